"""Functions of an angle with corners, roots, jumps and touching zeros, whose measures mpmath has to
30 digits.

Each is the text of a statement's formula in the angle `t`, the lengths `r` and `s` without unit, of
which a search may move both. Its `breaks` are all places in a turn, functions of r and s, where it
or one of its derivatives jumps.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mpmath
import sympy as sp
from mpmath import acos, asin, mpf, pi

from planter.engine.machine import Machine
from tests.support import own

R, S = 1.0, 0.3
"""Values of r and s in the statement."""
STATEMENT = '''"""A function of an angle."""
from sympy import *
from derive import Formulas, quantities
q = quantities("""
    t | rad | angle
    n | rad/s | its speed | 1
    r | 1 | size | 1 | 0.8 1.3
    s | 1 | shift | 0.3 | 0.2 0.5
    y | 1 | function of the angle
""")
f = Formulas("integrand", given=q, angle=q.t, speed=q.n)
t, r, s = q.t, q.r, q.s
f.defines(q.y, {})
SYSTEM = f.system()
'''

Place = Any
"""A number of mpmath."""


@dataclass(frozen=True)
class Integrand:
    """A function by its text; `measure` is exact to the digits of mpmath at the breaks'
    precision.
    """

    text: str
    breaks: Callable[[Place, Place], Sequence[Place]]

    @property
    def machine(self) -> Machine:
        """The machine of the single quantity y."""
        return own.machine(STATEMENT.format(self.text), "integrand")

    @property
    def expr(self) -> sp.Expr:
        """The function of the symbols t, r and s."""
        return _parse(self.text)

    def evaluate(self, t: Place, r: Place, s: Place) -> Place:
        """Return the value at numbers of mpmath."""
        return _compile(self.text)(t, r, s)

    def integrate(self, r: Place = R, s: Place = S, power: int = 1) -> Place:
        """Return the mean over a turn of a power of the function, between its breaks."""
        r, s = mpf(r), mpf(s)
        ends = sorted({mpf(0), 2 * pi, *(place % (2 * pi) for place in self.breaks(r, s))})
        middles = [(low + high) / 2 for low, high in itertools.pairwise(ends)]
        pieces = sorted([*ends, *middles])
        return mpmath.quad(lambda t: self.evaluate(t, r, s) ** power, pieces) / (2 * pi)

    def differentiate(self, r: Place = R, s: Place = S, power: int = 1) -> tuple[Place, Place]:
        """Return the derivatives of that mean in r and s, to about 12 digits."""
        return tuple(
            mpmath.diff(
                lambda *at: self.integrate(*at, power), (mpf(r), mpf(s)), orders, h=mpf(10) ** -10
            )
            for orders in ((1, 0), (0, 1))
        )


@cache
def _parse(text: str) -> sp.Expr:
    symbols = {name: sp.Symbol(name, real=True) for name in "trs"}
    return sp.sympify(text, locals=symbols)


@cache
def _compile(text: str) -> Callable[..., Place]:
    return sp.lambdify(sp.symbols("t r s", real=True), _parse(text), "mpmath")


def _none(r: Place, s: Place) -> list[Place]:
    return []


def _cosine(
    level: Callable[[Place, Place], Place], count: int = 1
) -> Callable[[Place, Place], list[Place]]:
    """Return the places where cos(count t) has a level."""

    def find(r: Place, s: Place) -> list[Place]:
        half = acos(level(r, s))
        return [(sign * half + 2 * pi * k) / count for sign in (1, -1) for k in range(count)]

    return find


def _sine(level: Callable[[Place, Place], Place]) -> Callable[[Place, Place], list[Place]]:
    """Return the places where sin(t) has a level."""
    return lambda r, s: [asin(level(r, s)), pi - asin(level(r, s))]


def _steps(*shares: float) -> Callable[[Place, Place], list[Place]]:
    """Return the places at shares of a turn, as such as 0.25."""
    return lambda r, s: [2 * pi * mpf(share) for share in shares]


def _find_whole_numbers(r: Place, s: Place) -> list[Place]:
    """Return the places where 3 r cos(t) + s is whole."""
    levels = [(k - s) / (3 * r) for k in range(-5, 7)]
    return [
        place
        for level in levels
        if abs(level) < 1
        for place in _cosine(lambda *_, at=level: at)(r, s)
    ]


INTEGRANDS: dict[str, Integrand] = {
    # roots at an end of a case
    "root_of_part": Integrand(
        "Piecewise((sqrt(r*cos(t) - s), r*cos(t) > s), (0, True))", _cosine(lambda r, s: s / r)
    ),
    "power_of_part": Integrand(
        "Piecewise(((r*cos(t) - s)**Rational(3, 2), r*cos(t) > s), (0, True))",
        _cosine(lambda r, s: s / r),
    ),
    "root_of_root": Integrand(
        "Piecewise((sqrt(2*r - sqrt(r*cos(t) - s)), r*cos(t) > s), (sqrt(2*r), True))",
        _cosine(lambda r, s: s / r),
    ),
    "root_of_greatest": Integrand("sqrt(Max(0, r*cos(t) - s))", _cosine(lambda r, s: s / r)),
    "root_of_size": Integrand("sqrt(Abs(r*sin(t) - s))", _sine(lambda r, s: s / r)),
    "size_times_logarithm": Integrand(
        "Abs(r*sin(t) - s)*log(Abs(r*sin(t) - s))", _sine(lambda r, s: s / r)
    ),
    # corners
    "size": Integrand("Abs(r*sin(t) - s)", _sine(lambda r, s: s / r)),
    "size_of_seven_waves": Integrand("Abs(r*cos(7*t) - s)", _cosine(lambda r, s: s / r, 7)),
    "part": Integrand("Max(0, r*sin(t) - s)", _sine(lambda r, s: s / r)),
    "least": Integrand("Min(r*cos(t), s)", _cosine(lambda r, s: s / r)),
    "clipped": Integrand(
        "Max(Min(r*cos(t), s), -s)",
        lambda r, s: [*_cosine(lambda r, s: s / r)(r, s), *_cosine(lambda r, s: -s / r)(r, s)],
    ),
    "greatest_of_three": Integrand(
        "r*Max(cos(t), cos(t - 2*pi/3), cos(t + 2*pi/3)) + s", lambda r, s: [pi / 3, pi, 5 * pi / 3]
    ),
    "decay_of_size": Integrand("exp(-r*Abs(sin(t) - s))", _sine(lambda r, s: s)),
    "share_of_size": Integrand("1/(r + Abs(cos(t) - s))", _cosine(lambda r, s: s)),
    "size_of_cube": Integrand("Abs(r*sin(t - s)**3)", lambda r, s: [s, pi + s]),
    "size_of_product": Integrand(
        "Abs((r*sin(t) - s)*cos(t))",
        lambda r, s: [*_sine(lambda r, s: s / r)(r, s), pi / 2, 3 * pi / 2],
    ),
    "size_within_size": Integrand(
        "Abs(Abs(r*cos(t)) - s)",
        lambda r, s: [
            pi / 2,
            3 * pi / 2,
            *_cosine(lambda r, s: s / r)(r, s),
            *_cosine(lambda r, s: -s / r)(r, s),
        ],
    ),
    # zeros that touch
    "norm_at_rest": Integrand("sqrt((r*sin(t - s))**2 + (r - r*cos(t - s))**2)", lambda r, s: [s]),
    "norm_of_root": Integrand("sqrt(r*(1 + cos(t - s)))", lambda r, s: [pi + s]),
    "power_at_rest": Integrand("(r*(1 + cos(t)))**Rational(3, 2)", lambda r, s: [pi]),
    "norm_times_cosine": Integrand(
        "cos(t)*sqrt(sin(t)**2 + sin(t)**4) + r*s", lambda r, s: [mpf(0), pi]
    ),
    "size_that_touches": Integrand("Abs(r - r*sin(t))", _none),
    "norm_nearly_at_rest": Integrand(
        "sqrt((r*cos(t - s))**2 + Rational(1, 10**6))", lambda r, s: [pi / 2 + s, 3 * pi / 2 + s]
    ),
    "norm_farther_from_rest": Integrand(
        "sqrt((r*cos(t))**2 + Rational(1, 100)*s)", lambda r, s: [pi / 2, 3 * pi / 2]
    ),
    "case_that_touches": Integrand(
        "Piecewise((s, sin(t) >= 1), (r*cos(t)**2, True))", lambda r, s: [mpf(1), mpf(2)]
    ),
    "logarithm": Integrand("log(Abs(r*sin(t - s)))", lambda r, s: [s, pi + s]),
    # dead centres
    "dead_centre": Integrand("r*cos(t) + sqrt(r**2 - (r*sin(t))**2)", _steps(0.25, 0.75)),
    "near_dead_centre": Integrand(
        "r*cos(t) + sqrt((1 + s/10**6)*r**2 - (r*sin(t))**2)", _steps(0.25, 0.75)
    ),
    "far_from_dead_centre": Integrand("r*cos(t) + sqrt(9*r**2 - (r*sin(t) - s)**2)", _none),
    "angle_at_dead_centre": Integrand("r*acos(cos(t - s))", lambda r, s: [s, pi + s]),
    "sine_at_dead_centre": Integrand(
        "r*s + asin(sin(t - s))", lambda r, s: [pi / 2 + s, 3 * pi / 2 + s]
    ),
    "angle_near_dead_centre": Integrand("asin((1 - s/10**5)*sin(t)) + r", _steps(0.25, 0.75)),
    "angle_of_size": Integrand("acos(Abs(cos(t)))*r - s", _steps(0, 0.25, 0.5, 0.75)),
    # jumps
    "sign": Integrand("sign(r*cos(t) - s)", _cosine(lambda r, s: s / r)),
    "sign_of_friction": Integrand("(r + cos(t)**2)*sign(sin(t) - s)", _sine(lambda r, s: s)),
    "case_that_jumps": Integrand(
        "Piecewise((r*cos(t), sin(t) > s), (-s, True))", _sine(lambda r, s: s)
    ),
    "two_conditions": Integrand(
        "Piecewise((r*sin(t)**2, (cos(t) > s) & (sin(t) > 0)), (s*cos(t), True))",
        lambda r, s: [mpf(0), *_cosine(lambda r, s: s)(r, s), pi],
    ),
    "either_condition": Integrand(
        "Piecewise((r*t*(2*pi - t), (cos(t) > s) | (sin(t) < -s)), (1 + s*cos(t), True))",
        lambda r, s: [mpf(0), *_cosine(lambda r, s: s)(r, s), *_sine(lambda r, s: -s)(r, s)],
    ),
    "whole_numbers": Integrand("floor(3*r*cos(t) + s)*cos(t)", _find_whole_numbers),
    "saw": Integrand(
        "5*t/(2*pi) + s - floor(5*t/(2*pi) + s)",
        lambda r, s: [2 * pi * (k - s) / 5 for k in range(1, 7)],
    ),
    "direction": Integrand("r*atan2(sin(t + s), cos(t + s))", lambda r, s: [mpf(0), pi - s]),
    "direction_through_pole": Integrand("atan2(r*sin(t), r - r*cos(t)) + s", lambda r, s: [mpf(0)]),
    "direction_of_part": Integrand("atan2(sin(t)**2, cos(t) - s)*r", _steps(0, 0.5)),
    # events in a step of a scan, and closer than an accuracy
    "narrow_pulse": Integrand(
        "Piecewise((100*r, cos(t) > cos(s/100)), (s, True))", lambda r, s: [s / 100, -s / 100]
    ),
    "narrow_part": Integrand(
        "Max(0, cos(t - s) - cos(r/1000))*10**6", lambda r, s: [s - r / 1000, s + r / 1000]
    ),
    "two_steps_at_once": Integrand(
        "(2 + cos(t))*(r*sign(sin(t - s)) + s*sign(sin(t - s - Rational(1, 10**9))))",
        lambda r, s: [s, s + mpf(10) ** -9, pi + s, pi + s + mpf(10) ** -9],
    ),
    # dwells and laws by cases
    "dwell": Integrand(
        "r*Piecewise(((t/s)**2*(3 - 2*t/s), t < s), (1, t < 2), ((1 + cos(pi*(t - 2)))/2, t < 3), "
        "(0, True))",
        lambda r, s: [mpf(0), s, mpf(2), mpf(3)],
    ),
    "law_of_size": Integrand(
        "Piecewise((s*(r*cos(t) - s), r*cos(t) > s), (2*(r*cos(t) - s), True))",
        _cosine(lambda r, s: s / r),
    ),
    "smooth": Integrand("r/(1 + s*cos(t))", _none),
}
"""Functions by name."""
