"""The file of a seedling pick-up: TOML, and a CSV of points where a path drives it, each number
with its origin.

Values stay as the file shows them, in mm, deg, deg/s: a key ends in its unit.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, field_validator

from planter.engine.measures import Limit
from planter.engine.sections import LimitsSection, parse_holds, with_whole_limits
from planter.errors import InputError
from planter.files import csv_rows, examples
from planter.files.csv_rows import Points, inline_points
from planter.files.document import Document, Origins
from planter.files.fields import (
    Angle,
    FileSection,
    NotNegative,
    Pair,
    Positive,
    Problems,
    Real,
    Whole,
    check,
    invalid_value_problem,
    missing_value_problem,
)
from planter.kernels import Array
from planter.numerics.arrays import MAX_GAP_RATIO, find_gap

Length = Annotated[Positive, Field(le=1e6)]
Module = Annotated[Real, Field(ge=1e-3, le=1e3)]
Addendum = Annotated[Positive, Field(le=10)]
LARGEST_SWING = 1e6
TRANSITION_DEG = 15.0
"""Where smooth ends of a dwell name none."""
LEAST_MM = 1e-4
"""Least tolerance of the points' distances where a file names none."""
DEFAULT = "yu2023"
"""The built-in pick-up that lends everything else to a CSV of points given alone."""


HEADER = ("x_mm", "y_mm")
LEAST = 12
"""Points that a path needs."""
LARGEST = 1e6
"""Largest coordinate [mm]."""
_FINEST = 300


def parse_points(text: str, source: str) -> tuple[Array, float]:
    """The points (n, 2) in m of a closed path, and the last decimal place that they are given to
    [m].

    A last point that repeats the first is left out. Raises InputError, naming file, line and what
    is allowed.
    """
    table = csv_rows.read_table(text, source, HEADER)
    points = np.column_stack([table.numbers(name, LARGEST) for name in HEADER])
    if len(points) > 1 and np.array_equal(points[0], points[-1]):
        points = points[:-1]
    if len(points) < LEAST:
        raise InputError(
            f"{source}: {len(points)} points are not enough: there must be at least {LEAST}"
        )
    steps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    for i, step in enumerate(steps, 1):
        if step == 0:
            raise InputError(f"{source}: point {i} is given twice in a row: neighbours must differ")
    gap = find_gap(steps)
    if gap is not None:
        raise InputError(
            f"{source}: points {gap + 1} and {(gap + 1) % len(points) + 1} are {steps[gap]:.4g} mm "
            "apart, which is not allowed: on a closed path neighbours must be within "
            f"{MAX_GAP_RATIO:g} times the median distance, {np.median(steps):.4g} mm"
        )
    return points / 1000, 10.0 ** -max(_places(cell) for row in table.rows for cell in row) / 1000


def _places(cell: str) -> int:
    """Decimal places of a number.

    >>> _places("1.250"), _places("2"), _places("1.5e-3")
    (3, 0, 4)
    """
    digits, _, power = cell.lower().partition("e")
    return min(len(digits.partition(".")[2]) - int(power or 0), _FINEST)


class Bars(FileSection):
    """Carrier arm L1 and planet arm L2; where a path drives the pick-up they are found from it."""

    L1_mm: Length
    """carrier arm: sun's centre to planet's axis"""
    L2_mm: Length
    """planet arm: planet's axis to tip"""

    @check
    def _tip_stays_outside(self) -> Problems:
        if self.L2_mm <= self.L1_mm:
            yield invalid_value_problem(
                "L2_mm", self.L2_mm, f"it must be greater than L1_mm = {self.L1_mm:g}"
            )


class Carrier(FileSection):
    """Bend at the intermediate axis, centre distance of stage 2, speed."""

    gamma_deg: Annotated[Real, Field(gt=90, lt=180)]
    """bend at the intermediate axis"""
    a2_mm: Length
    """centre distance of stage 2; the helix angle follows from it"""
    speed_deg_per_s: Annotated[Positive, Field(le=1e9)]
    """speed of the carrier"""


class HelicalStage(FileSection):
    """Standard helical pair; its helix angle follows from the centre distance."""

    mn_mm: Module
    """normal module"""
    z1: Annotated[Whole, Field(ge=5, le=1000)]
    """teeth of the first gear"""
    z2: Annotated[Whole, Field(ge=5, le=1000)]
    """teeth of the second gear"""
    B_mm: Length
    """face width"""
    alpha_n_deg: Annotated[Real, Field(ge=5, lt=45)]
    """normal pressure angle"""
    ha: Addendum
    """addendum, in normal modules"""

    @check
    def _equal_gears(self) -> Problems:
        if self.z1 != self.z2:
            yield invalid_value_problem(
                "z2", self.z2, f"it must equal z1 = {self.z1}: the ratio of stage 2 is 1"
            )


class NoncircularStage(FileSection):
    """Teeth of the non-circular pair."""

    m_mm: Module
    """module"""
    ha1: Addendum
    """addendum of the first gear, in modules"""
    ha2: Addendum
    """addendum of the second gear, in modules"""
    alpha0_deg: Annotated[Real, Field(ge=5, lt=45)]
    """pressure angle of the rack"""


class LawData(FileSection):
    """Slope of the arm's angle over the carrier's: c (1 + p cos t) on the teeth, zero in the dwell.

    At the ends of the dwell the slope jumps, unless these are smooth: then it goes to zero within
    `transition_deg`.
    """

    phi5_far_deg: Angle
    """carrier angle at which the tip is farthest"""
    phi1_far_deg: Annotated[Real, Field(ge=180, le=180)]
    """arm's angle there"""
    p: Annotated[Real, Field(ge=-LARGEST_SWING, le=LARGEST_SWING)]
    """swing of the slope of the arm's angle"""
    dwell_t_deg: Pair
    """start and end of the dwell, from the farthest point on"""
    ends: Literal["smooth"] | None = None
    """"smooth" for ends of the dwell at which the slope goes to zero; without it, it jumps"""
    transition_deg: Annotated[Positive, Field(le=90)] | None = None
    """angle over which the slope goes to zero at smooth ends"""

    @field_validator("dwell_t_deg")
    @classmethod
    def _dwell_within_a_turn(cls, dwell: tuple[float, float]) -> tuple[float, float]:
        if not 0 < dwell[0] < dwell[1] < 360:
            raise invalid_value_problem(
                "", list(dwell), "it must be [start, end] with 0 < start < end < 360"
            )
        return dwell

    @check
    def _arm_gains_a_turn(self) -> Problems:
        start, end = (math.radians(angle) for angle in self.dwell_t_deg)
        if start - end + 2 * math.pi + self.p * (math.sin(start) - math.sin(end)) <= 0:
            yield invalid_value_problem(
                "p", self.p, "it must let the arm's angle gain over the turn"
            )

    @check
    def _transitions_fit(self) -> Problems:
        if self.transition_deg is None:
            return
        if self.ends is None:
            allowed = 'it goes with smooth ends of the dwell, ends = "smooth", and with no others'
            yield invalid_value_problem("transition_deg", self.transition_deg, allowed)
        limit = (360 - self.dwell_t_deg[1] + self.dwell_t_deg[0]) / 4
        if self.transition_deg > limit:
            allowed = f"it must be at most {limit:g}, a quarter of the turn outside the dwell"
            yield invalid_value_problem("transition_deg", self.transition_deg, allowed)

    @property
    def transition(self) -> float:
        """Width of the transition between dwell and law [rad]; zero if the slope jumps."""
        if self.ends is None:
            return 0.0
        return math.radians(TRANSITION_DEG if self.transition_deg is None else self.transition_deg)


class PathData(FileSection):
    """Points of the tip's path, in a CSV or here, and how far apart distances may be that count as
    one (the dwell).

    Without a tolerance it is two of the last decimal place that a CSV's points are given to, and
    not below `LEAST_MM`.
    """

    csv: Annotated[str, Field(min_length=1)] | None = None
    """CSV file with the points, columns x_mm and y_mm"""
    points_mm: Annotated[list[Pair], Field(min_length=LEAST, max_length=1000)] | None = None
    """the points [x, y] themselves"""
    tolerance_mm: Length | None = None
    """difference of distances that count as one"""

    @check
    def _points_stand_in_one_place(self) -> Problems:
        if self.csv is None and self.points_mm is None:
            yield missing_value_problem("csv", "there must be either csv or points_mm")
        if self.csv is not None and self.points_mm is not None:
            yield invalid_value_problem(
                "csv", self.csv, "there must be either csv or points_mm, not both"
            )
        for number, (point, after) in enumerate(
            zip(self.points_mm or (), (self.points_mm or ())[1:], strict=False)
        ):
            if point == after:
                yield invalid_value_problem(
                    f"points_mm[{number + 1}]", list(after), "neighbours must differ"
                )


class SplineData(FileSection):
    """Value points that are taken from a law, equally spaced over the turn."""

    value_points: Annotated[Whole, Field(ge=12, le=1000)] = 25
    """number of points of the path, equally spaced over the turn, the farthest first"""


class Tray(FileSection):
    """Tray box and cell: a cell is a trapezium, its axis square to the tray."""

    box_inclination_deg: Annotated[Positive, Field(lt=90)]
    """inclination of the tray box"""
    cell_depth_mm: Length = 44.0
    """depth of a cell"""
    cell_top_mm: Length = 30.0
    """width of a cell at its top"""
    cell_bottom_mm: Length = 16.0
    """width of a cell at its bottom"""
    cell_pitch_mm: Length = 32.0
    """distance of neighbouring cells"""

    @check
    def _cells_are_cells(self) -> Problems:
        if not self.cell_bottom_mm <= self.cell_top_mm < self.cell_pitch_mm:
            allowed = (
                f"it must be from cell_bottom_mm = {self.cell_bottom_mm:g} to below cell_pitch_mm"
            )
            yield invalid_value_problem(
                "cell_top_mm", self.cell_top_mm, f"{allowed} = {self.cell_pitch_mm:g}"
            )


class Needle(FileSection):
    """The needle as seen along the axes of the gears; `mounting_deg` turns it against the arm O1 to
    tip.
    """

    length_mm: Length = 80.0
    """length of the needle"""
    width_mm: Length = 10.0
    """width of the needle"""
    mounting_deg: Annotated[Real, Field(ge=-180, le=180)] = 0.0
    """angle of the needle from the arm's direction, planet's axis to tip"""


class Targets(FileSection):
    """Requirements of the path (the paper's Table 1, by the numbers in its text), each with a
    tolerance.
    """

    push_deg: Angle = 90.0
    """angle of the arm where it pushes"""
    push_tolerance_deg: Positive = 2.0
    """tolerance of the push angle"""
    swing_deg: Angle = 50.0
    """push angle less pick angle"""
    swing_tolerance_deg: Positive = 2.0
    """tolerance of the swing"""
    entry_depth_mm: Length = 35.0
    """depth of the entry into a cell"""
    entry_depth_tolerance_mm: Length = 2.0
    """tolerance of the depth"""
    straight_entry_mm: Length = 65.0
    """length of the straight part of the entry"""
    straightness_mm: Length = 1.0
    """largest distance of that part from its chord"""
    clearance_mm: NotNegative = 0.0
    """least clearance of needle and tray"""


class TipPath(FileSection):
    """Points that the tip's path must pass, in the sun's frame, each with the radius of its
    tube.
    """

    points_mm: Points


class Pickup(Document):
    """A pick-up driven by a law or by a path.

    `points` are the path's (n, 2) in m, None with a law.
    """

    bars: Bars | None = None
    carrier: Carrier
    helical_stage: HelicalStage
    noncircular_stage: NoncircularStage
    law: LawData | None = None
    path: PathData | None = None
    spline: SplineData = SplineData()
    tray: Tray
    needle: Needle = Needle()
    targets: Targets = Targets()
    tip_path: TipPath | None = None
    requirements: LimitsSection | None = None
    origins: Origins = Field(alias="origin")

    _points: Array | None = PrivateAttr(default=None)
    _points_source: str = PrivateAttr(default="path")
    _resolution: float = PrivateAttr(default=0.0)

    @classmethod
    def read(
        cls,
        table: Mapping[str, Any],
        source: str,
        changes: Mapping[str, float] | None = None,
        changed: tuple[str, ...] = (),
    ) -> Self:
        """The validated content of a file, as `Document.read`; points of the tip's path may be in a
        CSV next to it.
        """
        return super().read(inline_points(table, "tip_path", source), source, changes, changed)

    @property
    def points(self) -> Array | None:
        listed = None if self.path is None else self.path.points_mm
        return self._points if listed is None else np.array(listed) / 1000

    @property
    def measure_limits(self) -> tuple[Limit, ...]:
        """The limits on measures in [requirements]. Raises InputError if one cannot be parsed."""
        return parse_holds(self.requirements, self.source)

    @property
    def points_source(self) -> str:
        """The file that the points were read from."""
        return self._points_source

    @property
    def tolerance(self) -> float:
        """Largest difference of distances from the sun's centre that count as equal [m]."""
        if self.path is not None and self.path.tolerance_mm is not None:
            return self.path.tolerance_mm / 1000
        return max(2 * self._resolution, LEAST_MM / 1000)

    def written_table(self) -> dict[str, Any]:
        """Return the table with the whole path of its points, to be written anywhere."""
        table = with_whole_limits(self.table(), self.measure_limits, self.source)
        if (
            self.path is not None
            and self.path.csv is not None
            and Path(self.points_source).is_file()
        ):
            table["path"]["csv"] = str(Path(self.points_source).resolve())
        return table

    def with_points(self, points: Array, csv: str) -> "Pickup":
        """A pick-up driven by a path of points (n, 2) in m, its bars found from them, all else as
        in this one.
        """
        table = self._without_drive()
        table["name"] = Path(csv).stem[:80]
        table["description"] = f"Seedling pick-up on the path of {csv}, all else as in {self.name}"
        changed = self.read({**table, "path": {"csv": csv}}, csv)
        changed._points, changed._points_source = points, csv
        return changed

    def on_path(self, points: Array) -> "Pickup":
        """This pick-up driven by a path of points (n, 2) in m in its file."""
        path = {"points_mm": np.round(points * 1000, 6).tolist()}
        return self.read({**self._without_drive(), "path": path}, self.source)

    def _without_drive(self) -> dict[str, Any]:
        """The table of the file without law, bars and path, and with an origin for another path."""
        gone = ("law", "bars", "path")
        table = {key: value for key, value in self.table().items() if key not in gone}
        origins = {
            key: text for key, text in self.origins.items() if key.partition(".")[0] not in gone
        }
        return {**table, "origin": {**origins, "path": "assumed"}}

    @check
    def _one_drive(self) -> Problems:
        if self.law is None and self.path is None:
            yield missing_value_problem("law", "there must be either [law] or [path]")
        if self.law is not None and self.path is not None:
            yield invalid_value_problem(
                "path", self.path.csv or "", "there must be either [law] or [path], not both"
            )
        if self.law is not None and self.bars is None:
            yield missing_value_problem("bars", "a law needs the lengths of the bars")

    @check
    def _helix_exists(self) -> Problems:
        stage, distance = self.helical_stage, self.carrier.a2_mm
        minimum = stage.mn_mm * (stage.z1 + stage.z2) / 2
        if distance < minimum:
            yield invalid_value_problem(
                "carrier.a2_mm", distance, f"it must be at least mn (z1 + z2)/2 = {minimum:g}"
            )


def load_pickup(source: str | Path, changes: Mapping[str, float] | None = None) -> Pickup:
    """Return the pick-up in a file, or a built-in one by name; a CSV of points takes the rest from
    `yu2023`.

    Raises InputError, one sentence with file, key, value and the allowed values.
    """
    label = str(source)
    if is_points(label):
        points, _ = parse_points(examples.read_source(source, "pickup", ".csv"), label)
        machine = load_pickup(DEFAULT).with_points(points, label)
        machine = machine.with_numbers(changes) if changes else machine
    else:
        machine = Pickup.load(source, "pickup", changes)
    if machine.path is not None and machine.path.csv is not None:
        csv = label if is_points(label) else _locate_csv(label, machine.path.csv)
        machine._points_source = str(csv)
        text = examples.read_source(csv, "pickup", ".csv")
        machine._points, machine._resolution = parse_points(text, str(csv))
    return machine


def is_points(label: str) -> bool:
    """Return whether a source is a CSV of points, by its name."""
    return label.lower().endswith(".csv") or label in examples.list_examples("pickup", ".csv")


def _locate_csv(config: str, csv: str) -> str | Path:
    """Return a built-in CSV by name, or the path of a CSV in the folder of the file that names
    it.
    """
    return csv if csv in examples.list_examples("pickup", ".csv") else Path(config).parent / csv
