"""Pitch curves by arc length, and pairs of them: of a stage, of circles, of measured radii."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from planter.errors import GeometryError
from planter.gears.geometry.pieces import Piece
from planter.gears.geometry.stage import Stage
from planter.kernels import Array, Integers, formulas
from planter.numerics import roots
from planter.numerics.arrays import TURN, to_degrees
from planter.numerics.piecewise import ChebyshevPanels, RoughFunctionError

RACK = formulas.load("rack_teeth")
"""Functions of pitch curves, and of the curves that a rack cuts on them."""
X, Y, TX, TY, KAPPA, POLAR = range(6)
"""Rows of a curve: point [m], unit tangent, curvature [1/m], polar angle [rad]."""
_JUMP_TOLERANCE = 1e-9
"""Share of the largest curvature below which a jump is rounding."""
_BREAK_TOLERANCE = 1e-9
"""Share below which two breakpoints are one."""
_SIDE_SHIFT = 1e-9
"""Shift towards the requested side of a breakpoint, as a share."""

Trace = Callable[[Array], tuple[Array, Array]]
"""Polar places (4, n) of a curve at parameters (n,), as `rack_teeth` takes them, and polar angle
per parameter (n,).
"""


@dataclass(frozen=True)
class PitchCurve:
    """A closed curve round its gear's axis, anticlockwise; `joints` are arc lengths in [0, L) where
    curvature jumps.
    """

    rows: ChebyshevPanels
    joints: Array

    @classmethod
    def from_trace(cls, trace: Trace, breaks: Array, sense: int) -> PitchCurve:
        """Return a curve whose polar angle runs anticlockwise (sense +1) or clockwise (-1) with its
        parameter.

        `breaks` are the parameters (m,) from its start to its end between which it is smooth.
        """

        def speed(u: Array) -> Array:
            polar, pace = trace(u)
            return RACK("pitch", polar_place=polar, sense=sense)["speed"][None] * pace

        length = ChebyshevPanels.fit(speed, breaks).integral
        at_ends = length(length.ends)[0]
        # rounding of the integral must not move the origin
        at_ends[0] = 0.0
        total = at_ends[-1]

        def rates(u: Array, index: Integers, arcs: Array) -> tuple[Array, Array]:
            return length(u, index)[0] - arcs, speed(u)[0]

        def rows(arcs: Array) -> Array:
            passed = arcs if sense > 0 else total - arcs
            polar, _ = trace(_find_places(length.ends, at_ends, rates, passed))
            columns = list(RACK("pitch", polar_place=polar, sense=sense).values())[:5]
            angle = polar[0] if sense > 0 else TURN - polar[0]
            return np.array([*columns, angle])

        ends = at_ends if sense > 0 else total - at_ends[::-1]
        return cls.from_panels(ChebyshevPanels.fit(rows, ends))

    @classmethod
    def from_panels(cls, rows: ChebyshevPanels) -> PitchCurve:
        """Return a curve with breakpoints at the ends of panels with different curvature."""
        count = np.arange(len(rows.series))
        start, end = rows(rows.ends[:-1], count)[KAPPA], rows(rows.ends[1:], count)[KAPPA]
        jump = np.abs(start - np.roll(end, 1)) > _JUMP_TOLERANCE * np.abs(start).max()
        return cls(rows, rows.ends[:-1][jump])

    @property
    def length(self) -> float:
        return float(self.rows.ends[-1])

    def at(self, s: Array, towards: Array | None = None) -> Array:
        """Return rows (6, n) at arc lengths (n,) [m] of any turn, on the side of breakpoints that
        lies `towards` (n,) " "[m].
        """
        arcs, panel, turns = self._locate(s, towards)
        rows = self.rows(arcs, panel)
        rows[POLAR] += TURN * turns
        return rows

    def _locate(self, s: Array, towards: Array | None) -> tuple[Array, Integers, Array]:
        """Return arc lengths (n,) within the first turn, their panels, and whole turns."""
        # the shift only chooses the panel; the rows are those of the arc length itself
        seen = s if towards is None else s + _SIDE_SHIFT * (towards - s)
        turns = np.floor(seen / self.length)
        past = turns * self.length
        return s - past, self.rows.panel(seen - past), turns

    def arc(self, polar: Array) -> Array:
        """Return arc lengths (n,) [m] at polar angles (n,) [rad] of any turn."""
        turns = np.floor(polar / TURN)
        return self.arc_within(polar - TURN * turns) + turns * self.length

    def arc_within(self, polar: Array) -> Array:
        """Return arc lengths (n,) [m] at polar angles (n,) [rad] between those of its ends."""
        slope = self.rows.slope

        def rates(s: Array, index: Integers, angles: Array) -> tuple[Array, Array]:
            return self.rows(s, index)[POLAR] - angles, slope(s, index)[POLAR]

        return _find_places(self.rows.ends, self._starts, rates, polar)

    @cached_property
    def _starts(self) -> Array:
        """Polar angles at the ends of the panels."""
        count = np.arange(len(self.rows.series))
        return np.append(
            self.rows(self.rows.ends[:-1], count)[POLAR], self.rows(self.rows.ends[-1:])[POLAR]
        )

    def bends(self, s: Array, towards: Array | None = None) -> Array:
        """Return curvature [1/m] and its first two derivatives by arc length (3, n), on the side
        that lies " "`towards`.
        """
        arcs, panel, _ = self._locate(s, towards)
        first = self.rows.slope
        return np.array([part(arcs, panel)[KAPPA] for part in (self.rows, first, first.slope)])

    def scaled(self, factor: float) -> PitchCurve:
        """Return the curve with all lengths multiplied by a factor."""
        factors = np.array([factor, factor, 1.0, 1.0, 1 / factor, 1.0])
        return PitchCurve(
            ChebyshevPanels(self.rows.ends * factor, self.rows.series * factors[:, None]),
            self.joints * factor,
        )

    def part(self, low: float, high: float) -> Piece:
        """Return the curve between two of its arc lengths [m]."""
        return Piece("pitch curve", lambda s: self.at(low + (high - low) * s)[:POLAR])


def _find_places(
    places: Array,
    values: Array,
    rates: Callable[[Array, Integers, Array], tuple[Array, Array]],
    targets: Array,
) -> Array:
    """Return the places (n,) at which a rising function has target values (n,).

    It has `values` (m,) at the `places` (m,) between which it is smooth; `rates` returns how far it
    is from the targets, and its slope, on intervals by their numbers.
    """
    index = np.clip(np.searchsorted(values, targets, "right") - 1, 0, len(values) - 2)
    # at an end itself rounding may give the bracket the wrong sign
    low, high = np.minimum(values[index] - targets, -0.0), values[index + 1] - targets
    return roots.find_bracketed_roots(
        lambda x: rates(x, index, targets),
        places[index],
        places[index + 1],
        (low, np.maximum(high, 0.0)),
    )


Contact = Callable[[Array], Array]
"""Radius, its two derivatives, ratio, its derivative, and the mate's rotation (6, n) at polar
angles (n,) of a gear.
"""


@dataclass(frozen=True)
class CurvePair:
    """A gear's pitch curve and its mate's, the distance of their axes [m], and the sense of the
    gear's polar angle.

    At rolling length s the gear touches at its arc length sense * s, the mate at -sense * s.
    """

    gear: PitchCurve
    mate: PitchCurve
    distance: float
    sense: int = 1

    @property
    def curves(self) -> tuple[PitchCurve, PitchCurve]:
        return self.gear, self.mate

    @property
    def senses(self) -> tuple[int, int]:
        """Signs of both curves' arc length relative to the rolling length."""
        return self.sense, -self.sense

    def scaled(self, factor: float) -> CurvePair:
        """Return the pair with all lengths multiplied by a factor."""
        return CurvePair(
            self.gear.scaled(factor), self.mate.scaled(factor), self.distance * factor, self.sense
        )


def build_contact(radii: Callable[[Array], Array], distance: float, breaks: Array) -> Contact:
    """Return the contact of a gear by its radius and two derivatives (3, n) at polar angles (n,),
    smooth between breaks (m,) [rad], with the axes at a distance [m].
    """

    def ratios(t: Array) -> Array:
        r, dr, _ = radii(t)
        return np.array(list(RACK("rolling", r=r, dr=dr, a=distance).values()))

    turned = ChebyshevPanels.fit(lambda t: ratios(t)[:1], breaks).integral
    return lambda t: np.vstack([radii(t), ratios(t), turned(t)])


def trace_pair(contact: Contact, distance: float) -> tuple[Trace, Trace]:
    """Return the traces of a contact's gear and of its mate, at a distance of the axes [m]."""

    def gear(t: Array) -> tuple[Array, Array]:
        return np.vstack([t, contact(t)[:3]]), np.ones_like(t)

    def mate(t: Array) -> tuple[Array, Array]:
        columns = contact(t)
        return np.array(list(RACK("mate", contact=columns, a=distance).values())), columns[3]

    return gear, mate


def build_contact_pair(
    contact: Contact,
    distance: float,
    breaks: Array,
    sense: int = 1,
    turns: int = 1,
    mate_turns: int = 1,
) -> CurvePair:
    """Build the pair of a contact that is smooth between breaks (m,) [rad].

    The mate turns `mate_turns` times in `turns`, one of which is 1.
    """

    gear, mate = trace_pair(contact, distance)
    # a faster mate closes within a part of the gear's turn, a slower one needs several
    end = breaks[0] + TURN * turns / mate_turns
    all_turns = np.concatenate([breaks[:-1] + TURN * k for k in range(turns)])
    all_turns = np.append(all_turns[all_turns < end * (1 - _BREAK_TOLERANCE)], end)
    return CurvePair(
        PitchCurve.from_trace(gear, breaks, sense),
        PitchCurve.from_trace(mate, all_turns, -sense),
        float(distance),
        sense,
    )


def place_gears(turned: Array, mate_turned: Array, distance: float) -> tuple[Array, Array]:
    """Return angle [rad] and axis [m] (3, n) of both gears, the line of centres along x, from the
    polar angles (n,) [rad] at which they touch.
    """
    zero = np.zeros_like(turned)
    return (
        np.array([-turned, zero, zero]),
        np.array([np.pi - mate_turned, zero + distance, zero]),
    )


def build_stage_pair(stage: Stage, parameters: Array, sense: int = 1) -> CurvePair:
    """Build the pair of a gear stage with its parameters (q,) in SI, with separate segments of the
    deformed curve.
    """
    hoisted = stage.prologue(parameters=parameters)["hoisted"]

    def contact(t: Array) -> Array:
        return np.vstack(list(stage.contact(t=t, parameters=parameters, hoisted=hoisted).values()))

    joint = stage.polar(u=np.array([np.pi]), parameters=parameters)["t_first"][0, 0]
    return build_contact_pair(contact, hoisted[0, 0], np.array([0.0, joint, TURN]), sense)


def build_circle_pair(radius: float, mate: float) -> CurvePair:
    """Build the pair of two circles by their radii [m]."""

    def trace_circle(r: float, sense: int) -> PitchCurve:
        def trace(t: Array) -> tuple[Array, Array]:
            still = np.zeros_like(t)
            return np.array([t, still + r, still, still]), np.ones_like(t)

        return PitchCurve.from_trace(trace, np.linspace(0, TURN, 3), sense)

    return CurvePair(trace_circle(radius, 1), trace_circle(mate, -1), radius + mate)


_SLOPE_SAMPLES = 9
"""Points between neighbouring samples at which the curve is checked."""
_BRACKET_MARGIN = 1e-9
"""Share by which the bracket of the centre distance is widened, because that of a circle is at its
end.
"""


MAX_SLOPE_ANGLE = np.radians(80)
"""Largest angle [rad] between a pitch curve and the circle about its axis: at a pressure angle of
10 deg the normals of flanks then pass through the axis, and no torque turns the gear.
"""
MAX_HALVINGS = 8
"""How often the gap between the gear's largest radius and the mate's axis is halved, from `turns`
of those radii, until the mate turns too far: a pitch curve closer to its axis cannot carry
teeth.
"""


CORNER_RATIO = 8.0
"""Ratio of the change of the radius's slope at a row to those two and three rows away from which on
it is a corner: smooth features of three rows or more stay below 4.
"""
CORNER_ANGLE = np.radians(0.5)
"""Smallest corner [rad]: above the rounding of tables with three decimals of a millimetre and steps
of a degree.
"""
CORNER_SPAN = np.radians(45)
"""Widest span of seven rows [rad] in which a corner is told from a curve with few points."""
REPEATS = 1e-4
"""Share of the radius by which a curve that repeats may differ from itself."""


class SampledRadius:
    """Radii (n,) [m] at polar angles (n,) [rad] that rise by less than a turn, joined by a periodic
    spline; the gear's own polar angles run in a `sense`. Errors begin with `name`.
    """

    def __init__(self, polar: Array, radius: Array, name: str, sense: int = 1) -> None:
        self.polar, self.radius, self.name, self.sense = polar, radius, name, sense
        self.knots: Array = np.append(polar, polar[0] + TURN) - polar[0]
        closed = np.append(radius, radius[0])
        self.curve = scipy.interpolate.CubicSpline(self.knots, closed, bc_type="periodic")

    def build_pair(self, turns: int = 1, mate_turns: int = 1) -> CurvePair:
        """Return the pair whose mate turns `mate_turns` times in `turns`, one of which is 1.

        The gear of the pair is always the faster one: with several `mate_turns` it is the mate.
        Raises GeometryError if the curve has a corner, reaches its axis, is too steep for any
        teeth, does not repeat as often as the mate turns, or has no centre distance that closes the
        mate.
        """
        self._check_slope()
        self._check_repeats(mate_turns)
        try:
            distance = self.find_centre_distance(turns / mate_turns)
            self._check_corners()
            pair = self._roll(distance, turns, mate_turns)
        except RoughFunctionError as error:
            raise GeometryError(
                f"{self.name}: the curve through the points is too rough to be rolled on: {error}"
            ) from error
        if mate_turns == 1:
            return pair
        return CurvePair(pair.mate, pair.gear, pair.distance, -pair.sense)

    def find_centre_distance(self, turns: float) -> float:
        """Return the distance of the axes [m] at which the mate turns once in `turns`.

        Raises GeometryError without one.
        """
        high = float(self.curve(self._sample_angles()).max())

        def over(distance: float) -> float:
            contact = build_contact(self._radii, distance, self.knots)
            return float(contact(self.knots[-1:])[-1, 0] - TURN / turns)

        # near the largest radius the ratio has a pole: the bracket is searched from the other end
        farther = high * (1 + turns) * (1 + _BRACKET_MARGIN)
        for gap in turns * 0.5 ** np.arange(1, MAX_HALVINGS + 1):
            nearer = high * (1 + gap)
            if over(nearer) >= 0:
                return float(scipy.optimize.brentq(over, nearer, farther, xtol=1e-18, rtol=1e-15))
            farther = nearer
        raise GeometryError(
            f"{self.name}: no mate rolls on this curve: where its radius is largest, "
            f"{high * 1e3:.4g} mm, the mate's would be below {gap * high * 1e3:.3g} mm; reduce the "
            "largest radius"
        )

    def find_repeat(self, parts: int) -> tuple[int, float]:
        """Return the point whose radius differs most from that a part of a turn later, and that
        radius [m].
        """
        later = self.curve(np.mod(self.polar - self.polar[0] + TURN / parts, TURN))
        worst = int(np.argmax(np.abs(later - self.radius)))
        return worst, float(later[worst])

    def _radii(self, t: Array) -> Array:
        """Return the radius and its derivatives (3, n) at angles (n,) [rad] from the first point."""
        return np.array([self.curve(t, order) for order in range(3)])

    def _roll(self, distance: float, turns: int, mate_turns: int) -> CurvePair:
        """Return the pair with the axes at a distance [m]."""
        within_turn = build_contact(self._radii, distance, self.knots)

        def contact(t: Array) -> Array:
            rows = within_turn(np.mod(t, TURN))
            rows[-1] += np.floor(t / TURN) * TURN * mate_turns / turns
            return rows

        return build_contact_pair(contact, distance, self.knots, self.sense, turns, mate_turns)

    def _sample_angles(self) -> Array:
        """Return angles [rad] from the first point at which the curve is checked."""
        shares = np.linspace(0, 1, _SLOPE_SAMPLES)
        angles: Array = self.knots[:-1, None] + np.diff(self.knots)[:, None] * shares
        return angles.ravel()

    def _describe_row(self, number: int) -> str:
        return f"at the polar angle {np.degrees(self.sense * self.polar[number]):.4g} deg"

    def _describe_place(self, place: float) -> str:
        angle = self.sense * (self.polar[0] + place)
        return f"at the polar angle {to_degrees(angle):.4g} deg"

    def _check_repeats(self, parts: int) -> None:
        """Raise GeometryError if the curve does not repeat a number of times in a turn."""
        worst, later = self.find_repeat(parts)
        radius = self.radius[worst]
        if abs(later - radius) > REPEATS * radius:
            raise GeometryError(
                f"{self.name}: the mate turns {parts} times in a turn, so the radius must repeat "
                f"after {360 / parts:.6g} deg, but it is {radius * 1e3:.6g} mm "
                f"{self._describe_row(worst)} and {later * 1e3:.6g} mm there"
            )

    def _check_corners(self) -> None:
        """Raise GeometryError if the radii have a corner, through which a spline would swing."""
        steps = np.diff(self.polar, append=self.polar[0] + TURN)
        slopes = np.diff(self.radius, append=self.radius[0]) / steps
        bends = slopes - np.roll(slopes, 1)
        # a smooth curve bends in proportion to the steps, a corner does not
        rates = 2 * np.abs(bends) / (steps + np.roll(steps, 1))
        neighbours = np.max([np.roll(rates, shift) for shift in (-3, -2, 2, 3)], axis=0)
        span = sum(np.roll(steps, shift) for shift in range(-2, 4))
        # a corner between two rows bends at both of them
        before, after = np.roll(bends, 1), np.roll(bends, -1)
        bend = bends + np.where(np.abs(before) > np.abs(after), before, after)
        turn = np.arctan(np.abs(bend) / self.radius)
        is_sharp = (rates > CORNER_RATIO * neighbours) & (turn > CORNER_ANGLE)
        is_corner = is_sharp & (span <= CORNER_SPAN)
        if is_corner.any():
            worst = int(np.argmax(np.where(is_corner, turn, 0.0)))
            raise GeometryError(
                f"{self.name}: the radius has a corner {self._describe_row(worst)}, "
                f"where its direction changes by {np.degrees(turn[worst]):.3g} deg from row to "
                "row, but hardly beside it; a pitch curve must be smooth: round the corner over several "
                "rows, or state more rows there"
            )

    def _check_slope(self) -> None:
        """Raise GeometryError if the curve reaches its axis or is too steep for teeth."""
        places = self._sample_angles()
        radius, slope = self.curve(places), self.curve(places, 1)
        smallest, steep = int(np.argmin(radius)), int(np.argmax(np.abs(slope) / radius))
        if radius[smallest] <= 0:
            raise GeometryError(
                f"{self.name}: the curve through the points has a radius of "
                f"{radius[smallest] * 1e3:.4g} mm "
                f"{self._describe_place(places[smallest])}: it must be above 0"
            )
        angle = np.arctan(np.abs(slope[steep]) / radius[steep])
        if angle > MAX_SLOPE_ANGLE:
            raise GeometryError(
                f"{self.name}: the curve through the points is {np.degrees(angle):.4g} deg from a "
                f"circle about its axis {self._describe_place(places[steep])}; it "
                f"must be at most {np.degrees(MAX_SLOPE_ANGLE):g} deg for teeth to turn it"
            )
