"""`planter calibrate FILE --data`: values of a mechanism come back from a noisy curve, within their
intervals.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.errors import ComputationError, InputError
from planter.measured import reading
from planter.measured.curve import Chosen, MeasuredCurve
from planter.measured.logger_table import list_units
from planter.measured.reading import Columns
from planter.mechanism.calibration import MeasuredSource, calibrate_to_data
from planter.mechanism.file import load
from planter.mechanism.model import Model
from planter.task import AUTO, Means
from tests.support import own
from tests.support.cli import answer, refusal

TRUE = {"m_s_kg": 1.8, "k_N_m": 720.0, "r_mm": 60.0}
"""Values that differ from those of the file by 20 %."""
NOISE = 0.4


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A curve of a force [kN] and a place [cm] over the time, as a recorder writes them."""
    degrees = np.arange(0, 360, 2.0)
    results = Model(own.machine("slider_crank", "", **TRUE)).results(np.radians(degrees))
    rng = np.random.default_rng(11)
    force = (results["F_Ox_N"] + 2.0 + rng.normal(0, NOISE, len(degrees))) / 1e3
    place = (results["s_mm"] + rng.normal(0, 0.1, len(degrees))) / 10
    rows = zip(degrees / 360 / 5 * 1e3, force, place, strict=True)
    path = tmp_path_factory.mktemp("data") / "recorded.csv"
    lines = [";".join(f"{number:.9f}".replace(".", ",") for number in row) for row in rows]
    path.write_text("\n".join(["t [ms];force [kN];place [cm]", *lines]) + "\n", encoding="utf-8")
    return path


def test_fitted_intervals_contain_true_values(data: Path) -> None:
    bounds = {
        "m_s_kg": (1.0, 3.0),
        "k_N_m": (300.0, 1500.0),
        "r_mm": (40.0, 80.0),
        "offset_N": (-9.0, 9.0),
    }
    source = MeasuredSource(own.machine("slider_crank"), data, Columns("force", time="t"), "F_Ox_N")
    calibrated = calibrate_to_data(source, bounds)
    truth = {"values.m_s_kg": 1.8, "values.k_N_m": 720.0, "values.r_mm": 60.0, "offset_N": 2.0}
    assert (calibrated.result.outcome, calibrated.result.rank, calibrated.result.other_model) == (
        "explained",
        4,
        None,
    )
    assert calibrated.result.reached.rms == pytest.approx(NOISE, rel=0.15)
    for entry in calibrated.result.fitted:
        low, high = entry.interval
        assert low < truth[entry.name] < high, entry.name
        assert high - low < 0.25 * (entry.upper - entry.lower)
    assert calibrated.machine is not None
    assert calibrated.machine.si("values.r_mm") == pytest.approx(0.06, rel=0.05)


def test_lengths_are_fitted_in_their_unit(data: Path, tmp_path: Path) -> None:
    path = str(own.generated("slider_crank") / "slider_crank.toml")
    call = (
        "--data",
        str(data),
        "--column",
        "place",
        "--time",
        "t",
        "--quantity",
        "s_mm",
        "--fit",
        "r_mm=40:80",
    )
    result = answer("calibrate", path, *call, "--out", str(tmp_path))
    assert (result["unit"], result["models"].keys()) == ("mm", {"derived"})
    assert result["reached"]["rms"] == pytest.approx(0.1, rel=0.2)
    assert load(tmp_path / "calibrated.toml").values["r_mm"] == pytest.approx(60.0, abs=0.1)
    assert "time" not in (tmp_path / "residuals.csv").read_text(encoding="utf-8").splitlines()[-1]


def test_bounds_beyond_closure_only_cost_starts(data: Path) -> None:
    """A crank longer than the rod has a dead point: starts there end nowhere, the others find the
    truth.
    """
    source = MeasuredSource(own.machine("slider_crank"), data, Columns("place", time="t"), "s_mm")
    result, by_workers = (
        calibrate_to_data(source, {"r_mm": (40.0, 400.0)}, means=means).result
        for means in (AUTO, Means(2))
    )
    assert by_workers.table() == result.table(), "every digit"
    assert result.fitted[0].interval[0] < 60.0 < result.fitted[0].interval[1]
    assert result.starts == 8 > result.agreeing_starts
    with pytest.raises(ComputationError, match="narrow the bounds"):
        calibrate_to_data(source, {"r_mm": (300.0, 400.0)})


def test_restart_ignores_earlier_values(data: Path) -> None:
    """Loops are closed near where they were before, which must not reach from one search into the
    next.
    """
    machine = own.machine("slider_crank")
    measured = reading.read(
        data, Columns("place", time="t"), float(machine.data[machine.speed]), "mm"
    )
    chosen = Chosen.from_bounds(machine, {"r_mm": (40.0, 80.0)})
    curve = MeasuredCurve(machine, chosen, measured, "s_mm")
    first, second = (np.array([r]) for r in (0.043, 0.071))
    alone = curve(second)[0].tobytes()
    curve(first)
    assert curve(second)[0].tobytes() != alone
    curve.restart()
    assert curve(second)[0].tobytes() == alone


def test_invalid_fit_is_rejected(data: Path) -> None:
    path = str(own.generated("slider_crank") / "slider_crank.toml")
    call = ("calibrate", path, "--data", str(data), "--time", "t")
    assert "did you mean 'force [kN]'" in refusal(
        *call, "--column", "forcd", "--quantity", "F_Ox_N", "--fit", "r_mm=1:2"
    )
    assert "--quantity must name what was measured" in refusal(
        *call, "--column", "force", "--fit", "r_mm=40:80"
    )
    assert "did you mean F_Ox_N" in refusal(
        *call, "--column", "force", "--quantity", "F_Oxx", "--fit", "r_mm=40:80"
    )
    assert "--unit must be one of mm" in refusal(
        *call, "--column", "force", "--quantity", "s_mm", "--fit", "r_mm=1:2"
    )
    assert "--data must name a CSV file" in refusal("calibrate", path)
    unnamed = MeasuredSource(own.machine("slider_crank"), data, Columns("force", time="t"))
    with pytest.raises(InputError, match="--quantity must name"):
        calibrate_to_data(unnamed, {"r_mm": (1, 2)})


def test_column_units_match_quantity() -> None:
    assert list_units("mm")["cm"] == pytest.approx(10.0)
    assert list_units("rad/s")["r/min"] == pytest.approx(np.pi / 30)
    assert list_units("N m")["kN m"] == 1e3
    assert list_units("")["%"] == pytest.approx(0.01)
    assert list_units("kg m2") == {"kg m2": 1.0}
