"""Pitch curves: what a family states, the registry of families, and what follows from a radius
alone.

A family states its radius; the two-segment deformation, conjugate, ratio, rotation, curvature, arc
length and the behaviour under a change of size are derived from it (Litvin, Fuentes-Aznar,
Gonzalez-Perez, Hayasaka: Noncircular Gears, 2009). The built-in families are in
`derive.mechanics.gearing.families`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import sympy as sp
from sympy import Expr, pi

from ...functions import switch, wrap
from ...model import Let
from ...quantity import Quantity, Vector

_SOURCE = "pitch curve"
u = Quantity("u", "rad", "parameter of the undeformed pitch curve", _SOURCE)
t = Quantity("t", "rad", "polar angle of the gear at the contact", _SOURCE)
a = Quantity("a", "m", "centre distance", _SOURCE)
m = Quantity("m", "1", "deformation coefficient", _SOURCE, shown="m")
swing = Quantity(
    "swing", "1", "relative swing of the ratio, (largest - least) / (largest + least)", _SOURCE
)
STEEPER = sp.Max(m, m / (2 * m - 1))
"""Slope of the parameter in the steeper of the two segments of a deformed curve; at least 1."""


@dataclass(frozen=True)
class Condition:
    """A condition on the parameters: an expression that must be positive."""

    name: str
    positive: Expr
    allowed: str


@dataclass(frozen=True)
class Shape:
    """A shape parameter of a family, with the range in which the extremes of the radius stay at u =
    0 and pi.
    """

    quantity: Quantity
    lower: Expr
    upper: Expr


@dataclass(frozen=True)
class ByClosure:
    """Centre distance from one revolution for one revolution: the mean ratio over u is 1 (wang2017,
    section 3.2).

    The mean ratio falls with a and is convex, so Newton's method started below the root increases
    towards it; twice the mean radius lies below the root by Jensen's inequality.
    """

    ratio: Expr


@dataclass(frozen=True)
class BySeries:
    """Rotation from the cosine series of the ratio, 1 + sum b_k cos(k u), with as many terms as
    specified.
    """

    ratio: Expr


class PitchCurve(ABC):
    """A closed pitch curve r(u), even in u, with its largest radius at u = 0 and its least at u =
    pi.
    """

    name: str
    title: str
    parameters: tuple[Quantity, ...]
    shapes: tuple[Shape, ...] = ()

    @abstractmethod
    def radius(self) -> Expr:
        """Return the pitch radius r(u) [m]; its derivatives are derived from it."""

    @abstractmethod
    def conditions(self) -> list[Condition]:
        """Return what the parameters must satisfy in addition to r < a and m > 1/2."""

    @abstractmethod
    def relative(self) -> tuple[Expr, ...]:
        """Return the parameters of a curve of unit size with the relative swing ``swing``.

        Without a closed form: those of a curve whose swing grows with ``swing`` and is close to it.
        """

    def centre_distance(self) -> Expr | ByClosure:
        """Return the distance to the conjugate's centre [m], in closed form if there is one."""
        return ByClosure(self.ratio())

    def turned(self) -> Expr | BySeries:
        """Return the rotation of the conjugate from u = 0 [rad]: the integral of the ratio over
        u.
        """
        return BySeries(self.ratio())

    def ratio(self) -> Expr:
        """Return the rotation of the conjugate per rotation of the gear [1], r / (a - r)."""
        return self.radius() / (a - self.radius())

    def convexity(self) -> Expr | None:
        """Return an expression [1] that is positive if and only if the deformed curve is convex;
        None without one.
        """
        return None


FAMILIES: dict[str, PitchCurve] = {}


def register(family: type[PitchCurve]) -> type[PitchCurve]:
    """Add a family to the registry under its name, and return it."""
    FAMILIES[family.name] = family()
    return family


tau = Quantity("tau", "rad", "polar angle within the revolution", _SOURCE)
m2 = Quantity("m2", "1", "deformation coefficient of the second segment", _SOURCE)
du = Quantity("du", "1", "slope of the parameter, per polar angle", _SOURCE)
ahead = Quantity(
    "ahead", "rad", "rotation of the undeformed conjugate since u = 0, less u", _SOURCE
)
r = Quantity("r", "m", "pitch radius of the gear", _SOURCE)
dr = Quantity("dr", "m", "slope of the pitch radius, per polar angle", _SOURCE)
ddr = Quantity("ddr", "m", "second derivative of the pitch radius, per polar angle", _SOURCE)
ratio = Quantity("ratio", "1", "rotation of the conjugate per rotation of the gear", _SOURCE)
dratio = Quantity("dratio", "1", "slope of the ratio, per polar angle", _SOURCE)
turned = Quantity(
    "turned", "rad", "rotation of the conjugate since t = 0, full revolutions included", _SOURCE
)
CONTACT = Vector("contact", (r, dr, ddr, ratio, dratio, turned))


_CLOSED = Let(m2, m / (2 * m - 1), "deformation: closure of the two segments")


def _radius_steps(radius: Expr) -> tuple[Let, ...]:
    slope = Let(r_u, radius.diff(u), "pitch curve, differentiated")
    return _CLOSED, Let(r, radius, "pitch curve"), slope


def parameter_steps() -> tuple[Let, ...]:
    """Return the deformation: u = m t up to pi/m, then u = m2 (2 pi - t), where 1/m + 1/m2 = 2
    (wang2017, [10]).
    """
    rest_of_first = pi / m - tau
    return (
        Let(tau, wrap(t, 2 * pi), "deformation: polar angle within the revolution"),
        _CLOSED,
        Let(u, switch(rest_of_first, m * tau, m2 * (2 * pi - tau)), "deformation: parameter"),
        Let(du, switch(rest_of_first, m, -m2), "deformation: slope of the parameter"),
    )


POLAR = Vector(
    "polar",
    tuple(
        Quantity(f"t_{segment}", "rad", f"polar angle at u on the {segment} segment", _SOURCE)
        for segment in ("first", "second")
    ),
)


def polar_steps() -> tuple[Let, ...]:
    """Return the polar angles at which each segment has the parameter u."""
    slope, parameter = parameter_steps()[1], parameter_steps()[2]
    cases = [value for value, _ in parameter.expr.args]
    angles = (sp.solve(case.xreplace({m2: slope.expr}) - u, tau)[0] for case in cases)
    return tuple(
        Let(symbol, sp.factor(angle), "deformation, inverted")
        for symbol, angle in zip(POLAR, angles, strict=True)
    )


def contact_steps(curve: PitchCurve) -> tuple[Let, ...]:
    """Return the contact of the deformed curve with its conjugate at the polar angle t, from the
    radius alone.
    """
    radius, undeformed_ratio = curve.radius(), curve.ratio()
    return (
        Let(r, radius, "pitch curve"),
        Let(dr, radius.diff(u) * du, "pitch curve, differentiated"),
        Let(ddr, radius.diff(u, 2) * du**2, "pitch curve, differentiated"),
        Let(ratio, undeformed_ratio, "conjugation"),
        Let(dratio, undeformed_ratio.diff(u) * du, "conjugation, differentiated"),
        Let(turned, t + switch(pi / m - tau, 1 / m, -1 / m2) * ahead, "conjugation, integrated"),
    )


r_u = Quantity("r_u", "m", "slope of the undeformed pitch radius", _SOURCE)
r_uu = Quantity("r_uu", "m", "second derivative of the undeformed pitch radius", _SOURCE)
ratio_u = Quantity("ratio_u", "1", "slope of the undeformed ratio", _SOURCE)
mate_u = Quantity(
    "mate_u",
    "m",
    "slope of the conjugate's radius, per angle of the conjugate and per slope of u",
    _SOURCE,
)
mate_uu = Quantity("mate_uu", "m", "second derivative of the conjugate's radius, likewise", _SOURCE)
CURVATURE = Vector(
    "curvature",
    tuple(
        Quantity(
            f"{gear}_{segment}",
            "1/m",
            f"curvature of the {gear}'s pitch curve, positive where convex, on the "
            f"{segment} segment",
            _SOURCE,
        )
        for segment in ("first", "second")
        for gear in ("gear", "conjugate")
    ),
)


def curvature_steps(curve: PitchCurve) -> tuple[Let, ...]:
    """Return the curvatures at the parameter u of both segments; u = 0 and pi are the two sides of
    a breakpoint.

    The conjugate of the deformed curve is the deformed conjugate, with the same coefficient: the
    polar angle of the conjugate is its rotation, which the deformation divides by the slope of u as
    it does that of the gear.
    """
    radius, undeformed_ratio = curve.radius(), curve.ratio()
    slopes = (m, m, m2, m2)
    gear, mate = (r, r_u, r_uu), (a - r, mate_u, mate_uu)
    return (
        *_radius_steps(radius),
        Let(r_uu, radius.diff(u, 2), "pitch curve, differentiated"),
        Let(ratio, undeformed_ratio, "conjugation"),
        Let(ratio_u, undeformed_ratio.diff(u), "conjugation, differentiated"),
        Let(mate_u, -r_u / ratio, "conjugate, differentiated by its angle"),
        Let(
            mate_uu,
            (r_u * ratio_u / ratio - r_uu) / ratio**2,
            "conjugate, differentiated by its angle",
        ),
        *(
            Let(symbol, _curvature(*polar, slope), "curvature in polar coordinates")
            for symbol, polar, slope in zip(
                CURVATURE, (gear, mate, gear, mate), slopes, strict=True
            )
        ),
    )


def _curvature(radius: Expr, slope: Expr, bend: Expr, mu: Expr) -> Expr:
    """Return the curvature of r(u(t)) in polar coordinates [1/m], from dr/du, d2r/du2 and the
    constant mu = du/dt.
    """
    square = mu**2 * slope**2
    return (radius**2 + 2 * square - mu**2 * radius * bend) / sp.sqrt(radius**2 + square) ** 3


SPEED = Vector(
    "speed",
    tuple(
        Quantity(
            f"speed_{segment}",
            "m",
            f"arc length of the gear's pitch curve per u on the {segment} segment",
            _SOURCE,
        )
        for segment in ("first", "second")
    ),
)


def speed_steps(curve: PitchCurve) -> tuple[Let, ...]:
    """Return the arc length per parameter u on both segments, each of which runs from u = 0 to pi.

    As the radius, both are even in u with period 2 pi, so that means over equal steps of u are
    spectrally accurate.
    """
    radius = curve.radius()
    return (
        *_radius_steps(radius),
        *(
            Let(
                symbol, sp.sqrt(r**2 + slope**2 * r_u**2) / slope, "arc length in polar coordinates"
            )
            for symbol, slope in zip(SPEED, (m, m2), strict=True)
        ),
    )


def length_parameters(curve: PitchCurve) -> tuple[Quantity, ...]:
    """Return the parameters that are lengths."""
    return tuple(p for p in curve.parameters if p.unit == "m")


def scale_invariants(curve: PitchCurve) -> tuple[Quantity, ...]:
    """Return ratio, its slope and the rotation if similar curves are proved to share them;
    otherwise nothing.

    A closure or a series is a mean of the ratio over u, so that for similar curves the centre
    distance grows with the lengths, and the series is the same.
    """
    expressions = [curve.ratio(), curve.ratio().diff(u), curve.turned()]
    invariant = all(_is_homogeneous(curve, f, 0) for f in expressions if isinstance(f, Expr))
    distance = curve.centre_distance()
    proportional = not isinstance(distance, Expr) or _is_homogeneous(curve, distance, 1)
    return (ratio, dratio, turned) if invariant and proportional else ()


def _is_homogeneous(curve: PitchCurve, f: Expr, degree: int) -> bool:
    """Whether a function of the lengths and the centre distance is homogeneous of a degree, by
    Euler's identity.
    """
    derivative = sum(
        (length * f.diff(length) for length in (*length_parameters(curve), a)), sp.S.Zero
    )
    return bool(sp.simplify(derivative - degree * f) == 0)
