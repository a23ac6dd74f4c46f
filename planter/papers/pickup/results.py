"""What the pick-up's command returns, key by key; t is the carrier angle from the farthest tip."""

from __future__ import annotations

from dataclasses import dataclass

from planter.engine.solvers.result import OptimalityCertificate
from planter.files.record import Record, WarningRecord

Pair = tuple[float, float]


@dataclass(frozen=True)
class Still(Record):
    """Range in which the arm is at rest, and the tip's distance from the sun's centre there."""

    start_deg: float
    end_deg: float
    tip_radius_mm: float


@dataclass(frozen=True)
class ExtremaResult(Record):
    """Least and largest value."""

    min: float
    max: float


@dataclass(frozen=True)
class Slope(ExtremaResult):
    """Slope of the arm's angle over the carrier's, over the whole turn."""

    mean: float


@dataclass(frozen=True)
class SunToothCount(Record):
    """Teeth of the sun: arc over pitch, the next whole number, and the module that makes it
    whole.
    """

    exact: float
    whole: int
    module_mm: float


@dataclass(frozen=True)
class LockingArcs(Record):
    """Radius of the locking arcs, pitch radii where the dwell begins and ends, sweep on the sun,
    reach of the horns.

    The paper prints no radius. With the smaller of the end radii, should they differ by more than
    an addendum, the intermediate gear has nothing in the arc on one side, and is free to turn one
    way; so it is the smaller one, or the least with which both sides hold. `horns_deg` are the
    angles at the sun over which that gear lies in the arc, on the side of the teeth before the
    dwell and of those after it.
    """

    radius_mm: float
    end_radii_mm: Pair
    sweep_deg: float
    horns_deg: Pair


@dataclass(frozen=True)
class Push(Record):
    """Carrier angle of the push, and the needle's rotation back from the pick."""

    t_deg: float
    swing_deg: float


@dataclass(frozen=True)
class Demand(Record):
    """A requirement: value in `unit`, what is wanted, by how much that holds, and its limits; t is
    null where it has no place, a limit where there is none.
    """

    name: str
    value: float
    unit: str
    wanted: str
    margin: float
    t_deg: float | None
    holds: bool
    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class PickupWarning(WarningRecord):
    """A warning, and the carrier angle at which its cause begins or is worst."""

    name: str
    t_deg: float | None
    message: str


@dataclass(frozen=True)
class PickupState(Record):
    """Motion and gears at a carrier angle; null in the dwell."""

    t_deg: float
    tip_mm: Pair
    L3_mm: float
    tip_speed_mm_s: float
    rho1_mm: float | None
    rho2_mm: float | None
    contact_ratio: float | None


@dataclass(frozen=True)
class Optimised(Record):
    """Displacement of the value points that satisfies the requirements, or violates them least."""

    holds: bool
    moved_mm: float
    iterations: int
    rounds: int
    certificate: OptimalityCertificate | None
    """That of the last round, None where nothing had to be moved."""
    requirements_before: list[Demand]
    value_points_before_mm: list[Pair]
    value_points_mm: list[Pair]


@dataclass(frozen=True)
class PickupFound(Record):
    """`planter design pickup`; null where there is no dwell, or no path back to the law."""

    machine: str
    driven_by: str
    L1_mm: float
    L2_mm: float
    L3_max_mm: float
    L3_min_mm: float
    phi5_far_deg: float
    phi5_near_deg: float
    beta1_deg: float
    a1_mm: float
    a2_mm: float
    helix_deg: float
    helical_contact_ratio: float
    dwell: Still | None
    slope: Slope
    sun_radius_mm: ExtremaResult
    sun_toothed_arc_mm: float
    phi1_monotone: bool
    round_trip_error_rad: float | None
    teeth: SunToothCount
    locking_arcs: LockingArcs | None
    push: Push
    requirements: list[Demand]
    warnings: list[PickupWarning]
    at: list[PickupState]
    optimised: Optimised | None = None


COMMANDS = {"design pickup": PickupFound}
