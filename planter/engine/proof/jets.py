"""Second-order Taylor forms of functions of the design, centred in a box of designs.

A `Jet` encloses value and gradient of a function f at the centre c of the box, and value, gradient
and Hessian H anywhere in the box. Then f(x) lies in f(c) + f'(c) (x - c) + (x - c)' H (x - c) / 2,
and f'(x) in f'(c) + H (x - c); each operation intersects its result with these forms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
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
    Branches,
    Unbounded,
    intersect_balls,
    select_balls,
    sum_products,
)
from planter.kernels import Array, Flags, Integers

CENTRE, ANYWHERE = 0, 1


class Space:
    """Box of designs [lower, upper] (p,), or one for each lane (p, lanes), on which jets are
    defined.

    Parameters of zero width are constants. `half` (p, 1 or lanes) is half the width. `jumping`
    (lanes,) marks lanes that may jump within the box, whose jets enclose values but not slopes;
    `may_jump` is true if there are any.
    """

    def __init__(self, lower: Array, upper: Array, branches: Branches | None = None) -> None:
        self.lower, self.upper = lower, upper
        self.centre = lower + (upper - lower) / 2
        half = np.maximum(upper - self.centre, self.centre - lower)
        self.half = np.where(upper > lower, half * GROWTH + TINY, 0.0).reshape(len(lower), -1)
        self.branches = Branches.none(1) if branches is None else branches
        self.jumping: Flags = np.zeros(1, dtype=bool)
        self.is_cutting = True
        self._reach: dict[tuple[int, ...], Array] = {}

    @property
    def may_jump(self) -> bool:
        return bool(self.jumping.any())

    def asking(self, branches: Branches, lanes: Any = slice(None)) -> Space:
        """Return the same box, or the boxes of some lanes, with conditions answered by
        `branches`.
        """
        ends = [end[..., lanes] if end.ndim > 1 else end for end in (self.lower, self.upper)]
        space = Space(ends[0], ends[1], branches)
        space.is_cutting = self.is_cutting
        return space

    @contextmanager
    def at_points(self) -> Iterator[None]:
        """Treat jets as functions at single designs, without intersecting them with their Taylor
        forms over the box.
        """
        self.is_cutting = False
        try:
            yield
        finally:
            self.is_cutting = True

    def parameters(self) -> list[Jet]:
        """Return the design parameters as jets."""
        return [self._parameter(k) for k in range(len(self.lower))]

    def _parameter(self, k: int) -> Jet:
        if not self.half[k].any():
            return self.constant(Ball.exact(np.atleast_1d(self.lower[k])))
        mid = np.tile(self.centre[k], (2, 1))
        value = Ball(mid, np.stack([0 * self.half[k], self.half[k]]))
        return Jet(self, (k,), value, Ball.exact(np.ones((2, 1, 1))), Ball.exact(np.zeros((1, 1))))

    def constant(self, value: Ball) -> Jet:
        """Return balls (lanes,) that do not depend on the design as a jet."""
        both = join_parts(value, value)
        nothing = Ball.exact(np.zeros((2, 0, 1))), Ball.exact(np.zeros((0, 1)))
        return Jet(self, (), both, *nothing)

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
        return Jet(self, support, value, Ball.exact(np.stack([rates, rates])), Ball.exact(bend))

    def integer(self, number: int) -> Jet:
        """Return an integer as a jet."""
        return self.constant(Ball.exact([float(number)]))

    def reach(self, support: tuple[int, ...], hessian: Array) -> Array:
        """Return the change (k, lanes) of a gradient from the centre to the faces, from packed
        |Hessian| (K, lanes).
        """
        if self.half.shape[1] > 1:
            rows, columns = packed_indices(len(support))
            square = np.empty((len(support), len(support)), dtype=np.int64)
            square[rows, columns] = square[columns, rows] = np.arange(len(rows))
            reach_sum: Array = (hessian[square] * self.half[list(support)]).sum(axis=1)
            return reach_sum
        if support not in self._reach:
            rows, columns = packed_indices(len(support))
            reach = np.zeros((len(support), len(rows)))
            for place, (i, j) in enumerate(zip(rows, columns, strict=True)):
                reach[i, place] = self.half[support[j], 0]
                reach[j, place] = self.half[support[i], 0]
            self._reach[support] = reach
        return self._reach[support] @ hessian


@dataclass(frozen=True, eq=False)
class Jet:
    """A quantity over lanes; `support` are the indices of the k parameters on which it depends.

    value (2, lanes) and gradient (2, k, lanes) at the centre and anywhere; hessian (K, lanes)
    anywhere, packed.
    """

    space: Space
    support: tuple[int, ...]
    value: Ball
    gradient: Ball
    hessian: Ball

    @property
    def lanes(self) -> int:
        return max(
            self.value.mid.shape[-1], self.gradient.mid.shape[-1], self.hessian.mid.shape[-1]
        )

    @property
    def is_bounded(self) -> Flags:
        """Flags (lanes,) of the lanes with bounds."""
        balls = [
            _broadcast_lanes(ball, self.lanes) for ball in (self.value, self.gradient, self.hessian)
        ]
        sides = [side.reshape(-1, self.lanes) for ball in balls for side in (ball.mid, ball.rad)]
        return np.asarray(np.isfinite(np.concatenate(sides)).all(axis=0))

    def repeated(self, count: int) -> Jet:
        """Return the jet repeated over `count` lanes if it has one lane."""
        return Jet(
            self.space,
            self.support,
            *(_broadcast_lanes(b, count) for b in (self.value, self.gradient, self.hessian)),
        )

    def taken(self, lanes: Any) -> Jet:
        """Return the jet on some of its lanes."""
        value, gradient, hessian = (
            _broadcast_lanes(b, self.lanes) for b in (self.value, self.gradient, self.hessian)
        )
        return Jet(
            self.space, self.support, value[..., lanes], gradient[..., lanes], hessian[..., lanes]
        )

    def over(self, support: tuple[int, ...]) -> Jet:
        """Return the jet as a function of more parameters."""
        if support == self.support:
            return self
        rows, places = _embedding_indices(self.support, support)
        gradient, hessian = (
            _zero_ball(b, n)
            for b, n in ((self.gradient, len(support)), (self.hessian, packed_size(len(support))))
        )
        for part in ("mid", "rad"):
            getattr(gradient, part)[:, rows] = getattr(self.gradient, part)
            getattr(hessian, part)[places] = getattr(self.hessian, part)
        return Jet(self.space, support, self.value, gradient, hessian)

    def cut(self) -> Jet:
        """Return the jet with value and gradient anywhere intersected with its Taylor form."""
        if not self.support or not self.space.is_cutting:
            return self
        half, moved = (
            self.space.half[list(self.support)],
            self.space.reach(self.support, self.hessian.magnitude),
        )
        slope = self.gradient[CENTRE]
        gradient = Ball(slope.mid, (slope.rad + moved) * GROWTH + TINY)
        centre = self.value[CENTRE]
        change = _weigh(half, slope.magnitude + moved / 2)
        value = Ball(centre.mid + 0 * change, (centre.rad + change) * GROWTH + TINY)
        return Jet(
            self.space,
            self.support,
            join_parts(centre, intersect_balls(self.value[ANYWHERE], value)),
            join_parts(slope, intersect_balls(self.gradient[ANYWHERE], gradient)),
            self.hessian,
        )

    @property
    def lower_bound(self) -> Array:
        """Lower bounds over the box, (lanes,)."""
        half, (rows, columns) = (
            self.space.half[list(self.support)],
            packed_indices(len(self.support)),
        )
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
        return Jet(self.space, self.support, -self.value, -self.gradient, -self.hessian)

    def __add__(self, other: Any) -> Jet:
        a, b = self._paired(other)
        if not b.support:
            return Jet(self.space, a.support, a.value + b.value, a.gradient, a.hessian)
        if not a.support:
            return Jet(self.space, b.support, a.value + b.value, b.gradient, b.hessian)
        a, b = _align_jets(a, b)
        return Jet(
            self.space, a.support, a.value + b.value, a.gradient + b.gradient, a.hessian + b.hessian
        ).cut()

    def __mul__(self, other: Any) -> Jet:
        a, b = self._paired(other)
        value = a.value * b.value
        if not b.support:
            a, b = b, a
        if not a.support:
            rate = a.value[:, None]
            return Jet(
                self.space, b.support, value, rate * b.gradient, a.value[ANYWHERE] * b.hessian
            )
        a, b = _align_jets(a, b)
        gradient = sum_products((a.value[:, None], b.gradient), (b.value[:, None], a.gradient))
        rows, columns = packed_indices(len(a.support))
        a_slope, b_slope = a.gradient[ANYWHERE], b.gradient[ANYWHERE]
        hessian = sum_products(
            (a.value[ANYWHERE], b.hessian),
            (b.value[ANYWHERE], a.hessian),
            (a_slope[rows], b_slope[columns]),
            (a_slope[columns], b_slope[rows]),
        )
        return Jet(self.space, a.support, value, gradient, hessian).cut()

    def through(self, value: Ball, first: Ball, second: Ball) -> Jet:
        """Return a function of the jet from its value (2, lanes), first (2, lanes) and second
        derivative (lanes,).
        """
        if not self.support:
            return Jet(self.space, (), value, self.gradient, self.hessian)
        rows, columns = packed_indices(len(self.support))
        slope = self.gradient[ANYWHERE]
        hessian = sum_products(
            (first[ANYWHERE], self.hessian), (second * slope[rows], slope[columns])
        )
        return Jet(self.space, self.support, value, first[:, None] * self.gradient, hessian).cut()

    def __pow__(self, exponent: int) -> Jet:
        if exponent < 0:
            return self.inverse() ** -exponent
        if exponent == 0:
            return self.space.constant(Ball.exact([1.0]))
        scales = [Ball.exact(float(n)) for n in (exponent, exponent * (exponent - 1))]
        first = scales[0] * self.value.power(exponent - 1)
        second = scales[1] * self.value[ANYWHERE].power(max(exponent - 2, 0))
        return self.through(self.value.power(exponent), first, second)

    def polynomial(self, coefficients: Sequence[float]) -> Jet:
        """Return the sum of a_k x^k, with the highest power first.

        The polynomial is expanded about the centre c of each lane, where the powers of x - c are
        small.
        """
        centre = Ball(self.value.mid[CENTRE], np.zeros_like(self.value.mid[CENTRE]))
        about = [Ball.exact(np.full(centre.mid.shape, float(a))) for a in coefficients]
        for end in range(len(about), 1, -1):
            for k in range(1, end):
                about[k] = about[k] + centre * about[k - 1]
        taylor, step = (
            about[::-1],
            self.value - Ball(join_parts(centre, centre).mid, np.zeros_like(self.value.mid)),
        )
        value, first, second = (_polynomial_derivative(taylor, step, n) for n in range(3))
        return self.through(value, first, second[ANYWHERE])

    def inverse(self) -> Jet:
        """Return an enclosure of the reciprocal."""
        value = self.value.inverse()
        square = value * value
        return self.through(value, -square, Ball.exact(2.0) * square[ANYWHERE] * value[ANYWHERE])

    def sqrt(self) -> Jet:
        """Return an enclosure of the square root."""
        root = self.value.sqrt()
        first = (Ball.exact(2.0) * root).inverse()
        return self.through(
            root, first, -(first * (Ball.exact(2.0) * self.value).inverse())[ANYWHERE]
        )

    def sin(self) -> Jet:
        """Return an enclosure of the sine."""
        value = self.value.sin()
        return self.through(value, self.value.cos(), -value[ANYWHERE])

    def cos(self) -> Jet:
        """Return an enclosure of the cosine."""
        value = self.value.cos()
        return self.through(value, -self.value.sin(), -value[ANYWHERE])

    def arctan(self) -> Jet:
        """Return an enclosure of the arc tangent."""
        first = (Ball.exact(1.0) + self.value.power(2).nonnegative()).inverse()
        second = -(Ball.exact(2.0) * self.value * first * first)[ANYWHERE]
        return self.through(self.value.arctan(), first, second)

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
        return (tangential / radial).arctan() + self.space.constant(fixed)

    def exp(self) -> Jet:
        """Return an enclosure of the exponential."""
        value = self.value.exp()
        return self.through(value, value, value[ANYWHERE])

    def log(self) -> Jet:
        """Return an enclosure of the natural logarithm."""
        first = self.value.inverse()
        return self.through(self.value.log(), first, -(first * first)[ANYWHERE])

    def floor(self) -> Jet:
        """Return an enclosure of the largest integers below the values, with derivative 0."""
        return self.space.constant(Ball.exact(self.space.branches.floor(self.value[ANYWHERE])))

    def mean(self) -> Jet:
        """Return the mean over the lanes."""
        return self.sum() / self.space.integer(self.lanes)

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
        return Jet(
            self.space,
            support,
            join_parts(value, self.value[ANYWHERE]),
            gradient,
            self.hessian[~of_k],
        ).cut()

    def sum(self) -> Jet:
        """Return the sum over the lanes."""
        sums = (
            _broadcast_lanes(b, self.lanes).sum() for b in (self.value, self.gradient, self.hessian)
        )
        return Jet(
            self.space, self.support, *(Ball(b.mid[..., None], b.rad[..., None]) for b in sums)
        ).cut()

    def where(self, condition: Any, other: Any) -> Jet:
        """Return this jet on the lanes where the condition is true and the other jet elsewhere."""
        a, b = _align_jets(*self._paired(other))
        parts = zip((a.value, a.gradient, a.hessian), (b.value, b.gradient, b.hessian), strict=True)
        return Jet(
            self.space,
            a.support,
            *(select_balls(condition, first, second) for first, second in parts),
        )

    def holding(self, value: Ball) -> Jet:
        """Return the jet with another enclosure of its value (2, lanes)."""
        return Jet(self.space, self.support, value, self.gradient, self.hessian)

    def _paired(self, other: Any) -> tuple[Jet, Jet]:
        return self, self.space.lift(other)

    def __sub__(self, other: Any) -> Jet:
        return self + (-other)

    def __rsub__(self, other: Any) -> Jet:
        return -self + other

    def __truediv__(self, other: Any) -> Jet:
        return self * self._paired(other)[1].inverse()

    def __rtruediv__(self, other: Any) -> Jet:
        return self.inverse() * other

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
    support = tuple(sorted({k for jet in jets for k in jet.support}))
    parts = [
        [getattr(jet.repeated(jet.lanes).over(support), part) for jet in jets]
        for part in ("value", "gradient", "hessian")
    ]
    return Jet(
        jets[0].space,
        support,
        *(
            Ball(
                np.concatenate([b.mid for b in balls], axis=-1),
                np.concatenate([b.rad for b in balls], axis=-1),
            )
            for balls in parts
        ),
    )


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
def _embedding_indices(few: tuple[int, ...], many: tuple[int, ...]) -> tuple[Integers, Integers]:
    """Return the positions of few parameters, and of their packed entries, among many."""
    rows = np.array([many.index(k) for k in few], dtype=np.int64)
    i, j = packed_indices(len(few))
    a, b = rows[i], rows[j]
    high, low = np.maximum(a, b), np.minimum(a, b)
    return rows, high * (high + 1) // 2 + low


def _align_jets(a: Jet, b: Jet) -> tuple[Jet, Jet]:
    """Return both jets as functions of the union of their parameters."""
    if a.support == b.support:
        return a, b
    support = tuple(sorted({*a.support, *b.support}))
    return a.over(support), b.over(support)


def _zero_ball(like: Ball, rows: int) -> Ball:
    shape = (*like.mid.shape[:-2], rows, like.mid.shape[-1])
    return Ball(np.zeros(shape), np.zeros(shape))


def _broadcast_lanes(ball: Ball, lanes: int) -> Ball:
    if ball.mid.shape[-1] == lanes == ball.rad.shape[-1]:
        return ball
    shape = (*ball.mid.shape[:-1], lanes)
    return Ball(np.broadcast_to(ball.mid, shape), np.broadcast_to(ball.rad, shape))


def join_parts(centre: Ball, anywhere: Ball) -> Ball:
    """Return a ball with parts at the centre of a box and anywhere in it."""
    return Ball(_stack_parts(centre.mid, anywhere.mid), _stack_parts(centre.rad, anywhere.rad))


def _stack_parts(centre: Array, anywhere: Array) -> Array:
    parts = np.empty((2, *np.broadcast_shapes(centre.shape, anywhere.shape)))
    parts[CENTRE], parts[ANYWHERE] = centre, anywhere
    return parts
