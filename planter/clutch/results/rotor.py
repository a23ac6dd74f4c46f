"""What `planter clutch rotor` returns."""

from __future__ import annotations

from dataclasses import dataclass

from planter.clutch.results.shape import Harmonic, Pair, VertexPath
from planter.records import Record


@dataclass(frozen=True)
class CornerPath(VertexPath):
    """The ellipse at a corner of any pair of polygons; `lead_deg` is the turn over which the corner is passed."""

    lead_deg: float


@dataclass(frozen=True)
class SlidPath(Record):
    """The ellipse of a vertex while two others slide on sides, lengths in widths."""

    vertex: int
    centre_over_R: Pair
    semi_axes_over_R: Pair
    axis_deg: float


@dataclass(frozen=True)
class Sliding(Record):
    """Two vertices that slide on two sides at once, and what the others do meanwhile."""

    sides_apart: int
    vertices_apart: int
    rotation_deg: float
    paths: list[SlidPath]


@dataclass(frozen=True)
class Fit(Record):
    """`planter clutch rotor`: how a polygon turns in another, lengths in widths; null where it has no meaning."""

    vertices: int
    sides: int
    exact: bool
    smallest_over_R: float
    mismatch_over_R: float | None
    fillet_limit_over_R: float | None
    ellipse: CornerPath | None
    slides: Sliding
    harmonics: list[Harmonic]
