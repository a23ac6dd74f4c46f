"""The eccentric circle."""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from ...quantity import Quantity
from ..pitch_curve import STEEPER, Condition, PitchCurve, register, swing, u


@register
class EccentricCircle(PitchCurve):
    """A circle of radius R turning about a point e off its centre: r = e cos u + sqrt(R^2 - e^2 sin^2 u).

    Convex up to R = mu^2 e, mu the steeper slope: with sin psi = e sin u / R, r^2 + 2 mu^2 r'^2 - mu^2 r r'' has the
    sign of mu^2 r - (mu^2 - 1) R cos^3 psi, and both r and -cos psi are least at u = pi.
    """

    name = "eccentric_circle"
    title = "deformed eccentric circle"
    R = Quantity("R", "m", "radius of the eccentric circle", "wang2017 3.4", shown="R_mm")
    e = Quantity("e", "m", "eccentricity of the circle", "wang2017 3.4", shown="e_mm")
    parameters = (R, e)

    def radius(self) -> Expr:
        return self.e * sp.cos(u) + sp.sqrt(self.R**2 - self.e**2 * sp.sin(u) ** 2)

    def conditions(self) -> list[Condition]:
        return [Condition("e", self.e, "greater than 0"), Condition("e", self.R - self.e, "less than R")]

    def relative(self) -> tuple[Expr, ...]:
        """Close ones: those of the limacon, from which the circle differs in the square of e / R."""
        return sp.Integer(1), swing / sp.sqrt(4 - 3 * swing**2)

    def convexity(self) -> Expr:
        return 1 - STEEPER**2 * self.e / self.R
