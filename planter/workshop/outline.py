"""Outlines of exact pieces, each with point, tangent and curvature by a parameter, and tables of their points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planter.kernels import Array

_STEP = 1e-5
"""Step of the parameter for difference quotients of a closed curve."""


class Piece(Protocol):
    """A smooth piece of a curve, along a parameter s from 0 to 1 in the direction of the curve; `kind` names it.

    `at(s)` gives points (n, 2) [m], `tangent(s)` unit vectors (n, 2), `curvature(s)` (n,) [1/m], positive where the
    curve turns to the left.
    """

    @property
    def kind(self) -> str: ...
    def at(self, s: Array) -> Array: ...
    def tangent(self, s: Array) -> Array: ...
    def curvature(self, s: Array) -> Array: ...


@dataclass(frozen=True)
class ClosedCurve:
    """A closed smooth curve as a piece, defined by points (n, 2) [m] along s from 0 to 1 only."""

    kind: str
    places: Callable[[Array], Array]

    def at(self, s: Array) -> Array:
        return self.places(s % 1.0)

    def tangent(self, s: Array) -> Array:
        chord = self.at(s + _STEP) - self.at(s - _STEP)
        return chord / np.hypot(*chord.T)[:, None]

    def curvature(self, s: Array) -> Array:
        before, middle, after = (self.at(s + step) for step in (-_STEP, 0.0, _STEP))
        first, second = middle - before, after - middle
        turn = np.arctan2(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0], (first * second).sum(axis=1))
        return turn / ((np.hypot(*first.T) + np.hypot(*second.T)) / 2)


@dataclass(frozen=True)
class OutlinePoints:
    """Points (n, 2) [m] with outward normals (n, 2), arc lengths (n,) [m], curvatures (n,) [1/m], piece numbers "
    "(n,)."""

    length: Array
    place: Array
    normal: Array
    curvature: Array
    piece: Array

    def columns(self) -> dict[str, Array]:
        """Return the columns of a table by keys that end in their units."""
        return {
            "arc_length_mm": self.length * 1e3,
            "x_mm": self.place[:, 0] * 1e3,
            "y_mm": self.place[:, 1] * 1e3,
            "normal_x": self.normal[:, 0],
            "normal_y": self.normal[:, 1],
            "curvature_per_mm": self.curvature * 1e-3,
        }


def sample_outline(pieces: Sequence[Piece], steps: int) -> OutlinePoints:
    """Return points of consecutive pieces, anticlockwise, each in `steps` equal steps of its parameter, ends included.

    The length between two points is that of an arc along both tangents.
    """
    s = np.linspace(0.0, 1.0, steps + 1)
    places, tangents = np.array([piece.at(s) for piece in pieces]), np.array([piece.tangent(s) for piece in pieces])
    chords, (before, after) = np.diff(places, axis=1), (tangents[:, :-1], tangents[:, 1:])
    half = (
        np.arctan2(before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0], (before * after).sum(axis=-1)) / 2
    )
    lengths = np.hypot(chords[..., 0], chords[..., 1]) / np.sinc(half / np.pi)
    ends = np.cumsum(lengths.sum(axis=1))
    piece_length = np.hstack([np.zeros((len(pieces), 1)), np.cumsum(lengths, axis=1)])
    arc_length = piece_length + np.concatenate([[0.0], ends[:-1]])[:, None]
    normals = np.stack([tangents[..., 1], -tangents[..., 0]], axis=-1)
    curvature = np.array([piece.curvature(s) for piece in pieces])
    return OutlinePoints(
        arc_length.ravel(), places.reshape(-1, 2), normals.reshape(-1, 2), curvature.ravel(),
        np.repeat(np.arange(len(pieces)), steps + 1),
    )  # fmt: skip
