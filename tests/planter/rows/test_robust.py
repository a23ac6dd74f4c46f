"""Robust designs of any machine: gradients against differences, machines one by one, limits, rows
without a cycle.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planter.engine.goal import Goal, resolve_limit, resolve_measure
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine, load_machine
from planter.engine.measures import parse_limit, parse_sum
from planter.engine.response import MachineResponse
from planter.engine.summary import summarise_machine
from planter.errors import ComputationError, InputError
from planter.files import examples
from planter.kernels import backends
from planter.mechanism.machines import build_machine
from planter.rows.adapter import ResolvedMachine
from planter.rows.points import Spread
from planter.rows.results import RobustFound
from planter.rows.robust import RobustGoal, Settings, find_robust
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


CASES = {
    "shi2021": (("linkage.crank_mm", "linkage.rod_mm"), "M_link_max_Nm"),
    "yu2023": (("bars.L2_mm", "carrier.gamma_deg"), "x_S_range_mm"),
}


@pytest.mark.parametrize("name", CASES)
def test_rows_equal_single_machine_outputs(name: str) -> None:
    inputs, output = CASES[name]
    resolved, machine = ResolvedMachine(name), load_machine(name)
    frozen = json.loads(json.dumps(resolved.adapter.frozen(resolved.machine)))
    nominal = resolved.adapter.nominal(resolved.machine)
    x = np.array([nominal[path] for path in inputs])
    subject = resolved.adapter.subject(
        frozen, {}, {path: (nominal[path],) * 2 for path in inputs}, [output]
    )
    (value,), slopes = subject.slopes(x)
    (term,) = subject.outputs[0].terms
    quantity = machine.find_quantity(term.name)
    peak = next(peak for peak in summarise_machine(machine).peaks if peak.name == quantity.name)
    assert value == pytest.approx(peak.max if term.kind == "max" else peak.max - peak.min, rel=1e-9)
    steps = np.diag(1e-6 * x)
    difference = (subject.evaluated(x + steps, 1) - subject.evaluated(x - steps, 1))[:, 0] / (
        2e-6 * x
    )
    np.testing.assert_allclose(slopes[0], difference, atol=1e-6 * np.abs(slopes).max())
    assert np.abs(slopes).max() > 0


def test_file_changed_during_run_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(examples.read_source("shi2021", "clutch"), encoding="utf-8")
    resolved = ResolvedMachine(str(path), {"crank_mm": 31.0})
    frozen = resolved.adapter.frozen(resolved.machine)
    assert resolved.adapter.thaw(frozen).numbers()["linkage.crank_mm"] == 31.0
    path.write_text(path.read_text().replace("rod_mm = ", "rod_mm = 1"), encoding="utf-8")
    with pytest.raises(InputError):
        resolved.adapter.thaw(frozen)


def find(resolved: ResolvedMachine, settings: Settings, spreads: dict[str, Spread]) -> RobustFound:
    robust = resolved.adapter.build_robust(resolved.machine, {}, spreads, settings)
    return find_robust(robust, settings, None)


VARIED = {"bars.L1_mm": (90.0, 97.0)}


def test_stated_sum_limit_and_ranges_make_a_robust_design() -> None:
    """Alone, the range is least at an end of the bar's length; as a limit it binds where the needle
    shall reach far.
    """
    resolved, machine = ResolvedMachine("yu2023"), load_machine("yu2023")
    spreads = {"bars.L1_mm": Spread("normal", 93.2, 93.5)}

    def find_range(length: float) -> float:
        moved = machine.with_moved(VARIED)
        response = MachineResponse(moved, ["x_S"])
        at = response.at(np.array([length * 1e-3]))
        return float(
            np.ptp(
                1e3
                * response.values(at, machine.turn * np.arange(machine.samples) / machine.samples)
            )
        )

    stated = Settings(1.0, 8, 1, sum_text="range x_S", ranges=VARIED)
    free = find(resolved, stated, spreads)
    ends = [find_range(length) for length in VARIED["bars.L1_mm"]]
    best = 90.0 if ends[0] < ends[1] else 97.0
    assert free.design == pytest.approx({"L1_mm": best})
    assert free.objective <= free.own_objective
    limit = (min(ends) + max(ends)) / 2
    upward = replace(stated, sum_text="-mean x_S", holds=(f"range x_S <= {limit!r}",))
    bound = find(resolved, upward, spreads)
    assert find_range(bound.design["L1_mm"]) <= limit * (1 + 1e-7)


@pytest.mark.parametrize(
    ("stated", "part"),
    [
        (Settings(sum_text="range x_S"), "no values to search in: give --vary"),
        (Settings(ranges=VARIED), "no sum to minimise: give --least"),
        (
            Settings(sum_text="range x_S", ranges={"bars.L1_mm": (97.0, 90.0)}),
            "LOW must be below HIGH",
        ),
        (Settings(sum_text="range x_Q", ranges=VARIED), "no quantity x_Q"),
    ],
)
def test_incomplete_robust_request_is_rejected(stated: Settings, part: str) -> None:
    resolved = ResolvedMachine("yu2023")
    with pytest.raises(InputError, match=part):
        resolved.adapter.build_robust(resolved.machine, {}, {}, stated)
    assert resolved.adapter.build_robust(resolved.machine, {}, {}, Settings()) is None
