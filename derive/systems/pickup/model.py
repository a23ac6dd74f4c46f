"""What is computed of the seedling pick-up: functions in closed form from its derivation, each on its own.

Splines, roots and integrals are numbers' work; what stands here is geometry: from a tip to the angles of its mechanism,
from the angles to the tip, from the slope of the arm's angle to pitch curves and teeth.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, cos, pi

from ...branches import wrap
from ...equations import Claimed
from ...mechanics.frames import Frame, Vec, Z
from ...model import ClosedForm, Let, System
from ...quantity import Quantity, Vector
from . import points
from . import quantities as q
from .claims import ASSUMPTIONS, formula, formulas
from .geometry import ARM, CARRIER, WORLD, along
from .vocabulary import PickupClaim


def _derived(name: str, unit: str, meaning: str, shown: str = "") -> Quantity:
    return Quantity(name, unit, meaning, "derived: pick-up", shown)


t = _derived("t", "rad", "carrier angle counted from where the tip is farthest", "t_deg")
turn = _derived("tau", "rad", "the carrier angle within its turn")
p = Quantity("p", "1", "swing of the arm's slope over its mean on the teeth", "assumed", "law.p")
c = Quantity("c", "1", "mean slope of the arm's angle on the teeth", "derived: one turn of the arm in a turn")
dwell_start = Quantity("dwell_start", "rad", "where the dwell begins, from the farthest tip", "assumed")
dwell_end = Quantity("dwell_end", "rad", "where the dwell ends, from the farthest tip", "assumed")
slope, dslope, ddslope = (
    _derived(name, "1", f"slope of the arm's angle over the carrier's, on the teeth{which}")
    for name, which in (("g", ""), ("dg", ", first derivative"), ("ddg", ", second derivative"))
)
short = _derived("short", "m2", "square of the largest distance of the tip less that of its distance")
over = _derived("over", "m2", "square of the tip's distance less that of the least")
way = _derived("way", "1", "1 from the farthest tip to the nearest, -1 on the way back")
arm_heading = _derived("psi", "rad", "direction of the arm, O1 to tip")
axis = _derived("axis", "rad", "direction of the cell's axis, into the cell")
x_bottom, y_bottom = (_derived(f"{name}_bottom", "m", f"a point on the cell's axis, {name}") for name in "xy")
along_axis = _derived("along", "m", "how far the tip lies beyond that point, along the axis")
across_axis = _derived("across", "m", "how far the tip lies beside the axis, to the left")
kappa1 = _derived("kappa1", "1/m", "curvature of the sun's pitch curve, positive if convex")
kappa2 = _derived("kappa2", "1/m", "curvature of the intermediate gear's pitch curve, positive if convex")
arc = _derived("arc", "m", "length of pitch curve that rolls off per radian of the carrier")

LAW = Vector("law", (p, dwell_start, dwell_end, q.phi1_far))
BARS = Vector("bars", (q.L1, q.L2))
CARRIER_DATA = Vector("carrier", (q.L1, q.gamma, q.a2, q.m_n, q.z_1, q.z_2, q.B, q.alpha_n, q.ha_n))
TRIANGLE = Vector("triangle", (q.L1, q.L2, q.gamma, q.a1, q.a2, q.beta1))
SLOPES = Vector("slopes", (slope, dslope, ddslope))
_PAIR = {q.m_n: S.One, q.z_1: S(20), q.z_2: S(20), q.a2: S(21)}
"""Any pair of gears, to tell the helix angle from the other roots."""


def named(*claims: Claimed) -> tuple[Let, ...]:
    """The derived formulas as steps; raises ClaimError for one that is not derived."""
    return tuple(Let(*formula(claim), f"derived: {claim}") for claim in claims)


def closed_form(
    name: str, inputs: tuple[Vector | Quantity, ...], steps: tuple[Let, ...], *outputs: Quantity
) -> ClosedForm:
    return ClosedForm(name, inputs, steps, Vector(f"{name}_outputs", outputs or tuple(step.symbol for step in steps)))


def bars() -> ClosedForm:
    """Lengths of the bars from the extremes of the tip's distance."""
    steps = named(PickupClaim.BAR_L1, PickupClaim.BAR_L2)
    return closed_form("bars", (q.L3_max, q.L3_min), steps)


def carrier() -> ClosedForm:
    """Helical pair and triangle of the carrier from the centre distance of stage 2."""
    symbol, distance = formula(PickupClaim.CENTRE_DISTANCE_2)
    helix = next(root for root in sp.solve(distance - symbol, q.beta) if 0 < root.subs(_PAIR) < pi / 2)
    steps = (
        Let(q.beta, helix, "derived: centre distance of the helical pair"),
        *named(
            PickupClaim.TRANSVERSE_PRESSURE_ANGLE,
            PickupClaim.HELICAL_CONTACT_RATIO,
            PickupClaim.INTERIOR_ANGLE_O,
            PickupClaim.INTERIOR_ANGLE_O1,
            PickupClaim.CENTRE_DISTANCE_1,
        ),
    )
    return closed_form("carrier", (CARRIER_DATA,), steps)


def law() -> ClosedForm:
    """The assumed slope c (1 + p cos t) on the teeth, none in the dwell; one turn of the arm in a turn."""
    plain = 1 + p * cos(t)
    grown = sp.integrate(plain, (t, 0, t))

    def until(angle: Expr) -> Expr:
        """Integral of the plain slope over the teeth up to an angle of the first turn."""
        before, after = sp.Min(angle, dwell_start), sp.Max(angle, dwell_end)
        return grown.subs(t, before) + grown.subs(t, after) - grown.subs(t, dwell_end)

    whole = grown.subs(t, dwell_start) + grown.subs(t, 2 * pi) - grown.subs(t, dwell_end)
    steps = (
        Let(turn, wrap(t, 2 * pi), "derived: within a turn"),
        Let(c, 2 * pi / whole, "derived: one turn of the arm in a turn"),
        Let(q.phi1, q.phi1_far + c * until(turn) + t - turn, "derived: integral of the slope"),
        Let(slope, c * plain, "assumed: slope on the teeth"),
        Let(dslope, c * plain.diff(t), "derived: slope of the slope"),
        Let(ddslope, c * plain.diff(t, 2), "derived: bend of the slope"),
    )
    return closed_form("law", (t, LAW), steps, q.phi1, slope, dslope, ddslope)


def inverse() -> ClosedForm:
    """Angles of arm and carrier from the tip, well conditioned at the ends of the arm's swing.

    Square distances are taken from their extremes: near those, arccosines of (12), (13) lose half of the digits.
    """
    stretched = along(CARRIER, q.L1) + along(ARM, q.L2).resolved(CARRIER)
    square = sp.simplify(stretched.dot(stretched))
    most, least = (formula(PickupClaim.EXTREME_DISTANCE.of(word))[1] ** 2 for word in ("farthest", "nearest"))
    half = sp.Symbol("half")
    shares = [sp.expand(sp.expand_trig(part.subs(q.phi1, 2 * half))) for part in (square - least, most - square)]
    if sp.simplify(shares[0] * cos(half) ** 2 - shares[1] * sp.sin(half) ** 2) != 0:
        raise ValueError("the tangent of half the arm's angle is not the root of the two squares' ratio")
    phi1 = 2 * pi - way * 2 * sp.atan2(sp.sqrt(over), sp.sqrt(short))
    x, y = stretched.components[:2]
    back = sp.atan2(-y, -x)
    steps = (
        Let(q.phi1, phi1, "derived: arm's angle by half angles"),
        Let(q.phi6, pi - back, "derived: direction of the tip, seen from O in the carrier"),
        Let(q.phi4, sp.atan2(q.y_S, q.x_S), "derived: direction of the tip"),
        *named(PickupClaim.DIRECTION_O_O1),
    )
    return closed_form("inverse", (q.x_S, q.y_S, short, over, way, BARS), steps)


def motion() -> ClosedForm:
    """Axes, tip and its velocity from the angles of carrier and arm; headings as derived, not as printed."""
    rate = formula(PickupClaim.PLANET_RATE)[1].subs(q.iZ, 1 / slope)
    steps = (
        *named(PickupClaim.DIRECTION_O_M1, PickupClaim.DIRECTION_M1_O1),
        *named(PickupClaim.PLANET_ANGLE, PickupClaim.DIRECTION_O1_S),
        Let(q.phi3_dot, rate, "derived: rate of the planet's angle"),
        *named(*(what.of(point, axis) for point in ("M1", "O1", "S")
                 for what in (PickupClaim.PLACE, PickupClaim.VELOCITY) for axis in "xy")),
        *named(PickupClaim.TIP_DISTANCE),
    )  # fmt: skip
    wanted = (q.Z1, q.x_M1, q.y_M1, q.x_O1, q.y_O1, q.x_S, q.y_S, q.vx_S, q.vy_S, q.L3)
    return closed_form("motion", (q.phi5, q.phi1, slope, q.omega, TRIANGLE), steps, *wanted)


def pitch() -> ClosedForm:
    """Pitch curves from the slope of the arm's angle: radii, places in their own gears, curvatures, arc."""
    by_law = dict(zip(points.LAW, (slope, dslope, ddslope), strict=True))
    slopes = points.pitch_slopes(formulas())
    middle = formula(PickupClaim.MIDDLE_PITCH_RADIUS)[1].subs(q.i1, 1 / slope)
    bends = {kappa: 1 / formula(PickupClaim.CURVATURE_RADIUS.of(gear))[1]
             for kappa, gear in ((kappa1, "sun"), (kappa2, "intermediate gear"))}  # fmt: skip
    steps = (
        Let(q.R2, sp.factor(middle), "derived: pitch radius of the intermediate gear"),
        *named(PickupClaim.SUN_PITCH_RADIUS),
        *(
            Let(symbol, sp.factor(slopes[symbol].subs(by_law)), f"derived: {symbol.meaning}")
            for symbol in (q.dR1, q.ddR1)
        ),
        *named(*(PickupClaim.PITCH_CURVE.of(gear, axis) for gear in ("sun", "intermediate gear") for axis in "xy")),
        *(Let(kappa, bend, f"derived: {kappa.meaning}") for kappa, bend in bends.items()),
        Let(arc, sp.sqrt(q.R1**2 + q.dR1**2), "derived: arc of the sun's pitch curve"),
    )
    return closed_form("pitch", (SLOPES, q.phi5, q.phi2, q.a1), steps)


def entry() -> ClosedForm:
    """Where the tip lies in the frame of a tray's cell."""
    cell = Frame("cell, x along its axis", WORLD, Z, axis)
    gap = Vec(WORLD, (q.x_S - x_bottom, q.y_S - y_bottom, S.Zero)).resolved(cell)
    steps = (
        Let(along_axis, gap[0], "derived: place along the cell's axis"),
        Let(across_axis, gap[1], "derived: place beside the cell's axis"),
    )
    return closed_form("entry", (q.x_S, q.y_S, x_bottom, y_bottom, axis), steps)


def exact() -> System:
    """All of it, under the name of its module."""
    return System(
        "pickup_exact",
        "Seedling pick-up, from first principles",
        "derived (geometry)",
        ASSUMPTIONS,
        closed_forms=(bars(), carrier(), law(), inverse(), motion(), pitch(), entry()),
    )


SYSTEMS = (exact,)
