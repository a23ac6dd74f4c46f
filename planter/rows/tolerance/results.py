"""Results of `planter tolerance`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from planter.files.record import Record


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
    evaluated at `samples` angles of a cycle. `starts` local searches were made.
    """

    design: dict[str, float]
    objective: float
    mean: float
    std: float
    own_objective: float
    samples: int
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


COMMANDS = {"tolerance": ToleranceFound}
