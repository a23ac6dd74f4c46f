"""The designer's summary, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.engine.summary import MotorTorque, Shock
from planter.records import Record


@dataclass(frozen=True)
class PeakForce(Record):
    """A force over a turn, its size or, of contacts that can only push, its signed value; one-sided where it jumps.

    Angles are those of the carrier, with the side's own half of the device as side 1.
    """

    name: str
    meaning: str
    max_N: float
    max_phi_deg: float
    min_N: float
    min_phi_deg: float


@dataclass(frozen=True)
class StressFound(Record):
    """Largest stress over a turn; `bending` by Lewis for both gears of the pair, null outside its formula's range."""

    contact_MPa: float
    contact_phi_deg: float
    bending_MPa: list[float | None]
    bending_phi_deg: list[float | None]


@dataclass(frozen=True)
class GearFound(Record):
    """A gear's pitch curve: least radius of curvature, least curvature (below zero: hollow), pitch radii.

    `teeth_min` is the least number of teeth of a circular gear that has such a curvature, where a module is given.
    """

    gear: str
    curvature_radius_min_mm: float
    curvature_min_per_mm: float
    pitch_radius_min_mm: float
    pitch_radius_max_mm: float
    teeth_min: float | None


@dataclass(frozen=True)
class StageFound(Record):
    """A gear stage; pressure angles over a turn and both flanks; contact ratio and stress where [gears] give them."""

    stage: int
    centre_distance_mm: float
    gears: list[GearFound]
    pressure_angle_min_deg: float
    pressure_angle_max_deg: float
    pressure_angle_max_phi_deg: float
    contact_ratio_min: float | None
    stress: StressFound | None


@dataclass(frozen=True)
class DesignersSummary(Record):
    """What a designer sizes motor, bearings, gears and cam by; `shocks` is empty where nothing jumps."""

    motor: MotorTorque
    holding_torque_max_Nm: float
    holding_torque_max_phi_deg: float
    forces: list[PeakForce]
    stages: list[StageFound]
    cam_pressure_angle_max_deg: float
    cam_pressure_angle_max_phi_deg: float
    shocks: list[Shock]
    notes: list[str]
