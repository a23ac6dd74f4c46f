"""Results of the planting device's commands, key by key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planter.engine.proof.proof_results import GlobalBound
from planter.engine.solvers.result import EvaluationCounts, OptimalityCertificate, WiderOptimum
from planter.files.record import Record
from planter.kernels import Array
from planter.measured.findings import (
    ExplanationFound,
    MeasuredFound,
    MeasuredPreview,
    PathFound,
)
from planter.mechanism.results import (
    EnsembleResult,
    MachineValidation,
    MechanismCycleResult,
    MotionResult,
)
from planter.papers.planting.design_results import DesignersSummary, ToothCountResult

Design = dict[str, float]
"""Values by the names of a machine's own design vector, each in the unit that its name ends in."""
Direction = list[dict[str, float]]
"""Weights of design parameters, in parts of their box widths."""


@dataclass(frozen=True)
class RequirementResult(Record):
    """A requirement at a design: limits and angle may be null; `of` says which gear or pair is
    meant.
    """

    name: str
    value: float
    unit: str
    lower: float | None
    upper: float | None
    margin: float
    phi_deg: float | None
    wanted_margin: float
    verdict: str
    meaning: str
    of: str | None
    origin: str


@dataclass(frozen=True)
class Violation(Record):
    """A requirement that must be relaxed: by `amount` in `unit`, its limit of `key` to
    `relaxed`.
    """

    name: str
    amount: float
    unit: str
    phi_deg: float | None
    value: float
    key: str
    limit: float
    relaxed: float

    def __str__(self) -> str:
        place = f" at phi = {self.phi_deg:.6g} deg" if self.phi_deg is not None else ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return (
            f"{self.name} = {self.value:.6g}{unit}{place} misses {self.key} with its margin by "
            f"{self.amount:.6g}{unit}"
        )


@dataclass(frozen=True)
class Statistics(Record):
    """Samples of a force: extremes, range, mean and population variance."""

    max_N: float
    min_N: float
    range_N: float
    mean_N: float
    variance_N2: float

    @classmethod
    def of_samples(cls, force: Array) -> Statistics:
        """Return the statistics of samples (n,) of a force [N]."""
        high, low = float(force.max()), float(force.min())
        return cls(high, low, high - low, float(force.mean()), float(force.var()))


@dataclass(frozen=True)
class CentreDistances(Record):
    """Centre distances of both stages."""

    a1: float
    a2: float


@dataclass(frozen=True)
class TrueExtremes(Record):
    """True extremes and integrals of the support force, and the objective (31) of these."""

    max_N: float
    min_N: float
    range_N: float
    mean_N: float
    variance_N2: float
    objective: float


@dataclass(frozen=True, kw_only=True)
class Lifted(Record):
    """Effect of relaxing one assumption of the exact model over a cycle.

    `support_N` and `joints_N` are the largest changes of the support force and of the sizes of the
    joint forces.
    """

    assumption: str
    support_N: float
    joints_N: dict[str, float]
    as_modelled_N: dict[str, float]
    largest_N: dict[str, float]
    motor_work_J: float
    friction_work_J: float


@dataclass(frozen=True, kw_only=True)
class PlantingCycleResult(MechanismCycleResult):
    """A cycle of a planting device; `requirements` if its file has any.

    `objective` and `support_force` are those of the samples, but for the mean force, which is an
    integral; `refined` those of true extremes and integrals. `work` is that of the motor, and what
    is lost to friction at both cams. `lifted` has the effects of relaxed assumptions.
    """

    model: str
    design: Design
    weight_N: float
    centre_distance_mm: CentreDistances
    support_force: Statistics
    objective: float
    refined: TrueExtremes
    designer: DesignersSummary | None = None
    requirements: list[RequirementResult] | None = None
    lifted: list[Lifted] | None = None


@dataclass(frozen=True, kw_only=True)
class PlantingValidation(MachineValidation):
    """`planter simulate --check` of a planting device, with the requirements of its file, if any."""

    requirements: list[RequirementResult] | None = None


@dataclass(frozen=True)
class SampledScore(Record):
    """A design scored over the machine file's number of samples."""

    samples: int
    objective: float
    range_N: float
    variance_N2: float


@dataclass(frozen=True)
class OptimumFound(Record):
    """An optimum, less its scores in both models; `samples` names the kind of all objectives,
    ranges and variances.

    `searches` says what was run and why, `wider` what bounds twice as wide would bring if some are
    active.
    """

    method: str
    samples: int | str
    objective: float
    design: Design
    range_N: float
    variance_N2: float
    start_objective: float
    evaluations: EvaluationCounts
    seconds: float
    certificate: OptimalityCertificate
    effective_parameters: int
    insensitive: list[Direction]
    requirements: list[RequirementResult] | None = None
    searches: str = ""
    wider: WiderOptimum | None = None


@dataclass(frozen=True)
class Scores(Record):
    """Objectives of the machine file's own design and of the optimum in one model."""

    start: float
    optimum: float


@dataclass(frozen=True)
class FrontPoint(Record):
    """A design of which neither range nor variance can be made smaller without the other
    growing.
    """

    range_N: float
    variance_N2: float
    design: Design


@dataclass(frozen=True, kw_only=True)
class OptimisationFound(OptimumFound):
    """`planter optimise`: an optimum with its certificate, both designs in both models, whole teeth
    where asked for.

    `samples` names the kind of objectives, ranges and variances, whole teeth and front included:
    "refined" for true extremes and integrals, else a number of angles. `sampled` and `refined` are
    the optimum's in either kind.
    """

    machine: str
    model: str
    sampled: SampledScore
    refined: TrueExtremes
    seed: int
    start_design: Design
    start_range_N: float
    start_variance_N2: float
    cross: dict[str, Scores]
    statement: str
    designer: DesignersSummary
    start_designer: DesignersSummary
    front: list[FrontPoint] | None = None
    proof: GlobalBound | None = None
    teeth: ToothCountResult | None = None


@dataclass(frozen=True)
class Fitted(Record):
    """An input that a calibration found, with the bounds that it searched."""

    name: str
    value: float
    unit: str
    lower: float
    upper: float


@dataclass(frozen=True)
class OtherModel(Record):
    """The support force of the other model with the same inputs."""

    range_N: float
    variance_N2: float
    mean_N: float


@dataclass(frozen=True)
class CalibrationTradeoff(Record):
    """One of the best misses: no figure comes nearer without another one being missed by more."""

    choices: dict[str, str]
    reached: dict[str, float]
    range_N: float
    miss_percent: dict[str, float]


@dataclass(frozen=True)
class CalibrationFound(Record):
    """`planter calibrate`: fitted inputs, and the figures that a model reaches with them.

    `rank` is the number of combinations of the inputs that the target determines; `least_push_N`
    the least force of the cam on the roller over the turn: below zero it would have to pull.
    `front` has the best misses if the target is not met.
    """

    machine: str
    model: str
    met: bool
    statement: str
    choices: dict[str, str]
    fitted: list[Fitted]
    target: dict[str, float]
    reached: dict[str, float]
    miss_percent: dict[str, float]
    least_push_N: float
    rank: int
    other_model: OtherModel
    front: list[CalibrationTradeoff] | None = None


@dataclass(frozen=True)
class ComparedPair(Record):
    """A pair of gear families; only one that is settled has a rank, `lacks` says what the others do
    not have.
    """

    rank: int | None
    stage1: str
    stage2: str
    feasible: bool
    objective: float
    range_N: float
    variance_N2: float
    design: Design
    binding: list[str]
    requirements: list[RequirementResult]
    objectives: list[float]
    kkt_residual: float | None
    violations: list[Violation]
    agreeing_starts: int
    lacks: list[str]
    settled: bool
    designer: DesignersSummary
    seconds: float


@dataclass(frozen=True)
class NarrowBox(Record):
    """The machine's own pair within its own bounds, no requirement kept, and what that makes of
    them.
    """

    objective: float
    range_N: float
    variance_N2: float
    requirements: list[RequirementResult]
    design: Design
    feasible: bool
    binding: list[str]


@dataclass(frozen=True)
class Proposal(Record):
    """Requirements that every pair violates; limits that the nearest pair satisfies but for
    `violation`, in steps.
    """

    conflicting: list[str]
    limits: dict[str, float]
    stage1: str
    stage2: str
    violation: float


@dataclass(frozen=True)
class ComparisonFound(Record):
    """`optimise --all-pairs`: pairs by rank; a proposal if no pair satisfies the requirements.

    `samples` names the kind of all objectives, ranges and variances: "refined", true extremes and
    integrals.
    """

    machine: str
    samples: Literal["refined"]
    starts: int
    seed: int
    settled: int
    devices: list[ComparedPair]
    narrow: NarrowBox
    proposal: Proposal | None
    seconds: float


COMMANDS = {
    "simulate": PlantingCycleResult | MechanismCycleResult | MotionResult | EnsembleResult,
    "simulate check": PlantingValidation | MachineValidation,
    "calibrate": CalibrationFound | MeasuredFound | MeasuredPreview | ExplanationFound | PathFound,
    "optimise all-pairs": ComparisonFound,
    "optimise": OptimisationFound,
}
