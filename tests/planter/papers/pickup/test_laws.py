"""The train against laws of kinematics: rolling, common tangent, dwell, locking arcs; a dwell with
smooth ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planter.errors import GeometryError
from planter.files import examples
from planter.gears.geometry.locking_arcs import compute_horn_reaches
from planter.papers.pickup import gears as locks
from planter.papers.pickup.analysis import build_result
from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.gears import build_rolling, compute_locking_arcs
from planter.papers.pickup.law import CosineLaw, Dwell
from planter.papers.pickup.model import PickupTrain
from planter.papers.pickup.scene import outline_locking_arcs
from tests.planter.papers.pickup.pickups import END, START, P, arm, built_in, tips
from tests.support.cli import below
from tests.support.tables import read_cycle_csv

TRAINS = {name: built_in(name) for name in ("yu2023", "yu2023-path")}


@pytest.fixture(params=TRAINS.values(), ids=TRAINS.keys())
def train(request: pytest.FixtureRequest) -> PickupTrain:
    return request.param


def test_arm_gains_a_revolution_per_cycle(train: PickupTrain) -> None:
    t = np.linspace(-3, 3, 50)
    assert train.law.arm(t + 2 * np.pi) - train.law.arm(t) == pytest.approx(2 * np.pi, abs=1e-12)
    assert train.integral(lambda x: train.law.slopes(x)[0]) == pytest.approx(2 * np.pi, abs=1e-9)
    assert train.law.arm(np.zeros(1))[0] == pytest.approx(np.pi, abs=1e-6)


def test_in_the_dwell_the_tip_turns_with_the_carrier(train: PickupTrain) -> None:
    dwell = train.law.dwell
    t = np.linspace(dwell.start, dwell.end, 40)
    rows = train.motion(t)
    assert np.ptp(rows["L3"]) < 1e-15
    assert np.hypot(rows["vx_S"], rows["vy_S"]) == pytest.approx(
        rows["L3"] * train.omega, rel=1e-12
    )
    assert np.ptp(train.law.arm(t)) < 1e-12
    outside = np.array([dwell.start - 1e-3, dwell.end + 1e-3])
    assert (np.abs(train.motion(outside)["L3"] - rows["L3"][0]) > 1e-5).all()


def test_locking_arcs_are_a_circle_about_the_sun(train: PickupTrain) -> None:
    arcs, dwell = compute_locking_arcs(train), train.law.dwell
    convex, concave = outline_locking_arcs(train, arcs)
    radius = float(train.law.arm(np.array([dwell.start]))[0])
    turned = (concave[0] + 1j * concave[1]) * np.exp(1j * radius) + train.geometry.a1
    assert np.abs(turned) == pytest.approx(arcs.radius)
    assert np.hypot(*convex) == pytest.approx(arcs.radius)
    assert np.ptp(np.unwrap(np.arctan2(convex[1], convex[0]))) == pytest.approx(dwell.width)
    for place, end in zip(concave.T[[0, -1]], ((1, -1), (0, 1)), strict=True):
        assert _from_pitch_curve(train, place, *end) == pytest.approx(
            train.teeth[2] * train.teeth[0], rel=1e-6
        )
    wrong = (concave[0] + 1j * concave[1]) * np.exp(1j * (radius + 0.1)) + train.geometry.a1
    assert np.ptp(np.abs(wrong)) > 1e-3


def _from_pitch_curve(train: PickupTrain, place: np.ndarray, end: int, sense: int) -> float:
    """Distance of a place from the intermediate gear's pitch curve beside an end of its teeth."""
    t = train.toothed[end] + sense * np.linspace(0, 1, 20001)
    curve = train.pitch(t)
    return float(np.hypot(curve["x2"] - place[0], curve["y2"] - place[1]).min())


def test_locking_arcs_hold_in_both_directions() -> None:
    """A horn on either side of the line of centres, as the intermediate gear's tips are there in
    the dwell.
    """
    train = TRAINS["yu2023"]
    arcs = compute_locking_arcs(train)
    addendum = train.teeth[2] * train.teeth[0]
    assert max(arcs.ends) - addendum < arcs.radius < max(arcs.ends)
    assert min(arcs.ends) < max(arcs.ends) - addendum
    assert min(arcs.reaches) > np.radians(3)
    with pytest.raises(GeometryError, match="no horn"):
        compute_horn_reaches(build_rolling(train), min(arcs.ends), addendum)


def test_dwell_without_arcs_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(*_: object) -> float:
        raise GeometryError("no horn")

    monkeypatch.setattr(locks, "compute_arc_radius", nothing)
    assert compute_locking_arcs(TRAINS["yu2023"]) is None
    result = build_result(load_pickup("yu2023"), TRAINS["yu2023"])
    assert result.locking_arcs is None
    assert "locking arcs" in {warning.name for warning in result.warnings}


def test_law_and_path_drive_the_same_train() -> None:
    by_law, by_path = TRAINS["yu2023"], TRAINS["yu2023-path"]
    t = np.linspace(0, 2 * np.pi, 500)
    assert np.abs(by_law.law.arm(t) - by_path.law.arm(t)).max() < 5e-4
    assert np.abs(by_law.tip(t) - by_path.tip(t)).max() < 5e-5


def test_built_in_law_equals_reference() -> None:
    t = np.linspace(-7, 9, 400)
    train = TRAINS["yu2023"]
    assert np.abs(train.law.arm(t) - arm(t)).max() < 1e-13
    assert np.abs(train.tip(t) - tips(t, arm(t))).max() < 1e-15
    assert train.law.mean_on_teeth == pytest.approx(1.1606603790, abs=1e-9)


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
