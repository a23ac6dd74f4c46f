"""Many small systems of equations at once: Newton's method from starts that are near."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array

System = Callable[[Array], tuple[Array, Array]]
"""Unknowns (k, n) -> what must vanish (k, n), and its Jacobian (k, k, n): a row for each equation."""

MOST_STEPS = 40
SMALL = 1e-9
"""A step below this share of its unknown's largest is the last but one."""
FLAT = 1e-6
"""Steps below this share that no longer shrink are rounding of the system."""


class NotFoundError(ComputationError):
    """The first of some systems that was not solved."""

    def __init__(self, index: int) -> None:
        super().__init__(f"the {index + 1}. of a number of systems of equations was not solved in {MOST_STEPS} steps")
        self.index = index


def newton(system: System, start: Array, largest: Array, rounding: float = 0.0) -> Array:
    """Unknowns (k, n) that solve n systems of k equations; no step is longer than `largest` (k,).

    What vanishes to `rounding` is solved, however badly it determines its unknowns.

    Raises NotFoundError, with its index, for the first system that is not solved to rounding.
    """
    at, last, done = start.copy(), np.full(start.shape[1], np.inf), np.zeros(start.shape[1], dtype=bool)
    for _ in range(MOST_STEPS):
        value, slopes = system(at)
        done |= (np.abs(value) <= rounding).all(axis=0)
        step = -_solved(slopes.transpose(2, 0, 1), value.T)
        size = (np.abs(step) / largest[:, None]).max(axis=0)
        at = np.where(done, at, at + step / np.maximum(size, 1.0))
        done |= (last < SMALL) | ((size >= last) & (size < FLAT))
        if done.all():
            return at
        last = size
    raise NotFoundError(int(np.argmin(done)))


def _solved(matrices: Array, right: Array) -> Array:
    """Solutions (k, n) of n linear systems. Raises NotFoundError for the first that determines nothing."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0].T)
    except np.linalg.LinAlgError:
        raise NotFoundError(int(np.argmin(np.abs(np.linalg.det(matrices))))) from None
