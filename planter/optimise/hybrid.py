"""The three methods: `ga`, `ipopt`, which is descents from several starts, and `hybrid`, which runs both as they are,
descends from the best individuals and returns the best of all, so that it is never worse than either alone at the same
seed.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Literal

from planter.kernels import Array
from planter.optimise import genetic
from planter.optimise.descent import Minimum, descend
from planter.optimise.genetic import Individual, Settings
from planter.optimise.problem import Best, Problem
from planter.optimise.result import Candidates, Result, result
from planter.optimise.starts import DEFAULT_STARTS, descents
from planter.parallel.jobs import Jobs
from planter.parallel.task import HERE, Means, Task
from planter.progress import Listener, Phase

Method = Literal["hybrid", "ipopt", "ga"]
METHODS: tuple[Method, ...] = ("hybrid", "ipopt", "ga")
POLISHED = 3
"""How many individuals are polished, and how far apart they must be as a share of the box."""
APART = 0.02


class Search:
    """One run of a method on a problem; each part counts its own evaluations and keeps its own history."""

    def __init__(
        self,
        problem: Problem,
        settings: Settings,
        seed: int = 0,
        starts: int = DEFAULT_STARTS,
        progress: Listener | None = None,
        task: Task | None = None,
        means: Means = HERE,
    ) -> None:
        self.task, self.means = task, means
        self.settings, self.seed, self.starts, self.progress = settings, seed, starts, progress
        self.ga, self.ipopt, self.polish = (problem.anew() for _ in range(3))
        self.minima: list[Minimum] = []
        self.begun = time.perf_counter()

    def run(self, method: Method, under_way: Jobs | None = None, known: Sequence[Array] = ()) -> Result:
        """The best of what the method finds and of points u (p,) that are known to keep the constraints.

        The starts are those `under_way`, else workers run those of the task as `descents` says.
        """
        reached = list(known)
        individuals: list[Individual] = []
        if method in ("ga", "hybrid"):
            individuals = genetic.search(self.ga, self.settings, self.seed, self.progress)
            reached.append(individuals[0].u)
        if method in ("ipopt", "hybrid"):
            self._descend(under_way)
            reached += [minimum.u for minimum in self.minima]
        if method == "hybrid":
            reached += self._polished(genetic.distinct(individuals, POLISHED, APART))
        return self._result(method, reached)

    def so_far(self, method: Method, under_way: Jobs | None = None) -> Result | None:
        """The best point met by any part of an interrupted run; None if there is none."""
        for descent in [] if under_way is None else under_way.results(len(self.minima)):
            self.minima.append(descent.join(self.ipopt))
        reached = [problem.best.u for problem in self._problems if problem.best is not None]
        reached += [minimum.u for minimum in self.minima]
        reached = [u for u in reached if self.polish.kept(u)]
        return self._result(method, reached) if reached else None

    def _descend(self, under_way: Jobs | None) -> None:
        found = descents(self.ipopt, self.starts, self.seed, self.progress, self.task, self.means, under_way)
        for minimum in found:
            self.minima.append(minimum)

    def _polished(self, individuals: Sequence[Individual]) -> list[Array]:
        """The local minima beside individuals, points u (p,)."""
        phase, found = Phase("polish", "individual", len(individuals), self.progress), []
        self.polish.heard = phase.under_way
        for one in individuals:
            found.append(descend(self.polish, one.u).u)
            phase.reached(len(found), best=self.polish.least)
        return found

    def best(self, under_way: Jobs | None = None) -> Best | None:
        """The best point that any part has met so far."""
        rest = [] if under_way is None else under_way.results(len(self.minima))
        met = [descent.best for descent in rest if descent.best is not None]
        met += [problem.best for problem in self._problems if problem.best is not None]
        return min(met, key=lambda best: best.objective, default=None)

    @property
    def _problems(self) -> tuple[Problem, Problem, Problem]:
        return self.ga, self.ipopt, self.polish

    def _result(self, method: Method, reached: list[Array]) -> Result:
        counts = self.ga.counts + self.ipopt.counts + self.polish.counts
        named = zip(("ga", "ipopt", "polish"), self._problems, strict=True)
        history = {name: problem.history for name, problem in named if problem.history}
        found = Candidates(reached, self.minima, counts, history)
        return result(self.ga, method, self.seed, found, time.perf_counter() - self.begun)
