"""A machine that nothing was generated for: other masses, the two gear families exchanged."""

from functools import cache
from typing import Any

from planter.papers.planting.file import PlantingMachine, load

DESIGN = {
    "theta_deg": 66.0,
    "gamma_deg": 31.0,
    "alpha3_deg": 24.0,
    "beta6_deg": 2.0,
    "A3_mm": 30.9,
    "k3": 0.06,
    "m31": 1.4,
    "R6_mm": 30.7,
    "e6_mm": 2.0,
    "m61": 1.2,
}
MASSES = {"sun_kg": 0.5, "middle_kg": 0.6, "planet_kg": 1.1, "carrier_kg": 4.0}


def table() -> dict[str, Any]:
    table = load("wang2017").table()
    table["mass"] |= MASSES
    table["stage1"], table["stage2"] = table["stage2"], table["stage1"]
    table["design"] = DESIGN
    table["bounds"] = {name: [0.99 * value, 1.01 * value] for name, value in DESIGN.items()}
    table["origin"] = {"default": "assumed"}
    return {key: value for key, value in table.items() if key != "requirements"} | {
        "name": "swapped"
    }


@cache
def machine() -> PlantingMachine:
    return PlantingMachine.read(table(), "swapped.toml")
