"""Carrier angles for what jumps often in a turn: integrals between the jumps, extremes on both sides of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.numerics import piecewise

NODES = 3
"""Nodes of a panel between neighbouring jumps."""
LONGEST = np.radians(2)
"""Longer panels are cut."""
ASIDE = 1e-8
"""How far from a jump its sides are looked at [rad]; jumps closer than ten times that are one."""


@dataclass(frozen=True)
class Angles:
    """Carrier angles (n,) [rad] of a turn, its second half as its first, with weights of means over the turn."""

    phi: Array
    weights: Array

    @classmethod
    def between(cls, jumps: Array) -> Angles:
        """Between jumps (m,) of either of two sides that are half a turn apart."""
        folded = np.unique(np.mod(jumps, np.pi))
        apart = folded[np.diff(folded, append=folded[0] + np.pi) > 10 * ASIDE]
        ends = np.append(apart, apart[0] + np.pi)
        pieces = np.ceil(np.diff(ends) / LONGEST).astype(int)
        inner = [np.linspace(a, b, k, endpoint=False) for a, b, k in zip(ends[:-1], ends[1:], pieces, strict=True)]
        cut = np.append(np.concatenate(inner), ends[-1])
        nodes, weights = piecewise.gauss_panels(cut, NODES)
        sides = cut[:-1, None] + ASIDE, cut[1:, None] - ASIDE
        half, none = np.hstack([sides[0], nodes, sides[1]]).ravel(), np.zeros((len(nodes), 1))
        own = np.hstack([none, weights, none]).ravel()
        return cls(np.concatenate([half, half + np.pi]), np.tile(own, 2) / (2 * np.pi))

    def mean(self, values: Array) -> float:
        return float(self.weights @ values)
