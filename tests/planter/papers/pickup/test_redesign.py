"""The reverse design: exact derivatives, requirements held, and what cannot be held said."""

import numpy as np
import pytest

from planter.engine.solvers.local_search import STATIONARITY_TOLERANCE
from planter.papers.pickup.file import load_pickup
from planter.papers.pickup.model import build_train
from planter.papers.pickup.redesign import NAMES, PINNED, LeastChange, build_nodes, redesign_path
from planter.papers.pickup.requirements import find_push

MACHINE = load_pickup("yu2023")
TRAIN = build_train(MACHINE)
AT = build_nodes(TRAIN, 25)


@pytest.fixture(scope="module")
def change() -> LeastChange:
    return LeastChange(MACHINE, TRAIN, AT, find_push(TRAIN)[0], dict.fromkeys(NAMES, 0.0))


@pytest.fixture(scope="module")
def moved():
    return redesign_path(MACHINE, TRAIN)


def test_the_law_is_linear_in_the_value_points() -> None:
    v = AT.values + np.random.default_rng(0).normal(0, 0.01, AT.size)
    law, t = AT.law_of(v), TRAIN.samples(300)
    for order in range(4):
        matrix, offset = AT.rows(t, order)
        values = law.arm(t) if order == 0 else law.slopes(t)[order - 1]
        assert matrix @ v + offset == pytest.approx(values, abs=1e-8)
    assert law.arm(AT.t)[1:] == pytest.approx(v)
    assert law.arm(t + 2 * np.pi) - law.arm(t) == pytest.approx(2 * np.pi)


def test_value_points_are_moved_until_the_requirements_hold(moved) -> None:
    assert not all(requirement.holds for requirement in moved.before)
    assert moved.holds
    assert 0.001 < moved.moved < 0.05
    assert moved.train.monotone
    curves = moved.train.pitch(moved.train.samples(2000))
    assert min(curves["kappa1"].min(), curves["kappa2"].min()) > 0


def test_fixed_points_stay(moved) -> None:
    assert moved.train.geometry == TRAIN.geometry
    assert moved.train.law.dwell == TRAIN.law.dwell
    assert moved.points[0] == pytest.approx(moved.points_before[0], abs=1e-9)
    distance = np.hypot(*moved.points[15:19].T)
    assert np.ptp(distance) < 1e-12
    assert abs(distance[0] - np.hypot(*moved.points_before[15])) > 1e-4


def test_feasible_design_is_not_changed() -> None:
    easy = load_pickup("yu2023", {"push_deg": 80, "swing_deg": 40})
    moved = redesign_path(easy, TRAIN)
    assert moved.iterations == 0
    assert moved.train.law is TRAIN.law


def test_conflicting_targets_are_not_satisfied() -> None:
    """A push angle of 90 deg is a swing of 50, not 60; the least violation lies between."""
    moved = redesign_path(load_pickup("yu2023", {"swing_deg": 60}), TRAIN)
    assert not moved.holds
    margin = {requirement.name: requirement.margin for requirement in moved.after}
    assert margin["push angle"] + margin["push angle less pick angle"] == pytest.approx(
        -6, abs=0.05
    )
    assert {name for name, value in margin.items() if value < -1e-6} <= {
        "push angle",
        "push angle less pick angle",
    }


def test_optimum_is_certified_with_active_constraints(moved) -> None:
    assert moved.certificate.kkt_residual < STATIONARITY_TOLERANCE
    names = [constraint.name for constraint in moved.certificate.active_constraints]
    assert set(names) <= {*NAMES, PINNED.name}
    assert "push angle" in names
