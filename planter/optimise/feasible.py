"""Is there a point that keeps all constraints? If not, the nearest to it: which ones give way, by how much."""

from __future__ import annotations

from collections.abc import Sequence

from planter.kernels import Array
from planter.optimise.constraints import KEPT, Constraints
from planter.optimise.elastic import Least, least_violation
from planter.optimise.problem import Problem

MOST_TRIED = 2
"""How many points the least violation is looked for from."""


def nearest(problem: Problem, constraints: Constraints, starts: Sequence[Array]) -> Least:
    """A point that keeps all constraints, looked for from those of `starts` with the least violation.

    Where there is none, `kept` is False and the least violation that was found is told.
    """
    found: list[Least] = []
    for start in sorted(map(problem.onto, starts), key=problem.violation)[:MOST_TRIED]:
        found.append(least_violation(problem, constraints, start))
        if found[-1].kept:
            return found[-1]
    return least_of(found)


def least_of(found: Sequence[Least]) -> Least:
    """The least of several violations, fewest kinds of constraints first."""
    return min(found, key=lambda least: (int((least.excess > KEPT).sum()), least.total))
