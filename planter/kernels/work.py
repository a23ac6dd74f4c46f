"""What is to be evaluated: a CasADi function over lanes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planter.kernels import loops, toolchain

Array = NDArray[np.float64]

LARGE = 10_000
"""Instructions from which a function is compiled with fewer passes."""


@dataclass(frozen=True)
class Work:
    """A function to be evaluated: `varying` inputs have a column for each lane; `summed` outputs are added up."""

    function: ca.Function
    varying: tuple[str, ...]
    summed: bool

    @property
    def size(self) -> int:
        return int(self.function.n_instructions())

    @cached_property
    def loop(self) -> str:
        """The function as a loop over lanes. Raises lanes.NotPrintable for one that has no such form."""
        return loops.file([loops.Graph.of(self.function, self.varying)], [self.summed])

    @property
    def passes(self) -> tuple[str, ...]:
        return toolchain.SWIFT if self.size > LARGE else toolchain.OPTIMISED
