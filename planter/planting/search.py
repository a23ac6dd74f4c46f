"""Optimisation of a device's design: least range and spread of its support force within bounds and requirements."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from planter import errors
from planter.errors import InputError
from planter.kernels import Array
from planter.optimise import pareto
from planter.optimise.directions import sensitivity
from planter.optimise.hybrid import METHODS, Method, Search
from planter.optimise.pareto import Compromise
from planter.optimise.problem import Best, Problem
from planter.optimise.range_and_spread import Sampling, angles_of
from planter.optimise.result import Result
from planter.optimise.starts import DEFAULT_STARTS
from planter.parallel.task import HERE, Means, count_cores
from planter.planting.model import Device
from planter.planting.problem import beside_design, build_task, kept, problem
from planter.planting.requirements.constraints import Required
from planter.planting.results.optimised import Evaluations, HeldBound, HeldRequirement, OptimumFound, Proof
from planter.planting.results.stated import Requirement
from planter.planting.whole.lengths import Lengths
from planter.progress import Listener, Progress


@dataclass(frozen=True)
class Optimum(Result):
    """A device's optimum: `design` x (p,) in SI.

    `insensitive` spans the directions that the force does not feel at the optimum, each [{name: weight}, ...] in
    parts of the box width: along these the design is not determined.
    """

    sampling: Sampling
    names: tuple[str, ...]
    effective_parameters: int
    insensitive: list[list[dict[str, float]]]
    requirements: list[Requirement]

    def shown(self, scale: Array) -> OptimumFound:
        """The optimum as results show it; `scale` (p,) is SI per shown unit."""
        return OptimumFound(
            method=self.method,
            samples=self.sampling,
            objective=self.objective,
            design=dict(zip(self.names, (self.design / scale).tolist(), strict=True)),
            range_N=self.evaluation.look.range,
            variance_N2=self.evaluation.look.variance,
            start_objective=self.start_objective,
            evaluations=Evaluations(**vars(self.evaluations)),
            seconds=self.seconds,
            certificate=self._proof(),
            effective_parameters=self.effective_parameters,
            insensitive=self.insensitive,
            requirements=self.requirements or None,
        )

    def _proof(self) -> Proof:
        """The certificate, with the requirements that hold the optimum where there are any to keep."""
        proof, required = self.certificate, {one.name for one in self.requirements}
        held = [HeldRequirement(**vars(one)) for one in proof.active_constraints if one.name in required]
        return Proof(
            kkt_residual=proof.kkt_residual,
            active_bounds=[HeldBound(**vars(bound)) for bound in proof.active_bounds],
            starts=proof.starts,
            agreeing_starts=proof.agreeing_starts,
            spread=proof.spread,
            active_requirements=held if self.requirements else None,
        )


Table = dict[str, Any]
"""What is known of an unfinished search, as the interface gives it."""
APART = 1.0
"""Seconds between two points that an unfinished search hands over, while it goes from step to step."""


class Interrupted(errors.Interrupted):
    """The user stopped an optimisation; `best` is the result so far, None if nothing was evaluated yet."""

    def __init__(self, best: Optimum | None, scale: Array) -> None:
        super().__init__(None if best is None else best.shown(scale).table())
        self.best = best


def run(
    device: Device,
    method: Method = "hybrid",
    samples: Sampling = "refined",
    seed: int = 0,
    starts: int | None = None,
    progress: Listener | None = None,
    keep: Callable[[Table], None] | None = None,
    lengths: Lengths | None = None,
    near: Sequence[Array] = (),
    means: Means = HERE,
) -> Optimum:
    """The best design of a device within its bounds, with its certificate.

    `samples` is "refined" for true extremes and integrals, or a number of angles of a cycle. `starts` is the number of
    descents, `progress` hears how far the search is, `keep` gets the best so far as it is found. With `lengths` the
    pitch curves have these, for whole teeth; minima beside the designs `near`, (p,) each, count too.
    `means` says what runs the descents, whose results do not depend on it.

    Raises InputError for an unknown method, Infeasible where no design keeps the machine's requirements, and
    Interrupted, with the best so far, on KeyboardInterrupt.
    """
    if method not in METHODS:
        raise InputError(f"method = {method!r} is not allowed: it must be one of {', '.join(METHODS)}")
    count = DEFAULT_STARTS if starts is None else starts
    required = Required.of(device)
    task = problem(device, samples, required, lengths)
    descents = build_task(device, samples, lengths)
    early = _choose_early_means(device, means)
    search = Search(task, device.machine.genetic_algorithm, seed, count, task=descents, means=means, early=early)
    best_so_far = _Keeper(device, task, method, samples, search.best, keep)
    search.progress = _both(progress, best_so_far)
    try:
        known = [] if task.constraints is None else [kept(task, required, seed, lengths)]
        known += [beside_design(task, x).u for x in near]
        return _optimum(device, required, lengths, samples, search.run(method, known))
    except KeyboardInterrupt:
        best = search.so_far(method)
        optimum = None if best is None else _optimum(device, required, lengths, samples, best)
        raise Interrupted(optimum, device.scale) from None


class _Keeper:
    """Hands over the best point of a search whenever it is told that there may be a better one."""

    def __init__(
        self, device: Device, task: Problem, method: str, samples: Sampling, best: Callable[[], Best | None],
        keep: Callable[[Table], None] | None,
    ) -> None:  # fmt: skip
        self.device, self.task, self.method, self.samples = device, task, method, samples
        self.best, self.keep = best, keep
        self.begun, self.last, self.least = time.perf_counter(), 0.0, float("inf")

    def __call__(self, step: Progress) -> None:
        now = time.perf_counter()
        if self.keep is None or step.best is None or step.best >= self.least:
            return
        if now - self.last < APART and step.done < step.total:
            return
        best = self.best()
        if best is not None and best.objective < self.least:
            self.last, self.least = now, best.objective
            self.keep(self._table(best, now - self.begun))

    def _table(self, best: Best, seconds: float) -> Table:
        x = self.task.design(best.u)
        look = self.task.score(x).look
        return {
            "machine": self.device.machine.name, "model": self.device.model, "method": self.method,
            "samples": self.samples, "objective": best.objective, "design": self.device.named(x), "range_N": look.range,
            "variance_N2": look.variance, "start_objective": self.task.reference.objective, "seconds": seconds,
        }  # fmt: skip


def _both(first: Listener | None, second: Listener) -> Listener:
    def both(step: Progress) -> None:
        second(step)
        if first is not None:
            first(step)

    return both


def _optimum(
    device: Device, required: Required | None, lengths: Lengths | None, sampling: Sampling, found: Result
) -> Optimum:
    held = None if lengths is None else lengths.slopes(found.design)
    felt = sensitivity(device.force, found.design, angles_of(sampling), held)
    return Optimum(
        **vars(found), sampling=sampling, names=device.names, effective_parameters=felt.effective_parameters,
        insensitive=felt.named,
        requirements=[] if required is None else required.record(found.design),
    )  # fmt: skip


def _choose_early_means(device: Device, means: Means) -> Means | None:
    """Return what runs the starts while the genetic algorithm runs here; None if they come after it."""
    if means == HERE:
        spare = count_cores() - 1
        return None if spare < 1 or device.force.response.slopes_kernel.way == "lanes" else Means(spare)
    return means


def front(
    device: Device, samples: Sampling = "refined", points: int = 15, progress: Listener | None = None
) -> list[Compromise]:
    """The Pareto front of range against variance of a device's force, from least range to least variance."""
    return pareto.sweep(device.force, samples, points, progress)
