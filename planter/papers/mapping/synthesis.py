"""`design synthesise`: from a file of poses to dyads, linkages and the angle curve of a gear
train.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np

from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.papers.mapping import model
from planter.papers.mapping.curve import AngleCurve
from planter.papers.mapping.dyads import (
    CONDITIONS,
    Dyad,
    Scale,
    Solution,
    count_free_parameters,
    distinct,
    find_family,
    fit_dyads,
    misses,
    solve_dyads,
    to_pair,
)
from planter.papers.mapping.file import PointsData, PoseFile, build_path_curve
from planter.papers.mapping.linkage import (
    FourBar,
    find_defects,
    reversals,
    standings,
)
from planter.papers.mapping.nearest import (
    SLOPES,
    Nearest,
    find_misses,
    find_nearest,
    interpolate_poses,
)
from planter.papers.mapping.results import (
    AtPose,
    CurveOfPaths,
    DefectsFound,
    DyadFound,
    Family,
    Four,
    LinkageFound,
    Missed,
    NearestCurve,
    OneSense,
    StraightFound,
    SynthesisFound,
)

_POINT = 1e-9
"""Radius, in sizes of the poses, below which a moving hinge stands still: that is no crank."""


@dataclass(frozen=True)
class Linkage:
    """A pair of dyads, by their numbers, as a four-bar linkage, with its positions at the poses."""

    numbers: tuple[int, int]
    bar: FourBar
    standings: list[AtPose]
    defects: DefectsFound
    sense: int
    """Sense of the crank through the poses, 0 if they are out of order."""


@dataclass(frozen=True)
class Synthesis:
    """Dyads, linkages and angle curves of poses; `result` is what the command returns."""

    file: PoseFile
    poses: Array
    solution: Solution
    members: list[Dyad]
    linkages: list[Linkage]
    carrier: Dyad | None
    exact: AngleCurve | None
    nearest: Nearest | None
    path_curve: AngleCurve | None
    result: SynthesisFound = field(repr=False)


def synthesise(file: PoseFile, carrier: int = 1, slopes: tuple[float, float] = SLOPES) -> Synthesis:
    """Return the dyads of the poses, all pairs as linkages, and the angle curve of a carrier dyad
    (from 1, by radius).

    `slopes` are the least and the largest slope [-] of the monotone angle curve.

    Raises InputError if no two poses differ, or if the carrier is not the number of a dyad.
    """
    poses = file.poses
    count = len(distinct(poses))
    solution, linkages = find_linkages(poses)
    family_of = find_family(poses) if solution.free or count < 2 else ([], [])
    dyad = _carrier(poses, solution.dyads, carrier)
    path_curve = _build_path_curve(file, linkages)
    closest, why_not = _find_nearest(dyad, poses, slopes)
    result = SynthesisFound(
        poses=len(poses),
        dyads=[dyad_result(d, poses) for d in solution.dyads],
        complex_pairs=solution.complex_roots // 2,
        singular_values=_singular_values(poses * [1e3, 1e3, 1]),
        scaled_singular_values=[float(v) for v in solution.singular_values[:CONDITIONS]],
        straight=solution.straights,
        family=_family_shown(solution, family_of, poses),
        linkages=[_linkage_shown(linkage, poses) for linkage in linkages],
        carrier_dyad=None if dyad is None else carrier,
        monotone=None if dyad is None else _find_rotation(dyad, poses),
        nearest=None
        if closest is None
        else NearestCurve(
            least_slope=slopes[0],
            largest_slope=slopes[1],
            order=[k + 1 for k in closest.order],
            **_describe_curve(closest.curve, closest.misses),
        ),
        curve=None
        if path_curve is None or dyad is None
        else CurveOfPaths(
            points=len(path_curve.carrier),
            **_describe_curve(path_curve, find_misses(dyad, poses, path_curve)),
        ),
        warnings=[*_remarks(poses, count, solution), *([why_not] if why_not else [])],
    )
    exact = None if dyad is None else interpolate_poses(dyad, poses)
    return Synthesis(
        file, poses, solution, family_of[0], linkages, dyad, exact, closest, path_curve, result
    )


def _singular_values(poses: Array) -> list[float]:
    """Return the singular values of the linear system (4) of sun2019, with lengths in mm."""
    values = np.linalg.svd(model.rows(poses), compute_uv=False)
    return [float(v) for v in values[:CONDITIONS]]


def find_linkages(poses: Array) -> tuple[Solution, list[Linkage]]:
    """Return the dyads of poses (n, 3), and every pair of them as a linkage."""
    count = len(distinct(poses))
    free = count_free_parameters(poses) if count > 1 else 1
    solution = fit_dyads(poses) if free == 0 and count > CONDITIONS else solve_dyads(poses)
    return solution, _pair(poses, solution.dyads)


def _pair(poses: Array, dyads: Sequence[Dyad]) -> list[Linkage]:
    smallest = _POINT * Scale.from_poses(poses).size
    linkages = []
    for (i, first), (j, second) in combinations(enumerate(dyads, 1), 2):
        if min(first.radius, second.radius) > smallest:
            bar = FourBar(first, second)
            positions = standings(bar, poses)
            linkages.append(Linkage((i, j), bar, positions, *find_defects(bar, positions)))
    return linkages


def choose_dyad(dyads: Sequence[Dyad], number: int) -> Dyad:
    """Return the dyad of a number, counted by radius. Raises InputError if there is none."""
    if not 1 <= number <= len(dyads):
        allowed = (
            f"from 1 to {len(dyads)}, the number of real dyads"
            if dyads
            else "left out: there is no real dyad"
        )
        raise InputError(f"--carrier {number} is not a dyad: the number must be {allowed}")
    return dyads[number - 1]


def _carrier(poses: Array, dyads: Sequence[Dyad], number: int) -> Dyad | None:
    """Return the dyad of a number; None if no dyad is real, or if its moving hinge stands still."""
    if not dyads and number == 1:
        return None
    dyad = choose_dyad(dyads, number)
    return dyad if dyad.radius > _POINT * Scale.from_poses(poses).size else None


def _find_rotation(dyad: Dyad, poses: Array) -> OneSense:
    """Return whether the arm can turn in one sense only, and the reversals if not."""
    turned = reversals(dyad.carrier_angles(poses), poses[:, 2])
    return OneSense(not turned, turned)


def _find_nearest(
    dyad: Dyad | None, poses: Array, slopes: tuple[float, float]
) -> tuple[Nearest | None, str]:
    if dyad is None:
        return None, ""
    try:
        return find_nearest(dyad, poses, slopes), ""
    except ComputationError as error:
        return None, error.message


def _build_path_curve(file: PoseFile, linkages: Sequence[Linkage]) -> AngleCurve | None:
    """Return the curve through the points that a file chooses on the paths of one of its
    linkages.
    """
    points = file.points
    if points is None:
        return None
    if points.linkage > len(linkages):
        raise file.input_error(
            "points.linkage", f"it must be from 1 to {len(linkages)}, the number of linkages"
        )
    linkage = linkages[points.linkage - 1]
    first, second = (_assembly(file, points, linkage, key) for key in ("first_pose", "second_pose"))
    return build_path_curve(linkage.bar, points, (first, second))


def _assembly(file: PoseFile, points: PointsData, linkage: Linkage, key: str) -> int:
    number = int(getattr(points, key))
    if number > len(linkage.standings):
        raise file.input_error(
            f"points.{key}", f"it must be from 1 to {len(linkage.standings)}, the number of poses"
        )
    return linkage.standings[number - 1].assembly


def _linkage_shown(linkage: Linkage, poses: Array) -> LinkageFound:
    bar = linkage.bar
    frame, crank, coupler, rocker = (length * 1e3 for length in bar.lengths)
    return LinkageFound(
        dyads=linkage.numbers,
        frame_mm=frame,
        crank_mm=crank,
        coupler_mm=coupler,
        rocker_mm=rocker,
        type=bar.type,
        grashof=bar.grashof,
        circuits=len(bar.reaches),
        transmission_min_deg=math.degrees(bar.least_transmission),
        arm_length_mm=float(np.hypot(*bar.crank.point)) * 1e3,
        poses=linkage.standings,
        defects=linkage.defects,
        crank_sense=linkage.sense,
        monotone=_find_rotation(bar.crank, poses),
    )


def _describe_curve(curve: AngleCurve, misses: list[Missed]) -> dict[str, Any]:
    """Return the values of a curve's record with its misses, and their root mean square over both
    ends of the arm.
    """
    squares = [(row.position_error_mm**2 + row.hinge_error_mm**2) / 2 for row in misses]
    rms = float(np.sqrt(np.mean(squares)))
    return {**describe_slopes(curve), "poses": misses, "rms_mm": rms}


def _family_shown(
    solution: Solution, members: tuple[list[Dyad], list[StraightFound]], poses: Array
) -> Family | None:
    if not solution.free:
        return None
    dyads, straights = members
    return Family(
        parameters=solution.free,
        dyads=[dyad_result(d, poses) for d in dyads],
        straight=straights,
    )


def _remarks(poses: Array, count: int, solution: Solution) -> list[str]:
    remarks = []
    if count < len(poses):
        remarks.append(f"only {count} of the {len(poses)} poses are different")
    if solution.free and count >= CONDITIONS:
        remarks.append(
            f"the poses depend on each other: they leave a family with {solution.free} free "
            f"parameters"
        )
    elif solution.free:
        remarks.append(
            f"{count} poses leave a family of dyads with {solution.free} free parameters; members "
            f"are listed"
        )
    elif count > CONDITIONS:
        remarks.append(
            f"{count} poses: no dyad passes all of them in general; those listed are the closest"
        )
    if solution.orientations:
        remarks.append(
            "the poses have two directions of the body only, which counts as a root without hinges"
        )
    return remarks


def to_four(lengths: Array) -> Four:
    """Return a length of each gear [m] in mm."""
    a, b, c, d = (float(x) * 1e3 for x in lengths)
    return a, b, c, d


def dyad_result(solution: Dyad, poses: Array) -> DyadFound:
    """Return a dyad, how far it misses the poses, and whether its fixed hinge is outside the
    polyline of their tips.
    """
    return DyadFound(
        moving_point_mm=to_pair(solution.point * 1e3),
        centre_mm=to_pair(solution.centre * 1e3),
        radius_mm=solution.radius * 1e3,
        multiplicity=solution.multiplicity,
        largest_miss_mm=float(misses(poses, solution.vector).max()) * 1e3,
        outside=is_outside(solution.centre, poses[:, :2]),
    )


def is_outside(place: Array, corners: Array) -> bool:
    """Return whether a place (2,) is outside the closed polyline through corners (n, 2): even-odd
    rule.
    """
    (x, y), (x1, y1) = place, corners.T
    x2, y2 = np.roll(corners, -1, axis=0).T
    spans = (y1 > y) != (y2 > y)
    rise = np.where(spans, y2 - y1, 1)
    return bool(np.sum(spans & (x < x1 + (y - y1) * (x2 - x1) / rise)) % 2 == 0)


def describe_slopes(curve: AngleCurve) -> dict[str, Any]:
    """Return the extremes of the slope [-] of an angle curve."""
    lowest, largest = curve.extremes
    return {
        "monotone": curve.monotone,
        "slope_min": lowest.value,
        "slope_min_at_deg": math.degrees(lowest.place % TURN),
        "slope_max": largest.value,
        "slope_max_at_deg": math.degrees(largest.place % TURN),
    }
