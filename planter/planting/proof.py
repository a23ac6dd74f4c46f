"""`planter optimise --prove`: how much better than the best one known a design of the box can be at most.

The objective that is enclosed is that of samples. A search over true extremes ends at another design: the incumbent of
the proof is then the best design over the machine file's samples, which is searched from that optimum and other starts.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from planter.engine.proof import ProvableObjective
from planter.kernels import Array
from planter.optimise.proof.bound import SECONDS, Incumbent, prove_bound
from planter.optimise.proof.shared import share_boxes
from planter.parallel.task import AUTO, Means
from planter.planting import search as planting_search
from planter.planting.enclosed import EnclosedForce
from planter.planting.file import Machine
from planter.planting.functions import Model
from planter.planting.model import Device
from planter.planting.objective import build_measures
from planter.planting.optimisation import Optimisation
from planter.planting.search import Optimum
from planter.progress import Listener


def with_proof(
    found: Optimisation, seconds: float = SECONDS, progress: Listener | None = None, means: Means = AUTO
) -> Optimisation:
    """Return an optimum with the proof of the best design over samples, in so many seconds.

    `means` says what bounds the boxes: a proof that ends before its time is up does not depend on it.
    """
    device, optimum = found.devices[found.result.model], _incumbent(found, progress)
    build = partial(build_objective, device.machine, device.model, int(optimum.sampling))
    bounding = build()
    scope = "no design of the box, requirements kept or not," if optimum.requirements else "no design of the box"
    named = device.named(optimum.design)
    incumbent = Incumbent(optimum.design, named, optimum.objective, int(optimum.sampling), scope)
    box = bounding.searched(optimum.design)
    with share_boxes(bounding, build, means) as shared:
        proof = prove_bound(shared, box, incumbent, seconds, progress)
    return replace(found, result=replace(found.result, proof=proof))


def build_objective(machine: Machine, model: Model, count: int) -> Objective:
    """Return the objective of a machine over `count` samples as a proof bounds it."""
    return Objective(Device(machine, model), count)


def _incumbent(found: Optimisation, progress: Listener | None) -> Optimum:
    """The optimum over samples: the one that was found, or the best that starts there and elsewhere lead to."""
    own = found.found
    if own.sampling != "refined":
        return own
    device = found.devices[found.result.model]
    samples = device.machine.objective.samples
    return planting_search.run(device, "ipopt", samples, own.seed, progress=progress, near=[own.design])


class Objective(ProvableObjective):
    """Objective (31) of a device over N samples, bounded over boxes of designs [lower, upper] (p,)."""

    def __init__(self, device: Device, count: int) -> None:
        self.device, self.force = device, EnclosedForce(device)
        super().__init__(device.force.machine, build_measures(device.machine), count, lambda _: self.force)

    def searched(self, design: Array) -> tuple[Array, Array]:
        """The device's box, parameters without effect held at their value in `design` (p,)."""
        gone = np.isin(self.device.names, self.force.without)
        return np.where(gone, design, self.device.lower), np.where(gone, design, self.device.upper)
