"""Latin hypercubes: SciPy's take a second of imports, more than most commands that draw one."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array


def draw_latin_hypercube(rows: int, size: int, generator: np.random.Generator) -> Array:
    """Return points (rows, size) in [0, 1): one in each of `rows` slices of every axis (McKay et
    al. 1979).

    The numbers are those of `scipy.stats.qmc.LatinHypercube` with the same generator, which draws
    from its child.
    """
    generator = generator.spawn(1)[0]
    offsets = generator.random((rows, size))
    slices = np.tile(np.arange(1, rows + 1), (size, 1))
    for axis in slices:
        generator.shuffle(axis)
    points: Array = (slices.T - offsets) / rows
    return points
