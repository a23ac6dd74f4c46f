"""Numbers of gear trains: helical pairs (ISO 21771), the split of a ratio, and the force of the planting device."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.interpolate import CubicSpline

from planter import planting
from planter.audit.registry import Inputs, Value, formula
from planter.device import Device
from planter.machine import Machine, load

_DENSE = 20_001
_IDLE = ("design", "bounds", "genetic_algorithm", "operation.forward_speed_m_s", "nozzle.tip_distance_mm")
"""What of a machine does not bear on the force of its own design, or is no input of it."""


@formula("centre distance as printed, nearest")
def centre_distance_printed(inputs: Inputs) -> float:
    """m_n (z1 + z2)/cos beta, without the half, at that helix angle of the printed range that comes nearest [mm]."""
    wanted = float(inputs["centre_distance_mm"])
    least, largest = inputs["helix_range_deg"]
    angles = np.radians(np.linspace(least, largest, _DENSE))
    found = _teeth(inputs) * inputs["normal_module_mm"] / np.cos(angles)
    return float(found[np.argmin(abs(found - wanted))])


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


@formula("support force")
def support_force(inputs: Inputs) -> float:
    """Extreme or variance of the support force in the printed model of a built-in machine at its own samples."""
    machine, found = _printed_cycle(inputs["machine"])
    for text in _assumptions(machine):
        inputs.assume(text)
    return found[inputs["part"]]


@cache
def _printed_cycle(name: str) -> tuple[Machine, dict[str, float]]:
    device = Device(load(name), "printed")
    turn = planting.cycle(device, device.prologue(device.design), planting.angles(device.machine.objective.samples))
    return device.machine, planting.statistics(turn.support)


def _assumptions(machine: Machine) -> list[str]:
    """Numbers of a machine that its paper does not give, and that bear on the force."""
    return [
        f"{path} = {value:g}"
        for path, value in machine.numbers().items()
        if not path.startswith(_IDLE) and not machine.origin(path).startswith("paper")
    ]
