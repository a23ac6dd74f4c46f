"""A gear: the exact outline that a rack cuts on its pitch curve, piece by piece, and what is measured of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.gearing.teeth import joins
from planter.gearing.teeth.curve import PitchCurve
from planter.gearing.teeth.flanks import Flanks
from planter.gearing.teeth.joins import Line
from planter.gearing.teeth.outline import Kind, Outline
from planter.gearing.teeth.pieces import KINDS, Pieces, at_joints, without_nothing
from planter.gearing.teeth.rack import Cut, Rack
from planter.kernels import Array
from planter.numerics import extremes, quadrature
from planter.numerics.arrays import Integers
from planter.numerics.latest import Latest

_TIP, _ROOT = KINDS.index("tip"), KINDS.index("root")
_NODES = 24
"""Nodes of a quadrature along a piece."""
_TRIED = 17
"""Places on a piece where the nearest point to the axis is looked for."""


@dataclass(frozen=True)
class Piece:
    """An exact piece of an outline, s from 0 to 1 (`outline.Piece`)."""

    gear: Gear
    number: int

    @cached_property
    def _own(self) -> Pieces:
        return self.gear.pieces.of(np.array([self.number]))

    @cached_property
    def _cut(self) -> Latest[Cut]:
        """What it is at shares (n,) of it; points and tangents are often asked for one after the other."""
        return Latest(lambda s: self.gear.cut(self._own.of(np.zeros(len(s), dtype=int)), s))

    @property
    def kind(self) -> Kind:
        return KINDS[self._own.kind[0]]

    @property
    def tooth(self) -> int:
        return int(self._own.tooth[0])

    @property
    def side(self) -> int:
        return int(self._own.side[0])

    def at(self, s: Array) -> Array:
        return self._cut(s).points.T

    def tangent(self, s: Array) -> Array:
        return self._cut(s).tangents.T

    def curvature(self, s: Array) -> Array:
        cut = self._cut(s)
        return np.asarray(cut.turning / cut.rate)


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
    def paths(self) -> list[list[Line]]:
        """The lines of the outline down each of the flanks, from the tip to the root."""
        return joins.paths(self.flanks)

    @cached_property
    def pieces(self) -> Pieces:
        """Tooth by tooth: fillet, flank, tip, flank, fillet, root; all cut where the pitch curve has a joint."""
        rows = np.array(list(self._ordered()))
        kind, flank, tooth, side = rows[:, :4].astype(int).T
        whole = Pieces(kind, flank, tooth, side, rows[:, 4], rows[:, 5])
        return without_nothing(at_joints(self.curve, whole), self.curve.length)

    def _ordered(self) -> Iterator[tuple[float, ...]]:
        """The rows of `Pieces`, one piece after the other."""
        f, z = self.flanks, self.z
        for tooth in range(z):
            begin, end = tooth, z + tooth
            for line in reversed(self.paths[begin][:-1]):
                yield KINDS.index(line.kind), begin, tooth, -1, line.lower, line.upper
            yield _TIP, -1, tooth, 0, f.tips[1][begin], f.tips[1][end]
            *lines, root = self.paths[end]
            for line in lines:
                yield KINDS.index(line.kind), end, tooth, 1, line.upper, line.lower
            past = 0.0 if tooth + 1 < z else self.curve.length
            yield _ROOT, -1, tooth, 0, root.upper, self.paths[(tooth + 1) % z][-1].upper + past

    def outline(self, centre: tuple[float, float] = (0.0, 0.0)) -> Outline:
        """The outline, for a gear whose axis an assembly puts at a centre [m]."""
        pieces = tuple(Piece(self, number) for number in range(len(self.pieces.kind)))
        return Outline(self.name, pieces, centre, self.curve.places)

    def cut(self, pieces: Pieces, share: Array) -> Cut:
        """What pieces (n,) are at shares (n,) of them."""
        s = pieces.start + share * (pieces.end - pieces.start)
        found = Cut(np.empty((2, len(s))), np.empty((2, len(s))), np.empty(len(s)), np.empty(len(s)))
        for kind, cut in enumerate(self._cutting):
            which = np.flatnonzero(pieces.kind == kind)
            if len(which):
                part = cut(s[which], pieces.flank[which], pieces.middle[which])
                for rows, values in zip(vars(found).values(), vars(part).values(), strict=True):
                    rows[..., which] = values
        return found

    def sampled(self, shares: Array, which: Integers | None = None) -> Cut:
        """Points (2, m, n) and the like of all pieces, or some of them (m,), at shares (n,) of each."""
        pieces = self.pieces if which is None else self.pieces.of(which)
        count = len(pieces.kind)
        every = pieces.of(np.repeat(np.arange(count), len(shares)))
        cut = self.cut(every, np.tile(shares, count))
        return Cut(*(rows.reshape(*rows.shape[:-1], count, len(shares)) for rows in vars(cut).values()))

    @property
    def _cutting(self) -> tuple[Callable[[Array, Integers, Array], Cut], ...]:
        """What cuts each of KINDS."""
        f, height = self.flanks, self.rack.sizes["tip"]
        return (
            f.fillet,
            f.flank,
            lambda s, _, towards: f.equidistant(s, height, towards),
            f.root,
        )

    @cached_property
    def _quadrature(self) -> tuple[Cut, Array]:
        """All pieces at the nodes of a quadrature, and weights (m, n) of arc lengths of the outline."""
        shares, weights = quadrature.panels(np.array([0.0, 1.0]), _NODES)
        cut = self.sampled(shares[0])
        stretch = (self.pieces.end - self.pieces.start)[:, None]
        return cut, cut.rate * stretch * weights[0]

    @property
    def area(self) -> float:
        """Area inside the outline [m2]."""
        cut, weights = self._quadrature
        (x, y), (ex, ey) = cut.points, cut.tangents
        return float(((x * ey - y * ex) * weights).sum() / 2)

    @cached_property
    def top_lands(self) -> Array:
        """Arc length (z,) of each tooth's tip [m]."""
        lengths = self._quadrature[1].sum(axis=1)
        tips = self.pieces.kind == _TIP
        found: Array = np.bincount(self.pieces.tooth[tips], lengths[tips], self.z).astype(float)
        return found

    @property
    def root_radius(self) -> float:
        """Least distance of the outline from the axis [m]."""
        shares = np.linspace(0, 1, _TRIED)
        distances = np.hypot(*self.sampled(shares).points)
        nearest = Piece(self, int(np.argmin(distances.min(axis=1))))
        return extremes.least(lambda s: np.hypot(*nearest.at(s).T), shares).value
