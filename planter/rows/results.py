"""Results of `planter sweep` and `planter tolerance`, key by key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

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


@dataclass(frozen=True)
class Toleranced(Record):
    """Input with a tolerance: its distribution between two ends and its standard deviation, in the
    unit of its name.
    """

    name: str
    distribution: str
    low: float
    high: float
    std: float


@dataclass(frozen=True)
class Band(Record):
    """Distribution of an output by Monte Carlo; `nominal` is its value at the centre of the
    tolerances.

    `mean_error` is the standard error of the mean, `missing` the number of machines without a
    cycle, and `first_order_std` the standard deviation from exact gradients, null if the machine
    has no gradients.
    """

    nominal: float
    mean: float
    std: float
    p5: float
    p95: float
    mean_error: float
    missing: int
    first_order_std: float | None = None


@dataclass(frozen=True)
class Share(Record):
    """Sobol' indices of an output in an input, and half the width of their 95 % intervals by
    bootstrap.
    """

    first: float
    total: float
    first_error: float
    total_error: float


@dataclass(frozen=True)
class Tightening(Record):
    """The standard deviation of an output with half an input's tolerance, and by how much that
    reduces it.
    """

    std: float
    reduction_percent: float


@dataclass(frozen=True)
class RobustFound(Record):
    """Design with the smallest mean plus `sigmas` standard deviations of the objective over
    `machines` random machines.

    `objective` is that sum, `own_objective` that of the design of the file; all objectives are
    evaluated at `samples` angles of a cycle, null of what moves freely, whose extremes are true.
    `starts` local searches were made.
    """

    design: dict[str, float]
    objective: float
    mean: float
    std: float
    own_objective: float
    samples: int | None
    sigmas: float
    machines: int
    starts: int


@dataclass(frozen=True)
class ToleranceFound(Record):
    """Result of `planter tolerance`: inputs, bands of outputs, Sobol' indices by output and input,
    the robust design.

    `rows`, `index_rows` and `tightened_rows` are the numbers of cycles of the bands, the indices
    and the halved tolerances. `sobol` and `tightened`, by output and input, are empty and `robust`
    null if they were not requested.
    """

    machine: str
    choices: dict[str, str]
    seed: int
    rows: int
    index_rows: int
    inputs: list[Toleranced]
    outputs: dict[str, Band]
    sobol: dict[str, dict[str, Share]]
    seconds: float
    hash: str
    robust: RobustFound | None = None
    tightened_rows: int = 0
    tightened: dict[str, dict[str, Tightening]] = field(default_factory=dict)


def rank_shares(shares: Mapping[str, Share]) -> list[tuple[str, Share]]:
    """Return the inputs in the order of their total index, largest first."""
    return sorted(shares.items(), key=lambda pair: -pair[1].total)


COMMANDS = {"sweep": SweepFound | Varied, "tolerance": ToleranceFound}
