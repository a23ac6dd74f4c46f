"""Tolerances of a planting device where none are given: assumed ones, of the size that workshops keep."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from planter.files import units
from planter.planting.file import Machine
from planter.planting.model import Device
from planter.planting.mounting import DEVIATIONS

Said = dict[str, Any]
SPEEDS: Said = {"from": 35, "to": 45}
"""Of the carrier in the paper's experiment [r/min]."""
MASS: Said = {"percent": 2}
CENTROID: dict[str, Said] = {"mm": {"plus_minus": 0.5}, "deg": {"plus_minus": 2}}
PHASE: Said = {"plus_minus": 0.1}
"""Of a gear on its shaft, and of the mounting [deg]."""
DISTANCE: Said = {"plus_minus": 0.05}
"""Of centres [mm]."""
CURVE: dict[str, Said] = {"mm": {"plus_minus": 0.02}, "": {"plus_minus": 0.002}}
"""Of a pitch curve's parameters, beside the size of all."""
FRICTION: Said = {"plus_minus": 2, "distribution": "uniform"}
"""Of an angle of friction [deg]."""
SECTIONS = ("centroid.", "nozzle.C1_mm", "nozzle.C2_mm")
"""Where centroids stand in a file."""


def usual(machine: Machine) -> dict[str, Said]:
    """Tolerances by input, as a file has them."""
    return dict(_usual(Device(machine)))


def _usual(device: Device) -> Iterator[tuple[str, Said]]:
    data = [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]
    nominal = device.machine.numbers()
    for path in data:
        if path.startswith("mass.") and nominal[path]:
            yield path, MASS
        elif path.startswith(SECTIONS):
            yield path, CENTROID[units.unit(path)]
        elif path.endswith("friction_angle_deg"):
            yield path, _above_zero(FRICTION, nominal[path])
    for name, entry in zip(device.names, device.entries, strict=True):
        yield f"design.{name}", PHASE if entry["unit"] == "rad" else CURVE[units.unit(name)]
    for path in DEVIATIONS:
        yield path, DISTANCE
    yield "operation.speed_rpm", SPEEDS


def _above_zero(tolerance: Said, nominal: float) -> Said:
    """A tolerance that leaves nothing negative."""
    return tolerance | {"plus_minus": min(tolerance["plus_minus"], nominal) or tolerance["plus_minus"]}
