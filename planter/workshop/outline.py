"""What an outline is: exact pieces, each with place, tangent and curvature along a parameter, that close a curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planter.kernels import Array

_STEP = 1e-5
"""Step of the parameter over which a traced curve's direction is told."""


class Piece(Protocol):
    """A smooth piece of a curve, along a parameter s from 0 to 1 in the direction of the curve; `kind` names it.

    `at(s)` gives places (n, 2) [m], `tangent(s)` unit vectors (n, 2), `curvature(s)` (n,) [1/m], positive where the
    curve turns to the left.
    """

    @property
    def kind(self) -> str: ...
    def at(self, s: Array) -> Array: ...
    def tangent(self, s: Array) -> Array: ...
    def curvature(self, s: Array) -> Array: ...


@dataclass(frozen=True)
class Traced:
    """A closed smooth curve as a piece, of which nothing but its places (n, 2) [m] along s from 0 to 1 is known."""

    kind: str
    places: Callable[[Array], Array]

    def at(self, s: Array) -> Array:
        return self.places(s % 1.0)

    def tangent(self, s: Array) -> Array:
        along = self.at(s + _STEP) - self.at(s - _STEP)
        return along / np.hypot(*along.T)[:, None]

    def curvature(self, s: Array) -> Array:
        before, here, after = (self.at(s + step) for step in (-_STEP, 0.0, _STEP))
        one, two = here - before, after - here
        turn = np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0], (one * two).sum(axis=1))
        return turn / ((np.hypot(*one.T) + np.hypot(*two.T)) / 2)
