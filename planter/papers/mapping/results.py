"""What the commands of kinematic mapping return, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record, WarningRecord

Pair = tuple[float, float]
Four = tuple[float, float, float, float]


@dataclass(frozen=True)
class DyadFound(Record):
    """A dyad, how far it misses the poses, and whether its fixed hinge is outside the polyline of
    their tips.
    """

    moving_point_mm: Pair
    centre_mm: Pair
    radius_mm: float
    multiplicity: int
    largest_miss_mm: float
    outside: bool


@dataclass(frozen=True)
class StraightFound(Record):
    """A dyad with a hinge at infinity: its point and its line normal . place = offset."""

    kind: str
    point_mm: Pair
    normal: Pair
    offset_mm: float
    multiplicity: int


@dataclass(frozen=True)
class Family(Record):
    """Members of a family of dyads with free parameters."""

    parameters: int
    dyads: list[DyadFound]
    straight: list[StraightFound]


@dataclass(frozen=True)
class AtPose(Record):
    """Position of a linkage at a pose; `assembly` is +1 or -1, circuits count from 1."""

    pose: int
    crank_angle_deg: float
    assembly: int
    circuit: int
    hinges_mm: tuple[Pair, Pair]
    position_error_mm: float
    angle_error_deg: float
    transmission_deg: float


@dataclass(frozen=True)
class DefectsFound(Record):
    """Defects of a linkage."""

    order: bool
    branch: bool
    circuit: bool


@dataclass(frozen=True)
class Back(Record):
    """Between which poses the arm must turn back, and how far."""

    from_pose: int
    to_pose: int
    deg: float


@dataclass(frozen=True)
class OneSense(Record):
    """Whether one closed turn can pass all poses with the arm turning in one sense against the
    carrier.
    """

    possible: bool
    reversals: list[Back]


@dataclass(frozen=True)
class LinkageFound(Record):
    """A pair of dyads as a four-bar linkage; the shorter drives."""

    dyads: tuple[int, int]
    frame_mm: float
    crank_mm: float
    coupler_mm: float
    rocker_mm: float
    type: str
    grashof: bool
    circuits: int
    transmission_min_deg: float
    arm_length_mm: float
    poses: list[AtPose]
    defects: DefectsFound
    crank_sense: int
    monotone: OneSense


@dataclass(frozen=True)
class Missed(Record):
    """Miss of a pose where a curve meets it."""

    pose: int
    carrier_deg: float
    position_error_mm: float
    hinge_error_mm: float
    angle_error_deg: float


@dataclass(frozen=True)
class CurveFound(Record):
    """An angle curve: extremes of its slope with their carrier angles, and its misses at poses."""

    monotone: bool
    slope_min: float
    slope_min_at_deg: float
    slope_max: float
    slope_max_at_deg: float
    poses: list[Missed]
    rms_mm: float


@dataclass(frozen=True)
class NearestCurve(CurveFound):
    """The monotone angle curve closest to the poses; `order` is that of the poses along it."""

    least_slope: float
    largest_slope: float
    order: list[int]


@dataclass(frozen=True)
class CurveOfPaths(CurveFound):
    """The angle curve through points of a linkage's paths."""

    points: int


@dataclass(frozen=True)
class SynthesisFound(Record):
    """`design synthesise`: dyads, linkages and angle curves; null where there is no carrier, or no
    such curve.
    """

    poses: int
    dyads: list[DyadFound]
    complex_pairs: int
    singular_values: list[float]
    scaled_singular_values: list[float]
    straight: list[StraightFound]
    family: Family | None
    linkages: list[LinkageFound]
    carrier_dyad: int | None
    monotone: OneSense | None
    nearest: NearestCurve | None
    curve: CurveOfPaths | None
    warnings: list[str]


@dataclass(frozen=True)
class TrainWarning(WarningRecord):
    """A warning about gears; `carrier_deg` is null if it concerns the whole cycle."""

    name: str
    carrier_deg: float | None
    message: str


@dataclass(frozen=True)
class TrainFound(Record):
    """`design train`: a gear train; lists of four are of driver 1, follower 1, driver 2, follower
    2.
    """

    ratio_min: float
    ratio_max: float
    module_max_mm: float
    x_s: float
    x_s_under_root: float
    slope_min: float
    slope_max: float
    slope_min_at_deg: float
    slope_max_at_deg: float
    monotone: bool
    closure_error_rad: Pair
    carrier_bend_deg: float | None
    convex: list[bool]
    concave_deg: list[list[Pair]]
    radius_min_mm: Four
    radius_max_mm: Four
    curvature_radius_min_mm: Four
    poses: list[Missed]
    warnings: list[TrainWarning]


COMMANDS = {"design synthesise": SynthesisFound, "design train": TrainFound}
