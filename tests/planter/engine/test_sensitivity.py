"""Sensitivity of any machine: central differences of the objective, directions that leave the
curves as they are.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.engine.goal import resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import Measure, parse_sum
from planter.engine.response import MachineResponse
from planter.engine.sensitivity import compute_sensitivity, find_widths, move_all
from planter.errors import InputError
from planter.mechanism.machines import build_machine
from planter.mechanism.optimisation import compute_objective_sensitivity
from tests.support import own


def build(source: str, text: str) -> tuple[Machine, list[Measure]]:
    machine = build_machine(own.file(source))
    return machine, [resolve_measure(machine, measure) for measure in parse_sum(text)]


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
