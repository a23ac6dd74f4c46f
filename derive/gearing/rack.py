"""Teeth that a rack cuts on a pitch curve: the curves that its flank, its round and its straight lines envelop.

The rack's pitch line rolls on the pitch curve, so that the pitch point is the instant centre: where the rack cuts, its
normal passes through there (Litvin, Fuentes-Aznar, Gonzalez-Perez, Hayasaka: Noncircular Gears, 2009; the basic rack
with the round at its tips: ISO 53). All in the arc length s of the pitch curve, which runs anticlockwise.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, pi

from ..mechanics.frames import Frame, Motion, Vec, X, Z, unit
from ..model import ClosedForm, Let, System
from ..quantity import Quantity, Vector
from . import meshing
from .pitch_curve import a
from .teeth import base_pitch, by_curvature

ASSUMPTIONS = (
    "rigid teeth that are exact envelopes of a rack in the transverse section",
    "the rack's straight flanks end in a round that is tangent to its tip line",
)
_SOURCE = "derived: rack teeth"


def _given(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, _SOURCE)


polar = _given("polar", "rad", "polar angle on the pitch curve, in the curve's own sense")
radius = _given("radius", "m", "pitch radius there")
slope = _given("slope", "m", "slope of the pitch radius, per polar angle")
bend = _given("bend", "m", "second derivative of the pitch radius, per polar angle")
POLAR = Vector("polar_place", (polar, radius, slope, bend))
sense = _given("sense", "1", "+1 where the curve's polar angle runs anticlockwise, -1 where clockwise")
x = _given("x", "m", "pitch point, x")
y = _given("y", "m", "pitch point, y")
tx = _given("tx", "1", "unit tangent of the pitch curve, x, anticlockwise")
ty = _given("ty", "1", "unit tangent of the pitch curve, y, anticlockwise")
kappa = _given("kappa", "1/m", "curvature of the pitch curve, positive where convex")
PLACE = Vector("place", (x, y, tx, ty, kappa))
speed = _given("speed", "m", "arc length of the pitch curve per polar angle")

s = _given("s", "m", "arc length of the pitch curve where the rack touches it")
xi = _given("xi", "m", "place of the flank on the pitch curve, where it crosses the rack's pitch line")
side = _given("side", "1", "+1 for the flank that ends a tooth, -1 for the one that begins it")
alpha = _given("alpha", "rad", "pressure angle")
height = _given("height", "m", "height of an equidistant line over the pitch line, outwards")
middle = _given("middle", "m", "centre of the rack's round along its pitch line")
depth = _given("depth", "m", "depth of the centre of the rack's round under its pitch line")
rho = _given("rho", "m", "radius of the rack's round")
away = _given("away", "m", "distance of the round's centre from the pitch point")

px = _given("px", "m", "point of the outline, x")
py = _given("py", "m", "point of the outline, y")
ex = _given("ex", "1", "unit tangent of the outline, x")
ey = _given("ey", "1", "unit tangent of the outline, y")
rate = _given("rate", "1", "length of the outline per arc length of the pitch curve; negative where it has turned back")
turning = _given("turning", "1/m", "angle that the outline's tangent turns by per arc length of the pitch curve")
POINT = Vector("point", (px, py, ex, ey, rate, turning))

tau = sp.Symbol("tau")
WORLD = Frame("gear")
TANGENT = Frame("tangent of the pitch curve", WORLD, Z, tau)
ROLLING = Motion({s: S.One, tau: kappa, x: sp.cos(tau), y: sp.sin(tau)})
"""How what the rack touches changes as it rolls on, per arc length."""


def _inward(along: Expr, into: Expr) -> Vec:
    """Components along the pitch curve's tangent and to its left, which is into the gear."""
    return Vec(TANGENT, (along, into, S.Zero))


def _envelope(
    name: str, inputs: tuple[Quantity | Vector, ...], offset: Vec, tangent: Vec, named: tuple[Let, ...] = ()
) -> ClosedForm:
    """Point, tangent and rates of what is cut at an offset from the pitch point, for a unit tangent to it.

    ``named`` are quantities that change with the arc length and stand in both by their names.
    """
    motion = Motion(dict(ROLLING.rates))
    motion.rates |= {let.symbol: motion.rate(let.expr).subs(let.expr, let.symbol) for let in named}
    drift = motion.derivative(offset) + unit(TANGENT, X)
    place, direction = offset.resolved(WORLD), tangent.resolved(WORLD)
    values = (
        x + place[0], y + place[1], direction[0], direction[1], drift.dot(tangent),
        tangent.cross(motion.derivative(tangent))[2],
    )  # fmt: skip
    plain = {sp.cos(tau): tx, sp.sin(tau): ty}
    shown = (_shorter(value, named).subs(plain) for value in values)
    steps = (*named, *(Let(q, value, f"derived: {name}") for q, value in zip(POINT, shown, strict=True)))
    return ClosedForm(name, inputs, steps, POINT)


def _shorter(expr: Expr, named: tuple[Let, ...] = ()) -> Expr:
    """The shorter of two equal forms: as it stands, or by what squares of sides, sines and distances are."""
    top, under = sp.fraction(sp.together(expr))
    squares = [(side**2 - 1, side), (sp.sin(alpha) ** 2 + sp.cos(alpha) ** 2 - 1, sp.cos(alpha))]
    squares += [(sp.expand(let.expr**2) - let.symbol**2, depth) for let in named]
    for square, symbol in squares:
        top = sp.rem(sp.expand(top), square, symbol)
    return min(expr, sp.factor(top / under), key=sp.count_ops)


def _flank() -> tuple[Vec, Vec]:
    """What the straight flank cuts, from the pitch point, and its tangent: the foot of the perpendicular from there."""
    outwards = _inward(-side * sp.sin(alpha), -sp.cos(alpha))
    start = _inward(xi - s, S.Zero)
    point = start - start.dot(outwards) * outwards
    return Vec(TANGENT, tuple(map(_shorter, point.components))), (-side) * outwards


def flank() -> ClosedForm:
    """The straight flank."""
    return _envelope("flank", (PLACE, s, xi, side, alpha), *_flank())


beyond = _given("beyond", "m", "distance of a flank's point from the pitch point, along the normal into the gear")


def action() -> ClosedForm:
    """Where on the line of action a flank is cut, and so touches its mate."""
    foot, tangent = _flank()
    steps = (Let(beyond, _shorter(tangent.cross(foot)[2]), "derived: line of action"),)
    return ClosedForm("action", (s, xi, side, alpha), steps, Vector("acting", (beyond,)))


def fillet() -> ClosedForm:
    """The round cuts on the line from the pitch point through its centre, beyond that; the outline runs against s."""
    centre = _inward(middle - s, depth)
    named = Let(away, sp.sqrt(centre.dot(centre)), "derived: fillet")
    along = (1 / away) * centre.cross(unit(TANGENT, Z))
    return _envelope("fillet", (PLACE, s, middle, depth, rho), (1 + rho / away) * centre, along, (named,))


def equidistant() -> ClosedForm:
    """A straight line of the rack cuts at the foot of the perpendicular from the pitch point: tips and roots."""
    return _envelope("equidistant", (PLACE, height), _inward(S.Zero, -height), unit(TANGENT, X))


dkappa = _given("dkappa", "1/m2", "slope of the curvature along the pitch curve")
ddkappa = _given("ddkappa", "1/m3", "second derivative of the curvature along the pitch curve")
BENDS = Vector("bends", (kappa, dkappa, ddkappa))
regular = _given("regular", "1", "rate of a flank in parts of a rack's; on a circle's straight end 1 - z_min/z")
dregular = _given("dregular", "1/m", "its slope along the pitch curve")
ddregular = _given("ddregular", "1/m2", "its second derivative along the pitch curve")
REGULARITY = Vector("regularity", (regular, dregular, ddregular))


def regularity() -> ClosedForm:
    """How far a flank is from turning back, with its derivatives."""
    rates = {s: S.One, kappa: dkappa, dkappa: ddkappa}
    growth = next(step.expr for step in flank().steps if isinstance(step, Let) and step.symbol == rate)
    values = [sp.expand(growth / sp.sin(alpha))]
    values += [Motion(rates).rate(values[0])]
    values += [Motion(rates).rate(values[1])]
    steps = tuple(Let(q, _shorter(v), "derived: regularity") for q, v in zip(REGULARITY, values, strict=True))
    return ClosedForm("regularity", (BENDS, s, xi, side, alpha), steps, REGULARITY)


def pitch() -> ClosedForm:
    """A pitch curve in polar coordinates as place, tangent and curvature in its own frame."""
    frame = Frame("radius", WORLD, Z, polar)
    motion = Motion({polar: S.One, radius: slope, slope: bend})
    point = Vec(frame, (radius, S.Zero, S.Zero))
    first = motion.derivative(point)
    second = motion.derivative(first)
    place, direction = point.resolved(WORLD), first.resolved(WORLD)
    size = sp.sqrt(sp.trigsimp(sp.expand(first.dot(first))))
    values = (
        place[0], sense * place[1], sense * direction[0] / speed, direction[1] / speed,
        sp.factor(first.cross(second)[2]) / speed**3,
    )  # fmt: skip
    steps = [Let(speed, size, "derived: pitch curve")]
    steps += [Let(q, v, "derived: pitch curve") for q, v in zip(PLACE, values, strict=True)]
    return ClosedForm("pitch", (POLAR, sense), tuple(steps), Vector("pitch_place", (*PLACE, speed)))


def mate() -> ClosedForm:
    """The conjugate's pitch curve in polar coordinates of its own: it turns by what the ratio says."""
    own = Motion({meshing.r: meshing.dr, meshing.dr: meshing.ddr, meshing.ratio: meshing.dratio})
    first = own.rate(a - meshing.r) / meshing.ratio
    values = (meshing.turned, a - meshing.r, first, own.rate(first) / meshing.ratio)
    steps = tuple(Let(q, v, "derived: conjugate") for q, v in zip(POLAR, values, strict=True))
    return ClosedForm("mate", (meshing.CONTACT, a), steps, POLAR)


def rolling() -> ClosedForm:
    """The ratio of a gear that rolls on its mate, from its radius alone."""
    found = meshing.r / (a - meshing.r)
    steps = (
        Let(meshing.ratio, found, "derived: conjugation"),
        Let(meshing.dratio, sp.factor(Motion({meshing.r: meshing.dr}).rate(found)), "derived: conjugation"),
    )
    return ClosedForm("rolling", (meshing.r, meshing.dr, a), steps, Vector("rolled", (meshing.ratio, meshing.dratio)))


module = _given("module", "m", "module")
addendum = _given("addendum", "1", "height of the rack's straight flank on both sides of its middle line, in modules")
clearance = _given("clearance", "1", "clearance under the tips of the mate, in modules")
shift = _given("shift", "1", "profile shift, outwards, in modules")
play = _given("play", "m", "circumferential play of a pair, shared by both gears and both flanks")
largest = _given("largest", "1", "largest radius of the rack's round, in modules")
RACK = Vector("rack", (module, addendum, clearance, shift, alpha, play, largest))
pitch_ = _given("pitch_", "m", "pitch of the teeth")
half = _given("half", "m", "half a tooth's thickness on the pitch curve")
full = _given("full", "m", "half a tooth's thickness without play")
tip = _given("tip", "m", "height of the tips over the pitch curve")
root = _given("root", "m", "depth of the roots under the pitch curve")
round_ = _given("round_", "m", "radius of the rack's round: as large as has the straight flank end at its addendum, "
                "as fits, or as is let")  # fmt: skip
sunk = _given("sunk", "m", "depth of the round's centre under the pitch curve")
beside = _given("beside", "m", "the round's centre from the middle of a tooth, along the pitch curve")
straight = _given("straight", "m", "depth under the pitch curve where the straight flank ends")
form = _given("form", "m", "depth of the rack's addendum under the pitch curve")
SIZES = Vector("sizes", (pitch_, half, full, tip, root, round_, sunk, beside, straight, form))


def sizes() -> ClosedForm:
    """What of a rack its gear feels: heights, thickness, and the round that is tangent to flank and tip line."""
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
        Let(half, full - play / 4, "play shared by both flanks of both gears"),
        Let(tip, (addendum + shift) * module, "ISO 53: addendum"),
        Let(root, (addendum + clearance - shift) * module, "ISO 53: dedendum"),
        Let(form, (addendum - shift) * module, "ISO 53: addendum of the rack"),
        Let(
            round_,
            sp.Min(sp.simplify(ending), sp.simplify(fitting), largest * module),
            "derived: round of the rack's tip",
        ),
        Let(sunk, root - round_, "derived: round of the rack's tip"),
        Let(beside, lateral.subs(r, round_), "derived: round of the rack's tip"),
        Let(straight, (-touch[1]).subs(r, round_), "derived: round of the rack's tip"),
    )
    return ClosedForm("sizes", (RACK,), steps, SIZES)


reach = _given("reach", "m", "length of the pitch curve over which a tooth's flank is cut up to the tip")


def reach_() -> ClosedForm:
    """From the flank's place on the pitch curve to where its tip is cut, on the circle that osculates there."""
    _, path = by_curvature(kappa, height, alpha)
    along = path / base_pitch(S.One, alpha)
    return ClosedForm("reach", (kappa, height, alpha), (Let(reach, along, "derived: path of action"),),
                      Vector("reached", (reach,)))  # fmt: skip


pressure = _given("pressure", "rad", "angle of the teeth's normal to the perpendicular of the line of centres")


def pressure_() -> ClosedForm:
    """Of both sides of the teeth, where they touch in the pitch point: below 0 where the normal leans the other way."""
    radial = Vec(WORLD, (x, y, S.Zero))
    tangent = Vec(WORLD, (tx, ty, S.Zero))
    lean = sp.atan2(radial.dot(tangent), radial.cross(tangent)[2])
    steps = (Let(pressure, alpha + side * lean, "derived: pressure angle"),)
    return ClosedForm("pressure", (PLACE, side, alpha), steps, Vector("pressed", (pressure,)))


angle = _given("angle", "rad", "how far a gear has been turned, anticlockwise")
cx = _given("cx", "m", "axis of the gear, x")
cy = _given("cy", "m", "axis of the gear, y")
WHERE = Vector("where", (angle, cx, cy))
PLACED = Vector("placed", (px, py, ex, ey))


def placed() -> ClosedForm:
    """A point of a gear with its tangent where the gear has been put, and turned."""
    gear = Frame("turned gear", WORLD, Z, angle)
    own = Vector("own", tuple(_given(f"own_{q.name}", q.unit, f"{q.meaning}, in the gear's own frame") for q in PLACED))
    point, tangent = (Vec(gear, (*pair, S.Zero)).resolved(WORLD) for pair in (own.quantities[:2], own.quantities[2:]))
    values = (cx + point[0], cy + point[1], tangent[0], tangent[1])
    steps = tuple(Let(q, v, "derived: gear in its place") for q, v in zip(PLACED, values, strict=True))
    return ClosedForm("placed", (own, WHERE), steps, PLACED)


def exact() -> System:
    """Teeth of a rack on pitch curves."""
    forms = (
        pitch(), mate(), rolling(), sizes(), flank(), regularity(), fillet(), equidistant(), action(), reach_(),
        pressure_(), placed(),
    )  # fmt: skip
    return System("rack_teeth", "Teeth cut by a rack on pitch curves", "derived (geometry)", ASSUMPTIONS,
                  closed_forms=forms)  # fmt: skip


SYSTEMS = (exact,)
