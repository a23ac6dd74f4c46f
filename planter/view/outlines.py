"""Lines with no more points than a drawing shows."""

from __future__ import annotations

import numpy as np
import shapely

from planter.kernels import Array


def thinned(points: Array, within: float) -> Array:
    """Those points of a closed line (k, 2) whose chords stay within a distance of the line.

    >>> thinned(np.array([[0.0, 0.0], [1.0, 0.001], [2.0, 0.0], [1.0, 2.0]]), 0.01).tolist()
    [[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]]
    """
    ring = shapely.simplify(shapely.linearrings(points), within, preserve_topology=False)
    return np.asarray(shapely.get_coordinates(ring)[:-1])
