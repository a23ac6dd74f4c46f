"""What values of a planting device are like: beyond, a file is read, but a wrong unit or digit is likely.

The ranges are the project's own. They are wide: about a tenth to ten times what hand-sized to tractor-drawn
transplanters have.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from planter.files import units
from planter.planting.file import Machine
from planter.planting.results.stated import Warned


class Range(NamedTuple):
    """Sizes of a number, without its sign, in the unit that its path ends in; of a list, those of each item."""

    path: str
    low: float
    high: float
    reason: str


_BODY = "bodies of a planting device weigh from a few grams to some kilograms"
_INERTIA = "that is what bodies of such masses and of some millimetres to decimetres have"
_REACH = "a planting device fits between two rows"
_PUSH = "a spring closes the nozzle against a seedling's weight and inertia"

RANGES = (
    Range("operation.speed_rpm", 2, 300, "transplanters plant some tens of seedlings a minute and side"),
    Range("operation.gravity_m_s2", 9.7, 9.9, "it is 9.76 to 9.83 on the ground"),
    Range("operation.forward_speed_m_s", 0, 3, "transplanters travel at walking pace"),
    Range("contact.pressure_angle_deg", 10, 35, "gears are cut at 14.5 to 30"),
    Range("contact.cam_friction_angle_deg", 0, 35, "friction coefficients are below 0.7"),
    Range("contact.tooth_friction_angle_deg", 0, 20, "friction coefficients of teeth are below 0.36"),
    Range("mass.sun_kg", 0.02, 10, _BODY),
    Range("mass.middle_kg", 0.02, 10, _BODY),
    Range("mass.planet_kg", 0.05, 20, _BODY),
    Range("mass.carrier_kg", 0.1, 50, _BODY),
    Range("mass.half_C1_kg", 0.002, 2, _BODY),
    Range("mass.half_C2_kg", 0.01, 5, _BODY),
    Range("inertia.J56_about_A1_kg_m2", 1e-6, 0.05, _INERTIA),
    Range("inertia.J7_about_B1_kg_m2", 1e-5, 0.2, _INERTIA),
    Range("inertia.C1_centroidal_xx_yy_zz_kg_m2", 1e-8, 0.01, _INERTIA),
    Range("inertia.C2_centroidal_xx_yy_zz_kg_m2", 1e-7, 0.05, _INERTIA),
    Range("centroid.sun_radius_mm", 0, 50, "a gear's centroid lies within the gear"),
    Range("centroid.middle_radius_mm", 0, 50, "a gear's centroid lies within the gear"),
    Range("centroid.planet_xy_mm", 0, 200, _REACH),
    Range("nozzle.hinge_A_mm", 0, 300, _REACH),
    Range("nozzle.C1_mm", 0, 300, _REACH),
    Range("nozzle.C2_mm", 0, 400, _REACH),
    Range("nozzle.hook_F_mm", 0, 300, _REACH),
    Range("nozzle.tip_distance_mm", 50, 600, "a nozzle reaches over the gears and into the soil"),
    Range("cam.rocker_length_mm", 5, 150, _REACH),
    Range("cam.base_radius_mm", 5, 150, _REACH),
    Range("cam.opening_deg", 2, 60, "a nozzle half opens by some degrees, as wide as a seedling"),
    Range("spring.preload_N", 0, 500, _PUSH),
    Range("spring.rate_N_m", 0, 20_000, _PUSH),
)


def warnings(machine: Machine) -> list[Warned]:
    """A warning for every value outside its range: what it is, what is usual, and why."""
    numbers = machine.numbers()
    return [
        told for item in RANGES for path in _paths(item.path, numbers) if (told := _told(item, path, numbers[path]))
    ]


def _paths(path: str, numbers: dict[str, float]) -> Iterator[str]:
    return (name for name in numbers if name == path or name.startswith(f"{path}["))


def _told(item: Range, path: str, value: float) -> Warned | None:
    if item.low <= abs(value) <= item.high:
        return None
    unit = units.unit(path)
    usual = f"up to {item.high:g}" if item.low == 0 else f"{item.low:g} to {item.high:g}"
    message = f"{path} = {value:g} {unit} is not what is usual, {usual} {unit}: {item.reason}; is the unit right?"
    return Warned(name="implausible_value", message=message)
