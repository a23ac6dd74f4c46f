"""A dwell with smooth ends: slope and velocity are continuous, and the arm still gains one turn in
a turn.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.files import examples
from planter.papers.pickup.law import CosineLaw, Dwell
from tests.planter.papers.pickup.pickups import END, START, P
from tests.support.cli import below
from tests.support.tables import read_cycle_csv

run, answer, refusal = below("pickup")

TRANSITION = np.radians(20)
LAW = CosineLaw(P, Dwell(START, END), transition=TRANSITION)


def smooth_file(folder: Path, transition: float | None = None) -> str:
    """The built-in pick-up with the lines of its example that make the ends smooth."""
    text = examples.example("yu2023", "pickup", ".toml").replace(
        '# ends = "smooth"', 'ends = "smooth"  #'
    )
    if transition is not None:
        text = text.replace("# transition_deg = 15", f"transition_deg = {transition}  #")
    (folder / "smooth.toml").write_text(text)
    return str(folder / "smooth.toml")


def test_the_arm_gains_a_turn_in_a_turn_and_rests_in_the_dwell() -> None:
    t = np.linspace(-7, 9, 4001)
    assert LAW.arm(t + 2 * np.pi) - LAW.arm(t) == pytest.approx(
        np.full(t.shape, 2 * np.pi), abs=1e-12
    )
    dwell_arm = LAW.arm(np.linspace(START, END, 50))
    assert np.ptp(dwell_arm) < 1e-12
    assert LAW.arm(np.zeros(1))[0] == pytest.approx(np.pi, abs=1e-14)


def test_slopes_are_the_derivatives_of_the_angle() -> None:
    t = np.linspace(END - 2 * np.pi, START, 5001)[1:-1]
    t = t[np.min(np.abs(t[:, None] - LAW.breakpoints()), axis=1) > 1e-3]
    h = 1e-5
    for lower, upper in (
        (LAW.arm, 0),
        (lambda x: LAW.slopes(x)[0], 1),
        (lambda x: LAW.slopes(x)[1], 2),
    ):
        numeric = (lower(t + h) - lower(t - h)) / (2 * h)
        assert LAW.slopes(t)[upper] == pytest.approx(numeric, abs=2e-5)


def test_slope_and_rate_are_continuous_and_end_at_zero() -> None:
    for joint in LAW.breakpoints():
        inside = LAW.slopes(np.array([joint - 1e-9, joint + 1e-9]))
        assert inside[0, 0] == pytest.approx(inside[0, 1], abs=1e-6)
        assert inside[1, 0] == pytest.approx(inside[1, 1], abs=1e-5)
    ends = LAW.slopes(np.array([LAW.breakpoints()[0], LAW.breakpoints()[-1]]))
    assert ends[:2] == pytest.approx(np.zeros((2, 2)), abs=1e-9)


def test_law_outside_transitions_equals_paper() -> None:
    t = np.linspace(LAW.breakpoints()[1], LAW.breakpoints()[2], 100)
    assert LAW.slopes(t)[0] == pytest.approx(LAW.mean_on_teeth * (1 + P * np.cos(t)), rel=1e-12)


@pytest.mark.usefixtures("blank_figures")
def test_command_reports_no_jump_and_undriven_angles(tmp_path: Path) -> None:
    result = answer(smooth_file(tmp_path), "--at", "200", "--at", "0")
    names = [warning["name"] for warning in result["warnings"]]
    assert not any("velocity" in name for name in names)
    message = next(
        warning["message"]
        for warning in result["warnings"]
        if warning["name"] == "no teeth at the dwell's start"
    )
    assert "from t = 195 to 210 deg" in message
    assert result["slope"]["mean"] == pytest.approx(1, abs=1e-12)
    assert [row["contact_ratio"] is None for row in result["at"]] == [True, False]
    cycle = answer(smooth_file(tmp_path, 20), "--out", str(tmp_path / "out"))
    assert cycle["round_trip_error_rad"] < 1e-5
    _, columns = read_cycle_csv(tmp_path / "out" / "cycle.csv")
    ring = np.append(columns["tip_vx_mm_s"], columns["tip_vx_mm_s"][0])
    assert np.abs(np.diff(ring)).max() < 100


def test_smooth_ends_and_moved_points_do_not_go_together(tmp_path: Path) -> None:
    assert 'law.ends = "smooth" cannot be used' in refusal(smooth_file(tmp_path), "--optimise")


def test_unsmoothable_slope_is_distinguished() -> None:
    assert LAW.rises
    assert not CosineLaw(1.5, Dwell(START, END), transition=TRANSITION).rises
