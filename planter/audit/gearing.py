"""Numbers of gear trains: helical pairs (ISO 21771) and the split of a ratio."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from planter.audit.registry import Inputs, Value, formula


@formula("centre distance as printed, nearest")
def centre_distance_printed(inputs: Inputs) -> float:
    """m_n (z1 + z2)/cos beta, without the half, at that helix angle of the printed range that comes nearest [mm]."""
    return _nearest(inputs, 1.0)


@formula("centre distance, nearest")
def centre_distance(inputs: Inputs) -> float:
    """m_n (z1 + z2)/(2 cos beta) at that helix angle of the printed range that comes nearest [mm]."""
    return _nearest(inputs, 0.5)


def _nearest(inputs: Inputs, factor: float) -> float:
    wanted = float(inputs["centre_distance_mm"])
    largest_and_least = np.cos(np.radians(inputs["helix_range_deg"]))
    shortest, longest = factor * _teeth(inputs) * inputs["normal_module_mm"] / largest_and_least
    return float(np.clip(wanted, shortest, longest))


@formula("plants in a square metre, nearest")
def density(inputs: Inputs) -> float:
    """Plants in a square metre [1/m2] at those spacings of the printed range that come nearest."""
    least, largest = (float(spacing) / 100 for spacing in inputs["spacing_cm"])
    return float(np.clip(inputs["density_per_m2"], 1 / largest**2, 1 / least**2))


def helix_angle(inputs: Inputs) -> float:
    """Helix angle of a standard pair with a given centre distance [rad]: cos beta = m_n (z1 + z2)/(2 a)."""
    return float(np.arccos(_teeth(inputs) * inputs["normal_module_mm"] / (2 * float(inputs["centre_distance_mm"]))))


@formula("contact ratio of a helical pair")
def helical_contact_ratio(inputs: Inputs) -> float:
    """Transverse part plus overlap of a standard external pair of equal gears; helix angle from the centre distance."""
    beta, module = helix_angle(inputs), inputs["normal_module_mm"]
    transverse = np.arctan(np.tan(np.radians(inputs["normal_pressure_angle_deg"])) / np.cos(beta))
    pitch = float(inputs["centre_distance_mm"]) / 2
    tip = np.arccos(pitch * np.cos(transverse) / (pitch + inputs["addendum_coefficient"] * module))
    profile = _teeth(inputs) * (np.tan(tip) - np.tan(transverse)) / (2 * np.pi)
    return float(profile + inputs["face_width_mm"] * np.sin(beta) / (np.pi * module))


def _teeth(inputs: Inputs) -> float:
    return float(inputs["teeth_1"] + inputs["teeth_2"])


@formula("split of the ratio")
def split(inputs: Inputs) -> Value:
    """Parameter that closes the first of two stages of a ratio: the mean of its inverse root over a turn.

    None where the curve is not monotone.
    """
    carrier, relative = np.asarray(inputs["carrier_deg"]), np.asarray(inputs["relative_deg"])
    turned = relative + carrier
    turned[-1] = turned[0]
    slope = 1 - CubicSpline(carrier, turned, bc_type="periodic")(np.arange(0.0, 360.0, 0.01), 1)
    return float(np.sqrt(slope).mean()) if slope.min() > 0 else None
