"""The Fourier curve."""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from ...quantity import Quantity
from ..pitch_curve import Condition, PitchCurve, Shape, register, swing, u

ORDER = 3
"""Highest harmonic (assumed: the paper names the family only)."""


@register
class Fourier(PitchCurve):
    """A cosine polynomial: r = c0 + c1 cos u + c2 cos 2u + c3 cos 3u.

    No sine terms, so that the joints are extrema. Closure and rotation by series, convexity by curvature. With
    sigma_k = c_k / c1 the radius falls from u = 0 to pi as long as 4 |sigma2| + 9 |sigma3| < 1, for |sin ku| is at most
    k |sin u|.
    """

    name = "fourier"
    title = "deformed Fourier curve"
    parameters = tuple(
        Quantity(f"C{k}", "m", f"coefficient of cos {k} u in the radius", "wang2017 digest 3.3", shown=f"c{k}_mm")
        for k in range(ORDER + 1)
    )  # fmt: skip
    shapes = tuple(
        Shape(Quantity(f"sigma{k}", "1", f"coefficient of cos {k} u per coefficient of cos u", "wang2017 digest 3.3"),
              -sp.Rational(9, 10) / (ORDER - 1) / k**2, sp.Rational(9, 10) / (ORDER - 1) / k**2)
        for k in range(2, ORDER + 1)
    )  # fmt: skip

    def radius(self) -> Expr:
        return sp.Add(*(c * sp.cos(k * u) for k, c in enumerate(self.parameters)))

    def conditions(self) -> list[Condition]:
        mean, first = self.parameters[:2]
        start, end = (self.radius().subs(u, joint) for joint in (0, sp.pi))
        return [
            Condition(mean.name, mean, "greater than 0"),
            Condition(first.name, start - end, "such that the radius falls from u = 0 to pi"),
            Condition(first.name, end, "such that the radius at u = pi is greater than 0"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """Close ones: those of the limacon with the same fall of the radius, which the odd coefficients make."""
        sigma = (sp.Integer(1), *(shape.quantity for shape in self.shapes))
        first = swing / sp.sqrt(4 - 3 * swing**2) / sp.Add(*sigma[::2])
        return sp.Integer(1), *(first * part for part in sigma)
