"""What `planter simulate` and `validate` return of a planting device, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.planting.designer.results import DesignersSummary
from planter.planting.results.stated import Design, Requirement, Statistics, Warned
from planter.records import Record


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
    variance_N2: float
    objective: float


@dataclass(frozen=True)
class Work(Record):
    """Work over a turn, both sides: of the motor, and lost to friction."""

    input_J: float
    friction_J: float


@dataclass(frozen=True)
class At(Record):
    """Forces and motion at a carrier angle: of side 1 up to F_A1y_N, then totals."""

    phi_deg: float
    phi52_deg: float
    phi72_deg: float
    alpha_deg: float
    omega_rad_s: float
    omega_dot_rad_s2: float
    tip_x_mm: float
    tip_y_mm: float
    theta1_deg: float
    F_E_N: float
    F_Ex_N: float
    M_Q_Nm: float
    M_P_Nm: float
    F_B1x_N: float
    F_B1y_N: float
    F_A1x_N: float
    F_A1y_N: float
    F_Ox_N: float
    F_Oy_N: float
    F_O1x_N: float
    F_O1y_N: float
    support_N: float
    M_L_Nm: float
    M_1_Nm: float


@dataclass(frozen=True, kw_only=True)
class Lifted(Record):
    """What lifting one assumption of the exact model does over a turn.

    `support_N` and `joints_N` are the largest changes of the support force and of the sizes of the joint forces.
    """

    assumption: str
    support_N: float
    joints_N: dict[str, float]
    as_modelled_N: dict[str, float]
    largest_N: dict[str, float]
    motor_work_J: float
    friction_work_J: float


@dataclass(frozen=True)
class SimulationFound(Record):
    """`planter simulate`: a machine's own design over a turn; `requirements` where its file has any.

    `objective` and `support_force` are those of so many `samples`, `refined` those of true extremes and integrals.
    """

    machine: str
    model: str
    samples: int
    design: Design
    weight_N: float
    centre_distance_mm: CentreDistances
    support_force: Statistics
    objective: float
    warnings: list[Warned]
    refined: TrueExtremes
    work: Work
    at: list[At]
    designer: DesignersSummary
    requirements: list[Requirement] | None = None
    lifted: list[Lifted] | None = None


@dataclass(frozen=True, kw_only=True)
class Validation(Record):
    """`planter validate`: a machine file that can be used."""

    machine: str
    valid: bool
    design: list[str]
    requirements: list[Requirement] | None = None
    warnings: list[Warned]
