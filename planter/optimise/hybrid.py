"""The three methods: `ga`, `ipopt`, which is descents from several starts, and `hybrid`, which runs both as they are,
descends from the best individuals and returns the best of all, so that it is never worse than either alone at the same
seed.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Literal

from planter.kernels import Array
from planter.optimise import genetic
from planter.optimise.descent import Minimum
from planter.optimise.genetic import Individual, Settings
from planter.optimise.problem import Best, Problem
from planter.optimise.result import Candidates, Result, result
from planter.optimise.starts import DEFAULT_STARTS, descents, find_minima, points
from planter.parallel.jobs import Jobs
from planter.parallel.task import AUTO, Means, Task
from planter.progress import Listener, ProgressPhase

Method = Literal["hybrid", "ipopt", "ga"]
METHODS: tuple[Method, ...] = ("hybrid", "ipopt", "ga")
POLISHED = 3
"""How many individuals are polished, and how far apart they must be as a share of the box."""
APART = 0.02


class Search:
    """One run of a method on a problem; each part has its own counts and its own history.

    Workers run the descents of the task as `means` says; those of `hybrid` begin before the genetic algorithm if
    `early` says what runs them.
    """

    def __init__(
        self,
        problem: Problem,
        settings: Settings,
        seed: int = 0,
        starts: int = DEFAULT_STARTS,
        progress: Listener | None = None,
        task: Task | None = None,
        means: Means = AUTO,
        early: Means | None = None,
    ) -> None:
        self.task, self.means, self.early = task, means, early
        self.settings, self.seed, self.starts, self.progress = settings, seed, starts, progress
        self.ga, self.ipopt, self.polish = (problem.anew() for _ in range(3))
        self.minima: list[Minimum] = []
        self.begun = time.perf_counter()
        self._jobs: Jobs | None = None

    def run(self, method: Method, known: Sequence[Array] = ()) -> Result:
        """Return the best of what the method reaches and of points u (p,) that satisfy the constraints.

        Raises NoFeasiblePointError if nothing satisfies them, ComputationError if no descent leads anywhere.
        """
        reached = list(known)
        individuals: list[Individual] = []
        with self._begin_descents(method) as self._jobs:
            if method in ("ga", "hybrid"):
                self.ga.restart()
                individuals = genetic.search(self.ga, self.settings, self.seed, self.progress)
                reached.append(individuals[0].u)
            if method in ("ipopt", "hybrid"):
                self._descend()
                reached += [minimum.u for minimum in self.minima]
            if method == "hybrid":
                reached += self._polish(genetic.distinct(individuals, POLISHED, APART))
        return self._result(method, reached)

    def so_far(self, method: Method) -> Result | None:
        """Return the best point met by any part of an interrupted run; None if there is none."""
        for descent in [] if self._jobs is None else self._jobs.results():
            if isinstance(end := descent.join(self.ipopt), Minimum):
                self.minima.append(end)
        reached = [problem.best.u for problem in self._problems if problem.best is not None]
        reached += [minimum.u for minimum in self.minima]
        reached = [u for u in reached if self.polish.kept(u)]
        return self._result(method, reached) if reached else None

    def best(self) -> Best | None:
        """Return the best point that any part has met so far."""
        rest = [] if self._jobs is None else self._jobs.results()
        met = [descent.best for descent in rest if descent.best is not None]
        met += [problem.best for problem in self._problems if problem.best is not None]
        return min(met, key=lambda best: best.objective, default=None)

    def _begin_descents(self, method: Method) -> AbstractContextManager[Jobs | None]:
        """Return the jobs of the starts, under way from now on; None if they come after the genetic algorithm."""
        if method != "hybrid" or self.task is None or self.early is None:
            return nullcontext()
        return Jobs(self.task, points(self.ipopt, self.starts, self.seed), self.early)

    def _descend(self) -> None:
        minima = descents(self.ipopt, self.starts, self.seed, self.progress, self.task, self.means, self._jobs)
        for minimum in minima:
            self.minima.append(minimum)

    def _polish(self, individuals: Sequence[Individual]) -> list[Array]:
        """Return the local minima near individuals, points u (p,)."""
        phase, starts = (
            ProgressPhase("polish", "individual", len(individuals), self.progress),
            [one.u for one in individuals],
        )
        if self._jobs is not None:
            self._jobs.add(starts)
        minima = find_minima(self.polish, starts, phase, self.task, self.means, self._jobs)
        return [minimum.u for minimum in minima]

    @property
    def _problems(self) -> tuple[Problem, Problem, Problem]:
        return self.ga, self.ipopt, self.polish

    def _result(self, method: Method, reached: list[Array]) -> Result:
        counts = self.ga.counts + self.ipopt.counts + self.polish.counts
        named = zip(("ga", "ipopt", "polish"), self._problems, strict=True)
        history = {name: problem.history for name, problem in named if problem.history}
        candidates = Candidates(reached, self.minima, counts, history)
        return result(self.ga, method, self.seed, candidates, time.perf_counter() - self.begun)
