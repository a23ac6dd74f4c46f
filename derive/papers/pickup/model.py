"""Models of the seedling pick-up: functions in closed form from its derivation, and the needle in
the tray.

Splines, roots and integrals are computed numerically elsewhere; these functions are geometry: from
a tip to the angles of its mechanism, from the angles to the tip, from the slope of the arm's angle
to pitch curves and teeth.
"""

from __future__ import annotations

from functools import partial

import sympy as sp
from sympy import Expr, S, cos, pi

from ...formulas import Formulas, Wanted
from ...functions import wrap
from ...mechanics.frames import Frame, Point, Vec, Z, displacement
from ...model import Let, System, let
from ...quantity import Quantity, Vector, quantities, read_quantities
from . import quantities as q
from .geometry import ARM, CARRIER, WORLD, axial_vector
from .subject import ARM_SLOPES, ASSUMPTIONS, derive_formulas, pitch_slopes

_derived = partial(Quantity, source="derived: pick-up")


s = read_quantities(
    """
derived: pick-up
t | rad | carrier angle counted from the farthest tip | t_deg
tau | rad | carrier angle within the revolution

assumed
p | 1 | swing of the arm's slope over its mean on the teeth | law.p

derived: one revolution of the arm per cycle
c | 1 | mean slope of the arm's angle on the teeth

assumed
dwell_start | rad | carrier angle at the start of the dwell, from the farthest tip
dwell_end | rad | carrier angle at the end of the dwell, from the farthest tip

derived: pick-up
g | 1 | slope of the arm's angle over the carrier's, on the teeth
dg | 1 | slope of the arm's angle over the carrier's, on the teeth, first derivative
ddg | 1 | slope of the arm's angle over the carrier's, on the teeth, second derivative
short | m2 | square of the largest distance of the tip minus that of its distance
over | m2 | square of the tip's distance minus that of the smallest
way | 1 | 1 from the farthest tip to the nearest, -1 on the way back
psi | rad | direction of the arm, O1 to tip
axis | rad | direction of the cell's axis, into the cell
x_bottom | m | a point on the cell's axis, x
y_bottom | m | a point on the cell's axis, y
along | m | distance of the tip from that point, along the axis
across | m | distance of the tip from the axis, to the left
kappa1 | 1/m | curvature of the sun's pitch curve, positive if convex
kappa2 | 1/m | curvature of the intermediate gear's pitch curve, positive if convex
arc | m | length of pitch curve that rolls off per radian of the carrier
"""
)
"""Quantities of this module."""


LAW = Vector("law", (s.p, s.dwell_start, s.dwell_end, q.phi1_far))
BARS = Vector("bars", (q.L1, q.L2))
CARRIER_DATA = Vector("carrier", q.TABLE.select("L1 gamma a2 m_n z_1 z_2 B alpha_n ha_n"))
TRIANGLE = Vector("triangle", q.TABLE.select("L1 L2 gamma a1 a2 beta1"))
SLOPES = Vector("slopes", s.select("g dg ddg"))
_PAIR = {q.m_n: S.One, q.z_1: S(20), q.z_2: S(20), q.a2: S(21)}
"""An arbitrary pair of gears, to select the helix angle among the roots."""


def _add_functions(f: Formulas) -> None:
    """Add all functions of the pick-up."""
    f.function("bars", (q.L3_max, q.L3_min), "bar L1 from the extremes", "bar L2 from the extremes")
    _carrier(f)
    _law(f)
    _inverse(f)
    _motion(f)
    _pitch(f)
    _entry(f)


def _carrier(f: Formulas) -> None:
    """Add helical pair and triangle of the carrier, from the centre distance of stage 2."""
    roots = sp.solve(f.equations["centre distance of the helical pair"].residual, q.beta)
    helix = next(root for root in roots if 0 < root.subs(_PAIR) < pi / 2)
    steps = (
        let(q.beta, helix, "centre distance of the helical pair"),
        "transverse pressure angle of the helical pair",
        "contact ratio of the helical pair",
        "interior angle at O",
        "interior angle at O1",
        "centre distance of stage 1",
    )
    f.function("carrier", (CARRIER_DATA,), *steps)


def _law(f: Formulas) -> None:
    """Add the assumed slope c (1 + p cos t) on the teeth, zero in the dwell; the arm turns once per
    cycle.
    """
    plain = 1 + s.p * cos(s.t)
    grown = sp.integrate(plain, (s.t, 0, s.t))

    def until(angle: Expr) -> Expr:
        """Return the integral of 1 + p cos t over the teeth up to an angle of the first
        revolution.
        """
        before, after = sp.Min(angle, s.dwell_start), sp.Max(angle, s.dwell_end)
        return grown.subs(s.t, before) + grown.subs(s.t, after) - grown.subs(s.t, s.dwell_end)

    total = grown.subs(s.t, s.dwell_start) + grown.subs(s.t, 2 * pi) - grown.subs(s.t, s.dwell_end)
    steps = (
        let(s.tau, wrap(s.t, 2 * pi), "within a revolution"),
        let(s.c, 2 * pi / total, "one revolution of the arm per cycle"),
        let(q.phi1, q.phi1_far + s.c * until(s.tau) + s.t - s.tau, "integral of the slope"),
        Let(s.g, s.c * plain, "assumed: slope on the teeth"),
        let(s.dg, s.c * plain.diff(s.t), "slope of the slope"),
        let(s.ddg, s.c * plain.diff(s.t, 2), "second derivative of the slope"),
    )
    f.function("law", (s.t, LAW), *steps, gives=(q.phi1, s.g, s.dg, s.ddg))


def _inverse(f: Formulas) -> None:
    """Add the angles of arm and carrier from the tip, well conditioned at the ends of the arm's
    swing.

    Squared distances are relative to their extremes: close to those, arccosines of (12), (13) lose
    half of the digits.
    """
    stretched = axial_vector(CARRIER, q.L1) + axial_vector(ARM, q.L2).resolved(CARRIER)
    square = sp.simplify(stretched.dot(stretched))
    largest, smallest = (f.expr(f"distance, tip {word}") ** 2 for word in ("farthest", "nearest"))
    half = sp.Symbol("half")
    shares = [
        sp.expand(sp.expand_trig(part.subs(q.phi1, 2 * half)))
        for part in (square - smallest, largest - square)
    ]
    if sp.simplify(shares[0] * cos(half) ** 2 - shares[1] * sp.sin(half) ** 2) != 0:
        raise ValueError(
            "the tangent of half the arm's angle is not the root of the two squares' ratio"
        )
    phi1 = 2 * pi - s.way * 2 * sp.atan2(sp.sqrt(s.over), sp.sqrt(s.short))
    x, y = stretched.components[:2]
    back = sp.atan2(-y, -x)
    steps = (
        let(q.phi1, phi1, "arm's angle by half angles"),
        let(q.phi6, pi - back, "direction of the tip, seen from O in the carrier"),
        let(q.phi4, sp.atan2(q.y_S, q.x_S), "direction of the tip"),
        "direction of O-O1 from the tip's",
    )
    f.function("inverse", (q.x_S, q.y_S, s.short, s.over, s.way, BARS), *steps)


def _motion(f: Formulas) -> None:
    """Add axes, tip and its velocity from the angles of carrier and arm, with the derived
    headings.
    """
    rate = f.expr("rate of the planet's angle").subs(q.iZ, 1 / s.g)
    steps: tuple[Wanted, ...] = (
        "direction of O-M1",
        "direction of M1-O1",
        "planet's angle from the arm's",
        "direction of O1-S",
        let(q.phi3_dot, rate, "rate of the planet's angle"),
        *(
            claim.format(point, axis)
            for point in ("M1", "O1", "S")
            for claim in ("place of {}, {}", "velocity of {}, {}")
            for axis in "xy"
        ),
        "distance of the tip",
    )
    outputs = q.TABLE.select("Z1 x_M1 y_M1 x_O1 y_O1 x_S y_S vx_S vy_S L3")
    f.function("motion", (q.phi5, q.phi1, s.g, q.omega, TRIANGLE), *steps, gives=outputs)


def _pitch(f: Formulas) -> None:
    """Add pitch curves from the slope of the arm's angle: radii, points in the gears' frames,
    curvatures, arc.
    """
    by_law = dict(zip(ARM_SLOPES, (s.g, s.dg, s.ddg), strict=True))
    slopes = pitch_slopes(f)
    middle = f.expr("pitch radius of the intermediate gear").subs(q.i1, 1 / s.g)
    bends = {
        kappa: 1 / f.expr(f"radius of curvature of the {gear}")
        for kappa, gear in ((s.kappa1, "sun"), (s.kappa2, "intermediate gear"))
    }
    steps: tuple[Wanted, ...] = (
        let(q.R2, sp.factor(middle), "pitch radius of the intermediate gear"),
        "pitch radius of the sun",
        *(let(symbol, sp.factor(slopes[symbol].subs(by_law))) for symbol in (q.dR1, q.ddR1)),
        *(
            f"pitch curve of the {gear}, {axis}"
            for gear in ("sun", "intermediate gear")
            for axis in "xy"
        ),
        *(let(kappa, bend) for kappa, bend in bends.items()),
        let(s.arc, sp.sqrt(q.R1**2 + q.dR1**2), "arc of the sun's pitch curve"),
    )
    f.function("pitch", (SLOPES, q.phi5, q.phi2, q.a1), *steps)


def _entry(f: Formulas) -> None:
    """Add the coordinates of the tip in the frame of a tray's cell."""
    cell = Frame("cell, x along its axis", WORLD, Z, s.axis)
    gap = Vec(WORLD, (q.x_S - s.x_bottom, q.y_S - s.y_bottom, S.Zero)).resolved(cell)
    steps = (
        let(s.along, gap[0], "position along the cell's axis"),
        let(s.across, gap[1], "position across the cell's axis"),
    )
    f.function("entry", (q.x_S, q.y_S, s.x_bottom, s.y_bottom, s.axis), *steps)


def build_pickup_system() -> System:
    """Build the model of the pick-up from first principles."""
    title, source = "Seedling pick-up, from first principles", "derived (geometry)"
    stated = derive_formulas().equations.values()
    f = Formulas("pickup_exact", stated, title=title, source=source, assumptions=ASSUMPTIONS)
    _add_functions(f)
    return f.system()


NEEDLE_ASSUMPTIONS = ("the needle is a rectangle in the plane of the tip's path",)
n = quantities(
    """
    along             | m   | tip along the cell's axis, from the tray's surface
    across            | m   | distance of the tip from the cell's axis, to the left
    tilt              | rad | angle of the needle from the cell's axis
    length            | m   | length of the needle
    width             | m   | width of the needle
    tip_right_along   | m   | corner of the needle, tip, right: along the cell's axis
    tip_right_across  | m   | corner of the needle, tip, right: across the cell's axis
    tip_left_along    | m   | corner of the needle, tip, left: along the cell's axis
    tip_left_across   | m   | corner of the needle, tip, left: across the cell's axis
    root_left_along   | m   | corner of the needle, root, left: along the cell's axis
    root_left_across  | m   | corner of the needle, root, left: across the cell's axis
    root_right_along  | m   | corner of the needle, root, right: along the cell's axis
    root_right_across | m   | corner of the needle, root, right: across the cell's axis
    right_surface     | m   | intersection of the needle's right edge with the tray's surface, across
    left_surface      | m   | intersection of the needle's left edge with the tray's surface, across
    axis              | rad | direction of the cell's axis in the machine's frame
    x                 | m   | position in the machine's frame, x
    y                 | m   | position in the machine's frame, y
    """,
    source="derived: needle",
    section="",
)
CELL = Frame("cell")
NEEDLE = Frame("needle", CELL, Z, n.tilt)
O = Point("O")  # noqa: E741
NEEDLE_TIP = Point("tip", O, Vec(CELL, (n.along, n.across, S.Zero)))


def _corner(back: Expr, left: Expr) -> Vec:
    """Return a point of the needle, from its distances behind the tip and to the left of the centre
    line.
    """
    return displacement(O, Point("corner", NEEDLE_TIP, Vec(NEEDLE, (-back, left, S.Zero))), CELL)


def _add_needle(f: Formulas) -> None:
    """Add the corners in the frame of the cell, and the intersections of both edges with the tray's
    surface.
    """
    right, left, back = -n.width / 2, n.width / 2, sp.Dummy("back")
    corners = {
        "tip_right": (S.Zero, right),
        "tip_left": (S.Zero, left),
        "root_left": (n.length, left),
        "root_right": (n.length, right),
    }
    steps = [
        let(n[f"{corner}_{axis}"], _corner(*place)[i])
        for corner, place in corners.items()
        for i, axis in enumerate(("along", "across"))
    ]
    for side, symbol in ((right, n.right_surface), (left, n.left_surface)):
        edge = _corner(back, side)
        (intersection,) = sp.solve(edge[0], back)
        steps.append(let(symbol, sp.simplify(edge[1].subs(back, intersection))))
    f.function("needle", (n.along, n.across, n.tilt, n.length, n.width), *steps, told="corners")


def _add_placed(f: Formulas) -> None:
    """Add a position in the cell's frame along the axes of the machine's frame, from the cell's
    origin.
    """
    machine = Frame("machine")
    at = Vec(Frame("cell", machine, Z, n.axis), (n.along, n.across, S.Zero)).resolved(machine)
    f.function("placed", (n.along, n.across, n.axis), let(n.x, at[0]), let(n.y, at[1]), told="at")


def build_needle_system() -> System:
    """Build the model of needle and tray."""
    title = "Needle of the pick-up"
    f = Formulas(
        "pickup_needle",
        given=n,
        title=title,
        source="derived (geometry)",
        assumptions=NEEDLE_ASSUMPTIONS,
    )
    _add_needle(f)
    _add_placed(f)
    return f.system()


SYSTEMS = (
    build_pickup_system,
    build_needle_system,
)
