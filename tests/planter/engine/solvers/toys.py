"""Toy responses with known optima, and the built-in machine with a short genetic search."""

from functools import cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pytest

from planter.engine.curves import QuantityCurves
from planter.engine.solvers.constraints import Constraints, DesignBox
from planter.engine.solvers.continuous_cycle import ContinuousCycle
from planter.engine.solvers.curve_sum import CurveSide, CurveStatistic, CurveSum, Sampling
from planter.engine.solvers.cycle_panels import PanelCache
from planter.engine.solvers.joined import JoinedObjective
from planter.engine.solvers.objective import ObjectiveSummary
from planter.engine.solvers.problem import Problem
from planter.engine.solvers.response import BreakpointEvent, CycleResponse
from planter.engine.solvers.sampled_cycle import SampledCycle
from planter.kernels import Array
from planter.numerics.statistics import StatisticKind
from planter.papers.planting.file import load
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device
from tests.planter.engine.solvers.toy import Toy


class Weights(NamedTuple):
    """Weights of range and scatter; the scatter is the variance for kind "paper", else the standard
    deviation.
    """

    weight_range: float
    weight_variance: float
    kind: str


RANGE, VARIANCE, PAPER = (
    Weights(1.0, 0.0, "paper"),
    Weights(0.0, 1.0, "paper"),
    Weights(0.6, 0.4, "paper"),
)


def build_range_sum(weights: Weights) -> CurveSum:
    """Return the weighted range and scatter of one curve."""
    kind: StatisticKind = "variance" if weights.kind == "paper" else "std"
    sides = (CurveSide(0, 0, 1), CurveSide(1, 0, -1))
    scatter = CurveStatistic(kind, 0, weights.weight_variance)
    return CurveSum((scatter,), sides, np.full(2, weights.weight_range))


SUM = build_range_sum(PAPER)
CORNER = BreakpointEvent("corner", 1, 2 * np.pi)


def over_turn(
    response: CycleResponse,
    weights: Weights,
    sampling: Sampling,
    constraints: Constraints | None = None,
) -> Problem:
    """Return the problem of least weighted range and scatter, in shares of the bounds."""
    box = DesignBox.shares(response.names, response.lower, response.upper, response.design)
    total, widths = build_range_sum(weights), response.upper - response.lower
    part = (
        ContinuousCycle(PanelCache(response), total)
        if sampling == "refined"
        else SampledCycle(response, total, sampling)
    )
    objective = JoinedObjective([part], response.names, widths, response.design)
    return Problem(objective, box, constraints)


def find_range(summary: ObjectiveSummary) -> float:
    """Return the range of the curve: its greatest value, and minus its least, are the rows."""
    return float(summary.tops.sum())


def third_harmonic() -> Toy:
    """cos phi + x cos 3 phi: least range sqrt 3 at x = -1/6, with peaks tied at +-30 deg and at 180
    +- 30 deg.
    """
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 1)
    return Toy(phi, x, ca.cos(phi) + x * ca.cos(3 * phi), lower=[-0.5], upper=[0.4])


def linear(seed: int, size: int = 3) -> tuple[Toy, Array, Array]:
    """A force that is linear in x, a0(phi) + a(phi) x, with random harmonics; and these, (7,) and
    (7, p).
    """
    rng = np.random.default_rng(seed)
    constant, slopes = rng.normal(size=7), rng.normal(size=(7, size))
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", size)
    waves = ca.vertcat(*(f(k * phi) for k in (1, 2, 3) for f in (ca.cos, ca.sin)), ca.cos(4 * phi))
    toy = Toy(
        phi, x, ca.dot(waves, constant + slopes @ x), lower=-np.ones(size), upper=np.ones(size)
    )
    return toy, constant, slopes


def waves(phi: Array) -> Array:
    """The harmonics of `linear` at angles, (n, 7)."""
    return np.stack(
        [f(k * phi) for k in (1, 2, 3) for f in (np.cos, np.sin)] + [np.cos(4 * phi)], axis=1
    )


def corner(height: float = 1.0, lower: float = -0.6, upper: float = 0.7) -> Toy:
    """A hill, 3 cos phi, with a corner, height |sin((phi - x) / 2)|, that moves with x."""
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 1)
    turned = (phi - x) / 2
    wrapped = turned - np.pi * ca.floor(turned / np.pi)
    force = 3 * ca.cos(phi) + height * ca.sin(wrapped)
    return Toy(phi, x, force, {CORNER: phi - x}, [lower], [upper])


def bent() -> Toy:
    """Two parameters, a corner whose place depends on both, not linearly, and a side peak that can
    tie with it.
    """
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 2)
    place = 1.0 + 0.3 * x[0] + 0.2 * x[0] * x[1] + 0.1 * x[1] ** 2
    turned = (phi - place) / 2
    wrapped = turned - np.pi * ca.floor(turned / np.pi)
    smooth = ca.cos(2 * phi + x[1]) * (1 + 0.4 * x[0] ** 2) + 0.3 * ca.sin(phi - x[0])
    return Toy(phi, x, smooth - (1.6 + x[1] * x[0]) * ca.sin(wrapped), {CORNER: phi - place})


def planting(model: Model = "exact") -> QuantityCurves:
    """The support force of the built-in machine."""
    return device(model).force


def device(model: Model = "exact") -> Device:
    """The built-in machine; made once."""
    return _device(model)


@cache
def _device(model: Model) -> Device:
    short = {"genetic_algorithm.generations": 6, "genetic_algorithm.individuals": 10}
    return Device(load("wang2017", short), model)


def problem(sampling: Sampling = 360, weights: Weights = PAPER, model: Model = "exact") -> Problem:
    return over_turn(planting(model), weights, sampling)


def difference(function, x: Array, step: Array | float) -> Array:  # type: ignore[no-untyped-def]
    """Central differences of a function of x (p,): the last axis is the coordinate."""
    steps = np.eye(len(x)) * step
    h = np.diag(steps)
    return np.stack(
        [(function(x + s) - function(x - s)) / (2 * k) for s, k in zip(steps, h, strict=True)],
        axis=-1,
    )


def check_derivatives(
    rows: Any,
    x: Array,
    weights: Array,
    width: Array,
    step: float = 1e-5,
    tolerances: tuple[float, float] = (1e-7, 1e-6),
) -> None:
    """Compare gradient and Hessian of weighted `values` (k,) with central differences over steps, in
    shares of a width (p,).
    """

    def weigh_slopes(y: Array) -> Array:
        return weights @ rows.slopes(y)

    gradient = weigh_slopes(x) * width
    first = difference(lambda y: weights @ rows.values(y), x, step * width) * width
    assert gradient == pytest.approx(first, abs=tolerances[0] * np.abs(gradient).max())
    second = difference(weigh_slopes, x, step * width) * np.outer(width, width)
    bent = rows.curvature(x, weights) * np.outer(width, width)
    assert bent == pytest.approx(second, abs=tolerances[1] * np.abs(second).max())
