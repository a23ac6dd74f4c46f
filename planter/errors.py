"""Errors that users see: each is one sentence with an exit code."""

from typing import Any, ClassVar, Self

from planter import safe_text


class PlanterError(Exception):
    """Failure which is reported to the user without a traceback."""

    exit_code: ClassVar[int] = 1
    partial: dict[str, Any] | None = None
    """What was computed before the failure, as `--json` prints it."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickling with all attributes and any constructor, because worker processes send
        their errors.
        """
        return _restore_error, (type(self), self.args, vars(self))

    @property
    def name(self) -> str:
        """Name of the error in results and JSON output."""
        return type(self).__name__

    @property
    def message(self) -> str:
        """Sentence on one line which states the fault and the remedy."""
        return safe_text.sanitise_line(str(self))

    def table(self) -> dict[str, Any]:
        """Return the object which `--json` prints: the error, and any partial result."""
        return {"error": {"name": self.name, "message": self.message}, "partial": self.partial}


def _restore_error(
    kind: type[PlanterError], args: tuple[Any, ...], attributes: dict[str, Any]
) -> PlanterError:
    error = kind.__new__(kind, *args)
    vars(error).update(attributes)
    return error


class InputError(PlanterError):
    """Invalid input: the message names the file, key, value and what is allowed."""

    exit_code: ClassVar[int] = 2

    @classmethod
    def for_value(cls, key: str, value: object, rule: str, source: str = "") -> Self:
        """Return the error of an invalid value, with the rule that it violates or what to do, and
        the file if any.

        >>> str(InputError.for_value("mass.sun_kg", -0.4, "it must be greater than 0", "my.toml"))
        'my.toml: mass.sun_kg = -0.4: it must be greater than 0'
        """
        text = value if isinstance(value, str) else safe_text.format_value(value)
        return cls(f"{f'{source}: ' if source else ''}{key} = {text}: {rule}")


class GeometryError(InputError):
    """Curve which cannot be built: the message names the curve, angle and violated bound."""


class ComputationError(PlanterError):
    """Failure of a computation with valid input."""


class NotFiniteError(ComputationError):
    """Output of a function which is NaN or infinite: name of the `output`, `row` and `lane` of the
    first such entry.
    """

    def __init__(self, function: str, output: str, row: int, lane: int) -> None:
        super().__init__(f"{function}: output {output}[{row}] is not finite in lane {lane}")
        self.output, self.row, self.lane = output, row, lane


class Interrupted(PlanterError):
    """Computation stopped by the user; `partial` is the result so far, if any."""

    exit_code: ClassVar[int] = 130
    name = "Interrupted"

    def __init__(self, partial: dict[str, Any] | None = None) -> None:
        super().__init__("interrupted; what was found so far is kept" if partial else "interrupted")
        self.partial = partial
