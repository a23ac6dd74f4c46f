"""The objective (31) of Wang et al. (2017) over a cycle: over true extremes, and over samples."""

from __future__ import annotations

import numpy as np

from planter.engine.goal import Goal
from planter.engine.problem import DesignProblem
from planter.engine.solvers.constraints import Constraints
from planter.engine.solvers.curve_sum import CurveSide, Sampling
from planter.engine.solvers.cycle_panels import CyclePanels
from planter.engine.solvers.response import ONE_SIDED_OFFSET
from planter.kernels import Array
from planter.numerics.statistics import Statistic
from planter.papers.planting.model import Device
from planter.papers.planting.results import SampledScore, TrueExtremes


def build_problem(
    device: Device, sampling: Sampling = "refined", *constraints: Constraints | None
) -> DesignProblem:
    """Return the problem of the sum of measures in the machine file, over true extremes and
    integrals, or that many samples, under what constraints there are.

    Parameters are searched in shares of the machine file's bounds.
    """
    machine = device.force.machine
    terms = [measure for measure in machine.objective if measure.weight]
    goal = Goal(machine, terms, (), None if sampling == "refined" else sampling)
    return DesignProblem(goal, sampling, [part for part in constraints if part is not None])


DENSE = np.linspace(0, 2 * np.pi, 721)
"""Carrier angles of a figure's curves [rad]."""


def evaluate_true_extremes(device: Device, x: Array) -> TrueExtremes:
    """True extremes and integrals of the support force of a design x (p,) [SI], and the objective
    of these.
    """
    panels = CyclePanels(device.force, x)
    high, low = (sign * panels.top(CurveSide(0, 0, sign)) for sign in (1, -1))
    mean = Statistic("mean", panels.values[0], panels.shares).value
    variance = Statistic("variance", panels.values[0], panels.shares).value
    objective = device.machine.objective.value(high - low, variance)
    return TrueExtremes(high, low, high - low, mean, variance, objective)


def evaluate_samples(device: Device, x: Array, samples: int | None = None) -> SampledScore:
    """Return the objective of a design x (p,) [SI] over samples, those of the machine file if None,
    and its parts.
    """
    count = samples or device.machine.objective.samples
    force = device.support(device.prologue(x), device.force.machine.list_angles(count))
    span, variance = float(np.ptp(force)), float(force.var())
    objective = device.machine.objective.value(span, variance)
    return SampledScore(count, objective, span, variance)


def find_curve_angles(device: Device, x: Array) -> Array:
    """Carrier angles (n,) [rad] of a figure of a design x (p,) [SI]: its largest and least force
    are the true ones.

    Beside `DENSE` they hold the extremes of the support force, and both sides of where it may jump.
    """
    period, panels = device.force.period, CyclePanels(device.force, x)
    extremes = panels.extremes(CurveSide(0, 0, 1)).angles
    sides = np.add.outer([-ONE_SIDED_OFFSET, ONE_SIDED_OFFSET], panels.breaks)
    ends = np.mod(np.append(extremes, sides), period)
    cycles = period * np.arange(round(2 * np.pi / period))
    return np.union1d(DENSE, np.add.outer(cycles, ends))
