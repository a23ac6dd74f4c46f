"""The files of a set of gears: drawings, previews, solids, flanks as tables, and how they are put together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.files import csv_rows
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.incomplete.gear import IncompleteGear
from planter.gears.results import Rim
from planter.kernels import Array
from planter.workshop import biarcs, bores, courses, drawing, mesh, preview, solids
from planter.workshop.arcs import Arcs
from planter.workshop.bores import Bore
from planter.workshop.drawing import Line
from planter.workshop.outline import Traced

LEAST_RIM = 0.5
"""Least rim between a bore, its keyway included, and the roots, in tooth depths: the rim thickness factors of ISO
6336-3 and AGMA 2001 end there."""
_ROWS = 8
"""Steps of a piece in a table of flanks."""


AnyGear = Gear | IncompleteGear
"""What files are made of: with teeth all round, or on part of a turn."""


@dataclass(frozen=True)
class Parts:
    """What files are made with: tolerance of arcs, bore, width of the gears [m], and whether to make solids."""

    tolerance: float
    bore: Bore | None
    width: float
    step: bool
    stl: bool


@dataclass(frozen=True)
class Placed:
    """A gear in its place: turned by an angle [rad], its axis at a centre [m]; direction of its keyway in its frame."""

    gear: AnyGear
    angle: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)
    key: float | None = None


@dataclass(frozen=True)
class Part:
    """A gear as it is made."""

    placed: Placed
    made: Parts

    @property
    def stem(self) -> str:
        return self.placed.gear.name.replace(" ", "_")

    @cached_property
    def teeth(self) -> Arcs:
        """Its outline as arcs."""
        return biarcs.fit(self.placed.gear.outline().pieces, self.made.tolerance).arcs

    @cached_property
    def pitch(self) -> Arcs:
        """Its pitch curve as arcs."""
        gear, tolerance = self.placed.gear, 10 * self.made.tolerance
        if isinstance(gear, IncompleteGear):
            return biarcs.fit([gear.pitch_line], tolerance, closed=False).arcs
        return biarcs.fit([Traced("pitch curve", gear.curve.places)], tolerance).arcs

    @cached_property
    def bore(self) -> Bore | None:
        """Its bore, with the keyway where its shaft has it."""
        bore = self.made.bore
        if bore is None or bore.keyway is None or self.placed.key is None:
            return bore
        return replace(bore, keyway=replace(bore.keyway, phase=self.placed.key))

    @cached_property
    def rim(self) -> Rim | None:
        """The rim between the bore and the roots, None without a bore. Raises InputError where it is too thin."""
        if self.bore is None:
            return None
        sizes = self.placed.gear.rack.sizes
        depth = sizes["tip"] + sizes["root"]
        wall = bores.check_wall(self.bore, self.teeth, self.placed.gear.name, LEAST_RIM * depth)
        return Rim(wall * 1e3, wall / depth)

    def lines(self, turn: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)) -> Iterator[Line]:
        """What a drawing shows of it, turned and with its axis at a centre."""
        yield Line("TEETH", self.teeth.moved(turn, centre))
        yield Line("PITCH", self.pitch.moved(turn, centre))
        if self.bore is not None:
            yield from self.bore.lines(turn, centre)
        yield from drawing.cross(centre, 0.1 * float(np.hypot(*self.teeth.vertices.T).max()))

    def files(self) -> Iterator[tuple[str, bytes]]:
        """Names and contents of its files."""
        lines = list(self.lines())
        yield f"{self.stem}.dxf", drawing.dxf(lines)
        yield f"{self.stem}.svg", preview.svg(lines, self.placed.gear.name).encode()
        yield f"{self.stem}_flanks.csv", _table(self.placed.gear).encode()
        holes = [] if self.bore is None else [self.bore.edge]
        if self.made.step:
            pieces = self.placed.gear.outline().pieces
            yield f"{self.stem}.step", solids.step(self.placed.gear.name, pieces, holes, self.made.width)
        if self.made.stl:
            yield f"{self.stem}.stl", mesh.stl(self.teeth, holes, self.made.width, self.made.tolerance)


def check(gears: Sequence[Placed], made: Parts) -> list[Part]:
    """Return the gears as they are made. Raises InputError for a bore that leaves too thin a rim."""
    found = [Part(one, made) for one in gears]
    for part in found:
        _ = part.rim
    return found


def files(parts: Sequence[Part]) -> Iterator[tuple[str, bytes]]:
    """Names and contents of all files: those of each gear, and of their assembly."""
    for part in parts:
        yield from part.files()
    lines = [line for part in parts for line in part.lines(part.placed.angle, part.placed.centre)]
    yield "assembly.dxf", drawing.dxf(lines)
    yield "assembly.svg", preview.svg(lines, "assembly").encode()


def _table(gear: AnyGear) -> str:
    """Places along the outline of a gear as CSV: which piece of which tooth, arc length, place, normal, curvature."""
    pieces = gear.outline().pieces
    found = courses.course(pieces, _ROWS)
    told = [(pieces[k].kind, pieces[k].tooth, pieces[k].side) for k in range(len(pieces))]
    columns = found.columns()
    values: Array = np.column_stack(list(columns.values()))
    rows = ((*told[k], *row) for k, row in zip(found.piece.tolist(), values.tolist(), strict=True))
    comments = (f"gear: {gear.name}", f"teeth: {gear.z}", f"module_mm: {gear.rack.module * 1e3!r}")
    return csv_rows.written(comments, ("piece", "tooth", "side", *columns), rows)
