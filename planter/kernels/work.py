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
MOST_PRINTED = 20_000
"""Instructions of a loop over lanes at most: one of 84,000 takes a compiler half an hour, CasADi's own C a second."""


@dataclass(frozen=True)
class Work:
    """A function to be evaluated: `varying` inputs have a column for each lane; `summed` outputs are added up.

    With `few_passes` it is compiled as a large one is: in a third of the time, and a tenth slower afterwards.
    """

    function: ca.Function
    varying: tuple[str, ...]
    summed: bool
    few_passes: bool = False

    @property
    def size(self) -> int:
        return int(self.function.n_instructions())

    @cached_property
    def loop(self) -> str:
        """The function as a loop over lanes. Raises NotPrintable for one that has no such form, or is too large."""
        return loops.file([loops.Graph.of(self.function, self.varying, MOST_PRINTED)], [self.summed])

    @property
    def passes(self) -> tuple[str, ...]:
        return toolchain.SWIFT if self.few_passes or self.size > LARGE else toolchain.OPTIMISED
