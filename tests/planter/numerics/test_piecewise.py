"""Piecewise functions with a kink and a jump against closed forms, Chebyshev series and
Gauss-Legendre panels.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.kernels import Array
from planter.numerics import piecewise
from planter.numerics.piecewise import CHEBYSHEV_NODES, ChebyshevPanels, PiecewiseFunctions

BREAKS = np.array([1.0, 4.0])
TURN = 2 * np.pi


def functions(phi: Array) -> tuple[Array, Array]:
    """A sine; a ramp of slope 2 that falls back by 6 at 4; a constant."""
    at = np.mod(phi, TURN)
    inside = (at >= 1) & (at < 4)
    ramp, zero = np.where(inside, 2 * (at - 1), 0.0), np.zeros_like(at)
    return (
        np.array([np.sin(at + 0.3), ramp, zero + 7]),
        np.array([np.cos(at + 0.3), np.where(inside, 2.0, 0.0), zero]),
    )


def rates(phi: Array) -> tuple[Array, Array]:
    zero = np.zeros_like(phi)
    return functions(phi)[1], np.array([-np.sin(phi + 0.3), zero, zero])


def test_extrema_include_values_of_both_sides() -> None:
    sine, ramp, level = PiecewiseFunctions(functions, BREAKS).extremes(np.array([0, 1, 2]), rates)
    assert sine[1].place == pytest.approx(np.pi / 2 - 0.3, abs=1e-12)
    assert [extremum.value for extremum in sine] == pytest.approx([-1, 1], abs=1e-15)
    assert (ramp[1].place, ramp[1].value) == pytest.approx((4.0, 6.0), abs=1e-14)
    assert ramp[0].value == 0
    assert level[0].value == level[1].value == 7


def test_integrals_and_jumps_match_closed_forms() -> None:
    pieces = PiecewiseFunctions(functions, BREAKS)
    assert pieces.mean == pytest.approx([0, 9 / TURN, 7], abs=1e-14)
    assert pieces.rms == pytest.approx([np.sqrt(0.5), np.sqrt(36 / TURN), 7], abs=1e-13)
    before, after = pieces.sides
    assert after - before == pytest.approx(np.array([[0, 0], [0, -6], [0, 0]]), abs=1e-14)


def test_missing_break_costs_panels_and_digits() -> None:
    """So that the test above can fail: panels are halved down to the kink that has no break."""
    blind, pieces = PiecewiseFunctions(functions, BREAKS[:1]), PiecewiseFunctions(functions, BREAKS)
    assert len(blind.nodes) > 1.5 * len(pieces.nodes)
    assert 1e-13 < abs(blind.mean[1] - 9 / TURN) < 1e-9


def test_functions_without_breaks() -> None:
    pieces = PiecewiseFunctions(functions, np.empty(0))
    assert pieces.sides[0].shape == (3, 0)
    assert pieces.extremes(np.array([0]), rates)[0][1].value == pytest.approx(1)


def test_coincident_breaks_are_merged() -> None:
    assert len(PiecewiseFunctions(functions, np.array([1.0, 1.0 + 1e-12, 4.0])).breaks) == 2


@pytest.mark.parametrize("noise", [1e-14, -1e-14])
def test_tied_peaks_select_first(noise: float) -> None:
    """A device whose second side repeats the first half a cycle later, each evaluated with its own
    rounding.
    """

    def repeated(phi: Array) -> tuple[Array, Array]:
        later = np.where(np.mod(phi, TURN) > np.pi, noise, 0.0)
        return (np.sin(2 * phi + 0.4) + later)[None], 2 * np.cos(2 * phi + 0.4)[None]

    def bends(phi: Array) -> tuple[Array, Array]:
        return repeated(phi)[1], -4 * np.sin(2 * phi + 0.4)[None]

    low, high = PiecewiseFunctions(repeated, np.empty(0)).extremes(np.array([0]), bends)[0]
    assert high.place == pytest.approx(np.pi / 4 - 0.2, abs=1e-7)
    assert low.place == pytest.approx(3 * np.pi / 4 - 0.2, abs=1e-7)
    assert high.value == pytest.approx(1 + max(noise, 0), abs=1e-15)


PANEL_ENDS = np.array([0.0, 0.7, 3.0])


def jumping(x: Array) -> Array:
    """Smooth but for x = 0.7, where the first of both jumps."""
    return np.array([np.where(x < 0.7, np.sin(x), 2 + np.cos(3 * x)), np.exp(x)])


def test_series_integral_slope_are_exact_to_rounding() -> None:
    result = ChebyshevPanels.fit(jumping, PANEL_ENDS)
    x = np.linspace(0.01, 2.99, 400)
    np.testing.assert_allclose(result(x), jumping(x), atol=3e-14)
    np.testing.assert_allclose(result.integral(x)[1], np.exp(x) - 1, atol=1e-13)
    np.testing.assert_allclose(result.slope(x)[1], np.exp(x), atol=1e-11)
    step = 1 - np.cos(0.7) + 2 * (x - 0.7) + (np.sin(3 * x) - np.sin(2.1)) / 3
    np.testing.assert_allclose(
        result.integral(x)[0], np.where(x < 0.7, 1 - np.cos(x), step), atol=1e-14
    )


def test_panel_index_selects_side_of_break() -> None:
    result = ChebyshevPanels.fit(jumping, PANEL_ENDS)
    last = result.panel(np.array([0.7]))
    before, after = result(np.array([0.7]), last - 1)[0, 0], result(np.array([0.7]), last)[0, 0]
    np.testing.assert_allclose([before, after], [np.sin(0.7), 2 + np.cos(2.1)], atol=1e-14)


def test_rough_panel_is_halved_locally() -> None:
    result = ChebyshevPanels.fit(lambda x: 1 / (1 + 400 * (x[None] - 1) ** 2), np.array([0.0, 3.0]))
    widths = np.diff(result.ends)
    assert widths.min() < 0.1 < 0.3 < widths.max()
    assert result.series.shape[2] == CHEBYSHEV_NODES
    x = np.linspace(0, 3, 999)
    np.testing.assert_allclose(result(x)[0], 1 / (1 + 400 * (x - 1) ** 2), atol=1e-13)


ENDS = np.array([-1.0, -0.2, 0.1, 2.0])


@pytest.mark.parametrize("count", [2, 8])
def test_gauss_panels_are_exact_to_stated_degree(count: int) -> None:
    nodes, weights = piecewise.gauss_panels(ENDS, count)
    assert nodes.shape == weights.shape == (3, count)
    assert ((nodes > ENDS[:-1, None]) & (nodes < ENDS[1:, None])).all()
    for degree, right in ((2 * count - 1, True), (2 * count, False)):
        expected = (ENDS[-1] ** (degree + 1) - ENDS[0] ** (degree + 1)) / (degree + 1)
        off = abs(float((weights * nodes**degree).sum()) / expected - 1)
        assert (off < 1e-13) == right


def test_rough_function_is_refused() -> None:
    with pytest.raises(piecewise.RoughFunctionError):
        ChebyshevPanels.fit(lambda t: np.sin(1e6 * t)[None], np.linspace(0, 1, 9))
