"""The sampled turn: half of an even grid, exact first and second derivatives, also beside and on
breakpoints.
"""

import numpy as np
import pytest

from planter.engine.solvers.objective import BreakpointHold
from planter.engine.solvers.response import find_breakpoints
from planter.engine.solvers.sampled_cycle import SampledCycle, SampledRows, sample_angles
from tests.planter.engine.solvers import toys
from tests.planter.engine.solvers.toys import check_derivatives


@pytest.mark.parametrize("samples", [90, 91])
def test_half_turn_equals_all_samples(samples):
    response = toys.planting()
    (force,) = response.curves.values(
        response.prologue(response.design), 2 * np.pi * np.arange(samples) / samples
    )
    summary = SampledCycle(response, toys.SUM, samples).summarise(response.design)
    assert summary.tops == pytest.approx((force.max(), -force.min()), abs=1e-10)
    assert summary.smooth == pytest.approx(0.4 * force.var(), rel=1e-11)


def crossing(side: float) -> tuple[SampledRows, np.ndarray]:
    """The machine with the breakpoint at t = pi/m of gear 3 a little before or behind the sample at 92
    deg.
    """
    response = toys.planting()
    x = response.design.copy()
    x[6] = np.pi / (np.radians(92) + side * 1e-4 + x[2])
    return SampledRows(
        response, toys.SUM, sample_angles(360, np.pi), np.ones((2, 180), dtype=bool)
    ), x


@pytest.mark.parametrize("side", [-1, 1])
def test_derivatives_are_exact_on_both_sides_of_a_joint(side):
    rows, x = crossing(side)
    width = rows.response.upper - rows.response.lower
    weights = np.append(0.7, np.random.default_rng(3).normal(size=360))
    check_derivatives(rows, x, weights, width)


def test_second_derivatives_jump_there():
    """What makes the test above one of two sides: the curvature of sample 92 is not the same on
    both.
    """
    weights = np.eye(361)[1 + 92]
    before, after = (rows.curvature(x, weights)[6, 6] for rows, x in (crossing(-1), crossing(1)))
    assert abs(after - before) > 0.1 * max(abs(before), abs(after))


@pytest.mark.parametrize("response", [toys.planting(), toys.bent()], ids=["machine", "toy"])
def test_pinned_samples_move_with_their_joint_smoothly(response):
    width = response.upper - response.lower
    x = response.lower + 0.4 * width
    turn = SampledCycle(response, toys.SUM, 24)
    breakpoints = find_breakpoints(response, response.prologue(x))
    first = int(np.flatnonzero(breakpoints.orders == 1)[0])
    sample = int(np.abs(turn.angles - breakpoints.folded[first]).argmin())
    rows = turn.local(x, [BreakpointHold(sample, int(breakpoints.events[first]))])
    assert rows.values(x)[-1:] == pytest.approx(
        [breakpoints.folded[first] - turn.angles[sample]], abs=1e-12
    )
    n = len(turn.angles)
    chosen = np.array([np.ones(n), np.zeros(n)], dtype=bool)
    rows = SampledRows(response, toys.SUM, turn.angles, chosen, rows.holds)
    weights = np.concatenate([[1.3], np.linspace(-1, 1, n), [0.8]])
    check_derivatives(rows, x, weights, width)


def test_sample_at_breakpoint_has_both_gradients():
    toy = toys.corner()
    turn = SampledCycle(toy, toys.SUM, 12)
    on = turn.conditions(np.array([np.pi / 6]))
    off = turn.conditions(np.array([np.pi / 6 + 1e-4]))
    assert (np.bincount(on.groups).tolist(), np.bincount(off.groups).tolist()) == (
        [13, 13],
        [12, 12],
    )
    assert on.gradients[[1, 12], 0] == pytest.approx([0.5, -0.5], abs=1e-7)
    assert on.kinks.shape == (1, 1)
    before, after = (turn.conditions(np.array([np.pi / 6 + s * 1e-7])).smooth for s in (1, -1))
    assert on.smooth == pytest.approx(before, abs=1e-6)
    assert on.smooth + on.kinks[0] == pytest.approx(after, abs=1e-6)
