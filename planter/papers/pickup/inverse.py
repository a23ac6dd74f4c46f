"""From points of the tip's path to the mechanism that draws it.

Nothing here knows where the points come from.

Extremes of the tip's distance from the sun's centre give both bars; at every point the triangle of
the bars gives the angles of arm and carrier, and a spline of the fifth degree joins them to a law.
While the arm dwells the tip's distance is constant: such points lie on a circle, and the dwell
begins and ends where the law of the others reaches their angle. At these ends the path has corners,
so no spline is laid across them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from planter.errors import ComputationError, InputError
from planter.kernels import Array, Integers
from planter.kernels.formulas import load
from planter.numerics.arrays import TURN, wrap_angle
from planter.papers.pickup.law import MODEL, Dwell, SplineLaw

DEGREE = 3
NEAR = 1e-6
"""Part of the curve's length around an extreme in which differences to it are taken from their
series.
"""


@dataclass(frozen=True)
class DistanceExtreme:
    """An extreme of the distance from O: parameter, place (2,), and whether it is a maximum."""

    u: float
    place: Array
    highest: bool

    @property
    def distance(self) -> float:
        return float(np.hypot(*self.place))


def chord_lengths(points: Array, closed: bool) -> Array:
    """Distances from each point (n, 2) to the next, (n,), or (n - 1,) for an open curve."""
    ring = np.vstack([points, points[:1]]) if closed else points
    return np.hypot(*np.diff(ring, axis=0).T)


def best_spline(points: Array, closed: bool) -> PathSpline:
    """The spline over chord length or over the points' own numbers: that which better foretells
    every other point.

    If the tip stops, its path has a cusp, which no smooth curve over chord length is near; over
    numbers of points that follow each other evenly it is smooth.
    """
    lengths = np.concatenate([[0.0], np.cumsum(chord_lengths(points, closed))])
    numbers = np.arange(len(lengths), dtype=float)
    parameter = min((numbers, lengths), key=lambda taken: _miss(taken[: len(points)], points))
    return PathSpline(points, closed, parameter)


def _miss(parameter: Array, points: Array) -> float:
    """Root mean square distance of every other point from the curve through those between."""
    curve = scipy.interpolate.make_interp_spline(parameter[::2], points[::2], k=DEGREE)
    odd = slice(1, len(points) - 1, 2)
    return float(np.sqrt(np.mean((curve(parameter[odd]) - points[odd]) ** 2)))


@dataclass(frozen=True)
class PathSpline:
    """The curve through value points (n, 2) in m; `closed` joins the last to the first with two
    derivatives.

    `parameter` (n,), or (n + 1,) for a closed curve, is increasing; without one it is the
    cumulative chord length.
    """

    points: Array
    closed: bool = True
    parameter: Array | None = None

    @cached_property
    def knots(self) -> Array:
        """The parameter at the value points, from 0; a closed curve has one more, where it meets
        its beginning.
        """
        if self.parameter is not None:
            return self.parameter - self.parameter[0]
        return np.concatenate([[0.0], np.cumsum(chord_lengths(self.points, self.closed))])

    @cached_property
    def curve(self) -> scipy.interpolate.BSpline:
        if self.closed:
            ring = np.vstack([self.points, self.points[:1]])
            return scipy.interpolate.make_interp_spline(
                self.knots, ring, k=DEGREE, bc_type="periodic"
            )
        return scipy.interpolate.make_interp_spline(self.knots, self.points, k=DEGREE)

    @property
    def length(self) -> float:
        """Length of the parameter's range."""
        return float(self.knots[-1])

    def __call__(self, u: Any, derivative: int = 0) -> Array:
        """Places (m, 2), or derivatives of them in the parameter."""
        return np.asarray(self.curve(np.asarray(u, dtype=float), derivative))

    @cached_property
    def _pieces(self) -> list[scipy.interpolate.PPoly]:
        return [
            scipy.interpolate.PPoly.from_spline((self.curve.t, self.curve.c[:, axis], DEGREE))
            for axis in (0, 1)
        ]

    def extremes(self, tolerance: float) -> list[DistanceExtreme]:
        """Extremes of the distance from O by parameter: roots of S .

        S', without those that differ by less.
        """
        roots = [
            DistanceExtreme(float(u), self(u), self._bend(u) < 0)
            for u in self._roots()
            if self._bend(u) != 0
        ]
        alternating = _alternating(roots, self.closed)
        left = find_prominent_extrema(
            np.array([extreme.distance for extreme in alternating]), tolerance, self.closed
        )
        return [alternating[i] for i in left]

    def _roots(self) -> Array:
        """Return the parameters where S . S' vanishes: its pieces are of the fifth degree."""
        first, second = self._pieces
        powers = np.zeros((6, len(first.x) - 1))
        for piece in (first, second):
            slopes = piece.derivative().c
            for i, coefficient in enumerate(piece.c):
                powers[i : i + 3] += coefficient * slopes
        product = scipy.interpolate.PPoly(powers, first.x)
        roots = product.roots(extrapolate=False)
        roots = roots[np.isfinite(roots)]
        slopes = product.derivative()(roots)
        # One step of Newton's method; what lies beyond the ends by rounding lies at the ends.
        roots = roots - np.divide(product(roots), slopes, out=0 * roots, where=slopes != 0)
        slack = 1e-9 * self.length
        inside = (roots >= -slack) & (roots <= self.length + slack)
        return np.unique(np.clip(roots[inside], 0.0, self.length))

    def _taylor(self, u: float, inside: float) -> Array:
        """Coefficients (4, 2) of the piece that holds `inside`, in powers of the distance from
        `u`.
        """
        pieces = self._pieces
        i = int(
            np.clip(
                np.searchsorted(pieces[0].x, inside, side="right") - 1, 0, pieces[0].c.shape[1] - 1
            )
        )
        shift = u - pieces[0].x[i]
        local = [
            np.polynomial.Polynomial(p.c[::-1, i])(np.polynomial.Polynomial([shift, 1.0]))
            for p in pieces
        ]
        return np.array([np.pad(poly.coef, (0, 4 - len(poly.coef))) for poly in local]).T

    def _bend(self, u: float) -> float:
        """Second derivative of half the squared distance."""
        return float(np.sum(self(u, 1) ** 2) + self(u) @ self(u, 2))

    def square_less(self, u: Array, extreme: DistanceExtreme) -> Array:
        """|S(u)|^2 less its value at an extreme, (m,); near the extreme by its series, which loses
        no digits.

        An extreme beyond the curve's end is that of a dwell, which the curve meets at an angle.
        """
        offsets = self._offsets(u, extreme)
        gap = self(u) - extreme.place
        plain = np.sum(gap * (self(u) + extreme.place), axis=1)
        on_curve = extreme.u <= self.length
        for i in np.flatnonzero(on_curve & (np.abs(offsets) < NEAR * self.length)):
            x = float(offsets[i])
            _, slope, bend, third = self._taylor(extreme.u, extreme.u + x / 2)
            step = x * (slope + x * (bend + x * third))
            plain[i] = 2 * extreme.place @ (x * x * (bend + x * third)) + step @ step
        return plain

    def _offsets(self, u: Array, extreme: DistanceExtreme) -> Array:
        offsets = np.asarray(u, dtype=float) - extreme.u
        return (
            (offsets + self.length / 2) % self.length - self.length / 2 if self.closed else offsets
        )


def _alternating(extremes: list[DistanceExtreme], closed: bool) -> list[DistanceExtreme]:
    """Return the extremes without the lesser of two neighbours of one kind, which roots at
    breakpoints may leave.
    """
    retained: list[DistanceExtreme] = []
    for extreme in extremes:
        if retained and retained[-1].highest == extreme.highest:
            extreme = _further(retained.pop(), extreme)
        retained.append(extreme)
    if closed and len(retained) > 1 and retained[0].highest == retained[-1].highest:
        last = retained.pop()
        retained[0] = _further(retained[0], last)
    return retained


def _further(a: DistanceExtreme, b: DistanceExtreme) -> DistanceExtreme:
    return a if (a.distance > b.distance) == a.highest else b


def find_prominent_extrema(values: Array, tolerance: float, closed: bool) -> Integers:
    """Places of the maxima and minima, which take turns in `values` (m,), that no ripple makes.

    As long as two neighbours differ by less than the tolerance, the least such pair goes, and the
    next ones become neighbours; in a `closed` course the last is the first's.
    """
    left = np.arange(len(values))
    while len(left) > 1:
        ring = np.append(left, left[:1]) if closed else left
        steps = np.abs(np.diff(values[ring]))
        k = int(steps.argmin())
        if steps[k] >= tolerance:
            break
        left = np.delete(left, [k, (k + 1) % len(left)])
    return left


LAW_DEGREE = 5
LEAST_TOOTHED = 8
SHOWN = 4
"""Places that a complaint names at most."""
TOLERANCE = 1e-7
"""How far distances may be apart that count as one [m]."""


@dataclass(frozen=True)
class Inversion:
    """Bars [m], direction of the carrier at the farthest tip [rad], the law from there on, and the
    path's spline.
    """

    L1: float
    L2: float
    phi5_far: float
    law: SplineLaw
    path: PathSpline


def invert_path(points: Array, tolerance: float = TOLERANCE, source: str = "path") -> Inversion:
    """The mechanism whose tip passes points (n, 2) in m, given in the order of a carrier that turns
    counter-clockwise.

    Raises InputError, naming `source`, where there is no such mechanism.
    """
    try:
        return _inverted(points, tolerance, source)
    except _TurnsBackError as error:
        raise InputError(f"{error}{_other_order(points, tolerance)}") from None


class _TurnsBackError(InputError):
    """The points are not in the order of a carrier that turns counter-clockwise."""


def _other_order(points: Array, tolerance: float) -> str:
    """A hint where the points taken the other way round are such a path."""
    try:
        _inverted(points[::-1], tolerance, "")
    except (InputError, ComputationError):
        return ""
    return " (in the opposite order they are such a path: turn the lines of the file round)"


def _inverted(points: Array, tolerance: float, source: str) -> Inversion:
    _check_outside(points, source)
    flat = find_plateau(points, tolerance)
    dwell, order = flat or (None, np.arange(len(points)))
    if len(order) < LEAST_TOOTHED:
        raise InputError(
            f"{source}: {len(order)} points outside the dwell are not enough: at least "
            f"{LEAST_TOOTHED}"
        )
    path = best_spline(points[order], closed=dwell is None)
    far, nearest = _extremes(path, dwell, points, tolerance, source)
    bars = load(MODEL).at("bars", L3_max=far.distance, L3_min=nearest.distance)
    chain = _Chain(path, far, nearest, np.array([bars["L1"], bars["L2"]]))
    phi5, phi1 = chain.angles(path.knots[: len(order)])
    _check_order(phi5, points[order], source)
    if dwell is None:
        _check_order(np.append(phi5, phi5[0] + TURN), points[order], source)
        phi5_far, law = _closed_law(chain, phi5, phi1)
    else:
        dwell_phi5, dwell_phi1 = chain.solve_dwell(points[dwell], phi5[-1])
        _check_order(
            np.array([*phi5, *dwell_phi5, phi5[0] + TURN]), points[[*order, *dwell]], source
        )
        phi5_far, law = _dwelling_law(
            chain, phi5, phi1, dwell_phi5, float(np.mean(dwell_phi1)), source
        )
    return Inversion(bars["L1"], bars["L2"], phi5_far % TURN, law, path)


def _extremes(
    path: PathSpline, dwell: Integers | None, points: Array, tolerance: float, source: str
) -> tuple[DistanceExtreme, DistanceExtreme]:
    """The farthest and the nearest place, of which there must be one each; either may be the dwell
    itself, whose points have the indices `dwell`.
    """
    extremes = path.extremes(tolerance)
    highs = [e for e in extremes if e.highest]
    lows = [e for e in extremes if not e.highest]
    if dwell is not None:
        place = points[dwell[len(dwell) // 2]]
        dwell_distance = float(np.hypot(*place))
        beyond = path.length * (1 + 1e-9)
        if not highs and len(lows) == 1:
            highs = (
                [DistanceExtreme(beyond, place, True)]
                if dwell_distance > np.hypot(*path.points.T).max() - tolerance
                else []
            )
        if not lows and len(highs) == 1:
            lows = (
                [DistanceExtreme(beyond, place, False)]
                if dwell_distance < np.hypot(*path.points.T).min() + tolerance
                else []
            )
    if len(highs) != 1 or len(lows) != 1:
        raise InputError(
            f"{source}: the distance of the points from the origin, which must be the sun's "
            f"centre, has {len(highs)} maxima and {len(lows)} "
            f"minima{_describe_extremes(highs, lows)}: it must have one of each over the path, and "
            "may dwell once; if the points are not exact, path.tolerance_mm = "
            f"{tolerance * 1000:g} is too small"
        )
    if lows[0].distance <= tolerance:
        raise InputError(
            f"{source}: the path must not meet the origin: the sun's centre lies there"
        )
    return highs[0], lows[0]


@dataclass(frozen=True)
class _Chain:
    """Angles of the mechanism along a path."""

    path: PathSpline
    far: DistanceExtreme
    nearest: DistanceExtreme
    bars: Array

    def angles(self, u: Array) -> tuple[Array, Array]:
        """Directions phi5 of the carrier and angles phi1 of the arm, both counted on along the
        path.
        """
        way = self._way(u)
        short, over = -self.path.square_less(u, self.far), self.path.square_less(u, self.nearest)
        phi5, phi1 = self._solved(self.path(u), short, over, way)
        return np.unwrap(phi5), phi1 + TURN * (u >= self.far.u)

    def solve_dwell(self, places: Array, after: float) -> tuple[Array, Array]:
        """Return these angles in the dwell, which follows the path's end, where the carrier is at
        `after` [rad].
        """
        way = self._way(np.array([self.path.length]))
        square = np.sum(places**2, axis=1)
        short, over = self.far.distance**2 - square, square - self.nearest.distance**2
        phi5, phi1 = self._solved(places, short, over, np.broadcast_to(way, len(places)))
        phi5 = np.unwrap(np.concatenate([[after], phi5]))[1:]
        return phi5, phi1 + TURN * (self.path.length >= self.far.u)

    def _way(self, u: Array) -> Array:
        """1 where the tip goes from its farthest to its nearest place, -1 on the way back."""
        period = self.path.length * (1 if self.path.closed else 2)
        return np.where(
            (u - self.far.u) % period < (self.nearest.u - self.far.u) % period, 1.0, -1.0
        )

    def _solved(self, places: Array, short: Array, over: Array, way: Array) -> tuple[Array, Array]:
        x, y = places.T
        clipped = {"short": np.maximum(short, 0), "over": np.maximum(over, 0)}
        angles = load(MODEL)("inverse", x_S=x, y_S=y, way=way, bars=self.bars, **clipped)
        return angles["phi5"], angles["phi1"]

    def direction(self, near_to: float) -> float:
        """Direction of the carrier at the farthest place, that of the tip, in the turn that a guess
        lies in.
        """
        raw = float(np.arctan2(*self.far.place[::-1]))
        return raw + TURN * round((near_to - raw) / TURN)


def _describe_extremes(highs: Sequence[DistanceExtreme], lows: Sequence[DistanceExtreme]) -> str:
    """Return the positions of the first extremes as text."""
    extremes = [*highs[:SHOWN], *lows[:SHOWN]]
    return f" (at {', '.join(_place(extreme.place) for extreme in extremes)})" if extremes else ""


def _place(point: Array) -> str:
    return f"({point[0] * 1000:.5g}, {point[1] * 1000:.5g}) mm"


def _check_outside(points: Array, source: str) -> None:
    """Raise InputError for a path round the origin, which the tip cannot go: the planet's arm is
    the longer bar.
    """
    ring = np.vstack([points, points[:1]])
    steps = np.diff(np.arctan2(ring[:, 1], ring[:, 0]))
    if round(float(np.sum(wrap_angle(steps))) / TURN):
        raise InputError(
            f"{source}: the path goes round the origin, where the sun's centre lies, but it must "
            "leave it outside (are the points counted from there?)"
        )


def _check_order(phi5: Array, places: Array, source: str) -> None:
    """Raise _TurnsBackError unless the carrier's angles, from the dwell's end on, increase from
    place to place.
    """
    falls = np.flatnonzero(np.diff(phi5) <= 0)
    if len(falls):
        raise _TurnsBackError(
            f"{source}: the carrier would have to turn back at {len(falls)} of {len(places)} "
            f"points, the first at {_place(places[falls[0]])}: they must be in the order of a "
            "carrier that turns counter-clockwise, on a path that the mechanism can draw"
        )


def _closed_law(chain: _Chain, phi5: Array, phi1: Array) -> tuple[float, SplineLaw]:
    """A law without dwell: the lead of the arm over the carrier repeats after a turn."""
    far = chain.direction(float(np.interp(chain.far.u, chain.path.knots[:-1], phi5)))
    t, lead = phi5 - far, phi1 - phi5 + far - TURN
    ring, closed = np.append(t, t[0] + TURN), np.append(lead, lead[0])
    curve = scipy.interpolate.make_interp_spline(ring, closed, k=LAW_DEGREE, bc_type="periodic")
    curve.extrapolate = "periodic"
    return far, SplineLaw(curve, None, 0.0)


def _dwelling_law(
    chain: _Chain, phi5: Array, phi1: Array, held5: Array, held1: float, source: str
) -> tuple[float, SplineLaw]:
    """A law on teeth between the ends of the dwell, which are where it reaches the angle that is
    held.
    """
    begin, end = (float(held5[-1]) - TURN, held1 - TURN), (float(held5[0]), held1)
    arm = _spline(phi5, phi1)
    first, last = _meets(arm, begin, float(phi5[0])), _meets(arm, end, float(phi5[-1]))
    nodes = [begin] * (first is None) + list(zip(phi5, phi1, strict=True)) + [end] * (last is None)
    arm = _spline(*np.array(nodes).T)
    ends = begin[0] if first is None else first, end[0] if last is None else last
    if ends[1] - ends[0] >= TURN:
        raise ComputationError(f"{source}: the dwell that the points show has no length")
    if chain.far.u > chain.path.length:
        far = (ends[1] + ends[0] + TURN) / 2
    else:
        far = chain.direction(float(np.interp(chain.far.u, chain.path.knots, phi5)))
    turns = np.floor((ends[1] - far) / TURN)
    shift = far + turns * TURN
    lead = scipy.interpolate.BSpline(arm.t - shift, arm.c - _greville(arm) + far - TURN, arm.k)
    rest = Dwell(float(ends[1] - shift), float(ends[0] - shift + TURN))
    return far, SplineLaw(lead, rest, held1 - TURN - turns * TURN)


def _greville(curve: scipy.interpolate.BSpline) -> Array:
    """Coefficients of the spline on the same knots that gives its argument back."""
    return np.array([curve.t[i + 1 : i + 1 + curve.k].mean() for i in range(len(curve.c))])


def _spline(phi5: Array, phi1: Array) -> scipy.interpolate.BSpline:
    return scipy.interpolate.make_interp_spline(
        phi5, phi1, k=min(LAW_DEGREE, len(phi5) // 2 * 2 - 1)
    )


def _meets(
    arm: scipy.interpolate.BSpline, dwell_end: tuple[float, float], toothed: float
) -> float | None:
    """Return the angle at which a law reaches the arm's angle in the dwell, or None if it does not
    before the dwell.
    """
    angle, level = dwell_end
    if (arm(toothed) - level) * (arm(angle) - level) > 0:
        return None
    return float(
        scipy.optimize.brentq(
            lambda x: float(arm(x)) - level, toothed, angle, xtol=1e-15, rtol=1e-15
        )
    )


LEAST_SWEEP = np.radians(5)
"""Angle at the sun's centre that a run of equal distances must cover: near an extreme they are
nearly equal, too.
"""
LEAST_POINTS = 3


def find_plateau(points: Array, tolerance: float) -> tuple[Integers, Integers] | None:
    """Return the longest run of points (n, 2) of a closed path whose distances from the origin are
    equal: their indices in order, and those of the others from its end round to its start.
    """
    distance = np.hypot(*points.T)
    if np.ptp(distance) <= tolerance:
        return None
    begin, count = _longest(distance, tolerance)
    members = (begin + np.arange(count)) % len(points)
    if count < LEAST_POINTS or _sweep(points[members]) < LEAST_SWEEP:
        return None
    return members, (begin + count + np.arange(len(points) - count)) % len(points)


def _sweep(places: Array) -> float:
    """Angle that a run of places covers at the origin."""
    directions = np.unwrap(np.arctan2(places[:, 1], places[:, 0]))
    return float(abs(directions[-1] - directions[0]))


def _longest(distance: Array, tolerance: float) -> tuple[int, int]:
    """Start and length of the longest cyclic run whose values differ by the tolerance at most."""
    values = np.tile(distance, 2)
    begin, best = 0, (0, 0)
    for end in range(1, len(values) + 1):
        while np.ptp(values[begin:end]) > tolerance:
            begin += 1
        if end - begin > best[1]:
            best = begin, end - begin
    return best
