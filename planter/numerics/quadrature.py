"""Integrals of smooth pieces, by Gauss and Legendre."""

from __future__ import annotations

from functools import cache

import numpy as np

from planter.kernels import Array

_legendre = cache(np.polynomial.legendre.leggauss)


def panels(ends: Array, count: int) -> tuple[Array, Array]:
    """Nodes and weights (m, count) on the m panels between neighbouring ends (m + 1,), exact to degree 2 count - 1."""
    points, weights = _legendre(count)
    widths = np.diff(ends)[:, None]
    return ends[:-1, None] + widths * (points + 1) / 2, widths * weights / 2
