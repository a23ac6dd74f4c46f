"""A machine with its drawings, and what every symbol, key and column of its geometry means and is drawn on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase

from planter import rooms
from planter.errors import InputError
from planter.explain import dictionary
from planter.explain.results import DrawnSheet, DrawnSymbol, ExplainedMachine, Meaning
from planter.view.sheet import Draughtsman, Labelled

GEOMETRIC = {"m", "mm", "rad", "deg"}
"""Units of lengths and angles."""
NOT_THERE = "this machine has no such part"
"""Why a name is on no sheet that machines of the room have, but this one."""
KINDS = ("symbol", "file key", "column")


@dataclass(frozen=True)
class Drawn:
    """A machine of a room, drawn, and what drew it."""

    room: str
    labels: Draughtsman
    labelled: Labelled

    def explained(self, files: list[str]) -> ExplainedMachine:
        """What the command returns; `files` are those that were written."""
        shown = [DrawnSheet(sheet.name, sheet.title, sorted(sheet.names)) for sheet in self.labelled.sheets]
        return ExplainedMachine(self.labelled.name, self.room, shown, self.symbols(), files)

    def symbols(self) -> list[DrawnSymbol]:
        """A row for each length, angle and coordinate."""
        return [self._symbol(one) for one in geometric(self.room)]

    def _symbol(self, one: Meaning) -> DrawnSymbol:
        sheet = next((sheet.name for sheet in self.labelled.sheets if one.name in sheet.names), None)
        key = _key(one, self.labelled.numbers, self.labels)
        column = one.name if one.kind == "column" else one.key
        return DrawnSymbol(
            one.name, one.unit, one.meaning, key, column if key is None else None, sheet,
            left_out(self.labels, one) or NOT_THERE if sheet is None else None,
        )  # fmt: skip


def draughtsmen() -> dict[str, Draughtsman]:
    """What draws machines, by room."""
    return {module.__name__.split(".")[-2]: module.LABELS for module in rooms.brought("labelled")}


def takes(source: str) -> bool:
    """Whether a room draws a source."""
    return any(labels.takes(source) for labels in draughtsmen().values())


def find_room(source: str) -> str:
    """Return the room that draws a source. Raises StopIteration if none does."""
    return next(room for room, labels in draughtsmen().items() if labels.takes(source))


def drawn(source: str, changes: Mapping[str, float]) -> Drawn:
    """The machine of a file or a built-in name.

    Raises InputError where no room draws it, and as its room does.
    """
    for room, labels in draughtsmen().items():
        if labels.takes(source):
            return Drawn(room, labels, labels.draw(source, changes))
    known = ", ".join(sorted(draughtsmen()))
    raise InputError(
        f"{source}: there is no such machine with a labelled drawing: it must be a file of one ({known}), or the name "
        f"of a built-in one"
    )


def geometric(room: str) -> list[Meaning]:
    """Lengths, angles and coordinates in a room's dictionary: its symbols, then keys and columns that are no symbol's.

    Each name once, as the first that has it says.
    """
    own = [one for one in dictionary.every() if one.machine == room and one.unit in GEOMETRIC]
    told = {_whole(one.key) for one in own if one.kind == "symbol"}
    found: dict[str, Meaning] = {}
    for kind in KINDS:
        for one in own:
            if one.kind == kind and (kind == "symbol" or not {_whole(one.key), one.name} & told):
                found.setdefault(one.name, one)
    return list(found.values())


def left_out(labels: Draughtsman, one: Meaning) -> str | None:
    """Why a name is on no sheet, None where nothing says so."""
    return next((why for why, patterns in labels.undrawn.items() if any(meant(one, p) for p in patterns)), None)


def meant(one: Meaning, pattern: str) -> bool:
    """Whether a pattern means a name, its source, or the table of its key."""
    marks = one.name, one.source, f"{(one.key or '').partition('.')[0]}."
    return any(fnmatchcase(mark, pattern) for mark in marks)


def _whole(key: str | None) -> str:
    """A path without the index of an item."""
    return (key or "").partition("[")[0]


def _key(one: Meaning, numbers: Mapping[str, float], labels: Draughtsman) -> str | None:
    """The file's key under which a symbol is given, None for one that follows."""
    if one.kind == "column":
        return None
    key = one.key or one.name
    asked = {pattern for patterns in labels.undrawn.values() for pattern in patterns}
    given = (path for path in numbers if f"{path.partition('.')[0]}." not in asked)
    own = next((path for path in given if f".{path}".endswith(f".{key}")), None)
    return key if own is None and ("." in key or one.kind == "file key") else own
