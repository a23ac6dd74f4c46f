"""Sweeps of planting devices: every row is the turn of the machine that it names, found by another
way.
"""

from collections.abc import Callable

import numpy as np
import pytest

from planter import simulate
from planter.engine.response import MachineResponse
from planter.engine.solvers.sampled_cycle import sample_angles
from planter.papers.planting import file
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.swept import ADAPTER

INPUTS = {
    "operation.speed_rpm": (35.0, 45.0),
    "mass.planet_kg": (1.0, 1.4),
    "centroid.planet_xy_mm[1]": (-8.0, -4.0),
    "design.e3_mm": (5.5, 5.7),
    "design.theta_deg": (65.0, 66.0),
    "contact.cam_friction_angle_deg": (4.0, 8.0),
}
OUTPUTS = (
    "objective",
    "support_range_N",
    "support_max_N",
    "support_variance_N2",
    "support_mean_N",
    "M_L_rms_Nm",
    "M_L_std_Nm",
    "M_L_min_Nm",
    "tip_y_min_mm",
    "F_E_max_N",
    "alpha_range_deg",
)
MANY = 20_000
"""Samples whose extremes and means miss true ones by the square of a step."""
MEASURED: dict[str, Callable[[np.ndarray], float]] = {
    "max": np.max,
    "min": np.min,
    "range": np.ptp,
    "mean": np.mean,
    "std": np.std,
    "variance": np.var,
    "rms": lambda values: np.sqrt(np.mean(values**2)),
}


@pytest.fixture(scope="module")
def machine(kernel_cache: None) -> PlantingMachine:
    return file.load("wang2017", {"objective.samples": 90})


def by_simulation(
    machine: PlantingMachine, model: str, point: np.ndarray, outputs: tuple[str, ...]
) -> list[float]:
    """Outputs of a row by `planter simulate`: a machine of its own, all of its quantities, in many
    samples.
    """
    numbers = dict(zip(INPUTS, map(float, point), strict=True)) | {"objective.samples": MANY}
    changed = machine.with_numbers(numbers)
    simulated = simulate(Device(changed, "printed" if model == "printed" else "exact"))
    columns = simulated.columns
    values = {"objective": simulated.result.objective}
    for name in set(outputs) - {"objective"}:
        stem, kind, unit = name.rsplit("_", 2)
        key = {"N2": f"{stem}_N"}.get(unit, f"{stem}_{unit}")
        values[name] = float(MEASURED[kind](columns[key]))
    return [values[name] for name in outputs]


@pytest.mark.parametrize("model", ["exact", "printed"])
def test_rows_equal_simulate(machine: PlantingMachine, model: str) -> None:
    subject = ADAPTER.subject(ADAPTER.frozen(machine), {"model": model}, INPUTS, OUTPUTS)
    shares = np.random.default_rng(3).random((3, len(INPUTS)))
    low, high = np.array(list(INPUTS.values())).T
    points = low + shares * (high - low)
    expected = [by_simulation(machine, model, point, OUTPUTS) for point in points]
    np.testing.assert_allclose(subject.evaluated(points, 1), expected, rtol=2e-6, atol=1e-7)


def test_rows_do_not_hang_on_threads_or_on_their_neighbours(
    machine: PlantingMachine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("planter.engine.rows.MOST_ROWS", 7)
    monkeypatch.setattr("planter.engine.rows.LEAST_WALKING", 16)
    monkeypatch.setattr("planter.engine.rows.MOST_WALKING", 16)
    subject = ADAPTER.subject(ADAPTER.frozen(machine), {}, INPUTS, OUTPUTS)
    points = np.array(list(INPUTS.values())).T[np.arange(40) % 2]
    alone = subject.evaluated(points[:1], 1)
    for threads in (1, 3):
        assert np.array_equal(subject.evaluated(points, threads)[::2], np.repeat(alone, 20, axis=0))


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


def test_row_without_finite_cycle_is_empty(machine: PlantingMachine) -> None:
    subject = ADAPTER.subject(ADAPTER.frozen(machine), {}, {"mass.planet_kg": (1.0, 1.4)}, OUTPUTS)
    rows = subject.evaluated(np.array([[1.2], [1e308], [1.2]]), 1)
    assert np.isnan(rows[1]).all()
    assert np.array_equal(rows[0], rows[2])
    assert np.isfinite(rows[0]).all()


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
