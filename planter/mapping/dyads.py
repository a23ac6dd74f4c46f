"""From poses to dyads: null space, two conics, and all that a common point of them can be.

Kinematic mapping in the linear form of Sun and Wang (CN107654585B, equations (1) to (9)); see also Ravani and Roth,
Motion synthesis using kinematic mappings, 1983. Poses are (n, 3): x, y [m], angle [rad]. Inside, lengths are in parts
of the poses' own size about their middle, so that no unit and no place of the origin matters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.mapping import model
from planter.mapping.conics import common_points

CONDITIONS = 5
"""Independent conditions that leave a finite number of dyads."""
RANK = 1e-12
"""Singular values below this share of the largest are taken for zero: the poses depend on each other."""
STRAIGHT = 1e-8
"""Circles with a radius of more than 1/STRAIGHT sizes are straight lines: the sagitta is then below rounding."""
PASSED = 1e-9
"""Largest miss of a pose, in parts of size and radius, that is no failure."""
_STEPS = 4

Kind = Literal["slider", "swinging line"]


@dataclass(frozen=True)
class Dyad:
    """A point of the body, the centre of its circle and the radius [m]; a double root has multiplicity 2."""

    point: Array
    centre: Array
    radius: float
    multiplicity: int = 1

    @property
    def vector(self) -> Array:
        """x, y, X, Y, radius (5,), as the generated functions take it."""
        return np.array([*self.point, *self.centre, self.radius])


@dataclass(frozen=True)
class Straight:
    """A dyad with a hinge at infinity.

    A slider: a `point` of the body stays on the line `normal . (X, Y) = offset` [m] of the fixed frame. A swinging
    line: the line `normal . (x, y) = offset` of the body stays on a `point` of the fixed frame.
    """

    kind: Kind
    point: Array
    normal: Array
    offset: float
    multiplicity: int = 1


@dataclass(frozen=True)
class Solution:
    """What the poses allow: dyads by radius, those with a hinge at infinity, and how many more roots there are.

    `free` is the number of parameters of a family, if the poses leave one; then nothing else is found here.
    `orientations` counts roots that ask for nothing but a certain direction of the body.
    """

    dyads: list[Dyad]
    straights: list[Straight]
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
    def of(cls, poses: Array) -> Scale:
        """A size of zero is kept from doing harm: then only the angles differ, and any unit will do."""
        middle = poses[:, :2].mean(axis=0)
        size = float(np.hypot(*(poses[:, :2] - middle).T).max())
        return cls(middle, size if size > 0 else 1.0)

    def inside(self, poses: Array) -> Array:
        return np.column_stack([(poses[:, :2] - self.middle) / self.size, poses[:, 2]])

    def dyad(self, vector: Array, multiplicity: int = 1) -> Dyad:
        point, centre = vector[:2] * self.size, vector[2:4] * self.size + self.middle
        return Dyad(point, centre, float(abs(vector[4]) * self.size), multiplicity)

    def outside(self, dyad: Dyad) -> Array:
        """The dyad (5,) in the size and about the middle of the poses."""
        return np.array([*dyad.point, *(dyad.centre - self.middle), dyad.radius]) / self.size

    def straight(self, kind: Kind, line: Array, multiplicity: int) -> Straight:
        length = float(np.hypot(*line[2:4]))
        normal, offset = line[2:4] / length, line[4] / length * self.size
        if kind == "slider":
            offset, point = offset + normal @ self.middle, line[:2] * self.size
        else:
            point = line[:2] * self.size + self.middle
        return Straight(kind, point, normal, float(offset), multiplicity)


def distinct(poses: Array) -> Array:
    """The poses (n, 3) without repetitions; angles that differ by whole turns are one."""
    inside = Scale.of(poses).inside(poses)
    marks = np.column_stack([inside[:, :2], np.cos(inside[:, 2]), np.sin(inside[:, 2])])
    chosen: list[int] = []
    for k, mark in enumerate(marks):
        if all(np.abs(mark - marks[j]).max() > RANK for j in chosen):
            chosen.append(k)
    return poses[chosen]


def null_space(poses: Array) -> tuple[Array, Array]:
    """Basis (8, k) of the null space of the linear system of poses as they are, and its singular values.

    More than five poses leave no null space; then the basis is what they leave least of.
    """
    values, vectors = np.linalg.svd(model.rows(poses))[1:]
    rank = int(np.sum(values[:CONDITIONS] > RANK * values[0]))
    return vectors[rank:].T if rank < CONDITIONS else vectors[CONDITIONS:].T, values


def solve(poses: Array, basis: Array | None = None) -> Solution:
    """All dyads of five poses; `basis` (8, 3) may replace that of the null space, in the poses' own size and middle.

    Raises ComputationError where a root was found that does not pass the poses.
    """
    scale, separate = Scale.of(poses), distinct(poses)
    inside = scale.inside(separate)
    plane, values = null_space(inside)
    plane = plane if basis is None else basis
    if plane.shape[1] > 3:
        return Solution([], [], 0, 0, values, free=plane.shape[1] - 3)
    return on_plane(inside, plane, scale, values)


def on_plane(inside: Array, basis: Array, scale: Scale, values: Array) -> Solution:
    """The dyads of poses, given in their own size, whose coefficients are sums of three vectors (8, 3)."""
    common = common_points(*model.conics(basis))
    if common is None:
        return Solution([], [], 0, 0, values, free=1)
    real = [(root, basis @ root.point.real) for root in common if root.is_real]
    dyads, straights, orientations = [], [], 0
    for root, p in real:
        member = dyad_of(inside, p / np.linalg.norm(p), scale, root.multiplicity)
        if isinstance(member, Dyad):
            dyads.append(member)
        elif member is not None:
            straights.append(member)
        else:
            orientations += root.multiplicity
    complex_roots = sum(root.multiplicity for root in common if not root.is_real)
    return Solution(sorted(dyads, key=lambda d: d.radius), straights, complex_roots, orientations, values)


def dyad_of(inside: Array, p: Array, scale: Scale, multiplicity: int = 1) -> Dyad | Straight | None:
    """What a real vector of the null space, of unit length, stands for; None for a direction of the body alone."""
    fixed, moving = float(np.hypot(p[3], p[4])), float(np.hypot(p[1], p[2]))
    if abs(p[0]) > STRAIGHT * max(fixed, moving):
        vector = polished(inside, model.hinges_of(p))
        _check(inside, vector)
        return scale.dyad(vector, multiplicity)
    if max(fixed, moving) <= STRAIGHT:
        return None
    if fixed >= moving:
        return scale.straight("slider", model.slider_of(p), multiplicity)
    return scale.straight("swinging line", model.swinging_of(p), multiplicity)


def polished(inside: Array, hinges: Array) -> Array:
    """Dyad (5,) by Gauss-Newton steps from its hinges (4,), the best of them: rounding is that of the poses alone."""
    away = model.placed(inside, hinges[:2]) - hinges[2:]
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
    """Return the distance of the moving hinge from its circle in each pose (n,), for a dyad (5,)."""
    return np.abs(np.hypot(*(model.placed(poses, dyad[:2]) - dyad[2:4]).T) - abs(dyad[4]))


def _check(inside: Array, vector: Array) -> None:
    worst = float(misses(inside, vector).max())
    if not worst <= PASSED * (1 + abs(vector[4])):
        raise ComputationError(
            f"a dyad was found that misses a pose by {worst:.3g} of the poses' size: the poses are too close to each "
            "other, or to poses that leave a whole family of dyads"
        )
