"""Machines of the engine: values, quantities and functions under one roof, and derivatives that
differences confirm.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from planter.engine.loops import TURN
from planter.engine.machine import Machine, load_machine
from planter.engine.response import MachineResponse
from planter.errors import ComputationError, InputError
from planter.mechanism.machines import build_machine
from tests.planter.engine.solvers.toys import check_derivatives
from tests.support import own

NAMES = ("slider_crank", "cam_follower")
ANGLES = TURN * np.array([0.03, 0.21, 0.4, 0.77])


@cache
def machine(name: str, *moved: str) -> Machine:
    built = build_machine(own.file(name))
    return built.with_moved(
        dict.fromkeys(moved or [value.path for value in built.values], (0.0, 1.0))
    )


@pytest.mark.parametrize("name", NAMES)
def test_quantities_are_those_of_the_generated_functions(name: str) -> None:
    response, expected = MachineResponse(machine(name)), own.evaluate_lane(own.file(name), ANGLES)
    values = response.values(response.at_data(machine(name).data), ANGLES)
    for quantity, row in zip(response.quantities, values, strict=True):
        np.testing.assert_allclose(row, expected[quantity.name], rtol=1e-12, atol=1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_derivatives_are_those_of_differences(name: str) -> None:
    built = machine(name)
    response = MachineResponse(built, [quantity.name for quantity in built.results][:3])
    x = built.design
    y, shape = np.append(0.0, x), (3, len(ANGLES))
    rows = SimpleNamespace(
        values=lambda y: response.values(response.at(y[1:]), ANGLES + y[0]).ravel(),
        slopes=lambda y: response.slopes(response.at(y[1:]), ANGLES + y[0])[1].reshape(-1, len(y)),
        curvature=lambda y, weights: response.curvature(
            response.at(y[1:]), ANGLES + y[0], weights.reshape(shape)
        ),
    )
    weights = np.random.default_rng(2).normal(size=shape)
    width = np.maximum(np.abs(y), 1e-2)
    check_derivatives(rows, y, weights.ravel(), width, 1e-5, (1e-6, 1e-6))
    slopes = weights.ravel() @ rows.slopes(y)
    bent = rows.curvature(y, weights)
    rates = response.rates(response.at(x), ANGLES)
    np.testing.assert_allclose((weights * rates[0]).sum(), slopes[0], rtol=1e-12)
    np.testing.assert_allclose((weights * rates[1]).sum(), bent[0, 0], rtol=1e-11)


def test_unknown_names_are_refused_with_close_ones() -> None:
    with pytest.raises(InputError, match="did you mean"):
        machine("slider_crank").find_quantity("F_Oy_")
    with pytest.raises(InputError, match="did you mean"):
        machine("slider_crank").find_index("values.r_m")
    with pytest.raises(InputError, match="no such file"):
        load_machine("nowhere.toml")


def test_dead_point_is_named_with_angle() -> None:
    built = machine("slider_crank")
    data = built.data.copy()
    data[built.find_index("l_mm")] = 0.5 * data[built.find_index("r_mm")]
    response = MachineResponse(built, ["s"])
    with pytest.raises(ComputationError, match="dead point near"):
        response.values(response.at_data(data), ANGLES)


def test_loops_depend_on_lengths_alone() -> None:
    machine = own.machine("slider_crank")
    assert machine.loops is not None
    response, phi = MachineResponse(machine), np.linspace(0, TURN, 12)
    keys = [value.path.rpartition(".")[2] for value in machine.values]
    before = response.coordinates(machine.data, phi)
    for key, is_length in (("m_s_kg", False), ("k_N_m", False), ("r_mm", True), ("e_mm", True)):
        d = machine.data.copy()
        d[keys.index(key)] *= 1.1
        assert machine.loops.are_same(d, machine.data) is not is_length
        assert (response.coordinates(d, phi) == before).all() != is_length
        response.coordinates(machine.data, phi)
