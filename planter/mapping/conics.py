"""All common points of two conics in the projective plane, real and complex: elimination and companion matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planter.kernels import Array

Complex = NDArray[np.complex128]

_TURNS = 4
"""Turns of the plane that are tried: in a general one no two points lie above each other."""
_NEAR = 1e-6
"""Points that are closer are one point of higher multiplicity: a double root keeps half the digits."""
_REAL = 1e-9
_NONE = 1e-12
"""Share of a coefficient that is taken for rounding."""
_STEPS = 6


@dataclass(frozen=True)
class Common:
    """A common point (3,) of unit length, and how often it counts; a real one has real coordinates."""

    point: Complex
    multiplicity: int

    @property
    def is_real(self) -> bool:
        return bool(np.abs(self.point.imag).max() == 0)


def common_points(first: Array, second: Array) -> list[Common] | None:
    """The four common points of u^T Q u = 0 for two symmetric matrices (3, 3), counted with multiplicity.

    None where the conics have a line in common, or are one conic: they share a curve of points.
    """
    sizes = [float(np.linalg.norm(q)) for q in (first, second)]
    if min(sizes) == 0:
        return None
    q1, q2 = first / sizes[0], second / sizes[1]
    trials = [_solved(q1, q2, turn) for turn in _turns()]
    solutions = [points for points in trials if points is not None]
    return _clustered(min(solutions, key=lambda points: _misfit(q1, q2, points))) if solutions else None


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
    return np.array([q[1, 1]]), 2 * np.array([q[0, 1], q[1, 2]]), np.array([q[0, 0], 2 * q[0, 2], q[2, 2]])


def eliminant(q1: Array, q2: Array) -> Array:
    """Resultant (5,) of two conics in u2, a quartic in u1: (a c' - a' c)^2 - (a b' - a' b)(b c' - b' c)."""
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
    """Newton's steps in the chart of the largest coordinate; directions that a double root leaves open stay."""
    u = point / np.linalg.norm(point)
    free = np.delete(np.arange(3), int(np.argmax(np.abs(u))))
    for _ in range(_STEPS):
        slopes = 2 * np.array([q1 @ u, q2 @ u])[:, free]
        u[free] -= np.linalg.lstsq(slopes, np.array([u @ q1 @ u, u @ q2 @ u]), rcond=1e-9)[0]
    return _with_real_phase(u)


def _with_real_phase(u: Complex) -> Complex:
    largest = u[int(np.argmax(np.abs(u)))]
    return u / largest / np.linalg.norm(u / largest)


def _misfit(q1: Array, q2: Array, points: list[Complex]) -> float:
    """Largest residual; two points that fell onto each other where others are missing show in their mean."""
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
    mean = _with_real_phase(np.mean([u / (p / abs(p)) for u, p in zip(group, phases, strict=True)], axis=0))
    tolerance = _REAL if len(group) == 1 else _NEAR
    real = np.abs(mean.imag).max() < tolerance
    return Common(mean.real.astype(complex) if real else mean, len(group))
