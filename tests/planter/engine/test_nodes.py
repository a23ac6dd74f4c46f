"""Nodes at angles, extrema and jumps of a cycle: where they are, and their derivatives against
differences.
"""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from planter.engine.loops import TURN
from planter.engine.machine import Machine, load_machine
from planter.engine.measures import Extremum
from planter.engine.nodes import ExtremumNode, FixedNodes, JumpNodes, Nodes
from planter.engine.summary import summarise_machine
from planter.errors import ComputationError
from planter.mechanism.machines import build_machine
from tests.planter.optimise.toys import check_derivatives
from tests.support import own

NAMES = ("s", "F_Ox")


@cache
def machine(name: str = "slider_crank", *moved: str) -> Machine:
    return build_machine(own.file(name)).with_moved(
        dict.fromkeys(moved or ("r_mm", "l_mm", "e_mm"), (0.0, 1e3))
    )


NODES = {
    "angles": lambda: FixedNodes(machine(), NAMES, np.array([0.3, 2.0])),
    "jumps": lambda: JumpNodes(machine(), NAMES),
    "where": lambda: ExtremumNode(machine(), NAMES, Extremum("beta", 1)),
}


@pytest.mark.parametrize("build", NODES.values(), ids=NODES.keys())
def test_derivatives_are_those_of_differences(build: object) -> None:
    nodes: Nodes = build()  # type: ignore[operator]
    x = machine().design
    shape = nodes(x).values.shape
    rows = SimpleNamespace(
        values=lambda y: nodes.evaluate(y).values.ravel(),
        slopes=lambda y: nodes.evaluate(y).slopes.reshape(-1, len(x)),
        curvature=lambda y, weights: nodes.evaluate(y).curvature(weights.reshape(shape)),
    )
    weights = np.random.default_rng(7).normal(size=np.prod(shape))
    check_derivatives(rows, x, weights, np.maximum(np.abs(x), 1e-2), 2e-6, (1e-6, 1e-5))


def test_extremum_equals_dense_grid() -> None:
    node = ExtremumNode(machine(), ["beta"], Extremum("beta", -1))
    grid = TURN * np.arange(7200) / 7200
    beta = FixedNodes(machine(), ["beta"], grid)(machine().design).values[0]
    assert node(machine().design).values[0, 0] == pytest.approx(beta.min(), rel=1e-6)
    assert node(machine().design).values[0, 0] <= beta.min()


def test_jumps_are_the_shocks_of_the_summary() -> None:
    """Both routes split the cycle at the slider's dead centres; what is continuous there has no
    jump but rounding.
    """
    at = JumpNodes(machine(), ["F_Ox", "F_Oy", "s", "a_slider_x"])(machine().design)
    shocks = [
        shock for shock in summarise_machine(machine()).shocks if shock.quantity in ("F_Ox", "F_Oy")
    ]
    expected = sorted((shock.quantity, shock.after - shock.before) for shock in shocks)
    jumps = sorted(
        (name, value)
        for name, row in zip(("F_Ox", "F_Oy"), at.values, strict=False)
        for value in set(row)
    )
    assert [name for name, _ in jumps] == [name for name, _ in expected]
    np.testing.assert_allclose(
        [value for _, value in jumps], [value for _, value in expected], rtol=1e-12
    )
    np.testing.assert_allclose(at.values[2:], 0, atol=1e-12)


@pytest.mark.parametrize(
    "name", ["wang2017", "yu2023", "sun2019-corrected", "shi2021", "planetary_train"]
)
def test_no_result_jumps_where_forces_are_continuous(name: str) -> None:
    """The summary looks at events of every order, jumps at those of order 0: the largest are the
    same.
    """
    source = (
        str(own.generated(name) / f"{name}.toml")
        if (own.EXAMPLES / f"{name}.py").is_file()
        else name
    )
    built = load_machine(source)
    names, largest = [quantity.name for quantity in built.results], dict[str, float]()
    for shock in summarise_machine(built).shocks:
        largest[shock.quantity] = max(
            largest.get(shock.quantity, 0.0), abs(shock.after - shock.before)
        )
    jumps = np.abs(JumpNodes(built, names)(built.design).values).max(axis=1)
    np.testing.assert_allclose(
        jumps, [largest.get(name, 0.0) for name in names], rtol=1e-9, atol=1e-9
    )
    assert bool(largest) == (name in ("yu2023", "shi2021"))


def test_jumps_follow_changed_friction() -> None:
    """The guide's friction is mu N: without it nothing jumps, and small friction makes jumps in
    proportion.
    """
    rubbing = machine("slider_crank", "mu")
    nodes = JumpNodes(rubbing, ["F_Ox"])
    none, some, twice = (np.abs(nodes(np.array([mu])).values).max() for mu in (0.0, 1e-5, 2e-5))
    assert none < 1e-12
    assert twice == pytest.approx(2 * some, rel=1e-4)
    slope = nodes(np.array([0.0])).slopes[0, :, 0]
    assert np.abs(slope).max() == pytest.approx(some / 1e-5, rel=1e-4)


def test_machine_whose_laws_never_change_has_no_jumps() -> None:
    arm = build_machine(own.file("transplanting_arm"))
    assert not JumpNodes(arm, ["M_in"])(arm.design).values.any()


def test_more_events_than_nodes_are_refused() -> None:
    nodes = JumpNodes(machine(), ["F_Ox"])
    nodes.count = 1
    with pytest.raises(ComputationError, match="a law changes 2 times"):
        nodes.evaluate(machine().design)
