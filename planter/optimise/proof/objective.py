"""Weighted range and spread of a response over a box: bounds of the objective and of its slopes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.proof.balls import Ball
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet

MOST_PAIRS = 60
"""Pairs of samples, of a possible maximum and a possible minimum, whose differences are each formed."""


@dataclass(frozen=True)
class Bounds:
    """Of an objective over a box: `least` below all its values, `reached` above that at the centre.

    slopes (p,) enclose its derivatives, those of one side at kinks; `looseness` (p,) is what each parameter's width
    costs in these bounds.
    """

    least: float
    reached: float
    slopes: Ball
    looseness: Array


def bounds(force: Jet, weight: float, outer: Callable[[Jet], Jet]) -> Bounds:
    """Of weight * (largest sample - least sample) + outer(population variance of the samples).

    The largest sample is one of those that may exceed all others somewhere in the box; so its slopes are among theirs.
    """
    spread = outer(_variance(force))
    high, low = _extreme(force), _extreme(-force)
    if len(high) * len(low) <= MOST_PAIRS:
        i, j = (found.ravel() for found in np.meshgrid(high, low))
        pairs = (force.taken(i) - force.taken(j)) * weight + spread
        slopes, least = pairs.gradient[ANYWHERE].spread(), float(pairs.least.max())
    else:
        centre = force.value[CENTRE].mid
        i, j = (np.array([find(centre)]) for find in (np.argmax, np.argmin))
        pairs = (force.taken(i) - force.taken(j)) * weight + spread
        rows = [pairs.over(force.felt) if pairs.felt != force.felt else pairs]
        along = [force.taken(found).gradient[ANYWHERE].spread() for found in (high, low)]
        slopes = Ball.exact(weight) * (along[0] - along[1]) + spread.over(force.felt).gradient[ANYWHERE][:, 0]
        least = float(rows[0].least.max())
    values = force.value[CENTRE]
    reached = (
        Ball.exact(weight) * (Ball.exact(values.high.max()) - Ball.exact(values.low.min())) + spread.value[CENTRE][0]
    )
    half = force.space.half[list(pairs.felt)]
    bent = (half[:, None] * (force.space.reach(pairs.felt) @ pairs.hessian.most)).max(axis=-1)
    return _whole(force, pairs, Bounds(least, float(reached.high), slopes, bent + half * slopes.rad))


def _whole(force: Jet, pairs: Jet, found: Bounds) -> Bounds:
    """Slopes and looseness for all parameters, zero for those of no width."""
    size, felt = len(force.space.lower), list(pairs.felt)
    mid, rad, loose = np.zeros(size), np.zeros(size), np.zeros(size)
    mid[felt], rad[felt], loose[felt] = found.slopes.mid, found.slopes.rad, found.looseness
    return Bounds(found.least, found.reached, Ball(mid, rad), loose)


def _variance(force: Jet) -> Jet:
    """Population variance over the lanes."""
    about = force - force.mean()
    found = (about**2).mean()
    return found.holding(found.value.nonnegative())


def _extreme(force: Jet) -> Integers:
    """Lanes that may be the largest somewhere in the box: those not below the largest at its centre everywhere."""
    largest = force.taken([int(np.argmax(force.value[CENTRE].mid))])
    found: Integers = np.flatnonzero((largest - force).least <= 0)
    return found
