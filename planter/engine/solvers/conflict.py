"""Constraints that cannot hold together near a point, and how far each would have to be relaxed.

Where the violation is smallest to first order, the constraints linearised there have no common
point in the box. Those with a multiplier in the elastic linear programme

    minimise  t   subject to  lower - t <= rows + slopes d <= upper + t,  u + d in the box,  t >= 0

have none either (Farkas). Leaving out one after the other as long as the rest has no common point
gives a set of which every part has one: an irreducible infeasible set by deletion filtering
(Chinneck and Dravnieks, ORSA Journal on Computing 3, 1991, 157-168).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from planter.engine.solvers.constraints import Constraints
from planter.engine.solvers.feasibility import VIOLATION_ROUNDING
from planter.engine.solvers.problem import Problem
from planter.kernels import Array, Flags

MULTIPLIER_ROUNDING = 1e-9
"""Multipliers of the linear programme below this are zero; those of its constraints add up to 1."""


@dataclass(frozen=True)
class Relaxation:
    """A change of a single constraint or bound with which the rest of a conflict has a common
    point, to first order.

    `index` is that of the constraint's kind or of the design's value. `side` is that of a bound,
    "lower" or "upper", and empty for a constraint. `amount` is in the unit of the constraint, or SI
    of the design.
    """

    index: int
    side: str
    amount: float


@dataclass(frozen=True)
class Conflict:
    """Constraints by the index of their kinds, and bounds by the index of a value and the side,
    that cannot hold together near a point to first order, while all but any one of them can; and
    what relaxes it, by a single change each.
    """

    kinds: tuple[int, ...]
    bounds: tuple[tuple[int, str], ...]
    relaxations: tuple[Relaxation, ...]


def find_conflict(problem: Problem, constraints: Constraints, u: Array) -> Conflict | None:
    """Return the conflict at a point u (p,) of smallest violation, None if the constraints
    linearised there have a common point in the box.

    Raises ComputationError if the constraints have no values there.
    """
    programme = _LinearProgram(problem, constraints, u)
    members, multipliers = programme.everything, programme.solve(programme.everything)
    if multipliers.gap <= VIOLATION_ROUNDING:
        return None
    involved = members & (multipliers.sizes > MULTIPLIER_ROUNDING)
    if programme.solve(involved).gap > VIOLATION_ROUNDING:
        members = involved
    for index in np.flatnonzero(members):
        rest = members.copy()
        rest[index] = False
        if programme.solve(rest).gap > VIOLATION_ROUNDING:
            members = rest
    return programme.describe(members)


@dataclass(frozen=True)
class _Solution:
    """Smallest common violation `gap` of members, and sizes (m,) of the multipliers of members."""

    gap: float
    sizes: Array


class _LinearProgram:
    """Constraints and bounds linearised at a point u (p,).

    Members (m,) are the kinds of the constraints, then the lower and the upper bounds.
    """

    def __init__(self, problem: Problem, constraints: Constraints, u: Array) -> None:
        x = problem.design(u)
        self.box, self.kinds = problem.box, constraints.kinds
        at = constraints.at(x)
        rows, slopes = at.values(x), at.slopes(x) * problem.box.unit
        above, below = np.isfinite(at.upper), np.isfinite(at.lower)
        size, count = len(u), len(self.kinds)
        below_slack, above_slack = problem.box.slack(u)
        self.matrix = np.vstack([slopes[above], -slopes[below], -np.eye(size), np.eye(size)])
        self.right = np.concatenate(
            [(at.upper - rows)[above], (rows - at.lower)[below], below_slack, above_slack]
        )
        bounds = count + np.arange(2 * size)
        self.owner = np.concatenate([at.owner[above], at.owner[below], bounds])
        self.everything: Flags = np.ones(count + 2 * size, dtype=bool)

    def solve(self, members: Flags, elastic: Flags | None = None) -> _Solution:
        """Return the smallest gap by which `elastic` members, all constraints by default, must give
        way for the members to have a common point, infinite if that does not suffice.
        """
        kinds = len(self.kinds)
        giving = np.arange(len(members)) < kinds if elastic is None else elastic
        rows = members[self.owner]
        owner = self.owner[rows]
        matrix = np.hstack([self.matrix[rows], -giving[owner, None].astype(float)])
        size = self.matrix.shape[1]
        solution = scipy.optimize.linprog(
            np.append(np.zeros(size), 1.0),
            A_ub=matrix,
            b_ub=self.right[rows],
            bounds=[*[(None, None)] * size, (0.0, None)],
            method="highs",
        )
        sizes = np.zeros(len(members))
        if not solution.success:
            return _Solution(np.inf, sizes)
        np.add.at(sizes, owner, np.abs(solution.ineqlin.marginals))
        return _Solution(float(solution.x[-1]), sizes)

    def describe(self, members: Flags) -> Conflict:
        """Return the conflict of members, with its relaxations."""
        kinds, bounds, changes = list[int](), list[tuple[int, str]](), list[Relaxation]()
        for member in np.flatnonzero(members):
            gap = self.solve(self.everything, np.arange(len(members)) == member).gap
            index, side, unit = self._locate(int(member))
            if side:
                bounds.append((index, side))
            else:
                kinds.append(index)
            if np.isfinite(gap):
                changes.append(Relaxation(index, side, gap * unit))
        return Conflict(tuple(kinds), tuple(bounds), tuple(changes))

    def _locate(self, member: int) -> tuple[int, str, float]:
        """Return the index of a member among the kinds or the values, its side if it is a bound,
        and its unit.
        """
        count, size = len(self.kinds), len(self.box.names)
        if member < count:
            return member, "", float(self.kinds[member].step)
        index = (member - count) % size
        return index, "lower" if member < count + size else "upper", float(self.box.unit[index])
