"""Spline, carrier, arm, gear train and teeth of the seedling pick-up, from their geometry (yu2023,
figs. 2, 4 and 6).

The carrier turns about the sun's centre O; a rigid triangle O-M1-O1 in it carries the intermediate
gear and the planet, whose arm ends in the tip S. Headings are directions from x; frames say how one
follows from another. The path of the tip is a cubic B-spline through value points (Cox-de Boor;
Piegl and Tiller, 1997). Pitch curves are described along the two centre lines, whose frames turn
with the carrier. At a contact a non-circular gear meshes like the circular gear of its radius of
curvature (`derive.mechanics.gearing.teeth`).
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr, S, acos, cos, pi, sin

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Point, Vec, Y, Z, displacement
from ...mechanics.gearing.teeth import TRANSVERSE, base_pitch, path_of_action
from ...quantity import Quantity
from . import quantities as q

WORLD = Frame("frame")
O = Point("O")  # noqa: E741

# the same lines twice: in the carrier, by the angles of the triangle, and in the world, by their
# named headings
CARRIER = Frame("line O-O1", WORLD, Z, q.phi5)
TO_M1 = Frame("line O-M1", CARRIER, Z, q.beta1)
TO_O1 = Frame("line M1-O1", TO_M1, Z, pi + q.gamma)
PLANET = Frame("planet, x along O1-S", TO_O1, Z, q.phi3)
ARM = Frame("line O1-S", CARRIER, Z, pi - q.phi1)
NAMED = {
    line: Frame(f"{line.name}, named", WORLD, Z, h)
    for line, h in ((TO_M1, q.Y1), (TO_O1, q.W1), (ARM, q.Z1))
}

M1 = Point("M1", O, Vec(NAMED[TO_M1], (q.a1, S.Zero, S.Zero)))
O1 = Point("O1", M1, Vec(NAMED[TO_O1], (q.a2, S.Zero, S.Zero)))
TIP = Point("S", O1, Vec(NAMED[ARM], (q.L2, S.Zero, S.Zero)))
SPIN = Motion({q.Y1: q.omega, q.W1: q.omega, q.Z1: q.omega + q.phi3_dot})


def axial_vector(frame: Frame, length: Expr) -> Vec:
    """Return a vector along the x axis of a frame."""
    return Vec(frame, (length, S.Zero, S.Zero))


def frame_heading(frame: Frame) -> Expr:
    """Return the angle of a frame in the world [rad]."""
    return sp.Add(*(angle for _, angle in frame.turns()))


def by_cosine(c: Expr, start: Expr, end: Expr) -> Expr:
    """Return the angle with the cosine ``c`` that runs from ``start`` to ``end`` while the cosine
    is monotonic.
    """
    x = sp.Symbol("x")
    ends = {cos(end): end, cos(start): start}
    branches = (sign * acos(x) + 2 * pi * turns for turns in range(3) for sign in (1, -1))
    branch = next(
        b for b in branches if all(b.subs(x, value) == angle for value, angle in ends.items())
    )
    return branch.subs(x, c)


def _add_triangle(f: Formulas) -> None:
    """Add the rigid triangle O-M1-O1 of the carrier: its closure, and the sum of its exterior
    angles.
    """
    f.defines(q.Y1, frame_heading(TO_M1), "direction of O-M1")
    f.defines(q.W1, frame_heading(TO_O1), "direction of M1-O1")
    f.defines(q.Z1, frame_heading(PLANET), "direction of O1-S")
    exterior = [pi - angle for angle in (q.beta1, q.gamma, q.U1)]
    f.defines(q.U1, sp.solve(sp.Add(*exterior) - 2 * pi, q.U1)[0], "interior angle at O1")
    across = (
        axial_vector(CARRIER, q.L1).resolved(TO_M1) - axial_vector(TO_O1, q.a2).resolved(TO_M1)
    )[1]
    flat = next(r for r in sp.solve(across, q.beta1) if r.subs(q.a2, 0) == 0)
    f.defines(q.beta1, flat, "interior angle at O")
    seen_from_O1 = Frame("line M1-O1 by U1", CARRIER, Z, -q.U1)
    bent = Frame("line O-M1 by gamma", seen_from_O1, Z, pi - q.gamma)
    gap = (axial_vector(CARRIER, q.L1) - axial_vector(bent, q.a1).resolved(CARRIER)).resolved(
        seen_from_O1
    )[1]
    f.defines(q.a1, sp.solve(gap, q.a1)[0], "centre distance of stage 1")


def _add_points(f: Formulas) -> None:
    """Add coordinates and velocities of M1, O1 and S, each from the previous point."""
    coordinates = {O: (S.Zero, S.Zero)}
    speeds = {O: (S.Zero, S.Zero)}
    for base, point, name in ((O, M1, "M1"), (M1, O1, "O1"), (O1, TIP, "S")):
        step = displacement(base, point, WORLD)
        swept = SPIN.derivative(displacement(O, point, WORLD))
        coordinates[point] = (getattr(q, f"x_{name}"), getattr(q, f"y_{name}"))
        speeds[point] = (getattr(q, f"vx_{name}"), getattr(q, f"vy_{name}"))
        for i, axis in enumerate("xy"):
            f.defines(
                coordinates[point][i],
                coordinates[base][i] + step[i],
                f"place of {name}, {axis}",
            )
            f.defines(speeds[point][i], swept[i], f"velocity of {name}, {axis}")


def _add_tip(f: Formulas) -> None:
    """Add the polar coordinates of the tip about O, and the angles of the triangle O-O1-S."""
    s = Vec(WORLD, (q.x_S, q.y_S, S.Zero))
    f.defines(q.L3, sp.sqrt(s.dot(s)), "distance of the tip")
    bars = axial_vector(CARRIER, q.L1) + axial_vector(ARM, q.L2).resolved(CARRIER)
    square = sp.simplify(bars.dot(bars))
    f.defines(q.L3, sp.sqrt(square), "distance of the tip from the arm's angle")
    growth = Motion({q.phi1: q.dphi1}).rate(square) / (2 * q.L3)
    f.defines(q.dL3, growth, "increment of the tip's distance")

    falling = sp.Lt(q.dL3, 0)
    arm = sp.solve(square.subs(cos(q.phi1), sp.Symbol("c")) - q.L3**2, sp.Symbol("c"))[0]
    away, back = by_cosine(arm, pi, 2 * pi), by_cosine(arm, 2 * pi, 3 * pi)
    f.defines(
        q.phi1, sp.Piecewise((away, falling), (back, True)), "arm's angle from the tip's distance"
    )
    to_tip = Frame("line O-S", CARRIER, Z, -q.phi6)
    rest = axial_vector(to_tip, q.L3).resolved(CARRIER) - axial_vector(CARRIER, q.L1)
    at_o = sp.expand_trig(sp.simplify(rest.dot(rest))).subs(cos(q.phi6), sp.Symbol("c"))
    at_o = sp.solve(at_o - q.L2**2, sp.Symbol("c"))[0]
    away, back = by_cosine(at_o, S.Zero, pi), by_cosine(at_o, pi, 2 * pi)
    f.defines(
        q.phi6, sp.Piecewise((away, falling), (back, True)), "angle at O from the tip's distance"
    )

    carrier = Frame("line O-O1 from the tip", Frame("line O-S, named", WORLD, Z, q.phi4), Z, q.phi6)
    f.defines(q.phi5, frame_heading(carrier), "direction of O-O1 from the tip's")
    f.defines(
        q.phi6,
        sp.solve(frame_heading(carrier) - q.phi5, q.phi6)[0],
        "angle at O from the directions",
    )
    _add_tip_direction(f)
    turned = sp.expand(frame_heading(ARM) - frame_heading(TO_O1))
    f.defines(q.phi3, turned, "planet's angle from the arm's")
    f.defines(
        q.phi3_dot, Motion({q.phi1: q.omega / q.iZ}).rate(turned), "rate of the planet's angle"
    )


def _add_tip_direction(f: Formulas) -> None:
    """Add the direction of S: the arctangent of y/x, which repeats every half turn, corrected in
    each quadrant.
    """
    x, y = sp.symbols("x y", positive=True)
    plain = sp.atan(q.y_S / q.x_S)
    jumps: dict[tuple[int, int], tuple[Expr, sp.And]] = {}
    for i, j in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        jump = sp.atan2(j * y, i * x) - sp.atan(j * y / (i * x))
        where = sp.And(q.x_S < 0 if i < 0 else q.x_S > 0, q.y_S < 0 if j < 0 else q.y_S >= 0)
        if jump != 0:
            jumps[i, j] = (jump, where)
    third, *further = jumps.values()
    f.defines(q.phi4, plain + sp.Piecewise(third, *further, (S.Zero, True)), "direction of the tip")
    f.defines(q.phi4, plain + third[0], "direction of the tip, third quadrant", where=third[1])
    elsewhere = plain + sp.Piecewise(*further, (S.Zero, True))
    f.defines(q.phi4, elsewhere, "direction of the tip, other quadrants", where=sp.Not(third[1]))


def _add_extremes(f: Formulas) -> None:
    """Add the farthest and nearest tip over the arm's revolution from the stretched position, for
    L2 > L1 > 0.
    """
    short, more = sp.symbols("short more", positive=True)
    back = {short: q.L1, more: q.L2 - q.L1}
    bars = axial_vector(CARRIER, q.L1) + axial_vector(ARM, q.L2).resolved(CARRIER)
    square = sp.simplify(bars.dot(bars)).subs(q.L2, q.L1 + more).subs(q.L1, short)
    still = sorted(sp.solveset(square.diff(q.phi1), q.phi1, sp.Interval.Ropen(pi, 3 * pi)))
    values = {phi1: sp.sqrt(sp.factor(square.subs(q.phi1, phi1))) for phi1 in still}
    farthest = max(still, key=lambda phi1: values[phi1].subs({short: 1, more: 1}))
    nearest = min(still, key=lambda phi1: values[phi1].subs({short: 1, more: 1}))
    signs = {short: 1, more: 1}
    names = (
        (farthest, "farthest", (q.phi1_far, q.phi6_far, q.L3_max)),
        (nearest, "nearest", (q.phi1_near, q.phi6_near, q.L3_min)),
    )
    for phi1, word, (angle, at_o, length) in names:
        tip = (
            axial_vector(CARRIER, short) + axial_vector(ARM, short + more).resolved(CARRIER)
        ).components
        x, y = (c.subs(q.phi1, phi1) for c in tip[:2])
        f.defines(angle, phi1, f"arm's angle, tip {word}")
        f.defines(
            at_o,
            sp.Mod(-sp.atan2(y.subs(signs), x.subs(signs)), 2 * pi),
            f"angle at O, tip {word}",
        )
        f.defines(length, sp.expand(values[phi1].subs(back)), f"distance, tip {word}")
    lengths = {q.L3_max: values[farthest].subs(back), q.L3_min: values[nearest].subs(back)}
    bars_by_extremes = sp.solve([length - value for length, value in lengths.items()], [q.L1, q.L2])
    f.defines(q.L1, bars_by_extremes[q.L1], "bar L1 from the extremes")
    f.defines(q.L2, bars_by_extremes[q.L2], "bar L2 from the extremes")


def _add_tray(f: Formulas) -> None:
    """Add the needle's rotation: it is parallel to a cell's axis when it picks, and upright when it
    pushes.
    """
    elevation = sp.Symbol("elevation", positive=True)
    surface = Frame("surface of the tray", WORLD, Z, -q.theta_box)
    needle = axial_vector(Frame("needle", WORLD, Z, elevation), S.One).resolved(WORLD)
    flush = sp.simplify(needle.dot(axial_vector(surface, S.One).resolved(WORLD)))
    pick = next(root for root in sp.solve(flush, elevation) if root.subs(q.theta_box, 0) == pi / 2)
    f.defines(q.swing, sp.expand(pi / 2 - pick), "turn of the needle from pick to push")


def add_geometry(f: Formulas) -> None:
    """Add the equations of carrier, arm and tip."""
    for add_equations in (_add_triangle, _add_points, _add_tip, _add_extremes, _add_tray):
        add_equations(f)


DEGREE = 3
KNOTS = {-2: q.u_im2, -1: q.u_im1, 0: q.u_i, 1: q.u_ip1, 2: q.u_ip2, 3: q.u_ip3}
CONTROLS = {-1: q.d_im1, 0: q.d_i, 1: q.d_ip1, 2: q.d_ip2}
INTERVALS = {-2: q.Delta_im2, -1: q.Delta_im1, 0: q.Delta_i, 1: q.Delta_ip1}
PEAK = (DEGREE + 1) // 2
"""Number of intervals from the beginning of a basis function to its peak."""


def basis_function(first: int, degree: int) -> Expr:
    """Return the basis function that begins at knot ``first``, in the interval from knot 0 to knot
    1.
    """
    if degree == 0:
        return S.One if first == 0 else S.Zero
    last = first + degree + 1
    rising, falling = basis_function(first, degree - 1), basis_function(first + 1, degree - 1)
    total = S.Zero
    if rising != 0:
        total += rising * (q.u - KNOTS[first]) / (KNOTS[last - 1] - KNOTS[first])
    if falling != 0:
        total += falling * (KNOTS[last] - q.u) / (KNOTS[last] - KNOTS[first + 1])
    return total


def by_intervals(expr: Expr) -> Expr:
    """Return an expression in knots in terms of the lengths of the intervals between them."""
    positions: dict[Quantity, Expr] = {KNOTS[0]: S.Zero}
    for index in (0, 1):
        positions[KNOTS[index + 1]] = positions[KNOTS[index]] + INTERVALS[index]
    for index in (-1, -2):
        positions[KNOTS[index]] = positions[KNOTS[index + 1]] - INTERVALS[index]
    return expr.xreplace(positions)


def control_weight(index: int) -> Expr:
    """Return the weight of the control point ``index`` at knot 0."""
    return sp.factor(by_intervals(basis_function(index - PEAK, DEGREE).subs(q.u, q.u_i)))


def support_intervals() -> Expr:
    """Return the number of intervals that a basis function of degree k spans: one more than for
    degree k - 1.
    """
    spans = sp.Function("spans")
    degree = sp.Symbol("degree", integer=True)
    return sp.rsolve(spans(degree) - spans(degree - 1) - 1, spans(degree), {spans(0): 1}).subs(
        degree, q.k
    )


def add_spline(f: Formulas) -> None:
    """Add the equations of the spline."""
    scale = INTERVALS[-1] + INTERVALS[0]
    rows = {index: sp.factor(control_weight(index) * scale) for index in (-1, 0, 1)}
    overlap = support_intervals().subs(q.k, DEGREE) - 1
    f.defines(q.Delta_i, KNOTS[1] - KNOTS[0], "length of a knot interval", named=True)
    f.defines(q.Delta_im1, KNOTS[0] - KNOTS[-1], "length of the knot interval before")
    f.defines(q.Delta_im2, KNOTS[-1] - KNOTS[-2], "length of the second knot interval before")
    f.defines(q.Delta_ip1, KNOTS[2] - KNOTS[1], "length of the knot interval after")
    f.defines(q.i_last, sp.expand(q.n + support_intervals()), "index of the last knot")
    f.defines(q.i_first, overlap, "index of the knot where the curve begins")
    f.defines(
        q.i_end,
        q.n + support_intervals().subs(q.k, DEGREE) - overlap,
        "index of the knot where the curve ends",
    )
    f.defines(
        q.p_u,
        sp.Add(*(basis_function(j - PEAK, DEGREE) * d for j, d in CONTROLS.items())),
        "point of the curve",
    )
    f.defines(
        q.q_i, sp.Add(*(control_weight(j) * CONTROLS[j] for j in rows)), "value point at a knot"
    )
    f.defines(q.a_i, rows[-1], "coefficient of the control point before")
    f.defines(q.b_i, sp.apart(rows[0], q.Delta_im2), "coefficient of the control point at the knot")
    f.defines(q.c_i, rows[1], "coefficient of the control point after")
    f.defines(q.e_i, scale * q.q_i, "right side of the row of a knot")
    coefficients = zip((q.a_i, q.b_i, q.c_i), (-1, 0, 1), strict=True)
    f.holds("row of a knot", sp.Add(*(c * CONTROLS[j] for c, j in coefficients)) - q.e_i)


SUN = Frame("sun, x along O-M1 at phi5 = 0", WORLD, Z, q.beta1)
BACK = Frame("line M1-O", TO_M1, Z, pi)
MIDDLE = Frame("intermediate gear", BACK, Z, q.phi2)
TURNING = Motion({q.phi5: q.dphi5, q.phi2: q.dphi2, q.phi1: q.dphi1})


def relative_rotation(frame: Frame, motion: Motion = TURNING) -> Expr:
    """Return the increment of a frame's angle relative to the carrier."""
    return motion.spin(frame)[2] - motion.spin(CARRIER)[2]


def slip_on_sun() -> Expr:
    """Return the speed at which the intermediate gear would slip on the stationary sun, at their
    contact.
    """
    axis = TURNING.derivative(axial_vector(TO_M1, q.a1))
    contact = TURNING.spin(MIDDLE).resolved(TO_M1).cross(axial_vector(TO_M1, -q.R2))
    return (axis + contact)[1]


def helical_slip(motion: Motion) -> Expr:
    """Return the speed at which the two equal helical gears would slip on each other, relative to
    the carrier.
    """
    radius = q.a2 / 2
    return sp.expand(
        relative_rotation(MIDDLE, motion) * radius - relative_rotation(ARM, motion) * (-radius)
    )


def _add_ratios(f: Formulas) -> None:
    """Add ratios and pitch radii; the ratio of an external pair is positive."""
    stage1 = -relative_rotation(WORLD) / relative_rotation(MIDDLE)
    total = relative_rotation(WORLD) / relative_rotation(ARM)
    helical = sp.solve(helical_slip(TURNING), q.dphi2)[0]
    carrier = sp.solve(stage1 - q.i1, q.dphi5)[0]
    through = total.subs(q.dphi1, sp.solve(helical_slip(TURNING), q.dphi1)[0]).subs(
        q.dphi5, carrier
    )
    at_dwell = sp.solve(helical_slip(Motion({**TURNING.rates, q.phi2: S.Zero})), q.dphi1)[0]
    radius = sp.solve(slip_on_sun().subs(q.dphi5, carrier), q.R2)[0]
    gap = (
        axial_vector(TO_M1, q.a1)
        + axial_vector(BACK, q.R2).resolved(TO_M1)
        - axial_vector(TO_M1, q.R1)
    )
    f.defines(q.dphi2, helical, "turn of the intermediate gear")
    f.defines(q.i1, stage1, "ratio of stage 1")
    f.defines(q.iZ, total, "total ratio", named=True)
    f.defines(q.iZ, sp.cancel(through), "total ratio through both stages")
    f.defines(
        q.g_locked,
        (1 / total).subs(q.dphi1, at_dwell),
        "reciprocal of the total ratio in the dwell",
    )
    f.defines(q.R2, sp.factor(radius), "pitch radius of the intermediate gear")
    f.defines(q.R1, sp.solve(gap[0], q.R1)[0], "pitch radius of the sun")


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
    """Add pitch curves and curvatures; contacts run counter-clockwise on the sun, clockwise on the
    other gear.
    """
    sun, middle = contact_points()
    rolling = Motion({q.phi5: S.One, q.phi2: q.R1 / q.R2, q.R1: q.dR1, q.R2: -q.dR1, q.dR1: q.ddR1})
    f.defines(q.x1, sun[0], "pitch curve of the sun, x")
    f.defines(q.y1, sun[1], "pitch curve of the sun, y")
    f.defines(q.x2, middle[0], "pitch curve of the intermediate gear, x")
    f.defines(q.y2, middle[1], "pitch curve of the intermediate gear, y")
    f.defines(q.rho1, curvature_radius(sun, rolling), "radius of curvature of the sun")
    f.defines(
        q.rho2,
        -curvature_radius(middle, rolling),
        "radius of curvature of the intermediate gear",
    )


def add_train(f: Formulas) -> None:
    """Add the equations of the gear train."""
    _add_ratios(f)
    _add_curves(f)


def helical_pitch() -> Expr:
    """Return the transverse pitch: the normal pitch, pi times the module, projected along the
    helix.
    """
    pitch = sp.Symbol("pitch")
    normal = Frame("normal section", TRANSVERSE, Y, q.beta)
    across = Vec(TRANSVERSE, (pitch, S.Zero, S.Zero)).resolved(normal)[0]
    return sp.solve(across - pi * q.m_n, pitch)[0]


def pitch_radius(teeth: Quantity) -> Expr:
    """Return the radius with a circumference of the teeth's pitches."""
    return teeth * helical_pitch() / (2 * pi)


def transverse_pressure_angle() -> Expr:
    """Return the transverse pressure angle, from the tooth normal in the normal section."""
    normal = Vec(
        Frame("normal section", TRANSVERSE, Y, q.beta), (cos(q.alpha_n), sin(q.alpha_n), S.Zero)
    )
    tangential, radial, _ = normal.resolved(TRANSVERSE).components
    return sp.atan(radial / tangential)


def helical_contact_ratio() -> Expr:
    """Return the transverse contact ratio plus the overlap ratio, of teeth without profile
    shift.
    """
    angle, addendum = q.alpha_t, q.ha_n * q.m_n
    path = sp.Add(*(path_of_action(pitch_radius(z), addendum, angle) for z in (q.z_1, q.z_2)))
    lead = q.B * sp.tan(q.beta)
    return path / base_pitch(helical_pitch(), angle) + lead / helical_pitch()


def add_teeth(f: Formulas) -> None:
    """Add the equations of the teeth; of the slopes of the contact ratio only the signs that are
    proved.
    """
    paths = [
        path_of_action(rho, ha * q.m, q.alpha0) for rho, ha in ((q.rho1, q.ha1), (q.rho2, q.ha2))
    ]
    ratio = (q.g1 + q.g2) / base_pitch(pi * q.m, q.alpha0)
    full_ratio = ratio.subs({q.g1: paths[0], q.g2: paths[1]})
    f.defines(
        q.a2,
        sp.factor(pitch_radius(q.z_1) + pitch_radius(q.z_2)),
        "centre distance of the helical pair",
    )
    f.defines(
        q.alpha_t, transverse_pressure_angle(), "transverse pressure angle of the helical pair"
    )
    f.defines(q.epsilon_h, helical_contact_ratio(), "contact ratio of the helical pair")
    f.defines(q.epsilon, ratio, "contact ratio of the non-circular pair")
    f.defines(q.g1, paths[0], "path of action to the sun's addendum")
    f.defines(q.g2, paths[1], "path of action to the intermediate gear's addendum")
    growth = full_ratio.diff(q.ha1) + full_ratio.diff(q.ha2)
    f.defines(q.epsilon_ha, growth, "slope of the contact ratio per addendum coefficient")
    f.defines(q.epsilon_m, full_ratio.diff(q.m), "slope of the contact ratio per module")
    if grows_with_addendum():
        f.holds("contact ratio grows with the addendum", q.epsilon_ha, ">")
    if falls_with_module():
        f.holds("contact ratio falls with the module", q.epsilon_m, "<")


def grows_with_addendum() -> bool:
    """Whether each path of action of a convex pitch curve grows with the addendum coefficient."""
    path, _, h = _path_of_positives()
    return bool(path.diff(h).is_positive)


def falls_with_module() -> bool:
    """Whether each path of action per module falls with the module: a concave path that begins at
    zero.
    """
    path, module, _ = _path_of_positives()
    bend = sp.factor(sp.simplify(path.diff(module, 2)))
    return bool(path.subs(module, 0) == 0 and bend.is_negative)


@cache
def _path_of_positives() -> tuple[Expr, sp.Symbol, sp.Symbol]:
    """Return path of action, module and addendum coefficient in positive symbols (slope: tangent of
    the angle).
    """
    module, coefficient, radius, slope = sp.symbols(
        "module coefficient radius slope", positive=True
    )
    angle = sp.Symbol("angle", positive=True)
    hypotenuse = sp.sqrt(1 + slope**2)
    path = path_of_action(radius, coefficient * module, angle)
    return (
        path.subs({sin(angle): slope / hypotenuse, cos(angle): 1 / hypotenuse}),
        module,
        coefficient,
    )
