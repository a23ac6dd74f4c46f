"""Results of the clutch's commands, key by key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from planter.engine.solvers.result import OptimalityCertificate
from planter.files.record import Record

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic_core import CoreSchema

Pair = tuple[float, float]


@dataclass(frozen=True)
class InequalityResult(Record):
    """An inequality; `margin` is in `unit`, positive where it holds, `share` the margin over what
    is bounded.
    """

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


@dataclass(frozen=True)
class ClutchGeometry(Record):
    """`design clutch geometry`: everything of a clutch's shape."""

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
    """`design clutch design`: sizes for a shaft, a space and a travel, and every inequality."""

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
class FastestSwitching(Record):
    """`design clutch optimise`: the least travel time that forces and space allow."""

    clutch: str
    travel_time_s: float
    start_travel_time_s: float
    start_violates: list[str]
    design: SwitchingDesign
    start_design: SwitchingDesign
    certificate: OptimalityCertificate
    assumes: list[str]
    seed: int


@dataclass(frozen=True)
class CornerPath(VertexPath):
    """The ellipse at a corner of any pair of polygons; `lead_deg` is the turn over which the corner
    is passed.
    """

    lead_deg: float


@dataclass(frozen=True)
class SlidPath(Oval):
    """The ellipse of a vertex while two others slide on sides, lengths in widths."""

    vertex: int


@dataclass(frozen=True)
class Sliding(Record):
    """Two vertices that slide on two sides at once, and the paths of the others."""

    sides_apart: int
    vertices_apart: int
    rotation_deg: float
    paths: list[SlidPath]


@dataclass(frozen=True)
class PolygonFit(Record):
    """`design clutch rotor`: how a polygon turns in another, lengths in widths; null where it has
    no meaning.
    """

    vertices: int
    sides: int
    exact: bool
    smallest_over_R: float
    mismatch_over_R: float | None
    fillet_limit_over_R: float | None
    ellipse: CornerPath | None
    slides: Sliding
    harmonics: list[Harmonic]


@dataclass(frozen=True)
class EnergyBalance(Record):
    """Work put in, energy kept, work lost, and what is missing of their balance."""

    input_J: float
    stored_J: float
    lost_J: float
    imbalance_J: float


@dataclass(frozen=True)
class OneModeLoads(Record):
    """Load on the tooth in one mode of the shaft; `t_loss_s` is null where contact is never
    lost.
    """

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
class ModalEngagement(OneModeLoads):
    """`design clutch engage --mode modal`; null where contact is never lost."""

    clutch: str
    mode: Literal["modal"]
    modal: BeamMode
    printed: OneModeLoads
    energy: EnergyBalance
    sensitivity: list[LoadSensitivity]


Outcome = Literal["impact", "jam", "held load", "no engagement"]
"""What the largest load of an engagement is: a blow that passes; a load that stays, of teeth that
overlap the shaft with the body in the middle (jam) or of others (held load); or nothing, as the
output does not follow the input.
"""


@dataclass(frozen=True)
class ClutchLoads(Record):
    """A clutch engaged and cut off; null for what does not happen.

    `outcome` says what the largest load is.

    `N_end_N` is the load that stays when the clutch has engaged.
    """

    outcome: Outcome
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
class LargestLoads(Record):
    """Largest loads of both clutches; no ratio where they are of two kinds."""

    N_max_ratio: float | None
    reuleaux_N_max_N: float
    reuleaux_outcome: Outcome
    dog_N_max_N: float
    dog_outcome: Outcome


@dataclass(frozen=True)
class ContactLoadSensitivity(LargestLoads):
    """Largest loads of both clutches, with one input times a factor."""

    input: str
    factor: float


@dataclass(frozen=True)
class PhaseLoads(LargestLoads):
    """Largest loads of both clutches, with the input turned on at the moment of switching."""

    phase_deg: float


@dataclass(frozen=True)
class TeethInSleeve(Record):
    """Overlap of teeth and shaft with the body in the middle, and the root circle that lets teeth
    pass the corners.
    """

    coaxial_overlap_mm: float
    root_least_mm: float


@dataclass(frozen=True)
class ContactEngagement(Record):
    """`design clutch engage --mode contact`: the clutch compared with a dog clutch.

    The ratio of the largest loads is null if they are of two kinds, or a clutch does not engage.
    """

    clutch: str
    mode: Literal["contact"]
    reuleaux: ClutchLoads
    dog: ClutchLoads
    N_max_ratio: float | None
    energy: EnergyBalance
    sensitivity: list[ContactLoadSensitivity]
    phases: list[PhaseLoads]
    teeth: TeethInSleeve
    assumptions: list[str]


Level = int | float | str


@dataclass(frozen=True)
class LevelMeans(Record):
    """Mean of the runs at each level of a factor, and the largest less the least of them."""

    k: list[float]
    R: float


@dataclass(frozen=True)
class Total(Record):
    """Sum of squares and degrees of freedom."""

    ss: float
    df: int


@dataclass(frozen=True)
class Effect(Total):
    """A factor against the error; null for a mean square without degrees of freedom, and for F and
    p without an error.
    """

    ms: float | None
    F: float | None
    p: float | None


@dataclass(frozen=True)
class ComparedClutches(Record):
    """The clutch on trial against another at a speed, by Welch's test."""

    speed_m_s: float
    measure: str
    reduction_percent: float | None
    p_value: float | None


@dataclass(frozen=True)
class PredictedRun(Record):
    """A combination of levels, and what is predicted of each response: its JSON has the means next
    to the levels.
    """

    levels: list[Level]
    means: dict[str, float]

    def table(self) -> dict[str, Any]:
        """Return the levels and the mean of each response by its name."""
        return {"levels": self.levels, **self.means}

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        schema = handler.resolve_ref_schema(handler(core))
        means = schema["properties"].pop("means")
        return schema | {
            "required": ["levels"],
            "additionalProperties": means["additionalProperties"],
        }


@dataclass(frozen=True)
class FieldTest(Record):
    """`design clutch field`: a field test evaluated; `best` has levels in the factors' order."""

    source: str
    runs: int
    goals: dict[str, str]
    range: dict[str, dict[str, LevelMeans]]
    anova: dict[str, dict[str, Effect | Total]]
    best: dict[str, list[Level]]
    prediction: list[PredictedRun]
    comparison: list[ComparedClutches]


@dataclass(frozen=True)
class FieldPlan(Record):
    """`design clutch plan`: a field test to be run; `text` is the CSV to fill in."""

    array: str
    columns: dict[str, list[str]]
    text: str


COMMANDS = {
    "design clutch geometry": ClutchGeometry,
    "design clutch design": Sizing,
    "design clutch optimise": FastestSwitching,
    "design clutch rotor": PolygonFit,
    "design clutch engage": ModalEngagement | ContactEngagement,
    "design clutch field": FieldTest,
    "design clutch plan": FieldPlan,
}
