"""Equations of motion of a clutch, for an integrator: six degrees of freedom, and where the energy goes.

They are generated, with what they assume; here they are put together with the contacts that a clutch has.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.clutch.engagement.inputs import NAMES
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


def list_assumptions() -> list[str]:
    """Return the assumptions of the contact model of both clutches."""
    return [text for model in (MOTION, REULEAUX, DOG) for text in formulas.load(model).sidecar["assumptions"]]


@dataclass(frozen=True)
class ClutchDynamics:
    """A clutch in contact: its right-hand side as symbols, and what can be seen of a state.

    `carriers` counts the contacts that carry the load, teeth or jaws; after a turn of `pitch` [rad] they look alike.
    """

    name: str
    carriers: int
    pitch: float
    dae: dict[str, ca.SX]
    seen: Kernel

    def columns(self, states: Array, vector: list[float]) -> dict[str, Array]:
        """Return the observed quantities of states (SIZE, n): rows by name."""
        return self.seen(x=states, p=vector)


@cache
def build_reuleaux() -> ClutchDynamics:
    """Return the dynamics of the Reuleaux clutch."""
    return _clutch("reuleaux", list_reuleaux_contacts(), math.lcm(VERTICES, SIDES))


@cache
def build_dog(count: int) -> ClutchDynamics:
    """Return the dynamics of a dog clutch with `count` jaws on each half."""
    return _clutch("dog", list_dog_contacts(count), count, jaws=count)


def _clutch(name: str, kinds: Sequence[Contact], alike: int, **fixed: float) -> ClutchDynamics:
    """Return the clutch with some contacts; it repeats `alike` times per revolution; `fixed` are constants."""
    model = formulas.load(MOTION)
    x, p = ca.SX.sym("x", SIZE), ca.SX.sym("p", len(NAMES))
    values = {key: ca.SX(value) for key, value in (SMALL | fixed).items()}
    values |= dict(zip(NAMES, ca.vertsplit(p), strict=True)) | _state(x)
    values |= {"angle_dot": values["input_speed"]} | model.composed("course", {**values, "t": x[TIME]})
    totals = combine_contacts(kinds, values)
    rates = model.composed("motion", values | totals.sums)
    places = model.entries("places")
    ode = ca.vertcat(
        x[FREE : 2 * FREE],
        *(rates[f"{place}_ddot"] for place in places[:FREE]),
        values["angle_dot"],
        1,
        *(rates[f"{bent}_dot"] for bent in model.entries("bristles")),
        *(rates[f"power_{power}"] for power in POWERS),
    )
    carriers = kinds[0].count
    observed = {
        "load": ca.sum1(totals.normal[:carriers]),
        "normal": totals.normal,
        "gaps": totals.gaps,
        "generalised": ca.vertcat(*(totals.sums[f"on_{place}"] for place in places)),
        "energy": rates["energy"],
        "link": values["link_angle"],
        "pushed": values["pushed"],
    }
    seen = ca.Function(f"{name}_seen", [x, p], ca.cse(list(observed.values())), ["x", "p"], list(observed))
    dae = {"x": x, "p": p, "ode": ca.cse(ode)}
    return ClutchDynamics(name, carriers, 2 * math.pi / alike, dae, Kernel(seen, lanes=("x",)))


def _state(x: ca.SX) -> dict[str, ca.SX]:
    """Places, rates and bristles of a state by the names of the derivation."""
    model = formulas.load(MOTION)
    free = model.entries("places")[:FREE]
    names = [*free, *(f"{place}_dot" for place in free), "angle", "t", *model.entries("bristles")]
    return dict(zip(names, ca.vertsplit(x[:WORKS]), strict=True))


MOTION, REULEAUX, DOG = "clutch_motion", "clutch_contact_reuleaux", "clutch_contact_dog"
"""Generated models: of what both clutches share, and of the contacts of each."""
Known = Mapping[str, ca.SX]


@dataclass(frozen=True)
class Contact:
    """A kind of contact: its model, the function of one, and how many there are."""

    model: str
    name: str
    count: int = 1


SHARED = (Contact(MOTION, "bearing"), Contact(MOTION, "linkage"))


def list_reuleaux_contacts() -> tuple[Contact, ...]:
    """Return the contacts of the teeth with the shaft and of the outline with the sleeve's hole."""
    return Contact(REULEAUX, "tooth", VERTICES), Contact(REULEAUX, "side", SIDES), *SHARED


def list_dog_contacts(jaws: int) -> tuple[Contact, ...]:
    """Return the contacts of jaws with jaws, and of the driving half with its fit."""
    return Contact(DOG, "jaw", jaws), Contact(DOG, "fit"), *SHARED


@dataclass(frozen=True)
class ContactTotals:
    """Signed distances [m] and normal forces [N] of all contacts, and the sums of their other results, by name."""

    gaps: ca.SX
    normal: ca.SX
    sums: dict[str, ca.SX]


def combine_contacts(contacts: Sequence[Contact], values: Known) -> ContactTotals:
    """Return the results of all contacts from values by name: positions, rates, contact law and sizes of the clutch."""
    contributions = [
        formulas.load(contact.model).composed(contact.name, {**values, "index": ca.SX(index)})
        for contact in contacts
        for index in range(contact.count)
    ]
    gaps, normal = (
        ca.vertcat(*(contribution.pop(name) for contribution in contributions)) for name in ("gap", "normal")
    )
    return ContactTotals(
        gaps, normal, {name: sum(contribution[name] for contribution in contributions) for name in contributions[0]}
    )
