"""The proof about Table 1 of docs/studies speaks of the exact model, and refuses what is false."""

from __future__ import annotations

import importlib.util
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from planter import load_machine, simulate
from planter.files.examples import example
from tests.support.structure import ROOT

pytest.importorskip("flint")

STUDIES = ROOT / "docs" / "studies"
RECORD = json.loads((STUDIES / "table1_theorem.json").read_text(encoding="utf-8"))


def load_checker() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_table1", STUDIES / "check_table1.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


checker = load_checker()
SUN_KG, CARRIER_KG = 1.3, 3.975
CAM = {
    "cam.opening_deg": checker.OPENING,
    **{f"cam.rise_delta_deg[{k}]": checker.RISE[k] for k in (0, 1)},
    **{f"cam.fall_delta_deg[{k}]": checker.FALL[k] for k in (0, 1)},
}


@pytest.fixture(autouse=True, scope="module")
def precision() -> Iterator[None]:
    with checker.ctx.workprec(checker.BITS):
        yield


@pytest.fixture(scope="module")
def train(precision: None) -> Any:
    return checker.Train()


def draw(seed: int, law: str, folder: Path) -> tuple[Any, dict[str, float]]:
    """Return the exact device with random inputs within the bounds, and these."""
    rng = np.random.default_rng(seed)
    bounds = {**checker.LINEAR, **CAM}
    inputs = {path: float(rng.uniform(*ends)) for path, ends in bounds.items()}
    # the spring, the rocker and the masses about the axis are of no account
    indifferent = {"spring.rate_N_m": rng.uniform(100, 3000), "mass.sun_kg": SUN_KG}
    file = folder / "device.toml"
    text = example("wang2017").replace('flank = "4-5-6-7 polynomial"', f'flank = "{law}"')
    file.write_text(text, encoding="utf-8")
    planet = inputs["mass.planet_kg"] * 4500e-6  # of inertia, enough for the farthest centroid
    changes = {**inputs, **indifferent, "inertia.J7_about_B1_kg_m2": planet}
    return load_machine(str(file), changes, model="exact"), inputs


def find_force(
    train: Any, law: str, inputs: dict[str, float], cam_deg: float
) -> tuple[float, float]:
    """Return what a side adds to the weight at a cam angle, and the radius of its ball [N]."""
    (rise, risen), (fall, fallen) = (
        (inputs[f"cam.{name}_delta_deg[0]"], inputs[f"cam.{name}_delta_deg[1]"])
        for name in ("rise", "fall")
    )
    opening = checker.arb(inputs["cam.opening_deg"]) * checker.DEGREE
    start, end, sign = (rise, risen, 1) if cam_deg < fall else (fall, fallen, -1)
    share = checker.arb(min(max((cam_deg - start) / (end - start), 0.0), 1.0))
    p, dp, ddp = checker.LAWS[law](share)
    if not start < cam_deg < end:
        dp = ddp = checker.arb(0)
    width = checker.arb(end - start) * checker.DEGREE
    swing = (
        opening * (p if sign > 0 else 1 - p),
        sign * opening * dp / width,
        sign * opening * ddp / width**2,
    )
    slopes = checker.differentiate(train(checker.arb(cam_deg) * checker.DEGREE), swing)[1]
    moments = checker.find_moments([inputs[path] for path in checker.LINEAR])
    force = checker.SPEED**2 * sum(m * s for m, s in zip(moments, slopes, strict=True))
    return float(force.mid()), float(force.rad())


@pytest.mark.parametrize("law", checker.LAWS)
def test_its_force_is_that_of_the_exact_model(law: str, train: Any, tmp_path: Path) -> None:
    device, inputs = draw(len(law), law, tmp_path)
    table = simulate(device, samples=360).to_frame()
    cam = np.mod(-np.array(table["phi72_deg"]), 360)
    force = np.array(table["support_N"])
    halves = inputs["mass.half_C1_kg"] + inputs["mass.half_C2_kg"]
    sides = 2 * (inputs["mass.middle_kg"] + inputs["mass.planet_kg"] + 2 * halves)
    weight = 9.81 * (SUN_KG + CARRIER_KG + sides)
    for index in (0, 20, 47, 88, 95, 110, 128, 150, 171):
        parts = [find_force(train, law, inputs, cam[k]) for k in (index, index + 180)]
        modelled = weight + sum(value for value, _ in parts)
        radius = sum(spread for _, spread in parts)
        assert radius < 1e-3
        assert modelled == pytest.approx(force[index], abs=radius + 1e-9)


def test_bounds_are_above_forces_within_them(train: Any, tmp_path: Path) -> None:
    square = float(checker.SPEED**2 / checker.PI)
    cover = checker.Cover(train)
    largest = cover.bound("harmonic", (29, 30), 16.0 / square)[0] * square
    assert largest < 16.0
    corner = {path: ends[1] for path, ends in checker.LINEAR.items()}
    corner |= {"mass.half_C1_kg": 0.02, "centroid.planet_xy_mm[1]": -30, "nozzle.C2_mm[2]": 5}
    corner |= {path: float(ends[1]) for path, ends in CAM.items()}
    corner |= {"cam.rise_delta_deg[1]": 155, "cam.fall_delta_deg[1]": 270}
    file = tmp_path / "device.toml"
    text = example("wang2017").replace('flank = "4-5-6-7 polynomial"', 'flank = "harmonic"')
    file.write_text(text, encoding="utf-8")
    device = load_machine(str(file), {**corner, "inertia.J7_about_B1_kg_m2": 0.03}, model="exact")
    force = np.array(simulate(device, samples=3600).to_frame()["support_N"])
    deviation = np.abs(force - force.mean()).mean()
    assert 10.0 < deviation < largest
    # the bound of the theorem itself: variance <= range * deviation / 2
    assert force.var() <= np.ptp(force) * deviation / 2


def test_devices_beyond_the_bounds_are_not_excluded(train: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(checker, "FINEST", 2.0)
    monkeypatch.setattr(checker, "NARROWEST", 2)
    heavier = {**checker.LINEAR, "mass.half_C2_kg": (0.1, 2.4)}
    cover = checker.Cover(train, heavier)
    limit = checker.find_limit(*checker.TABLE_1["experiment"])
    with pytest.raises(ArithmeticError, match="cycloidal"):
        checker.bound_deviation(cover, ["cycloidal"], limit)


def test_points_that_a_device_has_are_not_excluded() -> None:
    record = json.loads((STUDIES / "wang2017.json").read_text(encoding="utf-8"))
    points = [front["largest_range"] for front in record["fronts"]]
    points += [point for front in record["fronts"] for point in front["points"]]
    for point in points:
        assert point["variance_N2"] < point["range_N"] * RECORD["mean_deviation_N"] / 2
    for name, (span_N, variance_N2) in checker.TABLE_1.items():
        assert RECORD["rows"][name]["most_variance_N2"] < float(variance_N2)
        assert RECORD["rows"][name]["range_N"] == float(span_N)


@pytest.mark.long
def test_the_record_is_what_the_checker_finds(tmp_path: Path, monkeypatch: Any) -> None:
    out = tmp_path / "theorem.json"
    monkeypatch.setattr(sys, "argv", ["check_table1.py", "--out", str(out)])
    assert checker.main() == 0
    assert json.loads(out.read_text(encoding="utf-8")) == RECORD
