"""Motion of both clutches: what the linkage prescribes, the contacts they share, slides, equations of motion, powers.

Equations of motion from kinetic and potential energy (Lagrange), under the generalised forces of the contacts.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S, sqrt

from ....branches import clip, switch
from ....mechanics.frames import Point, Vec, displacement
from ....mechanics.friction import dahl, square
from ....mechanics.lagrange import accelerations
from ....mechanics.slopes import Followed
from ....model import ClosedForm, System, let
from ....quantity import Vector
from .. import quantities as clutch
from ..motion import MESH, crank_angle, gear_rate
from ..slider import CRANK, pin_distance
from . import quantities as q
from .bodies import BODY, END, INPUT, MOTION, ON_SLIDES, OVER_INPUT, WORLD, O, contact
from .quantities import found, given

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


def course() -> ClosedForm:
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
    outputs = Vector("course", (link_angle, q.pushed, q.pushed_dot))
    return ClosedForm("course", (time, CRANK, LINK), (*k.steps, rate), outputs)


def bearing() -> ClosedForm:
    """The thrust bearing on the face of the coupling: ends the sleeve's way, and brakes the coupling's slides."""
    return contact("bearing", (), (), q.way, q.way_dot, (OVER_INPUT[0], OVER_INPUT[1]))


def linkage() -> ClosedForm:
    """The linkage pushes the sleeve away; what brings it back is the spring."""
    return contact("linkage", (), (), q.way - q.pushed, q.way_dot - q.pushed_dot, ())


def kinetic() -> Expr:
    """Energy of motion; that of the body's and the input's rotation stays the same."""

    def moving(mass: Expr, point: Point) -> Expr:
        velocity = MOTION.derivative(displacement(O, point, WORLD))
        return mass * velocity.dot(velocity) / 2

    return moving(body, BODY) + moving(shaft_mass, END) + sleeve * q.way_dot**2 / 2 + inertia * q.output_dot**2 / 2


def potential() -> Expr:
    """Of the sleeve's spring and the bent shaft."""
    way = sp.Dummy("way")
    spring = sp.integrate(preload + spring_rate * way, (way, 0, q.way))
    bent = displacement(O, END, WORLD)
    return spring + shaft_stiffness * bent.dot(bent) / 2


def motion() -> ClosedForm:
    """Accelerations, rates of the bristles, works per time and energy, from what all contacts do together."""
    rates, free = q.RATES.quantities, slice(q.FREE)
    sliding, bent = ON_SLIDES.components[:2], Vec(INPUT, (*BENT, S.Zero))
    bristle_rates, lost = dahl(sliding, BENT, lock_stiffness, limit, creep)
    held = (-lock_stiffness * bent).resolved(WORLD)
    seated = clip(1 - q.way / lock_travel, S.Zero, S.One)
    bending = MOTION.derivative(displacement(O, END, WORLD))
    rayleigh = shaft_damping * bending.dot(bending) / 2
    pushes = {rates[0]: HELD[0] + push_x, rates[1]: HELD[1] + push_y, q.output_dot: -load * spun}
    forces = [
        on + pushes.get(rate, S.Zero) - rayleigh.diff(rate)
        for on, rate in zip(q.FORCES.quantities[free], rates[free], strict=True)
    ]
    solved = accelerations(kinetic(), potential(), q.PLACES.quantities[free], rates[free], forces)
    steps = (
        let(spun, q.output_dot / sqrt(q.output_dot**2 + load_speed**2)),
        let(limit, slide + lock * seated),
        *(let(name, component) for name, component in zip(HELD, held.components, strict=False)),
        *(let(name, expr, "Lagrange's equation") for name, expr in zip(ACCELERATIONS, solved, strict=True)),
        *(let(name, expr, "Dahl's bristles") for name, expr in zip(BENT_RATES, bristle_rates, strict=True)),
        *(let(name, expr) for name, expr in zip(POWERS, _powers(lost, rayleigh), strict=True)),
        let(energy, kinetic() + potential() + lock_stiffness * square(BENT) / 2 + q.stored),
    )
    outputs = Vector("motion", (*ACCELERATIONS, *BENT_RATES, *POWERS, energy))
    inputs = (q.PLACES, q.RATES, BRISTLES, SUMS, MASSES, SPRINGS, LOADS, SLIDES)
    return ClosedForm("motion", inputs, steps, outputs)


def _powers(lost: Expr, rayleigh: Expr) -> tuple[Expr, ...]:
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
        2 * rayleigh,
    )


def damping() -> ClosedForm:
    """Damping as a share of the critical one, at which the shaft's bending just does not swing."""
    s, critical = sp.Dummy("s"), sp.Dummy("critical", positive=True)
    swing = sp.discriminant(shaft_mass * s**2 + critical * s + shaft_stiffness, s)
    (most,) = sp.solve(swing, critical)
    step = let(shaft_damping, damping_share * most, "damping without swing")
    return ClosedForm(
        "damping", (damping_share, shaft_mass, shaft_stiffness), (step,), Vector("damped", (shaft_damping,))
    )


def exact() -> System:
    """What both clutches share."""
    return System(
        "clutch_motion",
        "Clutch in contact: linkage, shared contacts, equations of motion",
        "derived (Lagrange, virtual work); laws of Hunt and Crossley 1975, Dahl 1976",
        ASSUMPTIONS,
        closed_forms=(course(), bearing(), linkage(), motion(), damping()),
    )


SYSTEMS = (exact,)
