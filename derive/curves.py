"""Pitch-curve families, their two-segment deformation, conjugation and closure.

A family is one small class. Everything else (derivatives, conjugate, ratio, rotation) is derived from its radius
(Litvin, Fuentes-Aznar, Gonzalez-Perez, Hayasaka: Noncircular Gears, 2009).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import sympy as sp
from sympy import Expr, pi

from derive.branches import Turns, switch, wrap
from derive.model import Let
from derive.quantity import Quantity, Vector

_SOURCE = "pitch curve"
u = Quantity("u", "rad", "parameter of the undeformed pitch curve", _SOURCE)
t = Quantity("t", "rad", "polar angle of the gear at the contact", _SOURCE)
a = Quantity("a", "m", "centre distance", _SOURCE)
m = Quantity("m", "1", "deformation coefficient", _SOURCE, shown="m")


@dataclass(frozen=True)
class Condition:
    """What must hold, as an expression that must be positive."""

    name: str
    positive: Expr
    allowed: str


@dataclass(frozen=True)
class ByClosure:
    """Centre distance fixed by one turn for one turn: the mean of the ratio over u is 1 (wang2017, section 3.2).

    The mean ratio falls with a and is convex, so Newton's method started below the root climbs to it; twice the mean
    radius lies below it by Jensen's inequality, and so does the given start for curves whose largest radius is larger.
    """

    ratio: Expr


@dataclass(frozen=True)
class BySeries:
    """Rotation from the cosine series of the ratio, 1 + sum b_k cos(k u), as many terms as the caller asks for."""

    ratio: Expr


class PitchCurve(ABC):
    """A closed pitch curve r(u), even in u, with extrema at u = 0 and u = pi."""

    name: str
    title: str
    parameters: tuple[Quantity, ...]

    @abstractmethod
    def radius(self) -> Expr:
        """r(u) [m]; its derivatives are taken by differentiation alone."""

    def centre_distance(self) -> Expr | ByClosure:
        """Distance to the conjugate's centre [m], in closed form where there is one."""
        return ByClosure(self.ratio())

    def turned(self) -> Expr | BySeries:
        """Rotation of the conjugate from u = 0 [rad]: the integral of the ratio over u."""
        return BySeries(self.ratio())

    def ratio(self) -> Expr:
        """Rotation of the conjugate per rotation of the gear, r / (a - r)."""
        return self.radius() / (a - self.radius())

    @abstractmethod
    def conditions(self) -> list[Condition]:
        """What the parameters must satisfy beside r < a and m > 1/2."""


FAMILIES: dict[str, PitchCurve] = {}


def register(family: type[PitchCurve]) -> type[PitchCurve]:
    FAMILIES[family.name] = family()
    return family


@register
class EccentricCircle(PitchCurve):
    """A circle of radius R turning about a point e off its centre: r = e cos u + sqrt(R^2 - e^2 sin^2 u)."""

    name = "eccentric_circle"
    title = "deformed eccentric circle"
    R = Quantity("R", "m", "radius of the eccentric circle", "wang2017 3.4", shown="R_mm")
    e = Quantity("e", "m", "eccentricity of the circle", "wang2017 3.4", shown="e_mm")
    parameters = (R, e)

    def radius(self) -> Expr:
        return self.e * sp.cos(u) + sp.sqrt(self.R**2 - self.e**2 * sp.sin(u) ** 2)

    def conditions(self) -> list[Condition]:
        return [Condition("e", self.e, "greater than 0"), Condition("e", self.R - self.e, "less than R")]


@register
class Ellipse(PitchCurve):
    """An ellipse of semi-axis A and eccentricity k turning about a focus: r = A (1 - k^2) / (1 - k cos u).

    The conjugate at the distance 2 A is the same ellipse; the rotation is the angle seen from its focus.
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


tau = Quantity("tau", "rad", "polar angle within the turn", _SOURCE)
m2 = Quantity("m2", "1", "deformation coefficient of the second segment", _SOURCE)
du = Quantity("du", "1", "slope of the parameter, per polar angle", _SOURCE)
turned_u = Quantity("turned_u", "rad", "rotation of the undeformed conjugate since u = 0", _SOURCE)
r = Quantity("r", "m", "pitch radius of the gear", _SOURCE)
dr = Quantity("dr", "m", "slope of the pitch radius, per polar angle", _SOURCE)
ddr = Quantity("ddr", "m", "second derivative of the pitch radius, per polar angle", _SOURCE)
ratio = Quantity("ratio", "1", "rotation of the conjugate per rotation of the gear", _SOURCE)
dratio = Quantity("dratio", "1", "slope of the ratio, per polar angle", _SOURCE)
turned = Quantity("turned", "rad", "rotation of the conjugate since t = 0, whole turns included", _SOURCE)
CONTACT = Vector("contact", (r, dr, ddr, ratio, dratio, turned))


def parameter_steps() -> tuple[Let, ...]:
    """Two segments: u = m t up to the joint at pi/m, then u = m2 (2 pi - t), where 1/m + 1/m2 = 2 (wang2017, [10])."""
    first = pi / m - tau
    return (
        Let(tau, wrap(t, 2 * pi), "deformation: polar angle within the turn"),
        Let(m2, m / (2 * m - 1), "deformation: closure of the two segments"),
        Let(u, switch(first, m * tau, m2 * (2 * pi - tau)), "deformation: parameter"),
        Let(du, switch(first, m, -m2), "deformation: slope of the parameter"),
    )


def contact_steps(curve: PitchCurve) -> tuple[Let, ...]:
    """Contact of the deformed curve with its conjugate at the polar angle t, from the radius alone."""
    radius, of_u = curve.radius(), curve.ratio()
    rotation = switch(pi / m - tau, turned_u / m, 2 * pi - turned_u / m2)
    return (
        Let(r, radius, "pitch curve"),
        Let(dr, radius.diff(u) * du, "pitch curve, differentiated"),
        Let(ddr, radius.diff(u, 2) * du**2, "pitch curve, differentiated"),
        Let(ratio, of_u, "conjugation"),
        Let(dratio, of_u.diff(u) * du, "conjugation, differentiated"),
        Let(turned, 2 * pi * Turns(t / (2 * pi)) + rotation, "conjugation, integrated"),
    )
