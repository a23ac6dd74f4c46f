"""Numbers of gear trains: helical pairs and plants."""

from __future__ import annotations

import numpy as np

from planter.audit.registry import Inputs, formula
from planter.kernels.formulas import load
from planter.papers.pickup.law import MODEL


@formula("centre distance as printed, nearest")
def centre_distance_printed(inputs: Inputs) -> float:
    """m_n (z1 + z2)/cos beta, without the half, at that helix angle of the printed range that comes
    nearest [mm].
    """
    return _nearest(inputs, 1.0)


@formula("centre distance, nearest")
def centre_distance(inputs: Inputs) -> float:
    """m_n (z1 + z2)/(2 cos beta) at that helix angle of the printed range that comes nearest
    [mm].
    """
    return _nearest(inputs, 0.5)


def _nearest(inputs: Inputs, factor: float) -> float:
    distance = float(inputs["centre_distance_mm"])
    largest_and_least = np.cos(np.radians(inputs["helix_range_deg"]))
    shortest, longest = factor * _teeth(inputs) * inputs["normal_module_mm"] / largest_and_least
    return float(np.clip(distance, shortest, longest))


@formula("plants in a square metre, nearest")
def density(inputs: Inputs) -> float:
    """Plants in a square metre [1/m2] at those spacings of the printed range that come nearest."""
    smallest, largest = (float(spacing) / 100 for spacing in inputs["spacing_cm"])
    return float(np.clip(inputs["density_per_m2"], 1 / largest**2, 1 / smallest**2))


@formula("contact ratio of a helical pair")
def helical_contact_ratio(inputs: Inputs) -> float:
    """Transverse part plus overlap of a standard external pair of equal gears; helix angle from the
    centre distance.
    """
    lengths = [
        inputs.si(name) for name in ("L1_mm", "gamma_deg", "centre_distance_mm", "normal_module_mm")
    ]
    teeth = [inputs["teeth_1"], inputs["teeth_2"], inputs.si("face_width_mm")]
    tool = [inputs.si("normal_pressure_angle_deg"), inputs["addendum_coefficient"]]
    return load(MODEL).at("carrier", carrier=[*lengths, *teeth, *tool])["epsilon_h"]


@formula("speed of the simulation over that of the tests")
def simulated_speed(inputs: Inputs) -> float:
    """Speed of the carrier in the simulation over the highest one at which the mechanism was
    tested.
    """
    return float(inputs.si("simulated_deg_per_s") / np.max(inputs.si("tested_rpm")))


def _teeth(inputs: Inputs) -> float:
    return float(inputs["teeth_1"] + inputs["teeth_2"])
