"""Calibration: the fit finds what it is told to find, stays in its bounds and says what it does not
settle.
"""

import numpy as np
import pytest

from planter.engine.solvers.sampled_cycle import sample_angles
from planter.errors import InputError
from planter.papers.planting import calibration, file
from planter.papers.planting.calibration import FLANK
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.results import CalibrationFound, Statistics
from planter.papers.planting.unpublished_inputs import (
    FIGURES,
    CalibrationForce,
    CalibrationInputs,
    ForceFit,
    count_determined,
    fit_from_starts,
    fit_nearest,
)

pytestmark = pytest.mark.usefixtures("kernel_cache")
LAWS = ("modified trapezoid",)


@pytest.fixture(scope="module")
def machine() -> PlantingMachine:
    return file.load("wang2017")


@pytest.fixture(scope="module")
def calibrated(machine: PlantingMachine) -> CalibrationFound:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calibration, "SLOW_STARTS", calibration.STARTS["lanes"])
        return calibration.calibrate(machine, "printed", "table1", LAWS)


@pytest.fixture(scope="module")
def force(machine: PlantingMachine) -> CalibrationForce:
    device = Device(calibration.with_flank(machine, LAWS[0]), "printed")
    return CalibrationForce(device, CalibrationInputs.with_events(device))


def fits(
    force: CalibrationForce, target: dict[str, float], pushing: bool = False
) -> list[ForceFit]:
    starts = [np.random.default_rng(seed).random(len(force.inputs)) for seed in range(6)]
    return sorted(
        fit_from_starts(force, target, pushing, starts, np.ones(3)), key=lambda fit: fit.rank
    )


def test_reachable_target_is_reached_and_other_missed(force: CalibrationForce) -> None:
    hidden = np.random.default_rng(33).uniform(0.2, 0.8, len(force.inputs))
    target = force(hidden).figures()
    best = fits(force, target)[0]
    assert ((best.z >= 0) & (best.z <= 1)).all()
    assert best.met
    assert best.worst < 1e-6
    assert count_determined(best) == 3
    beyond = {**target, "variance_N2": (target["max_N"] - target["min_N"]) ** 2}
    assert not fits(force, beyond)[0].met


def test_the_nearest_fit_is_nearer_and_keeps_target_and_contact(force: CalibrationForce) -> None:
    target = force(np.random.default_rng(33).uniform(0.2, 0.8, len(force.inputs))).figures()
    met = [fit for fit in fits(force, target, pushing=True) if fit.met]
    closer = fit_nearest(met[-1], pushing=True)
    assert closer.met
    assert closer.pushes
    assert closer.distance <= met[-1].distance
    worse = ForceFit(force, met[0].z, {**target, "max_N": 2 * target["max_N"]})
    assert not worse.met
    assert worse.rank > met[0].rank


def test_printed_model_meets_table_and_exact_does_not(calibrated: CalibrationFound) -> None:
    printed, exact = calibrated.models["printed"], calibrated.models["exact"]
    assert calibrated.met
    assert printed.met
    assert printed.cam_pushes
    assert not exact.met
    assert exact.front
    assert printed.front is None
    assert calibrated.choices[FLANK] in LAWS
    assert exact.miss_percent["variance_N2"] < -50
    for tradeoff in exact.front:
        remaining = [o for o in exact.front if o is not tradeoff]
        misses = np.abs(list(tradeoff.miss_percent.values()))
        assert not any((np.abs(list(o.miss_percent.values())) <= misses).all() for o in remaining)


def test_the_result_has_the_keys_of_the_contract(calibrated: CalibrationFound) -> None:
    table = calibrated.table()
    assert table.keys() >= {"fitted", "target", "reached", "rank", "other_model", "met", "choices"}
    assert calibrated.target == {"max_N": 158.94, "min_N": 36.77, "variance_N2": 1907.32}
    assert tuple(calibrated.reached) == FIGURES == tuple(calibrated.target)
    assert all(
        f.lower - 1e-12 <= f.value <= f.upper + 1e-12 and f.origin == "calibrated"
        for f in calibrated.fitted
    )
    misses = {
        key: 100 * (calibrated.reached[key] / value - 1) for key, value in calibrated.target.items()
    }
    assert calibrated.miss_percent == pytest.approx(misses)
    assert calibrated.events == pytest.approx({"rise_begins_deg": 160, "fall_begins_deg": 280})


def test_fitted_machine_reproduces_reached_values(
    calibrated: CalibrationFound, machine: PlantingMachine
) -> None:
    fitted = calibration.with_flank(machine, calibrated.choices[FLANK]).with_numbers(
        {f.name: f.value for f in calibrated.fitted}
    )
    for model in ("printed", "exact"):
        device = Device(fitted, model)
        turn = device.columns(device.design, sample_angles(machine.objective.samples, 2 * np.pi))
        statistics = Statistics.of_samples(turn["support_N"])
        if model == "printed":
            assert {key: getattr(statistics, key) for key in FIGURES} == pytest.approx(
                calibrated.reached, rel=1e-9
            )
            assert turn["F_E_N"].min() == pytest.approx(calibrated.least_push_N, rel=1e-6)
        else:
            assert statistics.range_N == pytest.approx(calibrated.other_model.range_N, rel=1e-9)


@pytest.mark.parametrize(
    ("target", "law", "message"),
    [
        ("table2", (), "--target = table2: did you mean table1"),
        ("table1", ("cycloid",), "--flank = cycloid: did you mean cycloidal"),
    ],
)
def test_an_unknown_target_or_law_is_refused(
    target: str, law: tuple[str, ...], message: str, machine: PlantingMachine
) -> None:
    with pytest.raises(InputError, match=message):
        calibration.calibrate(machine, "printed", target, law)
