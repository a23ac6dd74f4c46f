"""What `planter sweep` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class Extent(Record):
    """An output over all rows, in its own unit: `min_at`, `max_at` are the inputs of the rows where the ends stand.

    Everything is null where no row has a result; `missing` counts the rows that have none.
    """

    min: float | None
    max: float | None
    mean: float | None
    missing: int
    min_at: dict[str, float | str] | None
    max_at: dict[str, float | str] | None


@dataclass(frozen=True)
class SweepFound(Record):
    """`planter sweep`: rows and columns of the table, a hash of its numbers, what each output reaches.

    `resumed` chunks were there before; `workers` were started, none for a small sweep.
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
    envelope: dict[str, Extent]


@dataclass(frozen=True)
class Varied(Record):
    """`planter sweep --list`: what of a machine can be varied and asked for, with its meaning."""

    machine: str
    choices: dict[str, list[str]]
    inputs: dict[str, str]
    outputs: dict[str, str]


COMMANDS = {"sweep": SweepFound | Varied}
