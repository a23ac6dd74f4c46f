"""Sums of measures of any machine over machines as their tolerances make them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from planter.engine.goal import Goal, GoalConstraints
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.constraints import Constraints, Kind
from planter.tolerance.robust import RobustObjective, draw_inputs
from planter.tolerance.room import Settings
from planter.tolerance.spread import Spread


class RobustGoal(RobustObjective):
    """A sum of measures over machines that are drawn once, as a function of the machine's moved values x (p,) [SI].

    `spreads` are those of values by path. The values that they spread move with the design in one goal, whose functions
    serve all machines.
    """

    def __init__(
        self, machine: Machine, least: Sequence[Measure], limits: Sequence[Limit], spreads: Mapping[str, Spread],
        settings: Settings, samples: int,
    ) -> None:  # fmt: skip
        super().__init__()
        self.machine, self.samples = machine, samples
        self.design, self.lower, self.upper = machine.design, machine.lower, machine.upper
        moved = [machine.values[index].path for index in machine.moved]
        others = [path for path in spreads if path not in moved]
        every = machine.with_moved(dict.fromkeys([*moved, *others], (0.0, 0.0)))
        self.goal = Goal(every, least, [], samples, with_events=False)
        self.limits = DesignLimits(Goal(machine, (), limits, samples, with_events=False)) if limits else None
        self._rest = every.design[len(moved) :]
        drawn = draw_inputs(spreads, settings)
        apart = np.zeros((settings.machines, len(every.moved)))
        for column, path in enumerate([*moved, *others]):
            if path in drawn:
                centre = spreads[path].centre if path in moved else 0.0
                apart[:, column] = (drawn[path] - centre) * every.scale[column]
        self.apart = apart
        for nodes in self.goal.nodes.values():
            nodes.response.compile()

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Return the sum (m,) of each machine, and its gradients (m, p)."""
        points = self.apart + np.concatenate([x, np.zeros(len(self._rest))])
        rows = [(self.goal.evaluate(point), self.goal.slope(point)[: len(x)]) for point in points]
        values, slopes = zip(*rows, strict=True)
        return np.array(values), np.array(slopes)

    def nominal(self, x: Array) -> tuple[float, Array]:
        """Return the sum without tolerances, and its gradient (p,)."""
        point = np.concatenate([x, self._rest])
        return self.goal.evaluate(point), self.goal.slope(point)[: len(x)]

    def named(self, x: Array) -> dict[str, float]:
        """Return a design by the names of the file, in its units."""
        names = self.machine.design_names
        return {name: float(value) for name, value in zip(names, x / self.machine.scale, strict=True)}


class DesignLimits(Constraints):
    """The limits of a goal as rows in the design alone, its variables as tight as they can be."""

    def __init__(self, goal: Goal) -> None:
        self.goal, self._rows = goal, GoalConstraints(goal)
        self.kinds: Sequence[Kind] = self._rows.kinds
        self.owner: Integers = self._rows.owner
        self.lower, self.upper = self._rows.lower, self._rows.upper

    def values(self, x: Array) -> Array:
        """Return the rows (k,) at a design. Raises ComputationError where there is no cycle."""
        return self._rows.values(self.goal.start(x))

    def slopes(self, x: Array) -> Array:
        """Return the gradients (k, p) of the rows; an extreme's is that of the node that has it."""
        slopes = self._rows.slopes(self.goal.start(x))
        return slopes[:, : len(x)] + slopes[:, len(x) :] @ self.goal.variable_slopes(x)

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the weighted sum (p, p) of the rows' Hessians."""
        return self._rows.curvature(self.goal.start(x), weights)[: len(x), : len(x)]
