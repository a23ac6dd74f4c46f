"""`planter optimise --prove`: how much better than the optimum that was found a design of the box can be at most."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.optimise.proof.curve import samples
from planter.optimise.proof.jets import Jet, Space
from planter.optimise.proof.objective import Bounds, bounds
from planter.optimise.proof.search import Bounded, Search
from planter.optimise.range_and_spread import Sampling
from planter.planting.enclosed import EnclosedForce
from planter.planting.model import Device
from planter.planting.objective import weights
from planter.planting.optimisation import Optimisation
from planter.planting.results.optimised import GlobalBound
from planter.progress import Listener, Progress

SECONDS = 480.0
"""Time for a proof, if nothing else is said [s]."""
GOAL = 1e-6
"""Gap of what counts as proved, as a share of the objective."""


class _Clock:
    """Tells every full second once."""

    def __init__(self, reached: float, limit: float, listener: Listener | None) -> None:
        self.reached, self.total, self.listener, self.next = reached, max(1, math.ceil(limit)), listener, 1

    def __call__(self, least: float, boxes: int, spent: float) -> None:
        for second in range(self.next, min(int(spent), self.total - 1) + 1):
            self._tell(second, boxes, least)
        self.next = max(self.next, int(spent) + 1)

    def end(self, result: Bounded) -> None:
        self._tell(self.total, result.boxes, result.least)

    def _tell(self, second: int, boxes: int, least: float) -> None:
        if self.listener is not None:
            self.listener(
                Progress("proof", "second", second, self.total, f"{boxes} boxes, gap {self.reached - least:.3g}")
            )


def check(sampling: Sampling) -> None:
    """Raises InputError where the objective is not one of samples."""
    if sampling == "refined":
        raise InputError("--prove is not allowed with refined samples: it proves the optimum of a number of samples")


def with_proof(found: Optimisation, seconds: float = SECONDS, progress: Listener | None = None) -> Optimisation:
    """The same with the proof of its optimum, in so many seconds. Raises InputError for refined samples."""
    sampling = found.found.sampling
    check(sampling)
    device = found.devices[found.result.model]
    design, objective = found.found.design, found.found.objective
    bounding = Objective(device, int(sampling))
    reached = bounding(design, design).reached
    clock = _Clock(reached, seconds, progress)
    search = Search(bounding, *bounding.searched(design), bounding.floor)
    result = search.run(reached - GOAL * abs(objective), seconds, clock)
    clock.end(result)
    gap = reached - result.least
    done = gap <= GOAL * abs(objective)
    proof = GlobalBound(
        objective=objective, lower_bound=result.least, gap=gap, boxes=result.boxes, seconds=result.seconds, proved=done,
        statement=_statement(result, objective, gap, done, bool(found.found.requirements)),
    )  # fmt: skip
    return replace(found, result=replace(found.result, proof=proof))


def _statement(result: Bounded, objective: float, gap: float, done: bool, required: bool) -> str:
    which = "no design of the box, requirements kept or not," if required else "no design of the box"
    said = f"{which} is better than {objective:.9g} by more than {gap:.2g}"
    if done:
        return f"proved: {said}"
    if result.met < objective * (1 - GOAL):
        said += f"; a design was met that is better: {result.met:.9g}"
    return f"not proved to {GOAL:g} of the objective in {result.seconds:.0f} s: {said}"


class Objective:
    """Objective (31) of a device over N samples, bounded over boxes of designs [lower, upper] (p,)."""

    def __init__(self, device: Device, count: int) -> None:
        self.device, self.count = device, count
        self.force, self.weights = EnclosedForce(device), weights(device.machine)

    def __call__(self, lower: Array, upper: Array) -> Bounds:
        force = samples(self.force, Space(lower, upper), self.count)
        return bounds(force, self.weights.weight_range, self._spread)

    @property
    def floor(self) -> float:
        """What no objective is below: neither range nor variance is negative."""
        return 0.0 if min(self.weights.weight_range, self.weights.weight_variance) >= 0 else -np.inf

    def searched(self, design: Array) -> tuple[Array, Array]:
        """The device's box, parameters without effect held at their value in `design` (p,)."""
        gone = np.isin(self.device.names, self.force.without)
        return np.where(gone, design, self.device.lower), np.where(gone, design, self.device.upper)

    def _spread(self, variance: Jet) -> Jet:
        spread = variance if self.weights.kind == "paper" else variance.sqrt()
        return spread * self.weights.weight_variance
