"""Equations of motion of a clutch, for an integrator: six degrees of freedom, and where the energy goes.

They are generated, with what they assume; here they are put together with the contacts that a clutch has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.clutch.engage import contacts
from planter.clutch.engage.contacts import DOG, MOTION, REULEAUX, Contact
from planter.clutch.engage.inputs import NAMES
from planter.clutch.geometry import SIDES, VERTICES
from planter.kernels import Kernel, formulas

Array = NDArray[np.float64]

FREE = 6
"""Degrees of freedom: body x, y; sleeve's travel; output rotation; shaft end x, y."""
POWERS = ("input", "linkage", "load", "damping", "friction", "slides", "shaft")
"""Works that are integrated beside the motion: two go in, the others are lost."""
ANGLE, TIME, BENT, WORKS = 2 * FREE, 2 * FREE + 1, 2 * FREE + 2, 2 * FREE + 4
SIZE = WORKS + len(POWERS)
"""A state: coordinates, their rates, input angle, time, the coupling's bristles (2), works."""
TRAVEL, OUTPUT = 2, 3
SMALL = {"least_depth": 1e-30, "core": 1e-9, "creep": 1e-6}
"""Lengths [m] and a speed [m/s] that keep slopes finite: of no depth, of no eccentricity, of no sliding."""


def assumptions() -> list[str]:
    """What the contact model of both clutches assumes."""
    return [text for model in (MOTION, REULEAUX, DOG) for text in formulas.load(model).sidecar["assumptions"]]


@dataclass(frozen=True)
class Clutch:
    """A clutch in contact: its right-hand side as symbols, and what can be seen of a state.

    `carriers` counts the contacts that carry the load, teeth or jaws; after a turn of `pitch` [rad] they look alike.
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
    return _clutch("reuleaux", contacts.reuleaux(), math.lcm(VERTICES, SIDES))


@cache
def dog(count: int) -> Clutch:
    return _clutch("dog", contacts.dog(count), count, jaws=count)


def _clutch(name: str, kinds: Sequence[Contact], alike: int, **fixed: float) -> Clutch:
    """The clutch of some contacts, which look alike in so many places of a turn; `fixed` are inputs built in."""
    model = formulas.load(MOTION)
    x, p = ca.SX.sym("x", SIZE), ca.SX.sym("p", len(NAMES))
    known = {key: ca.SX(value) for key, value in (SMALL | fixed).items()}
    known |= dict(zip(NAMES, ca.vertsplit(p), strict=True)) | _state(x)
    known |= {"angle_dot": known["input_speed"]} | model.composed("course", {**known, "t": x[TIME]})
    found = contacts.together(kinds, known)
    moved = model.composed("motion", known | found.sums)
    places = model.entries("places")
    ode = ca.vertcat(
        x[FREE : 2 * FREE],
        *(moved[f"{place}_ddot"] for place in places[:FREE]),
        known["angle_dot"],
        1,
        *(moved[f"{bent}_dot"] for bent in model.entries("bristles")),
        *(moved[f"power_{power}"] for power in POWERS),
    )
    carriers = kinds[0].count
    shown = {
        "load": ca.sum1(found.normal[:carriers]),
        "normal": found.normal,
        "gaps": found.gaps,
        "generalised": ca.vertcat(*(found.sums[f"on_{place}"] for place in places)),
        "energy": moved["energy"],
        "link": known["link_angle"],
        "pushed": known["pushed"],
    }
    seen = ca.Function(f"{name}_seen", [x, p], ca.cse(list(shown.values())), ["x", "p"], list(shown))
    dae = {"x": x, "p": p, "ode": ca.cse(ode)}
    return Clutch(name, carriers, 2 * math.pi / alike, dae, Kernel(seen, lanes=("x",)))


def _state(x: ca.SX) -> dict[str, ca.SX]:
    """Places, rates and bristles of a state by the names of the derivation."""
    model = formulas.load(MOTION)
    free = model.entries("places")[:FREE]
    names = [*free, *(f"{place}_dot" for place in free), "angle", "t", *model.entries("bristles")]
    return dict(zip(names, ca.vertsplit(x[:WORKS]), strict=True))
