"""What `planter explain` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class DefiningEquation(Record):
    """A printed equation that defines a symbol, its verdict in the audit, and what it claims to say."""

    paper: str
    equation: str
    verdict: str
    claims: str


@dataclass(frozen=True)
class Meaning(Record):
    """What a name means in a machine: its kind, unit, words, source, and where it stands, is drawn or is judged.

    `kind` is symbol, file key, result key or column; `allowed` are the bounds of a file's number; `key` is the name
    under which files and results show a symbol. Of a mechanism `kind` is value, quantity or check; `value` is a value
    in the unit of its key, and `origin` where that is from.
    """

    name: str
    kind: str
    machine: str
    unit: str
    meaning: str
    source: str
    key: str | None = None
    allowed: str | None = None
    equations: list[DefiningEquation] | None = None
    figures: list[str] | None = None
    value: float | None = None
    origin: str | None = None


@dataclass(frozen=True)
class Explained(Record):
    """`planter explain NAME`: every meaning of a name."""

    name: str
    meanings: list[Meaning]


@dataclass(frozen=True)
class KnownNames(Record):
    """`planter explain`: the names that are known, by machine."""

    names: dict[str, list[str]]


@dataclass(frozen=True)
class DrawnSheet(Record):
    """A drawing of a machine: its name, what it shows, and the symbols that stand on it."""

    name: str
    title: str
    symbols: list[str]


@dataclass(frozen=True)
class DrawnSymbol(Record):
    """A length, angle or coordinate of a machine, and where it is drawn.

    `key` is where its value stands in the machine's file, `column` its name in CSV files, `sheet` the first drawing
    that it stands on; `left_out` says why it is on none.
    """

    name: str
    unit: str
    meaning: str
    key: str | None = None
    column: str | None = None
    sheet: str | None = None
    left_out: str | None = None


@dataclass(frozen=True)
class ExplainedMachine(Record):
    """`planter explain MACHINE`: its drawings and every symbol of its geometry; `files` were written by `--out`."""

    machine: str
    kind: str
    sheets: list[DrawnSheet]
    symbols: list[DrawnSymbol]
    files: list[str]


@dataclass(frozen=True)
class ExplainedFunction(Record):
    """A function of a mechanism: its inputs, how many results it has, and of how many operations it is made."""

    name: str
    inputs: list[str]
    outputs: int
    operations: int | None


@dataclass(frozen=True)
class ExplainedMechanism(Record):
    """`planter explain FILE` of a mechanism: its values, quantities and functions; `files` were written by `--out`."""

    machine: str
    title: str
    source: str
    assumptions: list[str]
    values: list[Meaning]
    quantities: list[Meaning]
    functions: list[ExplainedFunction]
    files: list[str]


COMMANDS = {"explain": Explained | KnownNames | ExplainedMachine | ExplainedMechanism}
