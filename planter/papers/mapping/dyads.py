"""From poses to dyads: null space, two conics, and all that a common point of them can be.

Kinematic mapping in the linear form of Sun and Wang (CN107654585B, equations (1) to (9)); see also
Ravani and Roth, Motion synthesis using kinematic mappings, 1983. Poses are (n, 3): x, y [m], angle
[rad]. Inside, lengths are in parts of the size of the poses about their middle, so that neither the
unit nor the place of the origin matters.

Fewer than five different poses, or five that depend on each other, leave a family of dyads. A
family with one free parameter (four poses: the circle-point and centre-point curves of Burmester)
is cut by planes of the null space that turn about a line of it; each cut holds up to four dyads,
computed as for five poses. Families with more parameters are cut by random planes with a fixed
seed. Five poses may also leave a family within one plane, a curve that both conics share: it is cut
by lines. More than five poses are passed in the sense of least squares.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
import scipy
from numpy.typing import NDArray

from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.numerics.arrays import unit_vector
from planter.papers.mapping import model
from planter.papers.mapping.results import Pair, StraightFound

Complex = NDArray[np.complex128]

_TURNS = 4
"""Turns of the plane that are tried: in a general one no two points lie above each other."""
_NEAR = 1e-6
"""Points that are closer are one point of higher multiplicity: a double root keeps half the
digits.
"""
_REAL = 1e-9
_NONE = 1e-12
"""Share of a coefficient that is taken for rounding."""
_CONIC_STEPS = 6


@dataclass(frozen=True)
class Common:
    """A common point (3,) of unit length, and how often it counts; a real one has real
    coordinates.
    """

    point: Complex
    multiplicity: int

    @property
    def is_real(self) -> bool:
        return bool(np.abs(self.point.imag).max() == 0)


def common_points(first: Array, second: Array) -> list[Common] | None:
    """The four common points of u^T Q u = 0 for two symmetric matrices (3, 3), counted with
    multiplicity.

    None where the conics have a line in common, or are one conic: they share a curve of points.
    """
    sizes = [float(np.linalg.norm(q)) for q in (first, second)]
    if min(sizes) == 0:
        return None
    q1, q2 = first / sizes[0], second / sizes[1]
    trials = [_solved(q1, q2, turn) for turn in _turns()]
    solutions = [points for points in trials if points is not None]
    return (
        _clustered(min(solutions, key=lambda points: _misfit(q1, q2, points)))
        if solutions
        else None
    )


def _turns() -> list[Array]:
    rng = np.random.default_rng(20190716)
    return [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(_TURNS)]


def _solved(q1: Array, q2: Array, turn: Array) -> list[Complex] | None:
    p1, p2 = (turn.T @ q @ turn for q in (q1, q2))
    quartic = eliminant(p1, p2)
    if abs(quartic[0]) <= _NONE:
        return None
    return [_polished(q1, q2, turn @ _lifted(p1, p2, root)) for root in np.roots(quartic)]


def _in_second(q: Array) -> tuple[Array, Array, Array]:
    """Coefficients of u2^2, u2 and 1 in a conic with u3 = 1, as polynomials in u1."""
    return (
        np.array([q[1, 1]]),
        2 * np.array([q[0, 1], q[1, 2]]),
        np.array([q[0, 0], 2 * q[0, 2], q[2, 2]]),
    )


def eliminant(q1: Array, q2: Array) -> Array:
    """Resultant (5,) of two conics in u2, a quartic in u1: (a c' - a' c)^2 - (a b' - a' b)(b c' -
    b' c).
    """
    (a1, b1, c1), (a2, b2, c2) = _in_second(q1), _in_second(q2)
    mixed = np.convolve(a1, c2) - np.convolve(a2, c1)
    leading = np.convolve(a1, b2) - np.convolve(a2, b1)
    last = np.convolve(b1, c2) - np.convolve(b2, c1)
    return np.convolve(mixed, mixed) - np.convolve(leading, last)


def _lifted(q1: Array, q2: Array, u1: complex) -> Complex:
    """The point above a root: Sylvester's matrix takes (u2^3, u2^2, u2, 1) to zero."""
    a, b = ([complex(np.polyval(p, u1)) for p in _in_second(q)] for q in (q1, q2))
    matrix = np.array([[*a, 0], [0, *a], [*b, 0], [0, *b]])
    powers = np.linalg.svd(matrix)[2][-1].conj()
    k = int(np.argmax(np.abs(powers[1:])))
    return np.array([u1, powers[k] / powers[k + 1], 1.0])


def _polished(q1: Array, q2: Array, point: Complex) -> Complex:
    """Newton's steps in the chart of the largest coordinate; directions that a double root leaves
    open stay.
    """
    u = point / np.linalg.norm(point)
    free = np.delete(np.arange(3), int(np.argmax(np.abs(u))))
    for _ in range(_CONIC_STEPS):
        slopes = 2 * np.array([q1 @ u, q2 @ u])[:, free]
        u[free] -= np.linalg.lstsq(slopes, np.array([u @ q1 @ u, u @ q2 @ u]), rcond=1e-9)[0]
    return _with_real_phase(u)


def _with_real_phase(u: Complex) -> Complex:
    largest = u[int(np.argmax(np.abs(u)))]
    return u / largest / np.linalg.norm(u / largest)


def _misfit(q1: Array, q2: Array, points: list[Complex]) -> float:
    """Largest residual; two points that fell onto each other where others are missing show in their
    mean.
    """
    residual = max(max(abs(u @ q1 @ u), abs(u @ q2 @ u)) for u in points)
    pairs = sum(1 for i, u in enumerate(points) for v in points[:i] if _distance(u, v) < _NEAR)
    return float(residual) + pairs


def _distance(u: Complex, v: Complex) -> float:
    """Sine of the angle between two rays."""
    return float(np.linalg.norm(v - u * np.vdot(u, v)))


def _clustered(points: list[Complex]) -> list[Common]:
    groups: list[list[Complex]] = []
    for point in points:
        neighbours = next((g for g in groups if _distance(g[0], point) < _NEAR), None)
        if neighbours is None:
            groups.append([point])
        else:
            neighbours.append(point)
    return [_mean(group) for group in groups]


def _mean(group: list[Complex]) -> Common:
    """The mean of a cluster, in which the halves of a split double root cancel."""
    phases = [np.vdot(group[0], u) for u in group]
    mean = _with_real_phase(
        np.mean([u / (p / abs(p)) for u, p in zip(group, phases, strict=True)], axis=0)
    )
    tolerance = _REAL if len(group) == 1 else _NEAR
    real = np.abs(mean.imag).max() < tolerance
    return Common(mean.real.astype(complex) if real else mean, len(group))


CONDITIONS = 5
"""Independent conditions that leave a finite number of dyads."""
RANK = 1e-12
"""Singular values below this share of the largest are taken for zero: the poses depend on each
other.
"""
STRAIGHT = 1e-8
"""Circles with a radius of more than 1/STRAIGHT sizes are straight lines: the sagitta is then below
rounding.
"""
PASSED = 1e-9
"""Largest miss of a pose, in parts of size and radius, that is no failure."""
_STEPS = 4
CUTS = 90
"""Planes by which a family is cut."""
FAMILY_REACH = 20
"""Largest radius of a member of a family, in sizes of the poses."""
SUBSETS = 60
"""Sets of five poses whose dyads are initial points of the least-squares search."""
MOST_DYADS = 4
"""Largest number of dyads of more than five poses: as many as five poses may have."""
FIT_REACH = 1e3
"""Largest radius of a dyad of more than five poses, in their size; beyond it the circle is a
line.
"""
_SAME_DYAD = 1e-6
"""Relative difference below which two local minima are one dyad."""


@dataclass(frozen=True)
class Dyad:
    """A point of the body, the centre of its circle and the radius [m]; a double root has
    multiplicity 2.
    """

    point: Array
    centre: Array
    radius: float
    multiplicity: int = 1

    @property
    def vector(self) -> Array:
        """x, y, X, Y, radius (5,), as the generated functions take it."""
        return np.array([*self.point, *self.centre, self.radius])

    def carrier_angles(self, poses: Array) -> Array:
        """Directions (n,) [rad] from the fixed to the moving hinge in poses (n, 3)."""
        dx, dy = (model.place_point(poses, self.point) - self.centre).T
        return np.arctan2(dy, dx)


@dataclass(frozen=True)
class Solution:
    """Dyads of poses by radius, those with a hinge at infinity, and the numbers of the other roots.

    `free` is the number of parameters of a family, if the poses leave one; then the other entries
    are empty. `orientations` counts roots that ask for nothing but a certain direction of the body.
    """

    dyads: list[Dyad]
    straights: list[StraightFound]
    complex_roots: int
    orientations: int
    singular_values: Array
    free: int = 0


@dataclass(frozen=True)
class Scale:
    """Middle [m] and size [m] of the poses."""

    middle: Array
    size: float

    @classmethod
    def from_poses(cls, poses: Array) -> Scale:
        """Return the middle and the size of poses (n, 3); the size is 1 m where only the angles
        differ.
        """
        middle = poses[:, :2].mean(axis=0)
        size = float(np.hypot(*(poses[:, :2] - middle).T).max())
        return cls(middle, size if size > 0 else 1.0)

    def normalise(self, poses: Array) -> Array:
        """Return poses (n, 3) about their middle, in parts of their size."""
        return np.column_stack([(poses[:, :2] - self.middle) / self.size, poses[:, 2]])

    def restore_dyad(self, vector: Array, multiplicity: int = 1) -> Dyad:
        """Return the dyad [m] of a vector (5,) in parts of the size."""
        point, centre = vector[:2] * self.size, vector[2:4] * self.size + self.middle
        return Dyad(point, centre, float(abs(vector[4]) * self.size), multiplicity)

    def normalise_dyad(self, dyad: Dyad) -> Array:
        """Return a dyad (5,) about the middle of the poses, in parts of their size."""
        return np.array([*dyad.point, *(dyad.centre - self.middle), dyad.radius]) / self.size

    def restore_line(self, kind: str, line: Array, multiplicity: int) -> StraightFound:
        """Return the dyad with a hinge at infinity of point, normal and offset (5,) in parts of
        the size.
        """
        length = float(np.hypot(*line[2:4]))
        normal, offset = line[2:4] / length, line[4] / length * self.size
        if kind == "slider":
            offset, point = offset + normal @ self.middle, line[:2] * self.size
        else:
            point = line[:2] * self.size + self.middle
        offset_mm = 1e3 * float(offset)
        return StraightFound(kind, to_pair(point * 1e3), to_pair(normal), offset_mm, multiplicity)


def to_pair(place: Array) -> Pair:
    """Return the two coordinates of a place (2,)."""
    x, y = place
    return float(x), float(y)


def distinct(poses: Array) -> Array:
    """The poses (n, 3) without repetitions; angles that differ by whole turns are one."""
    inside = Scale.from_poses(poses).normalise(poses)
    marks = np.column_stack([inside[:, :2], np.cos(inside[:, 2]), np.sin(inside[:, 2])])
    chosen: list[int] = []
    for k, mark in enumerate(marks):
        if all(np.abs(mark - marks[j]).max() > RANK for j in chosen):
            chosen.append(k)
    return poses[chosen]


def null_space(poses: Array) -> tuple[Array, Array]:
    """Basis (8, k) of the null space of the linear system of poses as they are, and its singular
    values.

    More than five poses leave no null space; then the basis is what they leave least of.
    """
    values, vectors = np.linalg.svd(model.rows(poses))[1:]
    rank = int(np.sum(values[:CONDITIONS] > RANK * values[0]))
    return vectors[rank:].T if rank < CONDITIONS else vectors[CONDITIONS:].T, values


def solve_dyads(poses: Array) -> Solution:
    """Return all dyads of five poses.

    Raises ComputationError if a root does not pass the poses.
    """
    scale, separate = Scale.from_poses(poses), distinct(poses)
    inside = scale.normalise(separate)
    plane, values = null_space(inside)
    if plane.shape[1] > 3:
        return Solution([], [], 0, 0, values, free=plane.shape[1] - 3)
    return on_plane(inside, plane, scale, values)


def on_plane(inside: Array, basis: Array, scale: Scale, values: Array) -> Solution:
    """Return the dyads of normalised poses whose coefficients are sums of three vectors (8, 3)."""
    common = common_points(*model.conics(basis))
    if common is None:
        return Solution([], [], 0, 0, values, free=1)
    real = [(root, basis @ root.point.real) for root in common if root.is_real]
    dyads, straights, orientations = [], [], 0
    for root, p in real:
        member = build_dyad(inside, p / np.linalg.norm(p), scale, root.multiplicity)
        if isinstance(member, Dyad):
            dyads.append(member)
        elif member is not None:
            straights.append(member)
        else:
            orientations += root.multiplicity
    complex_roots = sum(root.multiplicity for root in common if not root.is_real)
    return Solution(
        sorted(dyads, key=lambda d: d.radius), straights, complex_roots, orientations, values
    )


def build_dyad(
    inside: Array, p: Array, scale: Scale, multiplicity: int = 1
) -> Dyad | StraightFound | None:
    """Return the dyad of a real unit vector (8,) of the null space; None for a direction of the
    body alone.
    """
    fixed, moving = float(np.hypot(p[3], p[4])), float(np.hypot(p[1], p[2]))
    if abs(p[0]) > STRAIGHT * max(fixed, moving):
        vector = polish_dyad(inside, model.place_dyad("dyad", p))
        _check(inside, vector)
        return scale.restore_dyad(vector, multiplicity)
    if max(fixed, moving) <= STRAIGHT:
        return None
    if fixed >= moving:
        return scale.restore_line("slider", model.place_dyad("slider", p), multiplicity)
    return scale.restore_line("swinging line", model.place_dyad("swinging", p), multiplicity)


def polish_dyad(inside: Array, hinges: Array) -> Array:
    """Dyad (5,) by Gauss-Newton steps from its hinges (4,), the best of them: rounding is that of
    the poses alone.
    """
    away = model.place_point(inside, hinges[:2]) - hinges[2:]
    best = vector = np.array([*hinges, np.hypot(*away.T).mean()])
    for _ in range(_STEPS):
        residual, slopes = model.squares(inside, vector)
        sizes = np.linalg.norm(slopes, axis=0)
        sizes[sizes == 0] = 1
        vector = vector - np.linalg.lstsq(slopes / sizes, residual, rcond=1e-13)[0] / sizes
        if misses(inside, vector).max() < misses(inside, best).max():
            best = vector
    return best


def misses(poses: Array, dyad: Array) -> Array:
    """Return the distance of the moving hinge from its circle in each pose (n,), for a dyad
    (5,).
    """
    return np.abs(np.hypot(*(model.place_point(poses, dyad[:2]) - dyad[2:4]).T) - abs(dyad[4]))


def _check(inside: Array, vector: Array) -> None:
    worst = float(misses(inside, vector).max())
    if not worst <= PASSED * (1 + abs(vector[4])):
        raise ComputationError(
            f"a dyad misses a pose by {worst:.3g} of the size of the poses: the poses are too "
            "close to each other, or to poses that leave a whole family of dyads"
        )


def find_family(poses: Array) -> tuple[list[Dyad], list[StraightFound]]:
    """Return members of the family of dyads that pass all poses (n, 3): with both hinges by radius,
    and the others.

    Raises InputError if fewer than two poses differ.
    """
    separate = distinct(poses)
    if len(separate) < 2:
        raise InputError(
            f"the {len(poses)} poses are one and the same, but at least two must differ"
        )
    scale = Scale.from_poses(poses)
    inside = scale.normalise(separate)
    basis, values = null_space(inside)
    members: list[Dyad | StraightFound | None]
    if basis.shape[1] == 8 - CONDITIONS:
        members = [build_dyad(inside, p, scale) for cut in _lines(basis) for p in _on_line(cut)]
    else:
        members = []
        for plane in _planes(basis):
            cut = on_plane(inside, plane, scale, values)
            members += cut.dyads
            members += cut.straights
    reach = FAMILY_REACH * scale.size
    dyads = [
        d for d in members if isinstance(d, Dyad) and max(d.radius, np.hypot(*d.point)) < reach
    ]
    return sorted(dyads, key=lambda d: d.radius), [
        m for m in members if isinstance(m, StraightFound)
    ]


def _on_line(cut: Array) -> list[Array]:
    """Return the unit vectors (8,) on both conditions among all sums of two vectors (8, 2)."""
    first, second = (q[:2, :2] for q in model.conics(np.column_stack([cut, np.zeros(8)])))
    leading, other = sorted((first, second), key=lambda q: -float(np.linalg.norm(q)))
    # In a line of general direction neither end of the axis is a root.
    roots = np.roots([leading[0, 0], 2 * leading[0, 1], leading[1, 1]])
    points = [
        np.array([root.real, 1]) / np.hypot(root.real, 1) for root in roots if abs(root.imag) < RANK
    ]
    size = float(np.linalg.norm(leading))
    return [
        cut @ u
        for u in points
        if abs(u @ other @ u) < 1e-9 * size and abs(u @ leading @ u) < 1e-9 * size
    ]


def count_free_parameters(poses: Array) -> int:
    """Return the number of free parameters of the dyads of poses (n, 3), by rank: 0 for five poses
    in general.
    """
    separate = distinct(poses)
    return int(null_space(Scale.from_poses(separate).normalise(separate))[0].shape[1]) - (
        8 - CONDITIONS
    )


def _planes(basis: Array) -> list[Array]:
    """Three-dimensional subspaces (8, 3) of a null space (8, k), k > 3."""
    rng = np.random.default_rng(4)
    size = basis.shape[1]
    if size > 4:
        return [basis @ np.linalg.qr(rng.normal(size=(size, 3)))[0] for _ in range(CUTS)]
    turned = basis @ np.linalg.qr(rng.normal(size=(4, 4)))[0]
    return [
        np.column_stack([turned[:, :2], turned[:, 2:] @ direction]) for direction in _directions()
    ]


def _lines(basis: Array) -> list[Array]:
    """Two-dimensional subspaces (8, 2) of a null space (8, 3), all through one point."""
    turned = basis @ np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    return [
        np.column_stack([turned[:, 0], turned[:, 1:] @ direction]) for direction in _directions()
    ]


def _directions() -> Array:
    angles = np.pi * np.arange(CUTS) / CUTS
    return unit_vector(angles).T


def fit_dyads(poses: Array) -> Solution:
    """Return the local minima of the sum of squared misses over dyads, by radius, for poses (n, 3)
    with n > 5.

    The miss is the distance of the moving hinge from the circle. Starts are the dyads of five poses
    each. The complex roots are those of the three singular vectors with the smallest values.
    """

    scale, separate = Scale.from_poses(poses), distinct(poses)
    inside = scale.normalise(poses)
    minima: list[tuple[float, Array]] = []
    for start in _starts(separate, scale):
        fitted = scipy.optimize.least_squares(
            lambda v: _miss(inside, v)[0],
            start,
            lambda v: _miss(inside, v)[1],
            method="lm",
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
        )
        new = all(
            np.abs(fitted.x - other).max() > _SAME_DYAD * (1 + abs(fitted.x[4]))
            for _, other in minima
        )
        if (
            new
            and abs(fitted.x[4]) < FIT_REACH
            and np.abs(fitted.grad).max() < _SAME_DYAD * (1 + abs(fitted.x[4]))
        ):
            minima.append((float(fitted.cost), fitted.x))
    best = sorted(minima, key=lambda minimum: minimum[0])[:MOST_DYADS]
    basis, values = null_space(scale.normalise(separate))
    roots = common_points(*model.conics(basis)) or []
    dyads = sorted((scale.restore_dyad(vector) for _, vector in best), key=lambda dyad: dyad.radius)
    return Solution(dyads, [], sum(r.multiplicity for r in roots if not r.is_real), 0, values)


def _starts(separate: Array, scale: Scale) -> list[Array]:
    """Return the normalised dyads (5,) of sets of five of the poses."""
    starts = []
    for chosen in _subsets(len(separate)):
        with suppress(
            ComputationError
        ):  # five poses that nearly depend on each other give no initial point
            starts += [
                scale.normalise_dyad(dyad) for dyad in solve_dyads(separate[list(chosen)]).dyads
            ]
    return starts


def _subsets(count: int) -> Iterable[Sequence[int]]:
    """All sets of five, or a random choice of SUBSETS of them with a fixed seed."""
    if comb(count, CONDITIONS) <= SUBSETS:
        return combinations(range(count), CONDITIONS)
    rng = np.random.default_rng(5)
    return [rng.choice(count, CONDITIONS, replace=False).tolist() for _ in range(SUBSETS)]


def _miss(inside: Array, vector: Array) -> tuple[Array, Array]:
    """Distance of the hinges less the radius (n,), and its derivatives (n, 5)."""
    residual, slopes = model.squares(inside, vector)
    distance = np.sqrt(np.maximum(residual + vector[4] ** 2, np.finfo(float).tiny))
    return distance - vector[4], np.column_stack(
        [slopes[:, :4] / (2 * distance[:, None]), -np.ones(len(inside))]
    )
