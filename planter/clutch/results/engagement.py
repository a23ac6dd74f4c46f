"""What `planter clutch engage` returns, on either model of the engagement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planter.records import Record


@dataclass(frozen=True)
class EnergyBalance(Record):
    """Work put in, energy kept, work lost, and what is missing of their balance."""

    input_J: float
    stored_J: float
    lost_J: float
    imbalance_J: float


@dataclass(frozen=True)
class OneModeLoads(Record):
    """Load on the tooth in one mode of the shaft; `t_loss_s` is null where contact is never lost."""

    N0_N: float
    N_max_N: float
    t_max_s: float
    t_loss_s: float | None


@dataclass(frozen=True)
class BeamMode(Record):
    """The shaft's mode: coefficients of stiffness and mass, and what they make."""

    K_coefficient: float
    mass_coefficient: float
    shape: str
    frequency_rad_s: float
    mass_kg: float
    stiffness_N_m: float


@dataclass(frozen=True)
class LoadSensitivity(Record):
    """Largest load over that of the given inputs, with one of them times a factor."""

    input: str
    factor: float
    N_max_ratio: float


@dataclass(frozen=True)
class ModalEngagement(Record):
    """`planter clutch engage --mode modal`; null where contact is never lost."""

    clutch: str
    mode: Literal["modal"]
    N0_N: float
    N_max_N: float
    t_max_s: float
    t_loss_s: float | None
    modal: BeamMode
    printed: OneModeLoads
    energy: EnergyBalance
    sensitivity: list[LoadSensitivity]


@dataclass(frozen=True)
class ClutchLoads(Record):
    """A clutch engaged and cut off; null for what does not happen."""

    N_max_N: float
    N_single_max_N: float
    N_end_N: float
    impacts: int
    slips: int
    first_slip_s: float | None
    engaged_s: float | None
    cut_off_s: float | None
    cut_off_N_max_N: float
    energy: EnergyBalance


@dataclass(frozen=True)
class ContactLoadSensitivity(Record):
    """Largest loads of both clutches, with one input times a factor."""

    input: str
    factor: float
    N_max_ratio: float
    reuleaux_N_max_N: float
    dog_N_max_N: float


@dataclass(frozen=True)
class PhaseLoads(Record):
    """Largest loads of both clutches, with the input turned on at the moment of switching."""

    phase_deg: float
    N_max_ratio: float
    reuleaux_N_max_N: float
    dog_N_max_N: float


@dataclass(frozen=True)
class TeethInSleeve(Record):
    """Overlap of teeth and shaft with the body in the middle, and the root circle that lets teeth pass the corners."""

    coaxial_overlap_mm: float
    root_least_mm: float


@dataclass(frozen=True)
class ContactEngagement(Record):
    """`planter clutch engage --mode contact`: the clutch compared with a dog clutch."""

    clutch: str
    mode: Literal["contact"]
    reuleaux: ClutchLoads
    dog: ClutchLoads
    N_max_ratio: float
    energy: EnergyBalance
    sensitivity: list[ContactLoadSensitivity]
    phases: list[PhaseLoads]
    teeth: TeethInSleeve
    assumptions: list[str]
