"""`planter audit wang2017 --experiment`: hypotheses on the measured figures, checked without the
operators.
"""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from planter import Device, load_machine, simulate
from planter.audit.presentation import plot_hypotheses
from tests.planter.measured.test_sensor import build_wang, write_file
from tests.support.cli import answer, refusal

MEASURED = {"max_N": 171.96, "min_N": 24.93, "variance_N2": 1033.23}


def compute_lever_figures(lever_mm: float) -> list[float]:
    """Return maximum, minimum and variance of support force and torque of the drive at a lever, by
    `simulate`.
    """
    at = simulate(
        Device(load_machine("wang2017"), "exact"), at_deg=np.arange(0, 360, 0.5).tolist()
    ).result.at
    force = np.array([row["support_N"] + row["M_L_Nm"] / (lever_mm * 1e-3) for row in at])
    return [float(force.max()), float(force.min()), float(force.var())]


def test_hypotheses_reach_figures(tmp_path: Path) -> None:
    result = answer(f"audit wang2017 --experiment --out {tmp_path}")["experiment"]
    rows = {row["name"]: row for row in result["hypotheses"]}
    assert {key: result["measured"][key] for key in MEASURED} == MEASURED
    lever = rows["lever M_L_Nm"]
    figures = compute_lever_figures(lever["parameters"]["lever M_L_Nm.lever"]["value"])
    assert [lever[key] for key in MEASURED] == pytest.approx(figures, rel=1e-3)
    assert lever["largest_miss_percent"] < 7
    assert [name for name, row in rows.items() if row["reached"]] == [
        "lever M_L_Nm + elastic mount"
    ]
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


def test_machine_file_states_a_hypothesis(tmp_path: Path) -> None:
    """The file's own inputs and sensor: figures of `simulate`, with the force of its rigid machine
    beside them.
    """
    file = build_wang(drive="M_L", lever_mm=37.2).with_numbers({"mass.planet_kg": 1.5})
    path = write_file(tmp_path, file)
    result = answer(f"audit wang2017 --experiment --machine {path}")["experiment"]
    rows = {row["name"]: row for row in result["hypotheses"]}
    cycle = answer(f"simulate {path} --model exact --samples 720")
    assert rows["stated"]["parameters"] == {}
    for row, seen in (("stated", cycle["measurement"]), ("rigid", None)):
        force = cycle["support_force"]
        expected = (
            [force[key] for key in MEASURED]
            if seen is None
            else [seen[key] for key in ("max", "min", "variance")]
        )
        assert [rows[row][key] for key in MEASURED] == pytest.approx(expected, rel=1e-3)
    assert rows["stated"]["range_N"] > 30 * rows["rigid"]["range_N"]
    assert rows["lever M_L_Nm"]["largest_miss_percent"] <= rows["stated"]["largest_miss_percent"]
    assert path in result["statements"][0]


def test_machine_file_without_a_force_is_refused(tmp_path: Path) -> None:
    path = write_file(tmp_path, build_wang(quantity="M_L_Nm"))
    message = refusal(f"audit wang2017 --experiment --machine {path}")
    assert "measurement.quantity" in message
    assert "M_L_Nm" in message
    assert "--machine needs --experiment" in refusal(f"audit wang2017 --machine {path}")


def test_paper_without_experiment_is_refused() -> None:
    assert "--experiment needs one of the papers wang2017" in refusal("audit sun2019 --experiment")
