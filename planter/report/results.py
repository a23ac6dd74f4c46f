"""Result of `planter animate`."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class Animated(Record):
    """`planter animate`: the file that was written, and what moves in it."""

    file: str
    machine: str
    model: str


COMMANDS = {"animate": Animated}
