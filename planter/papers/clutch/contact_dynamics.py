"""Equations of motion of a clutch in contact for an integrator, and their inputs, in SI units and
radians.

Six degrees of freedom, and the works of all forces. The equations are generated, with their
assumptions; here they are combined with the contacts of a clutch.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.kernels import Kernel, formulas
from planter.papers.clutch import modal_engagement
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.geometry import SIDES, VERTICES, CrankLinkage
from planter.papers.clutch.model import collect_values, load_model


@dataclass(frozen=True)
class ContactInputs:
    """Inputs that both clutches share, and the geometry of each; fields may vary without rebuilding
    the model.

    Names and units are those of the derivation, which says what each is; `push_*` is a force on the
    body that no clutch has, for limits in which there is a closed form.
    """

    stiffness: float
    dissipation: float
    friction: float
    slip_speed: float
    body: float
    sleeve: float
    inertia: float
    load: float
    load_speed: float
    input_speed: float
    shaft_mass: float
    shaft_stiffness: float
    shaft_damping: float
    preload: float
    spring_rate: float
    slide: float
    lock: float
    lock_travel: float
    lock_stiffness: float
    k: float
    gamma: float
    l_AB: float
    l_BC: float
    l_AC: float
    link_speed: float
    link_start: float
    link_end: float
    travel: float
    taper: float
    width: float
    hole: float
    tip: float
    root: float
    apothem: float
    fillet: float
    radius: float
    backlash: float
    edge: float
    depth: float
    fit: float
    push_x: float = 0.0
    push_y: float = 0.0

    @property
    def switching_s(self) -> float:
        """Duration of the link's motion from start to end [s]."""
        return abs(self.link_end - self.link_start) / self.link_speed

    def vector(self) -> list[float]:
        """Return the values in the order of the fields."""
        return self.packed(NAMES)

    def packed(self, names: Iterable[str]) -> list[float]:
        """Return the values of some fields."""
        return [getattr(self, name) for name in names]

    def times(self, factor: float, *names: str) -> ContactInputs:
        """Return a copy with some inputs multiplied by a factor."""
        return replace(self, **{name: factor * getattr(self, name) for name in names})

    def back(self) -> ContactInputs:
        """Return a copy in which the link moves in reverse."""
        return replace(self, link_start=self.link_end, link_end=self.link_start)


NAMES = [field.name for field in fields(ContactInputs)]
"""Names of the inputs, in the order of their vector."""


LONGEST_S = 3.0
"""Longest time that jaws may take to meet, and the sleeve to make its travel [s]."""
LOAD_SPEED = 0.01
"""Share of the input speed at which the load torque has 1/sqrt(2) of its value: below, it fades to
none at rest.
"""


def _check(clutch: ClutchFile) -> None:
    tooth, dog, sleeve = clutch.tooth, clutch.dog, clutch.sleeve
    turns, way = 60 / dog.jaws / LONGEST_S, sleeve.travel_mm / LONGEST_S
    period = f"within {LONGEST_S:g} s"
    rows = {
        "tooth.root_mm": (
            tooth.root_mm > tooth.tip_mm,
            f"greater than tooth.tip_mm = {tooth.tip_mm:g}",
        ),
        "dog.depth_mm": (
            dog.depth_mm < sleeve.travel_mm,
            f"less than sleeve.travel_mm = {sleeve.travel_mm:g}, so that jaws come apart",
        ),
        "engagement.input_speed_rpm": (
            clutch.engagement.input_speed_rpm >= turns,
            f"at least {turns:g}, so that jaws meet {period}",
        ),
        "sleeve.switching_speed_mm_s": (
            sleeve.switching_speed_mm_s >= way,
            f"at least {way:g}, so that the sleeve is there {period}",
        ),
    }
    for path, (is_met, allowed) in rows.items():
        if not is_met:
            raise clutch.input_error(path, f"it must be {allowed}")


def build_contact_inputs(clutch: ClutchFile, shape: str = modal_engagement.PAPERS) -> ContactInputs:
    """Return the inputs of an engagement from a clutch file; the link falls from its limit to the
    horizontal.

    The link moves at the speed that gives the sleeve the mean speed of the file. Raises InputError
    for a linkage that does not close over the travel, teeth or jaws that cannot be, or a motion
    that takes too long.
    """
    si = clutch.si
    _check(clutch)
    values, travel = collect_values(clutch), si("sleeve.travel_mm")
    linkage = CrankLinkage.from_lengths(clutch.linkage)
    linkage.check(travel, f"{clutch.source}: linkage.rod_mm")
    gears = {"k": values["k"], "gamma": values["gamma"]}
    drive = load_model().at(
        "drive", **gears, span=values["r_A"] + values["r_D"], theta_Amax=linkage.rotation(travel)
    )
    shaft = modal_engagement.build_beam(si, shape)
    bending = {"shaft_mass": shaft.mass, "shaft_stiffness": shaft.stiffness}
    radius, speed = si("engagement.contact_radius_mm"), si("engagement.input_speed_rpm")
    width = load_model().at("polygon", a=values["a"])["R"]
    return ContactInputs(
        stiffness=si("contact.stiffness_N_m15"),
        dissipation=si("contact.dissipation_s_m"),
        friction=si("sleeve.friction"),
        slip_speed=si("contact.slip_speed_mm_s"),
        body=si("engagement.body_kg"),
        sleeve=si("contact.sleeve_kg"),
        inertia=si("contact.output_inertia_kg_m2"),
        load=si("engagement.load_Nm"),
        load_speed=speed * LOAD_SPEED,
        input_speed=speed,
        **bending,
        **formulas.load("clutch_motion").at(
            "damping", damping_share=si("contact.shaft_damping"), **bending
        ),
        preload=si("sleeve.spring_preload_N"),
        spring_rate=si("contact.spring_rate_N_m"),
        slide=si("contact.slide_N"),
        lock=si("contact.lock_N"),
        lock_travel=si("contact.lock_travel_mm"),
        lock_stiffness=si("contact.lock_stiffness_N_m"),
        **gears,
        l_AB=linkage.crank,
        l_BC=linkage.rod,
        l_AC=linkage.distance,
        link_speed=drive["lift"] * si("sleeve.switching_speed_mm_s") / travel,
        link_start=drive["alpha_max"],
        link_end=0.0,
        travel=travel,
        taper=si("sleeve.axial_angle_deg"),
        width=width,
        hole=width / 2 + si("contact.sleeve_gap_mm"),
        tip=si("tooth.tip_mm"),
        root=si("tooth.root_mm"),
        apothem=si("shaft.flat_to_flat_mm") / 2,
        fillet=si("shaft.fillet_mm"),
        radius=radius,
        backlash=si("dog.backlash_deg") * radius,
        edge=si("dog.edge_mm"),
        depth=si("dog.depth_mm"),
        fit=si("dog.fit_mm"),
    )


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
"""Lengths [m] and a speed [m/s] that keep slopes finite: of no depth, of no eccentricity, of no
sliding.
"""


def list_assumptions() -> list[str]:
    """Return the assumptions of the contact model of both clutches."""
    return [
        text
        for model in (MOTION, REULEAUX, DOG)
        for text in formulas.load(model).sidecar["assumptions"]
    ]


@dataclass(frozen=True)
class ClutchDynamics:
    """A clutch in contact: its right-hand side as symbols, and what can be seen of a state.

    `carriers` counts the contacts that carry the load, teeth or jaws; after a turn of `pitch` [rad]
    they look alike.
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
    """Return the clutch with some contacts; it repeats `alike` times per revolution; `fixed` are
    constants.
    """
    model = formulas.load(MOTION)
    x, p = ca.SX.sym("x", SIZE), ca.SX.sym("p", len(NAMES))
    values = {key: ca.SX(value) for key, value in (SMALL | fixed).items()}
    values |= dict(zip(NAMES, ca.vertsplit(p), strict=True)) | _state(x)
    values |= {"angle_dot": values["input_speed"]} | model.composed(
        "course", {**values, "t": x[TIME]}
    )
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
    seen = ca.Function(
        f"{name}_seen", [x, p], ca.cse(list(observed.values())), ["x", "p"], list(observed)
    )
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
    """Signed distances [m] and normal forces [N] of all contacts, and the sums of their other
    results, by name.
    """

    gaps: ca.SX
    normal: ca.SX
    sums: dict[str, ca.SX]


def combine_contacts(contacts: Sequence[Contact], values: Known) -> ContactTotals:
    """Return the results of all contacts from values by name: positions, rates, contact law and
    sizes of the clutch.
    """
    contributions = [
        formulas.load(contact.model).composed(contact.name, {**values, "index": ca.SX(index)})
        for contact in contacts
        for index in range(contact.count)
    ]
    gaps, normal = (
        ca.vertcat(*(contribution.pop(name) for contribution in contributions))
        for name in ("gap", "normal")
    )
    return ContactTotals(
        gaps,
        normal,
        {
            name: sum(contribution[name] for contribution in contributions)
            for name in contributions[0]
        },
    )
