"""Commands for machines of other rooms: numbers of the engine, against the rooms' own, and refusals
with a reason.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import load_machine
from tests.support.cli import answer
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
