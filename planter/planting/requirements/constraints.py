"""Requirements of a machine file as constraints of an optimisation."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import LastCallCache
from planter.optimise.constraints import Constraints
from planter.planting.model import Device
from planter.planting.requirements.limits import limits
from planter.planting.requirements.measures import Measures
from planter.planting.requirements.record import record
from planter.planting.results import Requirement


class Required(Constraints):
    """The rows of a device's requirements, margins included; designs x are (p,) in SI."""

    def __init__(self, device: Device) -> None:
        self.measures = Measures(device)
        self.limits = limits(self.measures)
        self.step = self.limits.step
        self.lower, self.upper = self.limits.lower / self.step, self.limits.upper / self.step
        self.kinds = self.measures.kinds
        names = [kind.name for kind in self.kinds]
        self.owner = np.array([names.index(row.kind.name) for row in self.measures.rows])
        self._slopes = LastCallCache(lambda x: self.measures.slopes(x) / self.step[:, None])

    @classmethod
    def of(cls, device: Device) -> Required | None:
        """Those of the machine file; None where it has none."""
        return None if device.machine.requirements is None else cls(device)

    def values(self, x: Array) -> Array:
        """The rows, in steps. Raises ComputationError where a design has none."""
        scaled: Array = self.measures.at(x).values / self.step
        return scaled

    def slopes(self, x: Array) -> Array:
        """Gradients of the rows, (k, p)."""
        return self._slopes(x)

    def curvature(self, x: Array, weights: Array) -> Array:
        """Weighted sum (p, p) of the rows' Hessians."""
        return self.measures.curvature(x, weights / self.step)

    def record(self, x: Array) -> list[Requirement]:
        """Every requirement at a design (p,), as results show it."""
        return record(self.measures, x)
