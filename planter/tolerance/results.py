"""What `planter tolerance` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class Toleranced(Record):
    """An input that varies: its distribution between two ends, and its standard deviation, in the unit of its name."""

    name: str
    distribution: str
    low: float
    high: float
    std: float


@dataclass(frozen=True)
class Band(Record):
    """An output by Monte Carlo, beside its value at the centre of the tolerances and its first-order band.

    `mean_error` is the standard error of the mean; `missing` machines had no turn; `first_order_std` comes from exact
    gradients, and is missing where the machine has none.
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
    """Sobol' indices of an output in an input, and half the width of their 95 % intervals by bootstrap."""

    first: float
    total: float
    first_error: float
    total_error: float


@dataclass(frozen=True)
class Scored(Record):
    """A design: its objective without tolerances; mean, standard deviation and mean plus k of these with them."""

    design: dict[str, float]
    nominal: float
    mean: float
    std: float
    robust: float


@dataclass(frozen=True)
class RobustFound(Record):
    """The design with the least mean plus `sigmas` standard deviations of the objective, of `machines` drawn once.

    `objective` is that sum, like all objectives here one over `samples` of a cycle; `own` is the machine's design,
    `best_nominal` the optimum without tolerances. `residual` is the largest slope that is left along the box, of the
    objective over the box's width.
    """

    design: dict[str, float]
    objective: float
    samples: int
    sigmas: float
    machines: int
    starts: int
    residual: float
    own: Scored
    best_nominal: Scored
    best_robust: Scored


@dataclass(frozen=True)
class ToleranceFound(Record):
    """`planter tolerance`: inputs, bands of outputs, Sobol' indices by output and input, the robust design.

    `rows` turns were drawn for the bands, `index_rows` for the indices; `sobol` is empty and `robust` missing where
    they were not asked for.
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


COMMANDS = {"tolerance": ToleranceFound}
