"""Results of the commands that belong to no machine, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.engine.proof.proof_results import ProofCheck
from planter.files.record import Record


@dataclass(frozen=True)
class Cited(Record):
    """A work: its key, what it is behind, in words, and as an entry of BibTeX."""

    key: str
    behind: str
    text: str
    bibtex: str


@dataclass(frozen=True)
class Citations(Record):
    """`planter cite NAME`: the works behind a command, or one work."""

    name: str
    works: list[Cited]


@dataclass(frozen=True)
class Citable(Record):
    """`planter cite`: keys of the works, and of works by the command that rests on them."""

    works: list[str]
    commands: dict[str, list[str]]


@dataclass(frozen=True)
class Examples(Record):
    """`planter example`: names of the built-in files, and what each has, by name."""

    examples: list[str]
    descriptions: dict[str, str]


@dataclass(frozen=True)
class Example(Record):
    """`planter example NAME`: a built-in file."""

    name: str
    text: str


@dataclass(frozen=True)
class Derived(Record):
    """`planter derive FILE`: the folder that was written to, and the files there."""

    folder: str
    files: list[str]


@dataclass(frozen=True)
class Listed(Record):
    """`planter schema`: commands whose results have a schema."""

    commands: list[str]


@dataclass(frozen=True)
class Topics(Record):
    """`planter help`: what there is to read about."""

    topics: list[str]


@dataclass(frozen=True)
class Topic(Record):
    """`planter help TOPIC`: a page."""

    topic: str
    text: str


COMMANDS = {
    "example": Examples | Example,
    "derive": Derived,
    "schema": Listed,
    "help": Topics | Topic,
    "cite": Citations | Citable,
    "prove": ProofCheck,
}
