"""Results of the commands on the shape of a clutch: geometry, sizes, the fastest switching, rotors."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record

Pair = tuple[float, float]


@dataclass(frozen=True)
class InequalityResult(Record):
    """An inequality; `margin` is in `unit`, positive where it holds, `share` the margin over what is bounded."""

    condition: str
    source: str
    margin: float
    unit: str
    share: float
    holds: bool


@dataclass(frozen=True)
class Oval(Record):
    """An ellipse, lengths in widths of the polygon."""

    centre_over_R: Pair
    semi_axes_over_R: Pair
    axis_deg: float


@dataclass(frozen=True)
class VertexPath(Oval):
    """The ellipse at a corner, and the radius at which the path meets the side."""

    tangency_radius_over_R: float


@dataclass(frozen=True)
class Harmonic(Record):
    """A harmonic of the support function; `rotor` says whether a rotor may have it."""

    order: int
    amplitude_over_R: float
    rotor: bool


@dataclass(frozen=True)
class PolygonRotation(Record):
    """Rotation of the polygon in the hexagon, lengths in widths."""

    mismatch_over_R: float
    smallest_hexagon_over_R: float
    fillet_limit_over_R: float
    harmonics: list[Harmonic]


@dataclass(frozen=True)
class ToothResult(Record):
    """Least radii of tip and root, and the angle of the face there."""

    b1_min_mm: float
    b2_min_mm: float
    xi_deg: float


@dataclass(frozen=True)
class Travel(Record):
    """Least travel of the sleeve at an axial angle, as printed and derived."""

    axial_angle_deg: float
    printed_mm: float
    exact_mm: float


@dataclass(frozen=True)
class Crank(Record):
    """Linkage of an axial angle for the printed travel; null where the rod does not get there."""

    axial_angle_deg: float
    crank_rotation_deg: float | None
    rod_mm: float
    link_lift_deg: float | None
    teeth: float | None
    printed_teeth: float | None


@dataclass(frozen=True)
class AsPrinted(Record):
    """The shape by the paper's own formulas."""

    A1: float
    A2: float
    semi_axes_over_R: Pair
    tangency_radius_over_R: float
    mismatch_over_R: float
    fillet_limit_over_R: float
    tooth: ToothResult
    conditions: list[InequalityResult]


@dataclass(frozen=True)
class ClutchGeometry(Record):
    """`planter clutch geometry`: everything of a clutch's shape."""

    clutch: str
    R_mm: float
    a_mm: float
    b_mm: float
    A1: float
    A2: float
    ellipse: VertexPath
    rotor: PolygonRotation
    tooth: ToothResult
    travel: list[Travel]
    linkage: list[Crank]
    conditions: list[InequalityResult]
    warnings: list[str]
    printed: AsPrinted


@dataclass(frozen=True)
class Sizes(Record):
    """Sizes of a clutch that fits."""

    fillet_mm: float
    tip_mm: float
    root_mm: float
    hexagon_side_mm: float
    width_mm: float
    outline_mm: float
    left_radius_mm: float
    right_radius_mm: float
    length_mm: float
    travel_mm: float
    face_angle_deg: float
    axial_angle_deg: float


@dataclass(frozen=True)
class Rods(Record):
    """Linkage of a sized clutch; `rod_angle_deg` is the rod's steepest."""

    crank_mm: float
    rod_mm: float
    distance_mm: float
    crank_rotation_deg: float
    rod_angle_deg: float


@dataclass(frozen=True)
class Sizing(Record):
    """`planter clutch design`: sizes for a shaft, a space and a travel, and every inequality."""

    clutch: str
    feasible: bool
    binds: list[str]
    violated: list[str]
    tightest: str
    sizes: Sizes
    linkage: Rods
    conditions: list[InequalityResult]
    assumes: list[str]


@dataclass(frozen=True)
class SwitchingDesign(Record):
    """Optimisation variables of a clutch."""

    axial_angle_deg: float
    ratio: float
    crank_mm: float
    rod_mm: float
    distance_mm: float


@dataclass(frozen=True)
class ClutchBindingLimit(Record):
    """A limit that holds an optimum, and the share of the file's own time that a share of the limit is worth."""

    name: str
    multiplier: float


@dataclass(frozen=True)
class SwitchingCertificate(Record):
    """Certificate of an optimum."""

    kkt_residual: float
    active: list[ClutchBindingLimit]
    agreeing_starts: int
    spread: float
    starts: int


@dataclass(frozen=True)
class FastestSwitching(Record):
    """`planter clutch optimise`: the least travel time that forces and space allow."""

    clutch: str
    travel_time_s: float
    start_travel_time_s: float
    start_violates: list[str]
    design: SwitchingDesign
    start_design: SwitchingDesign
    stations: dict[str, list[float]]
    least_margin_along: dict[str, float]
    bounds: dict[str, Pair]
    certificate: SwitchingCertificate
    assumes: list[str]
    seed: int


@dataclass(frozen=True)
class CornerPath(VertexPath):
    """The ellipse at a corner of any pair of polygons; `lead_deg` is the turn over which the corner is passed."""

    lead_deg: float


@dataclass(frozen=True)
class SlidPath(Record):
    """The ellipse of a vertex while two others slide on sides, lengths in widths."""

    vertex: int
    centre_over_R: Pair
    semi_axes_over_R: Pair
    axis_deg: float


@dataclass(frozen=True)
class Sliding(Record):
    """Two vertices that slide on two sides at once, and the paths of the others."""

    sides_apart: int
    vertices_apart: int
    rotation_deg: float
    paths: list[SlidPath]


@dataclass(frozen=True)
class PolygonFit(Record):
    """`planter clutch rotor`: how a polygon turns in another, lengths in widths; null where it has no meaning."""

    vertices: int
    sides: int
    exact: bool
    smallest_over_R: float
    mismatch_over_R: float | None
    fillet_limit_over_R: float | None
    ellipse: CornerPath | None
    slides: Sliding
    harmonics: list[Harmonic]
