"""Elementary functions of jets under NumPy's names: generated array code as enclosures over a box of designs.

Quantities over a box of designs: an enclosure of each of their samples over a turn.

Sums of measures of samples over a box: bounds of the objective and of its slopes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import prod
from typing import Any, Protocol

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.proof.intervals import LIBM, Ball, Branches, U, Unbounded, select_balls
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space


class JetNamespace:
    """What generated array code takes as `xp`, in one box."""

    def __init__(self, space: Space) -> None:
        self.space = space

    @cached_property
    def pi(self) -> Jet:
        return self.space.constant(PI)

    def where(self, condition: Any, yes: Any, no: Any) -> Any:
        """Return an enclosure of the selection by a condition."""
        if isinstance(yes, Jet):
            return yes.where(condition, no)
        if isinstance(no, Jet):
            return no.where(np.logical_not(condition), yes)
        return self.space.constant(Ball.exact(np.where(condition, yes, no)))

    def absolute(self, x: Any) -> Any:
        """Return an enclosure of the absolute value."""
        return x.where(x.reaches(0), -x) if isinstance(x, Jet) else abs(x)

    def maximum(self, one: Any, two: Any) -> Jet:
        """Return an enclosure of the larger of two quantities."""
        first = self.space.lift(one)
        return first.where(first.reaches(two), two)

    def minimum(self, one: Any, two: Any) -> Jet:
        """Return an enclosure of the smaller of two quantities."""
        first = self.space.lift(one)
        return first.where(self.space.lift(two).reaches(first), two)

    def sign(self, x: Any) -> Any:
        """Return an enclosure of the sign."""
        return self.where(x > 0, 1, self.where(x < 0, -1, 0))

    logical_or, logical_and, logical_not = np.logical_or, np.logical_and, np.logical_not

    def divide(self, one: Any, two: Any) -> Jet:
        """Return an enclosure of the quotient."""
        return self.space.lift(one) / two

    def sin(self, x: Any) -> Jet:
        """Return an enclosure of the sine."""
        return self.space.lift(x).sin()

    def cos(self, x: Any) -> Jet:
        """Return an enclosure of the cosine."""
        return self.space.lift(x).cos()

    def tan(self, x: Any) -> Jet:
        """Return an enclosure of the tangent."""
        return self.sin(x) / self.cos(x)

    def sqrt(self, x: Any) -> Jet:
        """Return an enclosure of the square root."""
        return self.space.lift(x).sqrt()

    def exp(self, x: Any) -> Jet:
        """Return an enclosure of the exponential."""
        return self.space.lift(x).exp()

    def log(self, x: Any) -> Jet:
        """Return an enclosure of the natural logarithm."""
        return self.space.lift(x).log()

    def arctan(self, x: Any) -> Jet:
        """Return an enclosure of the arc tangent."""
        return self.space.lift(x).arctan()

    def arcsin(self, x: Any) -> Jet:
        """Return an enclosure of the arc sine."""
        return self.arctan(x / self.sqrt(1 - x**2))

    def arccos(self, x: Any) -> Jet:
        """Return an enclosure of the arc cosine."""
        return self.arctan2(self.sqrt(1 - x**2), x)

    def arctan2(self, y: Any, x: Any) -> Jet:
        """Return the angle of a point: that of a fixed direction near it, and the angle from there.

        NaN in lanes where the point may be the origin, or where the angle may jump by a turn. Raises Unbounded where
        that is so in every lane.
        """
        y, x = self.space.lift(y), self.space.lift(x)
        high, wide = y.value[ANYWHERE], x.value[ANYWHERE]
        is_apart = (wide.low > 0) | (high.low > 0) | (high.high < 0)
        if not is_apart.any():
            raise Unbounded("an angle may jump by a turn")
        angle = np.arctan2(y.value.mid[CENTRE], x.value.mid[CENTRE])
        cos, sin = np.cos(angle), np.sin(angle)
        along, across = x * cos + y * sin, y * cos - x * sin
        direction = np.arctan2(sin, cos)
        fixed = Ball(np.where(is_apart, direction, np.nan), np.full_like(direction, 2 * LIBM))
        return (across / along).arctan() + self.space.constant(fixed)

    @staticmethod
    def polyval(coefficients: Sequence[float], x: Jet) -> Jet:
        """The sum of a_k x^k, highest power first, as Taylor's polynomial about the centre: little in it cancels."""
        return x.polynomial(coefficients)

    @staticmethod
    def floor(x: Jet) -> Jet:
        """Return an enclosure of the largest integers below the values."""
        return x.floor()


PI = Ball(np.array([np.pi]), np.array([2 * U]))
"""The number pi; the double below it is closer than 2^-52."""


MAX_LANES = 8
"""Pieces of a lane, on average, above which a box is too wide to follow them."""


class EnclosedResponse(Protocol):
    """Quantities F(phi, x): the sums over `offsets` [turns] of shares at phi + each, `period` [turns] that of all.

    `is_continuous` says that they do not jump over designs, whatever their code asks.
    """

    @property
    def offsets(self) -> tuple[Fraction, ...]: ...
    @property
    def period(self) -> Fraction: ...
    @property
    def is_continuous(self) -> bool: ...

    def follow(self, space: Space, phi: Ball) -> Callable[[JetNamespace, Integers], Sequence[Jet]]:
        """Return the shares over a box as a function of lanes, of angles phi (lanes,) [rad].

        They are smooth but where they ask the space of the function's first argument.
        """

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return whether at some of the angles phi (lanes,) [rad] no design of a box [lower, upper] (p,) counts."""


def enclose_samples(response: EnclosedResponse, space: Space, count: int) -> list[Jet]:
    """Each quantity at phi = 2 pi i / count over a box, a lane for each of the angles that differ by the period."""
    return enclose_at(response, space, list_samples(response, count))


def list_samples(response: EnclosedResponse, count: int) -> list[Fraction]:
    """Return those of the angles i / count [turns] that differ by the period."""
    whole = (count * response.period).denominator == 1
    return [Fraction(i, count) for i in range(int(count * response.period) if whole else count)]


def enclose_at(response: EnclosedResponse, space: Space, turns: Sequence[Fraction]) -> list[Jet]:
    """Return each quantity over a box at angles [turns], a lane for each."""
    count = len(turns)
    phi = list_angles([turn + offset for offset in response.offsets for turn in turns])
    sides, shares = range(1, len(response.offsets)), _enclose_pieces(response, space, phi)
    space.jumping = np.asarray(space.jumping.reshape(-1, count).any(axis=0))
    return [
        sum((share.taken(slice(k * count, (k + 1) * count)) for k in sides), share.taken(slice(0, count)))
        for share in shares
    ]


def list_angles(turns: Sequence[Fraction]) -> Ball:
    """Return angles [rad] for angles in turns."""
    share = np.array([float(2 * turn) for turn in turns])
    return PI * Ball(share, U * np.abs(share))


def _enclose_pieces(response: EnclosedResponse, space: Space, phi: Ball) -> list[Jet]:
    """The shares at angles (lanes,): around all pieces of each."""
    lanes, script = np.arange(len(phi.mid)), np.empty((0, len(phi.mid)))
    parts: list[tuple[Integers, list[Jet]]] = []
    shares = response.follow(space, phi)
    space.jumping = np.zeros(len(phi.mid), dtype=bool)
    while len(lanes):
        branches = Branches(len(lanes), script)
        jets = shares(JetNamespace(space.asking(branches, lanes)), lanes)
        if not response.is_continuous:
            np.logical_or.at(space.jumping, lanes, branches.jumping)
        parts.append((lanes, [replace(jet.repeated(len(lanes)), space=space) for jet in jets]))
        further, script = branches.further()
        lanes = lanes[further]
        if sum(len(known) for known, _ in parts) > MAX_LANES * len(phi.mid):
            raise Unbounded("a box goes through many branches")
    quantities = range(len(parts[0][1]))
    return [_enclose_parts([(known, jets[index]) for known, jets in parts]) for index in quantities]


def _enclose_parts(parts: Sequence[tuple[Integers, Jet]]) -> Jet:
    """One jet around all parts: the first has every lane, the others pieces of some."""
    (lanes, first), *others = parts
    felt = tuple(sorted({k for _, jet in parts for k in jet.felt}))
    whole = first.over(felt).taken(lanes)
    touched = np.zeros(len(lanes), dtype=bool)
    balls = [whole.value, whole.gradient, whole.hessian]
    bounds = [(ball.low, ball.high) for ball in balls] if others else []
    for which, jet in others:
        touched[which] = True
        piece = jet.over(felt).taken(np.arange(len(which)))
        for (low, high), ball in zip(bounds, (piece.value, piece.gradient, piece.hessian), strict=True):
            for lane, place in enumerate(which):
                low[..., place] = np.minimum(low[..., place], ball.low[..., lane])
                high[..., place] = np.maximum(high[..., place], ball.high[..., lane])
    if others:
        balls = [select_balls(touched, Ball.between(*side), ball) for side, ball in zip(bounds, balls, strict=True)]
    return Jet(whole.space, felt, *balls)


MAX_CHOICES = 60
"""Choices of samples, one for each extreme, whose sums are each formed."""


@dataclass(frozen=True)
class ExtremumTerm:
    """The largest of the samples of a jet, or the least."""

    samples: Jet
    largest: bool = True


@dataclass(frozen=True)
class ObjectiveBounds:
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


def bound_objective(smooth: Jet, extremes: Sequence[ExtremumTerm]) -> ObjectiveBounds:
    """Return bounds of a smooth part (one lane) plus extremes of samples.

    An extreme is one of the samples that may be it somewhere in the box, so its slopes are among theirs. No largest
    sample is below any one of them: where there are many choices, that at the centre stands for all.
    """
    candidates = [_find_candidates(extreme) for extreme in extremes]
    centre = [
        np.array([(np.argmax if e.largest else np.argmin)(e.samples.value[CENTRE].mid)]) if e.largest else own
        for e, own in zip(extremes, candidates, strict=True)
    ]
    every = prod(len(lanes) for lanes in candidates) <= MAX_CHOICES
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
    found = ObjectiveBounds(
        float(least.min(axis=falling).max()), float(reached.high), slopes, bent + half[:, 0] * slopes.rad
    )
    return _expand_bounds(total, found)


def _expand_bounds(total: Jet, found: ObjectiveBounds) -> ObjectiveBounds:
    """Slopes and looseness for all parameters, zero for those of no width."""
    size, felt = len(total.space.lower), list(total.felt)
    mid, rad, loose = np.zeros(size), np.zeros(size), np.zeros(size)
    mid[felt], rad[felt], loose[felt] = found.slopes.mid, found.slopes.rad, found.looseness
    return ObjectiveBounds(found.least, found.reached, Ball(mid, rad), loose, total.space.may_jump)


def enclose_variance(samples: Jet) -> Jet:
    """Return the population variance over the lanes."""
    return enclose_mean_square(samples - samples.mean())


def enclose_mean_square(samples: Jet) -> Jet:
    """Return the mean of squares over the lanes."""
    value, mean = samples.value.square().sum(), (samples**2).mean()
    share = Ball(value.mid[:, None], value.rad[:, None]) / Ball.exact(float(samples.lanes))
    low, high = np.maximum(mean.value.low, share.low), np.minimum(mean.value.high, share.high)
    return mean.holding(Ball.between(low, high))


def _find_candidates(extreme: ExtremumTerm) -> Integers:
    """Return lanes that may be the extreme somewhere in the box: those that the one at the centre does not exclude."""
    jet = extreme.samples if extreme.largest else -extreme.samples
    largest = jet.taken([int(np.argmax(jet.value[CENTRE].mid))])
    lanes: Integers = np.flatnonzero((largest - jet).least <= 0)
    return lanes
