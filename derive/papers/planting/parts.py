"""Parts of the planting device: the pressure angle and the contour of its end-face cam, and the
nozzle in the soil.

The cam is fixed in the carrier and the rocker swings on the planet, so that the cam turns back by
the cam angle. Contacts lie in the plane of the swing, as in the rest of the model: a section of the
cam at a distance from its axis passes there as a straight cam would, and that is the unrolled
contour. A cutter of the roller's size on the roller's path produces the surface.
"""

from __future__ import annotations

from functools import partial

import sympy as sp
from sympy import S, pi, sqrt

from ...formulas import Formulas
from ...mechanics import contacts as cams
from ...mechanics.frames import Frame, Motion, Vec, X, Y, displacement, unit
from ...mechanics.kinematics import Kinematics
from ...model import ClosedForm, Lane, Let, System, let, let_all
from ...quantity import NOTHING, Quantity, Vector, read_quantities
from . import quantities as q
from .derivation import ASSUMPTIONS as DEVICE
from .derivation import B1, CARRIER, PLANET, WORLD, A, Half, add_flanks

CAM_ASSUMPTIONS = (
    "the cam's normal lies in the plane of the swing, as on a cylindrical roller parallel to the "
    "hinge",
)
t = read_quantities(
    """
derived: cam
pressure | rad | pressure angle of the cam: from the roller's path in its swing to the cam's normal

derived: end-face cam
station | m | distance of a section of the cam from its axis
slope | 1 | slope of the swing by the cam angle
bend | 1 | second derivative of the swing by the cam angle
along | m | roller's centre along the unrolled section, seen from outside, against the cam angle
height | m | roller's centre along the axis

derived: nozzle
tilt | rad | angle of the nozzle's axis from the vertical
soil | m | level of the soil
cut | m | ground coordinate at which the nozzle's axis crosses that level
plant | m | ground coordinate of the plant
top | m | height of the top of the plant
hair | m | length that regularises the slope of the distance at zero
length | m | length of a half, from hinge to tip
root_x | m | hinge on the nozzle's axis, x
root_y | m | hinge on the nozzle's axis, y
along_x | 1 | direction of the open half, x
along_y | 1 | direction of the open half, y
along_z | 1 | direction of the open half, z
nearest | m | distance from the hinge to the point of the half's line that is closest to the plant
lowest | m | distance from the hinge beyond which the half is lower than the plant's top
place | m | distance from the hinge to the closest point below the plant's top
clearance | m | horizontal distance of the half from the plant
"""
)
"""Quantities of this module."""


def pressure_angle() -> ClosedForm:
    """Return the angle between the roller's path in the planet's frame and the normal of its path
    in the carrier's.
    """
    motion = Motion({q.phi: q.omega, q.alpha: -q.Omega, q.theta1: q.theta1_dot})
    arm = displacement(B1, Half.build("inner half", A, 1, Y).E, PLANET)
    across = unit(PLANET, Y)
    seen = motion.relative_derivative(arm, CARRIER)
    normal = (seen - seen.dot(across) * across).cross(across)
    way = Vec(PLANET, tuple(c.diff(q.theta1) for c in arm.components))
    steep = sp.atan2(normal.cross(way).dot(across), sp.Abs(normal.dot(way)))
    inputs = (q.theta1, q.theta1_dot, q.Omega, q.MACHINE)
    return ClosedForm(
        "cam", inputs, (Let(t.pressure, steep, "derived: cam"),), Vector("steepness", (t.pressure,))
    )


def build_cam_angle_system() -> System:
    """Build the model of the cam's pressure angle."""
    return System(
        "planting_cam",
        "Pressure angle of the cam of the planting device",
        "derived (geometry)",
        CAM_ASSUMPTIONS,
        closed_forms=(pressure_angle(),),
    )


END_FACE_ASSUMPTIONS = (
    *(assumption for assumption in DEVICE if assumption.startswith("the cam's normal")),
    "the roller is a cylinder parallel to the hinge of the rocker, and touches the cam along a line",
)


_cam = partial(Quantity, source="derived: end-face cam")


centre = tuple(_cam(f"centre_{a}", "m", f"roller's centre on the cam, {a}") for a in "xyz")
surface = tuple(_cam(f"surface_{a}", "m", f"contact on the cam, {a}") for a in "xyz")
ROLLER = Vector("roller", (cams.reach, t.station))


def contour_lane() -> Lane:
    """Return contour and points of a section of the cam, whose x is the planet's x' at the cam
    angle zero.
    """
    motion = Motion({q.delta: S.One, q.alpha: S.One})
    k = Kinematics("end face", NOTHING, q.delta, motion, (S.Zero, S.Zero, S.Zero), True, CARRIER)
    k.follow((q.theta1, t.slope, t.bend), add_flanks(k, q.delta))
    x, _, z = displacement(B1, Half.build("inner half", A, 1, Y).E, PLANET).components
    velocity = motion.relative_derivative(Vec(PLANET, (x, t.station, z)), CARRIER)
    passing = velocity[0] - motion.rate(x)
    if passing.free_symbols - {t.station}:
        raise ValueError("the cam does not pass through the plane of the swing at a constant rate")
    k.let(t.along, -x - passing * q.delta)
    k.let(t.height, z)
    unrolled = (-velocity[0], velocity[2])
    swing = (-x.diff(q.theta1), z.diff(q.theta1))
    bending = (motion.rate(unrolled[0]), motion.rate(unrolled[1]))
    contact = cams.contour_steps((t.along, t.height), unrolled, bending, swing)
    places = {
        centre: (x, t.station, z),
        surface: (-cams.contact_x - passing * q.delta, t.station, cams.contact_y),
    }
    rolled = tuple(
        Let(symbol, component.xreplace({q.alpha: q.delta - q.phi}), f"derived: {symbol.meaning}")
        for symbols, place in places.items()
        for symbol, component in zip(
            symbols, Vec(PLANET, place).resolved(CARRIER).components, strict=True
        )
    )
    outputs = (q.theta1, t.slope, t.bend, t.along, t.height, *cams.CONTOUR, *centre, *surface)
    return Lane(
        q.delta, (q.MACHINE, ROLLER), (*k.steps, *contact, *rolled), Vector("contour", outputs)
    )


def build_end_face_system() -> System:
    """Build the model of the end-face cam."""
    return System(
        "planting_end_face",
        "End-face cam of the planting device",
        "derived (geometry)",
        END_FACE_ASSUMPTIONS,
        contour_lane(),
    )


NOZZLE_ASSUMPTIONS = (
    "a half of the nozzle is the line from its hinge to its tip; it swings out of the plane of "
    "the tip's path",
    "the plant is a vertical line from the ground to the top of the seedling",
)
DENOMINATOR_EPS = sp.Float("1e-30")
"""Keeps a quotient finite when the half hangs straight down."""


_nozzle = partial(Quantity, source="derived: nozzle")


def _add_axis(f: Formulas) -> None:
    """Add the tilt of the nozzle's axis, and the point at which it crosses a level."""
    distance = sp.Dummy("way")
    x, y, _ = unit(PLANET, X).resolved(WORLD).components
    (solution,) = sp.solve(q.y_tip + distance * y - t.soil, distance)
    steps = (let(t.tilt, q.alpha - pi / 2), let(t.cut, q.x_tip + solution * x))
    f.function("axis", (q.x_tip, q.y_tip, q.alpha, t.soil), *steps, told="passing")


def _add_half(f: Formulas) -> None:
    """Add the horizontal distance of a half from the plant; only the part below the plant's top is
    considered.
    """
    closed = unit(PLANET, X).resolved(WORLD)
    opened = unit(Frame("half", PLANET, Y, q.theta1), X).resolved(WORLD)
    s = sp.Dummy("s")
    gap = Vec(WORLD, (t.root_x - t.plant + s * t.along_x, S.Zero, s * t.along_z))
    square = gap.dot(gap)
    (closest,) = sp.solve(square.diff(s), s)
    numerator, denominator = sp.fraction(sp.together(closest))
    (crossing,) = sp.solve(t.root_y + s * t.along_y - t.top, s)
    steps = (
        let(t.length, q.L_tip - q.x_A),
        let(t.root_x, q.x_tip - t.length * closed[0]),
        let(t.root_y, q.y_tip - t.length * closed[1]),
        *let_all((t.along_x, t.along_y, t.along_z), opened.components),
        let(t.nearest, numerator / (denominator + DENOMINATOR_EPS)),
        let(t.lowest, sp.Min(sp.Max(crossing, S.Zero), t.length)),
        let(t.place, sp.Min(sp.Max(t.nearest, t.lowest), t.length)),
        let(t.clearance, sqrt(square.subs(s, t.place) + t.hair**2)),
    )
    inputs = (q.x_tip, q.y_tip, q.alpha, q.theta1, t.plant, t.top, t.hair, q.MACHINE)
    f.function("half", inputs, *steps, gives=(t.clearance,), told="apart")


def build_nozzle_system() -> System:
    """Build the model of the nozzle in the soil."""
    title, source = "Nozzle of the planting device in the soil", "derived (geometry)"
    f = Formulas("planting_nozzle", title=title, source=source, assumptions=NOZZLE_ASSUMPTIONS)
    _add_axis(f)
    _add_half(f)
    return f.system()


SYSTEMS = (
    build_cam_angle_system,
    build_end_face_system,
    build_nozzle_system,
)
