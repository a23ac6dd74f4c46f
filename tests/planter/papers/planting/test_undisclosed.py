"""Inputs that a paper does not disclose: bounds, the force they give with its slopes, and what can
be attained.
"""

import json
from itertools import product

import numpy as np
import pytest

from planter.engine.solvers.sampled_cycle import sample_angles
from planter.papers.planting import file
from planter.papers.planting.calibration import with_flank
from planter.papers.planting.model import Device
from planter.papers.planting.printed import attainable as experiment
from planter.papers.planting.printed.attainable import PAPER, load_paper_points, read_saved_front
from planter.papers.planting.unpublished_inputs import (
    INERTIA,
    CalibrationForce,
    CalibrationInputs,
    compute_cam_angles,
    compute_flank_angles,
    load_calibration_data,
)
from tests.support import machines, own
from tests.support.sampled import sampled
from tests.support.structure import ROOT

pytestmark = pytest.mark.usefixtures("kernel_cache")
SAMPLES = 60
front = own.import_file(ROOT / "docs" / "studies" / "attainable_front.py")


def device(law: str = "cycloidal", model: str = "exact") -> Device:
    return Device(with_flank(file.load("wang2017", {"objective.samples": SAMPLES}), law), model)


@pytest.fixture(scope="module")
def force() -> CalibrationForce:
    planting_device = device()
    return CalibrationForce(planting_device, CalibrationInputs.with_events(planting_device))


def test_every_input_is_assumed_in_the_machine(force: CalibrationForce) -> None:
    inputs, machine = force.inputs, force.device.machine
    assert len(inputs.find_constants(force.device)) == len(inputs) + 1 > 15
    assert (inputs.lower < inputs.upper).all()
    assert all(machine.origin(path).startswith("assumed") for path in inputs.paths)


def test_flanks_begin_at_paper_events(force: CalibrationForce) -> None:
    assert {k: round(np.degrees(v), 9) for k, v in compute_flank_angles(force.device).items()} == {
        "fall": 280,
        "rise": 160,
    }
    low, high = (force.inputs.table(np.full(len(force.inputs), z)) for z in (0.0, 1.0))
    rows = {row["name"]: row for row in high}
    delta = np.degrees(compute_cam_angles(force.device, np.radians([155.0, 165.0])))
    assert [rows["cam.rise_delta_deg[0]"][key] for key in ("lower", "upper")] == pytest.approx(
        list(delta)
    )
    begun = {row["name"]: row["value"] for row in low}
    assert begun["cam.rise_delta_deg[1]"] - begun["cam.rise_delta_deg[0]"] == pytest.approx(15)


def test_events_not_half_a_turn_apart_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(load_calibration_data()["events"]["seen"][0], "carrier_deg", 103)
    with pytest.raises(ValueError, match="half a turn apart"):
        compute_flank_angles(device())


def test_inertia_stays_physical_for_any_mass(force: CalibrationForce) -> None:
    for seed in range(20):
        rows = {
            row["name"]: row["value"]
            for row in force.inputs.table(np.random.default_rng(seed).random(len(force.inputs)))
        }
        offset = sum(rows[f"centroid.planet_xy_mm[{i}]"] ** 2 for i in (0, 1)) * 1e-6
        assert rows[INERTIA] > rows["mass.planet_kg"] * offset
        force.device.machine.with_numbers(rows)


@pytest.mark.parametrize(
    ("law", "model"),
    sampled(
        [("modified sine", "exact"), ("4-5-6-7 polynomial", "printed")],
        product(["modified sine", "4-5-6-7 polynomial"], ["exact", "printed"]),
    ),
)
def test_force_equals_rebuilt_machine_with_slopes(law: str, model: str) -> None:
    planting_device = device(law, model)
    force = CalibrationForce(planting_device, CalibrationInputs.with_events(planting_device))
    z = np.random.default_rng(5).random(len(force.inputs))
    curve = force(z)
    rows = force.inputs.table(z)
    moved = Device(
        planting_device.machine.with_numbers({row["name"]: row["value"] for row in rows}),
        planting_device.model,
    )
    turn = moved.columns(moved.design, sample_angles(SAMPLES, 2 * np.pi))
    assert curve.force == pytest.approx(turn["support_N"][: len(curve.force)], rel=1e-9)
    assert np.sort(curve.push) == pytest.approx(np.sort(turn["F_E_N"]), rel=1e-8)
    step = 1e-6
    for k, unit in enumerate(np.eye(len(z))):
        ahead, behind = force(z + step * unit), force(z - step * unit)
        for computed, expected, other in (
            (curve.slopes, ahead.force, behind.force),
            (curve.push_slopes, ahead.push, behind.push),
        ):
            scale = max(1.0, float(np.abs(computed).max()))
            assert computed[:, k] == pytest.approx(
                (expected - other) / (2 * step), abs=3e-6 * scale
            )


def test_machine_values_give_machine_force() -> None:
    planting_device = device("4-5-6-7 polynomial")
    force = CalibrationForce(planting_device, CalibrationInputs.wide(planting_device))
    assert force(force.file_point()).force == pytest.approx(
        planting_device.support(
            planting_device.prologue(planting_device.design), sample_angles(SAMPLES, 2 * np.pi)
        )[:30]
    )


def test_attained_points_satisfy_cap_and_contact(force: CalibrationForce) -> None:
    starts = [np.random.default_rng(seed).random(len(force.inputs)) for seed in range(3)]
    largest = front.find_largest_variance(force, 80.0, True, starts)
    assert largest is not None
    assert largest.range <= 80.5
    assert largest.push >= 0
    assert largest.variance > max(force(z).variance for z in starts if force(z).range <= 80)
    free, tied = (
        front.find_largest_range(force, False, starts),
        front.find_largest_range(force, True, starts),
    )
    assert free is not None
    assert tied is not None
    assert free.range >= tied.range - 1 > largest.range


def test_slopes_of_minimised_sums_equal_differences(force: CalibrationForce) -> None:
    search = front.VarianceSearch(force, 40.0, True)
    w = search.start(np.random.default_rng(1).random(len(force.inputs)))
    _, slopes = search.cost(w, 0.3)
    steps = [
        (search.cost(w + 1e-6 * u, 0.3)[0] - search.cost(w - 1e-6 * u, 0.3)[0]) / 2e-6
        for u in np.eye(len(w))
    ]
    assert slopes == pytest.approx(steps, rel=1e-4, abs=1e-5)


def test_saved_front_matches_current_code() -> None:
    saved_front = read_saved_front()
    assert saved_front is not None
    machine = file.load(PAPER)
    assert saved_front["key"] == front.compute_key(machine, load_paper_points(PAPER)), (
        "python docs/studies/attainable_front.py"
    )
    assert saved_front["key"] != front.compute_key(
        machine.with_numbers({"psi0_deg": -7.0}), load_paper_points(PAPER)
    )
    assert saved_front["key"] != front.compute_key(
        machine, {**load_paper_points(PAPER), "theory": {"range_N": 1.0, "variance_N2": 1.0}}
    )


@pytest.mark.parametrize("place", [0, -1])
@pytest.mark.parametrize("contact", [0, 1])
def test_front_points_equal_their_inputs(contact: int, place: int) -> None:
    points = read_saved_front()["fronts"][contact]
    point = points["points"][place]
    machine = with_flank(file.load(PAPER), point["flank"]).with_numbers(point["inputs"])
    subject = Device(machine, "exact")
    turn = subject.columns(subject.design, sample_angles(machine.objective.samples, 2 * np.pi))
    assert np.ptp(turn["support_N"]) == pytest.approx(point["range_N"], rel=1e-8)
    assert turn["support_N"].var() == pytest.approx(point["variance_N2"], rel=1e-8)
    if points["contact"] == "cam pushing":
        assert turn["F_E_N"].min() >= 0
    json.dumps(point, allow_nan=False)


def test_rippling_speed_equals_machine_at_speed() -> None:
    device = machines.device("wang2017")
    speeds = experiment.SpeedDependence.from_model(experiment.LiftedModel(device), 720)
    for rpm in (35.0, 45.0):
        other = Device(device.machine.with_numbers({"speed_rpm": rpm}), "exact")
        force = other.support(other.prologue(other.design), sample_angles(720, 2 * np.pi))
        assert speeds.weight + (rpm * np.pi / 30) ** 2 * speeds.a == pytest.approx(force, rel=1e-12)
    period = np.fft.fftfreq(720, 1 / 720)
    slope = np.real(np.fft.ifft(1j * period * np.fft.fft(speeds.b)))
    assert slope == pytest.approx(speeds.a, abs=2e-3 * np.abs(speeds.a).max())
