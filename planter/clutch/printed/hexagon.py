"""A Reuleaux pentagon in a regular hexagon, its tapered sleeve and its teeth, derived and as printed.

Lengths over R are in widths of the pentagon.
"""

from __future__ import annotations

import numpy as np

from planter.audit.registry import MM, Inputs, formula
from planter.clutch.geometry import SIDES, VERTICES, least_travel
from planter.clutch.model import Model, load_model
from planter.clutch.rotor import Rotor


@formula("distance from the centre of the corner's path")
def centre_offset(inputs: Inputs) -> float:
    """Distance of a printed centre of the ellipse from the centre of the corner's path, over R."""
    path = _path()
    return float(np.hypot(*np.subtract([path["x_E"], path["y_E"]], inputs["centre_over_width"])))


@formula("angle from the major axis of the corner's path")
def axis_offset(inputs: Inputs) -> float:
    """Angle between a printed line of the foci, by its slope, and the major axis of the ellipse [deg]."""
    angle = np.degrees(_path()["axis"] - np.arctan(inputs["foci_slope"])) % 180
    return float(min(angle, 180 - angle))


@formula("mismatch with the third pair of sides")
def mismatch(inputs: Inputs) -> float:
    """Largest distance by which a Reuleaux pentagon misses a hexagon's third pair of sides, over R.

    The sides are one width apart and two pairs of them are held exactly.
    """
    return _in_widths("miss")


@formula("play that the hexagon lacks")
def lacking_play(inputs: Inputs) -> float:
    """Distance of opposite sides beyond R that the pentagon needs to turn freely, over R."""
    return _in_widths("free") - 1


@formula("outline by both sections")
def outline_by_both(inputs: Inputs) -> float:
    """Circumradius over side of the hexagon: by the rule for tooth tips less that by the rule for the outline."""
    tips = np.sqrt(3) / 2 / np.sin(np.radians(inputs["tip_angle_deg"]))
    outline = np.sqrt(3 / (2 + 2 * np.cos(np.radians(inputs["outline_angle_deg"]))))
    return float(tips - outline)


@formula("width of the tips over the shaft")
def tip_play(inputs: Inputs) -> float:
    """Width of the pentagon of tooth tips with the printed tip radius less the shaft's across flats [mm]."""
    return float(inputs["shaft_flats_mm"] * (inputs["tip_radius_mm"] / tip_radius(inputs) - 1))


@formula("curvature of the tips' path over the fillet")
def fillet_play(inputs: Inputs) -> float:
    """Curvature radius of the tooth tips' path at the corner less the printed fillet radius [mm]."""
    return fillet(inputs) - float(inputs["fillet_mm"])


@formula("semi-axis of the corner's path")
def semi_axis(inputs: Inputs) -> float:
    """Semi-axis of the ellipse, over R: 1 is the major one."""
    return _path()[f"s_{inputs['axis']}"]


@formula("curvature radius where the path meets the side")
def contact_radius(inputs: Inputs) -> float:
    """Curvature radius of the ellipse where it touches the side of the hexagon, over R."""
    return _path()["tangency"]


@formula("fillet from the path")
def fillet(inputs: Inputs) -> float:
    """Curvature radius of the tooth tips' path round a shaft [mm]: the tips' width is the shaft's across flats."""
    return contact_radius(inputs) * float(inputs["shaft_flats_mm"])


@formula("fillet from the printed curvature")
def fillet_printed(inputs: Inputs) -> float:
    """Fillet radius from the printed curvature radius [mm]."""
    return float(inputs["contact_radius_over_width"]) * float(inputs["shaft_flats_mm"])


@formula("least tip radius")
def tip_radius(inputs: Inputs) -> float:
    """Circumradius of the pentagon of tooth tips whose width is the shaft's across flats [mm]."""
    return _teeth(inputs)["b1"] / MM


@formula("least root radius")
def root_radius(inputs: Inputs) -> float:
    """Distance of the filleted corner's outermost point from the shaft's axis [mm]."""
    return _teeth(inputs)["b2"] / MM


@formula("angle between tooth faces")
def face_angle(inputs: Inputs) -> float:
    """Angle between both faces of a tooth whose faces lie flat on the shaft [deg]."""
    face = load_model().at("face", flats=inputs.si("shaft_flats_mm"), b1=inputs.si("tip_radius_mm"))
    return float(np.degrees(face["xi"]))


@formula("travel as printed")
def travel_printed(inputs: Inputs) -> float:
    """Axial travel with the radial gap counted on both sides, as the print has it [mm]."""
    return _travel(inputs, "printed")


@formula("travel that frees the body")
def travel(inputs: Inputs) -> float:
    """Axial travel after which the body's circle is clear of the hexagon's sides [mm]: radial gap over the taper."""
    return _travel(inputs, "exact")


@formula("width by the travels over the shaft")
def width_by_travels(inputs: Inputs) -> float:
    """Width of the body that the printed travels belong to, by the printed formula, less the shaft's flats [mm]."""
    pairs = zip(inputs.si("travels_mm"), inputs.si("tapers_deg"), strict=True)
    sides = [travelled / least_travel(_of_side(1.0), float(taper), "printed") for travelled, taper in pairs]
    width = load_model().at("polygon", a=float(np.mean(sides)))["R"]
    return float(width / MM - inputs["shaft_flats_mm"])


@formula("ratio of radii")
def radius_ratio(inputs: Inputs) -> float:
    """Crank gear's pitch radius over the rack's."""
    return float(inputs["crank_gear_mm"]) / float(inputs["rack_mm"])


@formula("rotation of the crank gear by both equations")
def crank_gear_rotation(inputs: Inputs) -> float:
    """Rotation by (6), of the fixed frame, less that by which the gear rolls on the rack, for the link's unit rotation.

    By (7) the gear turns by the arc of the teeth that it passes, which is its rotation relative to the link.
    """
    k = radius_ratio(inputs)
    angles = [load_model("printed").at("gears", alpha=alpha, k=k, gamma=np.pi / 2)["theta_A"] for alpha in (1.0, 2.0)]
    return float(angles[1] - angles[0] - 1 / k)


def _path() -> dict[str, float]:
    """The ellipse of the corner's path, over R."""
    return Rotor(VERTICES, SIDES).ellipse


def _in_widths(name: str) -> float:
    """A length that goes with the hexagon's size, over R."""
    return load_model().at("rotor", a=1.0)[name] / load_model().at("polygon", a=1.0)["R"]


def _teeth(inputs: Inputs) -> dict[str, float]:
    return load_model().at("teeth", flats=inputs.si("shaft_flats_mm"), r=inputs.si("fillet_mm"))


def _travel(inputs: Inputs, name: Model) -> float:
    """Travel by a model [mm]."""
    return least_travel(_of_side(float(inputs.si("hexagon_side_mm"))), float(inputs.si("taper_deg")), name) / MM


def _of_side(a: float) -> dict[str, float]:
    """Return the inputs of a travel from the side of the hexagon [m]; friction and forces have no effect on it."""
    return {"a": a, "mu": 0.0, "F1": 0.0, "F2": 0.0}
