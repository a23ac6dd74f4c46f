"""The limacon of Pascal."""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from ...quantity import Quantity
from ..pitch_curve import STEEPER, Condition, PitchCurve, register, swing, u


@register
class Limacon(PitchCurve):
    """A limacon of Pascal: r = l + b cos u.

    One turn for one turn means that a / (a - r) has the mean 2: a = 2 sqrt((a - l)^2 - b^2), which is a quadratic
    equation. Convex up to l = (1 + mu^2) b, mu the steeper slope: the curvature has the sign of a quadratic in cos u,
    least at u = pi, where it is (l - b)(l - (1 + mu^2) b); without deformation the textbook's l = 2 b.
    """

    name = "limacon"
    title = "deformed limacon"
    l = Quantity("l", "m", "mean radius of the limacon", "wang2017 digest 3.3", shown="l_mm")  # noqa: E741
    b = Quantity("b", "m", "amplitude of the limacon's radius", "wang2017 digest 3.3", shown="b_mm")
    parameters = (l, b)

    def radius(self) -> Expr:
        return self.l + self.b * sp.cos(u)

    def centre_distance(self) -> Expr:
        return (4 * self.l + 2 * sp.sqrt(self.l**2 + 3 * self.b**2)) / 3

    def turned(self) -> Expr:
        """Integral of a / (a - r) - 1 by the tangent of the half angle."""
        kappa = self.b / (self.l + sp.sqrt(self.l**2 + 3 * self.b**2))
        return u + 4 * sp.atan(kappa * sp.sin(u) / (1 - kappa * sp.cos(u)))

    def conditions(self) -> list[Condition]:
        return [Condition("b", self.b, "greater than 0"), Condition("b", self.l - self.b, "less than l")]

    def relative(self) -> tuple[Expr, ...]:
        """The swing is 2 b / sqrt(l^2 + 3 b^2)."""
        return sp.Integer(1), swing / sp.sqrt(4 - 3 * swing**2)

    def convexity(self) -> Expr:
        return 1 - (1 + STEEPER**2) * self.b / self.l
