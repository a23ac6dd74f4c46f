"""Curvature of the pitch curves and contact ratio along them, over the two segments that each curve is deformed in.

A segment is run through by u from 0 to pi, t = u/m in the first and t = 2 pi - u/m2 in the second; all families are
even in u about both ends, so that whatever is an extreme inside is one in u, and the ends are the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from planter.gears import Stage
from planter.kernels import Kernel

ASIDE = 1e-7
"""How far inside its ends a segment is taken [rad]: an even curve differs there by the square of it."""
TOOTH = ("pitch_curvature", "curvature_radius", "contact_ratio")
"""Requirements that stand along pitch curves."""
INNER, OUTER, RATIO = 0, 1, 2
"""Rows of a segment: curvature of the inner gear and of its conjugate [1/m], contact ratio [-]."""


@dataclass(frozen=True)
class Teeth:
    """Rack teeth: module [m], pressure angle [rad]; the addendum is one module."""

    module: float
    pressure_angle: float


def segment(stage: Stage, second: bool, teeth: Teeth) -> ca.Function:
    """(u, parameters, hoisted) -> rows (3,) of a segment, and their first and second derivatives in u.

    With r'' as in `contact`: the inner gear's curvature is (r^2 + 2 r'^2 - r r'') / (r^2 + r'^2)^(3/2); its conjugate
    has the radius a - r over an angle that grows with the ratio f.
    """
    contact = stage.contact.function
    u, p = ca.SX.sym("u"), ca.SX.sym("parameters", contact.size1_in(1))
    hoisted = ca.SX.sym("hoisted", contact.size1_in(2))
    m = p[-1]
    inside = ASIDE + u * (1 - 2 * ASIDE / np.pi)
    t = 2 * np.pi - inside * (2 * m - 1) / m if second else inside / m
    r, dr, ddr, f, df, _ = contact(t, p, hoisted)
    other = (hoisted[0] - r, -dr / f, (dr * df / f - ddr) / f**2)
    bends = [_curvature(r, dr, ddr), _curvature(*other)]
    rows = ca.vertcat(*bends, contact_ratio(bends[0], bends[1], teeth))
    first = ca.jacobian(rows, u)
    return ca.Function("segment", [u, p, hoisted], [rows, ca.densify(first), ca.densify(ca.jacobian(first, u))])


def _curvature(r: ca.SX, dr: ca.SX, ddr: ca.SX) -> ca.SX:
    return (r**2 + 2 * dr**2 - r * ddr) / (r**2 + dr**2) ** 1.5


def contact_ratio(one: ca.SX, two: ca.SX, teeth: Teeth) -> ca.SX:
    """Contact ratio of rack teeth on two pitch curves by their curvatures at the pitch point [1/m].

    That of the two circles which osculate there: each adds sqrt((rho + h)^2 - (rho cos a)^2) - rho sin a to the path
    of contact, over the base pitch pi module cos a (ISO 21771). In terms of 1/rho, so that a straight or hollow place
    is no exception.
    """
    h, sine = teeth.module, float(np.sin(teeth.pressure_angle))

    def reach(bend: ca.SX) -> ca.SX:
        under = sine**2 + 2 * h * bend + (h * bend) ** 2
        return (2 * h + h**2 * bend) / (ca.sqrt(ca.fmax(under, 1e-12)) + sine)

    return (reach(one) + reach(two)) / (np.pi * teeth.module * np.cos(teeth.pressure_angle))


def kernel(f: ca.Function) -> Kernel:
    """A segment's rows at many u."""
    inputs = f.sx_in()
    named = ca.Function("segment", inputs, f.call(inputs), ["u", "parameters", "hoisted"], ["f", "df", "ddf"])
    return Kernel(named, lanes=["u"])
