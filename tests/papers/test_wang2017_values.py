"""The device of Wang et al. 2017 at its optimum with the input set S1: public values, computed
elsewhere.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planter.files import units
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device
from tests.support import machines, model

VALUES = tomllib.loads(Path(__file__).with_name("wang2017_values.toml").read_text(encoding="utf-8"))
ANGLES = np.radians([0.0, 100.0])


def by_array_code(device: Device, phi: np.ndarray) -> model.Outputs:
    return model.ArrayModel.like(device)(np, phi, device.design, device.constants)


def displayed_values(device: Device, outputs: model.Outputs) -> dict[str, np.ndarray]:
    """Outputs of side 1 and shared ones, in the units of their keys."""
    vectors = device.sidecar["vectors"]
    keys = {
        entry["name"]: units.display_key(entry["name"], entry["unit"])
        for entry in (*vectors["side"], *vectors["totals"])
    }
    values = outputs.side1 | outputs.totals
    return {keys[name]: values[name] / units.unit_factor(keys[name]) for name in values}


def deviations(
    kind: Model, code: Callable[[Device, np.ndarray], model.Outputs]
) -> dict[str, float]:
    """Largest difference to each public value; NaN stands where there is none."""
    device = machines.device("wang2017", kind)
    values = displayed_values(device, code(device, ANGLES))
    return {key: np.nanmax(np.abs(values[key] - value)) for key, value in VALUES[kind].items()}


@pytest.mark.parametrize("code", [model.cycle, by_array_code])
@pytest.mark.parametrize("kind", ["exact", "printed"])
def test_values_of_both_models(
    kind: Model, code: Callable[[Device, np.ndarray], model.Outputs]
) -> None:
    for key, deviation in deviations(kind, code).items():
        assert deviation < 1e-6, key


def test_the_models_differ_by_more_than_the_tolerance() -> None:
    forces = [
        model.cycle(machines.device("wang2017", kind), ANGLES).totals["F_support"]
        for kind in ("exact", "printed")
    ]
    assert np.abs(forces[0] - forces[1]).min() > 1


def gears(name: str) -> dict[str, float]:
    device = machines.device(name)
    h = device.prologue(device.design).h
    second = 1 + device.stages[0].terms
    return {"a1_mm": h[0] * 1e3, "b1": h[1], "b2": h[2], "a2_mm": h[second] * 1e3}


@pytest.mark.parametrize(
    ("key", "tolerance"), [("a1_mm", 1e-9), ("a2_mm", 1e-9), ("b1", 1e-10), ("b2", 1e-10)]
)
def test_gears(key: str, tolerance: float) -> None:
    assert gears("wang2017")[key] == pytest.approx(VALUES["gears"][key], abs=tolerance)
    assert abs(gears("compact")[key] - VALUES["gears"][key]) > 1e3 * tolerance


def test_every_published_value_is_compared() -> None:
    assert [len(VALUES[part]) for part in ("gears", "exact", "printed")] == [4, 21, 1]
