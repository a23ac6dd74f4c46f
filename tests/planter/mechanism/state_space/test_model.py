"""x' = f(t, x, u, p) and y = g(t, x, u, p) against the equations of motion, closed forms, differences
and Pinocchio.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from math import cos
from pathlib import Path

import numpy as np
import pytest

from planter.errors import InputError
from planter.kernels import Array
from planter.kernels.backends import bind_memory
from planter.mechanism.dynamics import Reactions
from planter.mechanism.state_space.linearisation import linearise_model
from planter.mechanism.state_space.model import DynamicsModel, load_dynamics
from tests.planter.mechanism.state_space.statements import (
    CART,
    CRANKS,
    FOUR_BAR,
    ODD,
    PLATFORM,
    RUBBING,
    build_chain,
    build_tree,
)
from tests.support import own
from tests.support.cli import answer, refusal
from tests.support.lanes import shortest

SOURCES = {
    "cart": (CART, "own"),
    "cranks": (CRANKS, "own"),
    "rubbing": (RUBBING, "own"),
    "odd": (ODD, "own"),
    "four-bar": (FOUR_BAR, "own"),
    "platform": (PLATFORM, "own"),
    "chain": (build_chain(24), "own"),
    "whipple": ("whipple", "whipple"),
    "row_unit": ("row_unit", "row_unit"),
}
SHORT = [name for name in SOURCES if name != "chain"]


def find_path(name: str) -> Path:
    source, file = SOURCES[name]
    return own.generated(source) / f"{file}.toml"


@cache
def model(name: str) -> DynamicsModel:
    return load_dynamics(find_path(name))


def draw_states(name: str, count: int = 4) -> list[Array]:
    """States near the start that the constraints allow."""
    rng, start = np.random.default_rng(5), model(name).start
    moved = (start + 0.05 * rng.standard_normal(len(start)) for _ in range(count))
    return [model(name).dynamics.project(0.0, state) for state in moved]


def differentiate(function: Callable[[Array], Array], point: Array) -> Array:
    """Return central differences (r, n)."""
    steps = 1e-6 * np.maximum(np.abs(point), 1e-2)
    rows = [
        (function(point + step) - function(point - step)) / (2 * step.sum())
        for step in np.diag(steps)
    ]
    return np.reshape(rows, (len(point), len(function(point)))).T


@pytest.mark.parametrize("name", SHORT)
def test_rates_are_those_of_the_equations_of_motion(name: str) -> None:
    subject, dynamics = model(name), model(name).dynamics
    for state in draw_states(name):
        accelerations = dynamics.accelerations(0.0, state)[0]
        expected = np.concatenate([state[dynamics.size :], accelerations])
        rates = subject.rates(0.0, state)
        np.testing.assert_allclose(rates, expected, atol=1e-12 * np.abs(expected).max())
        half = subject.rates(0.0, state, p=0.9 * subject.p)
        assert np.abs(half - expected).max() > 1e-4, "parameters count"


def vary(
    values: Callable[..., Array], arguments: Mapping[str, Array], key: str
) -> Callable[[Array], Array]:
    """A function of one of its arguments."""
    return lambda point: values(0.0, **{**arguments, key: point})


@pytest.mark.parametrize("name", SHORT)
def test_derivatives_are_those_of_differences(name: str) -> None:
    subject = model(name)
    for state in draw_states(name, 2):
        arguments = {"x": state, "u": subject.u, "p": subject.p}
        for values, slopes in (
            (subject.rates, subject.linearised),
            (subject.outputs_at, subject.linearised_outputs),
        ):
            for (key, point), slope in zip(arguments.items(), slopes(0.0, state), strict=True):
                differences = differentiate(vary(values, arguments, key), point)
                size = max(np.abs(differences).max(initial=0.0), 1.0)
                np.testing.assert_allclose(slope, differences, atol=2e-7 * size)


def test_outputs_are_reactions_and_reports() -> None:
    subject, state = model("rubbing"), draw_states("rubbing", 1)[0]
    dynamics = subject.dynamics
    accelerations, sizes = dynamics.accelerations(0.0, state)[0], dynamics.find_sizes(0.0, state)
    inputs = {
        "time": 0.0,
        "data": dynamics.data,
        "state": state,
        "accelerations": accelerations,
        "sizes": sizes,
    }
    actions, _ = Reactions(dynamics.formulas).solve(inputs)
    names = [variable.name for variable in subject.outputs]
    values = dict(zip(names, subject.outputs_at(0.0, state), strict=True))
    for name, action in zip(dynamics.formulas.entries("actions"), actions[:, 0], strict=True):
        assert values[name] == pytest.approx(action, rel=1e-10)


def test_size_of_a_normal_force_tells_where_its_sign_is_another() -> None:
    subject = model("rubbing")
    row = [variable.name for variable in subject.outputs].index("size_N_floor")
    whirled = np.array([0.0, np.pi / 2, 0.3, 18.0])  # upright, where the rod lifts the slider
    for state, sign in ((subject.start, 1.0), (whirled, -1.0)):
        force = subject.dynamics.find_normal_forces(0.0, state)[0]
        size = subject.outputs_at(0.0, state)[row]
        assert np.sign(force) == np.sign(size) == sign
    assert subject.outputs_at(0.0, subject.start)[row] == pytest.approx(
        subject.dynamics.find_sizes(0.0, subject.start)[0], rel=1e-10
    )


def test_curvature_is_the_slope_of_the_gradient() -> None:
    subject, rng = model("cart"), np.random.default_rng(2)
    state = draw_states("cart", 1)[0]
    point = np.concatenate([state, subject.u, subject.p])
    weights, direction = rng.standard_normal(4), rng.standard_normal(len(point))

    def gradient(at: Array) -> Array:
        parts = subject.linearised(0.0, at[:4], at[4:5], at[5:])
        return np.hstack(parts).T @ weights

    step = 1e-6
    expected = (gradient(point + step * direction) - gradient(point - step * direction)) / step / 2
    curvature = np.array(subject.curvature(0.0, state, subject.u, subject.p, weights, direction))[
        :, 0
    ]
    np.testing.assert_allclose(curvature, expected, atol=1e-7 * np.abs(expected).max())


def test_cart_has_the_linear_model_of_textbooks() -> None:
    result = linearise_model(model("cart"))
    m_c, m_p, length, g, d = 1.0, 0.3, 0.5, 9.81, 0.1
    expected = [
        [0, 0, 1, 0],
        [0, 0, 0, 1],
        [0, m_p * g / m_c, -d / m_c, 0],
        [0, -(m_c + m_p) * g / (m_c * length), d / (m_c * length), 0],
    ]
    np.testing.assert_allclose(result.A, expected, atol=1e-14)
    np.testing.assert_allclose(result.B, [[0], [0], [1 / m_c], [-1 / (m_c * length)]], atol=1e-14)
    (force,) = model("cart").inputs
    assert (force.name, force.unit, force.value, force.low, force.high) == ("F", "N", 0, -12, 12)
    assert "F" not in [parameter.name for parameter in model("cart").parameters]


def test_constraint_that_follows_from_others_is_left_out() -> None:
    subject = model("cranks")
    assert len(subject.constraints) == 3
    assert len(subject.left_out) == 1
    inertia, torque, weight = 3 * 0.04 + 2 * 0.3**2, 2.0, 2 * 9.81 * 0.3
    for angle in (1.0, 0.4, 2.1):
        state = np.array([angle, angle, angle, 0, 0.7, 0.7, 0.7, 0])
        acceleration = (torque - weight * cos(angle)) / inertia
        expected = [0.7, 0.7, 0.7, 0, *3 * [acceleration], 0]
        np.testing.assert_allclose(subject.rates(0.0, state), expected, atol=1e-11)
    flat = np.array([1e-7, 1e-7, 1e-7, 0, 0, 0, 0, 0])
    assert subject.pivot(0.0, flat) < 1e-6 < 1e-2 < subject.pivot(0.0, subject.start)
    result = linearise_model(subject)
    assert np.shape(result.basis) == (8, 2)
    np.testing.assert_allclose(
        subject.constraint_slopes(0.0, subject.start) @ result.basis, 0, atol=1e-12
    )


def test_pivot_is_an_output_where_it_changes() -> None:
    for name in ("cranks", "rubbing", "whipple"):
        subject, state = model(name), draw_states(name, 1)[0]
        (place,) = (i for i, x in enumerate(subject.outputs) if x.name == "pivot")
        assert subject.outputs_at(0.0, state)[place] == subject.pivot(0.0, state)
        assert 0 < subject.least_pivot < 1e-3 * subject.pivot(0.0, subject.start)
    assert "pivot" not in [output.name for output in model("cart").outputs]
    assert model("cart").least_pivot == 0
    renamed = CRANKS.replace('m.coordinate("c"', 'm.coordinate("pivot"')
    subject = load_dynamics(own.generated(renamed) / "own.toml")
    names = [x.name for x in (*subject.states, *subject.outputs)]
    assert len(set(names)) == len(names)
    assert {"pivot", "pivot_"} < set(names)


def test_bicycle_has_the_published_eigenvalues() -> None:
    """Meijaard, Papadopoulos, Ruina and Schwab, Proc. R. Soc. A 463 (2007), table 2, at 5 m/s."""
    roots = [complex(*root) for root in linearise_model(model("whipple")).eigenvalues]
    for published in (-0.32286642900409, -0.77534188219585 + 4.46486771378823j, -14.07838969279822):
        assert min(abs(root - published) for root in roots) < 1e-9 * abs(published)


def test_chain_has_the_derivatives_of_pinocchio() -> None:
    """Relative angles of six links; dense factors lose a digit or two against the recursion."""
    pin = pytest.importorskip("pinocchio")
    links = 6
    subject = load_dynamics(own.generated(build_chain(links)) / "own.toml")
    tree = build_tree(links)
    data, rng = tree.createData(), np.random.default_rng(4)
    for _ in range(5):
        q, rates = rng.uniform(-np.pi, np.pi, links), rng.normal(size=links)
        expected = pin.computeABADerivatives(tree, data, q, rates, np.zeros(links))
        slope, _, _ = subject.linearised(0.0, np.concatenate([q, rates]))
        for part, reference in zip(
            (slope[links:, :links], slope[links:, links:]), expected, strict=False
        ):
            error = np.abs(part - reference).max()
            assert error < 1e-10 * np.abs(reference).max()


MOST_OVERHEAD = 6
"""Time of a call by NumPy over that of the graph of 24 links in memory that stays."""


def test_call_by_arrays_costs_little_more_than_the_graph() -> None:
    subject = load_dynamics(own.generated(build_chain(24)) / "own.toml")
    state, function = subject.start, subject.f
    arguments = 0.0, state, subject.u, subject.p
    inputs = [np.array(part, ndmin=1, dtype=float) for part in arguments]
    outputs = [np.zeros(function.nnz_out(i)) for i in range(2)]
    run = bind_memory(function, inputs, outputs, is_straight=True)
    bare = shortest(run)
    assert shortest(lambda: subject.rates(0.0, state)) < MOST_OVERHEAD * bare
    assert shortest(lambda: function(*arguments)) > MOST_OVERHEAD * bare, "a tampered case"
    np.testing.assert_array_equal(subject.rates(0.0, state), outputs[0])


def test_values_of_a_file_can_be_inputs() -> None:
    subject = load_dynamics(find_path("cranks"), ["T_Nm"])
    assert [variable.name for variable in subject.inputs] == ["T"]
    _, slope, _ = subject.linearised(0.0, subject.start)
    inertia = 3 * 0.04 + 2 * 0.3**2
    np.testing.assert_allclose(slope[4:7, 0], 1 / inertia, rtol=1e-12)
    with pytest.raises(InputError, match="T_x"):
        load_dynamics(find_path("cranks"), ["T_x"])


def test_command_prints_the_linear_model() -> None:
    result = answer("linearise", str(find_path("cart")))
    assert [entry["name"] for entry in result["state"]] == ["s", "a", "s_dot", "a_dot"]
    assert [entry["unit"] for entry in result["inputs"]] == ["N"]
    assert np.shape(result["C"]) == (len(result["outputs"]), 4)
    assert np.shape(result["D"]) == (len(result["outputs"]), 1)
    assert result["constraints"] == {"rows": [], "left_out": [], "pivot": 1.0}
    assert answer("linearise", str(find_path("cart")), "--at", "rest")["at"] == "rest"
    assert refusal("linearise", "wang2017", "--json")


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (("q.l))", "F * q.l / 9.81))"), "F"),
        (("high=12", "high=-20"), "high"),
        (('"F", "N"', '"F", "mm"'), "mm"),
        (('m.input("F"', 'm.input("l"'), "l"),
    ],
)
def test_inputs_that_cannot_be_meant_are_refused(change: tuple[str, str], named: str) -> None:
    assert change[0] in CART
    with pytest.raises(ValueError, match=named):
        exec(CART.replace(*change), {})
