"""Latin hypercubes: each slice of every axis has one point, and the numbers are SciPy's."""

import numpy as np
import pytest
from scipy.stats import qmc

from planter.numerics.latin_hypercube import draw_latin_hypercube


@pytest.mark.parametrize(("rows", "size"), [(1, 1), (7, 3), (100, 10)])
def test_points_are_those_of_scipy(rows: int, size: int) -> None:
    points = draw_latin_hypercube(rows, size, np.random.default_rng(3))
    np.testing.assert_array_equal(
        points, qmc.LatinHypercube(size, rng=np.random.default_rng(3)).random(rows)
    )


def test_every_slice_of_every_axis_has_one_point() -> None:
    points = draw_latin_hypercube(50, 4, np.random.default_rng(0))
    slices = np.sort(np.floor(points * 50), axis=0)
    np.testing.assert_array_equal(slices, np.tile(np.arange(50.0)[:, None], 4))
