"""Points that a planting device's tip must pass, put on its own path for a hand to draw about: its requirements."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.planting import cycle
from planter.planting.file import Machine
from planter.planting.model import Device

POINTS = "requirements.points_mm"
COUNT = 6
"""Points that are put on a path."""
TUBE_MM = 10.0
"""Radius of the tube about each."""
REACH_MM = 80.0
"""How far a point can be drawn to either side."""
TUBES_MM = (0.5, 50.0)


def handles(machine: Machine) -> list[tuple[str, str]]:
    """Paths of the numbers x and y of every point."""
    return [(f"{POINTS}[{k}][0]", f"{POINTS}[{k}][1]") for k in range(len(_points(machine)))]


def bounds(machine: Machine) -> dict[str, tuple[float, float]]:
    """How far the numbers of the points can be moved, by path."""
    found = {}
    for k, (x, y, tube) in enumerate(_points(machine)):
        found[f"{POINTS}[{k}][0]"] = (x - REACH_MM, x + REACH_MM)
        found[f"{POINTS}[{k}][1]"] = (y - REACH_MM, y + REACH_MM)
        found[f"{POINTS}[{k}][2]"] = (min(TUBES_MM[0], tube), max(TUBES_MM[1], tube))
    return found


def wished(device: Device, x: Array, machine: Machine) -> Machine:
    """A machine whose tip must pass points on the path of a design x (p,), in SI."""
    turn = cycle.cycle(device, device.prologue(x), cycle.angles(COUNT)).columns()
    places = np.round(np.column_stack([turn["tip_machine_x_mm"], turn["tip_y_mm"]]), 3)
    table = machine.table()
    points = [[*place, TUBE_MM] for place in places.tolist()]
    required = {"tube_excess_max_mm": 0.0, **(table.get("requirements") or {}), "points_mm": points}
    return Machine.read({**table, "requirements": required}, machine.source)


def _points(machine: Machine) -> list[tuple[float, float, float]]:
    return [] if machine.requirements is None else machine.requirements.points_mm or []
