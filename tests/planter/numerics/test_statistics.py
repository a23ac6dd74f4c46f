"""Statistics of weighted values against numpy, and their derivatives against differences."""

import numpy as np
import pytest

from planter.numerics.statistics import REDUCTIONS, SMOOTH, Statistic, StatisticKind, reduce_samples

RNG = np.random.default_rng(4)
COUNT, SIZE = 7, 3


def quadratic(offset: float, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return value (n,), slope (n, p) and Hessian (n, p, p) of n quadratic functions at zero."""
    bent = share * RNG.normal(size=(COUNT, SIZE, SIZE))
    return (
        offset + RNG.random(COUNT),
        share * RNG.normal(size=(COUNT, SIZE)),
        bent + bent.transpose(0, 2, 1),
    )


VALUES, WEIGHTS = quadratic(5.0, 1.0), quadratic(1.0, 0.1)


def at(
    function: tuple[np.ndarray, np.ndarray, np.ndarray], x: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    value, slope, bent = function
    return value + slope @ x + 0.5 * np.einsum("kij,i,j->k", bent, x, x), slope + bent @ x


@pytest.mark.parametrize("kind", SMOOTH)
@pytest.mark.parametrize("moving", [True, False], ids=["moving weights", "equal weights"])
def test_derivatives_match_differences(kind: StatisticKind, moving: bool) -> None:
    def build(x: np.ndarray) -> tuple[Statistic, np.ndarray, np.ndarray | None]:
        (values, slopes), (weights, weight_slopes) = at(VALUES, x), at(WEIGHTS, x)
        if not moving:
            return Statistic(kind, values), slopes, None
        return Statistic(kind, values, weights), slopes, weight_slopes

    def gradient(x: np.ndarray) -> np.ndarray:
        statistic, slopes, weight_slopes = build(x)
        return statistic.gradient(slopes, weight_slopes)

    steps = 1e-5 * np.eye(SIZE)
    statistic, slopes, weight_slopes = build(np.zeros(SIZE))
    first = [(build(h)[0].value - build(-h)[0].value) / 2e-5 for h in steps]
    np.testing.assert_allclose(gradient(np.zeros(SIZE)), first, rtol=1e-7, atol=1e-8)
    second = [(gradient(h) - gradient(-h)) / 2e-5 for h in steps]
    hessian = statistic.curvature(slopes, weight_slopes) + np.einsum(
        "k,kij->ij", statistic.slope, VALUES[2]
    )
    if moving:
        hessian += np.einsum("k,kij->ij", statistic.weight_slope, WEIGHTS[2])
    np.testing.assert_allclose(hessian, second, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("kind", SMOOTH[:-1])
def test_equal_weights_match_reduction(kind: StatisticKind) -> None:
    samples = RNG.normal(2.0, 1e-3, size=(40, 3))
    columns = [Statistic(kind, column, np.full(40, 3.0)).value for column in samples.T]
    np.testing.assert_allclose(reduce_samples(kind, samples), columns, rtol=1e-12)


def test_range_reduces_along_first_axis() -> None:
    samples = RNG.normal(size=(9, 4))
    np.testing.assert_array_equal(
        reduce_samples("range", samples),
        reduce_samples("max", samples) - reduce_samples("min", samples),
    )
    assert set(REDUCTIONS) == {*SMOOTH[:-1], "max", "min", "range"}


def test_constant_has_zero_deviation_and_slope() -> None:
    statistic = Statistic("std", np.full(4, 7.0))
    assert statistic.value == 0
    assert not statistic.gradient(np.ones((4, 2))).any()
