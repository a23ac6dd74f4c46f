"""Files of a set of gears: drawings, previews, solids, tables of flanks, and the assembly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.files import csv_rows
from planter.gears.geometry.gear import Gear
from planter.gears.geometry.intermittent_gears import IncompleteGear
from planter.gears.workshop import arcs, drawing, solids
from planter.gears.workshop.arcs import Arcs
from planter.gears.workshop.drawing import Bore, DrawingLine

MIN_RIM = 0.5
"""Smallest rim between a bore with its keyway and the roots, in tooth depths: a rule of this
program.
"""
_ROWS = 8
"""Steps of a piece in a table of flanks."""


@dataclass(frozen=True)
class PartSettings:
    """Settings of the files: arc tolerance [m], bore, width of the gears [m], and whether to write
    solids.
    """

    tolerance: float
    bore: Bore | None
    width: float
    step: bool
    stl: bool


@dataclass(frozen=True)
class PlacedGear:
    """A gear rotated by an angle [rad] with its axis at a centre [m], and the direction of its
    keyway [rad] in its " "frame.
    """

    gear: Gear
    angle: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)
    key: float | None = None


@dataclass(frozen=True)
class GearPart:
    """A gear with its manufacturing settings."""

    placed: PlacedGear
    settings: PartSettings

    @property
    def stem(self) -> str:
        return self.placed.gear.name.replace(" ", "_")

    @cached_property
    def teeth(self) -> Arcs:
        """The outline as arcs."""
        return arcs.fit_arcs(self.placed.gear.outline(), self.settings.tolerance)

    @cached_property
    def pitch(self) -> Arcs:
        """The pitch curve as arcs."""
        gear, tolerance = self.placed.gear, 10 * self.settings.tolerance
        closed = not isinstance(gear, IncompleteGear)
        return arcs.fit_arcs([gear.pitch_line], tolerance, closed)

    @cached_property
    def bore(self) -> Bore | None:
        """The bore, its keyway in the direction of the shaft's."""
        bore = self.settings.bore
        if bore is None or bore.keyway is None or self.placed.key is None:
            return bore
        return replace(bore, keyway=replace(bore.keyway, phase=self.placed.key))

    def lines(
        self, turn: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)
    ) -> Iterator[DrawingLine]:
        """Yield the lines of a drawing of the gear, rotated by `turn` [rad], its axis at a centre
        [m].
        """
        yield DrawingLine("TEETH", self.teeth.moved(turn, centre))
        yield DrawingLine("PITCH", self.pitch.moved(turn, centre))
        if self.bore is not None:
            yield from self.bore.lines(turn, centre)
        yield from drawing.build_cross(centre, 0.1 * float(np.hypot(*self.teeth.vertices.T).max()))

    def files(self) -> Iterator[tuple[str, bytes]]:
        """Yield names and contents of the gear's files."""
        lines = list(self.lines())
        yield f"{self.stem}.dxf", drawing.format_dxf(lines)
        yield f"{self.stem}.svg", drawing.format_svg(lines, self.placed.gear.name).encode()
        yield f"{self.stem}_flanks.csv", _tabulate_flanks(self.placed.gear).encode()
        holes = [] if self.bore is None else [self.bore.edge]
        if self.settings.step:
            pieces = self.placed.gear.outline()
            yield (
                f"{self.stem}.step",
                solids.format_prism(self.placed.gear.name, pieces, holes, self.settings.width),
            )
        if self.settings.stl:
            yield (
                f"{self.stem}.stl",
                solids.format_stl(self.teeth, holes, self.settings.width, self.settings.tolerance),
            )


def check_parts(gears: Sequence[PlacedGear], settings: PartSettings) -> list[GearPart]:
    """Return the gears with their settings.

    Raises InputError for a bore that leaves too thin a rim.
    """
    parts = [GearPart(gear, settings) for gear in gears]
    for part in parts:
        gear, sizes = part.placed.gear, part.placed.gear.rack.sizes
        if part.bore is not None:
            limit = MIN_RIM * (sizes["tip"] + sizes["root"])
            drawing.check_wall(part.bore, part.teeth, gear.name, limit)
    return parts


def build_part_files(parts: Sequence[GearPart]) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents of all files: those of each gear, and of their assembly."""
    for part in parts:
        yield from part.files()
    lines = [line for part in parts for line in part.lines(part.placed.angle, part.placed.centre)]
    yield "assembly.dxf", drawing.format_dxf(lines)
    yield "assembly.svg", drawing.format_svg(lines, "assembly").encode()


def _tabulate_flanks(gear: Gear) -> str:
    """Return points of a gear's outline as CSV: piece, tooth, side, arc length, position, normal,
    curvature.
    """
    pieces = gear.outline()
    columns = arcs.tabulate_outline(pieces, _ROWS)
    labels = [(piece.kind, piece.tooth, piece.side) for piece in pieces for _ in range(_ROWS + 1)]
    numbers = zip(*(values.tolist() for values in columns.values()), strict=True)
    rows = ((*label, *row) for label, row in zip(labels, numbers, strict=True))
    comments = (f"gear: {gear.name}", f"teeth: {gear.z}", f"module_mm: {gear.rack.module * 1e3!r}")
    return csv_rows.format_csv(comments, ("piece", "tooth", "side", *columns), rows)
