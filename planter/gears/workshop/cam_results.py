"""Result records of `planter cam`."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class Most(Record):
    """A largest value over a turn, and its cam angle."""

    max: float
    at_deg: float


@dataclass(frozen=True)
class Roller(Record):
    """Smallest concave radius of curvature of the pitch curve and its angle, both null if the curve
    is convex.

    `margin` is 1 - radius of the roller / that radius; rollers must be below it.
    """

    radius_mm: float
    margin: float
    least_curvature_radius_mm: float | None
    at_deg: float | None


@dataclass(frozen=True)
class LiftOff(Record):
    """The lowest speed at which the force between cam and roller vanishes, and the angle of the
    mechanism there.
    """

    speed_rpm: float
    own_speed_rpm: float
    angle_deg: float


@dataclass(frozen=True)
class Contour(Record):
    """The contour as drawn: its length, its arcs, and their largest deviation from it."""

    length_mm: float
    arcs: int
    deviation_um: float


@dataclass(frozen=True)
class Cam(Record):
    """`planter cam`: a contour for a roller; lift-off is null if the roller stays on or no force
    was given.
    """

    machine: str
    kind: str
    roller: Roller
    pressure_angle_deg: Most
    lift_off: LiftOff | None
    contour: Contour
    files: list[str]
