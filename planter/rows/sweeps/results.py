"""What `planter sweep` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class SweepExtent(Record):
    """Range of an output over all rows, in its unit: `min_at`, `max_at` are the inputs of the rows
    with the extremes.

    All values are null if no row has a result; `missing` is the number of rows without a result.
    """

    min: float | None
    max: float | None
    mean: float | None
    missing: int
    min_at: dict[str, float | str] | None
    max_at: dict[str, float | str] | None


@dataclass(frozen=True)
class SweepFound(Record):
    """Result of `planter sweep`: rows and columns of the table, a hash of its numbers, the range of
    each output.

    `resumed` is the number of chunks reused from an earlier run, `workers` of processes started (0
    for a small sweep).
    """

    name: str
    machine: list[str]
    scheme: str
    seed: int
    rows: int
    columns: list[str]
    hash: str
    resumed: int
    seconds: float
    workers: int
    envelope: dict[str, SweepExtent]


@dataclass(frozen=True)
class Varied(Record):
    """Result of `planter sweep --list`: inputs and outputs of a machine, with their meanings."""

    machine: str
    choices: dict[str, list[str]]
    inputs: dict[str, str]
    outputs: dict[str, str]


COMMANDS = {"sweep": SweepFound | Varied}
