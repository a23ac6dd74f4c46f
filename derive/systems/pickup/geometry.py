"""Spline, carrier, arm and tip of the seedling pick-up, from their geometry (yu2023, figs. 2, 4 and 6).

The carrier turns about the sun's centre O; a rigid triangle O-M1-O1 in it carries the intermediate gear and the planet,
whose arm ends in the tip S. Headings are directions from x; frames say how one follows from another. The path of the
tip is a cubic B-spline through value points (Cox-de Boor; Piegl and Tiller, 1997).
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, acos, cos, pi

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Point, Vec, Z, displacement
from ...quantity import Quantity
from . import quantities as q
from .quantities import PickupClaim

WORLD = Frame("frame")
O = Point("O")  # noqa: E741

# the same lines twice: in the carrier, by the angles of the triangle, and in the world, by their named headings
CARRIER = Frame("line O-O1", WORLD, Z, q.phi5)
TO_M1 = Frame("line O-M1", CARRIER, Z, q.beta1)
TO_O1 = Frame("line M1-O1", TO_M1, Z, pi + q.gamma)
PLANET = Frame("planet, x along O1-S", TO_O1, Z, q.phi3)
ARM = Frame("line O1-S", CARRIER, Z, pi - q.phi1)
NAMED = {line: Frame(f"{line.name}, named", WORLD, Z, h) for line, h in ((TO_M1, q.Y1), (TO_O1, q.W1), (ARM, q.Z1))}

M1 = Point("M1", O, Vec(NAMED[TO_M1], (q.a1, S.Zero, S.Zero)))
O1 = Point("O1", M1, Vec(NAMED[TO_O1], (q.a2, S.Zero, S.Zero)))
TIP = Point("S", O1, Vec(NAMED[ARM], (q.L2, S.Zero, S.Zero)))
SPIN = Motion({q.Y1: q.omega, q.W1: q.omega, q.Z1: q.omega + q.phi3_dot})


def along(frame: Frame, length: Expr) -> Vec:
    return Vec(frame, (length, S.Zero, S.Zero))


def heading(frame: Frame) -> Expr:
    return sp.Add(*(angle for _, angle in frame.turns()))


def by_cosine(c: Expr, start: Expr, end: Expr) -> Expr:
    """The angle with the cosine ``c`` that runs from ``start`` to ``end`` as the cosine runs between its extremes."""
    x = sp.Symbol("x")
    ends = {cos(end): end, cos(start): start}
    branches = (sign * acos(x) + 2 * pi * turns for turns in range(3) for sign in (1, -1))
    found = next(b for b in branches if all(b.subs(x, value) == angle for value, angle in ends.items()))
    return found.subs(x, c)


def triangle(f: Formulas) -> None:
    """The rigid triangle of the carrier: closure of O-M1-O1, and once round it."""
    f.defines(q.Y1, heading(TO_M1), PickupClaim.DIRECTION_O_M1)
    f.defines(q.W1, heading(TO_O1), PickupClaim.DIRECTION_M1_O1)
    f.defines(q.Z1, heading(PLANET), PickupClaim.DIRECTION_O1_S)
    exterior = [pi - angle for angle in (q.beta1, q.gamma, q.U1)]
    f.defines(q.U1, sp.solve(sp.Add(*exterior) - 2 * pi, q.U1)[0], PickupClaim.INTERIOR_ANGLE_O1)
    across = (along(CARRIER, q.L1).resolved(TO_M1) - along(TO_O1, q.a2).resolved(TO_M1))[1]
    flat = next(r for r in sp.solve(across, q.beta1) if r.subs(q.a2, 0) == 0)
    f.defines(q.beta1, flat, PickupClaim.INTERIOR_ANGLE_O)
    seen_from_O1 = Frame("line M1-O1 by U1", CARRIER, Z, -q.U1)
    bent = Frame("line O-M1 by gamma", seen_from_O1, Z, pi - q.gamma)
    gap = (along(CARRIER, q.L1) - along(bent, q.a1).resolved(CARRIER)).resolved(seen_from_O1)[1]
    f.defines(q.a1, sp.solve(gap, q.a1)[0], PickupClaim.CENTRE_DISTANCE_1)


def places(f: Formulas) -> None:
    """Coordinates and velocities of M1, O1 and S, each from the point before."""
    known = {O: (S.Zero, S.Zero)}
    speeds = {O: (S.Zero, S.Zero)}
    for base, point, name in ((O, M1, "M1"), (M1, O1, "O1"), (O1, TIP, "S")):
        step = displacement(base, point, WORLD)
        swept = SPIN.derivative(displacement(O, point, WORLD))
        known[point] = (getattr(q, f"x_{name}"), getattr(q, f"y_{name}"))
        speeds[point] = (getattr(q, f"vx_{name}"), getattr(q, f"vy_{name}"))
        for i, axis in enumerate("xy"):
            f.defines(known[point][i], known[base][i] + step[i], PickupClaim.PLACE.of(name, axis))
            f.defines(speeds[point][i], swept[i], PickupClaim.VELOCITY.of(name, axis))


def tip(f: Formulas) -> None:
    """Where the tip stands seen from O, and the angles of the triangle O-O1-S."""
    s = Vec(WORLD, (q.x_S, q.y_S, S.Zero))
    f.defines(q.L3, sp.sqrt(s.dot(s)), PickupClaim.TIP_DISTANCE)
    bars = along(CARRIER, q.L1) + along(ARM, q.L2).resolved(CARRIER)
    square = sp.simplify(bars.dot(bars))
    f.defines(q.L3, sp.sqrt(square), PickupClaim.TIP_DISTANCE_BY_ARM)
    growth = Motion({q.phi1: q.dphi1}).rate(square) / (2 * q.L3)
    f.defines(q.dL3, growth, PickupClaim.TIP_DISTANCE_INCREMENT)

    falling = sp.Lt(q.dL3, 0)
    arm = sp.solve(square.subs(cos(q.phi1), sp.Symbol("c")) - q.L3**2, sp.Symbol("c"))[0]
    away, back = by_cosine(arm, pi, 2 * pi), by_cosine(arm, 2 * pi, 3 * pi)
    f.defines(q.phi1, sp.Piecewise((away, falling), (back, True)), PickupClaim.ARM_ANGLE)
    to_tip = Frame("line O-S", CARRIER, Z, -q.phi6)
    rest = along(to_tip, q.L3).resolved(CARRIER) - along(CARRIER, q.L1)
    at_o = sp.expand_trig(sp.simplify(rest.dot(rest))).subs(cos(q.phi6), sp.Symbol("c"))
    at_o = sp.solve(at_o - q.L2**2, sp.Symbol("c"))[0]
    away, back = by_cosine(at_o, S.Zero, pi), by_cosine(at_o, pi, 2 * pi)
    f.defines(q.phi6, sp.Piecewise((away, falling), (back, True)), PickupClaim.ANGLE_AT_O)

    carrier = Frame("line O-O1 from the tip", Frame("line O-S, named", WORLD, Z, q.phi4), Z, q.phi6)
    f.defines(q.phi5, heading(carrier), PickupClaim.DIRECTION_O_O1)
    f.defines(q.phi6, sp.solve(heading(carrier) - q.phi5, q.phi6)[0], PickupClaim.ANGLE_AT_O_BY_DIRECTIONS)
    by_quadrant(f)
    turned = sp.expand(heading(ARM) - heading(TO_O1))
    f.defines(q.phi3, turned, PickupClaim.PLANET_ANGLE)
    f.defines(q.phi3_dot, Motion({q.phi1: q.omega / q.iZ}).rate(turned), PickupClaim.PLANET_RATE)


def by_quadrant(f: Formulas) -> None:
    """Direction of S by the arctangent of y/x, which repeats every half turn, made whole in each quadrant."""
    x, y = sp.symbols("x y", positive=True)
    plain = sp.atan(q.y_S / q.x_S)
    jumps: dict[tuple[int, int], tuple[Expr, sp.And]] = {}
    for i, j in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        jump = sp.atan2(j * y, i * x) - sp.atan(j * y / (i * x))
        where = sp.And(q.x_S < 0 if i < 0 else q.x_S > 0, q.y_S < 0 if j < 0 else q.y_S >= 0)
        if jump != 0:
            jumps[i, j] = (jump, where)
    third, *others = jumps.values()
    f.defines(q.phi4, plain + sp.Piecewise(third, *others, (S.Zero, True)), PickupClaim.TIP_DIRECTION)
    f.defines(q.phi4, plain + third[0], PickupClaim.TIP_DIRECTION_THIRD_QUADRANT, where=third[1])
    elsewhere = plain + sp.Piecewise(*others, (S.Zero, True))
    f.defines(q.phi4, elsewhere, PickupClaim.TIP_DIRECTION_OTHER_QUADRANTS, where=sp.Not(third[1]))


def extremes(f: Formulas) -> None:
    """Farthest and nearest tip over the turn of the arm that begins stretched, for L2 > L1 > 0."""
    short, more = sp.symbols("short more", positive=True)
    back = {short: q.L1, more: q.L2 - q.L1}
    bars = along(CARRIER, q.L1) + along(ARM, q.L2).resolved(CARRIER)
    square = sp.simplify(bars.dot(bars)).subs(q.L2, q.L1 + more).subs(q.L1, short)
    still = sorted(sp.solveset(square.diff(q.phi1), q.phi1, sp.Interval.Ropen(pi, 3 * pi)))
    values = {phi1: sp.sqrt(sp.factor(square.subs(q.phi1, phi1))) for phi1 in still}
    far = max(still, key=lambda phi1: values[phi1].subs({short: 1, more: 1}))
    near = min(still, key=lambda phi1: values[phi1].subs({short: 1, more: 1}))
    signs = {short: 1, more: 1}
    names = ((far, "farthest", (q.phi1_far, q.phi6_far, q.L3_max)),
             (near, "nearest", (q.phi1_near, q.phi6_near, q.L3_min)))  # fmt: skip
    for phi1, word, (angle, at_o, length) in names:
        tip = (along(CARRIER, short) + along(ARM, short + more).resolved(CARRIER)).components
        x, y = (c.subs(q.phi1, phi1) for c in tip[:2])
        f.defines(angle, phi1, PickupClaim.EXTREME_ARM_ANGLE.of(word))
        f.defines(
            at_o, sp.Mod(-sp.atan2(y.subs(signs), x.subs(signs)), 2 * pi), PickupClaim.EXTREME_ANGLE_AT_O.of(word)
        )
        f.defines(length, sp.expand(values[phi1].subs(back)), PickupClaim.EXTREME_DISTANCE.of(word))
    lengths = {q.L3_max: values[far].subs(back), q.L3_min: values[near].subs(back)}
    found = sp.solve([length - value for length, value in lengths.items()], [q.L1, q.L2])
    f.defines(q.L1, found[q.L1], PickupClaim.BAR_L1)
    f.defines(q.L2, found[q.L2], PickupClaim.BAR_L2)


def tray(f: Formulas) -> None:
    """The needle lies along the axis of a cell when it picks, and upright when it pushes."""
    elevation = sp.Symbol("elevation", positive=True)
    surface = Frame("surface of the tray", WORLD, Z, -q.theta_box)
    needle = along(Frame("needle", WORLD, Z, elevation), S.One).resolved(WORLD)
    flush = sp.simplify(needle.dot(along(surface, S.One).resolved(WORLD)))
    pick = next(root for root in sp.solve(flush, elevation) if root.subs(q.theta_box, 0) == pi / 2)
    f.defines(q.swing, sp.expand(pi / 2 - pick), PickupClaim.NEEDLE_TURN)


def state_geometry(f: Formulas) -> None:
    """Claims about carrier, arm and tip."""
    for part in (triangle, places, tip, extremes, tray):
        part(f)


DEGREE = 3
KNOTS = {-2: q.u_im2, -1: q.u_im1, 0: q.u_i, 1: q.u_ip1, 2: q.u_ip2, 3: q.u_ip3}
CONTROLS = {-1: q.d_im1, 0: q.d_i, 1: q.d_ip1, 2: q.d_ip2}
INTERVALS = {-2: q.Delta_im2, -1: q.Delta_im1, 0: q.Delta_i, 1: q.Delta_ip1}
PEAK = (DEGREE + 1) // 2
"""Intervals from where a basis function begins to where it peaks."""


def basis(first: int, degree: int) -> Expr:
    """The basis function that begins at knot ``first``, in the interval from knot 0 to knot 1."""
    if degree == 0:
        return S.One if first == 0 else S.Zero
    last = first + degree + 1
    rising, falling = basis(first, degree - 1), basis(first + 1, degree - 1)
    total = S.Zero
    if rising != 0:
        total += rising * (q.u - KNOTS[first]) / (KNOTS[last - 1] - KNOTS[first])
    if falling != 0:
        total += falling * (KNOTS[last] - q.u) / (KNOTS[last] - KNOTS[first + 1])
    return total


def by_intervals(expr: Expr) -> Expr:
    """An expression in knots, written in the lengths of the intervals between them."""
    places: dict[Quantity, Expr] = {KNOTS[0]: S.Zero}
    for index in (0, 1):
        places[KNOTS[index + 1]] = places[KNOTS[index]] + INTERVALS[index]
    for index in (-1, -2):
        places[KNOTS[index]] = places[KNOTS[index + 1]] - INTERVALS[index]
    return expr.xreplace(places)


def weight(index: int) -> Expr:
    """What the control point ``index`` contributes at knot 0."""
    return sp.factor(by_intervals(basis(index - PEAK, DEGREE).subs(q.u, q.u_i)))


def support() -> Expr:
    """Intervals that a basis function of degree k spans: one more than those of the degree below, which it joins."""
    spans = sp.Function("spans")
    degree = sp.Symbol("degree", integer=True)
    return sp.rsolve(spans(degree) - spans(degree - 1) - 1, spans(degree), {spans(0): 1}).subs(degree, q.k)


def state_spline(f: Formulas) -> None:
    """Claims about the spline."""
    scale = INTERVALS[-1] + INTERVALS[0]
    rows = {index: sp.factor(weight(index) * scale) for index in (-1, 0, 1)}
    overlap = support().subs(q.k, DEGREE) - 1
    f.defines(q.Delta_i, KNOTS[1] - KNOTS[0], PickupClaim.KNOT_INTERVAL, named=True)
    f.defines(q.Delta_im1, KNOTS[0] - KNOTS[-1], PickupClaim.KNOT_INTERVAL_BEFORE)
    f.defines(q.Delta_im2, KNOTS[-1] - KNOTS[-2], PickupClaim.SECOND_KNOT_INTERVAL_BEFORE)
    f.defines(q.Delta_ip1, KNOTS[2] - KNOTS[1], PickupClaim.KNOT_INTERVAL_AFTER)
    f.defines(q.i_last, sp.expand(q.n + support()), PickupClaim.LAST_KNOT)
    f.defines(q.i_first, overlap, PickupClaim.FIRST_CURVE_KNOT)
    f.defines(q.i_end, q.n + support().subs(q.k, DEGREE) - overlap, PickupClaim.LAST_CURVE_KNOT)
    f.defines(q.p_u, sp.Add(*(basis(j - PEAK, DEGREE) * d for j, d in CONTROLS.items())), PickupClaim.CURVE_POINT)
    f.defines(q.q_i, sp.Add(*(weight(j) * CONTROLS[j] for j in rows)), PickupClaim.VALUE_POINT)
    f.defines(q.a_i, rows[-1], PickupClaim.CONTROL_BEFORE)
    f.defines(q.b_i, sp.apart(rows[0], q.Delta_im2), PickupClaim.CONTROL_AT_KNOT)
    f.defines(q.c_i, rows[1], PickupClaim.CONTROL_AFTER)
    f.defines(q.e_i, scale * q.q_i, PickupClaim.KNOT_ROW_RIGHT_SIDE)
    coefficients = zip((q.a_i, q.b_i, q.c_i), (-1, 0, 1), strict=True)
    f.holds(PickupClaim.KNOT_ROW, sp.Add(*(c * CONTROLS[j] for c, j in coefficients)) - q.e_i)
