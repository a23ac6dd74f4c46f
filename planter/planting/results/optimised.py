"""What `planter optimise` returns of a planting device, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.optimise.proof.results import GlobalBound
from planter.planting.designer.results import DesignersSummary
from planter.planting.results.simulated import TrueExtremes
from planter.planting.results.stated import Design, Direction, Requirement
from planter.planting.whole.results import WholeTeeth
from planter.records import Record


@dataclass(frozen=True)
class Evaluations(Record):
    """How often the objective was evaluated: its value, its gradient, its Hessian."""

    objective: int
    gradient: int
    hessian: int


@dataclass(frozen=True)
class HeldBound(Record):
    """A bound that holds the optimum, and what the objective would lose per unit of the box if it gave way."""

    name: str
    side: str
    multiplier: float


@dataclass(frozen=True)
class HeldRequirement(Record):
    """A requirement that holds the optimum, and what the objective would lose per unit of it if it gave way."""

    name: str
    side: str
    multiplier: float
    unit: str


@dataclass(frozen=True)
class Proof(Record):
    """How sure an optimum is; requirements that hold it where the file has any."""

    kkt_residual: float
    active_bounds: list[HeldBound]
    starts: int
    agreeing_starts: int
    spread: float
    active_requirements: list[HeldRequirement] | None = None


@dataclass(frozen=True)
class SampledScore(Record):
    """A design scored over the machine file's number of samples."""

    samples: int
    objective: float
    range_N: float
    variance_N2: float


@dataclass(frozen=True)
class OptimumFound(Record):
    """An optimum, less its scores in both models; `samples` names the kind of all objectives, ranges and variances."""

    method: str
    samples: int | str
    objective: float
    design: Design
    range_N: float
    variance_N2: float
    start_objective: float
    evaluations: Evaluations
    seconds: float
    certificate: Proof
    effective_parameters: int
    insensitive: list[Direction]
    requirements: list[Requirement] | None = None


@dataclass(frozen=True)
class Scores(Record):
    """Objectives of the machine file's own design and of the optimum in one model."""

    start: float
    optimum: float


@dataclass(frozen=True)
class FrontPoint(Record):
    """A design of which neither range nor variance can be made smaller without the other growing."""

    range_N: float
    variance_N2: float
    design: Design


@dataclass(frozen=True, kw_only=True)
class OptimisationFound(Record):
    """`planter optimise`: an optimum with its certificate, both designs in both models, whole teeth where asked for.

    `samples` names the kind of objectives, ranges and variances, whole teeth and front included: "refined" for true
    extremes and integrals, else a number of angles. `sampled` and `refined` are the optimum's in either kind.
    """

    machine: str
    model: str
    method: str
    samples: int | str
    objective: float
    design: Design
    range_N: float
    variance_N2: float
    start_objective: float
    evaluations: Evaluations
    seconds: float
    certificate: Proof
    effective_parameters: int
    insensitive: list[Direction]
    requirements: list[Requirement] | None = None
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
    teeth: WholeTeeth | None = None
