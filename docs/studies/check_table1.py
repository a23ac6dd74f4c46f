"""Proof that no device within the bounds of this study gives a row of Table 1 of Wang et al. (2017).

`python check_table1.py [--range N --variance N2]` needs python-flint and NumPy, and nothing of
planter. What it takes for granted is below: the laws of Newton, the device with the paper's gears
at constant speed (`GEARS`), and the bounds of the inputs that the paper does not publish (`LINEAR`,
`OPENING`, `RISE`, `FALL`; any law of `LAWS`). A test holds the force of this file against the
exact model at random inputs.

1. The support carries the weight and the rate of the vertical momentum of all bodies, whatever acts
   between them: springs, cams, teeth and friction do not enter. At constant speed w the force is
   F(phi) = W + w^2 (Y''(phi) + Y''(phi - pi)), where Y is the vertical moment of mass of a side.
   Hinges of planets and middle gears on the carrier cancel between both sides.
2. f = F - W has mean zero. With -l <= f <= h and l + h the range R,
   variance = mean(f^2) <= (h + l) mean|f| / 2 = R mean|f| / 2.
3. mean|f| <= (w^2 / pi) TV, where TV is the total variation of P = Y' over a turn.
4. Y is affine in each mass and in each length of `LINEAR`, so that TV is convex in each: it is
   largest in a corner of their bounds. Opening and cam angles are covered by boxes, on each of
   which arb encloses P and its slope. Where P is monotonic its variation is a difference.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from math import ceil, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from flint import acb, arb, ctx

BITS = 80
with ctx.workprec(BITS):
    PI = arb.pi()
    DEGREE = PI / 180
    SPEED = 40 * 2 * PI / 60  # of the carrier [rad/s]
GEARS = {
    "theta_deg": "65.744",
    "alpha3_deg": "25.467",
    "beta6_deg": "1.375",
    "R3_mm": "30.916",
    "e3_mm": "5.583",
    "m31": "1.542",
    "k6": "0.031",
    "m61": "1.26",
}
"""The paper's optimum, without what moves no body within its carrier's frame: gamma and A6."""
LINEAR = {
    "mass.middle_kg": (0.2, 2.0),
    "mass.planet_kg": (0.4, 4.0),
    "mass.half_C1_kg": (0.02, 0.4),
    "mass.half_C2_kg": (0.1, 1.2),
    "centroid.planet_xy_mm[0]": (-20, 60),
    "centroid.planet_xy_mm[1]": (-30, 30),
    "nozzle.hinge_A_mm[0]": (10, 60),
    "nozzle.C2_mm[0]": (40, 140),
    "nozzle.C2_mm[2]": (5, 40),
}
OPENING = (8, 30)
RISE = ((110, 140), (155, 200))
FALL = ((230, 255), (270, 320))
"""Beginnings and ends of the flanks in the cam angle [deg]."""
C1, C2_Y, MIDDLE = (-18, 30, 4), -4, (3, 200)
"""Centroids that do not vary: C1 and the middle coordinate of C2 from the hinge [mm]; of the middle
gears from their shaft [mm, deg].
"""
TABLE_1 = {"theory": ("122.17", "1907.32"), "experiment": ("147.03", "1033.23")}
JOINT = arb(0, 1e-15)
PRINTED = "0.005"
"""Half a unit of the last printed digit."""


def hull(*parts: arb) -> arb:
    """Return the smallest ball that holds all."""
    ball = parts[0]
    for part in parts[1:]:
        ball = ball.union(part)
    return ball


def span(low: Any, high: Any) -> arb:
    """Return the ball from a number to another."""
    return hull(arb(low), arb(high))


# Laws of a flank: (x) -> share of the rise, its first and second derivative, which are continuous at
# joints: a ball that passes one by its own rounding, below 1e-20, takes the other piece's values to
# `JOINT`, which is added.


def polynomial_345(x: arb) -> tuple[arb, arb, arb]:
    """The shortest polynomial without a jump of the acceleration."""
    y = arb(1) / 4 - (x - arb(1) / 2) ** 2
    return x**3 * (10 - 15 * x + 6 * x**2), 30 * y**2, 60 * y * (1 - 2 * x)


def polynomial_4567(x: arb) -> tuple[arb, arb, arb]:
    """The shortest polynomial without a jump of the jerk."""
    y = arb(1) / 4 - (x - arb(1) / 2) ** 2
    p = x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)
    return p, 140 * y**3, 420 * y**2 * (1 - 2 * x)


def harmonic(x: arb) -> tuple[arb, arb, arb]:
    """Half a cosine."""
    return (1 - (PI * x).cos()) / 2, PI * (PI * x).sin() / 2, PI**2 * (PI * x).cos() / 2


def cycloidal(x: arb) -> tuple[arb, arb, arb]:
    """A full sine of the acceleration."""
    y = 2 * PI * x
    return x - y.sin() / (2 * PI), 1 - y.cos(), 2 * PI * y.sin()


def modified_sine(x: arb) -> tuple[arb, arb, arb]:
    """Quarters of a fast sine at both ends, of a slow one between: joints at 1/8 and 7/8."""
    c, fast, slow, place = 1 / (PI + 4), 4 * PI * x, PI * (4 * x + 1) / 3, float(x.mid())
    if 1 / 8 < place < 7 / 8:
        p = c * (PI * x - 9 * slow.sin() / 4 + 2)
        return p, PI * c * (1 - 3 * slow.cos()), 4 * PI**2 * c * slow.sin()
    p = c * (PI * x - fast.sin() / 4 + (0 if place < 1 / 2 else 4))
    return p, PI * c * (1 - fast.cos()), 4 * PI**2 * c * fast.sin()


def modified_trapezoid(x: arb) -> tuple[arb, arb, arb]:
    """A trapezoid of the acceleration with corners of sines: joints at 1/8, 3/8, 5/8, 7/8."""
    c, y, place = 1 / (PI + 2), 4 * PI * x, float(x.mid())
    if place > 1 / 2:  # the second half mirrors the first
        p, dp, ddp = modified_trapezoid(1 - x)
        return 1 - p, dp, -ddp
    if place <= 1 / 8:
        return c * (2 * x - y.sin() / (2 * PI)), 2 * c * (1 - y.cos()), 8 * PI * c * y.sin()
    if place <= 3 / 8:
        start, z = c * (arb(1) / 4 - 1 / (2 * PI)), x - arb(1) / 8
        return start + 2 * c * z + 4 * PI * c * z**2, 2 * c + 8 * PI * c * z, 8 * PI * c
    p = c * (2 * PI * x + 2 * x + y.sin() / (2 * PI) - PI / 2)
    return p, 2 * c * (y.cos() + 1 + PI), -8 * PI * c * y.sin()


LAWS: dict[str, Callable[[arb], tuple[arb, arb, arb]]] = {
    "3-4-5 polynomial": polynomial_345,
    "4-5-6-7 polynomial": polynomial_4567,
    "cycloidal": cycloidal,
    "harmonic": harmonic,
    "modified sine": modified_sine,
    "modified trapezoid": modified_trapezoid,
}


class Curve(NamedTuple):
    """Half a pitch curve: ratio (u) -> its ratio to the conjugate and slope, and the inverse of the
    integral of the ratio from 0, both in [0, pi].
    """

    ratio: Callable[[arb], tuple[arb, arb]]
    inverse: Callable[[arb], arb]
    integral: Callable[[arb], arb]


class Stage:
    """A pair of gears whose driver has a curve with the deformation m: u = m t, then m2 (2 pi - t)."""

    def __init__(self, curve: Curve, deformation: arb) -> None:
        self.curve, self.m = curve, deformation
        self.m2 = deformation / (2 * deformation - 1)

    def turn(self, t: arb) -> arb:
        """Return the rotation of the conjugate to an angle t in the first segment of the driver."""
        if not self.m * t < PI:
            raise ValueError(f"{t} is not in the first segment")
        return self.curve.integral(self.m * t) / self.m

    def invert(self, turned: arb) -> arb:
        """Return the driver's angle for a point of the conjugate's rotation."""
        turns = int((turned / (2 * PI)).floor().mid().str(10, radius=False).split(".")[0])
        rest = turned - 2 * PI * turns
        zero = arb(0)
        first = self.curve.inverse((self.m * rest).min(PI).max(zero)) / self.m
        second = (
            2 * PI - self.curve.inverse((self.m2 * (2 * PI - rest)).min(PI).max(zero)) / self.m2
        )
        joint = PI / self.m
        if rest < joint:
            return first + 2 * PI * turns
        return (second if rest > joint else hull(first, second)) + 2 * PI * turns

    def ratio(self, t: arb) -> tuple[arb, arb]:
        """Return the ratio and its slope over an interval of the driver's angle."""
        parts = list(self._divide(t))
        return hull(*(value for value, _ in parts)), hull(*(slope for _, slope in parts))

    def _divide(self, t: arb) -> Iterator[tuple[arb, arb]]:
        low, high = t.lower(), t.upper()
        for turns in range(int(float(low) // (2 * pi)) - 1, int(float(high) // (2 * pi)) + 2):
            ends = 2 * PI * turns, 2 * PI * turns + PI / self.m, 2 * PI * (turns + 1)
            for start, end, factor, origin in (
                (ends[0], ends[1], self.m, ends[0]),
                (ends[1], ends[2], -self.m2, ends[2]),
            ):
                if high < start or low > end:
                    continue
                u = factor * (span(low.max(start), high.min(end)) - origin)
                value, slope = self.curve.ratio(u)
                yield value, factor * slope


def build_ellipse(k: arb) -> Curve:
    """Return the curve of an ellipse about its focus, whose ratio is Poisson's kernel."""

    def turn(u: arb, sign: int) -> arb:
        return u + sign * 2 * (k * u.sin() / (1 - sign * k * u.cos())).atan()

    def ratio(u: arb) -> tuple[arb, arb]:
        below = 1 + k**2 - 2 * k * u.cos()
        value = (1 - k**2) / below
        return value, -value * 2 * k * u.sin() / below

    return Curve(ratio, lambda v: turn(v, -1), lambda u: turn(u, 1))


def build_circle(radius: arb, eccentricity: arb, count: int = 1024) -> Curve:
    """Return the curve of an eccentric circle, whose centre distance makes the mean ratio 1."""

    def radii(u: Any) -> Any:
        return eccentricity * u.cos() + (radius**2 - (eccentricity * u.sin()) ** 2).sqrt()

    def integrate(low: arb, high: arb, distance: arb) -> arb:
        def integrand(u: acb, _: bool) -> acb:
            r = radii(u)
            return r / (distance - r)

        return acb.integral(integrand, low, high).real

    bracket = arb(2) * radius, arb(3) * radius
    for _ in range(70):
        middle = ((bracket[0] + bracket[1]) / 2).mid()
        gap = integrate(arb(0), PI, middle) - PI
        if not (gap > 0 or gap < 0):
            break
        bracket = (middle, bracket[1]) if gap > 0 else (bracket[0], middle)
    distance = span(*bracket)

    def ratio(u: arb) -> tuple[arb, arb]:
        r, sine, cosine = radii(u), u.sin(), u.cos()
        root = (radius**2 - (eccentricity * sine) ** 2).sqrt()
        slope = -eccentricity * sine - eccentricity**2 * sine * cosine / root
        return r / (distance - r), slope * distance / (distance - r) ** 2

    nodes = [PI * i / count for i in range(count + 1)]
    turned = [arb(0)]
    for low, high in itertools.pairwise(nodes):
        turned.append(turned[-1] + integrate(low, high, distance))
    starts = [float(value.lower()) for value in turned]

    def invert(v: arb) -> arb:
        index = int(np.searchsorted(starts, float(v.mid()))) - 1
        index = min(max(index, 0), count - 1)
        around = span(nodes[max(index - 1, 0)], nodes[min(index + 2, count)])
        return nodes[index] + (v - turned[index]) / ratio(around)[0]  # by the mean value theorem

    return Curve(ratio, invert, lambda u: integrate(arb(0), u, distance))


class Motion(NamedTuple):
    """What the gears decide at a cam angle: sine and cosine of alpha, the angle of the nozzle's axis
    clockwise from x; the direction of the middle gears' centroid with two derivatives in the
    carrier's angle; and the first and second derivative of the cam angle in it.
    """

    sine: arb
    cosine: arb
    middle: arb
    middle_rate: tuple[arb, arb]
    rate: arb
    rise: arb


class Train:
    """The two stages: cam angle -> motion. Angles are counted from the carrier's position 0."""

    def __init__(self, gears: dict[str, str] = GEARS) -> None:
        values = {name: arb(text) for name, text in gears.items()}
        circle = build_circle(values["R3_mm"] / 1000, values["e3_mm"] / 1000)
        self.first = Stage(circle, values["m31"])
        self.second = Stage(build_ellipse(values["k6"]), values["m61"])
        self.sun, self.middle = (values[name] * DEGREE for name in ("alpha3_deg", "beta6_deg"))
        self.mounting = values["theta_deg"] * DEGREE
        self.turned = self.first.turn(self.sun), self.second.turn(self.middle)

    def find_angles(self, cam: arb) -> tuple[arb, arb]:
        """Return the angles of carrier and middle gears for a point of the cam angle."""
        middle = self.second.invert(cam + self.turned[1]) - self.middle
        return self.first.invert(middle + self.turned[0]) - self.sun, middle

    def __call__(self, cam: arb) -> Motion:
        low, high, centre = arb(cam.lower()), arb(cam.upper()), arb(cam.mid())
        ends, at_centre = [self.find_angles(end) for end in (low, high)], self.find_angles(centre)
        carrier, middle = (hull(a, b) for a, b in zip(*ends, strict=True))
        f1, df1 = self.first.ratio(carrier + self.sun)
        f2, df2 = self.second.ratio(middle + self.middle)
        rate, rise = f1 * f2, df2 * f1**2 + f2 * df1
        # alpha falls by the carrier's angle and rises by the cam's: a mean value over the interval
        alpha = PI - self.mounting - at_centre[0] + centre + (1 - 1 / rate) * (cam - centre)
        direction = MIDDLE[1] * DEGREE + carrier + middle
        return Motion(alpha.sin(), alpha.cos(), direction, (1 + f1, df1), rate, rise)


def differentiate(at: Motion, swing: tuple[arb, arb, arb]) -> tuple[list[arb], list[arb]]:
    """Return P = Y' and P' in the carrier's angle for each of the five moments of mass of a side
    (`find_moments`).

    `swing` is the swing of a half with two derivatives in the cam angle.
    """
    angle, rate, rise = swing[0], swing[1] * at.rate, swing[2] * at.rate**2 + swing[1] * at.rise
    turn = at.rate - 1
    sine, cosine = angle.sin(), angle.cos()
    # alpha' is `turn`, alpha'' is at.rise; Y is -sin(alpha) times the swung moment along x'
    first, second = at.cosine * turn, at.cosine * at.rise - at.sine * turn**2
    momenta, slopes = [-first, -at.sine * turn], [-second, -at.sine * at.rise - at.cosine * turn**2]
    for value, d, dd in (
        (cosine, -sine * rate, -sine * rise - cosine * rate**2),
        (sine, cosine * rate, cosine * rise - sine * rate**2),
    ):
        momenta.append(-first * value - at.sine * d)
        slopes.append(-second * value - 2 * first * d - at.sine * dd)
    direction, (middle, bend) = at.middle, at.middle_rate
    momenta.append(direction.cos() * middle)
    slopes.append(direction.cos() * bend - direction.sin() * middle**2)
    return momenta, slopes


def find_moments(values: Sequence[float]) -> list[float]:
    """Return the moments of mass [kg m] of values in the order and units of `LINEAR`: of what turns
    with the planet, along x' and y'; of what swings, along xi and zeta; of the middle gears.
    """
    middle, planet, rocker, nozzle, x, y, hinge, along, across = values
    halves = 2 * (rocker + nozzle)
    moments = [
        planet * x + halves * hinge,
        planet * y + 2 * (rocker * C1[1] + nozzle * C2_Y),
        2 * (rocker * C1[0] + nozzle * along),
        2 * (rocker * C1[2] + nozzle * across),
        middle * MIDDLE[0],
    ]
    return [moment / 1000 for moment in moments]


class Enclosure(NamedTuple):
    """Balls (n, 5) as doubles; their radii cover the rounding of sums with them."""

    centre: np.ndarray
    radius: np.ndarray

    @classmethod
    def of(cls, rows: list[list[arb]]) -> Enclosure:
        """Return the enclosure of rows of balls."""
        centre = np.array([[float(ball.mid()) for ball in row] for row in rows])
        radius = np.array([[float(ball.rad()) for ball in row] for row in rows])
        return cls(centre, radius * (1 + 1e-12) + np.abs(centre) * 1e-12)

    def combine(self, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return centres and radii (n, c) of sums with weights (c, 5)."""
        return self.centre @ corners.T, (self.radius @ np.abs(corners).T) * (1 + 1e-12)


def bound_variation(
    at: list[list[arb]], between: list[list[arb]], corners: np.ndarray
) -> np.ndarray:
    """Return upper bounds (c,) of the total variation of sums of P.

    P stands at n + 1 places, its change over each panel between them, wherever it begins, in
    `between`. Over panels on which the sign of the slope is known P is monotonic.
    """
    values, radii = Enclosure.of(at).combine(corners)
    changes, spread = Enclosure.of(between).combine(corners)
    signs = np.where(np.abs(changes) > spread, np.sign(changes), 0)
    total = np.where(signs == 0, np.abs(changes) + spread, 0).sum(axis=0)
    start = np.zeros(len(corners), dtype=int)
    lanes = np.arange(len(corners))
    for place in range(1, len(at)):
        ends = signs[place] != signs[place - 1] if place < len(signs) else np.full(len(lanes), True)
        step = np.abs(values[place] - values[start, lanes]) + radii[place] + radii[start, lanes]
        total += np.where(ends & (signs[place - 1] != 0), step, 0)
        start = np.where(ends, place, start)
    return np.where(np.isnan(total), np.inf, total * (1 + 1e-12))  # of boxes too wide for balls


Box = tuple[tuple[float, float], tuple[float, float]]
"""Bounds of the beginning and of the end of a flank in the cam angle [deg]."""
STEP = 0.5
"""Panels of dwells in the cam angle [deg]; bounds of flanks lie on their ends."""
SHARES = 96
"""Panels of a flank: the joints of all laws lie on their ends."""
FINEST = 0.2
"""Least width of a box of cam angles before the opening is divided [deg]."""


class Cover:
    """Upper bounds (c,) of the total variation in corners (c,) of the moments of mass."""

    def __init__(self, train: Train, linear: dict[str, tuple[float, float]] = LINEAR) -> None:
        self.train = train
        self.corners = np.array([find_moments(v) for v in itertools.product(*linear.values())])
        edges = [arb(STEP) * i * DEGREE for i in range(int(360 / STEP) + 1)]
        self._edges = [train(edge) for edge in edges]
        self._panels = [train(hull(*pair)) for pair in itertools.pairwise(edges)]
        self._flanks: dict[Box, tuple[list[Motion], list[Motion], arb]] = {}
        self.closed = self.bound_dwells(arb(0), 0, 360)

    def bound_dwells(self, swing: arb, low: float, high: float) -> np.ndarray:
        """Return bounds (n, c) over panels of cam angles [deg] in which a half rests at a swing."""
        still = swing, arb(0), arb(0)
        rows = np.zeros((len(self._panels), len(self.corners)))
        for index in range(int(low / STEP), int(high / STEP)):
            at = [differentiate(self._edges[index + k], still)[0] for k in (0, 1)]
            panel = self._panels[index]
            step = arb(STEP) * DEGREE / panel.rate
            between = [slope * step for slope in differentiate(panel, still)[1]]
            rows[index] = bound_variation(at, [between], self.corners)
        return rows

    def bound_flank(self, law: str, opening: arb, box: Box, sign: int) -> np.ndarray:
        """Return bounds (c,) over a flank that opens (sign 1) or closes (-1) a half."""
        if box not in self._flanks:
            self._flanks[box] = self._place_flank(box)
        at, panels, width = self._flanks[box]
        momenta, changes = [], []
        for index, motion in enumerate(at):
            share = arb(index) / SHARES
            momenta.append(differentiate(motion, self._swing(law, share, opening, width, sign))[0])
        for index, motion in enumerate(panels):
            share = span(arb(index) / SHARES, arb(index + 1) / SHARES)
            slopes = differentiate(motion, self._swing(law, share, opening, width, sign))[1]
            changes.append([slope * width / motion.rate / SHARES for slope in slopes])
        return bound_variation(momenta, changes, self.corners)

    def _swing(
        self, law: str, share: arb, opening: arb, width: arb, sign: int
    ) -> tuple[arb, arb, arb]:
        _, dp, ddp = (value + JOINT for value in LAWS[law](share))
        ends = share.lower(), share.upper()
        p = hull(*(LAWS[law](arb(end))[0] for end in ends)) + JOINT  # rises all the way
        angle = opening * (p if sign > 0 else 1 - p)
        return angle, sign * opening * dp / width, sign * opening * ddp / width**2

    def _place_flank(self, box: Box) -> tuple[list[Motion], list[Motion], arb]:
        start, end = (span(*ends) * DEGREE for ends in box)
        places = [
            start * (1 - arb(i) / SHARES) + end * (arb(i) / SHARES) for i in range(SHARES + 1)
        ]
        panels = [self.train(hull(*pair)) for pair in itertools.pairwise(places)]
        return [self.train(place) for place in places], panels, end - start

    def bound(self, law: str, opening: tuple[float, float], limit: float) -> tuple[float, int]:
        """Return a bound over all flanks for an interval of openings [deg], and how many boxes it
        took: refined until it is below the limit or boxes are too small.
        """
        swing = span(*opening) * DEGREE
        opened = self.bound_dwells(swing, RISE[1][0], FALL[0][1])
        before, between, after = (
            int(angle / STEP) for angle in (RISE[0][0], RISE[1][1], FALL[0][0])
        )
        fixed = self.closed[:before].sum(axis=0) + opened[between:after].sum(axis=0)
        fixed += self.closed[int(FALL[1][1] / STEP) :].sum(axis=0)
        bounds: tuple[dict[Box, np.ndarray], ...] = ({}, {})
        fresh: list[list[Box]] = [[RISE], [FALL]]
        while True:
            for sign, rows, boxes in zip((1, -1), bounds, fresh, strict=True):
                first, last = (self.closed, opened) if sign > 0 else (opened, self.closed)
                edges = (before, between) if sign > 0 else (after, int(FALL[1][1] / STEP))
                for box in boxes:
                    start, end = ceil(box[0][1] / STEP), int(box[1][0] / STEP)
                    rests = first[edges[0] : start].sum(axis=0) + last[end : edges[1]].sum(axis=0)
                    rows[box] = self.bound_flank(law, swing, box, sign) + rests
            tops = [np.max(list(rows.values()), axis=0) for rows in bounds]
            total = fixed + sum(tops)
            worst = float(total.max()) * (1 + 1e-9)
            above = total * (1 + 1e-9) >= limit
            fresh = []
            for rows, top in zip(bounds, tops, strict=True):
                largest = [box for box, row in rows.items() if (row >= top * 0.99)[above].any()]
                fresh.append([part for box in largest for part in divide(box)])
                for box in largest if above.any() else ():
                    del rows[box]
            count = sum(map(len, bounds))
            if (
                not above.any()
                or min(b - a for parts in fresh for box in parts for a, b in box) < FINEST
            ):
                return worst, count


def divide(box: Box) -> list[Box]:
    """Return the halves of a box, across its wider side."""
    start, end = box
    wide = 0 if start[1] - start[0] > end[1] - end[0] else 1
    low, high = box[wide]
    halves = (low, (low + high) / 2), ((low + high) / 2, high)
    return [(half, end) if wide == 0 else (start, half) for half in halves]


WIDTH, NARROWEST = 2, 0.25
"""Widths of the first and of the last intervals of openings [deg]."""


def bound_deviation(cover: Cover, laws: Sequence[str], limit: float) -> tuple[float, int]:
    """Return a bound of mean |F - W| [N] for all devices of a cover, and how many boxes it took.

    Refined until it is below a limit [N]. Raises ArithmeticError where it does not get there.
    """
    square = float((SPEED**2 / PI).upper()) * (1 + 1e-12)
    bound, boxes = 0.0, 0
    pieces = [(h, h + WIDTH) for h in range(OPENING[0], OPENING[1], WIDTH)]
    for law in laws:
        waiting = list(pieces)
        while waiting:
            opening = waiting.pop()
            variation, count = cover.bound(law, opening, limit / square)
            boxes += count
            if variation * square < limit:
                bound = max(bound, variation * square)
                continue
            low, high = opening
            if high - low <= NARROWEST:
                raise ArithmeticError(f"{law}, opening {opening} deg: {variation * square:.2f} N")
            waiting += [(low, (low + high) / 2), ((low + high) / 2, high)]
    return bound, boxes


def find_limit(span_N: str, variance_N2: str) -> float:
    """Return the mean |F - W| [N] below which no force has a printed range and variance."""
    half = arb(PRINTED)
    limit: arb = 2 * (arb(variance_N2) - half) / (arb(span_N) + half)
    return float(limit.lower())


@ctx.workprec(BITS)
def main() -> int:
    """Print the theorem; return 1 if a row is not excluded."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--range", help="of another force to exclude [N]")
    parser.add_argument("--variance", help="of that force [N2]")
    parser.add_argument("--out", help="file for the figures as JSON")
    options = parser.parse_args()
    rows = TABLE_1
    if options.range and options.variance:
        rows = {"point": (options.range, options.variance)}
    limit = min(find_limit(*row) for row in rows.values())
    try:
        deviation, boxes = bound_deviation(Cover(Train()), list(LAWS), limit)
    except ArithmeticError as error:
        print(f"not excluded: mean |F - W| may reach {limit:.2f} N ({error})")
        return 1
    print(f"mean |F - W| is at most {deviation:.4f} N for every device within the bounds:")
    record = {"mean_deviation_N": deviation, "boxes": boxes, "rows": {}}
    for name, (span_N, variance_N2) in rows.items():
        most = float((arb(span_N) + arb(PRINTED)).upper()) * deviation / 2 * (1 + 1e-12)
        record["rows"][name] = {"range_N": float(span_N), "most_variance_N2": most}
        print(f"{name}: a range of {span_N} N excludes variances above {most:.2f} N2;")
        print(f"    {variance_N2} N2 is excluded")
    if options.out:
        Path(options.out).write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
