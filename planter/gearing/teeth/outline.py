"""Toothed outlines: exact pieces, each ending where the next begins, and their rows of arc lengths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from planter.gearing.teeth.curve import PitchCurve
from planter.gearing.teeth.flanks import split_at_breakpoints
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

Kind = Literal["tip", "flank", "fillet", "root", "wall", "convex arc", "concave arc", "topping"]
"""Kinds of pieces; the last four occur on incomplete gears only."""


class OutlinePiece(Protocol):
    """A smooth piece of an outline by a parameter s that runs from 0 to 1 in the outline's direction, anticlockwise.

    `tooth` is the number of the tooth; a root has that of the tooth before it. `side` is +1 on the flank that ends a
    tooth in the outline's direction and on its fillet, -1 on the one that begins it, 0 for tip and root.
    """

    @property
    def kind(self) -> Kind: ...

    @property
    def tooth(self) -> int: ...

    @property
    def side(self) -> int: ...

    def at(self, s: Array) -> Array:
        """Return points (n, 2) [m]."""

    def tangent(self, s: Array) -> Array:
        """Return unit tangents (n, 2) in the outline's direction."""

    def curvature(self, s: Array) -> Array:
        """Return signed curvature (n,) [1/m], positive where the outline bends to the left."""


@dataclass(frozen=True)
class ToothOutline:
    """The closed outline of a gear, in the frame of its axis: each piece ends where the next begins.

    `centre` is the gear's axis (0, 0) or where an assembly puts it [m]; `pitch` gives points (n, 2) [m] of the closed
    pitch curve, by a parameter (n,) that runs from 0 to 1.
    """

    name: str
    pieces: tuple[OutlinePiece, ...]
    centre: tuple[float, float]
    pitch: Callable[[Array], Array]


KINDS: tuple[Kind, ...] = ("fillet", "flank", "tip", "root")
_NO_LENGTH = 1e-12
"""Share of a pitch curve's length below which a piece is empty."""


@dataclass(frozen=True)
class OutlinePieces:
    """Pieces (n,) of an outline in its order: index into KINDS, number of the flank or -1, tooth, side, and the arc
    lengths of the pitch curve at which their start and end are cut."""

    kind: Integers
    flank: Integers
    tooth: Integers
    side: Integers
    start: Array
    end: Array

    @property
    def middle(self) -> Array:
        return (self.start + self.end) / 2

    def select(self, index: Integers | Flags) -> OutlinePieces:
        """Return the pieces of an index or mask."""
        return OutlinePieces(*(rows[index] for rows in vars(self).values()))


def split_at_joints(curve: PitchCurve, pieces: OutlinePieces) -> OutlinePieces:
    """Return pieces split where the curvature of the pitch curve jumps, each in the outline's direction."""
    backwards = pieces.end < pieces.start
    low, high = np.minimum(pieces.start, pieces.end), np.maximum(pieces.start, pieces.end)
    index, starts, ends = split_at_breakpoints(curve, low, high)
    order = np.lexsort((np.where(backwards[index], -starts, starts), index))
    index, starts, ends = index[order], starts[order], ends[order]
    reversed_ = backwards[index]
    parts = pieces.select(index)
    return OutlinePieces(
        parts.kind,
        parts.flank,
        parts.tooth,
        parts.side,
        np.where(reversed_, ends, starts),
        np.where(reversed_, starts, ends),
    )


def drop_empty(pieces: OutlinePieces, length: float) -> OutlinePieces:
    """Return the pieces that have a length; a rack with a full tip radius leaves no root."""
    return pieces.select(np.abs(pieces.end - pieces.start) > _NO_LENGTH * length)
