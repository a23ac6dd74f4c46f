"""Which of many equal optima is told: the one nearest to the design to start from.

Along some directions an objective may not change at all: a pair of gears scaled as a whole leaves the curve as it was.
Where a search happens to end along them is chance; the rule makes it a fact of the problem.
"""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.optimise import quadratic
from planter.optimise.problem import Problem

SAME = 1e-10
"""Objectives are equal that differ by less than this share of the problem's scale."""
STILL = 1e-9
"""A move below this, in the box's unit, is none."""
MOST_MOVES = 4


def nearest(problem: Problem, u: Array) -> Array:
    """The point (p,) nearest to the design to start from, of those that flat directions join to an optimum u (p,).

    Each move is to first order, then onto the equations; one that costs more than rounding, or breaks a constraint, is
    halved until it does not.
    """
    least = problem.evaluate(u).objective
    for _ in range(MOST_MOVES):
        move = _move(problem, u)
        while np.abs(move).max(initial=0.0) > STILL and not _equal(problem, _moved(problem, u, move), least):
            move = move / 2
        if np.abs(move).max(initial=0.0) <= STILL:
            break
        u = _moved(problem, u, move)
    return u


def _moved(problem: Problem, u: Array, move: Array) -> Array:
    return problem.onto(problem.box.inside(u + move))


def _equal(problem: Problem, u: Array, least: float) -> bool:
    return problem.kept(u) and problem.evaluate(u).objective - least <= SAME * problem.scale


def _move(problem: Problem, u: Array) -> Array:
    """The move (p,) along the flat directions that comes nearest to the start in the box, constraints to first order.

    Over shares c of the directions, the least |u + directions' c - start|^2.
    """
    directions = problem.flat(u)
    if not len(directions):
        return np.zeros(len(u))
    below, above = (np.maximum(room, 0.0) for room in problem.box.room(u))
    rows, most = [directions.T, -directions.T], [above, below]
    if problem.constraints is not None:
        x = problem.design(u)
        slopes = problem.constraints.slopes(x) * problem.box.unit @ directions.T
        values = problem.constraints.values(x)
        for sign, room in ((1, problem.constraints.upper - values), (-1, values - problem.constraints.lower)):
            finite = np.isfinite(room)
            rows.append(sign * slopes[finite])
            most.append(np.maximum(room[finite], 0.0))
    anywhere = np.full(len(directions), np.inf)
    slope = directions @ (u - problem.start)
    bounds = (-anywhere, anywhere)
    found = quadratic.solve(directions @ directions.T, slope, np.vstack(rows), np.concatenate(most), bounds)
    return np.zeros(len(u)) if found is None else found.z @ directions
