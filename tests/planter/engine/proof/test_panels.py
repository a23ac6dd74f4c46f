"""Panels of angles: means, greatest values and slopes against closed forms and quadrature; tampered
cases miss them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from planter.engine.proof import jets, objective
from planter.engine.proof.enclosures import AnglePanels, RootBranch, list_angles
from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.jets import ANYWHERE, CENTRE, Jet, Space
from planter.engine.proof.objective import enclose_square
from planter.engine.proof.search import BranchAndBound
from planter.kernels import Array
from tests.planter.engine.proof.toys import BENT, LOWER, UPPER, build_bent, find_kinks

MIDDLE = np.array([0.4, 1.1, 0.03])
HALF = np.array([0.02, 0.02, 0.004])
PERIOD = list_angles([BENT.period])


@pytest.fixture(autouse=True)
def _coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few panels: enough for a response without steep parts."""
    monkeypatch.setattr(objective, "PANELS", 40)
    monkeypatch.setattr(objective, "PANELS_AT_POINT", 2000)


def make_panels(lower: Array, upper: Array, count: int = 40) -> tuple[AnglePanels, Space]:
    panels = AnglePanels.build(find_kinks((lower + upper) / 2), (upper - lower) / 2, PERIOD, count)
    return panels, Space(np.append(lower, -1.0), np.append(upper, 1.0))


def enclose(lower: Array, upper: Array, count: int = 40) -> tuple[AnglePanels, Jet, Jet]:
    """Return panels, the curve in them, and their shares."""
    panels, space = make_panels(lower, upper, count)
    phi, shares = panels.angles(space)
    return panels, BENT.enclose(space, phi, [RootBranch(1.0, (), ())])[0], shares


def curve(x: Array, phi: float) -> float:
    return float(2 * x[0] * abs(np.sin(phi - x[2])) + (x[1] - x[2] ** 2) * np.cos(2 * phi))


def measure(x: Array, function: Callable[[float], float]) -> float:
    """Return the mean of a function of the curve over a period, by quadrature between kinks."""
    kink = x[2] % np.pi
    return float(
        quad(lambda phi: function(curve(x, phi)), kink, kink + np.pi, epsabs=1e-13, limit=200)[0]
        / np.pi
    )


def peak(x: Array, side: int) -> float:
    """Return the greatest value of the curve, or of minus it, by golden sections beside the best of
    many angles.
    """
    grid = np.linspace(0, np.pi, 721)
    best = max(grid, key=lambda phi: side * curve(x, phi))
    solution = minimize_scalar(
        lambda phi: -side * curve(x, phi),
        bounds=(best - 0.005, best + 0.005),
        method="bounded",
        options={"xatol": 1e-12},
    )
    return max(-float(solution.fun), side * curve(x, x[2]))


def true_objective(x: Array) -> float:
    mean = measure(x, lambda force: force)
    return 0.6 * (peak(x, 1) + peak(x, -1)) + 0.4 * measure(x, lambda force: (force - mean) ** 2)


def draw(count: int) -> list[Array]:
    rng = np.random.default_rng(8)
    return [MIDDLE + rng.uniform(-1, 1, 3) * HALF for _ in range(count)]


def find_mean() -> tuple[Ball, Array]:
    """Return the enclosed mean of squares over a box, and what it is at designs of the box."""
    _, force, shares = enclose(MIDDLE - HALF, MIDDLE + HALF)
    mean = (enclose_square(force).average(3) * shares).sum().value[ANYWHERE]
    return mean, np.array([measure(x, lambda force: force**2) for x in draw(20)])


def test_means_are_enclosed_and_narrow() -> None:
    mean, values = find_mean()
    assert (mean.low <= values).all()
    assert (values <= mean.high).all()
    assert mean.rad < 0.1 * mean.mid
    _, force, shares = enclose(MIDDLE, MIDDLE, 720)
    point = (force.average(3) * shares).sum().value[CENTRE]
    assert point.low <= 4 * MIDDLE[0] / np.pi <= point.high, "the mean of |sin| is 2 / pi"
    assert point.rad < 1e-6


@pytest.mark.parametrize("tamper", ["bend", "last panel"])
def test_means_without_a_part_are_wrong(tamper: str) -> None:
    _, force, shares = enclose(MIDDLE, MIDDLE, 720)
    if tamper == "bend":
        mean = (force.value[CENTRE] * shares.value[CENTRE]).sum()
    else:
        mean = (force.average(3) * shares).taken(slice(0, -1)).sum().value[CENTRE][0]
    assert not mean.low <= 4 * MIDDLE[0] / np.pi <= mean.high


def test_hulls_hold_the_curve_at_every_place() -> None:
    panels, force, _ = enclose(MIDDLE - HALF, MIDDLE + HALF)
    hull, rng = force.hull(3), np.random.default_rng(1)
    ends = np.append(panels.places, panels.places[0] + np.pi)
    slopes = np.vstack([panels.slopes, panels.slopes[:1]])
    for x in draw(10):
        edges = ends + slopes @ (x - MIDDLE)
        for k, share in enumerate(rng.random(len(panels.places))):
            phi = edges[k] + share * (edges[k + 1] - edges[k])
            assert hull.value[ANYWHERE].low[k] <= curve(x, phi) <= hull.value[ANYWHERE].high[k]
    middle = hull.value[CENTRE]
    for k, share in enumerate(rng.random(len(panels.places))):
        force_there = curve(MIDDLE, ends[k] + share * (ends[k + 1] - ends[k]))
        assert middle.low[k] <= force_there <= middle.high[k]


def test_parabolas_are_bounded_tightly() -> None:
    slope, bend = Ball.exact(np.array([0.5, 2.0, -0.3])), Ball.exact(np.array([-1.0, -1.0, 4.0]))
    bounds = jets._bound_parabola(slope, bend)
    s = np.linspace(-1, 1, 2001)
    values = np.outer(slope.mid, s) + np.outer(bend.mid, s**2) / 2
    np.testing.assert_allclose(bounds.high, values.max(axis=1), atol=1e-6)
    assert (bounds.low <= values.min(axis=1)).all()
    assert bounds.low[2] == pytest.approx(-(0.3**2) / 8, abs=1e-6)


def test_true_bounds_hold_at_random_designs() -> None:
    bound, values = build_bent(None), [true_objective(x) for x in draw(12)]
    bounds = bound(MIDDLE - HALF, MIDDLE + HALF)
    assert bounds.lower_bound <= min(values)
    assert bounds.lower_bound > 0.8 * min(values)
    assert true_objective(MIDDLE) <= bounds.reached
    for i, j in ((0, 5), (3, 9), (11, 2), (7, 8)):
        step = draw(12)[j] - draw(12)[i]
        greatest = np.where(step > 0, bounds.slopes.high, bounds.slopes.low) @ step
        assert values[j] - values[i] <= greatest + 1e-12
    point = bound(MIDDLE, MIDDLE)
    assert point.lower_bound <= true_objective(MIDDLE) <= point.reached
    assert point.reached - point.lower_bound < 1e-6


def test_the_true_optimum_is_proved() -> None:
    best = np.array([UPPER[0], LOWER[1], 0.0])
    bound = build_bent(None)
    goal = bound(best, best).reached * (1 - 1e-3)
    result = BranchAndBound(bound, LOWER, UPPER).run(goal, 60.0)
    assert result <= min(true_objective(LOWER + s * (UPPER - LOWER)) for s in np.eye(3))
    assert result <= true_objective(best)


def test_panels_that_may_overlap_are_refused() -> None:
    panels = AnglePanels(
        np.array([0.0, 1.0, 1.1]), np.array([[0.0], [1.0], [-1.0]]), (1, 1, 1), PERIOD
    )
    panels.angles(Space(np.array([0.0, -1.0]), np.array([0.05, 1.0])))
    with pytest.raises(Unbounded, match="overlap"):
        panels.angles(Space(np.array([0.0, -1.0]), np.array([0.3, 1.0])))
