"""How far two quantities, as coordinates of a point, are from a curve, from a ground, or from
another point.

A curve is the polyline through the points of a CSV file, closed if the last of them is the first
again. It is exact for the points as they are, and differentiable without a projection that must be
solved for: near almost every point the closest place of the curve stays on one segment or vertex,
whose choice has no derivative. So has the distance, for a segment that to a line, for a vertex that
to a point. It has a kink where two places are equally near: at the curve's medial axis, and on its
concave side at the bisectors of vertices, as small as the turns of the polyline there.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import InputError
from planter.files import csv_rows, units
from planter.files.units import parse_unit
from planter.kernels import Array
from planter.text_files import read_text

DISTANCE_EPS = 1e-12
"""Regularises d at zero, where it has no derivative: sqrt(d^2 + eps^2) [m]."""
MOST_POINTS = 1000


def read_curve(path: Path, keys: tuple[str, str], is_ground: bool = False) -> Array:
    """Return the points (n, 2) [m] of a CSV file, in columns `x` and `y` with a unit, as `x_mm`, or
    in two named.

    Those of a ground are in the order of x. Raises InputError for a file without such columns,
    without 2 to MOST_POINTS points that differ, or for a ground with two heights at one x.
    """
    table = csv_rows.read_table(read_text(path), str(path))
    columns = [
        name
        for axis in "xy"
        for name in table.header
        if re.fullmatch(rf"{axis}_\w+", name) and _is_length(name)
    ]
    if len(columns) != 2 or columns[0][0] == columns[1][0]:
        columns = list(keys)
    if missing := [name for name in columns if name not in table.header]:
        allowed = f"it must be those of a curve, x_mm and y_mm or {keys[0]} and {keys[1]}"
        raise InputError(
            f"{path}: the header {','.join(table.header)} has no column {missing[0]}: {allowed}"
        )
    points = np.column_stack(
        [np.array(table.numbers(name)) * units.unit_factor(name) for name in columns]
    )
    points = points[np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))]
    if not 2 <= len(points) <= MOST_POINTS:
        raise InputError(
            f"{path}: a curve has 2 to {MOST_POINTS} points that differ, and this has {len(points)}"
        )
    if is_ground:
        points = points[np.argsort(points[:, 0], kind="stable")]
        steps = np.diff(points[:, 0])
        if not (steps > 0).all():
            x = 1e3 * points[np.flatnonzero(steps <= 0)[0], 0]
            raise InputError(
                f"{path}: a ground has one height at every x, and this has two at x = {x:g} mm"
            )
    return points


def _is_length(key: str) -> bool:
    unit = units.display_unit(key)
    return bool(unit) and parse_unit(unit).same_kind(parse_unit("m"))


def build_distance(x: ca.SX, y: ca.SX, points: Array) -> ca.SX:
    """Return the graph of the distance [m] of a point from the polyline through points (n, 2) [m].

    The nearest segment is chosen by comparisons, whose derivatives are zero, and then taken by
    itself.
    """
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    segments = np.column_stack([points[:-1], steps / lengths[:, None], lengths]).tolist()
    nearest, index = _build_square(x, y, *segments[0]), ca.SX(0)
    for place, segment in enumerate(segments[1:], 1):
        square = _build_square(x, y, *segment)
        index = ca.fmax(index, place * (square < nearest))  # places rise
        nearest = ca.fmin(square, nearest)
    chosen = ca.SX.zeros(5)
    for place, segment in enumerate(segments):
        chosen += (index == place) * ca.DM(segment)
    return ca.sqrt(_build_square(x, y, *ca.vertsplit(chosen)) + DISTANCE_EPS**2)


def build_separation(point: Sequence[ca.SX], other: Sequence[ca.SX]) -> ca.SX:
    """Return the graph of the distance [m] of two points, each by its coordinates."""
    return ca.sqrt(sum((a - b) ** 2 for a, b in zip(point, other, strict=True)) + DISTANCE_EPS**2)


def build_clearance(x: ca.SX, y: ca.SX, points: Array) -> ca.SX:
    """Return the graph of the height [m] of a point over the polyline through points (n, 2) [m], in
    the order of x.

    It is negative below; beyond its ends the ground is level.
    """
    ground = ca.SX(float(points[0, 1]))
    for (begin, _), (length, rise) in zip(
        points[:-1].tolist(), np.diff(points, axis=0).tolist(), strict=True
    ):
        ground += rise / length * ca.fmin(ca.fmax(x - begin, 0), length)
    return y - ground


def _build_square(x: ca.SX, y: ca.SX, a: Any, b: Any, u: Any, v: Any, length: Any) -> ca.SX:
    """Return the square of the distance from the segment at (a, b) along the unit vector (u, v)."""
    x, y = x - a, y - b
    part = ca.fmin(ca.fmax(u * x + v * y, 0), length)
    return (x - part * u) ** 2 + (y - part * v) ** 2


def compose_pieces(
    place: ca.SX, knots: Array, coefficients: Sequence[Any], orders: int
) -> list[ca.SX]:
    """Return the graphs of a piecewise polynomial at a place, and of its derivatives up to below
    `orders`.

    `knots` (n,) are the beginnings of the pieces; the first and the last piece go on beyond the
    ends. Coefficients are (n,) for each power of the distance from a piece's knot, the highest
    power first.
    """
    begun = [ca.SX(1), *(place >= float(knot) for knot in knots[1:]), ca.SX(0)]
    chosen = ca.vertcat(
        *(ca.SX(current - following) for current, following in itertools.pairwise(begun))
    )
    powers = [_select(chosen, row) for row in coefficients]
    distance = place - _select(chosen, knots)
    derivatives = []
    for _ in range(orders):
        value = ca.SX(0)
        for power in powers:
            value = value * distance + power
        derivatives.append(value)
        degree = len(powers) - 1
        powers = [power * (degree - k) for k, power in enumerate(powers[:-1])]
    return derivatives


def _select(chosen: ca.SX, row: Any) -> ca.SX:
    """Return the entry of a row (n,) that is chosen; CasADi reads an array's memory whatever its
    strides are.
    """
    return ca.dot(chosen, ca.DM(row.tolist()) if isinstance(row, np.ndarray) else row)
