"""Sensitivity of any machine: central differences of the objective, directions that leave the
curves as they are.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.engine.goal import Goal, resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import Measure, parse_sum
from planter.engine.response import MachineResponse
from planter.engine.sensitivity import compute_sensitivity, find_widths, move_all
from planter.errors import InputError
from planter.mechanism.machines import build_machine
from planter.mechanism.optimisation import compute_objective_sensitivity
from tests.support import own
from tests.support.cli import answer

TRUE, SAMPLED = (
    "range F_Ox + 2 max abs F_Oy",
    "range F_Ox + 0.5 rms M_in + 2 max abs F_Oy + F_By at 100",
)


def build(source: str, text: str) -> tuple[Machine, list[Measure]]:
    machine = build_machine(own.file(source))
    return machine, [resolve_measure(machine, measure) for measure in parse_sum(text)]


@pytest.mark.parametrize(("text", "samples"), [(TRUE, None), (SAMPLED, 60)])
def test_gradient_equals_central_differences(text: str, samples: int | None) -> None:
    machine, objective = build("slider_crank", text)
    paths = ("values.r_mm", "values.omega_rpm", "values.mu")
    machine = machine.with_moved(dict.fromkeys(paths, (0.0, 1.0)))
    result = compute_sensitivity(machine, objective, samples, 36)
    goal = Goal(machine, objective, (), samples)
    for index, (name, slope) in enumerate(result.gradient.items()):
        step = 2e-5 * np.abs(machine.design) * (np.arange(len(machine.moved)) == index)
        high, low = (goal.evaluate(machine.design + sign * step) for sign in (1, -1))
        difference = (high - low) / (2 * step[index]) * machine.scale[index]
        assert slope == pytest.approx(difference, rel=2e-5), name
    assert result.scaled["r_mm"] == pytest.approx(result.gradient["r_mm"], rel=1e-12)


def test_directions_without_effect_leave_the_curves() -> None:
    machine, objective = build("transplanting_arm", "max abs M_in")
    machine = move_all(machine)
    result = compute_sensitivity(machine, objective, None, 90)
    assert [{"p_mm": 1.0}] in result.insensitive
    assert result.effective_parameters + len(result.insensitive) == len(machine.values)
    response, phi = MachineResponse(machine, ["M_in"]), np.linspace(0, 6, 40)
    slopes = response.slopes(response.at(machine.design), phi)[1][0, :, 1:] * find_widths(machine)
    for direction in result.insensitive:
        weights = {name: weight for part in direction for name, weight in part.items()}
        vector = np.array([weights.get(name, 0.0) for name in machine.design_names])
        assert np.abs(slopes @ vector).max() < 1e-6 * np.abs(slopes).max()
    strong = result.combinations[0].weights
    vector = np.array([strong.get(name, 0.0) for name in machine.design_names])
    assert np.linalg.norm(vector) == pytest.approx(1.0, abs=1e-9)
    assert np.linalg.norm(slopes @ vector) > 0.9 * np.linalg.norm(slopes, 2)


def test_missing_objective_is_refused() -> None:
    machine = own.machine("slider_crank")
    with pytest.raises(InputError, match=r"objective\.least is missing"):
        compute_objective_sensitivity(machine)
    with pytest.raises(InputError, match="--all"):
        compute_objective_sensitivity(machine.with_moved({}), least="max M_in")
    free = machine.with_moved({"values.J_kg_m2": (0.0, 1.0)})
    with pytest.raises(InputError, match="has an effect on s"):
        compute_sensitivity(
            free, [resolve_measure(free, measure) for measure in parse_sum("max s")], 12
        )


def test_planting_device_takes_any_sum_and_all_values() -> None:
    result = answer("sensitivity", "wang2017", "--least", "mean M_L", "--all", "--samples", "24")
    assert result["gradient"]["cam_friction_angle_deg"] > 0
    assert result["gradient"]["forward_speed_m_s"] == 0
