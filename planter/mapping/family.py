"""Poses that leave a family of dyads: fewer than five different ones, or five that depend on each other.

A family with one free parameter (four poses: the circle-point and centre-point curves of Burmester) is cut by planes
of the null space that turn about a line of it; each cut holds up to four dyads, found as for five poses. Families with
more parameters are cut by planes drawn at random from a fixed seed. Five poses may also leave a family within one
plane, a curve that both conics share: it is cut by lines.
"""

from __future__ import annotations

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.mapping import model
from planter.mapping.dyads import (
    CONDITIONS,
    RANK,
    Dyad,
    Scale,
    Solution,
    Straight,
    distinct,
    dyad_of,
    null_space,
    on_plane,
)

CUTS = 90
"""Planes by which a family is cut."""
REACH = 20
"""Members are kept up to this many sizes of the poses."""


def family(poses: Array) -> tuple[list[Dyad], list[Straight]]:
    """Members of the family of dyads that pass all poses (n, 3): those with both hinges, by radius, and the others.

    Raises InputError for fewer than two different poses.
    """
    own = distinct(poses)
    if len(own) < 2:
        raise InputError(f"the {len(poses)} poses are one and the same, but at least two must differ")
    scale = Scale.of(poses)
    inside = scale.inside(own)
    basis, values = null_space(inside)
    if basis.shape[1] == 8 - CONDITIONS:
        found = [dyad_of(inside, p, scale) for cut in _lines(basis) for p in _on_line(cut)]
    else:
        cuts = [on_plane(inside, cut, scale, values) for cut in _planes(basis)]
        found = [member for cut in cuts for member in _members(cut)]
    dyads = [d for d in found if isinstance(d, Dyad) and max(d.radius, np.hypot(*d.point)) < REACH * scale.size]
    return sorted(dyads, key=lambda d: d.radius), [m for m in found if isinstance(m, Straight)]


def _members(solution: Solution) -> list[Dyad | Straight | None]:
    return [*solution.dyads, *solution.straights]


def _on_line(cut: Array) -> list[Array]:
    """Vectors (8,) of unit length on both conditions, of all sums of two vectors (8, 2)."""
    first, second = (q[:2, :2] for q in model.conics(np.column_stack([cut, np.zeros(8)])))
    leading, other = sorted((first, second), key=lambda q: -float(np.linalg.norm(q)))
    # In a line of general direction neither end of the axis is a root.
    roots = np.roots([leading[0, 0], 2 * leading[0, 1], leading[1, 1]])
    points = [np.array([root.real, 1]) / np.hypot(root.real, 1) for root in roots if abs(root.imag) < RANK]
    size = float(np.linalg.norm(leading))
    return [cut @ u for u in points if abs(u @ other @ u) < 1e-9 * size and abs(u @ leading @ u) < 1e-9 * size]


def parameters(poses: Array) -> int:
    """Number of free parameters of the dyads of some poses, by the rank of their conditions: 0 for five in general."""
    own = distinct(poses)
    return int(null_space(Scale.of(own).inside(own))[0].shape[1]) - (8 - CONDITIONS)


def _planes(basis: Array) -> list[Array]:
    """Three-dimensional subspaces (8, 3) of a null space (8, k), k > 3."""
    rng = np.random.default_rng(4)
    size = basis.shape[1]
    if size > 4:
        return [basis @ np.linalg.qr(rng.normal(size=(size, 3)))[0] for _ in range(CUTS)]
    turned = basis @ np.linalg.qr(rng.normal(size=(4, 4)))[0]
    return [np.column_stack([turned[:, :2], turned[:, 2:] @ direction]) for direction in _directions()]


def _lines(basis: Array) -> list[Array]:
    """Two-dimensional subspaces (8, 2) of a null space (8, 3), all through one point."""
    turned = basis @ np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    return [np.column_stack([turned[:, 0], turned[:, 1:] @ direction]) for direction in _directions()]


def _directions() -> Array:
    angles = np.pi * np.arange(CUTS) / CUTS
    return np.column_stack([np.cos(angles), np.sin(angles)])
