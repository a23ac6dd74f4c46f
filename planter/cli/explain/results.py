"""Result records of `planter explain`."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class DefiningEquation(Record):
    """A printed equation that defines a symbol, its verdict in the audit, and its claim."""

    paper: str
    equation: str
    verdict: str
    claims: str


@dataclass(frozen=True)
class Meaning(Record):
    """The meaning of a name in a machine: kind, unit, description, source, key and verdicts.

    `kind` is symbol, file key, result key or column; `allowed` are the bounds of a file's number; `key` is
    the name under which files and results show a symbol. Of one machine `kind` is value, quantity
    or check; `value` is in the unit of its key, and `origin` is its source. `components` are those
    of a vector, whose size the name means.
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
    symbols: list[Meaning]


@dataclass(frozen=True)
class ExplainedFunction(Record):
    """A function of a machine: its inputs, and the numbers of its results and operations."""

    name: str
    inputs: list[str]
    outputs: int
    operations: int | None


@dataclass(frozen=True)
class ExplainedMachine(Record):
    """`planter explain MACHINE`: its values, quantities, functions and drawings; `files` were
    written by `--out`.
    """

    machine: str
    kind: str
    title: str
    source: str
    assumptions: list[str]
    values: list[Meaning]
    quantities: list[Meaning]
    functions: list[ExplainedFunction]
    sheets: list[DrawnSheet]
    files: list[str]


COMMANDS = {"explain": Explained | KnownNames | ExplainedMachine}
