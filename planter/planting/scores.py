"""A design's support force over a cycle, in numbers: true extremes and integrals, or those of samples."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.optimise.joints import ASIDE
from planter.optimise.refined import Panels, Refined
from planter.optimise.samples import Samples
from planter.planting.model import Device
from planter.planting.objective import weights
from planter.planting.results.optimised import SampledScore
from planter.planting.results.simulated import TrueExtremes

DENSE = np.linspace(0, 2 * np.pi, 721)
"""Carrier angles of a figure's curves [rad]."""


def true_extremes(device: Device, x: Array) -> TrueExtremes:
    """True extremes and integrals of the support force of a design x (p,) [SI], and the objective of these."""
    found = Refined(device.force).look(x)
    objective = weights(device.machine).value(found.range, found.variance)
    return TrueExtremes(found.high, found.low, found.range, found.variance, objective)


def sampled_score(device: Device, x: Array) -> SampledScore:
    """The objective of a design x (p,) [SI] over the machine file's samples, and what it is made of."""
    samples = device.machine.objective.samples
    found = Samples(device.force, samples).look(x)
    return SampledScore(
        samples, weights(device.machine).value(found.range, found.variance), found.range, found.variance
    )


def curve_angles(device: Device, x: Array) -> Array:
    """Carrier angles (n,) [rad] of a figure of a design x (p,) [SI]: its largest and least force are the true ones.

    Beside `DENSE` they hold the extremes of the support force, and both sides of where it may jump.
    """
    response = device.force
    panels = Panels(response, x)
    ends = np.concatenate([panels.extremes.angles, panels.breaks - ASIDE, panels.breaks + ASIDE])
    cycles = round(2 * np.pi / response.period)
    every = np.add.outer(response.period * np.arange(cycles), np.mod(ends, response.period)).ravel()
    return np.union1d(DENSE, every)
