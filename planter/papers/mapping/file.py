"""Files of poses, with what else a user may say in them.

Values are returned in SI units and radians.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import scipy
from pydantic import Field

from planter.engine.measures import Limit
from planter.engine.sections import LimitsSection, parse_holds, with_whole_limits
from planter.errors import ComputationError, InputError
from planter.files.document import Document, Origins
from planter.files.fields import (
    Angle,
    FileSection,
    Line,
    Pair,
    Positive,
    Problems,
    Real,
    Words,
    check,
    invalid_value_problem,
)
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.papers.mapping.curve import AngleCurve, closed_turn, unwrap_rotations
from planter.papers.mapping.dyads import Dyad
from planter.papers.mapping.linkage import FourBar


def build_path_curve(
    linkage: FourBar, points: PointsData, assemblies: tuple[int, int]
) -> AngleCurve:
    """The curve through points on the paths of two assemblies and free ones.

    Free ordinates that are not given lie on the periodic monotone cubic (Fritsch and Carlson)
    through the points of the paths. Raises ComputationError where a path has no such point.
    """
    first, second, free = (
        np.radians(angles)
        for angles in (
            points.first_carrier_deg,
            points.second_carrier_deg,
            points.free_carrier_deg,
        )
    )
    shift = float(np.radians(points.second_shift_deg))
    parts = [(first, assemblies[0], 0.0), (second, assemblies[1], shift)]
    theta = np.concatenate([angles for angles, _, _ in parts])
    relative = np.concatenate(
        [_on_path(linkage, a, assembly) + shift for a, assembly, shift in parts]
    )
    order = np.argsort(theta)
    theta, relative = theta[order], unwrap_rotations(relative[order])
    if relative[-1] <= relative[0] - TURN:
        raise ComputationError(
            "the points of the two paths do not lie on one closed turn of the carrier: the arm "
            "would have to turn against the carrier by "
            f"{np.degrees(relative[0] - relative[-1]):.6g} deg, which must be less than 360"
        )
    relative_deg = points.free_relative_deg
    ordinates = (
        _between(theta, relative, free) if relative_deg is None else np.radians(relative_deg)
    )
    return closed_turn(np.concatenate([theta, free]), np.concatenate([relative, ordinates]))


def _on_path(linkage: FourBar, theta: Array, assembly: int) -> Array:
    """Relative rotation [rad], up to whole turns, of the points of a path at carrier angles
    (n,).
    """
    for angle in theta:
        if not _within_reach(linkage, float(angle)):
            raise ComputationError(
                f"the path of assembly {assembly:+d} has no point at {np.degrees(angle):.6g} deg"
            )
    phi = linkage.arm_angle(theta, np.full(len(theta), assembly))
    relative: Array = phi - theta
    return _unwrap_near(relative, 0.0)


def _unwrap_near(relative: Array, start: float) -> Array:
    """The rotations with whole turns added so that the first lies within half a turn of `start`."""
    return relative - TURN * np.round((relative[0] - start) / TURN) if len(relative) else relative


def _within_reach(linkage: FourBar, theta: float) -> bool:
    return any(
        reach.is_full_turn or np.mod(theta - reach.start, TURN) <= reach.span
        for reach in linkage.reaches
    )


def _between(theta: Array, relative: Array, free: Array) -> Array:
    turns = np.array([-1, 0, 1])[:, None] * TURN
    return scipy.interpolate.PchipInterpolator((theta + turns).ravel(), (relative - turns).ravel())(
        free
    )


def duplicates(angles: Sequence[float]) -> list[float]:
    """Carrier angles [rad] that are given more than once, up to whole turns."""
    ordered = np.sort(np.mod(angles, TURN))
    return [
        float(a) for a, b in zip(ordered, np.roll(ordered, -1), strict=True) if abs(a - b) < 1e-9
    ]


LARGEST, SMALLEST = 1e100, 1e-100
"""Largest coordinate [mm], and least extent of the poses: their squares are numbers."""
MOST = 200
"""Most poses of a file, most points of a curve of paths."""

Coordinate = Annotated[Real, Field(ge=-LARGEST, le=LARGEST)]
Angles = Annotated[list[Angle], Field(max_length=MOST)]


class PoseEntry(FileSection):
    """A pose of the arm: place of its tip and direction of its x axis, from X,
    counter-clockwise.
    """

    x_mm: Coordinate
    y_mm: Coordinate
    phi_deg: Angle


class CarrierDyad(FileSection):
    """The dyad of the carrier, where a file names one."""

    moving_point_mm: Pair
    """moving hinge in the frame of the arm"""
    centre_mm: Pair
    """fixed hinge"""
    radius_mm: Positive
    """length of the dyad"""


class TrainData(FileSection):
    """Data of the gear train."""

    centre_distance_mm: Positive = 70.0
    """distance of the axes of a gear pair"""
    carrier_speed_rpm: Positive = 60.0
    """speed of the carrier"""


class CurveData(FileSection):
    """Points of an angle curve, one closed turn."""

    carrier_deg: Angles
    """angles of the carrier, one closed turn"""
    relative_deg: Angles
    """angle of the arm less that of the carrier, at each of them"""


class PointsData(FileSection):
    """Carrier angles of the points of the curve: on the path of either assembly of a linkage, and
    free ones.

    `linkage` counts as in the results. Free ordinates are given, or lie on a monotone cubic through
    the others.
    """

    linkage: Annotated[int, Field(strict=True, ge=1)] = 1
    """number of the linkage whose paths have the points"""
    first_pose: Annotated[int, Field(strict=True, ge=1)]
    """pose on whose path the first points are"""
    first_carrier_deg: Angles
    """carrier angles of the first points"""
    second_pose: Annotated[int, Field(strict=True, ge=1)]
    """pose on whose path the second points are"""
    second_carrier_deg: Angles
    """carrier angles of the second points"""
    second_shift_deg: Angle = 0.0
    """shift of the second points along the ordinate"""
    free_carrier_deg: Angles = Field(default_factory=list)
    """carrier angles of points on neither path"""
    free_relative_deg: Angles | None = None
    """their ordinates; between the paths if they are left out"""

    @check
    def _points_make_a_curve(self) -> Problems:
        angles = [*self.first_carrier_deg, *self.second_carrier_deg, *self.free_carrier_deg]
        if len(angles) < 3:
            yield invalid_value_problem(
                "first_carrier_deg", self.first_carrier_deg, "there must be 3 points in all"
            )
        twice = duplicates(np.radians(angles).tolist())
        if twice:
            allowed = (
                f"no two points may have one carrier angle, as at {np.degrees(twice[0]):.6g} deg"
            )
            yield invalid_value_problem("first_carrier_deg", self.first_carrier_deg, allowed)
        ordinates = self.free_relative_deg
        if ordinates is not None and len(ordinates) != len(self.free_carrier_deg):
            yield invalid_value_problem(
                "free_relative_deg", ordinates, "it must be as long as free_carrier_deg"
            )


class PoseFile(Document):
    """Poses; the other tables are optional, and so is where the numbers come from."""

    name: Annotated[Line, Field(min_length=1, max_length=80)] = "poses"
    """name of the machine in results"""
    description: Words = ""
    """a sentence on the machine"""
    pose: Annotated[list[PoseEntry], Field(min_length=2, max_length=MOST)]
    dyad: CarrierDyad | None = None
    train: TrainData = TrainData()
    curve: CurveData | None = None
    points: PointsData | None = None
    requirements: LimitsSection | None = None
    origins: Origins = Field(
        alias="origin", default_factory=lambda: {"default": "assumed (the file does not say)"}
    )

    @property
    def measure_limits(self) -> tuple[Limit, ...]:
        """The limits on measures in [requirements]. Raises InputError if one cannot be parsed."""
        return parse_holds(self.requirements, self.source)

    def written_table(self) -> dict[str, Any]:
        """Return the table with whole paths of the curves in limits, for a file in any folder."""
        return with_whole_limits(self.table(), self.measure_limits, self.source)

    @property
    def poses(self) -> Array:
        """Poses (n, 3): x, y [m], angle [rad]."""
        rows = [(p.x_mm * 1e-3, p.y_mm * 1e-3, np.radians(p.phi_deg)) for p in self.pose]
        return np.array(rows, dtype=float)

    @property
    def carrier_dyad(self) -> Dyad | None:
        """The dyad that the file names for the carrier [m]."""
        if self.dyad is None:
            return None
        point, centre = np.array(self.dyad.moving_point_mm), np.array(self.dyad.centre_mm)
        return Dyad(point * 1e-3, centre * 1e-3, self.dyad.radius_mm * 1e-3)


def load_poses(source: str | Path, changes: Mapping[str, float] | None = None) -> PoseFile:
    """A file of poses, or a built-in one by its name; `changes` set numbers, as `pose[0].phi_deg`.

    Raises InputError for anything that cannot be used.
    """
    if str(source).lower().endswith(".csv"):
        raise InputError(
            f"{source}: this is a CSV file, but poses are read from a TOML file with [[pose]] "
            f"with x_mm, y_mm, "
            f"phi_deg (planter example sun2019 prints one; a curve of angles goes to design train)"
        )
    file = PoseFile.load(source, "mapping", changes)
    _check_spread(file)
    return file


def _check_spread(file: PoseFile) -> None:
    places = file.poses[:, :2]
    size = float(np.abs(places - places.mean(axis=0)).max())
    if 0 < size < SMALLEST * 1e-3:
        raise file.input_error(
            "pose[0].x_mm", f"places of poses must differ by {SMALLEST:g} mm or more, or not at all"
        )
    if 0 < size < 1e-12 * float(np.abs(places).max()):
        raise file.input_error(
            "pose[0].x_mm", "the poses must lie nearer to the origin, or their differences are lost"
        )
