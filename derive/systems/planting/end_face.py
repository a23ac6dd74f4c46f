"""The end-face cam as a part: the way of the roller's centre on it, its contour for a roller, unrolled and in space.

The cam stands in the carrier and the rocker swings on the planet, so the cam turns back by the cam angle. Contacts lie
in the plane of the swing, as in the rest of the model: a section of the cam at a distance from its axis passes there as
a straight cam would, and that is the unrolled contour. A cutter of the roller's size, led like it, makes the surface.
"""

from __future__ import annotations

from sympy import S

from ...mechanics import cams
from ...mechanics.frames import Motion, Vec, Y, displacement
from ...mechanics.kinematics import Kinematics
from ...model import Lane, Let, System
from ...quantity import Quantity, Vector
from ...table import NOTHING
from . import quantities as q
from .derivation import ASSUMPTIONS as DEVICE
from .derivation import B1, CARRIER, PLANET, A, Half
from .flanks import FLANK

ASSUMPTIONS = (
    *(said for said in DEVICE if said.startswith("the cam's normal")),
    "the roller is a cylinder parallel to the hinge of the rocker, and touches the cam along a line",
)


def _found(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: end-face cam")


station = _found("station", "m", "distance of a section of the cam from its axis")
slope = _found("slope", "1", "slope of the swing by the cam angle")
bend = _found("bend", "1", "second derivative of the swing by the cam angle")
along = _found("along", "m", "roller's centre along the unrolled section, seen from outside, against the cam angle")
height = _found("height", "m", "roller's centre along the axis")
centre = tuple(_found(f"centre_{a}", "m", f"roller's centre on the cam, {a}") for a in "xyz")
surface = tuple(_found(f"surface_{a}", "m", f"contact on the cam, {a}") for a in "xyz")
ROLLER = Vector("roller", (cams.reach, station))


def lane() -> Lane:
    """Contour of a section and its places on the cam, whose x lies along the planet's x' at the cam angle zero."""
    motion = Motion({q.delta: S.One, q.alpha: S.One})
    k = Kinematics("end face", NOTHING, q.delta, motion, (S.Zero, S.Zero, S.Zero), True, CARRIER)
    cam = q.delta, q.delta
    k.flank(FLANK, "rise", cam, q.delta_r, q.x_rise, q.dx_rise, (q.p_rise, q.dp_rise, q.ddp_rise))
    k.flank(FLANK, "fall", cam, q.delta_f, q.x_fall, q.dx_fall, (q.p_fall, q.dp_fall, q.ddp_fall))
    k.follow((q.theta1, slope, bend), q.H * (q.p_rise - q.p_fall))
    x, _, z = displacement(B1, Half.of("inner half", A, 1, Y).E, PLANET).components
    velocity = motion.relative_derivative(Vec(PLANET, (x, station, z)), CARRIER)
    passing = velocity[0] - motion.rate(x)
    if passing.free_symbols - {station}:
        raise ValueError("the cam does not pass through the plane of the swing at a constant pace")
    k.let(along, -x - passing * q.delta)
    k.let(height, z)
    unrolled = (-velocity[0], velocity[2])
    swing = (-x.diff(q.theta1), z.diff(q.theta1))
    bending = (motion.rate(unrolled[0]), motion.rate(unrolled[1]))
    contact = cams.contour((along, height), unrolled, bending, swing)
    places = {
        centre: (x, station, z),
        surface: (-cams.contact_x - passing * q.delta, station, cams.contact_y),
    }
    rolled = tuple(
        Let(symbol, component.xreplace({q.alpha: q.delta - q.phi}), f"derived: {symbol.meaning}")
        for symbols, place in places.items()
        for symbol, component in zip(symbols, Vec(PLANET, place).resolved(CARRIER).components, strict=True)
    )
    outputs = (q.theta1, slope, bend, along, height, *cams.CONTOUR, *centre, *surface)
    return Lane(q.delta, (q.MACHINE, ROLLER), (*k.steps, *contact, *rolled), Vector("contour", outputs))


def exact() -> System:
    """The end-face cam."""
    return System("planting_end_face", "End-face cam of the planting device", "derived (geometry)", ASSUMPTIONS, lane())


SYSTEMS = (exact,)
