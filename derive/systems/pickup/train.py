"""Gear train of the seedling pick-up: rolling pitch curves, ratios, curvature, teeth of both stages.

Pitch curves are described along the two centre lines, whose frames turn with the carrier. At a contact a non-circular
gear meshes like the circular gear of its radius of curvature (`derive.gearing.teeth`).
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr, S, cos, pi, sin

from ...formulas import Formulas
from ...gearing.teeth import TRANSVERSE, base_pitch, path_of_action
from ...mechanics.frames import Frame, Motion, Vec, Y, Z
from ...quantity import Quantity
from . import quantities as q
from .geometry import ARM, CARRIER, TO_M1, WORLD, axial_vector
from .quantities import PickupClaim

SUN = Frame("sun, x along O-M1 at phi5 = 0", WORLD, Z, q.beta1)
BACK = Frame("line M1-O", TO_M1, Z, pi)
MIDDLE = Frame("intermediate gear", BACK, Z, q.phi2)
TURNING = Motion({q.phi5: q.dphi5, q.phi2: q.dphi2, q.phi1: q.dphi1})


def relative_rotation(frame: Frame, motion: Motion = TURNING) -> Expr:
    """Return the increment of a frame's angle relative to the carrier."""
    return motion.spin(frame)[2] - motion.spin(CARRIER)[2]


def slip_on_sun() -> Expr:
    """Return the speed at which the intermediate gear would slip on the stationary sun, at their contact."""
    axis = TURNING.derivative(axial_vector(TO_M1, q.a1))
    contact = TURNING.spin(MIDDLE).resolved(TO_M1).cross(axial_vector(TO_M1, -q.R2))
    return (axis + contact)[1]


def helical_slip(motion: Motion) -> Expr:
    """Return the speed at which the two equal helical gears would slip on each other, relative to the carrier."""
    radius = q.a2 / 2
    return sp.expand(relative_rotation(MIDDLE, motion) * radius - relative_rotation(ARM, motion) * (-radius))


def _add_ratios(f: Formulas) -> None:
    """Add ratios and pitch radii; the ratio of an external pair is positive."""
    stage1 = -relative_rotation(WORLD) / relative_rotation(MIDDLE)
    total = relative_rotation(WORLD) / relative_rotation(ARM)
    helical = sp.solve(helical_slip(TURNING), q.dphi2)[0]
    carrier = sp.solve(stage1 - q.i1, q.dphi5)[0]
    through = total.subs(q.dphi1, sp.solve(helical_slip(TURNING), q.dphi1)[0]).subs(q.dphi5, carrier)
    at_dwell = sp.solve(helical_slip(Motion({**TURNING.rates, q.phi2: S.Zero})), q.dphi1)[0]
    radius = sp.solve(slip_on_sun().subs(q.dphi5, carrier), q.R2)[0]
    gap = axial_vector(TO_M1, q.a1) + axial_vector(BACK, q.R2).resolved(TO_M1) - axial_vector(TO_M1, q.R1)
    f.defines(q.dphi2, helical, PickupClaim.MIDDLE_TURN)
    f.defines(q.i1, stage1, PickupClaim.RATIO_1)
    f.defines(q.iZ, total, PickupClaim.TOTAL_RATIO, named=True)
    f.defines(q.iZ, sp.cancel(through), PickupClaim.TOTAL_RATIO_BY_STAGES)
    f.defines(q.g_locked, (1 / total).subs(q.dphi1, at_dwell), PickupClaim.DWELL_RATIO)
    f.defines(q.R2, sp.factor(radius), PickupClaim.MIDDLE_PITCH_RADIUS)
    f.defines(q.R1, sp.solve(gap[0], q.R1)[0], PickupClaim.SUN_PITCH_RADIUS)


def contact_points() -> tuple[Vec, Vec]:
    """Return the contact on the sun and on the intermediate gear, each in the frame of its gear."""
    return axial_vector(TO_M1, q.R1).resolved(SUN), axial_vector(BACK, q.R2).resolved(MIDDLE)


def curvature_radius(curve: Vec, motion: Motion) -> Expr:
    """Return the radius of curvature of a plane curve that the motion follows counter-clockwise."""
    x, y = curve.components[:2]
    dx, dy = motion.rate(x), motion.rate(y)
    ddx, ddy = motion.rate(dx), motion.rate(dy)
    bend = sp.simplify(dx * ddy - dy * ddx)
    return sp.simplify(dx**2 + dy**2) ** sp.Rational(3, 2) / bend


def _add_curves(f: Formulas) -> None:
    """Add pitch curves and curvatures; contacts run counter-clockwise on the sun, clockwise on the other gear."""
    sun, middle = contact_points()
    rolling = Motion({q.phi5: S.One, q.phi2: q.R1 / q.R2, q.R1: q.dR1, q.R2: -q.dR1, q.dR1: q.ddR1})
    f.defines(q.x1, sun[0], PickupClaim.PITCH_CURVE.of("sun", "x"))
    f.defines(q.y1, sun[1], PickupClaim.PITCH_CURVE.of("sun", "y"))
    f.defines(q.x2, middle[0], PickupClaim.PITCH_CURVE.of("intermediate gear", "x"))
    f.defines(q.y2, middle[1], PickupClaim.PITCH_CURVE.of("intermediate gear", "y"))
    f.defines(q.rho1, curvature_radius(sun, rolling), PickupClaim.CURVATURE_RADIUS.of("sun"))
    f.defines(q.rho2, -curvature_radius(middle, rolling), PickupClaim.CURVATURE_RADIUS.of("intermediate gear"))


def add_train(f: Formulas) -> None:
    """Add the equations of the gear train."""
    _add_ratios(f)
    _add_curves(f)


def helical_pitch() -> Expr:
    """Return the transverse pitch: the normal pitch, pi times the module, projected along the helix."""
    pitch = sp.Symbol("pitch")
    normal = Frame("normal section", TRANSVERSE, Y, q.beta)
    across = Vec(TRANSVERSE, (pitch, S.Zero, S.Zero)).resolved(normal)[0]
    return sp.solve(across - pi * q.m_n, pitch)[0]


def pitch_radius(teeth: Quantity) -> Expr:
    """Return the radius with a circumference of the teeth's pitches."""
    return teeth * helical_pitch() / (2 * pi)


def transverse_pressure_angle() -> Expr:
    """Return the transverse pressure angle, from the tooth normal in the normal section."""
    normal = Vec(Frame("normal section", TRANSVERSE, Y, q.beta), (cos(q.alpha_n), sin(q.alpha_n), S.Zero))
    tangential, radial, _ = normal.resolved(TRANSVERSE).components
    return sp.atan(radial / tangential)


def helical_contact_ratio() -> Expr:
    """Return the transverse contact ratio plus the overlap ratio, of teeth without profile shift."""
    angle, addendum = q.alpha_t, q.ha_n * q.m_n
    path = sp.Add(*(path_of_action(pitch_radius(z), addendum, angle) for z in (q.z_1, q.z_2)))
    lead = q.B * sp.tan(q.beta)
    return path / base_pitch(helical_pitch(), angle) + lead / helical_pitch()


def add_teeth(f: Formulas) -> None:
    """Add the equations of the teeth; of the slopes of the contact ratio only the signs that are proved."""
    paths = [path_of_action(rho, ha * q.m, q.alpha0) for rho, ha in ((q.rho1, q.ha1), (q.rho2, q.ha2))]
    ratio = (q.g1 + q.g2) / base_pitch(pi * q.m, q.alpha0)
    full_ratio = ratio.subs({q.g1: paths[0], q.g2: paths[1]})
    f.defines(q.a2, sp.factor(pitch_radius(q.z_1) + pitch_radius(q.z_2)), PickupClaim.CENTRE_DISTANCE_2)
    f.defines(q.alpha_t, transverse_pressure_angle(), PickupClaim.TRANSVERSE_PRESSURE_ANGLE)
    f.defines(q.epsilon_h, helical_contact_ratio(), PickupClaim.HELICAL_CONTACT_RATIO)
    f.defines(q.epsilon, ratio, PickupClaim.CONTACT_RATIO)
    f.defines(q.g1, paths[0], PickupClaim.SUN_PATH_OF_ACTION)
    f.defines(q.g2, paths[1], PickupClaim.MIDDLE_PATH_OF_ACTION)
    f.defines(q.epsilon_ha, full_ratio.diff(q.ha1) + full_ratio.diff(q.ha2), PickupClaim.ADDENDUM_SLOPE)
    f.defines(q.epsilon_m, full_ratio.diff(q.m), PickupClaim.MODULE_SLOPE)
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
    """Return path of action, module and addendum coefficient in positive symbols (slope: tangent of the angle)."""
    module, coefficient, radius, slope = sp.symbols("module coefficient radius slope", positive=True)
    angle = sp.Symbol("angle", positive=True)
    hypotenuse = sp.sqrt(1 + slope**2)
    path = path_of_action(radius, coefficient * module, angle)
    return path.subs({sin(angle): slope / hypotenuse, cos(angle): 1 / hypotenuse}), module, coefficient
