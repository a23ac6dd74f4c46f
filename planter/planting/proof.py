"""`planter optimise --prove`: how much better than the best one known a design of the box can be at most.

The objective that is enclosed is that of samples. A search over true extremes ends at another design: the incumbent of
the proof is then the best design over the machine file's samples, which is searched from that optimum and other starts.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from planter.kernels import Array
from planter.optimise.proof.curve import samples
from planter.optimise.proof.jets import Jet, Space
from planter.optimise.proof.objective import Bounds, Extreme, bounds, variance
from planter.optimise.proof.search import Bounded, Search
from planter.planting import search as planting_search
from planter.planting.enclosed import EnclosedForce
from planter.planting.model import Device
from planter.planting.objective import weights
from planter.planting.optimisation import Optimisation
from planter.planting.results.optimised import GlobalBound
from planter.planting.search import Optimum
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


def with_proof(found: Optimisation, seconds: float = SECONDS, progress: Listener | None = None) -> Optimisation:
    """The same with the proof of the best design over samples, in so many seconds."""
    device, incumbent = found.devices[found.result.model], _incumbent(found, progress)
    design, objective = incumbent.design, incumbent.objective
    bounding = Objective(device, int(incumbent.sampling))
    reached = bounding(design, design).reached
    clock = _Clock(reached, seconds, progress)
    search = Search(bounding, *bounding.searched(design), bounding.floor)
    result = search.run(reached - GOAL * abs(objective), seconds, clock)
    clock.end(result)
    gap = reached - result.least
    done = gap <= GOAL * abs(objective)
    proof = GlobalBound(
        kind="sampled", samples=int(incumbent.sampling), design=device.named(design), objective=objective,
        lower_bound=result.least, gap=gap, boxes=result.boxes, seconds=result.seconds, proved=done,
        statement=_statement(result, incumbent, gap, done),
    )  # fmt: skip
    return replace(found, result=replace(found.result, proof=proof))


def _incumbent(found: Optimisation, progress: Listener | None) -> Optimum:
    """The optimum over samples: the one that was found, or the best that starts there and elsewhere lead to."""
    own = found.found
    if own.sampling != "refined":
        return own
    device = found.devices[found.result.model]
    samples = device.machine.objective.samples
    return planting_search.run(device, "ipopt", samples, own.seed, progress=progress, near=[own.design])


def _statement(result: Bounded, incumbent: Optimum, gap: float, done: bool) -> str:
    objective, over = incumbent.objective, f"over {incumbent.sampling} samples"
    which = "no design of the box, requirements kept or not," if incumbent.requirements else "no design of the box"
    said = f"{which} is better than {objective:.9g} {over} by more than {gap:.2g}"
    if result.met < objective * (1 - GOAL) and not done:
        said += f"; a design was met that is better: {result.met:.9g}"
    claim = "proved" if done else f"not proved to {GOAL:g} of the objective in {result.seconds:.0f} s"
    return f"{claim}: {said}; of true extremes nothing is proved"


class Objective:
    """Objective (31) of a device over N samples, bounded over boxes of designs [lower, upper] (p,)."""

    def __init__(self, device: Device, count: int) -> None:
        self.device, self.count = device, count
        self.force, self.weights = EnclosedForce(device), weights(device.machine)

    def __call__(self, lower: Array, upper: Array) -> Bounds:
        (force,) = samples(self.force, Space(lower, upper), self.count)
        weight = self.weights.weight_range
        extremes = [Extreme(force * factor, largest=weight >= 0) for factor in (weight, -weight)]
        return bounds(self._spread(variance(force)), extremes)

    @property
    def floor(self) -> float:
        """What no objective is below: neither range nor variance is negative."""
        return 0.0 if min(self.weights.weight_range, self.weights.weight_variance) >= 0 else -np.inf

    def searched(self, design: Array) -> tuple[Array, Array]:
        """The device's box, parameters without effect held at their value in `design` (p,)."""
        gone = np.isin(self.device.names, self.force.without)
        return np.where(gone, design, self.device.lower), np.where(gone, design, self.device.upper)

    def _spread(self, squared: Jet) -> Jet:
        spread = squared if self.weights.kind == "paper" else squared.sqrt()
        return spread * self.weights.weight_variance
