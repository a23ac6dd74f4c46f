"""Crank, rod, gears: the mechanism closes, work is kept, and rods are found for any wanted
travel.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from planter.errors import ComputationError, GeometryError
from planter.papers.clutch import file
from planter.papers.clutch.model import (
    CrankLinkage,
    collect_values,
    find_linkages,
    load_model,
    steepest_rod_angle,
)

OWN = CrankLinkage(0.015, 0.0471, 0.040)


def test_the_mechanism_closes_along_the_way():
    shift = np.linspace(0, 0.0042, 60)
    at = OWN.evaluate(shift)
    assert np.abs(np.hypot(at["pin_x"], at["pin_y"]) - OWN.crank).max() < 1e-12
    assert np.abs(np.hypot(OWN.distance + shift - at["pin_x"], at["pin_y"]) - OWN.rod).max() < 1e-12
    assert np.abs(np.arctan2(at["pin_y"], at["pin_x"]) - at["crank_angle"]).max() < 1e-12
    assert np.abs(OWN.rod * np.sin(at["rod_angle"]) - at["pin_y"]).max() < 1e-12


def test_rotation_agrees_with_law_of_cosines():
    at = OWN.evaluate(np.array([0.0, 0.0042]))["crank_angle"]
    assert OWN.rotation(0.0042) == pytest.approx(at[0] - at[1], rel=1e-13)
    by_hand = math.acos((40**2 + 15**2 - 47.1**2) / (2 * 40 * 15)) - math.acos(
        (44.2**2 + 15**2 - 47.1**2) / (2 * 44.2 * 15)
    )
    assert OWN.rotation(0.0042) == pytest.approx(by_hand, rel=1e-13)


def test_lever_is_the_derivative_of_the_way_and_keeps_the_work():
    shift, h = np.linspace(0.0003, 0.004, 20), 1e-7
    angle = lambda s: OWN.evaluate(s)["crank_angle"]  # noqa: E731
    slope = (angle(shift - h) - angle(shift + h)) / (2 * h)
    lever = OWN.evaluate(shift)["lever"]
    assert lever == pytest.approx(1 / slope, rel=1e-7)
    way = np.linspace(0, 0.0042, 2001)
    tooth = load_model()("push", shift=way, crank=OWN.packed, F1=60.0, r_A=0.014)["tooth_force"]
    turned = OWN.evaluate(way)["crank_angle"]
    assert -np.trapezoid(tooth * 0.014, turned) == pytest.approx(60 * 0.0042, rel=1e-6)


def test_the_side_force_balances_the_rod():
    """The rod pulls along itself: its share along the guide is the push, its share across is the
    side force.
    """
    at = OWN.evaluate(np.array([0.001]))
    push = load_model()("push", shift=np.array([0.001]), crank=OWN.packed, F1=60.0, r_A=0.014)
    assert push["side_force"][0] / 60 == pytest.approx(
        at["pin_y"][0] / (OWN.distance + 0.001 - at["pin_x"][0]), rel=1e-13
    )


@pytest.mark.parametrize("seed", range(6))
def test_rod_length_gives_the_required_travel(seed):
    random = np.random.default_rng(seed)
    crank, distance, travel = random.uniform([0.012, 0.035, 0.002], [0.018, 0.045, 0.007])
    rotation = travel / crank * random.uniform(1.02, 1.3)
    linkages = find_linkages(crank, distance, travel, rotation)
    for linkage in linkages:
        assert linkage.rotation(travel) == pytest.approx(rotation, abs=1e-12)
    assert [steepest_rod_angle(linkage, travel) for linkage in linkages] == sorted(
        steepest_rod_angle(linkage, travel) for linkage in linkages
    )
    low, high = distance + travel - crank + 1e-6, distance + crank - 1e-6
    grid = np.linspace(low, high, 400)
    off = [CrankLinkage(crank, rod, distance).rotation(travel) - rotation for rod in grid]
    roots = [
        brentq(
            lambda rod: CrankLinkage(crank, rod, distance).rotation(travel) - rotation,
            a,
            b,
            xtol=1e-15,
        )
        for a, b, left, right in zip(grid, grid[1:], off, off[1:], strict=False)
        if left * right < 0
    ]
    assert sorted(linkage.rod for linkage in linkages) == pytest.approx(sorted(roots), abs=1e-11)


def test_too_much_to_ask_of_a_crank():
    with pytest.raises(ComputationError, match="a crank of 15 mm makes at most"):
        find_linkages(0.015, 0.040, 0.0042, 0.1)
    with pytest.raises(GeometryError, match=r"here = 10: it must be between 29.2 and 55"):
        CrankLinkage(0.015, 0.010, 0.040).check(0.0042, "here")
    with pytest.raises(
        GeometryError, match="no rod reaches over the travel of 31 mm, the crank must be longer"
    ):
        OWN.check(0.031, "here")


@pytest.mark.parametrize("ratio", [0.3, 0.45, 0.8])
def test_gear_rolls_on_the_rack(ratio):
    """Relative to the link the arcs are equal; in the fixed frame the link's own turn comes on
    top.
    """
    mesh = math.radians(5)
    alpha = np.array([0.0, mesh - 1e-9, mesh + 0.1, mesh + 0.3])
    at = load_model()("gears", alpha=alpha, k=ratio, gamma=math.pi / 2 - mesh)
    turned = np.maximum(alpha - mesh, 0)
    assert at["theta_AR"] * ratio == pytest.approx(turned, abs=1e-15)
    assert at["theta_A"] - at["theta_AR"] == pytest.approx(turned, abs=1e-15)
    printed = load_model("printed")("gears", alpha=alpha, k=ratio, gamma=math.pi / 2 - mesh)[
        "theta_A"
    ]
    assert printed[2:] == pytest.approx((1 + 1 / ratio) * alpha[2:], rel=1e-14)
    assert printed[2] - at["theta_A"][2] == pytest.approx((1 + 1 / ratio) * mesh, rel=1e-12)


def test_drive_undoes_the_gears():
    values = collect_values(file.load_clutch("shi2021"))
    drive = load_model().at(
        "drive",
        k=values["k"],
        span=values["r_A"] + values["r_D"],
        gamma=values["gamma"],
        theta_Amax=0.3,
    )
    assert drive["r_A"] == pytest.approx(0.014, rel=1e-14)
    assert drive["r_D"] == pytest.approx(0.046, rel=1e-14)
    back = load_model().at("gears", alpha=drive["alpha_max"], k=values["k"], gamma=values["gamma"])[
        "theta_AR"
    ]
    assert back == pytest.approx(0.3, rel=1e-13)


def test_teeth_turned_through():
    """A whole turn is the number of teeth of the gear; (7) as printed gives twice that."""
    rotation = OWN.rotation(0.0042)
    exact, printed = (
        load_model(n).at("limit", crank=OWN.packed, c=0.0042, r_A=0.014, m=0.002)["n"]
        for n in ("exact", "printed")
    )
    assert exact == pytest.approx(rotation / (2 * math.pi) * 14, rel=1e-13)
    assert printed == pytest.approx(2 * exact, rel=1e-13)
