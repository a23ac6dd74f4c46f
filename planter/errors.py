"""What can go wrong, as the user sees it: every error is one sentence and knows its exit code."""

from typing import Any, ClassVar

from planter import legible


class PlanterError(Exception):
    """Any failure that the user is told about without a traceback."""

    exit_code: ClassVar[int] = 1

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle any error with its attributes, whatever its constructor takes: workers send their errors."""
        return _restore_error, (type(self), self.args, vars(self))

    @property
    def name(self) -> str:
        """The kind of error, as results and JSON output call it."""
        return type(self).__name__

    @property
    def message(self) -> str:
        """One sentence that says what is wrong and what would be right, on one line."""
        return legible.line(str(self))

    def table(self) -> dict[str, Any]:
        """What `--json` prints of it: the error, and what was reached before it."""
        return {"error": {"name": self.name, "message": self.message}, "partial": getattr(self, "partial", None)}


def _restore_error(kind: type[PlanterError], args: tuple[Any, ...], attributes: dict[str, Any]) -> PlanterError:
    error = kind.__new__(kind, *args)
    vars(error).update(attributes)
    return error


class InputError(PlanterError):
    """Bad input: the sentence names file, key, value given and what is allowed."""

    exit_code: ClassVar[int] = 2


class GeometryError(InputError):
    """A curve that cannot be built: the sentence names curve, angle and the bound that is broken."""


class ComputationError(PlanterError):
    """Valid input, but the computation did not succeed."""


class NotFiniteError(ComputationError):
    """A function gives what is no number, or beyond all numbers: the first row and lane of its output."""

    def __init__(self, function: str, output: str, row: int, lane: int) -> None:
        super().__init__(f"{function}: output {output}[{row}] is not finite in lane {lane}")
        self.row, self.lane = row, lane


class Interrupted(PlanterError):
    """The user stopped a computation; `partial` holds what was found so far."""

    exit_code: ClassVar[int] = 130

    def __init__(self, partial: dict[str, Any] | None = None) -> None:
        super().__init__("interrupted; what was found so far is kept" if partial else "interrupted")
        self.partial = partial
