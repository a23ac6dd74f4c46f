"""What `planter export` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class WrittenFiles(Record):
    """`planter export c` and its like: the files that were written."""

    files: list[str]


@dataclass(frozen=True)
class MotionWritten(Record):
    """`planter export motion`: the files that were written, how many columns and rows, and how long
    they last.
    """

    files: list[str]
    format: str
    columns: int
    rows: int
    end_s: float


@dataclass(frozen=True)
class MissingLibrary(Record):
    """A platform that a unit has no library for, and why."""

    platform: str
    reason: str


@dataclass(frozen=True)
class UnitWritten(Record):
    """`planter export fmu`: the unit that was written, how many variables it has, its libraries.

    Where a platform has no library, the C sources inside can be compiled for it.
    """

    files: list[str]
    fmi: str
    token: str
    inputs: int
    parameters: int
    outputs: int
    platforms: list[str]
    left_out: list[MissingLibrary]


COMMANDS = {
    "export c": WrittenFiles,
    "export casadi": WrittenFiles,
    "export jax": WrittenFiles,
    "export rust": WrittenFiles,
    "export fmu": UnitWritten,
    "export motion": MotionWritten,
}
"""Results by command."""
