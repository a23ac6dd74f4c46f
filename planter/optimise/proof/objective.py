"""Sums of measures of samples over a box: bounds of the objective and of its slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.proof.balls import Ball
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet

MOST_CHOICES = 60
"""Choices of samples, one for each extreme, whose sums are each formed."""


@dataclass(frozen=True)
class Extreme:
    """The largest of the samples of a jet, or the least."""

    samples: Jet
    largest: bool = True


@dataclass(frozen=True)
class Bounds:
    """Of an objective over a box: `least` below all its values, `reached` above that at the centre.

    slopes (p,) enclose its derivatives, those of one side at kinks; `looseness` (p,) is what each parameter's width
    costs in these bounds. Slopes say nothing of an objective that `may_jump`,
    and none may be used where but a part of it is bounded.
    """

    least: float
    reached: float
    slopes: Ball
    looseness: Array
    may_jump: bool = False


def bounds(smooth: Jet, extremes: Sequence[Extreme]) -> Bounds:
    """Return bounds of a smooth part (one lane) plus extremes of samples.

    An extreme is one of the samples that may be it somewhere in the box, so its slopes are among theirs. No largest
    sample is below any one of them: where there are many choices, that at the centre stands for all.
    """
    candidates = [_candidates(extreme) for extreme in extremes]
    centre = [
        np.array([(np.argmax if e.largest else np.argmin)(e.samples.value[CENTRE].mid)]) if e.largest else own
        for e, own in zip(extremes, candidates, strict=True)
    ]
    every = prod(len(lanes) for lanes in candidates) <= MOST_CHOICES
    chosen = candidates if every else centre
    total = smooth
    for extreme, lanes in zip(extremes, np.meshgrid(*chosen, indexing="ij"), strict=True):
        total = total + extreme.samples.taken(lanes.ravel())
    if not extremes:
        total = total.taken([0])
    slopes = total.gradient[ANYWHERE].spread()
    if not every:
        felt = tuple(sorted({*total.felt, *(k for extreme in extremes for k in extreme.samples.felt)}))
        total = total.over(felt)
        slopes = smooth.over(felt).gradient[ANYWHERE][:, 0]
        for extreme, lanes in zip(extremes, candidates, strict=True):
            slopes = slopes + extreme.samples.over(felt).taken(lanes).gradient[ANYWHERE].spread()
    least = total.least.reshape([len(lanes) for lanes in chosen])
    falling = tuple(axis for axis, extreme in enumerate(extremes) if not extreme.largest)
    reached = smooth.value[CENTRE][0]
    for extreme in extremes:
        high = extreme.samples.value[CENTRE].high
        reached = reached + Ball.exact(high.max() if extreme.largest else high.min())
    space = smooth.space
    half = space.half[list(total.felt)]
    bent = (half * space.reach(total.felt, total.hessian.most)).max(axis=-1)
    found = Bounds(float(least.min(axis=falling).max()), float(reached.high), slopes, bent + half[:, 0] * slopes.rad)
    return _whole(total, found)


def _whole(total: Jet, found: Bounds) -> Bounds:
    """Slopes and looseness for all parameters, zero for those of no width."""
    size, felt = len(total.space.lower), list(total.felt)
    mid, rad, loose = np.zeros(size), np.zeros(size), np.zeros(size)
    mid[felt], rad[felt], loose[felt] = found.slopes.mid, found.slopes.rad, found.looseness
    return Bounds(found.least, found.reached, Ball(mid, rad), loose, total.space.may_jump)


def variance(samples: Jet) -> Jet:
    """Return the population variance over the lanes."""
    return mean_square(samples - samples.mean())


def mean_square(samples: Jet) -> Jet:
    """Return the mean of squares over the lanes."""
    value, mean = samples.value.square().sum(), (samples**2).mean()
    share = Ball(value.mid[:, None], value.rad[:, None]) / Ball.exact(float(samples.lanes))
    low, high = np.maximum(mean.value.low, share.low), np.minimum(mean.value.high, share.high)
    return mean.holding(Ball.between(low, high))


def _candidates(extreme: Extreme) -> Integers:
    """Return lanes that may be the extreme somewhere in the box: those that the one at the centre does not exclude."""
    jet = extreme.samples if extreme.largest else -extreme.samples
    largest = jet.taken([int(np.argmax(jet.value[CENTRE].mid))])
    lanes: Integers = np.flatnonzero((largest - jet).least <= 0)
    return lanes
