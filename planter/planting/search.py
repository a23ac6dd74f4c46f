"""Optimisation of a device's design: least range and spread of its support force within bounds and requirements."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from planter import errors
from planter.engine.search import DesignOptimum, InterruptedSearch, SearchSpec, minimise
from planter.kernels import Array
from planter.optimise.directions import sensitivity
from planter.optimise.hybrid import Method
from planter.optimise.problem import Best
from planter.optimise.range_and_spread import Sampling, angles_of
from planter.optimise.result import Result
from planter.optimise.starts import DEFAULT_STARTS
from planter.parallel.task import AUTO, Means
from planter.planting.model import Device
from planter.planting.problem import beside_design, build_task, kept, problem
from planter.planting.requirements.constraints import Required
from planter.planting.results.optimised import Evaluations, HeldBound, HeldRequirement, OptimumFound, Proof
from planter.planting.results.stated import Requirement
from planter.planting.whole.lengths import Lengths
from planter.progress import Listener


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
    means: Means = AUTO,
) -> Optimum:
    """The best design of a device within its bounds, with its certificate.

    `samples` is "refined" for true extremes and integrals, or a number of angles of a cycle. `starts` is the number of
    descents, `progress` hears how far the search is, `keep` gets the best so far as it is found. With `lengths` the
    pitch curves have these, for whole teeth; minima beside the designs `near`, (p,) each, count too.
    `means` says what runs the descents, whose results do not depend on it.

    Raises InputError for an unknown method, Infeasible where no design keeps the machine's requirements, and
    Interrupted, with the best so far, on KeyboardInterrupt.
    """
    begun, required = time.perf_counter(), Required.of(device)
    task = problem(device, samples, required, lengths)
    spec = SearchSpec(samples, method, starts or DEFAULT_STARTS, seed, device.machine.genetic_algorithm)

    def build_optimum(best: DesignOptimum) -> Optimum:
        result = replace(best.result, seconds=time.perf_counter() - begun)
        return _optimum(device, required, lengths, samples, result)

    def keep_table(best: Best, seconds: float) -> None:
        assert keep is not None
        x = task.design(best.u)
        look = task.score(x).look
        keep({
            "machine": device.machine.name, "model": device.model, "method": method, "samples": samples,
            "objective": best.objective, "design": device.named(x), "range_N": look.range,
            "variance_N2": look.variance, "start_objective": task.reference.objective, "seconds": seconds,
        })  # fmt: skip

    try:
        feasible = [] if task.constraints is None else [kept(task, required, seed, lengths)]
        feasible += [beside_design(task, x).u for x in near]
        descents = build_task(device, samples, lengths)
        return build_optimum(minimise(task, spec, progress, descents, means, feasible, keep and keep_table))
    except InterruptedSearch as stop:
        raise Interrupted(None if stop.best is None else build_optimum(stop.best), device.scale) from None
    except KeyboardInterrupt:
        raise Interrupted(None, device.scale) from None


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
