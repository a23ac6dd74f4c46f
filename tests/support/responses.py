"""Quantities of a machine at angles of its drive, and their derivatives against differences."""

from __future__ import annotations

import numpy as np

from planter.engine.machine import Machine
from planter.engine.response import MachineResponse

STEP = 1e-6


def values_of(
    machine: Machine, angles: np.ndarray, data: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Return the quantities by name, of the machine's own values or others."""
    response = MachineResponse(machine)
    rows = response.values(response.at_data(machine.data if data is None else data), angles)
    return {quantity.name: row for quantity, row in zip(machine.quantities, rows, strict=True)}


def check_slopes(machine: Machine, angles: np.ndarray) -> None:
    """Hold the slopes in the drive's angle and in all values against central differences."""
    moved = machine.with_moved({value.path: (0.0, 1.0) for value in machine.values})
    response, x = MachineResponse(moved), moved.design
    values, slopes = response.slopes(response.at(x), angles)
    sizes = STEP * np.concatenate([[1.0], np.where(x == 0, 1.0, np.abs(x))])
    for column, size in enumerate(sizes):
        step = np.zeros(len(sizes))
        step[column] = size
        high, low = (
            response.values(response.at(x + sign * step[1:]), angles + sign * step[0])
            for sign in (1, -1)
        )
        difference = (high - low) / (2 * size)
        rounding = 1e-12 * np.abs(values).max(axis=1) / size
        allowed = 1e-5 * np.abs(difference).max(axis=1) + rounding
        assert (np.abs(slopes[:, :, column] - difference).max(axis=1) <= allowed).all(), column
