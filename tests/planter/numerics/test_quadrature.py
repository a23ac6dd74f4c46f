"""Gauss-Legendre panels."""

import numpy as np
import pytest

from planter.numerics import quadrature

ENDS = np.array([-1.0, -0.2, 0.1, 2.0])


@pytest.mark.parametrize("count", [2, 8])
def test_exact_to_the_degree_that_is_promised_and_no_further(count: int) -> None:
    nodes, weights = quadrature.panels(ENDS, count)
    assert nodes.shape == weights.shape == (3, count)
    assert ((nodes > ENDS[:-1, None]) & (nodes < ENDS[1:, None])).all()
    for degree, right in ((2 * count - 1, True), (2 * count, False)):
        expected = (ENDS[-1] ** (degree + 1) - ENDS[0] ** (degree + 1)) / (degree + 1)
        off = abs(float((weights * nodes**degree).sum()) / expected - 1)
        assert (off < 1e-13) == right
