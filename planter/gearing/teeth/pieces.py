"""Pieces of an outline as rows: which line of which tooth, and the arc lengths at which its ends are cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.gearing.teeth.curve import PitchCurve
from planter.gearing.teeth.flanks import smooth_parts
from planter.gearing.teeth.outline import Kind
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

KINDS: tuple[Kind, ...] = ("fillet", "flank", "tip", "root")
_NO_LENGTH = 1e-12
"""Share of a pitch curve's length below which a piece is none."""


@dataclass(frozen=True)
class Pieces:
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

    def of(self, which: Integers | Flags) -> Pieces:
        return Pieces(*(rows[which] for rows in vars(self).values()))


def at_joints(curve: PitchCurve, whole: Pieces) -> Pieces:
    """Pieces cut where the curvature of the pitch curve jumps, each part in the outline's direction."""
    backwards = whole.end < whole.start
    low, high = np.minimum(whole.start, whole.end), np.maximum(whole.start, whole.end)
    which, starts, ends = smooth_parts(curve, low, high)
    order = np.lexsort((np.where(backwards[which], -starts, starts), which))
    which, starts, ends = which[order], starts[order], ends[order]
    turned = backwards[which]
    parts = whole.of(which)
    return Pieces(
        parts.kind, parts.flank, parts.tooth, parts.side, np.where(turned, ends, starts), np.where(turned, starts, ends)
    )


def without_nothing(pieces: Pieces, length: float) -> Pieces:
    """The pieces that have a length: a rack with a full round leaves no root."""
    return pieces.of(np.abs(pieces.end - pieces.start) > _NO_LENGTH * length)
