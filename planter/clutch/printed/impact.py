"""Largest load between a mass and the end of an overhanging beam that meet with a speed: one mode of the beam."""

from __future__ import annotations

from planter.audit.registry import Inputs, formula
from planter.clutch.engagement import modal

_PATHS = {
    "shaft.density_kg_m3": "density_kg_m3",
    "shaft.overhang_mm": "overhang_mm",
    "shaft.modulus_GPa": "elastic_modulus_GPa",
    "shaft.flat_to_flat_mm": "shaft_flats_mm",
    "engagement.body_kg": "engaging_mass_kg",
    "engagement.contact_radius_mm": "tip_radius_mm",
    "engagement.input_speed_rpm": "input_speed_rpm",
    "engagement.load_Nm": "load_torque_Nm",
}
"""The audit's inputs by their places in a clutch file."""


@formula("largest contact load as printed")
def load_printed(inputs: Inputs) -> float:
    """The printed form: the beam's whole overhanging mass moves, and the engaging mass does not move with it [N]."""
    return modal.printed_extremes(_engagement(inputs))["N_max"]


@formula("largest contact load")
def load(inputs: Inputs) -> float:
    """By projection on the assumed mode: half the overhanging mass, and the engaging mass with it [N]."""
    return _engagement(inputs).largest


def _engagement(inputs: Inputs) -> modal.Modal:
    values = {path: float(inputs.si(name)) for path, name in _PATHS.items()}
    return modal.build_engagement(values.__getitem__)
