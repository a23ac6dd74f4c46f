"""What `planter cam` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class Most(Record):
    """A largest value over a turn, and the cam angle where it stands."""

    max: float
    at_deg: float


@dataclass(frozen=True)
class Roller(Record):
    """Least radius of curvature of the pitch curve towards the cam: null, with its place, where it is nowhere hollow.

    `margin` is 1 - radius of the roller / that radius; rollers must be below it.
    """

    radius_mm: float
    margin: float
    least_curvature_radius_mm: float | None
    at_deg: float | None


@dataclass(frozen=True)
class LiftOff(Record):
    """The speed at which the force between cam and roller first vanishes, and the mechanism's angle where it does."""

    speed_rpm: float
    own_speed_rpm: float
    angle_deg: float


@dataclass(frozen=True)
class Contour(Record):
    """The contour as drawn: its length, its arcs, and how far they stray from it at most."""

    length_mm: float
    arcs: int
    deviation_um: float


@dataclass(frozen=True)
class Cam(Record):
    """`planter cam`: a contour for a roller; lift-off null where the roller stays on, or no force of it was named."""

    machine: str
    kind: str
    roller: Roller
    pressure_angle_deg: Most
    lift_off: LiftOff | None
    contour: Contour
    files: list[str]
