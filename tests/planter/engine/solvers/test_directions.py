"""Insensitive directions of the force: rank and named null space."""

import casadi as ca
import numpy as np
import pytest

from planter.engine.solvers.curve_sum import scale_slopes
from planter.engine.solvers.insensitive import find_insensitive
from tests.planter.engine.solvers import toys
from tests.planter.engine.solvers.toy import Toy


def test_the_machine():
    machine = toys.device()
    insensitivity = find_insensitive(
        machine.force.names, scale_slopes(machine.force, machine.design, 360)
    )
    assert insensitivity.effective_parameters == 7
    single, other, mixed = insensitivity.named
    assert (single, other) == ([{"gamma_deg": 1.0}], [{"A6_mm": 1.0}])
    weights = {name: weight for entry in mixed for name, weight in entry.items()}
    radius, eccentricity = machine.design[4:6]
    width = (machine.upper - machine.lower)[4:6]
    assert weights == pytest.approx(
        {"R3_mm": radius / width[0] / (eccentricity / width[1]), "e3_mm": 1.0}, rel=1e-6
    )


def test_directions_span_the_null_space():
    """Along each the curve stands still, to first order; across none of the others does it."""
    response = toys.planting("printed")
    insensitivity = find_insensitive(response.names, scale_slopes(response, response.design, 360))
    phi = np.linspace(0, np.pi, 50)
    columns = response.curves.slopes(response.prologue(response.design), phi)[1][0, :, 1:]
    columns = columns * (response.upper - response.lower)
    assert insensitivity.effective_parameters + len(insensitivity.directions) == 10
    for direction in insensitivity.directions:
        vector = np.array([direction.get(name, 0.0) for name in response.names])
        assert np.abs(vector).max() == 1.0
        assert np.linalg.norm(columns @ vector) < 1e-8 * np.linalg.norm(columns)
    assert (
        np.linalg.matrix_rank(columns, tol=1e-9 * np.linalg.norm(columns))
        == insensitivity.effective_parameters
    )


def test_product_of_two_parameters_is_a_single_direction():
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 4)
    toy = Toy(
        phi,
        x,
        x[0] * x[1] * ca.cos(phi) + x[3] * ca.sin(phi),
        lower=[1, 1, 1, 1],
        upper=[2, 3, 2, 2],
    )
    insensitivity = find_insensitive(
        toy.names, scale_slopes(toy, np.array([1.5, 2.0, 1.5, 1.5]), 24)
    )
    assert insensitivity.effective_parameters == 2
    assert insensitivity.named[0] == [{"x2": 1.0}]
    assert {k: v for entry in insensitivity.named[1] for k, v in entry.items()} == pytest.approx(
        {"x0": 1.0, "x1": -2 / 3}
    )
    assert insensitivity.zero.tolist() == [False, False, True, False]
