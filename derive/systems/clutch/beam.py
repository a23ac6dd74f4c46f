"""Engagement of tooth and output shaft in one mode (shi2021, section 3.1), for several shapes of bending.

A shape phi(x) of height 1 at the contact gives the beam the kinetic energy M y'^2 / 2 and the strain energy K y^2 / 2
of one coordinate y, its deflection there (Rayleigh).
"""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp
from sympy import Expr, S, cos, cosh, pi, sin, sinh

from ...equations import Equation
from ...formulas import Formulas, Wanted
from ...model import ClosedForm, Let, System, let
from ...quantity import Quantity, Vector
from . import quantities as q
from .claims import formulas
from .model import FLATS, edge
from .motion import held_at_bearing, mode
from .vocabulary import ClutchClaim

BEND = "beam"
ASSUMPTIONS = (
    "output shaft is a uniform Euler-Bernoulli beam of hexagonal section, in one assumed shape",
    "shaft end undeformed at contact and at the body's speed; both move together",
)

Z = sp.Symbol("z", nonnegative=True)
"""Place along the overhang as a share of it."""
DIGITS = 40


def _found(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, f"derived: {BEND}")


MASS = _found("mass_coefficient", "1", "modal mass over the mass of the overhang")
STIFFNESS = _found("stiffness_coefficient", "1", "modal stiffness over E I / l^3")
SWING = _found("swing", "N", "amplitude of the load about the driving force")
LAG = _found("lag", "rad", "phase at which the load passes the driving force")
N_0 = _found("N_0", "N", "contact load at the start")
T_MAX = _found("t_max", "s", "time of the largest load")
T_LOSS = _found("t_loss", "s", "time at which contact is lost; after a full swing to zero where it never is")
RATE = _found("rate", "m/s", "speed of tooth and shaft end")
PERIOD = _found("period", "s", "time of a full swing")
GIVEN = _found("given", "J", "work of the driving force since the start")
KEPT = _found("kept", "J", "kinetic and strain energy less that at the start")

BEAM = Vector("beam", (FLATS, q.E, q.rho, q.l))
STRUCK = Vector("struck", (q.m1, q.F_M, q.Delta_omega, q.r1))
"""What strikes the shaft: mass, force, speed difference, radius."""


def clamped_free() -> tuple[Expr, Expr]:
    """First eigenvalue b of the clamped-free beam, cos(b) cosh(b) = -1, and its shape, of height 1 at the end."""
    b = sp.Dummy("b")
    root = sp.nsolve(cos(b) * cosh(b) + 1, b, 1.875, prec=DIGITS)
    share = (cosh(root) + cos(root)) / (sinh(root) + sin(root))
    return root, (cosh(root * Z) - cos(root * Z) - share * (sinh(root * Z) - sin(root * Z))) / 2


def static(fixity: Expr = S.One) -> Expr:
    """A beam in its bearing at z = 0, free of moment at z = 1, under a load there, of height 1 at the end.

    The bearing clamps it, or holds it elastically with a ``fixity`` from 1 down to 0, where it turns freely.
    """
    a, b, c, d = sp.symbols("a b c d")
    shape = a + b * Z + c * Z**2 + d * Z**3
    held = held_at_bearing(shape.subs(Z, q.x / q.l)).values()
    at_bearing = [sp.expand(q.l * left.subs(q.fixity, fixity)) for left in held]
    ends = [*at_bearing, shape.diff(Z, 2).subs(Z, 1), shape.subs(Z, 1) - 1]
    return shape.subs(sp.solve(ends, (a, b, c, d)))


def shapes() -> dict[str, Expr]:
    """Shapes to choose from over z, by name; the first is the paper's."""
    return {
        "quarter_sine": mode().subs(q.x, Z * q.l),
        "clamped_cosine": 1 - cos(pi / 2 * Z),
        "clamped_static": static(),
        "clamped_mode": clamped_free()[1],
    }


def coefficients(shape: Expr) -> tuple[Expr, Expr]:
    """Integrals of the shape squared and of its curvature squared over 0..1."""
    if shape.has(sp.Float):
        return sp.Rational(str(_quadrature(shape))), sp.Rational(str(_quadrature(shape.diff(Z, 2))))
    return _integral(shape), _integral(shape.diff(Z, 2))


def _integral(expr: Expr) -> Expr:
    """Integral of a square over 0..1."""
    return sp.simplify(sp.integrate(expr**2, (Z, 0, 1)))


def _quadrature(expr: Expr) -> sp.Float:
    """Integral of a square over 0..1 to 20 digits."""
    digits = DIGITS // 2
    with mpmath.workdps(digits + 5):
        return sp.N(sp.Float(mpmath.quad(sp.lambdify(Z, expr**2, "mpmath"), (0, 1)), digits + 5), digits)


def modal(f: Formulas, name: str, shape: Expr) -> None:
    """Modal mass and stiffness of the shaft in a shape, and the mass of the whole overhang."""
    mass, stiffness = coefficients(shape)
    steps = (
        edge(),
        ClutchClaim.SHAFT_SECTION,
        ClutchClaim.SECOND_MOMENT,
        ClutchClaim.OVERHANG_MASS,
        let(MASS, mass, BEND),
        let(STIFFNESS, stiffness, BEND),
        let(q.M_1, MASS * q.m2, BEND),
        let(q.K_1, STIFFNESS * q.E * q.I / q.l**3, BEND),
    )
    f.function(name, (BEAM,), *steps, gives=(MASS, STIFFNESS, q.M_1, q.K_1, q.m2, q.I))


def frequency() -> tuple[Let, ...]:
    """Frequency of shaft and body in contact, and the acceleration by the driving force: they move as one mass."""
    moving = q.M_1 + q.m1
    return (let(q.B1, sp.sqrt(q.K_1 / moving), BEND), let(q.B2, q.F_M / moving, BEND))


def extremes(f: Formulas, inputs: tuple[Vector | Quantity, ...], *rates: Wanted) -> ClosedForm:
    """The load as a swing about the driving force: largest, when, and when it is gone."""
    load = sp.expand(formulas().expr(ClutchClaim.CONTACT_LOAD))
    sine, cosine = load.coeff(sin(q.B1 * q.t)), load.coeff(cos(q.B1 * q.t))
    steps = (
        let(SWING, sp.sqrt(sine**2 + cosine**2), BEND),
        let(LAG, sp.atan2(-cosine, sine), BEND),
        let(N_0, load.subs(q.t, 0), BEND),
        let(q.N_max, q.F_M + SWING, BEND),
        let(T_MAX, (pi / 2 + LAG) / q.B1, BEND),
        let(PERIOD, 2 * pi / q.B1, BEND),
        let(T_LOSS, (pi + LAG + sp.asin(sp.Min(S.One, q.F_M / SWING))) / q.B1, BEND),
    )
    given = (q.B1, q.B2, SWING, N_0, q.N_max, T_MAX, T_LOSS, PERIOD)
    return f.function("extremes", inputs, *rates, *steps, gives=given)


def energy(f: Formulas) -> None:
    """Work done since the start, and what has become of it, where tooth and shaft end move together."""
    way = sp.Dummy("way")

    def held(deflection: Expr, speed: Expr) -> Expr:
        strain = sp.integrate(q.K_1 * way, (way, 0, deflection))
        return (q.M_1 + q.m1) * speed**2 / 2 + strain

    steps = (
        ClutchClaim.CONTACT_SPEED,
        let(GIVEN, sp.integrate(q.F_M, (way, 0, q.y_max)), BEND),
        let(KEPT, held(q.y_max, RATE) - held(S.Zero, q.v_0), BEND),
    )
    f.function("energy", (q.y_max, RATE, q.M_1, q.K_1, STRUCK), *steps, gives=(GIVEN, KEPT), told="energies")


def exact() -> System:
    """The engagement from first principles."""
    title = "Engagement in one mode, from first principles"
    stated = formulas().equations.values()
    f = Formulas("clutch_beam", stated, title=title, source="derived", assumptions=ASSUMPTIONS, told="{}")
    for name, shape in shapes().items():
        modal(f, name, shape)
    extremes(f, (q.M_1, q.K_1, STRUCK), *frequency())
    rate = let(RATE, f.expr(ClutchClaim.CONTACT_DEFLECTION).diff(q.t), BEND)
    moving = ClutchClaim.CONTACT_DEFLECTION, ClutchClaim.CONTACT_LOAD, rate
    f.function("motion", (q.t, q.B1, q.B2, STRUCK), *moving, gives=(q.y_max, RATE, q.N))
    f.function("start", (STRUCK,), ClutchClaim.CONTACT_SPEED, told="at_start")
    energy(f)
    return f.system()


def printed(equations: Mapping[str, Equation]) -> System:
    """The engagement with the frequency and the acceleration that a paper prints; from there on it follows (11)."""
    title, source = "Engagement in one mode, as printed", "shi2021 (8)-(12), taken literally"
    said = equations.values()
    f = Formulas("clutch_beam_printed", said, title=title, source=source, assumptions=ASSUMPTIONS, told="{}")
    rates = (ClutchClaim.CONTACT_FREQUENCY, q.B1), (ClutchClaim.DRIVING_ACCELERATION, q.B2)
    extremes(f, (q.E, q.I, q.l, q.m2, STRUCK), *rates)
    return f.system()


SYSTEMS = (exact,)
