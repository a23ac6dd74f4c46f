"""Contacts of the Reuleaux and the dog clutch: teeth on the shaft, outline in the sleeve; jaws, and a centring fit.

Each contact is a signed distance as seen from the output shaft, one of several equal ones.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, cos, pi, sin, sqrt

from ...formulas import Formulas
from ...functions import Turns, switch
from ...mechanics.frames import Frame, Vec, Y, Z, displacement, unit
from ...mechanics.kinematics import Followed
from ...model import Let, System, let
from ...quantity import Quantity, Vector
from . import contact_quantities as q
from . import rotor
from .contact_motion import BODY, OVER_INPUT, SHAFT, WORLD, O, contact, heading, opening, slip, vec
from .contact_quantities import found, given
from .geometry import SIDES, VERTICES, face_sine

DOG_ASSUMPTIONS = (
    "dog clutch: parallel flanks along the axis, rounded edges, all jaws alike, meeting at contact_radius_mm; its "
    "driving half sits in a fit on its shaft and moves with the sleeve, with the body's mass",
)
jaws = given("jaws", "1", "jaws of each half")
radius = given("radius", "m", "radius on which jaws meet")
backlash = given("backlash", "m", "backlash of the jaws along the circumference")
edge = given("edge", "m", "edge radii of two jaws that meet, added")
depth = given("depth", "m", "overlap of the jaws along the axis when engaged")
JAW = Vector("jaw_shape", (jaws, radius, backlash, edge, depth))
fit_clearance = given("fit", "m", "radial clearance of the driving half on its shaft")
core = given("core", "m", "length that keeps the direction of no eccentricity defined")

pitch = found("pitch", "rad", "angle from jaw to jaw")
offset = found("offset", "m", "middle of the jaw from that of the nearest opposite, along the circumference")
lift = found("lift", "m", "tip faces from each other, along the axis")
over = found("over", "m", "offset beyond where the flats of the flanks would meet, edges taken off")
above = found("above", "m", "lift beyond where the flats of the tips would meet, edges taken off")
edge_distance = found("nearest", "m", "distance of the middles of rounded edges and flats")
push = found("push", "1", "slope of the distance in the offset")
hoist = found("hoist", "1", "slope of the distance in the lift")
eccentric = found("eccentric", "m", "eccentricity of the body in its fit")


def jaw(f: Formulas) -> None:
    """On the rounded edge, on the flank, or on the tip face: whichever the point lies off."""
    place = Followed((q.c_x, q.c_y, q.heading))
    place.let(pitch, 2 * pi / jaws)
    at_jaw = Frame("jaw", SHAFT, Z, q.heading + pitch * q.index)
    behind = q.heading - pitch * Turns(q.heading / pitch + S.Half)
    across = unit(at_jaw, Y).resolved(SHAFT).dot(vec(SHAFT, q.c_x, q.c_y))
    place.let(offset, radius * behind + across)
    gap = Followed((offset, lift))
    gap.let(over, sp.Abs(offset) - (radius * pitch - backlash) / 2 + edge)
    gap.let(above, lift + edge)
    on_edge = sp.And(sp.Gt(over, 0), sp.Gt(above, 0))
    gap.let(edge_distance, sp.Piecewise((sqrt(over**2 + above**2), on_edge), (over, sp.Gt(over, above)), (above, True)))
    steps = (
        *heading(),
        *place.steps,
        let(lift, q.way - depth),
        *gap.steps,
        let(push, gap.along(edge_distance, offset)),
        let(hoist, gap.along(edge_distance, lift)),
    )
    moved = place.slopes(offset)
    passing = opening((moved[q.c_x], moved[q.c_y], moved[q.heading]))
    rate, sliding = push * passing + hoist * q.way_dot, push * q.way_dot - hoist * passing
    contact(f, "jaw", (q.index, JAW), steps, edge_distance - edge, rate, (sliding,))


def fit(f: Formulas) -> None:
    """The body round in the fit that centres it."""
    place = displacement(O, BODY, WORLD)
    k = Followed((q.x, q.y))
    k.let(eccentric, sqrt(place.dot(place) + core**2))
    slopes = k.slopes(eccentric)
    rate = -sp.Add(*(slopes[c] * c_dot for c, c_dot in zip((q.x, q.y), q.RATES, strict=False)))
    outwards = Vec(WORLD, (q.x / eccentric, q.y / eccentric, S.Zero))
    around = unit(WORLD, Z).cross(outwards).dot(OVER_INPUT)
    contact(f, "fit", (fit_clearance, core), tuple(k.steps), fit_clearance - eccentric, rate, (around, q.way_dot))


def build_dog_system() -> System:
    """The contacts that the dog clutch has beside those of both clutches."""
    title = "Dog clutch in contact: jaws on jaws, the driving half in its fit"
    source = "derived (distances, virtual work); law of Hunt and Crossley 1975"
    f = Formulas("clutch_contact_dog", title=title, source=source, assumptions=DOG_ASSUMPTIONS)
    for part in (jaw, fit):
        part(f)
    return f.system()


REULEAUX_ASSUMPTIONS = (
    "the hole of the body is relieved behind the roots of its teeth: on the printed root circle no tooth could pass a "
    "corner of the shaft",
    "sleeve_gap_mm between polygon and hole when cut off: without it the printed teeth would overlap with the shaft",
    "an overlap of tooth and shaft is less than the fillet radius",
)
HALF_SIDE = pi / SIDES
"""Half the angle that a side is seen under: from the middle of a side to its corner."""

tip = given("tip", "m", "distance of the tooth tips from the centroid")
root = given("root", "m", "distance of the tooth roots from the centroid")
apothem = given("apothem", "m", "half the distance between opposite flats of the shaft")
fillet = given("fillet", "m", "fillet radius on the corners of the shaft")
TOOTH = Vector("tooth_shape", (tip, root, apothem, fillet))
hole = given("hole", "m", "half the distance between opposite sides of the sleeve's hole when cut off")
travel = given("travel", "m", "travel of the sleeve")
taper = given("taper", "rad", "inclination of the tapered contact surface to the axis")
HOLE = Vector("hole_shape", (rotor.WIDTH, hole, travel, taper))

inner = found("inner", "m", "distance of the sides of the hexagon of the fillet centres from its centre")
face = found("face", "rad", "angle between a tooth's axis and either face")
reach = found("reach", "m", "length of a face, from tip to root")
t_x, t_y = (found(f"t_{a}", "m", f"tip as the turning shaft sees it, {a}") for a in "xy")
side = found("side", "rad", "direction of the middle of the side next to the tip")
corner = found("corner", "rad", "direction of the corner next to the tip")
out, beside = found("out", "m", "tip beyond that side"), found("beside", "m", "tip beside the middle of that side")
past = found("past", "m", "how far the tip is past the end of that side")
at_tip = found("at_tip", "m", "distance of the tip from the hexagon of the fillet centres")
f_x, f_y = (found(f"f_{a}", "m", f"fillet centre next to the tip, {a}") for a in "xy")
w_x, w_y = (found(f"w_{a}", "m", f"fillet centre as the tooth sees it from its tip, {a}") for a in "xy")
along = found("along", "m", "fillet centre along the nearer face, from the tip")
at_face = found("at_face", "m", "distance of that fillet centre from the nearer face")
nearest = found("nearest", "m", "distance of tooth and hexagon of the fillet centres")
outwards = found("outwards", "rad", "direction of the normal of a side of the hole")
apart = found("apart", "m", "distance of outline and side in the section")
room = found("room", "m", "half the distance between opposite sides of the hole where the sleeve is")
half_tooth = found("half_tooth", "rad", "half the angle that a tooth takes at its root")
least_root = found("least_root", "m", "least root radius with which teeth pass the corners of the shaft")


def slopes(distance: Quantity, followed: Followed) -> tuple[Let, ...]:
    """A distance's slopes in the centre that the shaft sees, and in the direction."""
    wanted = zip((q.normal_x, q.normal_y, q.lever), (q.c_x, q.c_y, q.heading), strict=True)
    return tuple(let(name, followed.along(distance, coordinate)) for name, coordinate in wanted)


NORMAL = q.normal_x, q.normal_y
POINT = q.point_x, q.point_y
OPENING = opening((*NORMAL, q.lever))


def radial(distance: Expr, direction: Expr) -> Vec:
    """A vector along a direction, as the shaft sees it."""
    return vec(Frame("radius", SHAFT, Z, direction), distance, S.Zero).resolved(SHAFT)


def tooth(f: Formulas) -> None:
    """Either the tip comes closest to the shaft, or one of its faces to a fillet."""
    k = Followed((q.c_x, q.c_y, q.heading))
    k.let(inner, apothem - fillet)
    for step in _face():
        k.let(step.symbol, step.expr)
    at_tooth = radial(tip, q.heading)
    k.let(t_x, q.c_x + at_tooth[0])
    k.let(t_y, q.c_y + at_tooth[1])
    _of_tip(k)
    from_face = _of_face(k)
    k.let(nearest, sp.Piecewise((at_face, from_face), (at_tip, True)))
    steps = (
        *heading(2 * pi * q.index / VERTICES),
        *k.steps,
        *slopes(nearest, k),
        *(
            let(name, sp.Piecewise((centre + fillet * normal, from_face), (end - (nearest - fillet) * normal, True)))
            for name, centre, end, normal in zip(POINT, (f_x, f_y), (t_x, t_y), NORMAL, strict=True)
        ),
    )
    contact(f, "tooth", (q.index, TOOTH), steps, nearest - fillet, OPENING, (slip(NORMAL, POINT),))


def _face() -> tuple[Let, Let]:
    """Direction and length of a tooth's faces: their lines pass the centroid at the shaft's apothem."""
    length = sp.Dummy("length")
    ends = sp.solve((tip + length * cos(face)) ** 2 + (length * sin(face)) ** 2 - root**2, length)
    return (
        let(face, sp.asin(sp.Min(face_sine(tip, apothem), S.One))),
        let(reach, next(end for end in ends if end.subs({tip: 1, root: 2, face: 1}) > 0)),
    )


def _of_tip(k: Followed) -> None:
    """Distance of the tip from the side of the inner hexagon that it stands over, or from that side's end."""
    sector = 2 * HALF_SIDE
    k.let(side, sector * Turns(sp.atan2(t_y, t_x) / sector) + HALF_SIDE)
    over = vec(SHAFT, t_x, t_y).resolved(Frame("side", SHAFT, Z, side))
    k.let(out, over[0] - inner)
    k.let(beside, over[1])
    k.let(past, sp.Abs(beside) - inner * sp.tan(HALF_SIDE))
    k.let(at_tip, switch(-past, out, sqrt(out**2 + past**2)))


def _of_face(k: Followed) -> sp.Basic:
    """Distance of the next fillet centre from the face that is nearer to it, and when that is the least distance."""
    sector = 2 * HALF_SIDE
    k.let(corner, sector * Turns(sp.atan2(t_y, t_x) / sector + S.Half))
    centre = radial(inner / cos(HALF_SIDE), corner)
    k.let(f_x, centre[0])
    k.let(f_y, centre[1])
    seen = vec(SHAFT, f_x - t_x, f_y - t_y).resolved(Frame("tooth", SHAFT, Z, q.heading))
    k.let(w_x, seen[0])
    k.let(w_y, seen[1])
    surface = Frame("face", SHAFT, Z, face)
    on_face = Vec(SHAFT, (w_x, sp.Abs(w_y), S.Zero)).resolved(surface)
    k.let(along, on_face[0])
    k.let(at_face, on_face[1])
    return sp.And(sp.Gt(along, 0), sp.Lt(along, reach), sp.Lt(at_face, at_tip))


def side_of_hole(f: Formulas) -> None:
    """The outline against one side of the tapered hole: their distance in the section, seen along their normal."""
    k = Followed((q.c_x, q.c_y, q.heading, q.way))
    k.let(outwards, HALF_SIDE * (2 * q.index + 1))
    k.let(rotor.VERTICES, sp.Integer(VERTICES))
    k.let(rotor.SIDES, sp.Integer(SIDES))
    k.let(rotor.PSI, outwards - q.heading)
    for step in rotor.support_steps():
        k.let(step.symbol, step.expr, step.source.removeprefix("derived: "))
    normal = radial(S.One, outwards)
    k.let(room, hole + (travel - q.way) * sp.tan(taper))
    k.let(apart, room - rotor.SUPPORT - normal.dot(vec(SHAFT, q.c_x, q.c_y)))
    tangent = radial(S.One, outwards + pi / 2)
    touching = rotor.SUPPORT * normal + k.along(rotor.SUPPORT, q.heading) * -tangent
    steps = (
        *heading(),
        *k.steps,
        *slopes(apart, k),
        *(let(name, centre + touching[i]) for i, (name, centre) in enumerate(zip(POINT, (q.c_x, q.c_y), strict=True))),
    )
    rate = (OPENING + k.along(apart, q.way) * q.way_dot) * cos(taper)
    contact(f, "side", (q.index, HOLE), steps, apart * cos(taper), rate, (slip(NORMAL, POINT), q.way_dot))


def clear(f: Formulas) -> None:
    """Where a tip rests on a rounded corner, the root opposite to a corner must clear what that lifts the body by."""
    high = (apothem - fillet) / cos(HALF_SIDE) + fillet
    lifted = high - tip
    f.function("clear", (TOOTH,), let(least_root, high + lifted), told="clearance")


def seen(f: Formulas) -> None:
    """Where the body is as the turning, deflected shaft sees it."""
    f.function("seen", (q.PLACES,), *heading(), told="view")


def section(f: Formulas) -> None:
    """Half the angle that a tooth takes at its root, and the sleeve's hole where the sleeve is."""
    at_root = Vec(Frame("face", SHAFT, Z, face), (reach, S.Zero, S.Zero)).resolved(SHAFT) + vec(SHAFT, tip, S.Zero)
    steps = (
        *_face(),
        let(half_tooth, sp.atan2(at_root[1], at_root[0])),
        let(room, hole + (travel - q.way) * sp.tan(taper)),
    )
    f.function("section", (TOOTH, HOLE, q.way), *steps, gives=(half_tooth, room), told="drawn")


def build_reuleaux_system() -> System:
    """The contacts that the Reuleaux clutch has beside those of both clutches."""
    title = "Reuleaux clutch in contact: teeth on the shaft, outline in the sleeve"
    source = "derived (distances, virtual work); law of Hunt and Crossley 1975"
    f = Formulas("clutch_contact_reuleaux", title=title, source=source, assumptions=REULEAUX_ASSUMPTIONS)
    for part in (tooth, side_of_hole, clear, seen, section):
        part(f)
    return f.system()


SYSTEMS = (
    build_dog_system,
    build_reuleaux_system,
)
