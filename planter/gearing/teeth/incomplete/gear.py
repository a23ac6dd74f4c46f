"""A gear with teeth on part of its turn: what a rack cuts there, and the pieces that close its outline."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.gearing.teeth.curve import PitchCurve
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.gear import Piece as Cut
from planter.gearing.teeth.incomplete.segments import PitchLine
from planter.gearing.teeth.outline import Outline, Piece
from planter.gearing.teeth.pieces import KINDS, Pieces, at_joints, without_nothing
from planter.gearing.teeth.rack import Rack
from planter.kernels import Array

_TIP, _ROOT = KINDS.index("tip"), KINDS.index("root")
CHORDS = {"fillet": 16, "flank": 24, "tip": 4, "root": 4, "wall": 1, "convex arc": 1024, "concave arc": 512,
          "topping": 64}  # fmt: skip
"""Chords of each kind of piece."""


@dataclass(frozen=True)
class Row(Gear):
    """Teeth in a row along part of a pitch curve that does not close.

    They begin and end in the middle of a space, or, `halved`, in the middle of the first and of the last tooth's tip.
    """

    halved: bool = False

    @cached_property
    def pieces(self) -> Pieces:
        inner = np.array(list(self._ordered()))[:-1]
        rows = self._from_tip_to_tip(inner) if self.halved else self._from_space_to_space(inner)
        kind, flank, tooth, side = rows[:, :4].astype(int).T
        whole = Pieces(kind, flank, tooth, side, rows[:, 4], rows[:, 5])
        return without_nothing(at_joints(self.curve, whole), self.curve.length)

    def _from_space_to_space(self, inner: Array) -> Array:
        spaces, last = self.flanks.spaces, 2 * self.z - 1
        before = [_ROOT, -1, 0, 0, spaces[0], self.paths[0][-1].upper]
        after = [_ROOT, -1, self.z - 1, 0, self.paths[last][-1].upper, spaces[last]]
        return np.vstack([before, inner, after])

    def _from_tip_to_tip(self, inner: Array) -> Array:
        tips = np.flatnonzero(inner[:, 0] == _TIP)
        rows = inner[tips[0] : tips[-1] + 1].copy()
        rows[0, 4], rows[-1, 5] = self.flanks.centre[0], self.flanks.centre[-1]
        return rows

    def line(self) -> list[Piece]:
        """The pieces one after the other."""
        return [Cut(self, number) for number in range(len(self.pieces.kind))]


@dataclass(frozen=True)
class IncompleteGear:
    """A gear as it is made: its teeth as the rack cuts them, all pieces of its outline, and the pitch line that rolls.

    Its frame is that of its axis, anticlockwise.
    """

    row: Row
    pieces: tuple[Piece, ...]
    pitch_line: PitchLine

    @property
    def name(self) -> str:
        return self.row.name

    @property
    def z(self) -> int:
        return self.row.z

    @property
    def rack(self) -> Rack:
        return self.row.rack

    @property
    def curve(self) -> PitchCurve:
        return self.row.curve

    def outline(self, centre: tuple[float, float] = (0.0, 0.0)) -> Outline:
        return Outline(self.name, self.pieces, centre, self.pitch_line.at)

    @cached_property
    def points(self) -> Array:
        """Vertices (n, 2) [m] of the outline, in its order."""
        return np.vstack(list(_sampled(self.pieces)))

    @property
    def joins(self) -> float:
        """How far the end of a piece is from the start of the next, at most [m]."""
        ends = np.vstack([piece.at(np.ones(1)) for piece in self.pieces])
        starts = np.vstack([piece.at(np.zeros(1)) for piece in self.pieces])
        return float(np.hypot(*(ends - np.roll(starts, -1, axis=0)).T).max())


def _sampled(pieces: Sequence[Piece]) -> Iterator[Array]:
    for piece in pieces:
        chords = CHORDS[piece.kind]
        yield piece.at(np.arange(chords) / chords)
