"""NumPy: the generator's array code, vectorised over angles; the gradient by forward differences."""

from __future__ import annotations

import numpy as np

from planter.bench.arrays import ArrayCode
from planter.bench.case import EXACT, Absent, Case, Contender
from planter.kernels import Array

STEP = 1e-6
"""Step of a difference, as a share of the box."""
DIFFERENCES = 1e-4
"""What a gradient by differences is allowed to be off, relative to its largest entry."""
CHUNK = 16
"""Designs in one array: what the caches hold."""
BUILT = "generated array code, one array over the angles"


def contender(case: Case, work: str) -> Contender:
    if work == "cycle":
        return Contender(Plain(case).value, BUILT)
    if work == "cycle+gradient":
        return Contender(Plain(case).gradient, f"{BUILT}; forward differences", (EXACT, DIFFERENCES))
    if work == "batch":
        return Contender(Plain(case).values, f"generated array code, arrays over the angles of {CHUNK} designs")
    raise Absent("second differences agree with nothing to 1e-10")


def together(case: Case, work: str) -> Contender:
    """All designs of a difference in one array: fewer calls of NumPy, larger arrays."""
    if work != "cycle+gradient":
        raise Absent("only a gradient has differences")
    built = "generated array code, one array over angles and steps; forward differences"
    return Contender(Plain(case).gradient_together, built, (EXACT, DIFFERENCES))


class Plain:
    """Objective and its differences in plain NumPy."""

    def __init__(self, case: Case) -> None:
        self.case, self.code = case, ArrayCode(case.device)
        self.steps = STEP * (case.device.upper - case.device.lower)

    def value(self, x: Array) -> float:
        h = self.case.hoisted(x)
        share = self.code.share(np, self.case.lanes, x, h, self.case.constants)
        return self.case.weighed(self.case.folded(share)).value

    def gradient(self, x: Array) -> tuple[float, Array]:
        value = self.value(x)
        moved = [self.value(x + step) for step in np.diag(self.steps)]
        return value, (np.array(moved) - value) / self.steps

    def gradient_together(self, x: Array) -> tuple[float, Array]:
        value, *moved = self._values(np.vstack([x, x + np.diag(self.steps)]))
        return float(value), (np.array(moved) - value) / self.steps

    def values(self, designs: Array) -> Array:
        """Objectives of designs (m, p)."""
        return np.concatenate([self._values(designs[i : i + CHUNK]) for i in range(0, len(designs), CHUNK)])

    def _values(self, designs: Array) -> Array:
        x, h = designs.T[:, :, None], self.case.prologues(designs)[:, :, None]
        share = self.code.share(np, self.case.lanes[None, :], x, h, self.case.constants)
        return np.array([self.case.weighed(force).value for force in self.case.folded(share)])
