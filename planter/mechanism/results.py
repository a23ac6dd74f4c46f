"""Results of the commands for user-defined mechanisms, in the keys of their JSON."""

from __future__ import annotations

from dataclasses import dataclass, field

from planter.engine.drive import DriveResult
from planter.engine.proof.proof_results import GlobalBound
from planter.engine.sensitivity import Direction, SensitivityResult
from planter.engine.solvers.result import EvaluationCounts, OptimalityCertificate, WiderOptimum
from planter.engine.summary import CycleSummary
from planter.files.record import Record, WarningRecord
from planter.gears.results import Cam
from planter.measured.findings import MeasurementResult


@dataclass(frozen=True)
class QuantityStatistics(Record):
    """A quantity over a cycle: extremes with their angles [deg], mean, root mean square.

    Mean and root mean square are null if the quantity does not end the cycle as it began it. `axes`
    names the frame of a joint's component if it is not the world's.
    """

    unit: str
    min: float
    max: float
    mean: float | None
    rms: float | None
    min_deg: float
    max_deg: float
    axes: str | None = None


@dataclass(frozen=True)
class MechanismLawResult(Record):
    """A law of mechanics, the largest residual of the results, and the largest quantity in its
    unit, its scale.
    """

    law: str
    violation: float
    unit: str
    scale: float


@dataclass(frozen=True, kw_only=True)
class MechanismWarning(WarningRecord):
    """A warning, with the angle of the drive at which its cause begins if it has one."""

    name: str
    phi_deg: float | None = None
    message: str


@dataclass(frozen=True)
class LimitResult(Record):
    """A limit in its `unit` with its value, whether it is active, and whether it is satisfied.

    `value` is null if the condition of the limit never holds, which satisfies it, and for an
    average of a quantity that does not repeat, which violates it. `price` is the loss of the
    objective at its optimum per unit by which the limit is tightened, zero for one that is not
    active; null where nothing was searched for.
    """

    limit_on: str
    value: float | None
    limit: float
    active: bool
    met: bool
    unit: str
    price: float | None = None


@dataclass(frozen=True, kw_only=True)
class MechanismCycleResult(Record):
    """A cycle of a machine; works [J] by the names of their powers, null if the power does not
    repeat.

    `repeats_after_turns` is 1 if the cycle ends in the state in which it began, null if no number
    of cycles is known after which it does; `not_repeating` has the largest difference, a cycle
    later, of each quantity that does not repeat, in its unit, or null if the next cycle cannot be
    computed. Angles are compared modulo 360 deg. `holds` are the limits of the file, if it has any,
    and `met` says whether all of them are satisfied. `at` has all quantities at the requested
    angles, by key, with the angle of the drive. `designer` has true extremes; a warning explains if
    it is missing. `measurement` is what the sensor sees, if the file has [measurement].
    """

    machine: str
    samples: int
    quantities: dict[str, QuantityStatistics]
    work: dict[str, float | None]
    laws: list[MechanismLawResult]
    warnings: list[MechanismWarning]
    repeats_after_turns: int | None
    not_repeating: dict[str, float | None]
    holds: list[LimitResult] | None = None
    met: bool | None = None
    at: list[dict[str, float]] = field(default_factory=list)
    designer: CycleSummary | None = None
    measurement: MeasurementResult | None = None


@dataclass(frozen=True, kw_only=True)
class MachineValidation(Record):
    """`planter simulate --check` of a machine of the engine: its file, limits and cycle.

    `design` are the values with bounds; `holds` and `met` are those of a cycle; `own_numbers` are
    the paths of the numbers whose origin is this file.
    """

    machine: str
    valid: bool
    design: list[str]
    own_numbers: list[str]
    holds: list[LimitResult] | None = None
    met: bool | None = None
    warnings: list[MechanismWarning]


@dataclass(frozen=True)
class QuantityHistory(Record):
    """A quantity over a time; `axes` as in a cycle."""

    unit: str
    min: float
    max: float
    last: float
    axes: str | None = None


@dataclass(frozen=True)
class MechanismEnergy(Record):
    """Energy of weights, springs and motion, which loads and dampers change."""

    start_J: float
    least_J: float
    most_J: float


@dataclass(frozen=True)
class ChangedStart(Record):
    """A coordinate or a rate whose stated start the constraints do not allow."""

    quantity: str
    unit: str
    stated: float
    used: float


@dataclass(frozen=True)
class MotionEvent(Record):
    """An event of a motion: a contact closes or opens, a law takes another case.

    `rising` says whether the value that decides becomes positive there: the gap of a contact that
    opens.
    """

    event: str
    time_s: float
    rising: bool


@dataclass(frozen=True)
class MotionResult(Record):
    """A free motion; eigenvalues are pairs of real and imaginary part, at the equilibrium.

    `changed_start` has the entries of the start that the constraints change: what the statement
    sets holds, or what it names to hold, and the others follow; if set values contradict the
    constraints, the nearest state by inertia is used. `dependent_constraints` follow from one
    another, of which `redundant_constraints` are redundant; `undetermined_actions` are statically
    indeterminate reactions. `holds` are the limits of the file over their own times, if it has any,
    and `met` says whether all of them are satisfied; null with values over time.
    """

    machine: str
    until_s: float
    quantities: dict[str, QuantityHistory]
    energy: MechanismEnergy
    redundant_constraints: int
    dependent_constraints: list[str]
    undetermined_actions: list[str]
    changed_start: list[ChangedStart]
    events: list[MotionEvent]
    equilibrium: dict[str, float] | None = None
    eigenvalues_per_s: list[tuple[float, float]] | None = None
    holds: list[LimitResult] | None = None
    met: bool | None = None


@dataclass(frozen=True)
class EnsembleStatistic(Record):
    """Distribution of a value over all periods of all runs: mean, standard deviation, percentiles
    5, 50 and 95.

    `mean_error` is the standard error of the mean; it takes runs as independent, not their periods.
    It is null for one run.
    """

    mean: float
    mean_error: float | None
    std: float
    p5: float
    median: float
    p95: float


@dataclass(frozen=True)
class EnsembleQuantity(Record):
    """Range, variance in time and peak of a quantity; the variance is in the square of `unit`."""

    unit: str
    range: EnsembleStatistic
    variance: EnsembleStatistic
    peak: EnsembleStatistic


@dataclass(frozen=True)
class LyapunovExponent(Record):
    """Mean rate of growth of a small separation, and its standard error, null for one run."""

    value: float
    error: float | None


@dataclass(frozen=True)
class EnsembleSeparation(Record):
    """Separation of the runs from the motion of the stated start, as a share of the ranges of
    coordinates and rates.

    A run has parted when it exceeds `threshold`; `parted_after_s` is null if none has.
    `lyapunov_per_s`, the largest Lyapunov exponent, is null if the output times are too far apart:
    separations must stay small between them.
    """

    threshold: float
    parted_runs: int
    parted_after_s: EnsembleStatistic | None
    last_median: float
    lyapunov_per_s: LyapunovExponent | None


@dataclass(frozen=True)
class EnsembleResult(Record):
    """An ensemble of free motions whose starts differ by `perturbation`, as a share of the ranges
    of the states.

    Statistics are those of `periods` pieces of `period_s` of each run after `since_s`; `period_s`
    is null for one piece until the end.
    """

    machine: str
    until_s: float
    since_s: float
    period_s: float | None
    runs: int
    periods: int
    perturbation: float
    seed: int
    quantities: dict[str, EnsembleQuantity]
    separation: EnsembleSeparation
    changed_start: list[ChangedStart]


@dataclass(frozen=True)
class FrontDesign(Record):
    """A Pareto-optimal design for range and variance, in the units of results."""

    range: float
    variance: float
    design: dict[str, float]


@dataclass(frozen=True)
class MechanismOptimumResult(Record):
    """The least objective of a cycle within bounds and limits.

    The quantities in `least` depend on `effective_parameters` combinations of the design at the
    optimum; along the directions in `insensitive`, in parts of the bounds, they do not change, so
    that the design is not determined. `searches` says what was run and why, `wider` what bounds
    twice as wide would bring if some are active.
    """

    machine: str
    method: str
    least: str
    objective: float
    start_objective: float
    design: dict[str, float]
    start_design: dict[str, float]
    holds: list[LimitResult]
    met: bool
    certificate: OptimalityCertificate
    evaluations: EvaluationCounts
    samples: int | None
    seconds: float
    effective_parameters: int
    insensitive: list[Direction]
    searches: str = ""
    wider: WiderOptimum | None = None
    proof: GlobalBound | None = None
    front: list[FrontDesign] | None = None


COMMANDS = {
    "cam": Cam,
    "simulate motor": DriveResult,
    "sensitivity": SensitivityResult,
    "optimise least": MechanismOptimumResult,
}
"""Results by command."""
