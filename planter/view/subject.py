"""What a machine's room brings so that its machines can be shown, and changed by hand: `KIND` in its module `show`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from planter import rooms
from planter.errors import InputError, PlanterError
from planter.files import units
from planter.files.document import Document
from planter.files.text import is_file, parse_toml, read_text
from planter.files.written import lines
from planter.version import __version__
from planter.view.exports import Export
from planter.view.scene import Scene

Values = Mapping[str, float]
"""Numbers by path, in the units [that their keys end in]."""
STEPS = 512
"""Steps from a number to an end beyond which the file does not allow it."""
REACH = 0.5
"""A number without bounds can be moved by this share of its value, to either side."""


@dataclass(frozen=True)
class Control:
    """A number that a hand can change, by its path, and how far."""

    path: str
    meaning: str
    unit: str
    value: float
    lower: float
    upper: float

    @property
    def group(self) -> str:
        """What it stands with."""
        return self.path.partition(".")[0]

    def told(self) -> dict[str, Any]:
        """As a page takes it."""
        return {**asdict(self), "group": self.group}


@dataclass(frozen=True)
class Reading:
    """A number that follows."""

    name: str
    unit: str
    value: float | None


@dataclass(frozen=True)
class Check:
    """A requirement with its margin, and whether it is met; `value` is None where only the margin is known."""

    name: str
    unit: str
    value: float | None
    margin: float
    met: bool


@dataclass(frozen=True)
class Table:
    """Rows under heads; the first cell of a row names it."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str | float | None]]


class Shown(Protocol):
    """A machine with numbers that a hand changes; all calls raise PlanterError where those make no machine."""

    name: str
    models: Sequence[str]
    controls: Sequence[Control]
    handles: Sequence[tuple[str, str]]
    """Points of the drawing that a hand can draw about: paths of the numbers [mm] that are their x and y."""

    exports: Sequence[Export]
    """What commands write of it."""

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """How it moves; the first scene is the machine's."""

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """What a person looks at while changing it."""

    def checks(self, values: Values, model: str) -> Sequence[Check]:
        """Its requirements, none where it has none; this may take longer."""

    def details(self, values: Values, model: str) -> Sequence[Table]:
        """What it is sized by, none where its room has no more to say; this may take a second."""

    def text(self, values: Values) -> str:
        """The machine's file with these numbers."""


@dataclass(frozen=True)
class Sought:
    """What a search has found: numbers by path, and a sentence about it."""

    values: Values
    sentence: str


@runtime_checkable
class Searching(Protocol):
    """A machine that a command can search a better design for."""

    @property
    def search(self) -> Sequence[str]:
        """Words of the command, without the machine's file; none where this machine has none."""

    def sought(self, answer: Mapping[str, Any]) -> Sought:
        """What the command has found, from what it prints as JSON."""


@runtime_checkable
class Wishing(Protocol):
    """A machine whose tip can be wished a path."""

    @property
    def wishes(self) -> bool:
        """Whether it has no such points, and can be given some."""

    def wished(self, values: Values) -> str:
        """The machine's file with points on its own path, as handles that a hand can draw about."""


class Kind(Protocol):
    """Machines of a kind."""

    def takes(self, source: str) -> bool:
        """Whether a file, or a built-in name, is a machine of this kind."""

    def open(self, source: str, changes: Values) -> Shown:
        """The machine in it. Raises InputError as its room does."""


@runtime_checkable
class Drawing(Protocol):
    """A kind that knows its room's objects, too."""

    def drawn(self, thing: object) -> Scene | None:
        """How an object moves; None where it is none of this kind."""


def drawn(thing: object) -> Scene:
    """How an object of some room moves. Raises InputError where no room knows it."""
    for module in rooms.brought("show"):
        scene = module.KIND.drawn(thing) if isinstance(module.KIND, Drawing) else None
        if scene is not None:
            return scene
    raise InputError(f"there is nothing to show of a {type(thing).__name__}")


def opened(source: str, changes: Values | None = None) -> Shown:
    """The machine of a file or a built-in name, of whatever room.

    Raises InputError where no room takes it: with the place of the error for a file that is not valid TOML.
    """
    for module in rooms.brought("show"):
        kind: Kind = module.KIND
        if kind.takes(source):
            return kind.open(source, changes or {})
    if is_file(Path(source)):
        parse_toml(read_text(source), source)
        raise InputError(
            f"{source}: this is no machine's file: its tables are those of no kind of machine that is known"
        )
    raise InputError(f"{source}: there is no such machine: it must be a machine's file, or the name of a built-in one")


def first_scene(machine: Shown, model: str | None, option: str) -> tuple[Scene, str]:
    """A machine as it is, in one of its models, and which that is: the first unless one is named.

    Raises InputError, naming the `option`, for a model that it has not.
    """
    chosen = machine.models[0] if model is None else model
    if chosen not in machine.models:
        raise InputError(f"{option} is not allowed: it must be one of {', '.join(machine.models)}")
    return machine.scenes({one.path: one.value for one in machine.controls}, chosen)[0].whole(), chosen


def controls(
    document: Document, paths: Iterable[str], meanings: Mapping[str, str], bounds: Mapping[str, tuple[float, float]]
) -> list[Control]:
    """Return controls for numbers of a file, within bounds by path if there are any, as far as the file allows.

    A number for which the file allows no other value has none.
    """
    numbers, found = document.numbers(), []
    for path in paths:
        value = float(numbers[path])
        ends = (_allowed_end(document, path, value, end) for end in bounds.get(path) or _about(value))
        lower, upper = min(value, next(ends)), max(value, next(ends))
        if lower < upper:
            found.append(Control(path, meanings.get(path, ""), units.unit(path), value, lower, upper))
    return found


def _allowed_end(document: Document, path: str, value: float, end: float) -> float:
    return farthest(value, end, lambda number: document.with_numbers({path: number}))


def farthest(value: float, end: float, attempt: Callable[[float], object]) -> float:
    """Return the farthest of `STEPS` numbers from a value towards an end at which an attempt succeeds, by bisection.

    An attempt that raises PlanterError has not succeeded; at the value itself it does.
    """
    allowed, refused, step = 0, STEPS + 1, STEPS
    while refused - allowed > 1:
        try:
            attempt(end if step == STEPS else value + (end - value) * step / STEPS)
            allowed = step
        except PlanterError:
            refused = step
        step = (allowed + refused) // 2
    return end if allowed == STEPS else value + (end - value) * allowed / STEPS


def _about(value: float) -> tuple[float, float]:
    reach = REACH * abs(value) or 1.0
    return value - reach, value + reach


def singles(table: Mapping[str, Any]) -> list[Reading]:
    """The single numbers of a result as readings."""
    return [
        Reading(key, units.unit(key), float(value))
        for key, value in table.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    ]


def changed(document: Any, values: Values) -> Any:
    """A file with other numbers, if they are others."""
    own = document.numbers()
    others = {path: value for path, value in values.items() if own[path] != value}
    return document.with_numbers(others) if others else document


HAND = "assumed; set by hand"
"""Origin of a number that a hand moved: the file's own word for it no longer holds."""


def written(own: Document, moved: Document) -> str:
    """The file of a machine whose numbers were moved by hand, what they were beside them."""
    before, table = own.numbers(), moved.table()
    was = {path: before[path] for path, value in moved.numbers().items() if path in before and before[path] != value}
    table["origin"] = {**moved.origins, **dict.fromkeys(was, HAND)}
    notes = {path: f"was {value!r} {units.unit(path)}".rstrip() for path, value in was.items()}
    head = f"# The machine {json.dumps(own.name)} with numbers set by hand, by planter {__version__}."
    order = dict(sorted(table.items(), key=lambda pair: isinstance(pair[1], dict | list)))
    return "\n".join([head, "", *lines(order, notes)]) + "\n"
