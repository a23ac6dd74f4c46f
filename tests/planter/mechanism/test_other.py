"""Commands for machines of other rooms: numbers of the engine, against the rooms' own, and refusals
with a reason.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.mechanism.cycle import simulate_machine
from tests.support.cli import answer, refusal
from tests.support.tables import read_cycle_csv


def test_pickup_simulation_equals_pickup_command() -> None:
    result = answer("simulate", "yu2023", "--at", "30", "--samples", "360")
    state = answer("pickup", "yu2023", "--at", "30")["at"][0]
    (at,) = result["at"]
    assert (at["x_S_mm"], at["y_S_mm"]) == pytest.approx(tuple(state["tip_mm"]), rel=1e-12)
    assert at["epsilon"] == pytest.approx(state["contact_ratio"], rel=1e-12)
    assert np.hypot(at["vx_S_m_s"], at["vy_S_m_s"]) == pytest.approx(
        state["tip_speed_mm_s"] / 1e3, rel=1e-12
    )
    peak = next(entry for entry in result["designer"]["peaks"] if entry["name"] == "y_S")
    assert peak["max"] >= result["quantities"]["y_S_mm"]["max"]
    assert result["repeats_after_turns"] == 1


def test_linkage_sensitivity_equals_differences() -> None:
    result = answer(
        "sensitivity", "sun2019-corrected", "--least", "X_f at 40", "--all", "--samples", "24"
    )
    machine = load_machine("sun2019-corrected")
    key = max(result["scaled"], key=lambda name: abs(result["scaled"][name]))
    index = machine.find_index(key)
    step, ends = 1e-6 * machine.data[index], []
    for sign in (1, -1):
        data = machine.data.copy()
        data[index] += sign * step
        (at,) = simulate_machine(machine.with_data(data), 24, [40.0]).result.at
        ends.append(at["X_f_mm"])
    difference = (ends[0] - ends[1]) / (2 * step) * machine.values[index].factor
    assert result["gradient"][key] == pytest.approx(difference, rel=1e-5)


def test_a_place_of_a_pick_up_is_fitted_to_data(tmp_path: Path) -> None:
    machine = load_machine("yu2023", {"bars.L2_mm": 170.0})
    degrees = np.arange(0, 360, 10.0)
    at = simulate_machine(machine, 24, degrees.tolist()).result.at
    rows = [f"{degree},{state['x_S_mm']}" for degree, state in zip(degrees, at, strict=True)]
    data = tmp_path / "tip.csv"
    data.write_text("\n".join(["angle [deg],x [mm]", *rows]) + "\n", encoding="utf-8")
    call = ("--column", "x", "--angle", "angle", "--quantity", "x_S_mm", "--fit", "L2_mm=150:190")
    result = answer(
        "calibrate", "yu2023", "--data", str(data), *call, "--out", str(tmp_path / "fit")
    )
    assert result["fitted"][0]["value"] == pytest.approx(170.0, abs=1e-4)
    fitted = load_machine(str(tmp_path / "fit" / "calibrated.toml"))
    assert fitted.data[fitted.find_index("bars.L2_mm")] == result["fitted"][0]["value"] * 1e-3


@pytest.mark.usefixtures("blank_figures")
def test_clutch_cycle_ends_where_link_returns(tmp_path: Path) -> None:
    result = answer(
        "simulate", "shi2021", "--samples", "24", "--speed-rpm", "2", "--out", str(tmp_path)
    )
    _, columns = read_cycle_csv(tmp_path / "values.csv")
    machine = load_machine("shi2021", speed_rpm=2.0)
    assert columns["phi_deg"][-1] == pytest.approx(np.degrees(machine.turn) * 23 / 24)
    assert columns["shift_mm"].max() == pytest.approx(
        result["quantities"]["shift_mm"]["max"], rel=1e-14
    )
    assert machine.data[machine.speed] == pytest.approx(np.pi / 15, rel=1e-12)
    assert (result["repeats_after_turns"], result["not_repeating"]) == (1, {}), (
        "velocities jump at the ends"
    )
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "radius of the arc rack" in page
    assert "set on the command line" in page


def test_irrelevant_options_are_refused() -> None:
    motor = ("--stall-Nm", "1", "--idle-rpm", "60", "--flywheel-kgm2", "1")
    assert "no torque of a motor" in refusal("drive", "yu2023", *motor)
    assert "--lift does not apply to yu2023" in refusal("simulate", "yu2023", "--lift")
    assert "--least" in refusal("sensitivity", "yu2023")
    assert "did you mean x_S" in refusal("sensitivity", "yu2023", "--all", "--least", "range x_SS")
