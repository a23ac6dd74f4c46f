"""Robust designs of any machine: gradients against differences, machines one by one, limits, rows
without a cycle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planter.engine.goal import Goal, resolve_limit, resolve_measure
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine
from planter.engine.measures import parse_limit, parse_sum
from planter.errors import ComputationError
from planter.kernels import backends
from planter.mechanism.machines import build_machine
from planter.rows.tolerance.job import Spread
from planter.rows.tolerance.robust import RobustGoal, Settings, find_robust
from tests.support import own

ANGLES = 24
SPREADS = {"values.m_s_kg": Spread("normal", 1.2, 1.8), "values.e_mm": Spread("uniform", 9, 11)}
SETTINGS = Settings(machines=8, starts=1)


@pytest.fixture(autouse=True)
def plain_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "select_fastest", backends.VirtualMachine)


def crank(**bounds: tuple[float, float]) -> Machine:
    """Return the slider-crank with values to move; the offset is one of them and has a
    tolerance.
    """
    ends = {f"values.{key}": pair for key, pair in bounds.items()} or {
        "values.r_mm": (30, 80),
        "values.e_mm": (-20, 20),
    }
    return build_machine(own.file("slider_crank")).with_moved(ends)


def robust_goal(machine: Machine, spreads: dict[str, Spread], hold: str = "") -> RobustGoal:
    measures = [
        resolve_measure(machine, measure) for measure in parse_sum("range F_Ox + 2 rms M_in")
    ]
    limits = [resolve_limit(machine, parse_limit(hold))] if hold else []
    bounds = MeasureLimits(Goal(machine, (), limits)) if limits else None
    return RobustGoal(
        replace(machine, objective=tuple(measures)), spreads, SETTINGS, ANGLES, bounds
    )


def test_gradient_of_mean_and_deviation_agrees_with_differences() -> None:
    robust = robust_goal(crank(), SPREADS)
    x, (value, slope) = robust.design, robust.value(robust.design, 3.0)
    for j, step in enumerate(np.diag(1e-6 * (robust.upper - robust.lower))):
        difference = (robust.value(x + step, 3.0)[0] - robust.value(x - step, 3.0)[0]) / (
            2 * step[j]
        )
        assert slope[j] == pytest.approx(difference, rel=1e-6)
    at = robust.at(x)
    assert value == pytest.approx(at.mean + 3 * at.std)
    assert not np.allclose(slope, at.mean_slope, rtol=1e-4), (
        "the deviation has a part in the gradient"
    )


def test_random_machines_agree_with_single_machines() -> None:
    robust = robust_goal(crank(), SPREADS)
    values, _ = robust.evaluate(robust.design)
    machine = robust.machine
    for deviations, value in zip(robust.deviations, values, strict=True):
        data = machine.data.copy()
        data[machine.find_index("values.e_mm")] += deviations[1]
        data[machine.find_index("values.m_s_kg")] = deviations[2]
        alone = Goal(machine.with_data(data), machine.objective, [], ANGLES)
        assert value == pytest.approx(alone.evaluate(alone.machine.design), rel=1e-12)
    assert np.ptp(values) > 0.01 * values.mean()


def test_robust_design_improves_within_limits() -> None:
    robust = robust_goal(crank(), SPREADS, "max s <= 245 mm")
    robust_result = find_robust(robust, SETTINGS, None)
    assert robust_result.objective == pytest.approx(robust_result.mean + 3 * robust_result.std)
    assert isinstance(robust.limits, MeasureLimits)
    x = (
        np.array([robust_result.design["r_mm"], robust_result.design["e_mm"]])
        * robust.machine.scale
    )
    assert robust.limits.violation(x) <= 1e-6
    assert robust.limits.violation(robust.design) > 1e-3


def test_search_skips_designs_without_cycle() -> None:
    robust_result = find_robust(robust_goal(crank(l_mm=(20, 220)), SPREADS), SETTINGS, None)
    assert robust_result.design["l_mm"] > 61
    robust = robust_goal(crank(l_mm=(20, 220)), SPREADS)
    with pytest.raises(ComputationError, match="slider_crank"):
        robust.value(np.array([0.02]), 3.0)


def test_limits_in_the_design_have_total_slopes() -> None:
    machine = crank()
    limit = resolve_limit(machine, parse_limit("range F_Ox <= 20 N"))
    limits = MeasureLimits(Goal(machine, (), [limit]))
    x = machine.design
    slopes = limits.slopes(x)
    for j, step in enumerate(np.diag(1e-6 * (machine.upper - machine.lower))):
        difference = (limits.values(x + step) - limits.values(x - step)) / (2 * step[j])
        np.testing.assert_allclose(slopes[:, j], difference, atol=1e-5 * np.abs(slopes).max())
