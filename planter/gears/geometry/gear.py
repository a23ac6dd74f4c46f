"""Gears: the exact outline that a rack cuts on a pitch curve, piece by piece, with its measures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.gears.geometry.flanks import (
    EMPTY_SHARE,
    Cut,
    FlankLine,
    Flanks,
    Rack,
    build_flank_lines,
    split_at_breakpoints,
)
from planter.gears.geometry.pieces import Piece
from planter.gears.geometry.pitch_curves import PitchCurve
from planter.kernels import Array, Flags, Integers
from planter.numerics import extrema, piecewise

KINDS = ("fillet", "flank", "tip", "root")


@dataclass(frozen=True)
class OutlinePieces:
    """Pieces (n,) of an outline in its order: index into KINDS, number of the flank or -1, tooth,
    side, and the arc lengths of the pitch curve at which their start and end are cut.
    """

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
    """Return pieces split where the curvature of the pitch curve jumps, each in the outline's
    direction.
    """
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


TIP, ROOT = KINDS.index("tip"), KINDS.index("root")
_NODES = 24
"""Nodes of a quadrature along a piece."""
_SAMPLES = 17
"""Points of a piece from which the point nearest to the axis is searched."""


@dataclass(frozen=True)
class Gear:
    """A toothed gear in the frame of its axis."""

    name: str
    flanks: Flanks

    @property
    def curve(self) -> PitchCurve:
        return self.flanks.curve

    @property
    def rack(self) -> Rack:
        return self.flanks.rack

    @property
    def z(self) -> int:
        return self.flanks.z

    @cached_property
    def paths(self) -> list[list[FlankLine]]:
        """The lines of the outline along each flank, from the tip to the root."""
        return build_flank_lines(self.flanks)

    @cached_property
    def pieces(self) -> OutlinePieces:
        """Pieces tooth by tooth: fillet, flank, tip, flank, fillet, root; split at breakpoints of
        the pitch curve.
        """
        rows = self._arrange(np.array(list(self._ordered())))
        kind, flank, tooth, side = rows[:, :4].astype(int).T
        pieces = OutlinePieces(kind, flank, tooth, side, rows[:, 4], rows[:, 5])
        # a rack with a full tip radius leaves no root
        pieces = split_at_joints(self.curve, pieces)
        return pieces.select(np.abs(pieces.end - pieces.start) > EMPTY_SHARE * self.curve.length)

    def _arrange(self, rows: Array) -> Array:
        """Return the rows of all pieces of the outline, from those of whole teeth."""
        return rows

    @cached_property
    def reaches(self) -> tuple[Array, Array]:
        """Lengths (2 z,) [m] from the flanks' crossings to their tips, and to their ends."""
        flanks = self.flanks
        ends = np.array([path[0].lower for path in self.paths])
        return np.abs(flanks.tips[0] - flanks.xi), np.abs(ends - flanks.xi)

    def _ordered(self) -> Iterator[tuple[float, ...]]:
        """Yield the rows of `OutlinePieces` in order."""
        f, z = self.flanks, self.z
        for tooth in range(z):
            begin, end = tooth, z + tooth
            for line in reversed(self.paths[begin][:-1]):
                yield KINDS.index(line.kind), begin, tooth, -1, line.lower, line.upper
            yield TIP, -1, tooth, 0, f.tips[1][begin], f.tips[1][end]
            *lines, root = self.paths[end]
            for line in lines:
                yield KINDS.index(line.kind), end, tooth, 1, line.upper, line.lower
            # the last root ends a turn after the first tooth begins
            past = 0.0 if tooth + 1 < z else self.curve.length
            yield ROOT, -1, tooth, 0, root.upper, self.paths[(tooth + 1) % z][-1].upper + past

    def outline(self) -> list[Piece]:
        """Return the pieces of the outline in order, each beginning where the last one ends."""
        return [self.piece(number) for number in range(len(self.pieces.kind))]

    def piece(self, number: int) -> Piece:
        """Return a piece of the outline by its number."""
        rows = self.pieces.select(np.array([number]))

        def evaluate(s: Array) -> Array:
            cut = self.cut(rows.select(np.zeros(len(s), dtype=int)), s)
            return np.vstack([cut.points, cut.tangents, cut.turning / cut.rate])

        return Piece(KINDS[rows.kind[0]], evaluate, int(rows.tooth[0]), int(rows.side[0]))

    @property
    def pitch_line(self) -> Piece:
        return self.curve.part(0.0, self.curve.length)

    def cut(self, pieces: OutlinePieces, share: Array) -> Cut:
        """Return pieces (n,) evaluated at shares (n,)."""
        s = pieces.start + share * (pieces.end - pieces.start)
        cut = Cut(np.empty((2, len(s))), np.empty((2, len(s))), np.empty(len(s)), np.empty(len(s)))
        # all pieces of a kind in one call, which costs more than its points
        for number, kind in enumerate(KINDS):
            index = np.flatnonzero(pieces.kind == number)
            if len(index):
                flank, towards = pieces.flank[index], pieces.middle[index]
                values = self.flanks.cut(kind, s[index], flank, towards)
                for rows, source in zip(vars(cut).values(), vars(values).values(), strict=True):
                    rows[..., index] = source
        return cut

    def sampled(self, shares: Array, index: Integers | None = None) -> Cut:
        """Return points (2, m, n) and derivatives of all pieces, or those of an index (m,), at
        shares (n,).
        """
        pieces = self.pieces if index is None else self.pieces.select(index)
        count = len(pieces.kind)
        repeated = pieces.select(np.repeat(np.arange(count), len(shares)))
        cut = self.cut(repeated, np.tile(shares, count))
        return Cut(
            *(rows.reshape(*rows.shape[:-1], count, len(shares)) for rows in vars(cut).values())
        )

    @cached_property
    def _quadrature(self) -> tuple[Cut, Array]:
        """All pieces at the nodes of a quadrature, and weights (m, n) of arc lengths of the
        outline.
        """
        shares, weights = piecewise.gauss_panels(np.array([0.0, 1.0]), _NODES)
        cut = self.sampled(shares[0])
        stretch = (self.pieces.end - self.pieces.start)[:, None]
        return cut, cut.rate * stretch * weights[0]

    @property
    def area(self) -> float:
        """Area inside the outline [m2]."""
        cut, weights = self._quadrature
        # Green's theorem along the outline
        (x, y), (ex, ey) = cut.points, cut.tangents
        return float(((x * ey - y * ex) * weights).sum() / 2)

    @cached_property
    def top_lands(self) -> Array:
        """Arc length (z,) of each tooth's tip [m]."""
        lengths = self._quadrature[1].sum(axis=1)
        tips = self.pieces.kind == TIP
        return np.bincount(self.pieces.tooth[tips], lengths[tips], self.z).astype(float)

    @property
    def root_radius(self) -> float:
        """Smallest distance of the outline from the axis [m]."""
        shares = np.linspace(0, 1, _SAMPLES)
        distances = np.hypot(*self.sampled(shares).points)
        # the samples only choose the piece; its minimum is searched
        nearest = self.piece(int(np.argmin(distances.min(axis=1))))
        return extrema.find_minimum(lambda s: np.hypot(*nearest.at(s).T), shares).value
