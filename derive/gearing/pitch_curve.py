"""What a family of pitch curves is, and the registry of those that there are."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import sympy as sp
from sympy import Expr

from ..quantity import Quantity

_SOURCE = "pitch curve"
u = Quantity("u", "rad", "parameter of the undeformed pitch curve", _SOURCE)
t = Quantity("t", "rad", "polar angle of the gear at the contact", _SOURCE)
a = Quantity("a", "m", "centre distance", _SOURCE)
m = Quantity("m", "1", "deformation coefficient", _SOURCE, shown="m")
swing = Quantity("swing", "1", "relative swing of the ratio, (largest - least) / (largest + least)", _SOURCE)
STEEPER = sp.Max(m, m / (2 * m - 1))
"""Slope of the parameter in the steeper of the two segments of a deformed curve; at least 1."""


@dataclass(frozen=True)
class Condition:
    """What must hold, as an expression that must be positive."""

    name: str
    positive: Expr
    allowed: str


@dataclass(frozen=True)
class Shape:
    """A number of a family beside size and swing, with the range in which it leaves the extremes at u = 0 and pi."""

    quantity: Quantity
    lower: Expr
    upper: Expr


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
    """A closed pitch curve r(u), even in u, with its largest radius at u = 0 and its least at u = pi."""

    name: str
    title: str
    parameters: tuple[Quantity, ...]
    shapes: tuple[Shape, ...] = ()

    @abstractmethod
    def radius(self) -> Expr:
        """r(u) [m]; its derivatives are taken by differentiation alone."""

    @abstractmethod
    def conditions(self) -> list[Condition]:
        """What the parameters must satisfy beside r < a and m > 1/2."""

    @abstractmethod
    def relative(self) -> tuple[Expr, ...]:
        """Parameters of a curve of unit size that has the relative swing ``swing``.

        Where no closed form is known: those of one whose swing grows with ``swing`` and is close to it.
        """

    def centre_distance(self) -> Expr | ByClosure:
        """Distance to the conjugate's centre [m], in closed form where there is one."""
        return ByClosure(self.ratio())

    def turned(self) -> Expr | BySeries:
        """Rotation of the conjugate from u = 0 [rad]: the integral of the ratio over u."""
        return BySeries(self.ratio())

    def ratio(self) -> Expr:
        """Rotation of the conjugate per rotation of the gear, r / (a - r)."""
        return self.radius() / (a - self.radius())

    def convexity(self) -> Expr | None:
        """Positive [1] if and only if the deformed curve is convex; None where only its curvature tells."""
        return None


FAMILIES: dict[str, PitchCurve] = {}


def register(family: type[PitchCurve]) -> type[PitchCurve]:
    """Add a family to the registry."""
    FAMILIES[family.name] = family()
    return family
