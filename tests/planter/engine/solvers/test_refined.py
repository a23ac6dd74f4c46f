"""True extremes and integrals: independent of any grid, with exact derivatives."""

import numpy as np
import pytest

from planter.engine.curves import QuantityCurves
from planter.engine.solvers import cycle_panels
from planter.engine.solvers.continuous_cycle import ContinuousCycle
from planter.engine.solvers.curve_sum import CurveSide, CurveStatistic
from planter.engine.solvers.cycle_panels import CyclePanels, PanelCache
from planter.engine.solvers.objective import find_tops
from planter.engine.solvers.response import CycleResponse
from tests.planter.engine.solvers import toys
from tests.planter.engine.solvers.toys import check_derivatives

VARIANCE = (CurveStatistic("variance", 0, 1.0),)


def measure_variance(response: CycleResponse, x: np.ndarray) -> float:
    return CyclePanels(response, x).smooth(VARIANCE).value


@pytest.mark.parametrize("model", ["exact", "printed"])
def test_extremes_and_integrals_agree_with_a_fine_grid(model):
    response = toys.planting(model)
    phi = np.pi * np.arange(20000) / 20000
    force = response.curves.values(response.prologue(response.design), phi)[0]
    summary = ContinuousCycle(PanelCache(response), toys.SUM).summarise(response.design)
    rough = np.abs(np.diff(force, 2)).max() / 4
    assert 0 <= summary.tops[0] - force.max() < rough
    assert 0 <= force.min() + summary.tops[1] < rough
    assert summary.smooth == pytest.approx(0.4 * force.var(), rel=1e-8)


def test_quadrature_has_converged(monkeypatch):
    response = toys.planting()
    variance = measure_variance(response, response.design)
    monkeypatch.setattr(cycle_panels, "MAX_PANEL", np.pi / 16)
    assert variance == pytest.approx(measure_variance(response, response.design), rel=1e-12)


def test_closed_forms():
    """cos phi - cos(3 phi) / 6: peaks sqrt 3 / 2 at +-30 deg, a dip 5/6 between them; variance (1 +
    1/36) / 2.
    """
    panels = CyclePanels(toys.third_harmonic(), np.array([-1 / 6]))
    extremes = panels.extremes(CurveSide(0, 0, 1))
    assert np.degrees(extremes.angles) == pytest.approx([0, 30, 150, 180, 210, 330], abs=1e-9)
    assert extremes.values == pytest.approx(
        np.sqrt([25 / 36, 0.75, 0.75, 25 / 36, 0.75, 0.75]) * [1, 1, -1, -1, -1, 1]
    )
    assert extremes.peaks.tolist() == [False, True, False, True, False, True]
    assert panels.smooth(VARIANCE).value == pytest.approx(37 / 72, rel=1e-13)


def test_a_corner_is_a_peak_where_the_slope_changes_sign():
    toy = toys.corner(height=-4.0)
    extremes = CyclePanels(toy, np.array([0.2])).extremes(CurveSide(0, 0, 1))
    top = extremes.values.argmax()
    assert (extremes.angles[top], extremes.breakpoint[top]) == (pytest.approx(0.2, abs=1e-14), 0)
    assert extremes.values[top] == pytest.approx(3 * np.cos(0.2), abs=1e-14)


@pytest.mark.parametrize(
    "response", [toys.planting(), toys.bent(), toys.corner(-4.0)], ids=["machine", "bent", "corner"]
)
@pytest.mark.parametrize("share", [0.3, 0.62])
def test_peak_and_variance_derivatives_equal_differences(response, share):
    width = response.upper - response.lower
    x = response.lower + share * width
    rows = ContinuousCycle(PanelCache(response), toys.SUM).local(x)
    weights = np.append(0.7, np.random.default_rng(5).normal(size=len(rows.groups)))
    check_derivatives(rows, x, weights, width, 2e-5, (1e-7, 2e-6))


def test_the_motion_of_nodes_is_needed(monkeypatch):
    """Without it the curvature of the variance of a moving corner would be wrong: the test above
    can fail.
    """
    toy, x = toys.corner(-4.0), np.array([0.2])
    cycle = ContinuousCycle(PanelCache(toy), toys.SUM)
    panels, smooth = cycle.panels(x)
    bent = panels.hessian(smooth)
    monkeypatch.setattr(CyclePanels, "_velocity", np.zeros((2, 1)))
    cycle = ContinuousCycle(PanelCache(toy), toys.SUM)
    panels, smooth = cycle.panels(x)
    assert abs(panels.hessian(smooth) - bent).max() > 0.1 * abs(bent).max()


def test_windows_cover_the_turn_wherever_the_design_goes():
    response = toys.bent()
    rows = ContinuousCycle(PanelCache(response), toys.SUM).local(np.array([0.1, 0.1]))
    for x in np.random.default_rng(0).random((6, 2)):
        summary = ContinuousCycle(PanelCache(response), toys.SUM).summarise(x)
        assert find_tops(rows.values(x)[1:], rows.groups, 2) == pytest.approx(
            summary.tops, abs=1e-12
        )


def test_all_joints_are_panel_ends():
    response = toys.planting()
    assert isinstance(response, QuantityCurves)
    panels = CyclePanels(response, response.design)
    assert np.isin(np.round(panels.folded, 9), np.round(np.mod(panels.breaks, np.pi), 9)).all()
