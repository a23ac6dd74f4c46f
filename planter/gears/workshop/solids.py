"""Solids in mm: STEP by Open CASCADE, with one cubic spline for each exact piece, and STL by
trimesh.

Open CASCADE comes with the extra `planter[step]` and is loaded with the first solid.
"""

from __future__ import annotations

import io
import os
import re
import time
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime
from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from planter.errors import ComputationError, InputError
from planter.gears.geometry.pieces import Piece
from planter.gears.workshop.arcs import Arcs, interpolate_arcs
from planter.kernels import Array
from planter.version import __version__

SpaceCurve = Callable[[Array], Array]
TOLERANCE = 2e-7
"""Largest deviation of a spline from its piece [m]."""
_MM = 1e3
_SEWING_TOLERANCE = 1e-4
"""Distance below which edges are joined [mm]."""
_PRODUCT = re.compile(rb"\bPRODUCT\('[^']*',\s*'[^']*'")
_FILE_NAME = re.compile(rb"\bFILE_NAME\(.*?\);", re.DOTALL)
CLOCK = "SOURCE_DATE_EPOCH"
"""Variable of the environment with the time [s] that stands for the clock's, so that the same parts
give the same files (reproducible-builds.org).
"""


class OpenCascade:
    """Modules of Open CASCADE by their names, without console output.

    Raises InputError, naming the extra, if it is not installed.
    """

    def __init__(self) -> None:
        try:
            import_module("OCP.Message")
        except ImportError:
            raise InputError(
                "STEP files need Open CASCADE, which is not installed: pip install 'planter[step]'"
            ) from None
        self._silence()

    def _silence(self) -> None:
        """Remove the printers of its messenger, whose banners would mix with a command's result."""
        message = self.Message
        message.Message.DefaultMessenger_s().RemovePrinters(
            message.Message_PrinterOStream.get_type_descriptor_s()
        )

    def __getattr__(self, name: str) -> Any:
        return import_module(f"OCP.{name}")


def format_prism(name: str, outline: Sequence[Piece], holes: Sequence[Arcs], width: float) -> bytes:
    """Return a prism of a width [m] as a STEP file; the same body gives the same bytes.

    Raises InputError if Open CASCADE is not installed, ComputationError if the outline bounds no
    body.
    """
    kernel = OpenCascade()
    return _format_step(kernel, name, _build_prism(kernel, outline, holes, width))


def format_ring(name: str, rims: Sequence[tuple[SpaceCurve, SpaceCurve]], base: float) -> bytes:
    """Return a ring as STEP, whose rim is ruled piece by piece from an inner to an outer curve,
    down to a plane [m].

    A curve gives points (n, 3) [m] along s from 0 to 1. Raises as `format_prism` does.
    """
    kernel = OpenCascade()
    sewing = kernel.BRepBuilderAPI.BRepBuilderAPI_Sewing(_SEWING_TOLERANCE)
    for courses in rims:
        inner, outer = (
            (_build_edge(kernel, course), _build_edge(kernel, _project_to_plane(course, base)))
            for course in courses
        )
        for sides in pairwise([inner[0], *outer, inner[1], inner[0]]):
            sewing.Add(kernel.BRepFill.BRepFill.Face_s(*sides))
    sewing.Perform()
    if sewing.NbFreeEdges():
        raise ComputationError(f"the ring is open along {sewing.NbFreeEdges()} edges")
    solid = kernel.BRepBuilderAPI.BRepBuilderAPI_MakeSolid(
        kernel.TopoDS.TopoDS.Shell(sewing.SewedShape())
    ).Solid()
    kernel.BRepLib.BRepLib.OrientClosedSolid_s(solid)
    return _format_step(kernel, name, solid)


def _build_edge(kernel: OpenCascade, course: SpaceCurve) -> Any:
    curve = _build_curve(kernel, fit_spline("a curve in space", course, TOLERANCE))
    return kernel.BRepBuilderAPI.BRepBuilderAPI_MakeEdge(curve).Edge()


def _project_to_plane(course: SpaceCurve, base: float) -> SpaceCurve:
    """Return a curve projected along z to the plane z = base [m]."""
    return lambda s: course(s) * [1.0, 1.0, 0.0] + [0.0, 0.0, base]


def _build_prism(
    kernel: OpenCascade, outline: Sequence[Piece], holes: Sequence[Arcs], width: float
) -> Any:
    curves = []
    for piece in outline:
        name = f"a piece, {piece.kind},"
        spline = fit_spline(name, piece.at, TOLERANCE, piece.tangent)
        curves.append(_build_curve(kernel, spline))
    face = kernel.BRepBuilderAPI.BRepBuilderAPI_MakeFace(_build_wire(kernel, curves))
    for hole in holes:
        wire = _build_wire(kernel, list(_build_arcs(kernel, hole)))
        face.Add(kernel.TopoDS.TopoDS.Wire(wire.Reversed()))
    if not face.IsDone():
        raise ComputationError("the outline bounds no plane face")
    up = kernel.gp.gp_Vec(0, 0, _MM * width)
    return kernel.BRepPrimAPI.BRepPrimAPI_MakePrism(face.Face(), up).Shape()


def _build_curve(kernel: OpenCascade, spline: BSpline) -> Any:
    """Return a spline as a curve [mm], in the plane z = 0 if it is two-dimensional."""
    collections, gp = kernel.collections, kernel.gp
    poles = collections.Array1_gp_Pnt(1, len(spline.c))
    for i, (x, y, *z) in enumerate((_MM * spline.c).tolist(), 1):
        poles.SetValue(i, gp.gp_Pnt(x, y, *(z or [0.0])))
    places, counts = np.unique(spline.t, return_counts=True)
    knots = collections.Array1_double(1, len(places))
    multiplicities = collections.Array1_int(1, len(places))
    for i, (knot, count) in enumerate(
        zip((_MM * places).tolist(), counts.tolist(), strict=True), 1
    ):
        knots.SetValue(i, knot)
        multiplicities.SetValue(i, count)
    return kernel.Geom.Geom_BSplineCurve(poles, knots, multiplicities, DEGREE)


def _build_arcs(kernel: OpenCascade, arcs: Arcs) -> Iterator[Any]:
    """Yield each arc as a curve in the plane z = 0 [mm]."""
    half, chords = arcs.half_angles, _MM * arcs.chords
    start = _MM * arcs.vertices
    middle = interpolate_arcs(start, chords, half, np.full(len(half), 0.5))
    for begin, centre, finish, turn in zip(start, middle, start + chords, half, strict=True):
        a, m, b = (kernel.gp.gp_Pnt(float(x), float(y), 0) for x, y in (begin, centre, finish))
        curve = kernel.GC.GC_MakeArcOfCircle(a, m, b) if turn else kernel.GC.GC_MakeSegment(a, b)
        yield curve.Value()


def _build_wire(kernel: OpenCascade, curves: Sequence[Any]) -> Any:
    """Return a closed wire of consecutive curves with common vertices."""
    build = kernel.BRepBuilderAPI
    corners = [
        build.BRepBuilderAPI_MakeVertex(curve.Value(curve.FirstParameter())).Vertex()
        for curve in curves
    ]
    wire = build.BRepBuilderAPI_MakeWire()
    for curve, start, end in zip(curves, corners, corners[1:] + corners[:1], strict=True):
        edge = build.BRepBuilderAPI_MakeEdge(curve, start, end)
        if not edge.IsDone():
            raise ComputationError(
                "the outline has an edge that does not end where the next begins"
            )
        wire.Add(edge.Edge())
    return wire.Wire()


def _format_step(kernel: OpenCascade, name: str, shape: Any) -> bytes:
    control = kernel.STEPControl
    writer = control.STEPControl_Writer()
    writer.Transfer(shape, control.STEPControl_StepModelType.STEPControl_AsIs)
    content = io.BytesIO()
    writer.WriteStream(content)
    return head_step(content.getvalue(), name)


def head_step(content: bytes, name: str) -> bytes:
    """Return a STEP file with the name of its part, the date, and planter as the system that it is
    from.

    Raises InputError if SOURCE_DATE_EPOCH is no number of seconds.
    """
    label = name.replace("'", " ")
    head = f"FILE_NAME('{label}','{_read_date()}',(''),(''),'Open CASCADE','planter {__version__}','');"
    product = f"PRODUCT('{label}','{label}'"
    titled = _FILE_NAME.sub(lambda _: head.encode(), content, count=1)
    return _PRODUCT.sub(lambda _: product.encode(), titled)


def _read_date() -> str:
    """Return the date and time, those of SOURCE_DATE_EPOCH if it is set."""
    text = os.environ.get(CLOCK)
    try:
        seconds = time.time() if text is None else float(text)
        date = datetime.fromtimestamp(seconds, UTC)
    except (ValueError, OverflowError, OSError):
        raise InputError(f"{CLOCK} = {text}: it must be a number of seconds since 1970") from None
    return f"{date:%Y-%m-%dT%H:%M:%S}"


DEGREE = 3
MIN_SPANS, MAX_SPANS = 8, 2048
"""Smallest and largest number of spans of a spline."""


def fit_spline(
    name: str, places: SpaceCurve, tolerance: float, tangents: SpaceCurve | None = None
) -> BSpline:
    """Return a spline by the length along it [m], within `tolerance` [m] of a curve halfway between
    the interpolated points.

    With unit tangents (n, 2) of a plane curve it begins and ends along them, and its deviation is
    measured across them: along the curve it may run at another speed. Raises ComputationError,
    naming the curve, if no spline follows it.
    """
    spans = MIN_SPANS
    while spans <= MAX_SPANS:
        s = np.linspace(0.0, 1.0, 2 * spans + 1)
        points, ways = places(s), None if tangents is None else tangents(s)
        chords = np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1))
        length = np.concatenate([[0.0], np.cumsum(chords)])
        ends: Any = "not-a-knot" if ways is None else ([(1, ways[0])], [(1, ways[-1])])
        spline = make_interp_spline(length[::2], points[::2], k=DEGREE, bc_type=ends)
        missed = (spline(length[1::2]) - points[1::2]).T
        if ways is None:
            error = np.sqrt((missed**2).sum(axis=0))
        else:
            error = np.abs(missed[0] * ways[1::2, 1] - missed[1] * ways[1::2, 0])
        if error.max() <= tolerance:
            return spline
        # doubled until halfway points agree; the error falls with the fourth power
        spans *= 2
    raise ComputationError(f"{name} turns too sharply for a spline within {tolerance * 1e6:g} um")


def format_stl(outline: Arcs, holes: Sequence[Arcs], width: float, tolerance: float) -> bytes:
    """Return a prism of a width [m] as a binary STL file with chords within `tolerance` [m] of the
    arcs.
    """
    from shapely import Polygon
    from trimesh.creation import extrude_polygon
    from trimesh.exchange.stl import export_stl

    rings = [_MM * ring.points(tolerance) for ring in (outline, *holes)]
    body = extrude_polygon(Polygon(rings[0], rings[1:]), _MM * width, engine="earcut")
    return export_stl(body)
