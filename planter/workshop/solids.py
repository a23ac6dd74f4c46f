"""Solids in STEP (mm) by Open CASCADE: an outline with one spline for each exact piece, extruded, with holes.

Open CASCADE comes with the extra `planter[step]` and is loaded when the first solid is made.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.workshop.arcs import Arcs, along
from planter.workshop.outline import Piece
from planter.workshop.splines import Spline, in_space, through

Course = Callable[[Array], Array]
TOLERANCE = 2e-7
"""How far a spline strays from its piece at most [m]."""
_MM = 1e3
_SAME = 1e-4
"""Edges that are nearer than this [mm] are one."""
_TITLES = re.compile(rb"\b(FILE_NAME|PRODUCT)\('[^']*',\s*'[^']*'")
_UNDATED = "2000-01-01T00:00:00"


class Kernel:
    """Modules of Open CASCADE by their names, silent from the first.

    Raises InputError, naming the extra, where it is not installed.
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
        """Its messenger prints banners to standard output, where a command's result belongs."""
        message = self.Message
        message.Message.DefaultMessenger_s().RemovePrinters(message.Message_PrinterOStream.get_type_descriptor_s())

    def __getattr__(self, name: str) -> Any:
        return import_module(f"OCP.{name}")


def step(name: str, outline: Sequence[Piece], holes: Sequence[Arcs], width: float) -> bytes:
    """A body of a width [m] between two planes as a STEP file: the same body gives the same bytes.

    Raises InputError where Open CASCADE is not installed, ComputationError for an outline that bounds no body.
    """
    kernel = Kernel()
    return _written(kernel, name, _prism(kernel, outline, holes, width))


def ring(name: str, rims: Sequence[tuple[Course, Course]], base: float) -> bytes:
    """A ring whose rim is ruled from an inner course to an outer one, piece by piece, down to a plane [m], as STEP.

    A course gives places (n, 3) [m] along s from 0 to 1. Raises as `step` does.
    """
    kernel = Kernel()
    sewing = kernel.BRepBuilderAPI.BRepBuilderAPI_Sewing(_SAME)
    for courses in rims:
        inner, outer = ((_edge(kernel, course), _edge(kernel, _lowered(course, base))) for course in courses)
        for one, two in ((inner[0], outer[0]), (outer[0], outer[1]), (outer[1], inner[1]), (inner[1], inner[0])):
            sewing.Add(kernel.BRepFill.BRepFill.Face_s(one, two))
    sewing.Perform()
    if sewing.NbFreeEdges():
        raise ComputationError(f"the ring is open along {sewing.NbFreeEdges()} edges")
    solid = kernel.BRepBuilderAPI.BRepBuilderAPI_MakeSolid(kernel.TopoDS.TopoDS.Shell(sewing.SewedShape())).Solid()
    kernel.BRepLib.BRepLib.OrientClosedSolid_s(solid)
    return _written(kernel, name, solid)


def _edge(kernel: Kernel, course: Course) -> Any:
    return kernel.BRepBuilderAPI.BRepBuilderAPI_MakeEdge(_curve(kernel, in_space(course, TOLERANCE))).Edge()


def _lowered(course: Course, base: float) -> Course:
    """A course, seen along z, in the plane z = base."""
    return lambda s: course(s) * [1.0, 1.0, 0.0] + [0.0, 0.0, base]


def _prism(kernel: Kernel, outline: Sequence[Piece], holes: Sequence[Arcs], width: float) -> Any:
    splines = [through(piece, TOLERANCE) for piece in outline]
    face = kernel.BRepBuilderAPI.BRepBuilderAPI_MakeFace(_ring(kernel, [_curve(kernel, s) for s in splines]))
    for hole in holes:
        face.Add(kernel.TopoDS.TopoDS.Wire(_ring(kernel, list(_arcs(kernel, hole))).Reversed()))
    if not face.IsDone():
        raise ComputationError("the outline bounds no plane face")
    up = kernel.gp.gp_Vec(0, 0, _MM * width)
    return kernel.BRepPrimAPI.BRepPrimAPI_MakePrism(face.Face(), up).Shape()


def _curve(kernel: Kernel, spline: Spline) -> Any:
    """A spline [mm], in the plane z = 0 where it has no third dimension."""
    collections, gp = kernel.collections, kernel.gp
    poles = collections.Array1_gp_Pnt(1, len(spline.poles))
    for i, (x, y, *z) in enumerate((_MM * spline.poles).tolist(), 1):
        poles.SetValue(i, gp.gp_Pnt(x, y, *(z or [0.0])))
    knots, times = collections.Array1_double(1, len(spline.knots)), collections.Array1_int(1, len(spline.knots))
    for i, (knot, count) in enumerate(zip((_MM * spline.knots).tolist(), spline.multiplicities, strict=True), 1):
        knots.SetValue(i, knot)
        times.SetValue(i, count)
    return kernel.Geom.Geom_BSplineCurve(poles, knots, times, spline.degree)


def _arcs(kernel: Kernel, arcs: Arcs) -> Iterator[Any]:
    """Each arc as a curve in the plane z = 0 [mm]."""
    half, chords = arcs.half_angles, _MM * arcs.chords
    start = _MM * arcs.vertices
    middle = along(start, chords, half, np.full(len(half), 0.5))
    for one, between, two, turn in zip(start, middle, start + chords, half, strict=True):
        a, m, b = (kernel.gp.gp_Pnt(float(x), float(y), 0) for x, y in (one, between, two))
        made = kernel.GC.GC_MakeArcOfCircle(a, m, b) if turn else kernel.GC.GC_MakeSegment(a, b)
        yield made.Value()


def _ring(kernel: Kernel, curves: Sequence[Any]) -> Any:
    """A closed wire of curves that follow each other; each pair of ends is one vertex."""
    build = kernel.BRepBuilderAPI
    corners = [build.BRepBuilderAPI_MakeVertex(curve.Value(curve.FirstParameter())).Vertex() for curve in curves]
    wire = build.BRepBuilderAPI_MakeWire()
    for curve, start, end in zip(curves, corners, corners[1:] + corners[:1], strict=True):
        made = build.BRepBuilderAPI_MakeEdge(curve, start, end)
        if not made.IsDone():
            raise ComputationError("the outline has an edge that does not end where the next begins")
        wire.Add(made.Edge())
    return wire.Wire()


def _written(kernel: Kernel, name: str, shape: Any) -> bytes:
    control = kernel.STEPControl
    writer = control.STEPControl_Writer()
    writer.Transfer(shape, control.STEPControl_StepModelType.STEPControl_AsIs)
    content = io.BytesIO()
    writer.WriteStream(content)
    told = name.replace("'", " ")
    titles = {b"FILE_NAME": f"FILE_NAME('{told}','{_UNDATED}'", b"PRODUCT": f"PRODUCT('{told}','{told}'"}
    return _TITLES.sub(lambda found: titles[found[1]].encode(), content.getvalue())
