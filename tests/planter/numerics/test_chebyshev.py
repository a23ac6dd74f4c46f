"""Functions on panels: values, integrals, slopes to rounding, also beside breaks; what is rough is halved."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.numerics.chebyshev import NODES, Panels

BREAKS = np.array([0.0, 0.7, 3.0])


def jumping(x: Array) -> Array:
    """Smooth but for x = 0.7, where the first of both jumps."""
    return np.array([np.where(x < 0.7, np.sin(x), 2 + np.cos(3 * x)), np.exp(x)])


def test_values_integrals_and_slopes_are_right_to_rounding() -> None:
    found = Panels.of(jumping, BREAKS)
    x = np.linspace(0.01, 2.99, 400)
    np.testing.assert_allclose(found(x), jumping(x), atol=3e-14)
    np.testing.assert_allclose(found.integral(x)[1], np.exp(x) - 1, atol=1e-13)
    np.testing.assert_allclose(found.slope(x)[1], np.exp(x), atol=1e-11)
    step = 1 - np.cos(0.7) + 2 * (x - 0.7) + (np.sin(3 * x) - np.sin(2.1)) / 3
    np.testing.assert_allclose(found.integral(x)[0], np.where(x < 0.7, 1 - np.cos(x), step), atol=1e-14)


def test_either_side_of_a_break_is_told_by_its_panel() -> None:
    found = Panels.of(jumping, BREAKS)
    last = found.panel(np.array([0.7]))
    before, after = found(np.array([0.7]), last - 1)[0, 0], found(np.array([0.7]), last)[0, 0]
    np.testing.assert_allclose([before, after], [np.sin(0.7), 2 + np.cos(2.1)], atol=1e-14)


def test_what_is_rough_is_halved_where_it_is() -> None:
    found = Panels.of(lambda x: 1 / (1 + 400 * (x[None] - 1) ** 2), np.array([0.0, 3.0]))
    widths = np.diff(found.ends)
    assert widths.min() < 0.1 < 0.3 < widths.max()
    assert found.series.shape[2] == NODES
    x = np.linspace(0, 3, 999)
    np.testing.assert_allclose(found(x)[0], 1 / (1 + 400 * (x - 1) ** 2), atol=1e-13)
