"""Simplification of outlines to the resolution of a drawing."""

from __future__ import annotations

import numpy as np
import shapely

from planter.kernels import Array


def simplify_outline(points: Array, tolerance: float) -> Array:
    """Return the points (m, 2) of a closed line (k, 2) whose chords deviate from it by at most a tolerance.

    >>> simplify_outline(np.array([[0.0, 0.0], [1.0, 0.001], [2.0, 0.0], [1.0, 2.0]]), 0.01).tolist()
    [[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]]
    """
    ring = shapely.simplify(shapely.linearrings(points), tolerance, preserve_topology=False)
    return np.asarray(shapely.get_coordinates(ring)[:-1])
