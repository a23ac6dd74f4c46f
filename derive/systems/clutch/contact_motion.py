"""Motion of both clutches in contact: bodies, linkage, shared contacts, equations of motion, powers."""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, sqrt

from ...formulas import Formulas
from ...functions import clip, switch
from ...mechanics.bodies import kinetic_energy
from ...mechanics.frames import Frame, Motion, Point, Vec, Z, displacement
from ...mechanics.impact import dahl, square
from ...mechanics.kinematics import Followed
from ...mechanics.mechanism import Mechanism
from ...model import Let, System, let
from ...quantity import Quantity, Vector
from . import contact_quantities as q
from . import quantities as clutch
from .contact_quantities import found, given
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
"""Of `SEEN`, as the turning shaft sees it."""
TURNING = (MOTION.spin(INPUT).resolved(WORLD) - MOTION.spin(SHAFT).resolved(WORLD))[2]
"""Rate at which the body turns against the shaft."""
OVER_INPUT = MOTION.relative_derivative(displacement(O, BODY, WORLD), INPUT)
"""Velocity of the body over what turns with the input."""
ON_SLIDES = MOTION.relative_derivative(displacement(O, BODY, INPUT), INPUT)
"""The same as the turning input sees it."""


def vec(frame: Frame, x: Expr, y: Expr) -> Vec:
    return Vec(frame, (x, y, S.Zero))


def heading(polar: Expr = S.Zero) -> tuple[Let, ...]:
    """Centre of the body and direction of a radius of it, as the shaft sees them."""
    return (
        let(q.c_x, SEEN[0]),
        let(q.c_y, SEEN[1]),
        let(q.heading, q.angle - q.output + polar),
    )


def opening(slopes: tuple[Expr, Expr, Expr]) -> Expr:
    """Rate of a distance from its slopes in what the shaft sees of the body: centre (2,) and direction."""
    x, y, turn = slopes
    return x * SEEN_RATE[0] + y * SEEN_RATE[1] + turn * TURNING


def slip(normal: tuple[Expr, Expr], point: tuple[Expr, Expr]) -> Expr:
    """Velocity of the body over the shaft along the surface at a point, all as the shaft sees it."""
    turning = Vec(SHAFT, (S.Zero, S.Zero, TURNING))
    over = SEEN_RATE + turning.cross(vec(SHAFT, *point) - vec(SHAFT, q.c_x, q.c_y))
    along = Vec(SHAFT, (S.Zero, S.Zero, S.One)).cross(vec(SHAFT, *normal))
    return along.dot(over)


def contact(
    f: Formulas,
    name: str,
    inputs: tuple[Vector | Quantity, ...],
    before: tuple[Let, ...],
    gap: Expr,
    rate: Expr,
    slips: tuple[Expr, ...],
) -> None:
    """A contact as a function of places, rates, the law and its own ``inputs``: what it does to each coordinate."""
    told = f"{name}_contact"
    steps = (*before, *q.CONTACT.steps(gap, rate, slips, q.HERTZ))
    given = q.CONTACT.outputs(told).quantities
    f.function(name, (*inputs, q.PLACES, q.RATES, q.LAW), *steps, gives=given, told=told)


ASSUMPTIONS = (
    "the input turns at a constant speed and the coupling passes this rotation on exactly; its slides have no mass",
    "the body does not tilt; gravity is left out; all is rigid but the contacts, the spring and the shaft's bending",
    "the output shaft bends in one mode, the same in both directions across its axis, the contact at its end",
    "the sleeve's hexagonal hole turns and moves with the output shaft, on whose hexagon it slides",
    "the sleeve moves along the axis against a linear spring; the linkage can push it away but not pull it back",
    "the slides of the coupling hold the body where it is by friction, whose limit grows by lock_N over the last "
    "lock_travel_mm of the sleeve's way: the thrust bearing seats",
    "the load torque resists rotation and is constant in size, but fades to none at rest",
    "one law for every contact, linkage and bearing included: Hunt and Crossley's, with Coulomb friction that creeps "
    "below slip_speed_mm_s instead of sticking",
)

time = given("t", "s", "time since the link began to move")
link_start = given("link_start", "rad", "inclination of the link at the start of its course")
link_end = given("link_end", "rad", "inclination of the link at the end of its course")
link_speed = given("link_speed", "rad/s", "size of the rate at which the link moves")
LINK = Vector("link", (clutch.k, clutch.gamma, link_start, link_end, link_speed))
link_angle = found("link_angle", "rad", "inclination of the link")
turned = found("turned", "rad", "rotation of the crank gear against the link")
crank = found("crank_angle", "rad", "angle of the crank from its guide")

body = given("body", "kg", "mass of the body")
sleeve = given("sleeve", "kg", "mass of the sleeve")
inertia = given("inertia", "kg m2", "moment of inertia of the output")
shaft_mass = given("shaft_mass", "kg", "modal mass of the output shaft's bending")
shaft_stiffness = given("shaft_stiffness", "N/m", "modal stiffness of the output shaft's bending")
shaft_damping = given("shaft_damping", "N s/m", "modal damping of the output shaft's bending")
preload = given("preload", "N", "preload of the sleeve's spring, engaged")
spring_rate = given("spring_rate", "N/m", "rate of the sleeve's spring")
load = given("load", "N m", "load torque on the output")
load_speed = given("load_speed", "rad/s", "speed at which the load torque has 1/sqrt(2) of its size")
slide = given("slide", "N", "limit of the friction of the coupling's slides")
lock = given("lock", "N", "what the seated thrust bearing adds to it")
lock_travel = given("lock_travel", "m", "last part of the sleeve's way, over which the bearing seats")
lock_stiffness = given("lock_stiffness", "N/m", "stiffness of the slides while they hold")
creep = given("creep", "m/s", "speed that keeps the law of the slides smooth where sliding stops")
push_x = given("push_x", "N", "force on the body, x; no clutch has it")
push_y = given("push_y", "N", "force on the body, y; no clutch has it")
MASSES = Vector("masses", (body, sleeve, inertia, shaft_mass))
SPRINGS = Vector("springs", (shaft_stiffness, shaft_damping, preload, spring_rate))
LOADS = Vector("loads", (load, load_speed, push_x, push_y))
SLIDES = Vector("slides", (slide, lock, lock_travel, lock_stiffness, creep))
damping_share = given("damping_share", "1", "damping as a share of the critical one")

BENT = tuple(found(f"bent_{axis}", "m", f"bend of the slides' bristles, {axis} of the input") for axis in "xy")
BENT_RATES = tuple(found(f"{b.name}_dot", "m/s", f"rate: {b.meaning}") for b in BENT)
BRISTLES = Vector("bristles", BENT)
SUMS = Vector("sums", (*q.FORCES, q.stored, q.damped, q.rubbed))
"""What all contacts do together."""
spun = found("spun", "1", "share of the load torque that acts, by the output's speed")
limit = found("limit", "N", "largest friction of the slides")
HELD = tuple(found(f"held_{axis}", "N", f"force of the slides on the body, {axis}") for axis in "xy")
ACCELERATIONS = tuple(
    found(f"{n}_ddot", f"{unit}/s2", f"acceleration: {what}") for n, unit, what in q.COORDINATES[: q.FREE]
)
energy = found("energy", "J", "kinetic and potential energy, the contacts' included")
POWERS = tuple(
    found(f"power_{name}", "W", what)
    for name, what in (
        ("input", "power of what turns the input, and of the force on the body"),
        ("linkage", "power of the linkage"),
        ("load", "power that the load takes"),
        ("damping", "power lost in contacts along their normals"),
        ("friction", "power lost to friction in contacts"),
        ("slides", "power lost in the slides"),
        ("shaft", "power lost in the shaft's bending"),
    )
)


def course(f: Formulas) -> None:
    """Where the linkage has pushed the sleeve: the link turns at a constant rate from start to end, then it rests.

    The crank gear rolls on the fixed rack from the start of mesh on; the crank slider carries the pin along its guide.
    """
    k = Followed((time,))
    span = link_end - link_start
    k.let(link_angle, link_start + span * clip(time * link_speed / sp.Abs(span), S.Zero, S.One))
    lift = link_angle - MESH
    k.let(turned, switch(lift, (gear_rate() - 1) * lift, S.Zero), "crank gear rolls on the rack")
    k.let(crank, crank_angle(clutch.l_AC) - turned)
    k.let(q.pushed, pin_distance(crank) - clutch.l_AC, "the loop A-B-C closes")
    rate = let(q.pushed_dot, k.along(q.pushed, time))
    given = (link_angle, q.pushed, q.pushed_dot)
    f.function("course", (time, CRANK, LINK), *k.steps, rate, gives=given, told="course")


def bearing(f: Formulas) -> None:
    """The thrust bearing on the face of the coupling: ends the sleeve's way, and brakes the coupling's slides."""
    contact(f, "bearing", (), (), q.way, q.way_dot, (OVER_INPUT[0], OVER_INPUT[1]))


def linkage(f: Formulas) -> None:
    """The linkage pushes the sleeve away; what brings it back is the spring."""
    contact(f, "linkage", (), (), q.way - q.pushed, q.way_dot - q.pushed_dot, ())


def mechanism() -> Mechanism:
    """What moves freely, and all that acts on it; nothing weighs, and the body keeps its rotation."""
    m = Mechanism("clutch_motion", spatial=True, world=WORLD)
    for symbols in zip(q.PLACES, q.RATES, ACCELERATIONS, strict=False):
        m.follow(symbols)
    m.motion.rates |= {q.angle: q.angle_dot, q.pushed: q.pushed_dot}
    on_x, on_y, on_way, on_output, on_shaft_x, on_shaft_y, *_ = q.FORCES
    at = m.point("centre of the sleeve", O, WORLD, z=q.way)
    place, way = displacement(O, END, WORLD), sp.Dummy("way")
    spring = sp.integrate(preload + spring_rate * way, (way, 0, q.way))
    bent = shaft_stiffness * place.dot(place) / 2
    m.potentials += [spring, bent]

    half = m.body("body", INPUT, body, BODY)
    ring = m.body("sleeve", WORLD, sleeve, at)
    shaft = m.body("output shaft", SHAFT, shaft_mass, END, inertia)
    m.force("contacts of the body", half, BODY, m.vector(WORLD, on_x + push_x, on_y + push_y))
    m.force("slides", half, BODY, m.vector(WORLD, *HELD))
    m.force("contacts and spring of the sleeve", ring, at, m.vector(WORLD, z=on_way - spring.diff(q.way)))
    m.torque("contacts and load", shaft, m.ground, on_output - load * spun)
    m.force("contacts of the shaft", shaft, END, m.vector(WORLD, on_shaft_x, on_shaft_y))
    m.force("bending", shaft, END, -m.vector(WORLD, *(bent.diff(s) for s in (q.shaft_x, q.shaft_y))))
    m.force("damping", shaft, END, -shaft_damping * m.velocity(END))
    return m


def motion(f: Formulas) -> None:
    """Accelerations, rates of the bristles, works per time and energy, from what all contacts do together."""
    sliding, bent = ON_SLIDES.components[:2], Vec(INPUT, (*BENT, S.Zero))
    bristle_rates, lost = dahl(sliding, BENT, lock_stiffness, limit, creep)
    held = (-lock_stiffness * bent).resolved(WORLD)
    seated = clip(1 - q.way / lock_travel, S.Zero, S.One)
    m = mechanism()
    bending = m.velocity(END)
    powers = _powers(lost, shaft_damping * bending.dot(bending))
    in_springs = sp.Add(*m.potentials) + lock_stiffness * square(BENT) / 2 + q.stored
    steps = (
        let(spun, q.output_dot / sqrt(q.output_dot**2 + load_speed**2)),
        let(limit, slide + lock * seated),
        *(let(name, component) for name, component in zip(HELD, held.components, strict=False)),
        *(let(name, expr, "Lagrange's equation") for name, expr in zip(ACCELERATIONS, m.accelerations(), strict=True)),
        *(let(name, expr, "Dahl's bristles") for name, expr in zip(BENT_RATES, bristle_rates, strict=True)),
        *(let(name, expr) for name, expr in zip(POWERS, powers, strict=True)),
        let(energy, kinetic_energy(m.motion, m.bodies, WORLD) + in_springs),
    )
    given = (*ACCELERATIONS, *BENT_RATES, *POWERS, energy)
    inputs = (q.PLACES, q.RATES, BRISTLES, SUMS, MASSES, SPRINGS, LOADS, SLIDES)
    f.function("motion", inputs, *steps, gives=given, told="motion")


def _powers(lost: Expr, damped: Expr) -> tuple[Expr, ...]:
    """In the order of `POWERS`. What prescribes a coordinate gives what the contacts take there."""
    carried = MOTION.derivative(displacement(O, BODY, WORLD)) - OVER_INPUT
    held = Vec(WORLD, (*HELD, S.Zero)).dot(carried)
    pushed = push_x * q.RATES.quantities[0] + push_y * q.RATES.quantities[1]
    on_angle, on_pushed = q.FORCES.quantities[q.FREE :]
    return (
        -on_angle * q.angle_dot + held + pushed,
        -on_pushed * q.pushed_dot,
        load * spun * q.output_dot,
        q.damped,
        q.rubbed,
        lost,
        damped,
    )


def damping(f: Formulas) -> None:
    """Damping as a share of the critical one, at which the shaft's bending just does not swing."""
    s, critical = sp.Dummy("s"), sp.Dummy("critical", positive=True)
    swing = sp.discriminant(shaft_mass * s**2 + critical * s + shaft_stiffness, s)
    (most,) = sp.solve(swing, critical)
    step = let(shaft_damping, damping_share * most, "damping without swing")
    f.function("damping", (damping_share, shaft_mass, shaft_stiffness), step, told="damped")


def build_motion_system() -> System:
    """What both clutches share."""
    title = "Clutch in contact: linkage, shared contacts, equations of motion"
    source = "derived (Lagrange, virtual work); laws of Hunt and Crossley 1975, Dahl 1976"
    f = Formulas("clutch_motion", title=title, source=source, assumptions=ASSUMPTIONS)
    for part in (course, bearing, linkage, motion, damping):
        part(f)
    return f.system()


SYSTEMS = (build_motion_system,)
