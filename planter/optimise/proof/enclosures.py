"""Enclosures of a response and bounds of an objective over a box of designs.

Generated array code is evaluated on jets, which have elementary functions under the names of NumPy. This encloses each
sample of a response over a cycle, and from these an objective and its slopes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.proof.intervals import LIBM, Ball, Branches, U, Unbounded, select_balls
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space, join_lanes, join_parts


class JetNamespace:
    """Array namespace `xp` of generated code, for jets over a box."""

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

    def maximum(self, a: Any, b: Any) -> Jet:
        """Return an enclosure of the larger of two quantities."""
        first = self.space.lift(a)
        return first.where(first.reaches(b), b)

    def minimum(self, a: Any, b: Any) -> Jet:
        """Return an enclosure of the smaller of two quantities."""
        first = self.space.lift(a)
        return first.where(self.space.lift(b).reaches(first), b)

    def sign(self, x: Any) -> Any:
        """Return an enclosure of the sign."""
        return self.where(x > 0, 1, self.where(x < 0, -1, 0))

    logical_or, logical_and, logical_not = np.logical_or, np.logical_and, np.logical_not

    def divide(self, a: Any, b: Any) -> Jet:
        """Return an enclosure of the quotient."""
        return self.space.lift(a) / b

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
        """Return the angle of a point as the angle of a fixed direction near it plus the angle from there.

        NaN in lanes in which the point may be the origin or the angle may jump by 2 pi. Raises Unbounded if that is
        the case in every lane.
        """
        y, x = self.space.lift(y), self.space.lift(x)
        ordinate, abscissa = y.value[ANYWHERE], x.value[ANYWHERE]
        is_apart = (abscissa.low > 0) | (ordinate.low > 0) | (ordinate.high < 0)
        if not is_apart.any():
            raise Unbounded("an angle may jump by a turn")
        angle = np.arctan2(y.value.mid[CENTRE], x.value.mid[CENTRE])
        cos, sin = np.cos(angle), np.sin(angle)
        radial, tangential = x * cos + y * sin, y * cos - x * sin
        direction = np.arctan2(sin, cos)
        fixed = Ball(np.where(is_apart, direction, np.nan), np.full_like(direction, 2 * LIBM))
        return (tangential / radial).arctan() + self.space.constant(fixed)

    @staticmethod
    def polyval(coefficients: Sequence[float], x: Jet) -> Jet:
        """Return the sum of a_k x^k, highest power first, about the centre, where little cancels."""
        return x.polynomial(coefficients)

    @staticmethod
    def floor(x: Jet) -> Jet:
        """Return an enclosure of the largest integers below the values."""
        return x.floor()


PI = Ball(np.array([np.pi]), np.array([2 * U]))
"""The number pi; the nearest double is closer than 2^-52."""


MAX_LANES = 8
"""Average number of pieces of a lane above which a box is too wide to follow them."""


class EnclosedCode(Protocol):
    """Code whose results are enclosed over boxes."""

    def enclose(
        self, space: Space, inputs: Sequence[Jet], lanes: Integers, script: Array
    ) -> tuple[Branches, Sequence[Jet]]:
        """Return the results on some lanes of inputs, and the conditions that were asked; `script` has answers."""


class EnclosedResponse(Protocol):
    """Quantities F(phi, x): sums over `offsets` [turns] of shares at phi + offset, with a common `period` [turns].

    `is_continuous` is true if they do not jump over designs, whatever the conditions in their code.
    """

    @property
    def offsets(self) -> tuple[Fraction, ...]: ...
    @property
    def period(self) -> Fraction: ...
    @property
    def is_continuous(self) -> bool: ...

    @property
    def code(self) -> EnclosedCode:
        """The code of the shares, smooth but for its conditions."""

    def prepare(self, space: Space, phi: Jet) -> Sequence[Jet]:
        """Return the inputs of the code over a box at angles phi (lanes,) [rad].

        After the p parameters of a design, a space may have the place in a panel of angles as one more.
        """

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return whether no design of a box [lower, upper] (p,) is valid at some of the angles phi (lanes,) [rad]."""


def enclose_samples(response: EnclosedResponse, space: Space, count: int) -> list[Jet]:
    """Return each quantity over a box at phi = 2 pi i / count, with a lane for each angle modulo the period."""
    return enclose_turns(response, space, list_samples(response, count))


def list_samples(response: EnclosedResponse, count: int) -> list[Fraction]:
    """Return the angles [turns] of `count` equal steps of a cycle, of a turn or more, that differ modulo the period."""
    cycle = max(Fraction(1), response.period)
    share = response.period / cycle * count
    return [cycle * i / count for i in range(int(share) if share.denominator == 1 else count)]


def enclose_turns(response: EnclosedResponse, space: Space, turns: Sequence[Fraction]) -> list[Jet]:
    """Return each quantity over a box at fixed angles [turns], a lane for each."""
    fixed = [list_angles([turn + offset for turn in turns]) for offset in response.offsets]
    return enclose_at(response, space, [space.constant(phi) for phi in fixed])


def enclose_moving(response: EnclosedResponse, space: Space, phi: Jet) -> list[Jet]:
    """Return each quantity over a box at angles that may move with the design [rad], a lane for each."""
    return enclose_at(response, space, [phi + space.constant(list_angles([offset])) for offset in response.offsets])


def enclose_at(response: EnclosedResponse, space: Space, angles: Sequence[Jet]) -> list[Jet]:
    """Return each quantity over a box from the angles [rad] of its shares, of the same lanes each."""
    count = angles[0].lanes
    sides, shares = range(1, len(angles)), _enclose_pieces(response, space, join_lanes(angles))
    space.jumping = np.asarray(space.jumping.reshape(-1, count).any(axis=0))
    return [
        sum((share.taken(slice(k * count, (k + 1) * count)) for k in sides), share.taken(slice(0, count)))
        for share in shares
    ]


def list_angles(turns: Sequence[Fraction]) -> Ball:
    """Return angles [rad] for angles in turns."""
    share = np.array([float(2 * turn) for turn in turns])
    return PI * Ball(share, U * np.abs(share))


def _enclose_pieces(response: EnclosedResponse, space: Space, phi: Jet) -> list[Jet]:
    """Return enclosures of the shares at angles (lanes,) [rad], each around all smooth pieces."""
    count = phi.lanes
    lanes, script = np.arange(count), np.empty((0, count))
    parts: list[tuple[Integers, list[Jet]]] = []
    inputs = response.prepare(space, phi)
    space.jumping = np.zeros(count, dtype=bool)
    while len(lanes):
        branches, jets = response.code.enclose(space, inputs, lanes, script)
        if not response.is_continuous:
            np.logical_or.at(space.jumping, lanes, branches.jumping)
        parts.append((lanes, [replace(jet.repeated(len(lanes)), space=space) for jet in jets]))
        further, script = branches.further()
        lanes = lanes[further]
        if sum(len(piece_lanes) for piece_lanes, _ in parts) > MAX_LANES * count:
            raise Unbounded("a box goes through many branches")
    quantities = range(len(parts[0][1]))
    return [_enclose_parts([(piece_lanes, jets[index]) for piece_lanes, jets in parts]) for index in quantities]


def _enclose_parts(parts: Sequence[tuple[Integers, Jet]]) -> Jet:
    """Return a jet around all parts: the first part has every lane, the others are pieces of some lanes."""
    (lanes, first), *pieces = parts
    felt = tuple(sorted({k for _, jet in parts for k in jet.felt}))
    hull = first.over(felt).taken(lanes)
    touched = np.zeros(len(lanes), dtype=bool)
    balls = [hull.value, hull.gradient, hull.hessian]
    bounds = [(ball.low, ball.high) for ball in balls] if pieces else []
    for piece_lanes, jet in pieces:
        touched[piece_lanes] = True
        piece = jet.over(felt).taken(np.arange(len(piece_lanes)))
        for (low, high), ball in zip(bounds, (piece.value, piece.gradient, piece.hessian), strict=True):
            np.minimum.at(low.T, piece_lanes, ball.low.T)
            np.maximum.at(high.T, piece_lanes, ball.high.T)
    if pieces:
        balls = [select_balls(touched, Ball.between(*side), ball) for side, ball in zip(bounds, balls, strict=True)]
    return Jet(hull.space, felt, *balls)


MAX_CHOICES = 60
"""Maximum number of combinations of angles, one for each extreme, at which an objective is bounded from below."""


@dataclass(frozen=True)
class Maximum:
    """The greatest value of a quantity over a cycle: it is nowhere below `points` (lanes), and one of `panels` (lanes).

    These are the same samples, or a few angles and what the quantity is anywhere in panels of all angles.
    """

    points: Jet
    panels: Jet

    @cached_property
    def order(self) -> Integers:
        """The points by their values at the centre, the greatest first."""
        return np.argsort(-self.points.value[CENTRE].mid, kind="stable")

    def find_span(self, part: int) -> tuple[float, float]:
        """Return between which values the greatest value is, at the centre of the box or anywhere in it."""
        return float(self.points.value[part].low.max()), float(self.panels.value[part].high.max())

    def find_slopes(self, felt: tuple[int, ...]) -> Ball:
        """Return what encloses the slopes of the greatest value: those of all panels that may have it."""
        panels = self.panels.over(tuple(sorted({*felt, *self.panels.felt})))
        lanes = np.flatnonzero((self.points.taken(self.order[:1]) - panels).lower_bound <= 0)
        places = [panels.felt.index(k) for k in felt]
        return panels.taken(lanes).gradient[ANYWHERE].spread()[places]


@dataclass(frozen=True)
class ObjectiveBounds:
    """Bounds of an objective over a box: `lower_bound` is below all values, `reached` above the value at the centre.

    `slopes` (p,) enclose the derivatives, at kinks the one-sided ones; `looseness` (p,) is the contribution of the
    width of each parameter to the looseness of the bounds. The slopes do not apply to an objective that `may_jump`,
    nor to an objective of which only a part is bounded.
    """

    lower_bound: float
    reached: float
    slopes: Ball
    looseness: Array
    may_jump: bool = False


def bound_objective(smooth: Jet, extremes: Sequence[Maximum]) -> ObjectiveBounds:
    """Return bounds of a smooth part (one lane) plus greatest values."""
    count = int(MAX_CHOICES ** (1 / max(1, len(extremes))))
    chosen = [extreme.order[:count] for extreme in extremes]
    total = smooth
    for extreme, lanes in zip(extremes, np.meshgrid(*chosen, indexing="ij"), strict=True):
        total = total + extreme.points.taken(lanes.ravel())
    moved = (k for extreme in extremes for k in extreme.panels.felt if smooth.space.half[k].any())
    total = total.over(tuple(sorted({*total.felt, *moved})))
    slopes = smooth.over(total.felt).gradient[ANYWHERE][:, 0]
    for extreme in extremes:
        slopes = slopes + extreme.find_slopes(total.felt)
    reached = smooth.value[CENTRE][0]
    for extreme in extremes:
        reached = reached + Ball.exact(extreme.find_span(CENTRE)[1])
    space = smooth.space
    half = space.half[list(total.felt)]
    curvature = (half * space.reach(total.felt, total.hessian.magnitude)).max(axis=-1)
    bounds = ObjectiveBounds(
        float(total.lower_bound.max()), float(reached.high), slopes, curvature + half[:, 0] * slopes.rad
    )
    return _expand_bounds(total, bounds)


def _expand_bounds(total: Jet, bounds: ObjectiveBounds) -> ObjectiveBounds:
    """Return the bounds with slopes and looseness of all parameters (p,), zero for parameters of zero width."""
    size, felt = len(total.space.lower), list(total.felt)
    mid, rad, loose = np.zeros(size), np.zeros(size), np.zeros(size)
    mid[felt], rad[felt], loose[felt] = bounds.slopes.mid, bounds.slopes.rad, bounds.looseness
    return ObjectiveBounds(bounds.lower_bound, bounds.reached, Ball(mid, rad), loose, total.space.may_jump)


def enclose_square(jet: Jet) -> Jet:
    """Return the squares, which are nowhere negative."""
    square = jet**2
    anywhere, power = square.value[ANYWHERE], jet.value[ANYWHERE].square()
    value = Ball.between(np.maximum(anywhere.low, power.low), np.minimum(anywhere.high, power.high))
    return square.holding(join_parts(square.value[CENTRE], value))
