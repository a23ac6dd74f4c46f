"""Nodes at angles and extrema of a cycle, and its jumps: where they are, and their derivatives against
differences.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest

from planter.engine.curves import QuantityCurves
from planter.engine.goal import Goal
from planter.engine.loops import TURN
from planter.engine.machine import Machine, load_machine
from planter.engine.measures import Measure, parse_sum
from planter.engine.nodes import NodeMeasure
from planter.engine.response import MachineResponse
from planter.engine.solvers.cycle_panels import CyclePanels
from planter.engine.summary import summarise_machine
from planter.kernels import Array
from planter.mechanism.machines import build_machine
from tests.planter.engine.solvers.toys import check_derivatives
from tests.support import own


@cache
def machine(name: str = "slider_crank", *moved: str) -> Machine:
    return build_machine(own.file(name)).with_moved(
        dict.fromkeys(moved or ("r_mm", "l_mm", "e_mm"), (0.0, 1e3))
    )


@pytest.mark.parametrize(
    "text", ["2 s at 30", "F_Ox where beta is greatest", "abs F_Ox where beta is greatest"]
)
def test_derivatives_are_those_of_differences(text: str) -> None:
    (measure,) = parse_sum(text)
    node, x = NodeMeasure(machine(), measure), machine().design
    weights = np.random.default_rng(7).normal(size=1 + len(node.groups))
    check_derivatives(node, x, weights, np.maximum(np.abs(x), 1e-2), 2e-6, (1e-6, 1e-5))


def test_extremum_equals_dense_grid() -> None:
    (measure,) = parse_sum("beta where beta is least")
    value = NodeMeasure(machine(), measure).value(machine().design)
    response, grid = MachineResponse(machine(), ["beta"]), TURN * np.arange(7200) / 7200
    beta = response.values(response.at(machine().design), grid)[0] / response.quantities[0].factor
    assert beta.min() * (1 + 1e-6) <= value <= beta.min()


def measure_jumps(machine: Machine, names: Sequence[str], x: Array | None = None) -> Array:
    """The greatest jump of each quantity, as goals have it, in SI."""
    panels = CyclePanels(QuantityCurves(machine, names), machine.design if x is None else x)
    before, after = np.split(panels.sides, 2, axis=1)
    return np.abs(after - before).max(axis=1, initial=0.0)


@pytest.mark.parametrize(
    "name",
    ["slider_crank", "wang2017", "yu2023", "sun2019-corrected", "shi2021", "planetary_train"],
)
def test_jumps_are_the_shocks_of_the_summary(name: str) -> None:
    """Both routes split the cycle at the events, one of them at those of every order: the largest
    jumps are the same, and what is continuous has none but rounding.
    """
    source = (
        str(own.generated(name) / f"{name}.toml")
        if (own.EXAMPLES / f"{name}.py").is_file()
        else name
    )
    built = load_machine(source)
    names, largest = [quantity.name for quantity in built.results], dict[str, float]()
    for shock in summarise_machine(built).shocks:
        size = abs(shock.after - shock.before) * built.find_quantity(shock.quantity).factor
        largest[shock.quantity] = max(largest.get(shock.quantity, 0.0), size)
    expected = [largest.get(name, 0.0) for name in names]
    np.testing.assert_allclose(measure_jumps(built, names), expected, rtol=1e-9, atol=1e-9)
    assert bool(largest) == (name in ("slider_crank", "yu2023", "shi2021"))


def test_jumps_follow_changed_friction() -> None:
    """The guide's friction is mu N: without it nothing jumps, and small friction makes jumps in
    proportion.
    """
    rubbing = machine("slider_crank", "mu")
    none, some, twice = (
        measure_jumps(rubbing, ["F_Ox"], np.array([mu]))[0] for mu in (0.0, 1e-5, 2e-5)
    )
    assert none < 1e-12
    assert twice == pytest.approx(2 * some, rel=1e-4)
    goal = Goal(rubbing, [Measure("jump", "F_Ox")])
    assert goal.slope(np.array([1e-5]))[0] == pytest.approx(some / 1e-5, rel=1e-4)


def test_machine_whose_laws_never_change_has_no_jumps() -> None:
    arm = build_machine(own.file("transplanting_arm"))
    assert measure_jumps(arm, ["M_in"]) == 0
    moved = arm.with_moved({"p_mm": (200.0, 280.0)})
    assert Goal(moved, [Measure("jump", "M_in")]).evaluate(moved.design) == 0
