"""The train against laws of kinematics: closure, rolling, common tangent, Euler-Savary, rates,
dwell, locking arcs.
"""

from dataclasses import replace

import numpy as np
import pytest

from planter.errors import GeometryError
from planter.gears.geometry.locking_arcs import compute_horn_reaches
from planter.papers.pickup import gears as locks
from planter.papers.pickup.analysis import build_result
from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.gears import build_rolling, compute_locking_arcs
from planter.papers.pickup.model import PickupTrain
from planter.papers.pickup.scene import outline_locking_arcs
from tests.planter.papers.pickup.pickups import arm, built_in, tips

TRAINS = {name: built_in(name) for name in ("yu2023", "yu2023-path")}


@pytest.fixture(params=TRAINS.values(), ids=TRAINS.keys())
def train(request: pytest.FixtureRequest) -> PickupTrain:
    return request.param


def contacts(
    train: PickupTrain, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Both pitch curves at t in the carrier's frame, x along the centre line: places and
    tangents.
    """
    step, turned = 1e-6, train.law.arm(t) - np.pi

    def law_path(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        build_result = train.pitch(at)
        return build_result["x1"] + 1j * build_result["y1"], build_result["x2"] + 1j * build_result[
            "y2"
        ]

    sun, middle = (
        curve * np.exp(sign * 1j * angle)
        for curve, sign, angle in zip(law_path(t), (-1, 1), (t, np.pi + turned), strict=True)
    )
    ahead, behind = law_path(t + step), law_path(t - step)
    d1, d2 = ((a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True))
    return sun, middle + train.geometry.a1, d1 * np.exp(-1j * t), d2 * np.exp(1j * (np.pi + turned))


def inside(train: PickupTrain, count: int = 300) -> np.ndarray:
    return train.samples(count + 2)[1:-1]


def test_arm_gains_a_revolution_per_cycle(train: PickupTrain) -> None:
    t = np.linspace(-3, 3, 50)
    assert train.law.arm(t + 2 * np.pi) - train.law.arm(t) == pytest.approx(2 * np.pi, abs=1e-12)
    assert train.integral(lambda x: train.law.slopes(x)[0]) == pytest.approx(2 * np.pi, abs=1e-9)
    assert train.law.arm(np.zeros(1))[0] == pytest.approx(np.pi, abs=1e-6)


def test_slopes_are_derivatives(train: PickupTrain) -> None:
    t, h = inside(train), 1e-5
    assert (train.law.arm(t + h) - train.law.arm(t - h)) / (2 * h) == pytest.approx(
        train.law.slopes(t)[0], abs=1e-8
    )
    for order in (0, 1):
        slope = (train.law.slopes(t + h)[order] - train.law.slopes(t - h)[order]) / (2 * h)
        assert slope == pytest.approx(train.law.slopes(t)[order + 1], abs=1e-3)


def test_pitch_curves_roll_without_slip(train: PickupTrain) -> None:
    sun, middle, d1, d2 = contacts(train, inside(train))
    assert np.abs(sun.imag).max() < 1e-15
    assert np.abs(sun - middle).max() < 1e-15
    assert np.abs(d1 - d2).max() < 1e-9
    assert train.arc == pytest.approx(
        train.integral(lambda t: np.abs(contacts(train, t)[3])), rel=1e-7
    )


def test_another_centre_distance_parts_the_curves() -> None:
    wrong = replace(TRAINS["yu2023"].geometry, a1=0.0521)
    train = replace(TRAINS["yu2023"], geometry=wrong)
    radii = TRAINS["yu2023"].pitch(inside(train))["R2"]
    assert np.abs(train.pitch(inside(train))["R1"] + radii - wrong.a1).max() > 1e-5


def test_curvatures_obey_euler_and_savary(train: PickupTrain) -> None:
    build_result = train.pitch(inside(train))
    sine = build_result["R1"] / np.hypot(build_result["R1"], build_result["dR1"])
    assert build_result["kappa1"] + build_result["kappa2"] == pytest.approx(
        (1 / build_result["R1"] + 1 / build_result["R2"]) * sine, rel=1e-10
    )


def test_curvature_equals_three_neighbouring_points() -> None:
    train, h = TRAINS["yu2023"], 1e-3
    t = inside(train, 50)
    for gear, sign in (("1", 1), ("2", -1)):
        a, b, c = (
            f[f"x{gear}"] + 1j * f[f"y{gear}"] for f in (train.pitch(t + k * h) for k in (-1, 0, 1))
        )
        area = sign * ((b - a).conjugate() * (c - a)).imag / 2
        bent = 4 * area / (abs(b - a) * abs(c - b) * abs(a - c))
        assert bent == pytest.approx(train.pitch(t)[f"kappa{gear}"], rel=1e-4)


def test_tip_and_velocity(train: PickupTrain) -> None:
    t, h = np.concatenate([inside(train), np.radians([220, 240, 260])]), 1e-6
    build_result = train.motion(t)
    place = train.geometry.L1 * np.exp(1j * (train.phi5_far + t))
    place += train.geometry.L2 * np.exp(1j * train.arm_heading(t))
    assert np.abs(build_result["x_S"] + 1j * build_result["y_S"] - place).max() < 1e-15
    speed = (train.tip(t + h) - train.tip(t - h)) / (2 * h) * train.omega
    assert (
        np.abs(np.column_stack([build_result["vx_S"], build_result["vy_S"]]) - speed).max() < 1e-7
    )


def test_triangle_closes(train: PickupTrain) -> None:
    g, build_result = train.geometry, train.motion(np.linspace(0, 6, 30))
    middle, planet = (build_result[f"x_{p}"] + 1j * build_result[f"y_{p}"] for p in ("M1", "O1"))
    assert np.abs(planet) == pytest.approx(g.L1)
    assert np.abs(middle) == pytest.approx(g.a1)
    assert np.abs(planet - middle) == pytest.approx(g.a2)
    assert np.abs(np.angle((planet - middle) / -middle)) == pytest.approx(g.gamma)
    assert np.angle(middle / planet) == pytest.approx(g.beta1)


def test_distance_extremes_are_at_stretched_bars(train: PickupTrain) -> None:
    g, build_result = train.geometry, train.motion(np.linspace(0, 2 * np.pi, 5001))["L3"]
    ends = train.motion(np.array([0.0, train.nearest_angle]))["L3"]
    assert ends == pytest.approx([g.L1 + g.L2, g.L2 - g.L1], abs=1e-12)
    assert (ends[1] - 1e-15 <= build_result).all()
    assert (build_result <= ends[0] + 1e-15).all()


def test_in_the_dwell_the_tip_turns_with_the_carrier(train: PickupTrain) -> None:
    dwell = train.law.dwell
    t = np.linspace(dwell.start, dwell.end, 40)
    build_result = train.motion(t)
    assert np.ptp(build_result["L3"]) < 1e-15
    assert np.hypot(build_result["vx_S"], build_result["vy_S"]) == pytest.approx(
        build_result["L3"] * train.omega, rel=1e-12
    )
    assert np.ptp(train.law.arm(t)) < 1e-12
    outside = np.array([dwell.start - 1e-3, dwell.end + 1e-3])
    assert (np.abs(train.motion(outside)["L3"] - build_result["L3"][0]) > 1e-5).all()


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
