"""Sweeps of planting devices: every row is the turn of the machine that it names, found by another
way.
"""

import numpy as np
import pytest

from planter import simulate
from planter.engine.response import MachineResponse
from planter.engine.solvers.sampled_cycle import sample_angles
from planter.papers.planting import file
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.swept import ADAPTER

MANY = 20_000
"""Samples whose extremes and means miss true ones by the square of a step."""


@pytest.fixture(scope="module")
def machine(kernel_cache: None) -> PlantingMachine:
    return file.load("wang2017", {"objective.samples": 90})


def test_the_mean_force_is_the_weight_whatever_is_varied(machine: PlantingMachine) -> None:
    inputs = {
        "mass.planet_kg": (1.0, 1.4),
        "mass.sun_kg": (0.3, 0.5),
        "operation.speed_rpm": (10.0, 80.0),
    }
    subject = ADAPTER.subject(ADAPTER.frozen(machine), {}, inputs, ["support_mean_N"])
    points = np.array([[1.0, 0.3, 10.0], [1.4, 0.5, 80.0], [1.1, 0.4, 33.0]])
    weight = Device(machine).weight
    gravity, mass = machine.operation.gravity_m_s2, machine.mass
    weights = weight + gravity * (2 * (points[:, 0] - mass.planet_kg) + points[:, 1] - mass.sun_kg)
    np.testing.assert_allclose(subject.evaluated(points, 1)[:, 0], weights, rtol=1e-10)


@pytest.mark.parametrize("name", ["wang2017", "compact"])
def test_deviation_changes_only_centre_distance(name: str, kernel_cache: None) -> None:
    """Centres stand apart by as much more, and the angles over a turn are the same."""
    machine = ADAPTER.build(file.load(name))
    response = MachineResponse(machine, ["phi52", "phi72", "F_B1x"])
    mounted = machine.data.copy()
    mounted[-2:] = [0.2e-3, -0.1e-3]
    places = Device(file.load(name)).distance_places
    points = [response.at_data(data) for data in (machine.data, mounted)]
    np.testing.assert_allclose(points[1].h[places] - points[0].h[places], mounted[-2:], rtol=1e-9)
    before, after = (response.values(point, sample_angles(24, 2 * np.pi)) for point in points)
    np.testing.assert_allclose(after[:2], before[:2], atol=1e-12)
    assert np.ptp(after[2] - before[2]) > 1e-6


def test_path_over_ground_equals_simulate() -> None:
    """A machine that travels does not come back: the turn is the one from 0 to 360 deg."""
    machine = file.load("compact", {"objective.samples": MANY})
    changed = machine.with_numbers({"operation.speed_rpm": 36.0})
    path = simulate(Device(changed)).columns["tip_x_mm"]
    subject = ADAPTER.subject(
        ADAPTER.frozen(machine), {}, {"operation.speed_rpm": (35, 45)}, ["tip_x_range_mm"]
    )
    np.testing.assert_allclose(
        subject.evaluated(np.array([[36.0]]), 1), [[np.ptp(path)]], rtol=2e-4
    )
