"""Calibration: the fit finds what it is told to find, stays in its bounds and says what it does not settle."""

import jsonschema
import numpy as np
import pytest

from planter.errors import InputError
from planter.planting import calibration, cycle, file, tables
from planter.planting.calibration import Force, Inputs
from planter.planting.model import Device
from planter.planting.report.page import device_page
from planter.terminal.console import Console
from tests.support.schemas import committed


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
    jsonschema.validate(found.table(), committed("calibrate"))
    assert found.target == {"max_N": 158.94, "min_N": 36.77, "variance_N2": 1907.32}
    assert found.reached.keys() == found.target.keys()
    assert set(found.other_model.table()) == {"range_N", "variance_N2", "mean_N"}
    assert all(f.lower <= f.value <= f.upper and f.origin == "calibrated" for f in found.fitted)
    assert found.rank <= 3
    misses = {key: 100 * (found.reached[key] / value - 1) for key, value in found.target.items()}
    assert found.miss_percent == pytest.approx(misses)
    assert found.met is (max(map(abs, misses.values())) <= 1)


def test_the_devices_that_are_handed_in_stay_as_they_are(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration, "GENERATIONS", 1)
    both = Device(device.machine, "printed"), Device(device.machine, "exact")
    before = [one.constants for one in both]
    values = [one.constants.copy() for one in both]
    seen: list[bool] = []
    searched = calibration._searched

    def watched(*arguments):
        found = searched(*arguments)
        seen.append(all((one.constants == value).all() for one, value in zip(both, values, strict=True)))
        return found

    monkeypatch.setattr(calibration, "_searched", watched)
    calibration.calibrate(*both, "table1")
    assert seen == [True, True]
    assert all(one.constants is array for one, array in zip(both, before, strict=True))
    assert not any(one.compiled for one in both)


RESULT = {
    "machine": "m", "model": "printed", "met": False, "statement": "",
    "fitted": [{"name": "mass.sun_kg", "value": 0.7, "unit": "kg", "lower": 0.1, "upper": 1.5, "origin": "calibrated"}],
    "target": {"max_N": 100.0}, "reached": {"max_N": 88.0}, "miss_percent": {"max_N": -12.0}, "rank": 1,
    "other_model": {"range_N": 3.0}, "largest_inertia_range_N": 40.0,
}  # fmt: skip


@pytest.mark.parametrize(("miss", "word"), [(-0.12, "is missed: max_N by -12.0 %"), (0.009, "is met")])
def test_the_first_line_and_the_page_say_whether_the_target_is_met(
    miss: float, word: str, device: Device, capsys: pytest.CaptureFixture[str]
) -> None:
    statement = calibration._statement("table1", {"max_N": miss})
    result = {**RESULT, "statement": statement, "met": abs(miss) <= 0.01}
    tables.calibration(Console(as_json=False), result)
    assert word in capsys.readouterr().out.splitlines()[0]
    page = device_page(device.machine, device.sidecar, result, {})
    assert "Calibration of the planting device wang2017" in page
    assert "Simulation of" not in page
    body = page[page.index("<section") :] if "<section" in page else page
    assert body.index(word) < body.index("mass.sun_kg") < body.index("Results")
    assert ("warning" in body[: body.index(word)].rpartition("<p")[2]) is ("missed" in word)
    assert "calibrated" in body
    assert "miss / %" in body


def test_an_unknown_target_is_refused(device: Device) -> None:
    with pytest.raises(InputError, match="--target = table2 is not allowed: did you mean table1"):
        calibration.calibrate(device, device, "table2")
