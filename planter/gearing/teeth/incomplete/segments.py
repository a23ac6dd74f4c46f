"""Pieces of an outline that no rack cuts: arcs, straight walls, parts of other pieces, the pitch line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.gearing.teeth.curve import KAPPA, TX, TY, PitchCurve, X, Y
from planter.gearing.teeth.outline import Kind, Piece
from planter.kernels import Array


@dataclass(frozen=True)
class Arc:
    """An arc about a centre [m], from an angle on by a sweep [rad], which is negative clockwise."""

    kind: Kind
    tooth: int
    centre: Array
    radius: float
    start: float
    sweep: float
    side: int = 0

    def _spoke(self, s: Array) -> Array:
        angle = self.start + self.sweep * s
        return np.column_stack([np.cos(angle), np.sin(angle)])

    def at(self, s: Array) -> Array:
        return np.asarray(self.centre + self.radius * self._spoke(s))

    def tangent(self, s: Array) -> Array:
        return np.sign(self.sweep) * self._spoke(s)[:, ::-1] * [-1.0, 1.0]

    def curvature(self, s: Array) -> Array:
        return np.full(len(s), np.sign(self.sweep) / self.radius)


@dataclass(frozen=True)
class Wall:
    """A straight line from a point to another [m]."""

    tooth: int
    start: Array
    end: Array
    kind: Kind = "wall"
    side: int = 0

    def at(self, s: Array) -> Array:
        return np.asarray(self.start + np.outer(s, self.end - self.start))

    def tangent(self, s: Array) -> Array:
        along = (self.end - self.start) / np.hypot(*(self.end - self.start))
        return np.tile(along, (len(s), 1))

    def curvature(self, s: Array) -> Array:
        return np.zeros(len(s))


@dataclass(frozen=True)
class Part:
    """What of a piece lies between two of its parameters."""

    whole: Piece
    low: float
    high: float

    @property
    def kind(self) -> Kind:
        return self.whole.kind

    @property
    def tooth(self) -> int:
        return self.whole.tooth

    @property
    def side(self) -> int:
        return self.whole.side

    def _own(self, s: Array) -> Array:
        return self.low + (self.high - self.low) * s

    def at(self, s: Array) -> Array:
        return self.whole.at(self._own(s))

    def tangent(self, s: Array) -> Array:
        return self.whole.tangent(self._own(s))

    def curvature(self, s: Array) -> Array:
        return self.whole.curvature(self._own(s))


@dataclass(frozen=True)
class PitchLine:
    """The pitch curve between two of its arc lengths [m], as a piece."""

    curve: PitchCurve
    low: float
    high: float
    kind: str = "pitch curve"

    def _rows(self, s: Array) -> Array:
        return self.curve.at(self.low + (self.high - self.low) * s)

    def at(self, s: Array) -> Array:
        return self._rows(s)[[X, Y]].T

    def tangent(self, s: Array) -> Array:
        return self._rows(s)[[TX, TY]].T

    def curvature(self, s: Array) -> Array:
        return np.asarray(self._rows(s)[KAPPA])
