"""More than five poses: dyads that pass them as closely as can be, in the sense of least squares."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from itertools import combinations
from math import comb

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.mapping import model
from planter.mapping.conics import common_points
from planter.mapping.dyads import CONDITIONS, Scale, Solution, distinct, null_space, solve

SUBSETS = 60
"""Sets of five poses whose own dyads are starts."""
MOST = 4
"""Dyads that are given, the best: as many as five poses may have."""
REACH = 1e3
"""Dyads are kept up to this radius in sizes of the poses; beyond it the circle has become a line."""
_SAME = 1e-6


def fit(poses: Array) -> Solution:
    """Local minima of the sum of squared misses over dyads, by radius, for poses (n, 3) with n > 5.

    The miss is the distance of the moving hinge from the circle. Starts are the dyads of five poses each. The complex
    roots are those of the null space that the poses leave least of.
    """
    from scipy.optimize import least_squares

    scale, own = Scale.of(poses), distinct(poses)
    inside = scale.inside(poses)
    found: list[tuple[float, Array]] = []
    for start in _starts(own, scale):
        fitted = least_squares(lambda v: _miss(inside, v)[0], start, lambda v: _miss(inside, v)[1], method="lm",
                               xtol=1e-15, ftol=1e-15, gtol=1e-15)  # fmt: skip
        new = all(np.abs(fitted.x - other).max() > _SAME * (1 + abs(fitted.x[4])) for _, other in found)
        if new and abs(fitted.x[4]) < REACH and np.abs(fitted.grad).max() < _SAME * (1 + abs(fitted.x[4])):
            found.append((float(fitted.cost), fitted.x))
    best = sorted(found, key=lambda one: one[0])[:MOST]
    basis, values = null_space(scale.inside(own))
    roots = common_points(*model.conics(basis)) or []
    dyads = sorted((scale.dyad(vector) for _, vector in best), key=lambda dyad: dyad.radius)
    return Solution(dyads, [], sum(r.multiplicity for r in roots if not r.is_real), 0, values)


def _starts(own: Array, scale: Scale) -> list[Array]:
    """Dyads (5,) of sets of five of the poses, in the size of all."""
    found = []
    for chosen in _subsets(len(own)):
        with suppress(ComputationError):  # five poses that nearly depend on each other are no start
            found += [scale.outside(dyad) for dyad in solve(own[list(chosen)]).dyads]
    return found


def _subsets(count: int) -> Iterable[Sequence[int]]:
    """All sets of five, or as many of them as are tried, drawn from a fixed seed."""
    if comb(count, CONDITIONS) <= SUBSETS:
        return combinations(range(count), CONDITIONS)
    rng = np.random.default_rng(5)
    return [rng.choice(count, CONDITIONS, replace=False).tolist() for _ in range(SUBSETS)]


def _miss(inside: Array, vector: Array) -> tuple[Array, Array]:
    """Distance of the hinges less the radius (n,), and its derivatives (n, 5)."""
    residual, slopes = model.squares(inside, vector)
    distance = np.sqrt(np.maximum(residual + vector[4] ** 2, np.finfo(float).tiny))
    return distance - vector[4], np.column_stack([slopes[:, :4] / (2 * distance[:, None]), -np.ones(len(inside))])
