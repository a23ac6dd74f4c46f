"""Result records of `planter explain`."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class DefiningEquation(Record):
    """A printed equation that defines a symbol, its verdict in the audit, and its claim."""

    paper: str
    equation: str
    verdict: str
    claims: str


@dataclass(frozen=True)
class Meaning(Record):
    """The meaning of a name in a machine: kind, unit, description, source, key, figures and
    verdicts.

    `kind` is symbol, file key, result key or column; `allowed` are the bounds of a file's number;
    `key` is the name under which files and results show a symbol. In a mechanism `kind` is value,
    quantity or check; `value` is in the unit of its key, and `origin` is its source. `components`
    are those of a vector, whose size the name means.
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
    components: list[str] | None = None


@dataclass(frozen=True)
class Explained(Record):
    """`planter explain NAME`: every meaning of a name."""

    name: str
    meanings: list[Meaning]


@dataclass(frozen=True)
class KnownNames(Record):
    """`planter explain`: all names by machine."""

    names: dict[str, list[str]]


@dataclass(frozen=True)
class DrawnSheet(Record):
    """A drawing of a machine: its name, its title, and the symbols on it."""

    name: str
    title: str
    symbols: list[str]


@dataclass(frozen=True)
class DrawnSymbol(Record):
    """A length, angle or coordinate of a machine, and its drawing.

    `key` is the key of its value in the machine's file, `column` its name in CSV files, `sheet` the
    first drawing with it; `left_out` is the reason for its absence from all drawings.
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
    """`planter explain MACHINE`: its drawings and every symbol of its geometry; `files` were
    written by `--out`.
    """

    machine: str
    kind: str
    sheets: list[DrawnSheet]
    symbols: list[DrawnSymbol]
    files: list[str]


@dataclass(frozen=True)
class ExplainedFunction(Record):
    """A function of a mechanism: its inputs, and the numbers of its results and operations."""

    name: str
    inputs: list[str]
    outputs: int
    operations: int | None


@dataclass(frozen=True)
class ExplainedMechanism(Record):
    """`planter explain FILE` of a mechanism: its values, quantities and functions; `files` were
    written by `--out`.
    """

    machine: str
    title: str
    source: str
    assumptions: list[str]
    values: list[Meaning]
    quantities: list[Meaning]
    functions: list[ExplainedFunction]
    files: list[str]


COMMANDS = {"explain": Explained | KnownNames | ExplainedMachine | ExplainedMechanism}
