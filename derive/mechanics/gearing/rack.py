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

from ...model import ClosedForm, Let, System, let_all
from ...quantity import Quantity, Vector, read_quantities
from ..frames import Frame, Motion, Vec, X, Z, unit
from . import pitch_curve
from .pitch_curve import a
from .teeth import base_pitch, path_by_curvature

ASSUMPTIONS = (
    "rigid teeth that are exact envelopes of a rack in the transverse section",
    "the rack's straight flanks end in a tip radius that is tangent to its tip line",
)
_rack = partial(Quantity, source="derived: rack teeth")

t = read_quantities(
    """
derived: rack teeth
polar | rad | polar angle on the pitch curve, in the direction of the curve
radius | m | pitch radius at that angle
slope | m | slope of the pitch radius, per polar angle
bend | m | second derivative of the pitch radius, per polar angle
sense | 1 | +1 where the curve's polar angle runs anticlockwise, -1 where clockwise
x | m | pitch point, x
y | m | pitch point, y
tx | 1 | unit tangent of the pitch curve, x, anticlockwise
ty | 1 | unit tangent of the pitch curve, y, anticlockwise
kappa | 1/m | curvature of the pitch curve, positive where convex
speed | m | arc length of the pitch curve per polar angle
s | m | arc length of the pitch curve at the point that the rack touches
xi | m | position of the flank: arc length of the pitch curve at which the flank crosses the rack's pitch line
side | 1 | +1 for the flank at the end of a tooth, -1 for the flank at its beginning
alpha | rad | pressure angle
height | m | height of an equidistant line over the pitch line, outwards
middle | m | centre of the rack's tip radius along its pitch line
depth | m | depth of the centre of the rack's tip radius under its pitch line
rho | m | tip radius of the rack
away | m | distance of the centre of the tip radius from the pitch point
px | m | point of the outline, x
py | m | point of the outline, y
ex | 1 | unit tangent of the outline, x
ey | 1 | unit tangent of the outline, y
rate | 1 | length of the outline per arc length of the pitch curve; negative where the outline has reversed
turning | 1/m | rotation of the outline's tangent per arc length of the pitch curve
beyond | m | distance of a point of a flank from the pitch point, along the normal into the gear
dkappa | 1/m2 | slope of the curvature along the pitch curve
ddkappa | 1/m3 | second derivative of the curvature along the pitch curve
regular | 1 | rate of a flank relative to that of a rack; 1 - z_min/z at the end of the straight flank on a circle
dregular | 1/m | slope of regular along the pitch curve
ddregular | 1/m2 | second derivative of regular along the pitch curve
module | m | module
addendum | 1 | height of the rack's straight flank on both sides of its middle line, in modules
clearance | 1 | clearance under the tips of the mating gear, in modules
shift | 1 | profile shift, outwards, in modules
play | m | circumferential backlash of a pair, shared by both gears and both flanks
largest | 1 | largest tip radius of the rack, in modules
pitch_ | m | pitch of the teeth
half | m | half a tooth's thickness on the pitch curve
full | m | half a tooth's thickness without backlash
tip | m | height of the tips over the pitch curve
root | m | depth of the roots under the pitch curve
round_ | m | tip radius of the rack: the smallest of the radius at which the straight flank ends at the \
addendum, the full tip radius, and the largest that is allowed
sunk | m | depth of the centre of the tip radius under the pitch curve
beside | m | distance of the centre of the tip radius from the middle of a tooth, along the pitch curve
straight | m | depth of the end of the straight flank under the pitch curve
form | m | depth of the rack's addendum under the pitch curve
reach | m | length of the pitch curve over which a flank is cut, from its position to the tip
pressure | rad | angle of the teeth's normal to the perpendicular of the line of centres
angle | rad | rotation of a gear, anticlockwise
cx | m | axis of the gear, x
cy | m | axis of the gear, y
"""
)
"""Quantities of this module."""


POLAR = Vector("polar_place", t.select("polar radius slope bend"))


PLACE = Vector("place", t.select("x y tx ty kappa"))


POINT = Vector("point", t.select("px py ex ey rate turning"))

tau = sp.Symbol("tau")
WORLD = Frame("gear")
TANGENT = Frame("tangent of the pitch curve", WORLD, Z, tau)
ROLLING = Motion({t.s: S.One, tau: t.kappa, t.x: sp.cos(tau), t.y: sp.sin(tau)})
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
    definitions: tuple[Let, ...] = (),
) -> ClosedForm:
    """Build the point, tangent and rates of an outline that is cut at ``offset`` from the pitch
    point.

    ``tangent`` is the unit tangent of the outline; ``definitions`` define quantities that vary with the
    arc length and that both vectors contain as symbols.
    """
    motion = Motion(dict(ROLLING.rates))
    motion.rates |= {
        let.symbol: motion.rate(let.expr).subs(let.expr, let.symbol) for let in definitions
    }
    drift = motion.derivative(offset) + unit(TANGENT, X)
    point, direction = offset.resolved(WORLD), tangent.resolved(WORLD)
    values = (
        t.x + point[0],
        t.y + point[1],
        direction[0],
        direction[1],
        drift.dot(tangent),
        tangent.cross(motion.derivative(tangent))[2],
    )
    components = {sp.cos(tau): t.tx, sp.sin(tau): t.ty}
    expressions = (_simplify_if_shorter(value, definitions).subs(components) for value in values)
    steps = (
        *definitions,
        *let_all(POINT, expressions, name),
    )
    return ClosedForm(name, inputs, steps, POINT)


def _simplify_if_shorter(expr: Expr, definitions: tuple[Let, ...] = ()) -> Expr:
    """Return the expression with the squares of sides, sines and distances replaced, if that is
    shorter.
    """
    numerator, denominator = sp.fraction(sp.together(expr))
    squares = [
        (t.side**2 - 1, t.side),
        (sp.sin(t.alpha) ** 2 + sp.cos(t.alpha) ** 2 - 1, sp.cos(t.alpha)),
    ]
    squares += [(sp.expand(let.expr**2) - let.symbol**2, t.depth) for let in definitions]
    for square, symbol in squares:
        numerator = sp.rem(sp.expand(numerator), square, symbol)
    return min(expr, sp.factor(numerator / denominator), key=sp.count_ops)


def _flank() -> tuple[Vec, Vec]:
    """Return the point cut by the straight flank, relative to the pitch point, and its tangent.

    The point is the foot of the perpendicular from the pitch point to the flank.
    """
    normal = _inward(-t.side * sp.sin(t.alpha), -sp.cos(t.alpha))
    start = _inward(t.xi - t.s, S.Zero)
    point = start - start.dot(normal) * normal
    return Vec(TANGENT, tuple(map(_simplify_if_shorter, point.components))), (-t.side) * normal


def flank_envelope() -> ClosedForm:
    """Build the outline that the straight flank cuts."""
    return _envelope("flank", (PLACE, t.s, t.xi, t.side, t.alpha), *_flank())


def line_of_action_point() -> ClosedForm:
    """Build the position on the line of action at which a flank is cut, and touches its mating
    flank.
    """
    foot, tangent = _flank()
    steps = (
        Let(t.beyond, _simplify_if_shorter(tangent.cross(foot)[2]), "derived: line of action"),
    )
    return ClosedForm("action", (t.s, t.xi, t.side, t.alpha), steps, Vector("acting", (t.beyond,)))


def fillet_envelope() -> ClosedForm:
    """Build the fillet: the tip radius cuts on the line from the pitch point through its centre,
    beyond the centre.

    The outline runs against s.
    """
    centre = _inward(t.middle - t.s, t.depth)
    distance = Let(t.away, sp.sqrt(centre.dot(centre)), "derived: fillet")
    tangent = (1 / t.away) * centre.cross(unit(TANGENT, Z))
    return _envelope(
        "fillet",
        (PLACE, t.s, t.middle, t.depth, t.rho),
        (1 + t.rho / t.away) * centre,
        tangent,
        (distance,),
    )


def equidistant_envelope() -> ClosedForm:
    """Build tips and roots: a straight line of the rack cuts at the foot of the perpendicular from
    the pitch point.
    """
    return _envelope("equidistant", (PLACE, t.height), _inward(S.Zero, -t.height), unit(TANGENT, X))


BENDS = Vector("bends", t.select("kappa dkappa ddkappa"))


REGULARITY = Vector("regularity", t.select("regular dregular ddregular"))


def flank_regularity() -> ClosedForm:
    """Build the margin of a flank from undercut, which is zero where the flank reverses, with its
    derivatives.
    """
    rates = {t.s: S.One, t.kappa: t.dkappa, t.dkappa: t.ddkappa}
    growth = next(
        step.expr
        for step in flank_envelope().steps
        if isinstance(step, Let) and step.symbol == t.rate
    )
    values = [sp.expand(growth / sp.sin(t.alpha))]
    for _ in range(2):
        values.append(Motion(rates).rate(values[-1]))
    steps = tuple(
        Let(q, _simplify_if_shorter(v), "derived: regularity")
        for q, v in zip(REGULARITY, values, strict=True)
    )
    return ClosedForm("regularity", (BENDS, t.s, t.xi, t.side, t.alpha), steps, REGULARITY)


def pitch_point() -> ClosedForm:
    """Build point, tangent and curvature of a pitch curve, in the gear's frame, from its polar
    coordinates.
    """
    frame = Frame("radius", WORLD, Z, t.polar)
    motion = Motion({t.polar: S.One, t.radius: t.slope, t.slope: t.bend})
    point = Vec(frame, (t.radius, S.Zero, S.Zero))
    first = motion.derivative(point)
    second = motion.derivative(first)
    position, direction = point.resolved(WORLD), first.resolved(WORLD)
    size = sp.sqrt(sp.trigsimp(sp.expand(first.dot(first))))
    values = (
        position[0],
        t.sense * position[1],
        t.sense * direction[0] / t.speed,
        direction[1] / t.speed,
        sp.factor(first.cross(second)[2]) / t.speed**3,
    )
    steps = [Let(t.speed, size, "derived: pitch curve")]
    steps += let_all(PLACE, values, "pitch curve")
    return ClosedForm(
        "pitch", (POLAR, t.sense), tuple(steps), Vector("pitch_place", (*PLACE, t.speed))
    )


def conjugate_polar() -> ClosedForm:
    """Build the polar coordinates of the conjugate's pitch curve, in its frame, which turns by the
    ratio.
    """
    r, ratio = pitch_curve.r, pitch_curve.ratio
    motion = Motion({r: pitch_curve.dr, pitch_curve.dr: pitch_curve.ddr, ratio: pitch_curve.dratio})
    first = motion.rate(a - r) / ratio
    values = (pitch_curve.turned, a - r, first, motion.rate(first) / ratio)
    steps = let_all(POLAR, values, "conjugate")
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


RACK = Vector("rack", t.select("module addendum clearance shift alpha play largest"))


SIZES = Vector("sizes", t.select("pitch_ half full tip root round_ sunk beside straight form"))


def tooth_sizes() -> ClosedForm:
    """Build heights and thickness of the teeth, and the tip radius of the rack, tangent to flank
    and tip line.
    """
    rack = Frame("rack")
    normal = Vec(rack, (sp.cos(t.alpha), sp.sin(t.alpha), S.Zero))
    r = sp.Symbol("r", positive=True)
    b = sp.Symbol("b")
    centre = Vec(rack, (b - t.half, r - t.root, S.Zero))
    (lateral,) = sp.solve(sp.expand(centre.dot(normal) - r), b)
    touch = centre - r * normal
    (ending,) = sp.solve(sp.expand(-touch[1] - t.form), r)
    (fitting,) = sp.solve(sp.expand(lateral - t.pitch_ / 2), r)
    steps = (
        Let(t.pitch_, pi * t.module, "ISO 53: pitch"),
        Let(t.full, t.pitch_ / 4 + t.shift * t.module * sp.tan(t.alpha), "ISO 53: thickness"),
        Let(t.half, t.full - t.play / 4, "backlash shared by both flanks of both gears"),
        Let(t.tip, (t.addendum + t.shift) * t.module, "ISO 53: addendum"),
        Let(t.root, (t.addendum + t.clearance - t.shift) * t.module, "ISO 53: dedendum"),
        Let(t.form, (t.addendum - t.shift) * t.module, "ISO 53: addendum of the rack"),
        Let(
            t.round_,
            sp.Min(sp.simplify(ending), sp.simplify(fitting), t.largest * t.module),
            "derived: tip radius of the rack",
        ),
        Let(t.sunk, t.root - t.round_, "derived: tip radius of the rack"),
        Let(t.beside, lateral.subs(r, t.round_), "derived: tip radius of the rack"),
        Let(t.straight, (-touch[1]).subs(r, t.round_), "derived: tip radius of the rack"),
    )
    return ClosedForm("sizes", (RACK,), steps, SIZES)


def flank_reach() -> ClosedForm:
    """Build the length of the pitch curve over which a flank is cut, on the osculating circle."""
    _, path = path_by_curvature(t.kappa, t.height, t.alpha)
    step = Let(t.reach, path / base_pitch(S.One, t.alpha), "derived: path of action")
    return ClosedForm("reach", (t.kappa, t.height, t.alpha), (step,), Vector("reached", (t.reach,)))


def pressure_angle() -> ClosedForm:
    """Build the pressure angle of a flank that touches at the pitch point; negative if the normal
    is inclined back.
    """
    radial = Vec(WORLD, (t.x, t.y, S.Zero))
    tangent = Vec(WORLD, (t.tx, t.ty, S.Zero))
    lean = sp.atan2(radial.dot(tangent), radial.cross(tangent)[2])
    steps = (Let(t.pressure, t.alpha + t.side * lean, "derived: pressure angle"),)
    return ClosedForm("pressure", (PLACE, t.side, t.alpha), steps, Vector("pressed", (t.pressure,)))


WHERE = Vector("where", t.select("angle cx cy"))
PLACED = Vector("placed", t.select("px py ex ey"))


def mounted_point() -> ClosedForm:
    """Build a point of a gear and its tangent after the gear has been mounted and turned."""
    gear = Frame("turned gear", WORLD, Z, t.angle)
    local = Vector(
        "own",
        tuple(_rack(f"own_{q.name}", q.unit, f"{q.meaning}, in the gear's frame") for q in PLACED),
    )
    pairs = local.quantities[:2], local.quantities[2:]
    point, tangent = (Vec(gear, (*pair, S.Zero)).resolved(WORLD) for pair in pairs)
    values = (t.cx + point[0], t.cy + point[1], tangent[0], tangent[1])
    steps = let_all(PLACED, values, "mounted gear")
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
