"""Curvature of the pitch curves and contact ratio along them, over the two segments that each curve is deformed in.

A segment is run through by u from 0 to pi, t = u/m in the first and t = 2 pi - u/m2 in the second, so that the
curvature, which jumps at their joints, has its extremes inside a segment or at its ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from planter.gearing.stage import Stage
from planter.kernels import Kernel

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
    """(u, parameters, hoisted) -> rows (3,) of a segment, and their first and second derivatives in u."""
    curvature = stage.curvature.function
    u, p = ca.SX.sym("u"), ca.SX.sym("parameters", curvature.size1_in(1))
    hoisted = ca.SX.sym("hoisted", curvature.size1_in(2))
    found = curvature(u, p, hoisted)
    one, two = found[2:] if second else found[:2]
    rows = ca.vertcat(one, two, contact_ratio(one, two, teeth))
    first = ca.jacobian(rows, u)
    return ca.Function("segment", [u, p, hoisted], [rows, ca.densify(first), ca.densify(ca.jacobian(first, u))])


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
