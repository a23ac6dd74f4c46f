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
CORNERS = 5
_DENSE = 12_001


def corner_path(lead: float) -> Array:
    """Path of corner C as M (2, 2): C = centre + R M (cos theta, sin theta), in widths R of the pentagon.

    Corner A stays on the upper side and gives y = -sin theta; corner B stays on the next side, so that the coordinate
    across that side, -x sin 60 deg + y cos 60 deg, is -sin(theta + lead). `lead` [rad] is between AC and BC as seen
    from the two sides.
    """
    across = -np.array([np.sin(lead), np.cos(lead)])
    y = np.array([0.0, -1.0])
    return np.array([(y * np.cos(TURN) - across) / np.sin(TURN), y])


@formula("distance from the centre of the corner's path")
def centre_offset(inputs: Inputs) -> float:
    """Distance of a printed centre of the ellipse from the corner between both sides, in widths of the pentagon."""
    sides = np.array([[0.0, 1.0], [-np.sin(TURN), np.cos(TURN)]])
    corner = np.linalg.solve(sides, [0.5, 0.5])
    return float(np.linalg.norm(corner - inputs["centre_over_width"]))


@formula("angle from the major axis of the corner's path")
def axis_offset(inputs: Inputs) -> float:
    """Angle between a printed line of the foci, by its slope, and the major axis of the ellipse [deg]."""
    x, y = np.linalg.svd(_path(inputs))[0][:, 0]
    apart = np.degrees(np.arctan2(y, x) - np.arctan(inputs["foci_slope"])) % 180
    return float(min(apart, 180 - apart))


def support(direction: Array) -> Array:
    """Distance from the centre to the tangent of a Reuleaux pentagon of width 1, by direction [rad], a corner at 0.

    Round a corner the tangent passes through it; elsewhere it touches the arc about the corner opposite.
    """
    pitch, outline = 2 * np.pi / CORNERS, 1 / (2 * np.sin(np.radians(72)))

    def at_corner(angle: Array) -> Array:
        return outline * np.cos(angle - pitch * np.round(angle / pitch))

    from_corner = abs(direction - pitch * np.round(direction / pitch))
    return np.where(from_corner <= pitch / 4, at_corner(direction), 1 - at_corner(direction + np.pi))


@formula("mismatch with the third pair of sides")
def mismatch(inputs: Inputs) -> float:
    """Largest distance by which a Reuleaux pentagon misses a hexagon's third pair of sides, in its own widths.

    The sides are one width apart and two pairs of them are held exactly. Across a pair the centre lies at 1/2 less the
    support distance; the directions across three pairs, 60 deg apart, have n1 + n3 = n2.
    """
    turned = np.linspace(0, 2 * np.pi / CORNERS, _DENSE)
    first, second, third = (0.5 - support(angle - turned) for angle in np.radians(inputs["across_deg"]))
    return float(abs(first + third - second).max())


@formula("play that the hexagon lacks")
def lacking_play(inputs: Inputs) -> float:
    """By how much opposite sides must stand further apart for the pentagon to turn freely, in its own widths.

    A play d lets the centre stray by d/2 across each pair, so that three pairs close a mismatch of 3 d/2.
    """
    return mismatch(inputs) * 2 / 3


@formula("outline by both sections")
def outline_by_both(inputs: Inputs) -> float:
    """Circumradius over side of the hexagon: by the rule for tooth tips less that by the rule for the outline."""
    tips = APOTHEM / np.sin(np.radians(inputs["tip_angle_deg"]))
    outline = np.sqrt(3 / (2 + 2 * np.cos(np.radians(inputs["outline_angle_deg"]))))
    return float(tips - outline)


@formula("width of the tips over the shaft")
def tip_play(inputs: Inputs) -> float:
    """Width of the pentagon of tooth tips with the printed tip radius less the shaft's across flats [mm]."""
    return float(2 * inputs["tip_radius_mm"] * np.sin(np.radians(72)) - inputs["shaft_flats_mm"])


@formula("curvature of the tips' path over the fillet")
def fillet_play(inputs: Inputs) -> float:
    """Curvature radius of the tooth tips' path at the corner less the printed fillet radius [mm]."""
    return fillet(inputs) - float(inputs["fillet_mm"])


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
