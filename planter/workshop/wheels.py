"""Toothed wheels as files: a drawing, a preview and a table of flanks of each, the assembly, solids and meshes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from planter.files import csv_rows
from planter.kernels import Array
from planter.workshop import biarcs, courses, mesh, preview, solids
from planter.workshop.arcs import Arcs
from planter.workshop.biarcs import Fit
from planter.workshop.bores import Bore, check_wall
from planter.workshop.drawing import Line, cross, dxf
from planter.workshop.outline import Piece, Traced

STEPS = 8
"""Steps along a piece in the table of flanks."""
_BEYOND = 1.08
"""How far centre lines reach, in largest radii."""


class ToothPiece(Piece, Protocol):
    """A piece of a toothed outline: on which tooth, +1 or -1 on which of its sides, 0 on neither."""

    @property
    def tooth(self) -> int: ...
    @property
    def side(self) -> int: ...


class ToothedOutline(Protocol):
    """A gear's outline, and places (n, 2) [m] of its pitch curve by a parameter that runs from 0 to 1."""

    @property
    def name(self) -> str: ...
    @property
    def pieces(self) -> Sequence[ToothPiece]: ...
    @property
    def pitch(self) -> Callable[[Array], Array]: ...


@dataclass(frozen=True)
class Wheel:
    """A gear as it is made, in the frame of its axis, its arcs within a tolerance [m], and where an assembly puts it.

    There it is turned by `turn` [rad], then shifted to `centre` [m]. `stem` begins the names of its files.
    """

    stem: str
    outline: ToothedOutline
    tolerance: float
    bore: Bore | None = None
    turn: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if self.bore is not None:
            check_wall(self.bore, self.teeth.arcs, self.outline.name)

    @cached_property
    def teeth(self) -> Fit:
        """The toothed outline as arcs."""
        return biarcs.fit(self.outline.pieces, self.tolerance)

    @cached_property
    def pitch(self) -> Fit:
        """The pitch curve as arcs."""
        return biarcs.fit([Traced("pitch curve", self.outline.pitch)], self.tolerance)

    def lines(self) -> Iterator[Line]:
        """What is drawn of it, in its own frame."""
        yield Line("TEETH", self.teeth.arcs)
        yield Line("PITCH", self.pitch.arcs)
        if self.bore is not None:
            yield from self.bore.lines()
        yield from cross((0.0, 0.0), _BEYOND * float(np.hypot(*self.teeth.arcs.vertices.T).max()))

    def placed(self) -> Iterator[Line]:
        """What is drawn of it in the assembly."""
        for line in self.lines():
            turn = 0.0 if line.layer == "CENTRE" else self.turn
            yield Line(line.layer, line.arcs.moved(turn, self.centre))

    def table(self, comments: Iterable[str]) -> str:
        """Places along the outline as CSV, piece by piece."""
        pieces, found = self.outline.pieces, courses.course(self.outline.pieces, STEPS)
        columns = found.columns()
        own = [(pieces[i].kind, pieces[i].tooth, pieces[i].side) for i in found.piece.astype(int)]
        numbers = zip(*(values.tolist() for values in columns.values()), strict=True)
        rows = ((*values, *names) for values, names in zip(numbers, own, strict=True))
        return csv_rows.written(comments, (*columns, "piece", "tooth", "side"), rows)

    def files(self, comments: Sequence[str]) -> dict[str, bytes]:
        """Drawing, preview and table of flanks, by their names."""
        lines = list(self.lines())
        return {
            f"{self.stem}.dxf": dxf(lines),
            f"{self.stem}.svg": preview.svg(lines, self.outline.name).encode(),
            f"{self.stem}.csv": self.table(comments).encode(),
        }

    def step(self, width: float) -> dict[str, bytes]:
        """The solid of a width [m]. Raises InputError where Open CASCADE is not installed."""
        return {f"{self.stem}.step": solids.extruded(self.outline.name, self.outline.pieces, self._holes, width)}

    def stl(self, width: float) -> dict[str, bytes]:
        """The mesh of a width [m]."""
        return {f"{self.stem}.stl": mesh.stl(self.teeth.arcs, self._holes, width, self.tolerance)}

    @property
    def _holes(self) -> list[Arcs]:
        return [] if self.bore is None else [self.bore.edge]


def assembly(wheels: Sequence[Wheel], stem: str, title: str) -> dict[str, bytes]:
    """Drawing and preview of wheels where they belong."""
    lines = [line for wheel in wheels for line in wheel.placed()]
    return {f"{stem}.dxf": dxf(lines), f"{stem}.svg": preview.svg(lines, title).encode()}
