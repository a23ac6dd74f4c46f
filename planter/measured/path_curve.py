"""The distances of measured points from the path of a point of a machine, with exact derivatives.

The distance is that to the true nearest point, where the line to it is square to the path: its
angle is a root of (p(phi) - q) . p'(phi). Since the distance is stationary in that angle, its
derivatives in the inputs are those at a fixed angle (orthogonal distance regression; Boggs, Byrd,
Schnabel 1987, A stable and efficient algorithm for nonlinear orthogonal distance regression, SIAM
J. Sci. Stat. Comput. 8, 1052).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
import scipy

from planter.engine.machine import Machine
from planter.engine.response import DesignPoint
from planter.errors import InputError
from planter.kernels import Array, Integers
from planter.measured.curve import (
    FRAME,
    SAMPLES,
    ChannelNoise,
    Chosen,
    MeasuredCurve,
    factor_of,
    is_nuisance,
)
from planter.measured.reading import PATH_UNIT, Measurement
from planter.measured.sensor_view import is_sensor_input
from planter.numerics.roots import find_bracketed_roots

SCALE = 1e-3
"""First standard deviation of the distances, in the extent of the points; their own takes its place
after a fit.
"""
MOST_PAIRS = 2_000_000
"""Number of points and samples of the path whose distances are compared at once."""
TOUCHING = 1e-9
"""Distance, in the extent of the points, below which its direction is the normal of the path."""
SCAN_STEP_DEG = 15.0
"""Largest step between the rotations of a scan."""
QUADRATURE: tuple[Array, Array] = np.polynomial.legendre.leggauss(5)
"""Abscissae and weights of the quadrature of the length of an arc, on each step of the samples."""


@dataclass(frozen=True)
class PathDistances:
    """Measured points (2, m) in the frame of the machine, the nearest points (2, m) of the path at
    angles (m,) [rad] and arcs (m,) from the angle 0, and distances (m,).

    Lengths are in mm. A distance is positive if the point lies on the left of the path, seen in the
    direction in which the angle grows.
    """

    points: Array
    nearest: Array
    angles: Array
    arcs: Array
    distances: Array


class PathCurve(MeasuredCurve):
    """Distances [mm] of measured points from the path of a point, for values (n,) of the chosen
    inputs.

    The quantities are x and y of the point. The inputs may have the pose of the measured frame in
    that of the machine: its rotation and its origin, by the names `FRAME`. What is measured is the
    distance 0, and what is computed the signed distance of the path from each point.
    """

    def __init__(
        self, machine: Machine, chosen: Chosen, measured: Measurement, quantities: Sequence[str]
    ) -> None:
        super().__init__(machine, chosen, measured, quantities)
        self.points = np.array([channel.values for channel in measured.channels])
        self.extent = float(np.ptp(self.points, axis=1).max())
        self.keys, self.units = ("distance_mm",), (PATH_UNIT,)
        count = self.points.shape[1]
        self._set_points([np.arange(count)], np.zeros(count))
        self.noises = (ChannelNoise(SCALE * self.extent),)

    def _check_names(self) -> None:
        """Raise InputError for an input that points without an angle do not have."""
        for name in self.chosen.names:
            if (is_nuisance(name) and name not in FRAME) or is_sensor_input(name):
                raise InputError(
                    f"--fit {name}: the points of a path have neither an angle nor a gauge; their "
                    f"frame has {', '.join(FRAME)}"
                )

    def _select(self, selected: Sequence[Integers]) -> MeasuredCurve:
        thin = super()._select(selected)
        assert isinstance(thin, PathCurve)
        thin.points = self.points[:, selected[0]]
        return thin

    def with_angles_at(self, z: Array) -> MeasuredCurve:
        """Return a copy whose points have the angles of the nearest points of the path."""
        placed = copy(self)
        placed.phi = self._find_nearest(z)
        return placed

    def place_points(self, z: Array) -> Array:
        """Return the measured points (2, m) in the frame of the machine [mm]."""
        pose = self.find_pose(z)
        cosine, sine = np.cos(pose[0]), np.sin(pose[0])
        rotation = np.array([[cosine, -sine], [sine, cosine]])
        placed: Array = rotation @ self.points + pose[1:, None]
        return placed

    def find_pose(self, z: Array) -> Array:
        """Return the rotation [rad] and the origin [mm] of the measured frame, (3,)."""
        names, pose = self.chosen.names, np.zeros(3)
        for k, name in enumerate(FRAME):
            if name in names:
                pose[k] = z[names.index(name)]
        pose[1:] /= factor_of(FRAME[1])
        return pose

    def __call__(self, z: Array) -> tuple[Array, Array]:
        """Return the signed distances of the path from the points (m,) and their Jacobian (m, n),
        the last of which are cached.
        """
        key = z.tobytes()
        if self._last is None or self._last[0] != key:
            distances, directions, path_slopes = self._measure(z, self._find_nearest(z))
            slopes = np.einsum(
                "km,kmn->mn", directions, path_slopes - self._differentiate_points(z)
            )
            self._last = key, (-distances, slopes)
        return self._last[1]

    def measure(self, z: Array) -> PathDistances:
        """Return the distances for values (n,), with where they are."""
        angles = self._find_nearest(z)
        nearest = self.evaluate(z, angles)[0]
        distances = self._measure(z, angles)[0]
        arcs = self.measure_arcs(z)(angles)
        return PathDistances(self.place_points(z), nearest, angles, arcs, distances)

    def measure_arcs(self, z: Array) -> scipy.interpolate.CubicHermiteSpline:
        """Return the length [mm] of the path from the angle 0 to another one [rad] of a cycle."""
        point, step = self._find_point(z), self.machine.turn / SAMPLES
        grid = np.linspace(0, self.machine.turn, SAMPLES + 1)
        abscissae, weights = QUADRATURE
        inner = (grid[:-1, None] + step * (1 + abscissae) / 2).ravel()
        speeds = self._find_speeds(point, inner).reshape(SAMPLES, -1)
        arcs = np.concatenate([[0.0], np.cumsum(speeds @ weights * step / 2)])
        return scipy.interpolate.CubicHermiteSpline(grid, arcs, self._find_speeds(point, grid))

    def find_starts(self, z: Array, count: int) -> list[tuple[Array, float]]:
        """Return the best minima over the rotation of the measured frame, best first: values (n,)
        and the sum of squares.

        The origin, if it is chosen too, lays the middle of the points on that of the path, within
        the bounds. Returns `z` alone, with an infinite sum, if the rotation is not chosen.
        """
        names = self.chosen.names
        if FRAME[0] not in names:
            return super().find_starts(z, count)
        index, (lower, upper) = names.index(FRAME[0]), self.bounds(z)
        width = upper[index] - lower[index]
        steps = max(2, int(np.ceil(np.degrees(width) / SCAN_STEP_DEG)))
        middle = self.evaluate(z, self.sample_angles)[0].mean(axis=1)
        starts = []
        for rotation in np.linspace(lower[index], upper[index], steps + 1):
            values = z.copy()
            values[index] = rotation
            gap = middle - self.place_points(values).mean(axis=1)
            for k, name in enumerate(FRAME[1:]):
                if name in names:
                    values[names.index(name)] += gap[k] * factor_of(name)
            values = np.clip(values, lower, upper)
            residuals = self.residuals(values)[0]
            starts.append((values, float(residuals @ residuals)))
        sums = np.array([np.inf, *(total for _, total in starts), np.inf])
        is_minimum = (sums[1:-1] <= sums[:-2]) & (sums[1:-1] <= sums[2:])
        minima = [start for start, good in zip(starts, is_minimum, strict=True) if good]
        return sorted(minima, key=lambda start: start[1])[:count]

    def _find_point(self, z: Array) -> DesignPoint:
        return self._response.at(z[self._inputs])

    def _find_speeds(self, point: DesignPoint, phi: Array) -> Array:
        """Return the lengths of the path's derivative (n,) in the angle [mm/rad]."""
        rates = self._response.derivatives(point, phi)[1] / self._factors[:, None]
        speeds: Array = np.hypot(*rates)
        return speeds

    def _measure(self, z: Array, angles: Array) -> tuple[Array, Array, Array]:
        """Return signed distances (m,) from the path at angles (m,), their directions (2, m), and
        the Jacobian of the path (2, m, n).
        """
        path, slopes = self.evaluate(z, angles)
        rates = self._response.derivatives(self._find_point(z), angles)[1]
        tangents = rates / np.maximum(np.hypot(*rates), np.finfo(float).tiny)
        normals = np.array([-tangents[1], tangents[0]])
        offsets = self.place_points(z) - path
        lengths, sides = np.hypot(*offsets), (normals * offsets).sum(axis=0)
        signs = np.where(sides < 0, -1.0, 1.0)
        # at a corner the line to the nearest point is not along the normal of either side
        is_apart = lengths > TOUCHING * self.extent
        directions = np.where(is_apart, signs * offsets / np.where(is_apart, lengths, 1.0), normals)
        return signs * lengths, directions, slopes

    def _differentiate_points(self, z: Array) -> Array:
        """Return the Jacobian (2, m, n) of the points in the frame of the machine."""
        names = self.chosen.names
        slopes = np.zeros((*self.points.shape, len(z)))
        if FRAME[0] in names:
            turned = self.place_points(z) - self.find_pose(z)[1:, None]
            slopes[:, :, names.index(FRAME[0])] = np.array([-turned[1], turned[0]])
        for k, name in enumerate(FRAME[1:]):
            if name in names:
                slopes[k, :, names.index(name)] = 1 / factor_of(name)
        return slopes

    def _find_nearest(self, z: Array) -> Array:
        """Return the angles (m,) [rad] of the nearest points of the path.

        Each step of the samples within which a distance has a minimum is refined, unless it is too
        short to reach as near as the nearest sample.
        """
        point, points = self._find_point(z), self.place_points(z)
        grid = np.linspace(0, self.machine.turn, SAMPLES + 1)
        both = self._response.derivatives(point, grid)
        path, rates = (rows / self._factors[:, None] for rows in both)
        steps = np.hypot(*np.diff(path))
        angles = np.empty(points.shape[1])
        parts = -(-points.shape[1] * len(grid) // MOST_PAIRS)
        for part in np.array_split(np.arange(points.shape[1]), parts):
            offsets = path[:, None, :] - points[:, part, None]
            lengths = np.hypot(*offsets)
            slopes = (offsets * rates[:, None, :]).sum(axis=0)
            nearest = lengths.argmin(axis=1)
            shortest = lengths[np.arange(len(part)), nearest]
            bounds = np.minimum(lengths[:, :-1], lengths[:, 1:]) - steps
            is_minimum = (slopes[:, :-1] <= 0) & (slopes[:, 1:] > 0)
            rows, columns = np.nonzero(is_minimum & (bounds <= shortest[:, None]))
            ends = slopes[rows, columns], slopes[rows, columns + 1]
            brackets = grid[columns], grid[columns + 1]
            targets = points[:, part[rows]]
            roots = self._refine(point, targets, brackets, ends)
            refined = self._response.values(point, roots) / self._factors[:, None]
            distances = np.hypot(*(refined - targets))
            angles[part] = grid[nearest]
            # the nearest of a point's minima is assigned last
            order = np.argsort(-distances, kind="stable")
            order = order[distances[order] <= shortest[rows[order]]]
            angles[part[rows[order]]] = roots[order]
        return np.mod(angles, self.machine.turn)

    def _refine(
        self,
        point: DesignPoint,
        targets: Array,
        brackets: tuple[Array, Array],
        ends: tuple[Array, Array],
    ) -> Array:
        """Return the angles (k,) in brackets at which the line to targets (2, k) is square to the
        path.
        """
        scale = self._factors[:, None]

        def evaluate_slopes(phi: Array) -> tuple[Array, Array]:
            offsets = self._response.values(point, phi) / scale - targets
            first, second = (rows / scale for rows in self._response.rates(point, phi))
            bends = (first**2).sum(axis=0) + (offsets * second).sum(axis=0)
            return (offsets * first).sum(axis=0), bends

        return find_bracketed_roots(evaluate_slopes, *brackets, ends)
