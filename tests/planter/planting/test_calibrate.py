"""Calibration: the fit finds what it is told to find, stays in its bounds and says what it does not settle."""

import numpy as np
import pytest

from planter.errors import InputError
from planter.planting import calibration, cycle, file
from planter.planting.calibration import Force, Inputs
from planter.planting.model import Device


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(file.load("wang2017", {"objective.samples": 60}), "printed")


def test_every_input_is_one_of_the_machine_and_assumed(device: Device) -> None:
    inputs = Inputs.load()
    assert len(inputs.places(device)) == len(inputs.paths) > 15
    assert (inputs.lower < inputs.upper).all()
    assert all(device.machine.origin(path).startswith("assumed") for path in inputs.paths)


def test_the_force_of_the_own_inputs_is_the_device_s_own(device: Device) -> None:
    force = Force(device, Inputs.load())
    at = device.prologue(device.design)
    assert force(force.start()) == pytest.approx(device.support(at, cycle.angles(60)), rel=1e-12)


def test_a_target_that_the_model_can_reach_is_reached_and_one_out_of_reach_is_not(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(calibration, "GENERATIONS", 15)
    force = Force(device, Inputs.load())
    hidden = np.random.default_rng(3).uniform(0.2, 0.8, len(force.inputs.paths))
    wanted = calibration._reached(force(hidden), {"max_N": 0.0, "min_N": 0.0, "variance_N2": 0.0})
    found = calibration._fitted(force, wanted)
    assert ((found >= 0) & (found <= 1)).all()
    assert calibration._reached(force(found), wanted) == pytest.approx(wanted, rel=1e-6)
    assert calibration._rank(force, found, wanted) == 3
    beyond = {**wanted, "variance_N2": (wanted["max_N"] - wanted["min_N"]) ** 2}
    missed = calibration._reached(force(calibration._fitted(force, beyond)), beyond)
    assert missed["variance_N2"] < 0.9 * beyond["variance_N2"] or missed["max_N"] > 1.1 * beyond["max_N"]


def test_the_result_has_the_keys_of_the_contract(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration, "GENERATIONS", 2)
    other = Device(device.machine, "exact")
    found = calibration.calibrate(device, other, "table1")
    assert found.keys() >= {"fitted", "target", "reached", "rank", "other_model"}
    assert found["target"] == {"max_N": 158.94, "min_N": 36.77, "variance_N2": 1907.32}
    assert found["reached"].keys() == found["target"].keys()
    assert found["other_model"].keys() == {"range_N", "variance_N2", "mean_N"}
    assert all(f["lower"] <= f["value"] <= f["upper"] and f["origin"] == "calibrated" for f in found["fitted"])
    assert found["rank"] <= 3


def test_an_unknown_target_is_refused(device: Device) -> None:
    with pytest.raises(InputError, match="--target = table2 is not allowed: did you mean table1"):
        calibration.calibrate(device, device, "table2")
