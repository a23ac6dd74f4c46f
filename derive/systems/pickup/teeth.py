"""Teeth of both stages of the seedling pick-up: centre distance of the helical pair, contact ratios.

At a contact a non-circular gear meshes like the circular gear of its radius of curvature (`derive.gearing.teeth`).
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr, S, cos, pi, sin

from ...formulas import Formulas
from ...gearing.teeth import TRANSVERSE, base_pitch, path_of_action
from ...mechanics.frames import Frame, Vec, Y
from ...quantity import Quantity
from . import quantities as q
from .vocabulary import PickupClaim


def helical_pitch() -> Expr:
    """Transverse pitch: the normal pitch, pi times the module, projected back along the helix."""
    pitch = sp.Symbol("pitch")
    normal = Frame("normal section", TRANSVERSE, Y, q.beta)
    across = Vec(TRANSVERSE, (pitch, S.Zero, S.Zero)).resolved(normal)[0]
    return sp.solve(across - pi * q.m_n, pitch)[0]


def pitch_radius(teeth: Quantity) -> Expr:
    """The radius whose circumference holds the teeth."""
    return teeth * helical_pitch() / (2 * pi)


def transverse_pressure_angle() -> Expr:
    """From the tooth normal, which lies in the normal section."""
    normal = Vec(Frame("normal section", TRANSVERSE, Y, q.beta), (cos(q.alpha_n), sin(q.alpha_n), S.Zero))
    along, radial, _ = normal.resolved(TRANSVERSE).components
    return sp.atan(radial / along)


def helical_contact_ratio() -> Expr:
    """Transverse part and overlap; teeth without profile shift."""
    angle, addendum = q.alpha_t, q.ha_n * q.m_n
    path = sp.Add(*(path_of_action(pitch_radius(z), addendum, angle) for z in (q.z_1, q.z_2)))
    lead = q.B * sp.tan(q.beta)
    return path / base_pitch(helical_pitch(), angle) + lead / helical_pitch()


def state(f: Formulas) -> None:
    """Claims about teeth; of the slopes of the contact ratio only what is proved of their signs."""
    paths = [path_of_action(rho, ha * q.m, q.alpha0) for rho, ha in ((q.rho1, q.ha1), (q.rho2, q.ha2))]
    ratio = (q.g1 + q.g2) / base_pitch(pi * q.m, q.alpha0)
    whole = ratio.subs({q.g1: paths[0], q.g2: paths[1]})
    f.defines(q.a2, sp.factor(pitch_radius(q.z_1) + pitch_radius(q.z_2)), PickupClaim.CENTRE_DISTANCE_2)
    f.defines(q.alpha_t, transverse_pressure_angle(), PickupClaim.TRANSVERSE_PRESSURE_ANGLE)
    f.defines(q.epsilon_h, helical_contact_ratio(), PickupClaim.HELICAL_CONTACT_RATIO)
    f.defines(q.epsilon, ratio, PickupClaim.CONTACT_RATIO)
    f.defines(q.g1, paths[0], PickupClaim.SUN_PATH_OF_ACTION)
    f.defines(q.g2, paths[1], PickupClaim.MIDDLE_PATH_OF_ACTION)
    f.defines(q.epsilon_ha, whole.diff(q.ha1) + whole.diff(q.ha2), PickupClaim.ADDENDUM_SLOPE)
    f.defines(q.epsilon_m, whole.diff(q.m), PickupClaim.MODULE_SLOPE)
    if grows_with_addendum():
        f.holds(PickupClaim.GROWS_WITH_ADDENDUM, q.epsilon_ha, ">")
    if falls_with_module():
        f.holds(PickupClaim.FALLS_WITH_MODULE, q.epsilon_m, "<")


def grows_with_addendum() -> bool:
    """Whether each path of action of a convex pitch curve grows with the addendum coefficient."""
    path, _, h = _path_of_positives()
    return bool(path.diff(h).is_positive)


def falls_with_module() -> bool:
    """Whether each path of action per module falls with the module: a concave path that begins at zero."""
    path, module, _ = _path_of_positives()
    bend = sp.factor(sp.simplify(path.diff(module, 2)))
    return bool(path.subs(module, 0) == 0 and bend.is_negative)


@cache
def _path_of_positives() -> tuple[Expr, sp.Symbol, sp.Symbol]:
    """Path of action, module and addendum coefficient, all in positive symbols (slope: tangent of the angle)."""
    module, coefficient, radius, slope = sp.symbols("module coefficient radius slope", positive=True)
    angle = sp.Symbol("angle", positive=True)
    hypotenuse = sp.sqrt(1 + slope**2)
    path = path_of_action(radius, coefficient * module, angle)
    return path.subs({sin(angle): slope / hypotenuse, cos(angle): 1 / hypotenuse}), module, coefficient
