"""Inputs of the contact model of both clutches, in SI units and radians."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

from planter.clutch.engagement import modal
from planter.clutch.file import ClutchFile
from planter.clutch.geometry import CrankLinkage
from planter.clutch.model import collect_values, load_model
from planter.kernels import formulas


@dataclass(frozen=True)
class ContactInputs:
    """Inputs that both clutches share, and the geometry of each; fields may vary without rebuilding the model.

    Names and units are those of the derivation, which says what each is; `push_*` is a force on the body that no clutch
    has, for limits in which there is a closed form.
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
"""Share of the input speed at which the load torque has 1/sqrt(2) of its value: below, it fades to none at rest."""


def _check(clutch: ClutchFile) -> None:
    if clutch.tooth.root_mm <= clutch.tooth.tip_mm:
        raise clutch.input_error("tooth.root_mm", f"it must be greater than tooth.tip_mm = {clutch.tooth.tip_mm:g}")
    if clutch.dog.depth_mm >= clutch.sleeve.travel_mm:
        allowed = f"it must be less than sleeve.travel_mm = {clutch.sleeve.travel_mm:g}, so that jaws come apart"
        raise clutch.input_error("dog.depth_mm", allowed)
    slowest = 60 / clutch.dog.jaws / LONGEST_S
    if clutch.engagement.input_speed_rpm < slowest:
        allowed = f"it must be at least {slowest:g}, so that jaws meet within {LONGEST_S:g} s"
        raise clutch.input_error("engagement.input_speed_rpm", allowed)
    slowest = clutch.sleeve.travel_mm / LONGEST_S
    if clutch.sleeve.switching_speed_mm_s < slowest:
        allowed = f"it must be at least {slowest:g}, so that the sleeve is there within {LONGEST_S:g} s"
        raise clutch.input_error("sleeve.switching_speed_mm_s", allowed)


def build_contact_inputs(clutch: ClutchFile, shape: str = modal.PAPERS) -> ContactInputs:
    """Return the inputs of an engagement from a clutch file; the link falls from its limit to the horizontal.

    The link moves at the speed that gives the sleeve the mean speed of the file. Raises InputError for a linkage that
    does not close over the travel, teeth or jaws that cannot be, or a motion that takes too long.
    """
    si = clutch.si
    _check(clutch)
    values, travel = collect_values(clutch), si("sleeve.travel_mm")
    linkage = CrankLinkage(*(si(f"linkage.{key}") for key in ("crank_mm", "rod_mm", "distance_mm")))
    linkage.check(travel, f"{clutch.source}: linkage.rod_mm")
    gears = {"k": values["k"], "gamma": values["gamma"]}
    drive = load_model().at("drive", **gears, span=values["r_A"] + values["r_D"], theta_Amax=linkage.rotation(travel))
    shaft = modal.build_beam(si, shape)
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
        **formulas.load("clutch_motion").at("damping", damping_share=si("contact.shaft_damping"), **bending),
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
