"""Teeth cut by a rack on a pitch curve: the envelopes of its flanks, tip radii and straight lines.

The rack's pitch line rolls on the pitch curve, so that the pitch point is the instant centre: the
normal to the rack passes through the pitch point at the point that is cut (Litvin, Fuentes-Aznar,
Gonzalez-Perez, Hayasaka: Noncircular Gears, 2009; basic rack with a tip radius: ISO 53). The
parameter is the arc length s of the pitch curve, anticlockwise.
"""

from __future__ import annotations

from functools import partial

import sympy as sp
from sympy import Expr, S, pi

from ..mechanics.frames import Frame, Motion, Vec, X, Z, unit
from ..model import ClosedForm, Let, System
from ..quantity import Quantity, Vector
from . import pitch_curve
from .pitch_curve import a
from .teeth import base_pitch, path_by_curvature

ASSUMPTIONS = (
    "rigid teeth that are exact envelopes of a rack in the transverse section",
    "the rack's straight flanks end in a tip radius that is tangent to its tip line",
)
_rack = partial(Quantity, source="derived: rack teeth")

polar = _rack("polar", "rad", "polar angle on the pitch curve, in the direction of the curve")
radius = _rack("radius", "m", "pitch radius at that angle")
slope = _rack("slope", "m", "slope of the pitch radius, per polar angle")
bend = _rack("bend", "m", "second derivative of the pitch radius, per polar angle")
POLAR = Vector("polar_place", (polar, radius, slope, bend))
sense = _rack(
    "sense", "1", "+1 where the curve's polar angle runs anticlockwise, -1 where clockwise"
)
x = _rack("x", "m", "pitch point, x")
y = _rack("y", "m", "pitch point, y")
tx = _rack("tx", "1", "unit tangent of the pitch curve, x, anticlockwise")
ty = _rack("ty", "1", "unit tangent of the pitch curve, y, anticlockwise")
kappa = _rack("kappa", "1/m", "curvature of the pitch curve, positive where convex")
PLACE = Vector("place", (x, y, tx, ty, kappa))
speed = _rack("speed", "m", "arc length of the pitch curve per polar angle")

s = _rack("s", "m", "arc length of the pitch curve at the point that the rack touches")
xi = _rack(
    "xi",
    "m",
    "position of the flank: arc length of the pitch curve at which the flank crosses the rack's "
    "pitch line",
)
side = _rack(
    "side", "1", "+1 for the flank at the end of a tooth, -1 for the flank at its beginning"
)
alpha = _rack("alpha", "rad", "pressure angle")
height = _rack("height", "m", "height of an equidistant line over the pitch line, outwards")
middle = _rack("middle", "m", "centre of the rack's tip radius along its pitch line")
depth = _rack("depth", "m", "depth of the centre of the rack's tip radius under its pitch line")
rho = _rack("rho", "m", "tip radius of the rack")
away = _rack("away", "m", "distance of the centre of the tip radius from the pitch point")

px = _rack("px", "m", "point of the outline, x")
py = _rack("py", "m", "point of the outline, y")
ex = _rack("ex", "1", "unit tangent of the outline, x")
ey = _rack("ey", "1", "unit tangent of the outline, y")
rate = _rack(
    "rate",
    "1",
    "length of the outline per arc length of the pitch curve; negative where the outline has "
    "reversed",
)
turning = _rack(
    "turning", "1/m", "rotation of the outline's tangent per arc length of the pitch curve"
)
POINT = Vector("point", (px, py, ex, ey, rate, turning))

tau = sp.Symbol("tau")
WORLD = Frame("gear")
TANGENT = Frame("tangent of the pitch curve", WORLD, Z, tau)
ROLLING = Motion({s: S.One, tau: kappa, x: sp.cos(tau), y: sp.sin(tau)})
"""Rates of the quantities at the pitch point per arc length as the rack rolls."""


def _inward(forward: Expr, inward: Expr) -> Vec:
    """Return a vector from its components along the pitch curve's tangent and to the left of it,
    into the gear.
    """
    return Vec(TANGENT, (forward, inward, S.Zero))


def _envelope(
    name: str,
    inputs: tuple[Quantity | Vector, ...],
    offset: Vec,
    tangent: Vec,
    lets: tuple[Let, ...] = (),
) -> ClosedForm:
    """Build the point, tangent and rates of an outline that is cut at ``offset`` from the pitch
    point.

    ``tangent`` is the unit tangent of the outline; ``lets`` define quantities that vary with the
    arc length and that both vectors contain as symbols.
    """
    motion = Motion(dict(ROLLING.rates))
    motion.rates |= {let.symbol: motion.rate(let.expr).subs(let.expr, let.symbol) for let in lets}
    drift = motion.derivative(offset) + unit(TANGENT, X)
    point, direction = offset.resolved(WORLD), tangent.resolved(WORLD)
    values = (
        x + point[0],
        y + point[1],
        direction[0],
        direction[1],
        drift.dot(tangent),
        tangent.cross(motion.derivative(tangent))[2],
    )
    components = {sp.cos(tau): tx, sp.sin(tau): ty}
    expressions = (_simplify_if_shorter(value, lets).subs(components) for value in values)
    steps = (
        *lets,
        *(Let(q, expr, f"derived: {name}") for q, expr in zip(POINT, expressions, strict=True)),
    )
    return ClosedForm(name, inputs, steps, POINT)


def _simplify_if_shorter(expr: Expr, lets: tuple[Let, ...] = ()) -> Expr:
    """Return the expression with the squares of sides, sines and distances replaced, if that is
    shorter.
    """
    numerator, denominator = sp.fraction(sp.together(expr))
    squares = [(side**2 - 1, side), (sp.sin(alpha) ** 2 + sp.cos(alpha) ** 2 - 1, sp.cos(alpha))]
    squares += [(sp.expand(let.expr**2) - let.symbol**2, depth) for let in lets]
    for square, symbol in squares:
        numerator = sp.rem(sp.expand(numerator), square, symbol)
    return min(expr, sp.factor(numerator / denominator), key=sp.count_ops)


def _flank() -> tuple[Vec, Vec]:
    """Return the point cut by the straight flank, relative to the pitch point, and its tangent.

    The point is the foot of the perpendicular from the pitch point to the flank.
    """
    normal = _inward(-side * sp.sin(alpha), -sp.cos(alpha))
    start = _inward(xi - s, S.Zero)
    point = start - start.dot(normal) * normal
    return Vec(TANGENT, tuple(map(_simplify_if_shorter, point.components))), (-side) * normal


def flank_envelope() -> ClosedForm:
    """Build the outline that the straight flank cuts."""
    return _envelope("flank", (PLACE, s, xi, side, alpha), *_flank())


beyond = _rack(
    "beyond",
    "m",
    "distance of a point of a flank from the pitch point, along the normal into the gear",
)


def line_of_action_point() -> ClosedForm:
    """Build the position on the line of action at which a flank is cut, and touches its mating
    flank.
    """
    foot, tangent = _flank()
    steps = (Let(beyond, _simplify_if_shorter(tangent.cross(foot)[2]), "derived: line of action"),)
    return ClosedForm("action", (s, xi, side, alpha), steps, Vector("acting", (beyond,)))


def fillet_envelope() -> ClosedForm:
    """Build the fillet: the tip radius cuts on the line from the pitch point through its centre,
    beyond the centre.

    The outline runs against s.
    """
    centre = _inward(middle - s, depth)
    distance = Let(away, sp.sqrt(centre.dot(centre)), "derived: fillet")
    tangent = (1 / away) * centre.cross(unit(TANGENT, Z))
    return _envelope(
        "fillet", (PLACE, s, middle, depth, rho), (1 + rho / away) * centre, tangent, (distance,)
    )


def equidistant_envelope() -> ClosedForm:
    """Build tips and roots: a straight line of the rack cuts at the foot of the perpendicular from
    the pitch point.
    """
    return _envelope("equidistant", (PLACE, height), _inward(S.Zero, -height), unit(TANGENT, X))


dkappa = _rack("dkappa", "1/m2", "slope of the curvature along the pitch curve")
ddkappa = _rack("ddkappa", "1/m3", "second derivative of the curvature along the pitch curve")
BENDS = Vector("bends", (kappa, dkappa, ddkappa))
regular = _rack(
    "regular",
    "1",
    "rate of a flank relative to that of a rack; 1 - z_min/z at the end of the straight flank on "
    "a circle",
)
dregular = _rack("dregular", "1/m", "slope of regular along the pitch curve")
ddregular = _rack("ddregular", "1/m2", "second derivative of regular along the pitch curve")
REGULARITY = Vector("regularity", (regular, dregular, ddregular))


def flank_regularity() -> ClosedForm:
    """Build the margin of a flank from undercut, which is zero where the flank reverses, with its
    derivatives.
    """
    rates = {s: S.One, kappa: dkappa, dkappa: ddkappa}
    growth = next(
        step.expr
        for step in flank_envelope().steps
        if isinstance(step, Let) and step.symbol == rate
    )
    values = [sp.expand(growth / sp.sin(alpha))]
    for _ in range(2):
        values.append(Motion(rates).rate(values[-1]))
    steps = tuple(
        Let(q, _simplify_if_shorter(v), "derived: regularity")
        for q, v in zip(REGULARITY, values, strict=True)
    )
    return ClosedForm("regularity", (BENDS, s, xi, side, alpha), steps, REGULARITY)


def pitch_point() -> ClosedForm:
    """Build point, tangent and curvature of a pitch curve, in the gear's frame, from its polar
    coordinates.
    """
    frame = Frame("radius", WORLD, Z, polar)
    motion = Motion({polar: S.One, radius: slope, slope: bend})
    point = Vec(frame, (radius, S.Zero, S.Zero))
    first = motion.derivative(point)
    second = motion.derivative(first)
    position, direction = point.resolved(WORLD), first.resolved(WORLD)
    size = sp.sqrt(sp.trigsimp(sp.expand(first.dot(first))))
    values = (
        position[0],
        sense * position[1],
        sense * direction[0] / speed,
        direction[1] / speed,
        sp.factor(first.cross(second)[2]) / speed**3,
    )
    steps = [Let(speed, size, "derived: pitch curve")]
    steps += [Let(q, v, "derived: pitch curve") for q, v in zip(PLACE, values, strict=True)]
    return ClosedForm("pitch", (POLAR, sense), tuple(steps), Vector("pitch_place", (*PLACE, speed)))


def conjugate_polar() -> ClosedForm:
    """Build the polar coordinates of the conjugate's pitch curve, in its frame, which turns by the
    ratio.
    """
    r, ratio = pitch_curve.r, pitch_curve.ratio
    motion = Motion({r: pitch_curve.dr, pitch_curve.dr: pitch_curve.ddr, ratio: pitch_curve.dratio})
    first = motion.rate(a - r) / ratio
    values = (pitch_curve.turned, a - r, first, motion.rate(first) / ratio)
    steps = tuple(Let(q, v, "derived: conjugate") for q, v in zip(POLAR, values, strict=True))
    return ClosedForm("mate", (pitch_curve.CONTACT, a), steps, POLAR)


def rolling_ratio() -> ClosedForm:
    """Build the ratio of a gear that rolls on its mating gear, from its radius alone."""
    r, dr = pitch_curve.r, pitch_curve.dr
    ratio = r / (a - r)
    steps = (
        Let(pitch_curve.ratio, ratio, "derived: conjugation"),
        Let(pitch_curve.dratio, sp.factor(Motion({r: dr}).rate(ratio)), "derived: conjugation"),
    )
    return ClosedForm(
        "rolling", (r, dr, a), steps, Vector("rolled", (pitch_curve.ratio, pitch_curve.dratio))
    )


module = _rack("module", "m", "module")
addendum = _rack(
    "addendum",
    "1",
    "height of the rack's straight flank on both sides of its middle line, in modules",
)
clearance = _rack("clearance", "1", "clearance under the tips of the mating gear, in modules")
shift = _rack("shift", "1", "profile shift, outwards, in modules")
play = _rack(
    "play", "m", "circumferential backlash of a pair, shared by both gears and both flanks"
)
largest = _rack("largest", "1", "largest tip radius of the rack, in modules")
RACK = Vector("rack", (module, addendum, clearance, shift, alpha, play, largest))
pitch_ = _rack("pitch_", "m", "pitch of the teeth")
half = _rack("half", "m", "half a tooth's thickness on the pitch curve")
full = _rack("full", "m", "half a tooth's thickness without backlash")
tip = _rack("tip", "m", "height of the tips over the pitch curve")
root = _rack("root", "m", "depth of the roots under the pitch curve")
round_ = _rack(
    "round_",
    "m",
    "tip radius of the rack: the smallest of the radius at which the straight flank ends at "
    "the addendum, the full tip radius, and the largest that is allowed",
)
sunk = _rack("sunk", "m", "depth of the centre of the tip radius under the pitch curve")
lateral_centre = _rack(
    "beside",
    "m",
    "distance of the centre of the tip radius from the middle of a tooth, along the pitch curve",
)
straight = _rack("straight", "m", "depth of the end of the straight flank under the pitch curve")
form = _rack("form", "m", "depth of the rack's addendum under the pitch curve")
SIZES = Vector(
    "sizes", (pitch_, half, full, tip, root, round_, sunk, lateral_centre, straight, form)
)


def tooth_sizes() -> ClosedForm:
    """Build heights and thickness of the teeth, and the tip radius of the rack, tangent to flank
    and tip line.
    """
    rack = Frame("rack")
    normal = Vec(rack, (sp.cos(alpha), sp.sin(alpha), S.Zero))
    r = sp.Symbol("r", positive=True)
    b = sp.Symbol("b")
    centre = Vec(rack, (b - half, r - root, S.Zero))
    (lateral,) = sp.solve(sp.expand(centre.dot(normal) - r), b)
    touch = centre - r * normal
    (ending,) = sp.solve(sp.expand(-touch[1] - form), r)
    (fitting,) = sp.solve(sp.expand(lateral - pitch_ / 2), r)
    steps = (
        Let(pitch_, pi * module, "ISO 53: pitch"),
        Let(full, pitch_ / 4 + shift * module * sp.tan(alpha), "ISO 53: thickness"),
        Let(half, full - play / 4, "backlash shared by both flanks of both gears"),
        Let(tip, (addendum + shift) * module, "ISO 53: addendum"),
        Let(root, (addendum + clearance - shift) * module, "ISO 53: dedendum"),
        Let(form, (addendum - shift) * module, "ISO 53: addendum of the rack"),
        Let(
            round_,
            sp.Min(sp.simplify(ending), sp.simplify(fitting), largest * module),
            "derived: tip radius of the rack",
        ),
        Let(sunk, root - round_, "derived: tip radius of the rack"),
        Let(lateral_centre, lateral.subs(r, round_), "derived: tip radius of the rack"),
        Let(straight, (-touch[1]).subs(r, round_), "derived: tip radius of the rack"),
    )
    return ClosedForm("sizes", (RACK,), steps, SIZES)


reach = _rack(
    "reach",
    "m",
    "length of the pitch curve over which a flank is cut, from its position to the tip",
)


def flank_reach() -> ClosedForm:
    """Build the length of the pitch curve over which a flank is cut, on the osculating circle."""
    _, path = path_by_curvature(kappa, height, alpha)
    step = Let(reach, path / base_pitch(S.One, alpha), "derived: path of action")
    return ClosedForm("reach", (kappa, height, alpha), (step,), Vector("reached", (reach,)))


pressure = _rack(
    "pressure", "rad", "angle of the teeth's normal to the perpendicular of the line of centres"
)


def pressure_angle() -> ClosedForm:
    """Build the pressure angle of a flank that touches at the pitch point; negative if the normal
    is inclined back.
    """
    radial = Vec(WORLD, (x, y, S.Zero))
    tangent = Vec(WORLD, (tx, ty, S.Zero))
    lean = sp.atan2(radial.dot(tangent), radial.cross(tangent)[2])
    steps = (Let(pressure, alpha + side * lean, "derived: pressure angle"),)
    return ClosedForm("pressure", (PLACE, side, alpha), steps, Vector("pressed", (pressure,)))


angle = _rack("angle", "rad", "rotation of a gear, anticlockwise")
cx = _rack("cx", "m", "axis of the gear, x")
cy = _rack("cy", "m", "axis of the gear, y")
WHERE = Vector("where", (angle, cx, cy))
PLACED = Vector("placed", (px, py, ex, ey))


def mounted_point() -> ClosedForm:
    """Build a point of a gear and its tangent after the gear has been mounted and turned."""
    gear = Frame("turned gear", WORLD, Z, angle)
    local = Vector(
        "own",
        tuple(_rack(f"own_{q.name}", q.unit, f"{q.meaning}, in the gear's frame") for q in PLACED),
    )
    pairs = local.quantities[:2], local.quantities[2:]
    point, tangent = (Vec(gear, (*pair, S.Zero)).resolved(WORLD) for pair in pairs)
    values = (cx + point[0], cy + point[1], tangent[0], tangent[1])
    steps = tuple(Let(q, v, "derived: mounted gear") for q, v in zip(PLACED, values, strict=True))
    return ClosedForm("placed", (local, WHERE), steps, PLACED)


def build_rack_system() -> System:
    """Build the model of teeth cut by a rack on pitch curves."""
    forms = (
        pitch_point(),
        conjugate_polar(),
        rolling_ratio(),
        tooth_sizes(),
        flank_envelope(),
        flank_regularity(),
        fillet_envelope(),
        equidistant_envelope(),
        line_of_action_point(),
        flank_reach(),
        pressure_angle(),
        mounted_point(),
    )
    return System(
        "rack_teeth",
        "Teeth cut by a rack on pitch curves",
        "derived (geometry)",
        ASSUMPTIONS,
        closed_forms=forms,
    )


SYSTEMS = (build_rack_system,)
