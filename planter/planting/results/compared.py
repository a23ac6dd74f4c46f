"""What `planter compare` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planter.planting.designer.results import DesignersSummary
from planter.planting.results.stated import Design, Requirement, Violation
from planter.records import Record


@dataclass(frozen=True)
class ComparedPair(Record):
    """A pair of gear families; only one that is settled has a rank, `lacks` says what the others do not have."""

    rank: int | None
    stage1: str
    stage2: str
    feasible: bool
    objective: float
    range_N: float
    variance_N2: float
    design: Design
    binding: list[str]
    requirements: list[Requirement]
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
    """The machine's own pair within its own bounds, no requirement kept, and what that makes of them."""

    objective: float
    range_N: float
    variance_N2: float
    requirements: list[Requirement]
    design: Design
    feasible: bool
    binding: list[str]


@dataclass(frozen=True)
class Proposal(Record):
    """What every pair breaks, and limits that the nearest pair keeps but for `violation`, in steps."""

    conflicting: list[str]
    limits: dict[str, float]
    stage1: str
    stage2: str
    violation: float


@dataclass(frozen=True)
class ComparisonFound(Record):
    """`planter compare`: pairs by rank; a proposal where none keeps the requirements.

    `samples` names the kind of all objectives, ranges and variances: "refined", true extremes and integrals.
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
