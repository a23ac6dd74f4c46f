"""Largest load between a mass and the end of an overhanging beam that meet with a speed: one mode of the beam."""

from __future__ import annotations

import numpy as np

from planter.audit.registry import Inputs, formula


@formula("largest contact load as printed")
def load_printed(inputs: Inputs) -> float:
    """The printed form: the beam's whole overhanging mass moves, and the engaging mass does not move with it [N]."""
    return _load(inputs, _beam_mass(inputs))


@formula("largest contact load")
def load(inputs: Inputs) -> float:
    """By projection on the assumed mode: half the overhanging mass, and the engaging mass with it [N]."""
    return _load(inputs, float(inputs["engaging_mass_kg"]) + _beam_mass(inputs) / 2)


def _load(inputs: Inputs, moving: float) -> float:
    """F + m1 sqrt((B1 v)^2 + (F/m)^2), B1^2 = pi^4 E I/(32 m l^3), for a moving mass m [kg]."""
    length = inputs["overhang_mm"] * 1e-3
    stiffness = np.pi**4 * inputs["elastic_modulus_GPa"] * 1e9 * _second_moment(inputs) / (32 * length**3)
    reach = inputs["tip_radius_mm"] * 1e-3
    speed = inputs["input_speed_rpm"] * np.pi / 30 * reach
    driving = inputs["load_torque_Nm"] / reach
    return float(driving + inputs["engaging_mass_kg"] * np.hypot(np.sqrt(stiffness / moving) * speed, driving / moving))


def _side(inputs: Inputs) -> float:
    """Side of the hexagonal shaft [m]."""
    return float(inputs["shaft_flats_mm"]) * 1e-3 / np.sqrt(3)


def _second_moment(inputs: Inputs) -> float:
    """Of a regular hexagon about any axis through its centre: 5 sqrt(3)/16 s^4 [m4]."""
    return float(5 * np.sqrt(3) / 16 * _side(inputs) ** 4)


def _beam_mass(inputs: Inputs) -> float:
    area = 1.5 * np.sqrt(3) * _side(inputs) ** 2
    return float(inputs["density_kg_m3"] * area * inputs["overhang_mm"] * 1e-3)
