"""`planter audit wang2017 --experiment`: hypotheses on the measured figures, checked without the operators."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from planter import Device, load_machine, simulate
from planter.audit.presentation import plot_hypotheses
from tests.support.cli import answer, refusal

MEASURED = {"max_N": 171.96, "min_N": 24.93, "variance_N2": 1033.23}


def compute_lever_figures(lever_mm: float) -> list[float]:
    """Return maximum, minimum and variance of support force and torque of the drive at a lever, by `simulate`."""
    at = simulate(Device(load_machine("wang2017"), "exact"), at_deg=np.arange(0, 360, 0.5).tolist()).result.at
    force = np.array([row.support_N + row.M_L_Nm / (lever_mm * 1e-3) for row in at])
    return [float(force.max()), float(force.min()), float(force.var())]


def test_hypotheses_reach_figures(tmp_path: Path) -> None:
    result = answer("audit", "wang2017", "--experiment", "--out", str(tmp_path))["experiment"]
    rows = {row["name"]: row for row in result["hypotheses"]}
    assert {key: result["measured"][key] for key in MEASURED} == MEASURED
    lever = rows["lever M_L_Nm"]
    figures = compute_lever_figures(lever["parameters"]["lever M_L_Nm.lever"]["value"])
    assert [lever[key] for key in MEASURED] == pytest.approx(figures, rel=1e-3)
    assert lever["largest_miss_percent"] < 7
    assert [name for name, row in rows.items() if row["reached"]] == ["lever M_L_Nm + elastic mount"]
    for row in rows.values():
        misses = [abs(row[key] / value - 1) for key, value in MEASURED.items()]
        assert row["largest_miss_percent"] == pytest.approx(100 * max(misses))
        assert row["range_N"] == pytest.approx(row["max_N"] - row["min_N"])
    assert rows["rigid"]["range_N"] < 4
    assert rows["only F_O1y_N"]["range_N"] == pytest.approx(108, rel=0.01)
    assert rows["only F_O1y_N"]["variance_N2"] == pytest.approx(508, rel=0.01)
    assert len(result["statements"]) == len(rows) + 2
    bars = plot_hypotheses(result).axes[0].patches
    intervals = [(bar.get_x(), bar.get_width()) for bar in bars if isinstance(bar, Rectangle)]
    expected = [(row["min_N"], row["range_N"]) for row in result["hypotheses"]]
    assert np.array(intervals) == pytest.approx(np.array(expected))
    assert {path.name for path in tmp_path.iterdir()} >= {"experiment.svg", "experiment.png"}


def test_lever_of_prototype_is_reproduced() -> None:
    assert compute_lever_figures(37.2) == pytest.approx([177.0, 30.0, 926], rel=2e-3)


def test_paper_without_experiment_is_refused() -> None:
    assert "--experiment needs one of the papers wang2017" in refusal("audit", "sun2019", "--experiment")
