"""What `planter cite` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


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


COMMANDS = {"cite": Citations | Citable}
