"""Solids as triangles in STL (mm), by trimesh: an outline with holes, extruded."""

from __future__ import annotations

from collections.abc import Sequence

from planter.workshop.arcs import Arcs

_MM = 1e3


def stl(outline: Arcs, holes: Sequence[Arcs], width: float, tolerance: float) -> bytes:
    """A body of a width [m] between two planes as a binary STL file, its chords within `tolerance` [m] of the arcs."""
    from shapely import Polygon
    from trimesh.creation import extrude_polygon
    from trimesh.exchange.stl import export_stl

    rings = [_MM * ring.points(tolerance) for ring in (outline, *holes)]
    body = extrude_polygon(Polygon(rings[0], rings[1:]), _MM * width, engine="earcut")
    return export_stl(body)
