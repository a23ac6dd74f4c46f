"""The Pareto front of range and variance of a quantity of a machine."""

from __future__ import annotations

from planter.engine.curves import QuantityCurves
from planter.engine.goal import Goal
from planter.engine.machine import Machine
from planter.engine.measures import Measure
from planter.engine.problem import DesignProblem
from planter.engine.solvers.curve_sum import Sampling
from planter.engine.solvers.pareto import trace_pareto_front
from planter.errors import InputError
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.progress import Listener

FRONT_POINTS = 5


def require_front(problem: DesignProblem) -> str:
    """Return the name of the quantity of which a sum is range and variance.

    Raises InputError for another sum, and under limits.
    """
    terms, machine = problem.goal.terms, problem.machine
    names, kinds = {measure.name for measure in terms}, {measure.kind for measure in terms}
    is_plain = kinds <= {"range", "variance", "std"} and not any(
        m.during or m.size or m.weight < 0 for m in terms
    )
    curve = (
        QuantityCurves(machine, [*names])
        if is_plain and len(names) == 1 and machine.turn == TURN
        else None
    )
    if curve is None or not curve.is_closed or any(event.order == 0 for event in curve.events):
        allowed = "a front takes range and variance of one quantity that repeats and does not jump"
        raise InputError(f"--front does not apply to the sum for {machine.name}: {allowed}")
    if problem.constraints is not None:
        raise InputError(
            f"--front does not apply to {machine.name} under limits: they would not be satisfied"
        )
    return terms[0].name


def trace_front(
    machine: Machine, name: str, sampling: Sampling, listener: Listener | None = None
) -> list[tuple[float, float, Array]]:
    """Return range, variance, both in display units, and design (p,) in SI of each point of the
    front, from the smallest range to the smallest variance, limits or not.
    """
    samples = None if sampling == "refined" else sampling
    sums = (
        [Measure("range", name, weight=0.0), Measure("variance", name)],
        [Measure("range", name)],
    )
    problems = [DesignProblem(Goal(machine, terms, (), samples), sampling) for terms in sums]
    front = trace_pareto_front(problems[0], problems[1], FRONT_POINTS, listener)
    factor = machine.find_quantity(name).factor  # rows are in SI, sums in display units
    return [(point.range / factor, point.variance, point.design) for point in front]
