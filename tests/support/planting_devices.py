"""Ten planting devices of one's own: crops with other spacings, depths and speeds, planted by
wang2017-wide in other sizes.

Distances between plants of a row: tomato 0.3 to 0.6 m (FAO, Crop information), pepper, cabbage and
broccoli 12 to 18 inches, lettuce 8 to 12, endive 6 to 8, aubergine 18 (Berkeley Horticultural
Nursery and Kassenhoff Growers, vegetable seedling spacing), rice 20 cm, 2 to 3 cm deep (PhilRice,
PalayCheck, how to transplant rice) or 10 cm, 3 to 4 cm deep (Rice Knowledge Management Portal of
India), by machine 16 to 24 cm (Shamshiri et al., International Journal
of Agricultural and Biological Engineering 12, 2019). Depths and heights of vegetable seedlings are
assumed, as are the plants a minute: 80 to 140 of both sides, for rice 200.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from planter.files.examples import example
from planter.papers.planting.file import PlantingMachine
from planter.text_files import parse_toml

BASE = "wang2017-wide"
LENGTHS = ("R3_mm", "e3_mm", "A6_mm")
SIZED = (
    "depth_margin_mm",
    "hole_length_max_mm",
    "hole_length_margin_mm",
    "path_height_min_mm",
    "path_height_margin_mm",
    "seedling_clearance_margin_mm",
    "nozzle_distance_min_mm",
    "nozzle_distance_margin_mm",
    "curvature_radius_min_mm",
    "curvature_radius_margin_mm",
    "module_mm",
)
"""Limits that are as large as the device."""


@dataclass(frozen=True)
class Crop:
    """A crop: size of its device over that of `BASE`, plants of one side a minute, distance between
    plants, depth, height and width of a seedling [mm], and mass over that of a device of its size.

    `changes` are other numbers of [requirements], None for one that is left out.
    """

    size: float
    speed_rpm: float
    spacing_mm: float
    depth_mm: float
    seedling_mm: tuple[float, float]
    mass: float = 1.0
    changes: tuple[tuple[str, float | None], ...] = ()


CROPS = {
    "tomato on ridges": Crop(0.9, 40, 450, 60, (120, 60)),
    "tomato for canning": Crop(1.0, 36, 500, 70, (130, 60), mass=1.2),
    "pepper": Crop(0.8, 45, 400, 50, (110, 50), mass=1.1),
    "cabbage": Crop(0.8, 50, 400, 45, (90, 50), mass=0.9),
    "broccoli": Crop(0.8, 42, 400, 50, (100, 50), mass=0.8),
    "lettuce": Crop(0.6, 60, 300, 30, (60, 40)),
    "endive": Crop(0.4, 70, 200, 25, (45, 30), mass=1.3),
    "rice": Crop(0.4, 100, 200, 25, (50, 20), mass=0.9),
    "rice in narrow hills": Crop(0.4, 100, 100, 30, (50, 20)),
    "aubergine in a hurry": Crop(0.92, 70, 460, 60, (120, 60)),
}
INFEASIBLE = {
    "rice in narrow hills": "ground_speed_ratio",
    "aubergine in a hurry": "funnel_speed",
}
"""Crops that their devices cannot plant, with the limit that stands in the way: a path that is too
long for the spacing, and a speed of the funnel that grows with the plants a minute.
"""


def build_table(name: str) -> dict[str, Any]:
    """Return the table of the machine file of a crop."""
    crop, table = CROPS[name], deepcopy(parse_toml(example(BASE, suffix=".toml"), BASE))
    size, mass = crop.size, crop.mass * crop.size**3
    table["name"], table["description"] = name, f"Own planting device for {name}"
    table["operation"]["speed_rpm"] = crop.speed_rpm
    table["operation"]["forward_speed_m_s"] = -crop.spacing_mm * crop.speed_rpm / 30_000
    for section in ("centroid", "nozzle", "cam"):
        for key, value in table[section].items():
            if key.endswith("_mm"):
                table[section][key] = _multiply(value, size)
    table["mass"] = {key: value * mass for key, value in table["mass"].items()}
    inertia = mass * size**2
    table["inertia"] = {k: _multiply(value, inertia) for k, value in table["inertia"].items()}
    spring = table["spring"]
    spring["preload_N"], spring["rate_N_m"] = spring["preload_N"] * mass, spring["rate_N_m"] * mass
    for section in ("design", "bounds"):
        for key in LENGTHS:
            table[section][key] = _multiply(table[section][key], size)
    limits = table["requirements"]
    limits |= {key: limits[key] * size for key in SIZED}
    height, width = crop.seedling_mm
    limits |= {"seedling_height_mm": height, "seedling_width_mm": width}
    limits |= {
        "soil_depth_mm": crop.depth_mm,
        "depth_min_mm": 0.7 * crop.depth_mm,
        "depth_max_mm": 1.3 * crop.depth_mm,
        "spacing_min_mm": 0.95 * crop.spacing_mm,
        "spacing_max_mm": 1.05 * crop.spacing_mm,
        "spacing_margin_mm": 0.01 * crop.spacing_mm,
    }
    for key, value in crop.changes:
        limits[key] = value
    table["requirements"] = {key: value for key, value in limits.items() if value is not None}
    table["origin"] = {"default": "assumed"}
    return table


def _multiply(value: Any, factor: float) -> Any:
    return [each * factor for each in value] if isinstance(value, list) else value * factor


def build_planting_machine(name: str) -> PlantingMachine:
    """Return the machine of a crop."""
    return PlantingMachine.read(build_table(name), name)
