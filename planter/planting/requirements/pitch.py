"""Curvature of the pitch curves and contact ratio along them, over the two segments that each curve is deformed in.

A segment is run through by u from 0 to pi, t = u/m in the first and t = 2 pi - u/m2 in the second, so that the
curvature, which jumps at their joints, has its extremes inside a segment or at its ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from planter.gear_geometry.flanks import TEETH
from planter.gear_geometry.stage import Stage
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

    @property
    def sizes(self) -> dict[str, float]:
        """By the names of the derivation."""
        return {"module": self.module, "ha1": 1.0, "ha2": 1.0, "alpha0": self.pressure_angle}


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
    """Contact ratio of rack teeth on two pitch curves by their curvatures at the pitch point [1/m]."""
    return TEETH.composed("contact_ratio", {"kappa1": one, "kappa2": two, **teeth.sizes})["epsilon"]


def kernel(f: ca.Function) -> Kernel:
    """A segment's rows at many u."""
    inputs = f.sx_in()
    named = ca.Function("segment", inputs, f.call(inputs), ["u", "parameters", "hoisted"], ["f", "df", "ddf"])
    return Kernel(named, lanes=["u"])
