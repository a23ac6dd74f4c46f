"""Contacts of the dog clutch: a jaw against the nearest one opposite, and the driving half in its fit.

Jaws meet in the plane of circumference and axis. One is a point to the other, grown by the first: parallel flanks along
the axis, rounded edges.
"""

from __future__ import annotations

import sympy as sp
from sympy import S, pi, sqrt

from ....branches import Turns
from ....formulas import Formulas
from ....mechanics.frames import Frame, Vec, Y, Z, displacement, unit
from ....mechanics.slopes import Followed
from ....model import System, let
from ....quantity import Vector
from . import quantities as q
from .bodies import BODY, OVER_INPUT, SHAFT, WORLD, O, contact, heading, opening, vec
from .quantities import found, given

ASSUMPTIONS = (
    "dog clutch: parallel flanks along the axis, rounded edges, all jaws alike, meeting at contact_radius_mm; its "
    "driving half sits in a fit on its shaft and moves with the sleeve, with the body's mass",
)
jaws = given("jaws", "1", "jaws of each half")
radius = given("radius", "m", "radius on which jaws meet")
backlash = given("backlash", "m", "backlash of the jaws along the circumference")
edge = given("edge", "m", "edge radii of two jaws that meet, added")
depth = given("depth", "m", "overlap of the jaws along the axis when engaged")
JAW = Vector("jaw_shape", (jaws, radius, backlash, edge, depth))
room = given("fit", "m", "radial clearance of the driving half on its shaft")
core = given("core", "m", "length that keeps the direction of no eccentricity defined")

pitch = found("pitch", "rad", "angle from jaw to jaw")
offset = found("offset", "m", "middle of the jaw from that of the nearest opposite, along the circumference")
lift = found("lift", "m", "tip faces from each other, along the axis")
over = found("over", "m", "offset beyond where the flats of the flanks would meet, edges taken off")
above = found("above", "m", "lift beyond where the flats of the tips would meet, edges taken off")
nearest = found("nearest", "m", "distance of the middles of rounded edges and flats")
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
    gap.let(nearest, sp.Piecewise((sqrt(over**2 + above**2), on_edge), (over, sp.Gt(over, above)), (above, True)))
    steps = (
        *heading(),
        *place.steps,
        let(lift, q.way - depth),
        *gap.steps,
        let(push, gap.along(nearest, offset)),
        let(hoist, gap.along(nearest, lift)),
    )
    moved = place.slopes(offset)
    passing = opening((moved[q.c_x], moved[q.c_y], moved[q.heading]))
    rate, sliding = push * passing + hoist * q.way_dot, push * q.way_dot - hoist * passing
    contact(f, "jaw", (q.index, JAW), steps, nearest - edge, rate, (sliding,))


def fit(f: Formulas) -> None:
    """The body round in the fit that centres it."""
    place = displacement(O, BODY, WORLD)
    k = Followed((q.x, q.y))
    k.let(eccentric, sqrt(place.dot(place) + core**2))
    slopes = k.slopes(eccentric)
    rate = -sp.Add(*(slopes[c] * c_dot for c, c_dot in zip((q.x, q.y), q.RATES, strict=False)))
    outwards = Vec(WORLD, (q.x / eccentric, q.y / eccentric, S.Zero))
    around = unit(WORLD, Z).cross(outwards).dot(OVER_INPUT)
    contact(f, "fit", (room, core), tuple(k.steps), room - eccentric, rate, (around, q.way_dot))


def exact() -> System:
    """The contacts that the dog clutch has beside those of both clutches."""
    title = "Dog clutch in contact: jaws on jaws, the driving half in its fit"
    source = "derived (distances, virtual work); law of Hunt and Crossley 1975"
    f = Formulas("clutch_contact_dog", title=title, source=source, assumptions=ASSUMPTIONS)
    for part in (jaw, fit):
        part(f)
    return f.system()


SYSTEMS = (exact,)
