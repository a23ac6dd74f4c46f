"""Geometry of a Reuleaux pentagon in a regular hexagon, and of the tapered sleeve that holds it.

Derived from the places of its corners: A and B slide on two neighbouring sides of the hexagon, C is opposite.
"""

from __future__ import annotations

import numpy as np

from planter.audit.registry import Inputs, formula
from planter.kernels import Array

APOTHEM = np.sqrt(3) / 2
"""Distance of a regular hexagon's sides from its centre, in side lengths."""
TURN = np.radians(60)
"""Between the directions in which A and B slide."""


def corner_path(lead: float) -> Array:
    """Path of corner C as M (2, 2): C = centre + R M (cos theta, sin theta), in widths R of the pentagon.

    Corner A stays on the upper side and gives y = -sin theta; corner B stays on the next side, so that the coordinate
    across that side, -x sin 60 deg + y cos 60 deg, is -sin(theta + lead). `lead` [rad] is between AC and BC as seen
    from the two sides.
    """
    across = -np.array([np.sin(lead), np.cos(lead)])
    y = np.array([0.0, -1.0])
    return np.array([(y * np.cos(TURN) - across) / np.sin(TURN), y])


@formula("semi-axis of the corner's path")
def semi_axis(inputs: Inputs) -> float:
    """Semi-axis of the ellipse, in widths of the pentagon: 1 is the major one."""
    axes = np.linalg.svd(_path(inputs), compute_uv=False)
    return float(axes[inputs["axis"] - 1])


@formula("curvature radius where the path meets the side")
def contact_radius(inputs: Inputs) -> float:
    """Curvature radius of the ellipse where it touches the side of the hexagon, in widths of the pentagon.

    There y is stationary, theta = 90 deg, and the radius is x'^2/|y''|.
    """
    (x_cos, _), (_, y_sin) = _path(inputs)
    return float(x_cos**2 / abs(y_sin))


@formula("fillet from the path")
def fillet(inputs: Inputs) -> float:
    """Curvature radius of the tooth tips' path round a shaft [mm]: the tips' width is the shaft's across flats."""
    return contact_radius(inputs) * float(inputs["shaft_flats_mm"])


@formula("fillet from the printed curvature")
def fillet_printed(inputs: Inputs) -> float:
    """The same, from the printed curvature radius [mm]."""
    return float(inputs["contact_radius_over_width"]) * float(inputs["shaft_flats_mm"])


@formula("least tip radius")
def tip_radius(inputs: Inputs) -> float:
    """Circumradius of the pentagon of tooth tips whose width is the shaft's across flats [mm]."""
    return float(inputs["shaft_flats_mm"] / (2 * np.sin(np.radians(72))))


@formula("least root radius")
def root_radius(inputs: Inputs) -> float:
    """Distance of the filleted corner's outermost point from the shaft's axis [mm]."""
    side = inputs["shaft_flats_mm"] / (2 * APOTHEM)
    return float(side - (1 / APOTHEM - 1) * inputs["fillet_mm"])


@formula("angle between tooth faces")
def face_angle(inputs: Inputs) -> float:
    """Angle between both faces of a tooth whose faces lie flat on the shaft [deg]."""
    return float(np.degrees(2 * np.arcsin(inputs["shaft_flats_mm"] / (2 * inputs["tip_radius_mm"]))))


@formula("travel as printed")
def travel_printed(inputs: Inputs) -> float:
    """Axial travel with the radial gap counted on both sides, as the print has it [mm]."""
    return 2 * travel(inputs)


@formula("travel that frees the body")
def travel(inputs: Inputs) -> float:
    """Axial travel after which the body's circle is clear of the hexagon's sides [mm]: radial gap over the taper."""
    side = inputs["hexagon_side_mm"]
    outline = side * np.sqrt(3 / (2 + 2 * np.cos(np.radians(36))))
    return float((outline - APOTHEM * side) / np.tan(np.radians(inputs["taper_deg"])))


@formula("ratio of radii")
def radius_ratio(inputs: Inputs) -> float:
    """Crank gear's pitch radius over the rack's."""
    return float(inputs["crank_gear_mm"]) / float(inputs["rack_mm"])


def _path(inputs: Inputs) -> Array:
    return corner_path(np.radians(inputs["lead_deg"]))
