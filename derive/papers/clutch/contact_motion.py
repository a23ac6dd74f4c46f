"""Motion of both clutches in contact: bodies, linkage, shared contacts, equations of motion,
powers.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, sqrt

from ...formulas import Formulas
from ...functions import clip, switch
from ...mechanics.bodies import kinetic_energy
from ...mechanics.frames import Frame, Motion, Point, Vec, Z, displacement
from ...mechanics.impact import dahl, sum_of_squares
from ...mechanics.kinematics import Followed
from ...mechanics.mechanism import Mechanism
from ...model import Let, System, let, let_all
from ...quantity import Quantity, Vector, read_quantities
from . import contact_quantities as q
from . import quantities as clutch
from .contact_quantities import derived
from .motion import CRANK, MESH, crank_angle, gear_rate, pin_distance

WORLD = Frame("frame")
INPUT = Frame("input", WORLD, Z, q.angle)
"""The body turns with the input, whose slides carry it."""
SHAFT = Frame("output shaft", WORLD, Z, q.output)
O = Point("O")  # noqa: E741
BODY = Point("centre of the body", O, Vec(WORLD, (q.x, q.y, S.Zero)))
END = Point("end of the output shaft", O, Vec(WORLD, (q.shaft_x, q.shaft_y, S.Zero)))
SEEN = displacement(END, BODY, SHAFT)

MOTION = Motion(dict(zip(q.PLACES, q.RATES, strict=True)))
SEEN_RATE = MOTION.relative_derivative(displacement(END, BODY, WORLD), SHAFT).resolved(SHAFT)
"""Rate of `SEEN` in the turning shaft's frame."""
TURNING = (MOTION.spin(INPUT).resolved(WORLD) - MOTION.spin(SHAFT).resolved(WORLD))[2]
"""Rate at which the body turns against the shaft."""
OVER_INPUT = MOTION.relative_derivative(displacement(O, BODY, WORLD), INPUT)
"""Velocity of the body relative to the input."""
ON_SLIDES = MOTION.relative_derivative(displacement(O, BODY, INPUT), INPUT)
"""The same velocity in the turning input's frame."""


def plane_vector(frame: Frame, x: Expr, y: Expr) -> Vec:
    """Return a vector in the x-y plane of a frame."""
    return Vec(frame, (x, y, S.Zero))


def heading_steps(polar: Expr = S.Zero) -> tuple[Let, ...]:
    """Return the centre of the body and the direction of a radius of it, in the shaft's frame."""
    return (
        let(q.c_x, SEEN[0]),
        let(q.c_y, SEEN[1]),
        let(q.heading, q.angle - q.output + polar),
    )


def distance_rate(slopes: tuple[Expr, Expr, Expr]) -> Expr:
    """Return the rate of a distance from its slopes in the body's centre (2,) and direction, in the
    shaft's frame.
    """
    x, y, turn = slopes
    return x * SEEN_RATE[0] + y * SEEN_RATE[1] + turn * TURNING


def slip_velocity(normal: tuple[Expr, Expr], point: tuple[Expr, Expr]) -> Expr:
    """Return the velocity of the body over the shaft along the surface at a point, in the shaft's
    frame.
    """
    turning = Vec(SHAFT, (S.Zero, S.Zero, TURNING))
    over = SEEN_RATE + turning.cross(
        plane_vector(SHAFT, *point) - plane_vector(SHAFT, q.c_x, q.c_y)
    )
    tangent = Vec(SHAFT, (S.Zero, S.Zero, S.One)).cross(plane_vector(SHAFT, *normal))
    return tangent.dot(over)


def add_contact(
    f: Formulas,
    name: str,
    inputs: tuple[Vector | Quantity, ...],
    before: tuple[Let, ...],
    gap: Expr,
    rate: Expr,
    slips: tuple[Expr, ...],
) -> None:
    """Add a contact: its actions on each coordinate from positions, rates, the law and further
    ``inputs``.
    """
    output_name = f"{name}_contact"
    steps = (*before, *q.CONTACT.steps(gap, rate, slips, q.HERTZ))
    outputs = q.CONTACT.outputs(output_name).quantities
    f.function(name, (*inputs, q.PLACES, q.RATES, q.LAW), *steps, gives=outputs, told=output_name)


ASSUMPTIONS = (
    "the input turns at a constant speed and the coupling passes this rotation on exactly; its "
    "slides have no mass",
    "the body does not tilt; gravity is left out; all is rigid but the contacts, the spring and "
    "the shaft's bending",
    "the output shaft bends in one mode, the same in both directions across its axis, the contact "
    "at its end",
    "the sleeve's hexagonal hole turns and moves with the output shaft, on whose hexagon it slides",
    "the sleeve moves along the axis against a linear spring; the linkage can push it away but "
    "not pull it back",
    "the slides of the coupling hold the body where it is by friction, whose limit grows by "
    "lock_N over the last "
    "lock_travel_mm of the sleeve's way: the thrust bearing seats",
    "the load torque resists rotation and is constant in size, but fades to none at rest",
    "one law for every contact, linkage and bearing included: Hunt and Crossley's, with Coulomb "
    "friction that creeps "
    "below slip_speed_mm_s instead of sticking",
)

t = read_quantities(
    """
clutch file
t | s | time since the link began to move
link_start | rad | inclination of the link at the start of its motion
link_end | rad | inclination of the link at the end of its motion
link_speed | rad/s | magnitude of the link's rate

derived: clutch in contact
link_angle | rad | inclination of the link
turned | rad | rotation of the crank gear against the link
crank_angle | rad | angle of the crank from its guide

clutch file
body | kg | mass of the body
sleeve | kg | mass of the sleeve
inertia | kg m2 | moment of inertia of the output
shaft_mass | kg | modal mass of the output shaft's bending
shaft_stiffness | N/m | modal stiffness of the output shaft's bending
shaft_damping | N s/m | modal damping of the output shaft's bending
preload | N | preload of the sleeve's spring, engaged
spring_rate | N/m | rate of the sleeve's spring
load | N m | load torque on the output
load_speed | rad/s | speed at which the load torque has 1/sqrt(2) of its full value
slide | N | limit of the friction of the coupling's slides
lock | N | increase of the friction limit by the seated thrust bearing
lock_travel | m | last part of the sleeve's travel, over which the bearing seats
lock_stiffness | N/m | stiffness of the slides while they stick
creep | m/s | speed that smooths the friction law of the slides where sliding stops
push_x | N | additional force on the body, x; zero in all clutches
push_y | N | additional force on the body, y; zero in all clutches
damping_share | 1 | damping as a share of the critical one

derived: clutch in contact
spun | 1 | share of the load torque that acts, by the output's speed
limit | N | largest friction of the slides
energy | J | kinetic and potential energy, the contacts' included
"""
)
"""Quantities of this module."""


LINK = Vector("link", (clutch.k, clutch.gamma, t.link_start, t.link_end, t.link_speed))


MASSES = Vector("masses", t.select("body sleeve inertia shaft_mass"))
SPRINGS = Vector("springs", t.select("shaft_stiffness shaft_damping preload spring_rate"))
LOADS = Vector("loads", t.select("load load_speed push_x push_y"))
SLIDES = Vector("slides", t.select("slide lock lock_travel lock_stiffness creep"))


BENT = tuple(
    derived(f"bent_{axis}", "m", f"bend of the slides' bristles, {axis} of the input")
    for axis in "xy"
)
BENT_RATES = tuple(derived(f"{b.name}_dot", "m/s", f"rate: {b.meaning}") for b in BENT)
BRISTLES = Vector("bristles", BENT)
SUMS = Vector("sums", (*q.FORCES, q.stored, q.damped, q.rubbed))
"""Sums over all contacts."""


SLIDE_FORCE = tuple(
    derived(f"held_{axis}", "N", f"force of the slides on the body, {axis}") for axis in "xy"
)
ACCELERATIONS = tuple(
    derived(f"{c}_ddot", f"{c.unit}/s2", f"acceleration: {c.meaning}")
    for c in q.COORDINATES[: q.FREE]
)

POWERS = tuple(
    derived(f"power_{name}", "W", meaning)
    for name, meaning in (
        ("input", "power of the input's drive, and of the additional force on the body"),
        ("linkage", "power of the linkage"),
        ("load", "power absorbed by the load"),
        ("damping", "power lost in contacts along their normals"),
        ("friction", "power lost to friction in contacts"),
        ("slides", "power lost in the slides"),
        ("shaft", "power lost in the shaft's bending"),
    )
)


def _add_course(f: Formulas) -> None:
    """Add the displacement by the linkage: the link turns at a constant rate from start to end,
    then it rests.

    The crank gear rolls on the fixed rack from the start of mesh; the crank slider moves the pin
    along its guide.
    """
    k = Followed((t.t,))
    span = t.link_end - t.link_start
    k.let(
        t.link_angle, t.link_start + span * clip(t.t * t.link_speed / sp.Abs(span), S.Zero, S.One)
    )
    lift = t.link_angle - MESH
    k.let(t.turned, switch(lift, (gear_rate() - 1) * lift, S.Zero), "crank gear rolls on the rack")
    k.let(t.crank_angle, crank_angle(clutch.l_AC) - t.turned)
    k.let(q.pushed, pin_distance(t.crank_angle) - clutch.l_AC, "the loop A-B-C closes")
    rate = let(q.pushed_dot, k.along(q.pushed, t.t))
    outputs = (t.link_angle, q.pushed, q.pushed_dot)
    f.function("course", (t.t, CRANK, LINK), *k.steps, rate, gives=outputs, told="course")


def _add_bearing(f: Formulas) -> None:
    """Add the thrust bearing on the face of the coupling: it limits the sleeve's travel and brakes
    the slides.
    """
    add_contact(f, "bearing", (), (), q.way, q.way_dot, (OVER_INPUT[0], OVER_INPUT[1]))


def _add_linkage(f: Formulas) -> None:
    """Add the contact by which the linkage pushes the sleeve away; the spring returns it."""
    add_contact(f, "linkage", (), (), q.way - q.pushed, q.way_dot - q.pushed_dot, ())


def build_mechanism() -> Mechanism:
    """Build the freely moving bodies with all actions; there is no gravity, and the body turns with
    the input.
    """
    m = Mechanism("clutch_motion", spatial=True, world=WORLD)
    for symbols in zip(q.PLACES, q.RATES, ACCELERATIONS, strict=False):
        m.follow(symbols)
    m.motion.rates |= {q.angle: q.angle_dot, q.pushed: q.pushed_dot}
    on_x, on_y, on_way, on_output, on_shaft_x, on_shaft_y, *_ = q.FORCES
    at = m.point("centre of the sleeve", O, WORLD, z=q.way)
    deflection, way = displacement(O, END, WORLD), sp.Dummy("way")
    spring = sp.integrate(t.preload + t.spring_rate * way, (way, 0, q.way))
    bent = t.shaft_stiffness * deflection.dot(deflection) / 2
    m.potentials += [spring, bent]

    half = m.body("body", INPUT, t.body, BODY)
    ring = m.body("sleeve", WORLD, t.sleeve, at)
    shaft = m.body("output shaft", SHAFT, t.shaft_mass, END, t.inertia)
    m.force("contacts of the body", half, BODY, m.vector(WORLD, on_x + t.push_x, on_y + t.push_y))
    m.force("slides", half, BODY, m.vector(WORLD, *SLIDE_FORCE))
    m.force(
        "contacts and spring of the sleeve",
        ring,
        at,
        m.vector(WORLD, z=on_way - spring.diff(q.way)),
    )
    m.torque("contacts and load", shaft, m.ground, on_output - t.load * t.spun)
    m.force("contacts of the shaft", shaft, END, m.vector(WORLD, on_shaft_x, on_shaft_y))
    m.force(
        "bending", shaft, END, -m.vector(WORLD, *(bent.diff(s) for s in (q.shaft_x, q.shaft_y)))
    )
    m.force("damping", shaft, END, -t.shaft_damping * m.velocity(END))
    return m


def _add_motion(f: Formulas) -> None:
    """Add accelerations, rates of the bristles, powers and energy, from the sums over all
    contacts.
    """
    sliding, bent = ON_SLIDES.components[:2], Vec(INPUT, (*BENT, S.Zero))
    bristle_rates, lost = dahl(sliding, BENT, t.lock_stiffness, t.limit, t.creep)
    slide_force = (-t.lock_stiffness * bent).resolved(WORLD)
    seated = clip(1 - q.way / t.lock_travel, S.Zero, S.One)
    m = build_mechanism()
    bending = m.velocity(END)
    powers = _powers(lost, t.shaft_damping * bending.dot(bending))
    in_springs = sp.Add(*m.potentials) + t.lock_stiffness * sum_of_squares(BENT) / 2 + q.stored
    steps = (
        let(t.spun, q.output_dot / sqrt(q.output_dot**2 + t.load_speed**2)),
        let(t.limit, t.slide + t.lock * seated),
        *(
            let(name, component)
            for name, component in zip(SLIDE_FORCE, slide_force.components, strict=False)
        ),
        *let_all(ACCELERATIONS, m.accelerations(), "Lagrange's equation"),
        *let_all(BENT_RATES, bristle_rates, "Dahl's bristles"),
        *let_all(POWERS, powers),
        let(t.energy, kinetic_energy(m.motion, m.bodies, WORLD) + in_springs),
    )
    outputs = (*ACCELERATIONS, *BENT_RATES, *POWERS, t.energy)
    inputs = (q.PLACES, q.RATES, BRISTLES, SUMS, MASSES, SPRINGS, LOADS, SLIDES)
    f.function("motion", inputs, *steps, gives=outputs, told="motion")


def _powers(lost: Expr, damped: Expr) -> tuple[Expr, ...]:
    """Return the powers in the order of `POWERS`; the drive of a coordinate supplies the power that
    contacts absorb.
    """
    carried = MOTION.derivative(displacement(O, BODY, WORLD)) - OVER_INPUT
    transmitted = Vec(WORLD, (*SLIDE_FORCE, S.Zero)).dot(carried)
    pushed = t.push_x * q.RATES.quantities[0] + t.push_y * q.RATES.quantities[1]
    on_angle, on_pushed = q.FORCES.quantities[q.FREE :]
    return (
        -on_angle * q.angle_dot + transmitted + pushed,
        -on_pushed * q.pushed_dot,
        t.load * t.spun * q.output_dot,
        q.damped,
        q.rubbed,
        lost,
        damped,
    )


def _add_damping(f: Formulas) -> None:
    """Add the damping as a share of the critical one, at which the shaft's bending is about to
    oscillate.
    """
    s, critical = sp.Dummy("s"), sp.Dummy("critical", positive=True)
    swing = sp.discriminant(t.shaft_mass * s**2 + critical * s + t.shaft_stiffness, s)
    (limit_damping,) = sp.solve(swing, critical)
    step = let(t.shaft_damping, t.damping_share * limit_damping, "damping without swing")
    f.function("damping", (t.damping_share, t.shaft_mass, t.shaft_stiffness), step, told="damped")


def build_motion_system() -> System:
    """Build the model of the motion that both clutches share."""
    title = "Clutch in contact: linkage, shared contacts, equations of motion"
    source = "derived (Lagrange, virtual work); laws of Hunt and Crossley 1975, Dahl 1976"
    f = Formulas("clutch_motion", title=title, source=source, assumptions=ASSUMPTIONS)
    for add_function in (_add_course, _add_bearing, _add_linkage, _add_motion, _add_damping):
        add_function(f)
    return f.system()


SYSTEMS = (build_motion_system,)
