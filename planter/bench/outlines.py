"""Gears with teeth on a pair of ellipses, from the pitch curve to a drawing: here, and by ncgears.

Both cut the same rack, check that the pair meshes, and draw as they do by default. A drawing is off by as much as it
strays from the outline that its own generator has found.
"""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from ezdxf.entities.lwpolyline import LWPolyline
from ezdxf.filemanagement import read

from planter.bench.case import Absent, Case
from planter.bench.results import Drawn, Skipped
from planter.gear_geometry import cutting, pitch_curves
from planter.gear_geometry.cutting import ToothOrder
from planter.planting.model import Device
from planter.workshop import biarcs, drawing
from planter.workshop.drawing import DrawingLine

ECCENTRICITY, TEETH, MODULE, TOLERANCE = 0.2, 30, 2e-3, 1e-6
UNIT = f"us per pair of ellipses of eccentricity {ECCENTRICITY} with {TEETH} teeth each: outlines, checks, DXF"


@dataclass(frozen=True)
class Maker:
    """A way to make the pair: a call, how it was built, and the measures of the last drawing."""

    make: Callable[[Any], None]
    built: str
    measure: Callable[[], Drawn]


def ways(case: Case) -> tuple[dict[str, Maker], list[Skipped]]:
    """Return the ways that make the pair, and those that do not, with the reason."""
    makers = {"planter": ours(case)}
    try:
        return {**makers, "ncgears": theirs()}, []
    except Absent as reason:
        return makers, [Skipped("ncgears", str(reason))]


def ours(case: Case) -> Maker:
    """Exact pieces, all contacts solved, arcs within a micrometre."""
    device = Device(case.device.machine.with_numbers({"design.k6": ECCENTRICITY, "design.m61": 1.0}))
    fits: list[biarcs.ArcFit] = []

    def make(_: Any) -> None:
        curves = pitch_curves.build_stage_pair(device.stages[1], device.of_stage(1, device.design))
        order = ToothOrder(module=MODULE, keep="module")
        teeth = cutting.cut_teeth(curves, order, "ellipses", ("inner gear", "outer gear"))
        fits[:] = [biarcs.fit_arcs(gear.outline().pieces, TOLERANCE) for gear in teeth.gears]
        drawing.format_dxf(DrawingLine("TEETH", fit.arcs) for fit in fits)
        if teeth.gears[0].z != TEETH or np.abs(teeth.contacts.errors).max() > TOLERANCE:
            raise Absent("the pair does not mesh")

    def measure_drawing() -> Drawn:
        return Drawn(sum(len(fit.arcs.vertices) for fit in fits), max(fit.deviation for fit in fits) * 1e6)

    return Maker(make, "exact pieces, contacts solved, biarcs within 1 um", measure_drawing)


def theirs() -> Maker:
    """ncgears, as its documentation calls it. Raises Absent where it is not installed."""
    try:
        ncgears = import_module("ncgears")
    except ModuleNotFoundError:
        raise Absent("ncgears is not installed") from None
    folder = tempfile.TemporaryDirectory()
    file = Path(folder.name) / "pair.dxf"
    outlines: list[Any] = []

    def make(_: Any) -> None:
        gears = ncgears.generate_from_centrode(
            f"1/(1-{ECCENTRICITY}*cos(phi))", teeth=TEETH, module=MODULE * 1e3, output_directory=folder.name
        )
        gears.export_dxf(file)
        outlines[:] = [gears.drive_outline, gears.placed_driven_outline]

    def measure_drawing() -> Drawn:
        space = read(io.StringIO(file.read_text(encoding="utf-8"))).modelspace()
        lines = [line for line in space if isinstance(line, LWPolyline)]
        rings = [shapely.LinearRing(np.array(line.get_points("xy"))) for line in lines]
        off = [shapely.distance(shapely.points(dense), ring).max() for dense, ring in zip(outlines, rings, strict=True)]
        return Drawn(sum(len(ring.coords) - 1 for ring in rings), float(max(off)) * 1e3)

    return Maker(make, "generate_from_centrode and export_dxf with their defaults", measure_drawing)
