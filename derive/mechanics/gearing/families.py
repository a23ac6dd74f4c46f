"""The built-in families of pitch curves (wang2017 3.3 and 3.4), each a class that states its
radius.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from ...quantity import Quantity
from .pitch_curve import FAMILIES, STEEPER, Condition, PitchCurve, Shape, register, swing, u

__all__ = ["FAMILIES", "EccentricCircle", "Ellipse", "Fourier", "Limacon", "Sine"]


@register
class EccentricCircle(PitchCurve):
    """A circle of radius R that turns about a point e off its centre: r = e cos u + sqrt(R^2 - e^2
    sin^2 u).

    Convex up to R = mu^2 e, mu the steeper slope: with sin psi = e sin u / R, r^2 + 2 mu^2 r'^2 -
    mu^2 r r'' has the sign of mu^2 r - (mu^2 - 1) R cos^3 psi, and both r and -cos psi are least at
    u = pi.
    """

    name = "eccentric_circle"
    title = "deformed eccentric circle"
    R = Quantity("R", "m", "radius of the eccentric circle", "wang2017 3.4", shown="R_mm")
    e = Quantity("e", "m", "eccentricity of the circle", "wang2017 3.4", shown="e_mm")
    parameters = (R, e)

    def radius(self) -> Expr:
        """Return the radius of the pitch curve [m] at the angle u."""
        return self.e * sp.cos(u) + sp.sqrt(self.R**2 - self.e**2 * sp.sin(u) ** 2)

    def conditions(self) -> list[Condition]:
        """Return the conditions under which the parameters give a pitch curve."""
        return [
            Condition("e", self.e, "greater than 0"),
            Condition("e", self.R - self.e, "less than R"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """Return those of the limacon, which are close: the circle differs from it in the square of
        e / R.
        """
        return sp.Integer(1), swing / sp.sqrt(4 - 3 * swing**2)

    def convexity(self) -> Expr:
        """Return an expression that is positive if the pitch curve is convex."""
        return 1 - STEEPER**2 * self.e / self.R


@register
class Ellipse(PitchCurve):
    """An ellipse of semi-axis A and eccentricity k that turns about a focus: r = A (1 - k^2) / (1 -
    k cos u).

    The conjugate at the distance 2 A is the same ellipse; the rotation is the angle seen from its
    focus. Convex up to k (mu^2 - 1) = 1, mu the steeper slope: convex means 1/r + (1/r)'' >= 0, and
    that is 1 + (mu^2 - 1) k cos u.
    """

    name = "ellipse"
    title = "deformed ellipse"
    A = Quantity("A", "m", "semi-axis of the ellipse", "wang2017 3.4", shown="A_mm")
    k = Quantity("k", "1", "eccentricity of the ellipse", "wang2017 3.4", shown="k")
    parameters = (A, k)

    def radius(self) -> Expr:
        """Return the radius of the pitch curve [m] at the angle u."""
        return self.A * (1 - self.k**2) / (1 - self.k * sp.cos(u))

    def centre_distance(self) -> Expr:
        """Return the centre distance of the pair in closed form [m]."""
        return 2 * self.A

    def turned(self) -> Expr:
        """Return the angle by which the mating gear has turned at the angle u [rad]."""
        return u + 2 * sp.atan(self.k * sp.sin(u) / (1 - self.k * sp.cos(u)))

    def conditions(self) -> list[Condition]:
        """Return the conditions under which the parameters give a pitch curve."""
        return [
            Condition("A", self.A, "greater than 0"),
            Condition("k", self.k, "greater than 0"),
            Condition("k", 1 - self.k, "less than 1"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """Return them from the swing 2 k / (1 + k^2), as the ratio varies from (1 - k)/(1 + k) to
        its inverse.
        """
        return sp.Integer(1), swing / (1 + sp.sqrt(1 - swing**2))

    def convexity(self) -> Expr:
        """Return an expression that is positive if the pitch curve is convex."""
        return 1 - self.k * (STEEPER**2 - 1)


ORDER = 3
"""Highest harmonic (assumed: the paper only names the family)."""


@register
class Fourier(PitchCurve):
    """A cosine polynomial: r = c0 + c1 cos u + c2 cos 2u + c3 cos 3u.

    Without sine terms, the breakpoints at u = 0 and pi are extrema. Closure and rotation are by
    series, convexity is by curvature. With sigma_k = c_k / c1 the radius falls from u = 0 to pi as
    long as 4 |sigma2| + 9 |sigma3| < 1, since |sin ku| <= k |sin u|.
    """

    name = "fourier"
    title = "deformed Fourier curve"
    parameters = tuple(
        Quantity(
            f"C{k}",
            "m",
            f"coefficient of cos {k} u in the radius",
            "wang2017 digest 3.3",
            shown=f"c{k}_mm",
        )
        for k in range(ORDER + 1)
    )
    shapes = tuple(
        Shape(
            Quantity(
                f"sigma{k}",
                "1",
                f"coefficient of cos {k} u per coefficient of cos u",
                "wang2017 digest 3.3",
            ),
            -sp.Rational(9, 10) / (ORDER - 1) / k**2,
            sp.Rational(9, 10) / (ORDER - 1) / k**2,
        )
        for k in range(2, ORDER + 1)
    )

    def radius(self) -> Expr:
        """Return the radius of the pitch curve [m] at the angle u."""
        return sp.Add(*(c * sp.cos(k * u) for k, c in enumerate(self.parameters)))

    def conditions(self) -> list[Condition]:
        """Return the conditions under which the parameters give a pitch curve."""
        mean, first = self.parameters[:2]
        start, end = (self.radius().subs(u, breakpoint) for breakpoint in (0, sp.pi))
        return [
            Condition(mean.name, mean, "greater than 0"),
            Condition(first.name, start - end, "such that the radius falls from u = 0 to pi"),
            Condition(first.name, end, "such that the radius at u = pi is greater than 0"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """Return those of the limacon with the same fall of the radius, which the odd coefficients
        determine.
        """
        sigma = (sp.Integer(1), *(shape.quantity for shape in self.shapes))
        first = swing / sp.sqrt(4 - 3 * swing**2) / sp.Add(*sigma[::2])
        return sp.Integer(1), *(first * part for part in sigma)


@register
class Limacon(PitchCurve):
    """A limacon of Pascal: r = l + b cos u.

    One revolution for one means that a / (a - r) has the mean 2: a = 2 sqrt((a - l)^2 - b^2), which
    is a quadratic equation. Convex up to l = (1 + mu^2) b, mu the steeper slope: the curvature has
    the sign of a quadratic in cos u, least at u = pi, where it is (l - b)(l - (1 + mu^2) b);
    without deformation the textbook's l = 2 b.
    """

    name = "limacon"
    title = "deformed limacon"
    l = Quantity("l", "m", "mean radius of the limacon", "wang2017 digest 3.3", shown="l_mm")  # noqa: E741
    b = Quantity("b", "m", "amplitude of the limacon's radius", "wang2017 digest 3.3", shown="b_mm")
    parameters = (l, b)

    def radius(self) -> Expr:
        """Return the radius of the pitch curve [m] at the angle u."""
        return self.l + self.b * sp.cos(u)

    def centre_distance(self) -> Expr:
        """Return the centre distance of the pair in closed form [m]."""
        return (4 * self.l + 2 * sp.sqrt(self.l**2 + 3 * self.b**2)) / 3

    def turned(self) -> Expr:
        """Return the integral of a / (a - r) - 1, by the tangent of half the angle."""
        kappa = self.b / (self.l + sp.sqrt(self.l**2 + 3 * self.b**2))
        return u + 4 * sp.atan(kappa * sp.sin(u) / (1 - kappa * sp.cos(u)))

    def conditions(self) -> list[Condition]:
        """Return the conditions under which the parameters give a pitch curve."""
        return [
            Condition("b", self.b, "greater than 0"),
            Condition("b", self.l - self.b, "less than l"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """Return them from the swing 2 b / sqrt(l^2 + 3 b^2)."""
        return sp.Integer(1), swing / sp.sqrt(4 - 3 * swing**2)

    def convexity(self) -> Expr:
        """Return an expression that is positive if the pitch curve is convex."""
        return 1 - (1 + STEEPER**2) * self.b / self.l


@register
class Sine(PitchCurve):
    """The curve with a sinusoidal ratio, shifted so that the breakpoints are extrema: f = 1 + c cos
    u.

    From r / (D - r) = f the radius is r = D f / (1 + f), and every centre distance D gives one
    revolution for one. The paper only names the family; it is assumed that the ratio is the sine,
    since a sinusoidal radius would be the limacon again. Convex up to the smaller root of c^2 - (3
    + mu^2) c + 2, mu the steeper slope: with y = c cos u 1/r + (1/r)'' has the sign of (1 + y)^3 +
    (1 + y)^2 + mu^2 (2 c^2 + y - y^2), which grows up to y = 1/2 and is positive for y >= 0, so
    that it vanishes first at u = pi; without deformation at c = 2 - sqrt(2).
    """

    name = "sine"
    title = "deformed sine curve"
    D = Quantity("D", "m", "centre distance of the gear pair", "wang2017 digest 3.3", shown="D_mm")
    c = Quantity("c", "1", "amplitude of the ratio", "wang2017 digest 3.3", shown="c")
    parameters = (D, c)

    def radius(self) -> Expr:
        """Return the radius of the pitch curve [m] at the angle u."""
        return self.D * self.ratio() / (1 + self.ratio())

    def ratio(self) -> Expr:
        """Return the ratio of the pair at the angle u [1]."""
        return 1 + self.c * sp.cos(u)

    def centre_distance(self) -> Expr:
        """Return the centre distance of the pair in closed form [m]."""
        return self.D

    def turned(self) -> Expr:
        """Return the angle by which the mating gear has turned at the angle u [rad]."""
        return u + self.c * sp.sin(u)

    def conditions(self) -> list[Condition]:
        """Return the conditions under which the parameters give a pitch curve."""
        return [
            Condition("D", self.D, "greater than 0"),
            Condition("c", self.c, "greater than 0"),
            Condition("c", 1 - self.c, "less than 1"),
        ]

    def relative(self) -> tuple[Expr, ...]:
        """Return them from the swing, which is c."""
        return sp.Integer(1), swing

    def convexity(self) -> Expr:
        """Return an expression that is positive if the pitch curve is convex."""
        return self.c**2 - (3 + STEEPER**2) * self.c + 2
