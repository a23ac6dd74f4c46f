"""Contacts of the Reuleaux and the dog clutch: teeth on the shaft, outline in the sleeve; jaws, and
a centring fit.

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
from .contact_motion import (
    BODY,
    OVER_INPUT,
    SHAFT,
    WORLD,
    O,
    add_contact,
    distance_rate,
    heading_steps,
    plane_vector,
    slip_velocity,
)
from .contact_quantities import datum, derived
from .geometry import SIDES, VERTICES, face_sine

DOG_ASSUMPTIONS = (
    "dog clutch: parallel flanks along the axis, rounded edges, all jaws alike, meeting at "
    "contact_radius_mm; its "
    "driving half sits in a fit on its shaft and moves with the sleeve, with the body's mass",
)
jaws = datum("jaws", "1", "jaws of each half")
radius = datum("radius", "m", "radius on which jaws meet")
backlash = datum("backlash", "m", "backlash of the jaws along the circumference")
edge = datum("edge", "m", "edge radii of two jaws that meet, added")
depth = datum("depth", "m", "overlap of the jaws along the axis when engaged")
JAW = Vector("jaw_shape", (jaws, radius, backlash, edge, depth))
fit_clearance = datum("fit", "m", "radial clearance of the driving half on its shaft")
core = datum("core", "m", "length that regularises the direction of a zero eccentricity")

pitch = derived("pitch", "rad", "angle from jaw to jaw")
offset = derived(
    "offset",
    "m",
    "offset of the jaw's middle from that of the nearest opposite jaw, along the circumference",
)
lift = derived("lift", "m", "distance of the tip faces, along the axis")
over = derived("over", "m", "offset beyond contact of the flanks' flats, without the edge radii")
above = derived("above", "m", "lift beyond contact of the tips' flats, without the edge radii")
edge_distance = derived("nearest", "m", "distance of the middles of rounded edges and flats")
push = derived("push", "1", "slope of the distance in the offset")
hoist = derived("hoist", "1", "slope of the distance in the lift")
eccentric = derived("eccentric", "m", "eccentricity of the body in its fit")


def _add_jaw(f: Formulas) -> None:
    """Add the distance of a jaw from the rounded edge, the flank or the tip face of the opposite
    jaw.
    """
    position = Followed((q.c_x, q.c_y, q.heading))
    position.let(pitch, 2 * pi / jaws)
    at_jaw = Frame("jaw", SHAFT, Z, q.heading + pitch * q.index)
    behind = q.heading - pitch * Turns(q.heading / pitch + S.Half)
    across = unit(at_jaw, Y).resolved(SHAFT).dot(plane_vector(SHAFT, q.c_x, q.c_y))
    position.let(offset, radius * behind + across)
    gap = Followed((offset, lift))
    gap.let(over, sp.Abs(offset) - (radius * pitch - backlash) / 2 + edge)
    gap.let(above, lift + edge)
    on_edge = sp.And(sp.Gt(over, 0), sp.Gt(above, 0))
    gap.let(
        edge_distance,
        sp.Piecewise(
            (sqrt(over**2 + above**2), on_edge), (over, sp.Gt(over, above)), (above, True)
        ),
    )
    steps = (
        *heading_steps(),
        *position.steps,
        let(lift, q.way - depth),
        *gap.steps,
        let(push, gap.along(edge_distance, offset)),
        let(hoist, gap.along(edge_distance, lift)),
    )
    moved = position.slopes(offset)
    passing = distance_rate((moved[q.c_x], moved[q.c_y], moved[q.heading]))
    rate, sliding = push * passing + hoist * q.way_dot, push * q.way_dot - hoist * passing
    add_contact(f, "jaw", (q.index, JAW), steps, edge_distance - edge, rate, (sliding,))


def _add_fit(f: Formulas) -> None:
    """Add the contact of the body with the fit that centres it."""
    position = displacement(O, BODY, WORLD)
    k = Followed((q.x, q.y))
    k.let(eccentric, sqrt(position.dot(position) + core**2))
    slopes = k.slopes(eccentric)
    rate = -sp.Add(*(slopes[c] * c_dot for c, c_dot in zip((q.x, q.y), q.RATES, strict=False)))
    outwards = Vec(WORLD, (q.x / eccentric, q.y / eccentric, S.Zero))
    tangential = unit(WORLD, Z).cross(outwards).dot(OVER_INPUT)
    add_contact(
        f,
        "fit",
        (fit_clearance, core),
        tuple(k.steps),
        fit_clearance - eccentric,
        rate,
        (tangential, q.way_dot),
    )


def build_dog_system() -> System:
    """Build the model of the contacts of the dog clutch alone."""
    title = "Dog clutch in contact: jaws on jaws, the driving half in its fit"
    source = "derived (distances, virtual work); law of Hunt and Crossley 1975"
    f = Formulas("clutch_contact_dog", title=title, source=source, assumptions=DOG_ASSUMPTIONS)
    _add_jaw(f)
    _add_fit(f)
    return f.system()


REULEAUX_ASSUMPTIONS = (
    "the hole of the body is relieved behind the roots of its teeth: on the printed root circle "
    "no tooth could pass a "
    "corner of the shaft",
    "sleeve_gap_mm between polygon and hole when cut off: without it the printed teeth would "
    "overlap with the shaft",
    "an overlap of tooth and shaft is less than the fillet radius",
)
HALF_SIDE = pi / SIDES
"""Half the angle that a side subtends: from the middle of a side to its corner."""

tip = datum("tip", "m", "distance of the tooth tips from the centroid")
root = datum("root", "m", "distance of the tooth roots from the centroid")
apothem = datum("apothem", "m", "half the distance between opposite flats of the shaft")
fillet = datum("fillet", "m", "fillet radius on the corners of the shaft")
TOOTH = Vector("tooth_shape", (tip, root, apothem, fillet))
hole = datum(
    "hole", "m", "half the distance between opposite sides of the sleeve's hole when cut off"
)
travel = datum("travel", "m", "travel of the sleeve")
taper = datum("taper", "rad", "inclination of the tapered contact surface to the axis")
HOLE = Vector("hole_shape", (rotor.WIDTH, hole, travel, taper))

inner = derived(
    "inner", "m", "distance of the sides of the hexagon of the fillet centres from its centre"
)
face = derived("face", "rad", "angle between a tooth's axis and either face")
reach = derived("reach", "m", "length of a face, from tip to root")
t_x, t_y = (derived(f"t_{a}", "m", f"tip in the turning shaft's frame, {a}") for a in "xy")
side = derived("side", "rad", "direction of the middle of the side next to the tip")
corner = derived("corner", "rad", "direction of the corner next to the tip")
normal_offset, lateral_offset = (
    derived("out", "m", "normal distance of the tip from that side"),
    derived("beside", "m", "lateral distance of the tip from the middle of that side"),
)
past = derived("past", "m", "distance of the tip beyond the end of that side")
at_tip = derived("at_tip", "m", "distance of the tip from the hexagon of the fillet centres")
f_x, f_y = (derived(f"f_{a}", "m", f"fillet centre next to the tip, {a}") for a in "xy")
w_x, w_y = (
    derived(f"w_{a}", "m", f"fillet centre from the tip, in the tooth's frame, {a}") for a in "xy"
)
along_face = derived("along", "m", "fillet centre along the nearer face, from the tip")
at_face = derived("at_face", "m", "distance of that fillet centre from the nearer face")
nearest = derived("nearest", "m", "distance of tooth and hexagon of the fillet centres")
outwards = derived("outwards", "rad", "direction of the normal of a side of the hole")
side_distance = derived("apart", "m", "distance of outline and side in the section")
room = derived(
    "room", "m", "half the distance between opposite sides of the hole at the sleeve's position"
)
half_tooth = derived("half_tooth", "rad", "half the angle of a tooth at its root")
least_root = derived(
    "least_root", "m", "smallest root radius with which teeth pass the corners of the shaft"
)


def _slope_steps(distance: Quantity, followed: Followed) -> tuple[Let, ...]:
    """Return the slopes of a distance in the body's centre and direction."""
    pairs = zip((q.normal_x, q.normal_y, q.lever), (q.c_x, q.c_y, q.heading), strict=True)
    return tuple(let(name, followed.along(distance, coordinate)) for name, coordinate in pairs)


NORMAL = q.normal_x, q.normal_y
POINT = q.point_x, q.point_y
OPENING = distance_rate((*NORMAL, q.lever))


def _polar_vector(distance: Expr, direction: Expr) -> Vec:
    """Return a vector from its length and direction, in the shaft's frame."""
    return plane_vector(Frame("radius", SHAFT, Z, direction), distance, S.Zero).resolved(SHAFT)


def _add_tooth(f: Formulas) -> None:
    """Add the distance of a tooth from the shaft: of its tip, or of one of its faces from a
    fillet.
    """
    k = Followed((q.c_x, q.c_y, q.heading))
    k.let(inner, apothem - fillet)
    for step in _face():
        k.let(step.symbol, step.expr)
    at_tooth = _polar_vector(tip, q.heading)
    k.let(t_x, q.c_x + at_tooth[0])
    k.let(t_y, q.c_y + at_tooth[1])
    _add_tip_distance(k)
    from_face = _add_face_distance(k)
    k.let(nearest, sp.Piecewise((at_face, from_face), (at_tip, True)))
    steps = (
        *heading_steps(2 * pi * q.index / VERTICES),
        *k.steps,
        *_slope_steps(nearest, k),
        *(
            let(
                name,
                sp.Piecewise(
                    (centre + fillet * normal, from_face), (end - (nearest - fillet) * normal, True)
                ),
            )
            for name, centre, end, normal in zip(POINT, (f_x, f_y), (t_x, t_y), NORMAL, strict=True)
        ),
    )
    add_contact(
        f,
        "tooth",
        (q.index, TOOTH),
        steps,
        nearest - fillet,
        OPENING,
        (slip_velocity(NORMAL, POINT),),
    )


def _face() -> tuple[Let, Let]:
    """Return direction and length of a tooth's faces: their lines are the shaft's apothem from the
    centroid.
    """
    length = sp.Dummy("length")
    ends = sp.solve((tip + length * cos(face)) ** 2 + (length * sin(face)) ** 2 - root**2, length)
    return (
        let(face, sp.asin(sp.Min(face_sine(tip, apothem), S.One))),
        let(reach, next(end for end in ends if end.subs({tip: 1, root: 2, face: 1}) > 0)),
    )


def _add_tip_distance(k: Followed) -> None:
    """Add the distance of the tip from the side of the inner hexagon opposite to it, or from that
    side's end.
    """
    sector = 2 * HALF_SIDE
    k.let(side, sector * Turns(sp.atan2(t_y, t_x) / sector) + HALF_SIDE)
    over = plane_vector(SHAFT, t_x, t_y).resolved(Frame("side", SHAFT, Z, side))
    k.let(normal_offset, over[0] - inner)
    k.let(lateral_offset, over[1])
    k.let(past, sp.Abs(lateral_offset) - inner * sp.tan(HALF_SIDE))
    k.let(at_tip, switch(-past, normal_offset, sqrt(normal_offset**2 + past**2)))


def _add_face_distance(k: Followed) -> sp.Basic:
    """Add the distance of the next fillet centre from the nearer face, and return when it is the
    smallest one.
    """
    sector = 2 * HALF_SIDE
    k.let(corner, sector * Turns(sp.atan2(t_y, t_x) / sector + S.Half))
    centre = _polar_vector(inner / cos(HALF_SIDE), corner)
    k.let(f_x, centre[0])
    k.let(f_y, centre[1])
    seen = plane_vector(SHAFT, f_x - t_x, f_y - t_y).resolved(Frame("tooth", SHAFT, Z, q.heading))
    k.let(w_x, seen[0])
    k.let(w_y, seen[1])
    surface = Frame("face", SHAFT, Z, face)
    on_face = Vec(SHAFT, (w_x, sp.Abs(w_y), S.Zero)).resolved(surface)
    k.let(along_face, on_face[0])
    k.let(at_face, on_face[1])
    return sp.And(sp.Gt(along_face, 0), sp.Lt(along_face, reach), sp.Lt(at_face, at_tip))


def _add_hole_side(f: Formulas) -> None:
    """Add the contact of the outline with a side of the tapered hole: their distance in the
    section, on the normal.
    """
    k = Followed(q.TABLE.select("c_x c_y heading way"))
    k.let(outwards, HALF_SIDE * (2 * q.index + 1))
    k.let(rotor.VERTICES, sp.Integer(VERTICES))
    k.let(rotor.SIDES, sp.Integer(SIDES))
    k.let(rotor.PSI, outwards - q.heading)
    for step in rotor.support_steps():
        k.let(step.symbol, step.expr, step.source.removeprefix("derived: "))
    normal = _polar_vector(S.One, outwards)
    k.let(room, hole + (travel - q.way) * sp.tan(taper))
    k.let(side_distance, room - rotor.SUPPORT - normal.dot(plane_vector(SHAFT, q.c_x, q.c_y)))
    tangent = _polar_vector(S.One, outwards + pi / 2)
    touching = rotor.SUPPORT * normal + k.along(rotor.SUPPORT, q.heading) * -tangent
    steps = (
        *heading_steps(),
        *k.steps,
        *_slope_steps(side_distance, k),
        *(
            let(name, centre + touching[i])
            for i, (name, centre) in enumerate(zip(POINT, (q.c_x, q.c_y), strict=True))
        ),
    )
    rate = (OPENING + k.along(side_distance, q.way) * q.way_dot) * cos(taper)
    add_contact(
        f,
        "side",
        (q.index, HOLE),
        steps,
        side_distance * cos(taper),
        rate,
        (slip_velocity(NORMAL, POINT), q.way_dot),
    )


def _add_root_clearance(f: Formulas) -> None:
    """Add the smallest root radius: a tip on a rounded corner lifts the body towards the opposite
    root.
    """
    high = (apothem - fillet) / cos(HALF_SIDE) + fillet
    lifted = high - tip
    f.function("clear", (TOOTH,), let(least_root, high + lifted), told="clearance")


def _add_body_position(f: Formulas) -> None:
    """Add the position of the body in the frame of the turning, deflected shaft."""
    f.function("seen", (q.PLACES,), *heading_steps(), told="view")


def _add_section(f: Formulas) -> None:
    """Add half the angle of a tooth at its root, and the size of the sleeve's hole at the sleeve's
    position.
    """
    at_root = Vec(Frame("face", SHAFT, Z, face), (reach, S.Zero, S.Zero)).resolved(
        SHAFT
    ) + plane_vector(SHAFT, tip, S.Zero)
    steps = (
        *_face(),
        let(half_tooth, sp.atan2(at_root[1], at_root[0])),
        let(room, hole + (travel - q.way) * sp.tan(taper)),
    )
    f.function("section", (TOOTH, HOLE, q.way), *steps, gives=(half_tooth, room), told="drawn")


def build_reuleaux_system() -> System:
    """Build the model of the contacts of the Reuleaux clutch alone."""
    title = "Reuleaux clutch in contact: teeth on the shaft, outline in the sleeve"
    source = "derived (distances, virtual work); law of Hunt and Crossley 1975"
    f = Formulas(
        "clutch_contact_reuleaux", title=title, source=source, assumptions=REULEAUX_ASSUMPTIONS
    )
    for add_function in (
        _add_tooth,
        _add_hole_side,
        _add_root_clearance,
        _add_body_position,
        _add_section,
    ):
        add_function(f)
    return f.system()


SYSTEMS = (
    build_dog_system,
    build_reuleaux_system,
)
