"""The three methods: `ga`, `ipopt`, and `hybrid`, which runs both as they are, polishes the best individuals by IPOPT
and returns the best of all, so that it is never worse than either alone at the same seed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Literal

from planter.errors import InputError
from planter.kernels import Array
from planter.optimise import feasible, genetic
from planter.optimise.aside import Aside, Report
from planter.optimise.constraints import Constraints
from planter.optimise.descent import Minimum, descend
from planter.optimise.genetic import Individual
from planter.optimise.objective import Objective
from planter.optimise.problem import Problem, Sampling
from planter.optimise.progress import Progress
from planter.optimise.response import Planting, Response
from planter.optimise.result import Found, Interrupted, Result, result
from planter.optimise.starts import DEFAULT_STARTS, descents, points
from planter.planting.model import Device
from planter.planting.sections import GeneticAlgorithm

Method = Literal["hybrid", "ipopt", "ga"]
METHODS: tuple[Method, ...] = ("hybrid", "ipopt", "ga")
POLISHED = 3
"""How many individuals are polished, and how far apart they must be as a share of the box."""
APART = 0.02


def run(
    device: Device,
    method: Method = "hybrid",
    samples: Sampling | None = None,
    seed: int = 0,
    starts: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Result:
    """The best design of a device within its bounds. `samples` None: as the machine file says.

    Raises InputError for an unknown method, Infeasible where no design keeps the machine's requirements, and
    Interrupted, with the best so far, on KeyboardInterrupt.
    """
    if method not in METHODS:
        raise InputError(f"method = {method!r} is not allowed: it must be one of {', '.join(METHODS)}")
    sampling = device.machine.objective.samples if samples is None else samples
    count = DEFAULT_STARTS if starts is None else starts
    response, objective = Planting(device), Objective.of(device.machine)
    search = Search(response, objective, sampling, device.machine.genetic_algorithm, seed, count, progress,
                    Constraints.of(device))  # fmt: skip
    with _beside(device, method, sampling, seed, count) as beside:
        try:
            return search.run(method, beside)
        except KeyboardInterrupt:
            raise Interrupted(search.so_far(method, beside), device.scale) from None


def _beside(
    device: Device, method: Method, sampling: Sampling, seed: int, starts: int
) -> AbstractContextManager[Aside | None]:
    """The starts in a second process, where there is something to run beside them and a core for it."""
    if method != "hybrid" or (os.cpu_count() or 1) < 2 or device.force.slopes_kernel.way == "lanes":
        return nullcontext()
    return Aside(device, sampling, seed, starts)


class Search:
    """One run of a method on a response; each part counts its own evaluations and keeps its own history."""

    def __init__(
        self,
        response: Response,
        objective: Objective,
        sampling: Sampling,
        settings: GeneticAlgorithm,
        seed: int = 0,
        starts: int = DEFAULT_STARTS,
        progress: Callable[[Progress], None] | None = None,
        constraints: Constraints | None = None,
    ) -> None:
        self.constraints = constraints
        self.settings, self.seed, self.starts, self.progress = settings, seed, starts, progress
        self.ga, self.ipopt, self.polish = (Problem(response, objective, sampling, constraints) for _ in range(3))
        self.minima: list[Minimum] = []
        self.begun = time.perf_counter()

    def run(self, method: Method, beside: Aside | None = None) -> Result:
        """The best of what the method finds; with `beside`, its starts come from there."""
        reached = self._kept()
        individuals: list[Individual] = []
        if method in ("ga", "hybrid"):
            individuals = genetic.search(self.ga, self.settings, self.seed, self.progress)
            reached.append(individuals[0].u)
        if method in ("ipopt", "hybrid"):
            self._descend(beside)
            reached += [minimum.u for minimum in self.minima]
        if method == "hybrid":
            reached += [descend(self.polish, one.u).u for one in genetic.distinct(individuals, POLISHED, APART)]
        return self._result(method, reached)

    def _kept(self) -> list[Array]:
        """A point that keeps the requirements, where there are any. Raises Infeasible where there is none."""
        if self.constraints is None:
            return []
        tried = points(self.polish, feasible.MOST_TRIED, self.seed)
        return [feasible.point(self.polish, self.constraints, tried)]

    def so_far(self, method: Method, beside: Aside | None = None) -> Result | None:
        """The best point met by any part of an interrupted run; None if there is none."""
        if beside is not None and not self.minima:
            self._take(beside.so_far())
        reached = [problem.best.u for problem in self._problems if problem.best is not None]
        reached += [minimum.u for minimum in self.minima]
        reached = [u for u in reached if self.polish.kept(u)]
        return self._result(method, reached) if reached else None

    def _descend(self, beside: Aside | None) -> None:
        report = beside.result() if beside is not None else None
        if report is not None:
            self._take(report)
        else:
            for minimum in descents(self.ipopt, self.starts, self.seed, self.progress):
                self.minima.append(minimum)

    def _take(self, report: Report) -> None:
        self.minima, self.ipopt.counts, self.ipopt.history = report.minima, report.counts, report.history

    @property
    def _problems(self) -> tuple[Problem, Problem, Problem]:
        return self.ga, self.ipopt, self.polish

    def _result(self, method: Method, reached: list[Array]) -> Result:
        counts = self.ga.counts + self.ipopt.counts + self.polish.counts
        named = zip(("ga", "ipopt", "polish"), self._problems, strict=True)
        history = {name: problem.history for name, problem in named if problem.history}
        found = Found(reached, self.minima, counts, history)
        return result(self.ga, method, self.seed, found, time.perf_counter() - self.begun)
