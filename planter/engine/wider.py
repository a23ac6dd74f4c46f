"""What wider bounds would bring: an optimum at its bounds is a corner of a box, no more."""

from __future__ import annotations

import numpy as np

from planter.engine.machine import Machine
from planter.engine.problem import DesignProblem
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.local_search import LocalMinimum, search_locally
from planter.engine.solvers.result import OptimiserResult, WiderOptimum
from planter.errors import PlanterError
from planter.kernels import Array

LEAST_SHARE = 0.5
"""Share of a bound that is the least which a value of one sign may have, where its bounds are
widened.
"""


def search_wider(problem: DesignProblem, result: OptimiserResult) -> WiderOptimum | None:
    """Return the optimum of a local search from an optimum within bounds twice as wide about it.

    None if no bound is active there, or if the search ends with an error.
    """
    if not result.certificate.active_bounds:
        return None
    machine, x = problem.machine, result.design
    lower, upper = widen_bounds(machine, x)
    wider = problem.with_box(lower, upper, problem.box.point(x))
    wider.restart()
    try:
        minimum = search_locally(wider, wider.start)
    except PlanterError:  # a design that the file allows may be none that can be built
        return None
    is_better = minimum.violation <= FEASIBILITY_TOLERANCE and minimum.objective < result.objective
    u = minimum.u if is_better else wider.start
    names = {bound.name for bound in result.certificate.active_bounds}
    ends = np.column_stack([lower, upper]) / machine.scale[:, None]
    design = wider.design(u) / machine.scale
    return WiderOptimum(
        objective=minimum.objective if is_better else result.objective,
        active_bounds=_count_active(wider, minimum) if is_better else len(names),
        bounds={
            name: pair
            for name, pair in zip(machine.design_names, ends.tolist(), strict=True)
            if name in names
        },
        design=dict(zip(machine.design_names, design.tolist(), strict=True)),
    )


def _count_active(problem: DesignProblem, minimum: LocalMinimum) -> int:
    """Return how many bounds a minimum is at."""
    below, above = problem.box.slack(minimum.u)
    return int(np.count_nonzero(np.minimum(below, above) <= 0.0))


def widen_bounds(machine: Machine, x: Array) -> tuple[Array, Array]:
    """Return bounds (p,) of a machine's design that are twice as wide, about a design x (p,).

    They stay within what the file may hold. A value whose bounds are above zero, such as a length
    or a mass, stays above half its lower bound, and one whose bounds are below zero likewise.
    """
    lower, upper = machine.lower, machine.upper
    width = upper - lower
    low, high = x - width, x + width
    low = np.where(lower >= 0, np.maximum(low, LEAST_SHARE * lower), low)
    high = np.where(upper <= 0, np.minimum(high, LEAST_SHARE * upper), high)
    for k, index in enumerate(machine.moved):
        lowest, highest = machine.values[index].limits
        factor = machine.values[index].factor
        low[k] = low[k] if lowest is None else max(low[k], lowest * factor)
        high[k] = high[k] if highest is None else min(high[k], highest * factor)
    return np.minimum(low, lower), np.maximum(high, upper)
