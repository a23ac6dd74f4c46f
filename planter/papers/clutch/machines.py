"""Clutches as the engine takes them: the linkage that pushes the sleeve, while the link goes up and
down again.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from planter.engine.closed_form import build_closed_machine
from planter.engine.machine import Machine, Value
from planter.files import examples
from planter.papers.clutch import file
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.model import CrankLinkage, collect_values, control_motion, load_model

SPEED = "search.lift_rad_s"
VALUES = {
    "l_AB": ("m", "length of the crank", "linkage.crank_mm"),
    "l_BC": ("m", "length of the connecting rod", "linkage.rod_mm"),
    "l_AC": (
        "m",
        "distance from the crank's axis to the sleeve's pin, engaged",
        "linkage.distance_mm",
    ),
    "r_A": ("m", "pitch radius of the crank gear", "linkage.crank_gear_radius_mm"),
    "r_D": ("m", "pitch radius of the arc rack", "linkage.rack_radius_mm"),
    "gamma": ("rad", "mounting phase angle of the arc rack", "linkage.rack_phase_deg"),
    "F1": ("N", "force that pushes the sleeve, all along its way", "sleeve.engaging_force_N"),
    "omega": ("rad/s", "speed of the link", SPEED),
}
"""Unit, meaning and path of the numbers on which the switching depends, by name."""
QUANTITIES = {
    "link": ("rad", "rotation of the link from where the clutch is engaged"),
    "alpha": ("rad", "inclination of the link"),
    "theta_AR": ("rad", "rotation of the crank against the link"),
    "crank_angle": ("rad", "angle of the crank from the guide"),
    "rod_angle": ("rad", "angle of the rod with the guide"),
    "shift": ("m", "way of the sleeve from its engaged place"),
    "v_sleeve": ("m/s", "velocity of the sleeve"),
    "pin_x": ("m", "crank pin, along the guide"),
    "pin_y": ("m", "crank pin, across the guide"),
    "lever": ("m", "way of the sleeve per rotation of the crank"),
    "tooth_force": ("N", "tangential force of the rack on the crank gear"),
    "side_force": ("N", "force of the guide on the sleeve, across the way"),
    "M_link": ("N m", "torque on the link that pushes the sleeve, in the direction of its drive"),
}


def takes(source: str) -> bool:
    """Return whether a source is a clutch's file, or the name of a built-in one."""
    return examples.belongs_to_package(source, "clutch", {"sleeve", "shaft", "tooth"})


def load(source: str, changes: Mapping[str, float]) -> Machine:
    """Return the machine of a clutch.

    Raises InputError as its file does, GeometryError as its linkage does.
    """
    return build_machine(file.load_clutch(source, changes))


def build_machine(clutch: ClutchFile) -> Machine:
    """Return the switching of a clutch over the rotation of its link.

    The link goes up by as much as the file's own linkage needs for the sleeve's travel, and comes
    down again: that is a cycle. Raises GeometryError if the linkage does not make the travel.
    """
    linkage = CrankLinkage.from_lengths(clutch.linkage)
    linkage.check(clutch.si("sleeve.travel_mm"), f"{clutch.source}: linkage.rod_mm")
    control = control_motion(clutch, collect_values(clutch))
    assert control is not None
    lift = control["lift"]
    values = tuple(Value(name, *entry) for name, entry in VALUES.items())
    phi, d, none = ca.SX.sym("phi"), ca.SX.sym("d", len(values)), ca.SX.sym("none", 0)
    return build_closed_machine(
        clutch,
        build_machine,
        load_model().sidecar,
        values,
        np.array([clutch.si(value.path) for value in values]),
        QUANTITIES,
        _compose_switching(phi, dict(zip(VALUES, ca.vertsplit(d), strict=True)), lift),
        (phi, d, none),
        none,
        [(phi, {"name": "link turns back", "order": 0, "period": lift})],
        SPEED,
        clutch.measure_limits,
        turn=2 * lift,
        motors=("M_link",),
    )


def _compose_switching(phi: ca.SX, inputs: dict[str, ca.SX], lift: float) -> dict[str, ca.SX]:
    """Return the quantities by name at a drive angle phi, half of whose cycle is the link's lift
    [rad].
    """
    formulas = load_model()
    link = lift - ca.fabs(phi - 2 * lift * ca.floor(phi / (2 * lift)) - lift)
    crank = ca.vertcat(*(inputs[name] for name in ("l_AB", "l_BC", "l_AC")))
    engaged = formulas.composed("slider", {**inputs, "shift": ca.SX(0), "crank": crank})
    turned = link * inputs["r_D"] / inputs["r_A"]
    angle = engaged["crank_angle"] - turned
    across = inputs["l_AB"] * ca.sin(angle)
    shift = (
        inputs["l_AB"] * ca.cos(angle) + ca.sqrt(inputs["l_BC"] ** 2 - across**2) - inputs["l_AC"]
    )
    results = formulas.composed("slider", {**inputs, "shift": shift})
    results |= formulas.composed("push", {**inputs, "shift": shift})
    results |= {
        "link": link,
        "alpha": np.pi / 2 - inputs["gamma"] + link,
        "theta_AR": turned,
        "shift": shift,
    }
    slope = ca.jacobian(shift, phi)
    results |= {"v_sleeve": inputs["omega"] * slope, "M_link": inputs["F1"] * slope}
    return results
