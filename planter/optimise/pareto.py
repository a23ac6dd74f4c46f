"""Range against variance: the designs of which neither can be made smaller without the other growing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.device import Device
from planter.kernels import Array
from planter.optimise.descent import descend
from planter.optimise.objective import Evaluation, Objective
from planter.optimise.problem import Problem, Sampling
from planter.optimise.response import Planting, Response


@dataclass(frozen=True)
class Compromise:
    """An optimum for `share` of the weight on the range, the rest on the variance; `design` x (p,) in SI."""

    share: float
    design: Array
    evaluation: Evaluation


def front(device: Device, samples: Sampling | None = None, points: int = 15) -> list[Compromise]:
    """The Pareto front of a device, from least variance to least range; see `sweep`."""
    return sweep(Planting(device), device.machine.objective.samples if samples is None else samples, points)


def sweep(response: Response, sampling: Sampling, points: int = 15) -> list[Compromise]:
    """Optima of share * range + (1 - share) * variance, both in parts of the response's own design's.

    Each starts from the one before. A weighted sum finds the convex part of a front only. Compromises that another one
    beats in both are left out.
    """
    start = Problem(response, Objective(1.0, 0.0, "paper"), sampling)
    range_N, variance = start.reference.range_N, start.reference.variance_N2
    found, u = [], start.start
    for share in np.linspace(0.0, 1.0, points):
        problem = Problem(response, Objective(share / range_N, (1 - share) / variance, "paper"), sampling)
        minimum = descend(problem, u)
        u = minimum.u
        found.append(Compromise(float(share), problem.design(u), minimum.evaluation))
    return [one for one in found if not any(_beats(other.evaluation, one.evaluation) for other in found)]


def _beats(one: Evaluation, other: Evaluation) -> bool:
    not_worse = one.range_N <= other.range_N and one.variance_N2 <= other.variance_N2
    return not_worse and (one.range_N < other.range_N or one.variance_N2 < other.variance_N2)
