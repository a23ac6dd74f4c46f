"""Pitch curves in mesh: two-segment deformation, conjugation, curvature; families stand in ``families``.

A family is one small class in one file there. Everything else (derivatives, conjugate, ratio, rotation, curvature) is
derived from its radius (Litvin, Fuentes-Aznar, Gonzalez-Perez, Hayasaka: Noncircular Gears, 2009).
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, pi

from ..branches import switch, wrap
from ..discovery import modules
from ..model import Let
from ..quantity import Quantity, Vector
from . import families
from .pitch_curve import FAMILIES, STEEPER, BySeries, Condition, PitchCurve, a, m, swing, t, u

__all__ = [
    "CONTACT", "CURVATURE", "FAMILIES", "POLAR", "SPEED", "STEEPER", "BySeries", "Condition", "PitchCurve", "a",
    "contact_steps", "curvature_steps", "m", "parameter_steps", "polar_steps", "speed_steps", "swing", "t", "u",
]  # fmt: skip


modules(families)

_SOURCE = "pitch curve"
tau = Quantity("tau", "rad", "polar angle within the turn", _SOURCE)
m2 = Quantity("m2", "1", "deformation coefficient of the second segment", _SOURCE)
du = Quantity("du", "1", "slope of the parameter, per polar angle", _SOURCE)
ahead = Quantity("ahead", "rad", "rotation of the undeformed conjugate since u = 0, less u", _SOURCE)
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


POLAR = Vector(
    "polar",
    tuple(
        Quantity(f"t_{which}", "rad", f"polar angle at u on the {which} segment", _SOURCE)
        for which in ("first", "second")
    ),
)


def polar_steps() -> tuple[Let, ...]:
    """Polar angles at the parameter u: where each segment has it."""
    slope, parameter = parameter_steps()[1], parameter_steps()[2]
    cases = [value for value, _ in parameter.expr.args]
    angles = (sp.solve(case.xreplace({m2: slope.expr}) - u, tau)[0] for case in cases)
    return tuple(
        Let(symbol, sp.factor(angle), "deformation, inverted") for symbol, angle in zip(POLAR, angles, strict=True)
    )


def contact_steps(curve: PitchCurve) -> tuple[Let, ...]:
    """Contact of the deformed curve with its conjugate at the polar angle t, from the radius alone."""
    radius, of_u = curve.radius(), curve.ratio()
    return (
        Let(r, radius, "pitch curve"),
        Let(dr, radius.diff(u) * du, "pitch curve, differentiated"),
        Let(ddr, radius.diff(u, 2) * du**2, "pitch curve, differentiated"),
        Let(ratio, of_u, "conjugation"),
        Let(dratio, of_u.diff(u) * du, "conjugation, differentiated"),
        Let(turned, t + switch(pi / m - tau, 1 / m, -1 / m2) * ahead, "conjugation, integrated"),
    )


r_u = Quantity("r_u", "m", "slope of the undeformed pitch radius", _SOURCE)
r_uu = Quantity("r_uu", "m", "second derivative of the undeformed pitch radius", _SOURCE)
ratio_u = Quantity("ratio_u", "1", "slope of the undeformed ratio", _SOURCE)
mate_u = Quantity("mate_u", "m", "slope of the conjugate's radius, per angle of its own and per slope of u", _SOURCE)
mate_uu = Quantity("mate_uu", "m", "second derivative of the conjugate's radius, likewise", _SOURCE)
CURVATURE = Vector(
    "curvature",
    tuple(
        Quantity(f"{gear}_{segment}", "1/m", f"curvature of the {gear}'s pitch curve, positive where convex, on the "
                 f"{segment} segment", _SOURCE)
        for segment in ("first", "second")
        for gear in ("gear", "conjugate")
    ),
)  # fmt: skip


def curvature_steps(curve: PitchCurve) -> tuple[Let, ...]:
    """Curvatures at the parameter u of either segment, both sides of a joint so at its u = 0 or pi.

    The conjugate of the deformed curve is the deformed conjugate, with the same coefficient: its own polar angle is
    its rotation, which the deformation divides by the slope of u as it does the gear's.
    """
    radius, of_u = curve.radius(), curve.ratio()
    slopes = (m, m, m2, m2)
    gear, mate = (r, r_u, r_uu), (a - r, mate_u, mate_uu)
    return (
        Let(m2, m / (2 * m - 1), "deformation: closure of the two segments"),
        Let(r, radius, "pitch curve"),
        Let(r_u, radius.diff(u), "pitch curve, differentiated"),
        Let(r_uu, radius.diff(u, 2), "pitch curve, differentiated"),
        Let(ratio, of_u, "conjugation"),
        Let(ratio_u, of_u.diff(u), "conjugation, differentiated"),
        Let(mate_u, -r_u / ratio, "conjugate, differentiated in its own angle"),
        Let(mate_uu, (r_u * ratio_u / ratio - r_uu) / ratio**2, "conjugate, differentiated in its own angle"),
        *(
            Let(symbol, _curvature(*polar, slope), "curvature in polar coordinates")
            for symbol, polar, slope in zip(CURVATURE, (gear, mate, gear, mate), slopes, strict=True)
        ),
    )


def _curvature(radius: Expr, slope: Expr, bend: Expr, mu: Expr) -> Expr:
    """Of a curve in polar coordinates whose radius has these derivatives in u, and u the slope mu in the angle."""
    along = mu**2 * slope**2
    return (radius**2 + 2 * along - mu**2 * radius * bend) / sp.sqrt(radius**2 + along) ** 3


SPEED = Vector(
    "speed",
    tuple(
        Quantity(
            f"speed_{segment}", "m", f"arc length of the gear's pitch curve per u on the {segment} segment", _SOURCE
        )
        for segment in ("first", "second")
    ),
)


def speed_steps(curve: PitchCurve) -> tuple[Let, ...]:
    """Arc lengths per parameter u of either segment, which runs from u = 0 to pi.

    Both are even in u and of period 2 pi, as the radius is: their means over u are spectrally accurate.
    """
    radius = curve.radius()
    return (
        Let(m2, m / (2 * m - 1), "deformation: closure of the two segments"),
        Let(r, radius, "pitch curve"),
        Let(r_u, radius.diff(u), "pitch curve, differentiated"),
        *(
            Let(symbol, sp.sqrt(r**2 + slope**2 * r_u**2) / slope, "arc length in polar coordinates")
            for symbol, slope in zip(SPEED, (m, m2), strict=True)
        ),
    )
