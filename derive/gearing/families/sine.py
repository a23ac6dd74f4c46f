"""The curve of a sinusoidal ratio."""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from ...quantity import Quantity
from ..pitch_curve import STEEPER, Condition, PitchCurve, register, swing, u


@register
class Sine(PitchCurve):
    """The curve whose ratio is a sine, a quarter of a turn on so that the joints are extrema: f = 1 + c cos u.

    From r / (D - r) = f the radius is r = D f / (1 + f), and one turn for one turn holds at every centre distance D.
    The paper names the family only; that the ratio is the sine, and not the radius, which would be the limacon
    again, is assumed. Convex up to the smaller root of c^2 - (3 + mu^2) c + 2, mu the steeper slope: with y = c cos u
    1/r + (1/r)'' has the sign of (1 + y)^3 + (1 + y)^2 + mu^2 (2 c^2 + y - y^2), which grows up to y = 1/2 and is
    positive for y >= 0, so that it vanishes first at u = pi; without deformation at c = 2 - sqrt(2).
    """

    name = "sine"
    title = "deformed sine curve"
    D = Quantity("D", "m", "centre distance of the gear pair", "wang2017 digest 3.3", shown="D_mm")
    c = Quantity("c", "1", "amplitude of the ratio", "wang2017 digest 3.3", shown="c")
    parameters = (D, c)

    def radius(self) -> Expr:
        return self.D * self.ratio() / (1 + self.ratio())

    def ratio(self) -> Expr:
        return 1 + self.c * sp.cos(u)

    def centre_distance(self) -> Expr:
        return self.D

    def turned(self) -> Expr:
        return u + self.c * sp.sin(u)

    def conditions(self) -> list[Condition]:
        return [
            Condition("D", self.D, "greater than 0"),
            Condition("c", self.c, "greater than 0"),
            Condition("c", 1 - self.c, "less than 1"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """The swing is c."""
        return sp.Integer(1), swing

    def convexity(self) -> Expr:
        return self.c**2 - (3 + STEEPER**2) * self.c + 2
