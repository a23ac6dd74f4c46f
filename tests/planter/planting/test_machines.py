"""Planting devices as machines of the engine: the same numbers as their own functions, derivatives
in every value.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.engine.response import MachineResponse
from planter.planting import file
from planter.planting.model import Device

ANGLES = np.linspace(0.0, np.pi, 9)


@pytest.mark.parametrize("name", ["wang2017", "compact"])
def test_support_force_equals_device(name: str) -> None:
    machine, device = load_machine(name), Device(file.load(name))
    response, at = MachineResponse(machine, ["F_support"]), device.prologue(device.design)
    values, slopes = response.slopes(response.at(machine.design), ANGLES)
    expected, expected_slopes = device.support_slopes(at, ANGLES)
    np.testing.assert_allclose(values[0], expected, rtol=1e-13)
    np.testing.assert_allclose(
        slopes[0], expected_slopes, rtol=1e-11, atol=1e-11 * np.abs(expected_slopes).max()
    )


def test_slopes_in_numbers_of_the_file_are_those_of_differences() -> None:
    machine = load_machine("compact", model="printed")
    paths = ("design.theta_deg", "mass.planet_kg", "operation.speed_rpm", "spring.rate_N_m")
    machine = machine.with_moved(dict.fromkeys(paths, (0.0, 1.0)))
    response, x = MachineResponse(machine, ["F_support", "M_L"]), machine.design
    slopes = response.slopes(response.at(x), ANGLES)[1][:, :, 1:]
    for column, step in enumerate(np.diag(1e-5 * np.abs(x))):
        high, low = (response.values(response.at(x + sign * step), ANGLES) for sign in (1, -1))
        difference = (high - low) / (2 * step.sum())
        np.testing.assert_allclose(
            slopes[:, :, column], difference, rtol=1e-6, atol=1e-6 * np.abs(slopes).max()
        )
