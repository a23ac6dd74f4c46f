"""The ellipse."""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from ...quantity import Quantity
from ..pitch_curve import STEEPER, Condition, PitchCurve, register, swing, u


@register
class Ellipse(PitchCurve):
    """An ellipse of semi-axis A and eccentricity k turning about a focus: r = A (1 - k^2) / (1 - k cos u).

    The conjugate at the distance 2 A is the same ellipse; the rotation is the angle seen from its focus. Convex up to
    k (mu^2 - 1) = 1, mu the steeper slope: convex means 1/r + (1/r)'' >= 0, and that is 1 + (mu^2 - 1) k cos u.
    """

    name = "ellipse"
    title = "deformed ellipse"
    A = Quantity("A", "m", "semi-axis of the ellipse", "wang2017 3.4", shown="A_mm")
    k = Quantity("k", "1", "eccentricity of the ellipse", "wang2017 3.4", shown="k")
    parameters = (A, k)

    def radius(self) -> Expr:
        return self.A * (1 - self.k**2) / (1 - self.k * sp.cos(u))

    def centre_distance(self) -> Expr:
        return 2 * self.A

    def turned(self) -> Expr:
        return u + 2 * sp.atan(self.k * sp.sin(u) / (1 - self.k * sp.cos(u)))

    def conditions(self) -> list[Condition]:
        return [
            Condition("A", self.A, "greater than 0"),
            Condition("k", self.k, "greater than 0"),
            Condition("k", 1 - self.k, "less than 1"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """The swing is 2 k / (1 + k^2), from the ratios (1 + k)/(1 - k) and (1 - k)/(1 + k)."""
        return sp.Integer(1), swing / (1 + sp.sqrt(1 - swing**2))

    def convexity(self) -> Expr:
        return 1 - self.k * (STEEPER**2 - 1)
