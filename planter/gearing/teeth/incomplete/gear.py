"""A gear with teeth on part of its turn: what a rack cuts there, and the pieces that close its outline."""

from __future__ import annotations

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
SAGITTA = 5e-4
"""How far the chords of an outline may be from it, in modules."""
_TRIED = 17
"""Places on a piece where its curvature is looked at."""


@dataclass(frozen=True)
class Row(Gear):
    """Teeth in a row along part of a pitch curve that does not close, between two of its arc lengths [m].

    What is beside them is root, or, `tipped`, tip: the first and the last tooth are that long.
    """

    low: float = 0.0
    high: float = 0.0
    tipped: bool = False

    @cached_property
    def pieces(self) -> Pieces:
        inner = np.array(list(self._ordered()))[:-1]
        rows = self._between_tips(inner) if self.tipped else self._between_roots(inner)
        kind, flank, tooth, side = rows[:, :4].astype(int).T
        whole = Pieces(kind, flank, tooth, side, rows[:, 4], rows[:, 5])
        return without_nothing(at_joints(self.curve, whole), self.curve.length)

    def _between_roots(self, inner: Array) -> Array:
        last = 2 * self.z - 1
        before = [_ROOT, -1, 0, 0, self.low, self.paths[0][-1].upper]
        after = [_ROOT, -1, self.z - 1, 0, self.paths[last][-1].upper, self.high]
        return np.vstack([before, inner, after])

    def _between_tips(self, inner: Array) -> Array:
        tips = np.flatnonzero(inner[:, 0] == _TIP)
        rows = inner[tips[0] : tips[-1] + 1].copy()
        rows[0, 4], rows[-1, 5] = self.low, self.high
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
        return np.vstack([piece.at(_shares(piece, self._sagitta)[:-1]) for piece in self.pieces])

    @cached_property
    def inside(self) -> Array:
        """Vertices (n, 2) [m] of a polygon that the outline encloses and touches: chords, and tangents where hollow."""
        return np.vstack([_inside(piece, self._sagitta) for piece in self.pieces])

    @property
    def _sagitta(self) -> float:
        """Distance of chords from the outline [m]."""
        return SAGITTA * self.rack.module

    @property
    def joins(self) -> float:
        """How far the end of a piece is from the start of the next, at most [m]."""
        ends = np.vstack([piece.at(np.ones(1)) for piece in self.pieces])
        starts = np.vstack([piece.at(np.zeros(1)) for piece in self.pieces])
        return float(np.hypot(*(ends - np.roll(starts, -1, axis=0)).T).max())


def _shares(piece: Piece, sagitta: float) -> Array:
    """Ends (n + 1,) of as many chords of a piece as stay within a distance of it [m]."""
    tried = np.linspace(0, 1, _TRIED)
    length = float(np.hypot(*np.diff(piece.at(tried), axis=0).T).sum())
    chords = length * np.sqrt(float(np.abs(piece.curvature(tried)).max()) / (8 * sagitta))
    return np.linspace(0, 1, 1 + max(1, int(np.ceil(chords))))


def _inside(piece: Piece, sagitta: float) -> Array:
    """A piece without its end as chords, and, where it is hollow, as tangents at the ends of what chords would be."""
    shares = _shares(piece, sagitta)
    points, tangents, bends = piece.at(shares), piece.tangent(shares), piece.curvature(shares)
    hollow = np.flatnonzero((bends[:-1] < 0) & (bends[1:] < 0))
    chord, start, end = (points[1:] - points[:-1])[hollow], tangents[hollow], tangents[hollow + 1]
    along = _cross(chord, end) / _cross(start, end)
    return np.asarray(np.insert(points[:-1], hollow + 1, points[hollow] + along[:, None] * start, axis=0))


def _cross(one: Array, other: Array) -> Array:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
