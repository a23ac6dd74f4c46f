"""Warnings of implausible values of a planting device.

The plausible ranges are the project's own. They are wide: about a tenth to ten times the values of
hand-sized to tractor-drawn transplanters. A value outside is read, but a wrong unit or digit is
likely.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from planter.files import units
from planter.mechanism.results import MechanismWarning
from planter.papers.planting.file import PlantingMachine


class PlausibleRange(NamedTuple):
    """Sizes of a number, without its sign, in the unit that its path ends in; of a list, those of
    each item.
    """

    path: str
    low: float
    high: float
    reason: str


_BODY = "bodies of a planting device weigh from a few grams to some kilograms"
_INERTIA = "that is what bodies of such masses and of some millimetres to decimetres have"
_REACH = "a planting device fits between two rows"
_PUSH = "a spring closes the nozzle against a seedling's weight and inertia"

RANGES = (
    PlausibleRange(
        "operation.speed_rpm",
        2,
        300,
        "transplanters plant some tens of seedlings a minute and side",
    ),
    PlausibleRange("operation.gravity_m_s2", 9.7, 9.9, "it is 9.76 to 9.83 on the ground"),
    PlausibleRange("operation.forward_speed_m_s", 0, 3, "transplanters travel at walking pace"),
    PlausibleRange("contact.pressure_angle_deg", 10, 35, "gears are cut at 14.5 to 30"),
    PlausibleRange("contact.cam_friction_angle_deg", 0, 35, "friction coefficients are below 0.7"),
    PlausibleRange(
        "contact.tooth_friction_angle_deg", 0, 20, "friction coefficients of teeth are below 0.36"
    ),
    PlausibleRange("mass.sun_kg", 0.02, 10, _BODY),
    PlausibleRange("mass.middle_kg", 0.02, 10, _BODY),
    PlausibleRange("mass.planet_kg", 0.05, 20, _BODY),
    PlausibleRange("mass.carrier_kg", 0.1, 50, _BODY),
    PlausibleRange("mass.half_C1_kg", 0.002, 2, _BODY),
    PlausibleRange("mass.half_C2_kg", 0.01, 5, _BODY),
    PlausibleRange("inertia.J56_about_A1_kg_m2", 1e-6, 0.05, _INERTIA),
    PlausibleRange("inertia.J7_about_B1_kg_m2", 1e-5, 0.2, _INERTIA),
    PlausibleRange("inertia.C1_centroidal_xx_yy_zz_kg_m2", 1e-8, 0.01, _INERTIA),
    PlausibleRange("inertia.C2_centroidal_xx_yy_zz_kg_m2", 1e-7, 0.05, _INERTIA),
    PlausibleRange("centroid.sun_radius_mm", 0, 50, "a gear's centroid lies within the gear"),
    PlausibleRange("centroid.middle_radius_mm", 0, 50, "a gear's centroid lies within the gear"),
    PlausibleRange("centroid.planet_xy_mm", 0, 200, _REACH),
    PlausibleRange("nozzle.hinge_A_mm", 0, 300, _REACH),
    PlausibleRange("nozzle.C1_mm", 0, 300, _REACH),
    PlausibleRange("nozzle.C2_mm", 0, 400, _REACH),
    PlausibleRange("nozzle.hook_F_mm", 0, 300, _REACH),
    PlausibleRange(
        "nozzle.tip_distance_mm", 50, 600, "a nozzle reaches over the gears and into the soil"
    ),
    PlausibleRange("cam.rocker_length_mm", 5, 150, _REACH),
    PlausibleRange("cam.base_radius_mm", 5, 150, _REACH),
    PlausibleRange(
        "cam.opening_deg", 2, 60, "a nozzle half opens by some degrees, as wide as a seedling"
    ),
    PlausibleRange("spring.preload_N", 0, 500, _PUSH),
    PlausibleRange("spring.rate_N_m", 0, 20_000, _PUSH),
)


def find_implausible_values(machine: PlantingMachine) -> list[MechanismWarning]:
    """A warning for every value outside its range: what it is, what is usual, and why."""
    numbers = machine.numbers()
    return [
        warning
        for item in RANGES
        for path in _list_paths(item.path, numbers)
        if (warning := _check_value(item, path, numbers[path]))
    ]


def _list_paths(path: str, numbers: dict[str, float]) -> Iterator[str]:
    return (name for name in numbers if name == path or name.startswith(f"{path}["))


def _check_value(item: PlausibleRange, path: str, value: float) -> MechanismWarning | None:
    if item.low <= abs(value) <= item.high:
        return None
    unit = units.display_unit(path)
    usual = f"up to {item.high:g}" if item.low == 0 else f"{item.low:g} to {item.high:g}"
    message = (
        f"{path} = {value:g} {unit} is not what is usual, {usual} {unit}: {item.reason}; is "
        f"the unit right?"
    )
    return MechanismWarning(name="implausible_value", message=message)
