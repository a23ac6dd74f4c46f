"""What `planter gears` and `planter cam` return, key by key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planter.files import units
from planter.files.record import Record

if TYPE_CHECKING:
    from planter.kernels import Array


@dataclass(frozen=True)
class Undercut(Record):
    """A flank that is undercut: its tooth, +1 where it ends the tooth anticlockwise and -1 where it
    begins it.
    """

    tooth: int
    flank: int
    margin: float


@dataclass(frozen=True)
class GearCut(Record):
    """A toothed gear: its least margin against undercut and where it is, its least top land and
    root radius.

    `keyway_phase_deg` is the direction of its shaft's mark in its own frame, whose x points to
    where its pitch curve begins; null where no shaft is known.
    """

    name: str
    teeth: int
    area_mm2: float
    margin: float
    margin_tooth: int
    undercut: list[Undercut]
    top_land_mm: float
    top_land_tooth: int
    root_radius_min_mm: float
    curvature_radius_min_mm: float
    hollow_radius_mm: float | None
    profile_shift: float
    keyway_phase_deg: float | None


@dataclass(frozen=True)
class PartExtent(Record):
    """Least and largest value."""

    min: float
    max: float


@dataclass(frozen=True)
class Ratio(Record):
    """Contact ratio of tooth pairs: least, largest, mean."""

    min: float
    max: float
    mean: float


@dataclass(frozen=True)
class StageCut(Record):
    """A pair of toothed gears, and the proof that they mesh.

    `overlap_mm2` and `polygon_gap_mm` are those of polygons at `positions` positions,
    `penetration_modules` is how deep these polygons reach into each other at most, in modules, over
    the whole period; all else is solved exactly. `lost_motion_deg` is how far the second gear turns
    from its central position to contact on one side, the first gear fixed; `lost_motion_total_deg`
    is the turn from contact on one side to contact on the other at the same position, as it is
    measured on a machine. `farther_lost_motion_deg`, `farther_total_deg` and
    `farther_contact_ratio` are those with an error of the centre distance, null without one and
    where teeth lose contact at any position. `sliding_max_mm` is the sliding speed of flanks per
    rotation rate of the first gear.
    """

    stage: int
    z: list[int]
    module_mm: float
    scale: float
    centre_distance_mm: float
    perimeter_mm: list[float]
    gears: list[GearCut]
    contact_ratio: Ratio
    pressure_angle_deg: PartExtent
    transmission_error_rad: float
    gap_mm: PartExtent
    lost_motion_deg: PartExtent
    lost_motion_total_deg: PartExtent
    farther_lost_motion_deg: PartExtent | None
    farther_total_deg: PartExtent | None
    farther_contact_ratio: Ratio | None
    sliding_max_mm: float
    penetration_modules: float
    overlap_mm2: float
    polygon_gap_mm: PartExtent
    positions: int


@dataclass(frozen=True)
class Scaled(Record):
    """Effect of scaling a machine to a standard module.

    `tip_moved_max_mm` is the largest displacement of the path of its tip; `broken_before`, `broken`
    are the requirements that it breaks as designed and as scaled, null if it has no requirements.
    """

    design: dict[str, float]
    tip_moved_max_mm: float
    broken_before: list[str] | None
    broken: list[str] | None


@dataclass(frozen=True)
class FrictionTurn(Record):
    """A machine over a turn with one kind of tooth friction.

    `largest_N` and `rms_N` are those of forces by name, `lost_J` the work lost by place, of all
    sides together. `efficiency` (stage 1, stage 2) is the share of the supplied work that a mesh
    transmits, seen from the carrier.
    """

    largest_N: dict[str, float]
    rms_N: dict[str, float]
    torque_Nm: PartExtent
    motor_work_J: float
    lost_J: dict[str, float]
    efficiency: list[float]


@dataclass(frozen=True)
class Friction(Record):
    """Effect of tooth friction on a machine: without friction, by the convention of its paper, and
    against the sliding.

    `sliding` has all pairs in contact bear the same; with `nearest` the one nearest to the pitch
    point bears all, with `farthest` the one farthest from there. `at_most_N` bounds the forces over
    all ways to share a load, and `pairs` are the most pairs of a stage that bear at once. The
    support force, and with it the `objective`, does not depend on friction: `support_changed_N` is
    its largest change.
    """

    friction_angle_deg: float
    pressure_angle_deg: float
    angles: int
    pairs: list[int]
    objective: float
    support_changed_N: float
    without: FrictionTurn
    convention: FrictionTurn
    sliding: FrictionTurn
    nearest: FrictionTurn
    farthest: FrictionTurn
    at_most_N: dict[str, float]


@dataclass(frozen=True)
class IncompleteCut(Record):
    """An incomplete gear: its teeth including cut ones, the pieces of its outline and the largest
    gap between them.

    Margin and top land are those that the rack leaves, before the arcs.
    """

    name: str
    teeth: int
    area_mm2: float
    margin: float
    margin_tooth: int
    top_land_mm: float
    top_land_tooth: int
    pieces: int
    joins_mm: float


@dataclass(frozen=True)
class LooseMotion(Record):
    """Largest rotation of a driven gear behind its law and ahead of it; null if nothing limits
    it.
    """

    behind_deg: float | None
    ahead_deg: float | None


@dataclass(frozen=True)
class LooseTurn(Record):
    """Loose motion over the parts of a turn; in `driven` teeth limit it in both directions
    throughout.
    """

    after_dwell: LooseMotion
    driven: LooseMotion
    before_dwell: LooseMotion
    dwell: LooseMotion


@dataclass(frozen=True)
class Intermittent(Record):
    """A pair with teeth on part of its turn and locking arcs over the rest, both laid over each
    other as polygons.

    `z` are the teeth of the driving gear, `pitches` the pitches on the toothed arc. `horns_deg` are
    the angles at the driving axis over which the driven gear lies in the arc after the dwell and
    before it. Pairs of angles of the driving gear, after the dwell and before it: `undriven_deg`,
    over which no teeth drive all the time; `undriven_least_deg`, the same with the best phase for
    either side only; `unheld_deg`, over which no teeth hold back. `slack_deg` is what the driven
    gear can turn by in the middle of the dwell, clockwise and anticlockwise; `farther_loose` is its
    loose motion with an error of the centre distance, null without one. `contact_ratio` is of the
    pairs of flanks that the arcs leave whole, pressure angle, error of transmission and sliding
    (per rotation rate of the driving gear) are over all positions, without play. `overlap_mm2` is
    the largest area that the outlines share at `positions` positions over the teeth,
    `dwell_overlap_mm2` at as many over the dwell.
    """

    z: int
    pitches: float
    module_mm: float
    centre_distance_mm: float
    toothed_arc_mm: float
    locking_radius_mm: float
    end_radii_mm: tuple[float, float]
    horns_deg: tuple[float, float]
    apart_mm: float
    dwell_deg: float
    gears: list[IncompleteCut]
    undriven_deg: tuple[float, float]
    undriven_least_deg: tuple[float, float]
    unheld_deg: tuple[float, float]
    slack_deg: tuple[float, float]
    loose: LooseTurn
    farther_loose: LooseTurn | None
    contact_ratio: Ratio
    pressure_angle_deg: PartExtent
    transmission_error_rad: float
    sliding_max_mm: float
    overlap_mm2: float
    dwell_overlap_mm2: float
    positions: int


@dataclass(frozen=True)
class GearsFound(Record):
    """`planter gears`: every pair of gears, what they are cut with, and the files that were
    written.

    `intermittent` is the pair of a machine with a dwell, else null; such a machine has no `stages`.
    `friction` is null if the forces of the machine are not available.
    """

    machine: str
    pressure_angle_deg: float
    addendum: float
    clearance: float
    backlash_mm: float
    centre_error_mm: float
    process: str
    stages: list[StageCut]
    scaled: Scaled | None
    intermittent: Intermittent | None
    friction: Friction | None
    files: list[str]


KINDS = {
    "without": "no friction of the teeth",
    "convention": "friction of the teeth by the paper's convention",
    "sliding": "friction of the teeth against their sliding",
}
"""Kinds of friction that are compared, and their descriptions."""


@dataclass(frozen=True)
class FrictionCurves:
    """Friction result, and quantities (n,) at carrier angles (n,) [deg] by key with display unit,
    then by kind.

    `names` are those of the quantities by key.
    """

    result: Friction
    phi_deg: Array
    curves: Mapping[str, Mapping[str, Array]]
    names: Mapping[str, str]

    def columns(self) -> dict[str, Array]:
        """Return all columns of the table; the kind of friction precedes the unit in the key."""
        columns = {"phi_deg": self.phi_deg}
        for key, kinds in self.curves.items():
            columns |= {name_column(key, kind): values for kind, values in kinds.items()}
        return columns


def name_column(key: str, kind: str) -> str:
    """Return the key of a quantity with one kind of friction.

    >>> name_column("F_A1_N", "sliding")
    'F_A1_sliding_N'
    """
    unit = units.unit_suffix(key)
    return f"{key.removesuffix(unit)}_{kind}{unit}"


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


COMMANDS = {"gears": GearsFound}
