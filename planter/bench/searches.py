"""Whole optimisations: the genetic algorithm, IPOPT and both, on the same kernels."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import Any

from planter.bench.case import Case
from planter.bench.clock import Times, race
from planter.bench.results import Basins, Seed
from planter.optimise import genetic
from planter.optimise.starts import descents
from planter.planting import search
from planter.planting.model import Device
from planter.planting.objective import problem as problem_of

REFERENCE = "ipopt"
BUILT = {
    "ga": "the machine file's settings, a new seed at every call",
    "ipopt": "from the machine file's design",
    "hybrid": "both, IPOPT from the default number of starts, and the best individuals polished",
}
MOST_STARTS = 64
CLOSE = 1e-9


def compiled(case: Case, model: str) -> Device:
    """The device in a model, everything compiled beforehand: compile time is not counted."""
    device = case.device if model == case.device.model else Device(case.device.machine, "printed")
    device.compile()
    device.force.response.hessian_kernel.compile()
    return device


def printed(case: Case, rounds: int) -> tuple[dict[str, Times], dict[str, list[float]]]:
    """The printed model has one basin: durations of each method, and the objectives it reached."""
    device = compiled(case, "printed")
    samples = device.machine.objective.samples
    reached: dict[str, list[float]] = {name: [] for name in BUILT}

    def run(name: Any, starts: int | None) -> Callable[[Any], None]:
        return lambda seed: reached[name].append(search.run(device, name, samples, seed, starts).objective)

    calls = {"ga": run("ga", None), "ipopt": run("ipopt", 1), "hybrid": run("hybrid", None)}
    for name in ("ipopt", "hybrid"):  # whatever they compile on the way is not counted either
        calls[name](0)
    return race(calls, itertools.count(), rounds, 0), reached


def exact(case: Case, rounds: int) -> Basins:
    """The exact model has several basins: time and starts until IPOPT meets what the GA found, for each seed."""
    device = compiled(case, "exact")
    return Basins("exact", [_met(device, seed) for seed in range(rounds)])


def _met(device: Device, seed: int) -> Seed:
    sought, begun = problem_of(device, device.machine.objective.samples), time.perf_counter()
    target = genetic.search(sought, device.machine.genetic_algorithm, seed)[0].objective
    ga_s = time.perf_counter() - begun
    problem, begun = problem_of(device, device.machine.objective.samples), time.perf_counter()
    best, starts = float("inf"), 0
    for minimum in descents(problem, MOST_STARTS, seed):
        best, starts = min(best, minimum.objective), starts + 1
        if best <= target * (1 + CLOSE):
            break
    ipopt_s = time.perf_counter() - begun
    return Seed(seed, target, ga_s, best, ipopt_s, starts, met=best <= target * (1 + CLOSE))
