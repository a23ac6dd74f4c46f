"""What a machine's room brings so that its machines can be swept: an object `ROOM` in its module `swept`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from planter import rooms
from planter.errors import InputError
from planter.files import paths
from planter.files.document import Document
from planter.kernels import Array


class Subject(Protocol):
    """A machine whose turns are evaluated in rows."""

    def evaluated(self, points: Array, threads: int) -> Array:
        """Outputs (m, k) at points (m, n), in shown units: NaN in rows that have none."""


class Room(Protocol):
    """Machines of a kind. All values are in the units [that their keys end in]."""

    choices: Mapping[str, Sequence[str]]
    """Inputs that are no numbers, with what they may be, the usual first."""

    def takes(self, source: str) -> bool:
        """Whether a file, or a built-in name, is a machine of this kind."""

    def load(self, source: str, changes: Mapping[str, float]) -> Document:
        """The machine in a file, some of its numbers set."""

    def inputs(self, machine: Any) -> Mapping[str, str]:
        """What can be varied, by path, with its meaning."""

    def outputs(self, machine: Any) -> Mapping[str, str]:
        """What can be asked for, with its meaning."""

    def describe_measure(self, machine: Any, text: str, label: str) -> tuple[str, str]:
        """Return the name and the meaning of an output that a text in the language of measures asks for.

        Raises InputError, which begins with `label`, for what is none.
        """

    def default_outputs(self, machine: Any) -> Sequence[str]:
        """Outputs where none are asked for."""

    def hash_curves(self, machine: Any, outputs: Sequence[str]) -> Mapping[str, str]:
        """Return the hashes of further files that outputs need, by path."""

    def frozen(self, machine: Any) -> dict[str, Any]:
        """All that makes the machine again, fit for JSON: what `subject` takes in another process."""

    def subject(
        self, frozen: Mapping[str, Any], choices: Mapping[str, str],
        inputs: Mapping[str, tuple[float, float]], outputs: Sequence[str],
    ) -> Subject:  # fmt: skip
        """A machine whose `inputs`, by path, take values between two ends.

        Raises InputError where it cannot be made at these ends.
        """


class Held:
    """A machine with the room that it belongs to, by which it was found."""

    def __init__(self, source: str, changes: Mapping[str, float] | None = None) -> None:
        found = next((module for module in rooms.brought("swept") if module.ROOM.takes(source)), None)
        if found is None:
            raise InputError(f"{source}: there is no such machine that can be swept: it must be a machine's file, or "
                             "the name of a built-in one")  # fmt: skip
        self.module, self.room, self.source = found.__name__, found.ROOM, source
        self.machine = self.room.load(source, changes or {})

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        found: Mapping[str, str] = self.room.inputs(self.machine)
        return found

    @cached_property
    def outputs(self) -> Mapping[str, str]:
        found: Mapping[str, str] = self.room.outputs(self.machine)
        return found

    @property
    def choices(self) -> Mapping[str, Sequence[str]]:
        found: Mapping[str, Sequence[str]] = self.room.choices
        return found

    def path(self, name: str, of: str) -> str:
        """The full path of an input. Raises InputError, `of` naming who asks for it, for one that there is not."""
        return named(name, self.inputs, of, "inputs")

    def hash_curves(self, outputs: Sequence[str]) -> dict[str, Any]:
        """Return the hashes of files that outputs need, as a recipe has them: rows of other curves are other rows."""
        hashes = self.room.hash_curves(self.machine, outputs)
        return {"curves": dict(hashes)} if hashes else {}

    def asked(self, names: Sequence[str], of: str) -> list[str]:
        """Full names of outputs, the default ones for none. Raises InputError as `path`, or if there are none."""
        names = names or self.room.default_outputs(self.machine)
        if not names:
            raise InputError(f"{of} is missing: name at least one output; {_hint((), 'outputs')}")
        return [self.describe_output(name, of)[0] for name in names]

    def describe_output(self, name: str, label: str) -> tuple[str, str]:
        """Return an output's full name, and its meaning. Raises InputError as `path`."""
        if " " in name:
            described: tuple[str, str] = self.room.describe_measure(self.machine, name, label)
            return described
        full = named(name, self.outputs, f"{label}: {name}", "outputs")
        return full, self.outputs[full]


def named(name: str, known: Mapping[str, str], of: str, what: str) -> str:
    """The entry that a name means: itself, or its last part where that fits one only."""
    names = paths.Names(list(known))
    found = names.candidates(name)
    if len(found) == 1:
        return found[0]
    close = paths.close(name, known)
    hint = f"it fits several, name one of {', '.join(found)}" if found else _hint(close, what)
    raise InputError(f"{of} is not allowed: {hint}")


def _hint(close: Sequence[str], what: str) -> str:
    meant = f"did you mean {' or '.join(close)}? " if close else ""
    return f"{meant}`planter sweep --list MACHINE` lists all {what}"


def beside(source: str, folder: Path | None) -> str:
    """A machine's file as a plan names it: as seen from the plan's folder, or a built-in name."""
    if folder is not None and not Path(source).is_absolute() and (folder / source).is_file():
        return str(folder / source)
    return source
