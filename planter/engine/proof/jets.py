"""Second-order Taylor forms of functions of the design, centred in a box of designs.

A `Jet` encloses value and gradient of a function f at the centre c of the box, and value, gradient
and Hessian H anywhere in the box. Then f(x) lies in f(c) + f'(c) (x - c) + (x - c)' H (x - c) / 2,
and f'(x) in f'(c) + H (x - c); each operation intersects its result with these forms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from planter.engine.proof.intervals import (
    GROWTH,
    LIBM,
    SLACK,
    TINY,
    Ball,
    Unbounded,
    intersect_balls,
    select_balls,
    sum_products,
)
from planter.kernels import Array, Flags, Integers

CENTRE, ANYWHERE = 0, 1
ONE, TWO = Ball.exact(1.0), Ball.exact(2.0)

BallFunction = Callable[..., Ball]
FUNCTIONS: dict[str, tuple[BallFunction, BallFunction, BallFunction]] = {
    "inverse": (Ball.inverse, lambda _, y: -(y * y), lambda x, y, d: TWO * (y * y) * y),
    "sqrt": (
        Ball.sqrt,
        lambda _, y: (TWO * y).inverse(),
        lambda x, y, d: -(d * (TWO * x).inverse()),
    ),
    "sin": (Ball.sin, lambda x, _: x.cos(), lambda x, y, d: -y),
    "cos": (Ball.cos, lambda x, _: -x.sin(), lambda x, y, d: -y),
    "arctan": (
        Ball.arctan,
        lambda x, _: (ONE + x.power(2).nonnegative()).inverse(),
        lambda x, y, d: -(TWO * x * d * d),
    ),
    "exp": (Ball.exp, lambda _, y: y, lambda x, y, d: y),
    "log": (Ball.log, lambda x, _: x.inverse(), lambda x, y, d: -(d * d)),
}
"""Elementary functions y of a ball x, by name: y from x, y' from x and y, y'' from x, y and y'."""


class Space:
    """Box of designs [lower, upper] (p,), or one for each lane (p, lanes), on which jets are
    defined.

    Parameters of zero width are constants. `half` (p, 1 or lanes) is half the width. `jumping`
    (lanes,) marks lanes that may jump within the box, whose jets enclose values but not slopes.
    Jets of functions at single designs have no Taylor forms: they are not cut by them if
    `is_cutting` is false.
    """

    def __init__(self, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, upper
        self.centre = lower + (upper - lower) / 2
        half = np.maximum(upper - self.centre, self.centre - lower)
        self.half = np.where(upper > lower, half * GROWTH + TINY, 0.0).reshape(len(lower), -1)
        self.jumping: Flags = np.zeros(1, dtype=bool)
        self.is_cutting = True
        self._reach: dict[tuple[int, ...], Array] = {}

    def taken(self, lanes: Any) -> Space:
        """Return the boxes of some lanes, or the same box if all lanes have it."""
        ends = [end[..., lanes] if end.ndim > 1 else end for end in (self.lower, self.upper)]
        space = Space(*ends)
        space.is_cutting = self.is_cutting
        return space

    def parameters(self) -> list[Jet]:
        """Return the design parameters as jets."""
        return [self._parameter(k) for k in range(len(self.lower))]

    def _parameter(self, k: int) -> Jet:
        if not self.half[k].any():
            return self.constant(Ball.exact(np.atleast_1d(self.lower[k])))
        mid = np.tile(self.centre[k], (2, 1))
        value = Ball(mid, np.stack([0 * self.half[k], self.half[k]]))
        return self.jet((k,), value, Ball.exact(np.ones((2, 1, 1))), Ball.exact(np.zeros((1, 1))))

    def jet(self, support: tuple[int, ...], value: Ball, gradient: Ball, hessian: Ball) -> Jet:
        """Return the jet of a value (2, lanes), gradient (2, k, lanes) and packed Hessian (K,
        lanes).
        """
        slopes = gradient.map(lambda side: side.reshape(2 * len(support), side.shape[-1]))
        return Jet(self, support, _stack_rows(value, slopes, hessian))

    def constant(self, value: Ball) -> Jet:
        """Return balls (lanes,) that do not depend on the design as a jet."""
        return Jet(self, (), join_parts(value, value))

    def lift(self, value: Any) -> Jet:
        """Return numbers as a jet; a jet is returned unchanged."""
        if isinstance(value, Jet):
            assert value.space is self
            return value
        return self.constant(Ball.exact(np.atleast_1d(np.asarray(value, dtype=float))))

    def linear(self, values: Array, slopes: Array) -> Jet:
        """Return functions of the first parameters, with values (m,) at the centre and slopes (m,
        k), as a jet.
        """
        support = tuple(
            k for k in np.flatnonzero(slopes.any(axis=0)).tolist() if self.half[k].any()
        )
        rates = slopes.T[list(support)]
        change = _weigh(self.half[list(support)], np.abs(rates)) * GROWTH + TINY
        value = Ball(
            np.stack([values, values]), np.stack([0 * values, change if support else 0 * values])
        )
        bend = np.zeros((packed_size(len(support)), len(values)))
        return self.jet(support, value, Ball.exact(np.stack([rates, rates])), Ball.exact(bend))

    def reach(self, support: tuple[int, ...], hessian: Array) -> Array:
        """Return the change (k, lanes) of a gradient from the centre to the faces, from packed
        |Hessian| (K, lanes).
        """
        rows, columns = packed_indices(len(support))
        if self.half.shape[1] > 1:
            square = np.empty((len(support), len(support)), dtype=np.int64)
            square[rows, columns] = square[columns, rows] = np.arange(len(rows))
            reach_sum: Array = (hessian[square] * self.half[list(support)]).sum(axis=1)
            return reach_sum
        if support not in self._reach:
            reach = np.zeros((len(support), len(rows)))
            for place, (i, j) in enumerate(zip(rows, columns, strict=True)):
                reach[i, place] = self.half[support[j], 0]
                reach[j, place] = self.half[support[i], 0]
            self._reach[support] = reach
        return self._reach[support] @ hessian


@dataclass(frozen=True, eq=False)
class Jet:
    """A quantity over lanes; `support` are the indices of the k parameters on which it depends.

    Rows (2 + 2 k + K, lanes), as in C: value at the centre and anywhere, gradient at the centre
    and anywhere, packed Hessian anywhere.
    """

    space: Space
    support: tuple[int, ...]
    rows: Ball

    @property
    def value(self) -> Ball:
        """The value at the centre and anywhere, (2, lanes)."""
        return self.rows[:2]

    @property
    def gradient(self) -> Ball:
        """The gradient at the centre and anywhere, (2, k, lanes)."""
        count = len(self.support)
        slopes = self.rows[2 : 2 + 2 * count]
        return slopes.map(lambda side: side.reshape(2, count, side.shape[1]))

    @property
    def hessian(self) -> Ball:
        """The packed Hessian anywhere, (K, lanes)."""
        return self.rows[2 + 2 * len(self.support) :]

    @property
    def lanes(self) -> int:
        return self.rows.mid.shape[1]

    @property
    def is_bounded(self) -> Flags:
        """Flags (lanes,) of the lanes with bounds."""
        finite = np.isfinite(self.rows.mid) & np.isfinite(self.rows.rad)
        return np.asarray(finite.all(axis=0))

    def repeated(self, count: int) -> Jet:
        """Return the jet repeated over `count` lanes if it has one lane."""
        shape = len(self.rows.mid), count
        return self._with(self.rows.map(lambda side: np.broadcast_to(side, shape)))

    def taken(self, lanes: Any) -> Jet:
        """Return the jet on some of its lanes."""
        return self._with(self.rows[:, lanes])

    def moved(self, space: Space) -> Jet:
        """Return the jet on a space of the same box."""
        return Jet(space, self.support, self.rows)

    def holding(self, value: Ball) -> Jet:
        """Return the jet with another enclosure of its value (2, lanes)."""
        return self._with(_stack_rows(value, self.rows[2:]))

    def masked(self, lanes: Flags) -> Jet:
        """Return the jet without bounds in all lanes but those that are flagged."""
        return self._with(self.rows.map(lambda side: np.where(lanes, side, np.nan)))

    def _with(self, rows: Ball) -> Jet:
        return Jet(self.space, self.support, rows)

    def over(self, support: tuple[int, ...]) -> Jet:
        """Return the jet as a function of more parameters."""
        if support == self.support:
            return self
        places = _embedding_indices(self.support, support)

        def embed(side: Array) -> Array:
            count = 2 + 2 * len(support) + packed_size(len(support))
            rows = np.zeros((count, side.shape[1]))
            rows[places] = side
            return rows

        return Jet(self.space, support, self.rows.map(embed))

    def cut(self) -> Jet:
        """Return the jet with value and gradient anywhere intersected with its Taylor form."""
        if not self.support or not self.space.is_cutting:
            return self
        count, half = len(self.support), self.space.half[list(self.support)]
        moved = self.space.reach(self.support, self.hessian.magnitude)
        centre, slope = self.rows[0], self.rows[2 : 2 + count]
        gradient = Ball(slope.mid, (slope.rad + moved) * GROWTH + TINY)
        change = _weigh(half, slope.magnitude + moved / 2)
        value = Ball(centre.mid, (centre.rad + change) * GROWTH + TINY)
        rows = self.rows.map(np.copy)
        for place, formed in ((1, value), (slice(2 + count, 2 + 2 * count), gradient)):
            part = intersect_balls(rows[place], formed)
            rows.mid[place], rows.rad[place] = part.mid, part.rad
        return self._with(rows)

    @property
    def lower_bound(self) -> Array:
        """Lower bounds over the box, (lanes,)."""
        half = self.space.half[list(self.support)]
        rows, columns = packed_indices(len(self.support))
        weights = np.where(rows == columns, 0.5, 1.0)[:, None] * half[rows] * half[columns]
        bent = np.where(
            (rows == columns)[:, None], np.maximum(-self.hessian.low, 0), self.hessian.magnitude
        )
        change = (
            _weigh(half, self.gradient[CENTRE].magnitude) + _weigh(weights, bent)
        ) * GROWTH + TINY
        centre = self.value[CENTRE]
        formed = Ball(centre.mid, (centre.rad + change) * GROWTH + TINY).low
        return np.maximum(formed, self.value[ANYWHERE].low)

    def __neg__(self) -> Jet:
        return self._with(-self.rows)

    def __add__(self, other: Any) -> Jet:
        a, b = self, self.space.lift(other)
        if not a.support:
            a, b = b, a
        if not b.support:
            return a.holding(a.value + b.value)
        a, b = _align_jets(a, b)
        return a._with(a.rows + b.rows).cut()

    def __mul__(self, other: Any) -> Jet:
        a, b = self, self.space.lift(other)
        value = a.value * b.value
        if not b.support:
            a, b = b, a
        if not a.support:
            rate, bend = a.value[:, None] * b.gradient, a.value[ANYWHERE] * b.hessian
            return self.space.jet(b.support, value, rate, bend)
        a, b = _align_jets(a, b)
        a_gradient, b_gradient = a.gradient, b.gradient
        gradient = sum_products((a.value[:, None], b_gradient), (b.value[:, None], a_gradient))
        rows, columns = packed_indices(len(a.support))
        a_slope, b_slope = a_gradient[ANYWHERE], b_gradient[ANYWHERE]
        hessian = sum_products(
            (a.value[ANYWHERE], b.hessian),
            (b.value[ANYWHERE], a.hessian),
            (a_slope[rows], b_slope[columns]),
            (a_slope[columns], b_slope[rows]),
        )
        return self.space.jet(a.support, value, gradient, hessian).cut()

    def through(self, value: Ball, first: Ball, second: Ball) -> Jet:
        """Return a function of the jet from its value (2, lanes), first (2, lanes) and second
        derivative (lanes,).
        """
        if not self.support:
            return Jet(self.space, (), value)
        rows, columns = packed_indices(len(self.support))
        gradient = self.gradient
        slope = gradient[ANYWHERE]
        hessian = sum_products(
            (first[ANYWHERE], self.hessian), (second * slope[rows], slope[columns])
        )
        return self.space.jet(self.support, value, first[:, None] * gradient, hessian).cut()

    def call(self, name: str) -> Jet:
        """Return an elementary function of the jet."""
        function, slope, bend = FUNCTIONS[name]
        value = function(self.value)
        first = slope(self.value, value)
        parts = self.value[ANYWHERE], value[ANYWHERE], first[ANYWHERE]
        return self.through(value, first, bend(*parts))

    def __pow__(self, exponent: int) -> Jet:
        if exponent < 0:
            return self.call("inverse") ** -exponent
        if exponent == 0:
            return self.space.lift(1.0)
        scales = [Ball.exact(float(n)) for n in (exponent, exponent * (exponent - 1))]
        first = scales[0] * self.value.power(exponent - 1)
        second = scales[1] * self.value[ANYWHERE].power(max(exponent - 2, 0))
        return self.through(self.value.power(exponent), first, second)

    def polynomial(self, coefficients: Sequence[float]) -> Jet:
        """Return the sum of a_k x^k, with the highest power first.

        The polynomial is expanded about the centre c of each lane, where the powers of x - c are
        small.
        """
        centre = Ball.exact(self.value.mid[CENTRE])
        about = [Ball.exact(np.full(centre.mid.shape, float(a))) for a in coefficients]
        for end in range(len(about), 1, -1):
            for k in range(1, end):
                about[k] = about[k] + centre * about[k - 1]
        taylor, step = about[::-1], self.value - centre
        value, first, second = (_polynomial_derivative(taylor, step, n) for n in range(3))
        return self.through(value, first, second[ANYWHERE])

    def angle(self, abscissa: Jet) -> Jet:
        """Return the angle of a point with this ordinate: that of a fixed direction near it plus
        the angle from there.

        NaN in lanes in which the point may be the origin or the angle may jump by 2 pi. Raises
        Unbounded if that is the case in every lane.
        """
        y, x = self.value[ANYWHERE], abscissa.value[ANYWHERE]
        is_apart = (x.low > 0) | (y.low > 0) | (y.high < 0)
        if not is_apart.any():
            raise Unbounded("an angle may jump by a turn")
        angle = np.arctan2(self.value.mid[CENTRE], abscissa.value.mid[CENTRE])
        cos, sin = np.cos(angle), np.sin(angle)
        radial, tangential = abscissa * cos + self * sin, self * cos - abscissa * sin
        direction = np.arctan2(sin, cos)
        fixed = Ball(np.where(is_apart, direction, np.nan), np.full_like(direction, 2 * LIBM))
        return (tangential / radial).call("arctan") + self.space.constant(fixed)

    def average(self, k: int) -> Jet:
        """Return the mean over a parameter k in [-1, 1], as a function of the others, in each lane.

        With f(c, s) = f(c) + f_s s + H_ss s^2 / 2, terms odd in s cancel but for what differs
        between pieces: radii.
        """
        return self._without(
            k, lambda slope, bend: _center(slope) + bend / Ball.exact(6.0), _center
        )

    def hull(self, k: int) -> Jet:
        """Return what the jet is at any fixed place in [-1, 1] of a parameter k, as a function of
        the others.
        """
        return self._without(
            k, _bound_parabola, lambda slope: Ball(np.zeros_like(slope.rad), slope.magnitude)
        )

    def _without(
        self, k: int, change: Callable[[Ball, Ball], Ball], tilt: Callable[[Ball], Ball]
    ) -> Jet:
        """Return the jet without a parameter k, by what its slope and bend change the value, and a
        slope the slopes.
        """
        if k not in self.support:
            return self
        place, (rows, columns) = self.support.index(k), packed_indices(len(self.support))
        rest = [i for i in range(len(self.support)) if i != place]
        of_k, is_square = (rows == place) | (columns == place), rows == columns
        slope, mixed = self.gradient[CENTRE], self.hessian[of_k & ~is_square]
        value = self.value[CENTRE] + change(slope[place], self.hessian[of_k & is_square][0])
        gradient = join_parts(slope[rest] + tilt(mixed), self.gradient[ANYWHERE][rest])
        support = tuple(self.support[i] for i in rest)
        value = join_parts(value, self.value[ANYWHERE])
        return self.space.jet(support, value, gradient, self.hessian[~of_k]).cut()

    def sum(self) -> Jet:
        """Return the sum over the lanes."""
        return self._with(self.rows.sum()[:, None]).cut()

    def where(self, condition: Any, other: Any) -> Jet:
        """Return this jet on the lanes where the condition is true and the other jet elsewhere."""
        a, b = _align_jets(self, self.space.lift(other))
        return a._with(select_balls(condition, a.rows, b.rows))

    def __sub__(self, other: Any) -> Jet:
        return self + (-other)

    def __rsub__(self, other: Any) -> Jet:
        return -self + other

    def __truediv__(self, other: Any) -> Jet:
        return self * self.space.lift(other).call("inverse")

    def __rtruediv__(self, other: Any) -> Jet:
        return self.call("inverse") * other

    __radd__, __rmul__ = __add__, __mul__


def _center(slope: Ball) -> Ball:
    """Return the mean of slope times s over s in [-1, 1], where the slope may differ from one s to
    the next.
    """
    return Ball(np.zeros_like(slope.rad), slope.rad / 2 * GROWTH + TINY)


def _bound_parabola(slope: Ball, bend: Ball) -> Ball:
    """Return slope * s + bend * s^2 / 2 over all s in [-1, 1]."""
    steep = slope.magnitude

    def rise(curve: Array) -> Array:
        is_round = (curve < 0) & (steep < -curve)
        bound: Array = np.where(
            is_round, steep**2 / np.where(is_round, -2 * curve, 1.0), steep + curve / 2
        )
        return bound * GROWTH + (steep + np.abs(curve)) * SLACK + TINY

    return Ball.between(-rise(-bend.low), rise(bend.high))


def join_lanes(jets: Sequence[Jet]) -> Jet:
    """Return the lanes of all jets, one after the other."""
    support = unite_supports(jets)
    rows = [jet.over(support).rows for jet in jets]
    sides = [ball.mid for ball in rows], [ball.rad for ball in rows]
    return Jet(jets[0].space, support, Ball(*(np.concatenate(side, axis=1) for side in sides)))


def unite_supports(jets: Iterable[Jet], *more: int) -> tuple[int, ...]:
    """Return the parameters on which any of some jets depends, and others."""
    return tuple(sorted({k for jet in jets for k in jet.support}.union(more)))


def _stack_rows(*parts: Ball) -> Ball:
    """Return the rows of parts (n, lanes) below each other; a part of one lane is repeated."""
    lanes = max(side.shape[1] for part in parts for side in (part.mid, part.rad))
    mid, rad = np.empty((2, sum(len(part.mid) for part in parts), lanes))
    start = 0
    for part in parts:
        stop = start + len(part.mid)
        mid[start:stop], rad[start:stop] = part.mid, part.rad
        start = stop
    return Ball(mid, rad)


def _polynomial_derivative(taylor: Sequence[Ball], step: Ball, order: int) -> Ball:
    """Return the derivative of some order of sum b_k h^k at steps h (2, lanes)."""
    total = Ball.exact(np.zeros_like(step.mid))
    for k in range(order, len(taylor)):
        total = total + Ball.exact(float(math.perm(k, order))) * taylor[k] * step.power(k - order)
    return total


def _weigh(weights: Array, values: Array) -> Array:
    """Return sums over rows (k, lanes), by weights (k, 1) of all lanes, or (k, lanes)."""
    total: Array = (
        weights[:, 0] @ values if weights.shape[1] == 1 else (weights * values).sum(axis=0)
    )
    return total


def packed_size(size: int) -> int:
    """Return the number of entries of a packed symmetric matrix."""
    return size * (size + 1) // 2


@lru_cache(maxsize=64)
def packed_indices(size: int) -> tuple[Integers, Integers]:
    """Return rows and columns of the entries of a packed symmetric matrix."""
    rows, columns = np.tril_indices(size)
    return rows, columns


@lru_cache(maxsize=4096)
def _embedding_indices(few: tuple[int, ...], many: tuple[int, ...]) -> Integers:
    """Return the places of the rows of a jet of few parameters among those of many."""
    places = np.array([many.index(k) for k in few], dtype=np.int64)
    i, j = packed_indices(len(few))
    high, low = np.maximum(places[i], places[j]), np.minimum(places[i], places[j])
    bends = 2 + 2 * len(many) + high * (high + 1) // 2 + low
    return np.concatenate([[0, 1], 2 + places, 2 + len(many) + places, bends])


def _align_jets(a: Jet, b: Jet) -> tuple[Jet, Jet]:
    """Return both jets as functions of the union of their parameters."""
    support = unite_supports((a, b))
    return a.over(support), b.over(support)


def join_parts(centre: Ball, anywhere: Ball) -> Ball:
    """Return a ball with parts at the centre of a box and anywhere in it."""
    mid, rad = (
        np.empty((2, *np.broadcast_shapes(*(side.shape for side in sides))))
        for sides in ((centre.mid, anywhere.mid), (centre.rad, anywhere.rad))
    )
    mid[CENTRE], mid[ANYWHERE] = centre.mid, anywhere.mid
    rad[CENTRE], rad[ANYWHERE] = centre.rad, anywhere.rad
    return Ball(mid, rad)
