"""What a system states for the trial of a chain of equations as a whole: laws, motions, the derivation's own steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy import Expr

from ..equations import Claimed, Equation
from ..model import Let, Twin

Array = NDArray[np.float64]
Values = dict[sp.Symbol, Array]


@dataclass(frozen=True)
class Law:
    """``gaps`` vanish: at every angle (``largest``), on average, or in their integral over a turn.

    ``cycle`` names the motion in which it is tested. What is asked of the violation is asked of its share of ``scale``.
    """

    name: str
    unit: str
    gaps: tuple[Expr, ...]
    over: Literal["largest", "mean", "turn"] = "largest"
    cycle: str = "reference"
    scale: float = 1.0

    def violations(self, gaps: Sequence[Array], weights: Array) -> Array:
        """By how much the law is broken, from the gaps at every angle (last axis)."""
        if self.over == "largest":
            return np.max([np.max(np.abs(gap), axis=-1) for gap in gaps], axis=0)
        total = np.abs(sum(gap @ weights for gap in gaps))
        return total / weights.sum() if self.over == "mean" else total


@dataclass(frozen=True)
class Cycle:
    """A motion at some angles: what is known of each equal side, and the weights that integrate over a turn.

    ``between`` are more angles, interpolated, close enough to find the largest value of anything.
    """

    sides: tuple[Values, ...]
    weights: Array
    between: Cycle | None = None


@dataclass(frozen=True)
class Dynamics:
    """What a system states for the trial of a chain: its laws, its motions, and its derivation.

    ``claims`` are derived equations by what they claim to be; ``supplements`` the derivation's steps for unknowns of
    one side that a chain may lack but a derived equation may name; ``twins`` name a quantity on the second side, and on
    those after it.
    """

    laws: tuple[Law, ...]
    cycles: Mapping[str, Cycle]
    claims: Mapping[Claimed, Equation]
    supplements: tuple[Let, ...]
    twins: tuple[Twin, ...] = ()
