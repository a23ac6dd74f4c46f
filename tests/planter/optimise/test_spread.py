"""Weighted range and spread of samples: known values, derivatives against CasADi's, and tampered
ones seen.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from planter.kernels import Array
from planter.optimise.variance import Variance, WeightedSum, Weights

PAPER, NEWTON = Weights(0.75, 0.25, "paper"), Weights(2.0, 3.0, "newton")


def bowl(x: ca.MX, count: int = 12) -> ca.MX:
    """Samples that bend in three parameters."""
    t = np.linspace(0.1, 5.0, count)
    return (
        ca.sin(x[0] * t) * x[1]
        + x[2] ** 2 * ca.DM(t) / 4
        + ca.exp(x[0] * x[2] / 3) * ca.cos(ca.DM(t))
    )


def derivatives(function: ca.MX, x: ca.MX, at: Array) -> list[Array]:
    hessian, gradient = ca.hessian(function, x)
    return [np.array(value) for value in ca.Function("f", [x], [function, gradient, hessian])(at)]


def by_casadi(weights: Weights, x: ca.MX, at: Array) -> list[Array]:
    """Value, gradient and Hessian of the objective with the extremes held at their samples."""
    samples = bowl(x)
    values = np.array(ca.Function("own", [x], [samples])(at))[:, 0]
    deviations = samples - ca.sum1(samples) / samples.numel()
    spread = weights.weighted(ca.sumsqr(deviations) / samples.numel(), ca.sqrt)
    span = samples[int(values.argmax())] - samples[int(values.argmin())]
    return derivatives(weights.weight_range * span + spread, x, at)


def weighed(weights: Weights, x: ca.MX, at: Array) -> tuple[WeightedSum, Array, Array]:
    """The same by the one function, and the samples' slopes (n, p) and Hessians (n, p, p)."""
    samples = bowl(x)
    rows = [derivatives(samples[k], x, at) for k in range(samples.numel())]
    values, slopes, bent = (np.array(part) for part in zip(*rows, strict=True))
    return WeightedSum(weights, values.ravel()), slopes[:, :, 0], bent


@pytest.mark.parametrize("weights", [PAPER, NEWTON])
def test_value_gradient_and_hessian(weights: Weights) -> None:
    x, at = ca.MX.sym("x", 3), np.array([0.7, 1.3, -0.4])
    value, gradient, hessian = by_casadi(weights, x, at)
    spread, slopes, bent = weighed(weights, x, at)
    assert spread.value == pytest.approx(value.item(), rel=1e-14)
    assert spread.gradient(slopes) == pytest.approx(gradient[:, 0], rel=1e-12)
    assert spread.hessian(slopes, lambda each: np.tensordot(each, bent, 1)) == pytest.approx(
        hessian, rel=1e-11
    )


def test_a_missing_term_is_seen() -> None:
    """Without what the samples' slopes add, or without the mean's, the Hessian is another."""
    x, at = ca.MX.sym("x", 3), np.array([0.7, 1.3, -0.4])
    hessian = by_casadi(PAPER, x, at)[2]
    spread, slopes, bent = weighed(PAPER, x, at)
    curved = np.tensordot(spread.slope, bent, 1)
    uncentred = curved + 2 * PAPER.weight_variance / 12 * slopes.T @ slopes
    for wrong in (curved, uncentred):
        assert np.abs(wrong - hessian).max() > 0.01 * np.abs(hessian).max()


def test_shares_of_a_turn() -> None:
    """A value that holds for a third of the turn counts as three equal ones of nine."""
    few = Variance(np.array([1.0, 4.0, -2.0]), np.array([3, 4, 2]) / 9)
    many = Variance(np.repeat([1.0, 4.0, -2.0], [3, 4, 2]))
    slopes = np.array([[1.0, 0.5], [-2.0, 0.25], [3.0, 4.0]])
    repeated = np.repeat(slopes, [3, 4, 2], axis=0)
    assert few.value == pytest.approx(many.value, rel=1e-15)
    assert few.gradient(slopes) == pytest.approx(many.gradient(repeated), rel=1e-14)
    assert few.squared(slopes) == pytest.approx(many.squared(repeated), rel=1e-14)


def test_a_constant_curve_has_no_spread() -> None:
    for weights in (PAPER, NEWTON):
        assert WeightedSum(weights, np.full(5, 3.0)).value == pytest.approx(0.0, abs=1e-150)
