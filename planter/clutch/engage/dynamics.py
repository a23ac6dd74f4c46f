"""Equations of motion of a clutch, for an integrator: six degrees of freedom, and where the energy goes.

What is assumed stands in `ASSUMPTIONS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.clutch.engage import contacts, course
from planter.clutch.engage.contacts import Contact, State
from planter.clutch.engage.inputs import Symbols
from planter.clutch.engage.profiles import across, turned
from planter.kernels import Kernel

Array = NDArray[np.float64]

ASSUMPTIONS = (
    "the input turns at a constant speed and the coupling passes this rotation on exactly; its slides have no mass",
    "the body does not tilt; gravity is left out; all is rigid but the contacts, the spring and the shaft's bending",
    "the output shaft bends in one mode, the same in both directions across its axis, the contact at its end",
    "the sleeve's hexagonal hole turns and moves with the output shaft, on whose hexagon it slides",
    "the sleeve moves along the axis against a linear spring; the linkage can push it away but not pull it back",
    "the slides of the coupling hold the body where it is by friction, whose limit grows by lock_N over the last "
    "lock_travel_mm of the sleeve's way: the thrust bearing seats",
    "the hole of the body is relieved behind the roots of its teeth: on the printed root circle no tooth could pass a "
    "corner of the shaft",
    "sleeve_gap_mm between polygon and hole when cut off: without it the printed teeth would overlap with the shaft",
    "dog clutch: parallel flanks along the axis, rounded edges, all jaws alike, meeting at contact_radius_mm; its "
    "driving half sits in a fit on its shaft and moves with the sleeve, with the body's mass",
    "the load torque resists rotation and is constant in size, but fades to none at rest",
    "one law for every contact, linkage and bearing included: Hunt and Crossley's, with Coulomb friction that creeps "
    "below slip_speed_mm_s instead of sticking",
)
FREE = 6
"""Degrees of freedom: body x, y; sleeve's travel; output rotation; shaft end x, y."""
POWERS = ("input", "linkage", "load", "damping", "friction", "slides", "shaft")
"""Works that are integrated beside the motion: two go in, the others are lost."""
ANGLE, TIME, BENT, WORKS = 2 * FREE, 2 * FREE + 1, 2 * FREE + 2, 2 * FREE + 4
SIZE = WORKS + len(POWERS)
"""A state: coordinates, their rates, input angle, time, the coupling's bristles (2), works."""
TRAVEL, OUTPUT = 2, 3
CREEP = 1e-6
"""Speed that keeps the bristles' law smooth where sliding stops [m/s]."""

Build = Callable[[State, State, Symbols], list[Contact]]


@dataclass(frozen=True)
class Clutch:
    """A clutch in contact: its right-hand side as symbols, and what can be seen of a state.

    `carriers` counts the contacts that carry the load: teeth or jaws.
    """

    name: str
    carriers: int
    pitch: float
    dae: dict[str, ca.SX]
    seen: Kernel

    def columns(self, states: Array, vector: list[float]) -> dict[str, Array]:
        """What is seen of states (SIZE, n): rows by name."""
        return self.seen(x=states, p=vector)


@cache
def reuleaux() -> Clutch:
    return _clutch("reuleaux", 5, 2 * np.pi / 30, contacts.reuleaux)


@cache
def dog(count: int) -> Clutch:
    return _clutch("dog", count, 2 * np.pi / count, lambda at, rate, p: contacts.dog(at, rate, p, count))


def _state(vector: ca.SX) -> State:
    return State(vector[0:2], vector[2], vector[3], vector[4:6], vector[6], vector[7])


def _clutch(name: str, carriers: int, pitch: float, build: Build) -> Clutch:
    p, x = Symbols(), ca.SX.sym("x", SIZE)
    places, rates = ca.SX.sym("places", FREE + 2), ca.SX.sym("rates", FREE + 2)
    at, rate = _state(places), _state(rates)
    pairs = build(at, rate, p)
    found = contacts.forces(pairs, at, rate, p)
    pushed = course.sleeve(x[TIME], p)
    given = [
        ca.vertcat(x[:FREE], x[ANGLE], pushed),
        ca.vertcat(x[FREE : 2 * FREE], p.input_speed, ca.jacobian(pushed, x[TIME])),
    ]
    parts = [found.normal, found.gaps, found.generalised, found.stored, found.damping, found.friction]
    normal, gaps, on, stored, damping, friction = ca.substitute(parts, [places, rates], given)
    speed = x[FREE : 2 * FREE]
    spun = speed[OUTPUT] / ca.sqrt(speed[OUTPUT] ** 2 + p.load_speed**2)
    held = _slides(x, p)
    own = _own_forces(x, p, spun) + ca.vertcat(held.force, ca.DM.zeros(FREE - 2))
    mass = ca.vertcat(p.body, p.body, p.sleeve, p.inertia, p.shaft_mass, p.shaft_mass)
    powers = ca.vertcat(
        -on[FREE] * p.input_speed + held.given + p.push_x * speed[0] + p.push_y * speed[1],
        -on[FREE + 1] * given[1][FREE + 1],
        p.load * spun * speed[OUTPUT],
        damping,
        friction,
        held.lost,
        p.shaft_damping * ca.sumsqr(speed[4:6]),
    )
    ode = ca.vertcat(speed, (on[:FREE] + own) / mass, p.input_speed, 1, held.rate, powers)
    bristles = p.lock_stiffness * ca.sumsqr(x[BENT:WORKS]) / 2
    potential = p.preload * x[TRAVEL] + p.spring_rate * x[TRAVEL] ** 2 / 2 + p.shaft_stiffness * ca.sumsqr(x[4:6]) / 2
    shown = {
        "load": ca.sum1(normal[:carriers]),
        "normal": normal,
        "gaps": gaps,
        "generalised": on,
        "energy": ca.dot(mass, speed**2) / 2 + potential + bristles + stored,
        "link": course.link_angle(x[TIME], p),
        "pushed": pushed,
    }
    seen = ca.Function(f"{name}_seen", [x, p.vector], list(shown.values()), ["x", "p"], list(shown))
    return Clutch(name, carriers, pitch, {"x": x, "p": p.vector, "ode": ode}, Kernel(seen, lanes=("x",)))


def _own_forces(x: ca.SX, p: Symbols, spun: ca.SX) -> ca.SX:
    """Forces on the degrees of freedom beside those of contact: spring, load, the shaft's stiffness and damping."""
    spring = -(p.preload + p.spring_rate * x[TRAVEL])
    bending = -p.shaft_stiffness * x[4:6] - p.shaft_damping * x[FREE + 4 : FREE + 6]
    return ca.vertcat(p.push_x, p.push_y, spring, -p.load * spun, bending)


@dataclass(frozen=True)
class Slides:
    """Friction of the coupling's slides: force on the body (2,), its bristles' rate (2,), power given and lost [W]."""

    force: ca.SX
    rate: ca.SX
    given: ca.SX
    lost: ca.SX


def _slides(x: ca.SX, p: Symbols) -> Slides:
    """Dahl's bristles, in the frame of the input: elastic where it holds, and a limit that grows as the bearing seats.

    P. Dahl, "Solid friction damping of mechanical vibrations", AIAA J. 14 (1976) 1675-1682.
    """
    centre, speed, bent = x[0:2], x[FREE : FREE + 2], x[BENT:WORKS]
    carried = p.input_speed * across(centre)
    sliding = turned(speed - carried, -x[ANGLE])
    seated = ca.fmin(ca.fmax(1 - x[TRAVEL] / p.lock_travel, 0), 1)
    limit = p.slide + p.lock * seated
    yielding = ca.sqrt(ca.sumsqr(sliding) + CREEP**2) * p.lock_stiffness / limit
    force = -p.lock_stiffness * turned(bent, x[ANGLE])
    lost = p.lock_stiffness * ca.sumsqr(bent) * yielding
    return Slides(force, sliding - yielding * bent, ca.dot(force, carried), lost)
