"""What the contact model of both clutches is fed with, in SI units and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import casadi as ca

from planter.clutch.engage import beam
from planter.clutch.file import Clutch
from planter.clutch.linkage import Linkage


@dataclass(frozen=True)
class Inputs:
    """Everything both clutches share, and the geometry of each; every field may be varied without building anew.

    Units are SI; `stiffness` [N/m^1.5], `dissipation` [s/m], `link_speed` [rad/s], `push_*` a force on the body that
    no clutch has [N], for limits in which there is a closed form.
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
    mesh_angle: float
    link_ratio: float
    crank: float
    rod: float
    distance: float
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
        """Time in which the link goes from start to end of its course [s]."""
        return abs(self.link_end - self.link_start) / self.link_speed

    def vector(self) -> list[float]:
        """The values in the order of the fields."""
        return [getattr(self, field.name) for field in fields(self)]

    def times(self, factor: float, *names: str) -> Inputs:
        """A copy with some inputs multiplied."""
        return replace(self, **{name: factor * getattr(self, name) for name in names})

    def back(self) -> Inputs:
        """A copy in which the link goes its course the other way."""
        return replace(self, link_start=self.link_end, link_end=self.link_start)


class Symbols:
    """The same names as CasADi symbols, and the vector of them all."""

    def __init__(self) -> None:
        names = [field.name for field in fields(Inputs)]
        self.vector = ca.SX.sym("p", len(names))
        self._named = dict(zip(names, ca.vertsplit(self.vector), strict=True))

    def __getattr__(self, name: str) -> ca.SX:
        return self._named[name]


LONGEST_S = 3.0
"""Longest time that jaws may take to meet, and the sleeve to make its travel [s]."""
LOAD_SPEED = 0.01
"""Share of the input speed at which the load torque has 1/sqrt(2) of its value: below, it fades to none at rest."""


def _check(clutch: Clutch) -> None:
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


def inputs(clutch: Clutch, shape: str = beam.PAPERS) -> Inputs:
    """The inputs of an engagement from a clutch file; the link falls from its limit to the horizontal.

    The link moves at the speed that gives the sleeve the mean speed of the file. Raises InputError for a linkage that
    does not close over the travel, teeth or jaws that cannot be, or a motion that takes too long.
    """
    si = clutch.si
    _check(clutch)
    linkage = Linkage(*(si(f"linkage.{key}") for key in ("crank_mm", "rod_mm", "distance_mm")))
    travel = si("sleeve.travel_mm")
    linkage.check(travel, f"{clutch.source}: linkage.rod_mm")
    ratio = si("linkage.rack_radius_mm") / si("linkage.crank_gear_radius_mm")
    mesh = math.pi / 2 - si("linkage.rack_phase_deg")
    lift = linkage.rotation(travel) / ratio
    shaft = beam.beam(si, shape)
    radius, speed = si("engagement.contact_radius_mm"), si("engagement.input_speed_rpm")
    side = si("sleeve.hexagon_side_mm")
    return Inputs(
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
        shaft_mass=shaft.mass,
        shaft_stiffness=shaft.stiffness,
        shaft_damping=2 * si("contact.shaft_damping") * math.sqrt(shaft.mass * shaft.stiffness),
        preload=si("sleeve.spring_preload_N"),
        spring_rate=si("contact.spring_rate_N_m"),
        slide=si("contact.slide_N"),
        lock=si("contact.lock_N"),
        lock_travel=si("contact.lock_travel_mm"),
        lock_stiffness=si("contact.lock_stiffness_N_m"),
        mesh_angle=mesh,
        link_ratio=ratio,
        crank=linkage.crank,
        rod=linkage.rod,
        distance=linkage.distance,
        link_speed=lift * si("sleeve.switching_speed_mm_s") / travel,
        link_start=mesh + lift,
        link_end=0.0,
        travel=travel,
        taper=si("sleeve.axial_angle_deg"),
        width=math.sqrt(3) * side,
        hole=math.sqrt(3) / 2 * side + si("contact.sleeve_gap_mm"),
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
