"""Drawings of curves of arcs: DXF (R2010, mm) by ezdxf, and SVG previews with the same arcs.

Each outline is one LWPOLYLINE, whose arcs are bulges.
"""

from __future__ import annotations

import io
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from importlib import resources
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from planter.errors import InputError
from planter.gears.workshop.arcs import Arcs, build_circle
from planter.kernels import Array
from planter.text_files import parse_toml

if TYPE_CHECKING:
    from ezdxf.document import Drawing

Layer = Literal["TEETH", "PITCH", "BORE", "CENTRE", "CONTOUR"]
_COLOURS: dict[Layer, int] = {
    "TEETH": 7,
    "CONTOUR": 7,
    "PITCH": 8,
    "BORE": 5,
    "CENTRE": 1,
}
_MM = 1e3
_CENTRE_LINE = ("CENTER", "long and short dashes", [12.0, 8.0, -1.5, 1.0, -1.5])
"""Name, meaning, and pattern [mm]: its length, then dashes, gaps as negative."""
_LOCK = threading.Lock()


@dataclass(frozen=True)
class DrawingLine:
    """A curve on a layer."""

    layer: Layer
    arcs: Arcs


def build_cross(centre: tuple[float, float], reach: float) -> Iterator[DrawingLine]:
    """Yield two centre lines through a point [m] that extend `reach` [m] to both sides."""
    for arm in ((reach, 0.0), (0.0, reach)):
        ends = np.array([np.subtract(centre, arm), np.add(centre, arm)])
        yield DrawingLine("CENTRE", Arcs(ends, np.zeros(2), closed=False))


def format_dxf(lines: Iterable[DrawingLine]) -> bytes:
    """Return curves as a DXF file; the same curves give the same bytes."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    text = io.StringIO()
    with _fix_dates():
        drawing = new("R2010", units=units.MM)
        name, meaning, pattern = _CENTRE_LINE
        drawing.linetypes.add(name, pattern, description=meaning)
        for line in lines:
            _add_line(drawing, line)
        for kind in sorted(drawing.entitydb.dxf_types_in_use()):  # ezdxf iterates over a set
            drawing.classes.add_class(kind)
        drawing.write(text)
    return text.getvalue().encode(drawing.output_encoding)


def _add_line(drawing: Drawing, line: DrawingLine) -> None:
    if line.layer not in drawing.layers:
        kind = _CENTRE_LINE[0] if line.layer == "CENTRE" else "CONTINUOUS"
        drawing.layers.add(line.layer, color=_COLOURS[line.layer], linetype=kind)
    points = np.column_stack([_MM * line.arcs.vertices, line.arcs.bulges])
    attributes = {"layer": line.layer}
    drawing.modelspace().add_lwpolyline(
        points, format="xyb", close=line.arcs.closed, dxfattribs=attributes
    )


@contextmanager
def _fix_dates() -> Iterator[None]:
    """Make ezdxf write fixed dates and ids; a lock guards the global setting."""
    from ezdxf._options import options

    with _LOCK:
        before = options.write_fixed_meta_data_for_testing
        options.write_fixed_meta_data_for_testing = True
        try:
            yield
        finally:
            options.write_fixed_meta_data_for_testing = before


_MARGIN = 0.03
_STYLES: dict[Layer, str] = {
    "TEETH": "#1b2430",
    "CONTOUR": "#1b2430",
    "PITCH": "#0072b2",
    "BORE": "#1b2430",
    "CENTRE": "#d55e00",
}
_THIN: frozenset[Layer] = frozenset({"PITCH", "CENTRE"})


def format_svg(lines: Iterable[DrawingLine], title: str) -> str:
    """Return curves as SVG in true size, y upwards; the same curves give the same text."""
    shapes = list(lines)
    corners = np.vstack([line.arcs.vertices for line in shapes]) * _MM
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = _MARGIN * float((high - low).max())
    x, y = low[0] - margin, -high[1] - margin
    width, height = high - low + 2 * margin
    paths = "\n".join(_format_line(line, float(width)) for line in shapes)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.3f}mm" height="{height:.3f}mm" '
        f'viewBox="{x:.3f} {y:.3f} {width:.3f} {height:.3f}">\n<title>{escape(title)}</title>\n'
        f'<rect x="{x:.3f}" y="{y:.3f}" width="{width:.3f}" height="{height:.3f}" '
        f'fill="#fefefe"/>\n{paths}\n</svg>\n'
    )


def _format_line(line: DrawingLine, width: float) -> str:
    stroke = width * (0.001 if line.layer in _THIN else 0.002)
    return (
        f'<path class="{line.layer}" fill="none" stroke="{_STYLES[line.layer]}" '
        f'stroke-width="{stroke:.3f}" '
        f'd="{format_path(line.arcs)}"/>'
    )


def format_path(arcs: Arcs) -> str:
    """Return a curve as the data of an SVG path in mm, y downwards, to a tenth of a micrometre.

    >>> from planter.gears.workshop.arcs import build_circle
    >>> format_path(build_circle(0.01))
    'M-10 0A10 10 0 0 0 10 0A10 10 0 0 0 -10 0Z'
    """
    half, chords = arcs.half_angles, np.hypot(*arcs.chords.T) * _MM
    ends = np.roll(arcs.vertices, -1, axis=0)[: len(chords)] * _MM
    steps = [f"M{_format_point(arcs.vertices[0] * _MM)}"]
    for angle, chord, end in zip(half.tolist(), chords.tolist(), ends, strict=True):
        if angle == 0:
            steps.append(f"L{_format_point(end)}")
        else:
            radius = _format_number(abs(chord / (2 * np.sin(angle))))
            steps.append(
                f"A{radius} {radius} 0 {int(abs(angle) > np.pi / 2)} {int(angle < 0)} "
                f"{_format_point(end)}"
            )
    return "".join(steps) + ("Z" if arcs.closed else "")


def _format_point(point: Array) -> str:
    return f"{_format_number(point[0])} {_format_number(-point[1])}"


def _format_number(value: float) -> str:
    return f"{round(float(value), 4) + 0.0:.10g}"


_CHORD = 1e-6
"""Deviation of chords from arcs in the measurement of walls [m]."""


@dataclass(frozen=True)
class Keyway:
    """Width, depth in the hub from the crown of the bore [m], and direction from the axis [rad]."""

    width: float
    depth: float
    phase: float = 0.0


@dataclass(frozen=True)
class Bore:
    """A bore about the origin by its diameter [m], with a keyway or without.

    Raises InputError if the keyway is not narrower than the bore.
    """

    diameter: float
    keyway: Keyway | None = None

    def __post_init__(self) -> None:
        if self.keyway is not None and not self.keyway.width < self.diameter:
            raise InputError(
                f"keyway width = {self.keyway.width * _MM:g} mm: it must be below the bore's "
                f"{self.diameter * _MM:g} mm"
            )

    @property
    def reach(self) -> float:
        """Largest distance of the edge from the axis [m]."""
        if self.keyway is None:
            return self.diameter / 2
        return float(np.hypot(self.diameter / 2 + self.keyway.depth, self.keyway.width / 2))

    @property
    def edge(self) -> Arcs:
        """The edge with the keyway, anticlockwise."""
        if self.keyway is None:
            return build_circle(self.diameter / 2)
        slot = self._slot(self.keyway)
        bulge = np.tan((np.pi + slot.half_angles[-1]) / 2)
        return Arcs(slot.vertices, np.array([0.0, 0.0, 0.0, bulge]))

    def lines(
        self, turn: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)
    ) -> Iterator[DrawingLine]:
        """Yield the edge of the bore, which a keyway interrupts: one contour, as it is cut."""
        yield DrawingLine("BORE", self.edge.moved(turn, centre))

    def _slot(self, keyway: Keyway) -> Arcs:
        half, radius = keyway.width / 2, self.diameter / 2
        inner_x, outer_x = np.sqrt(radius**2 - half**2), radius + keyway.depth
        corners = np.array([[inner_x, -half], [outer_x, -half], [outer_x, half], [inner_x, half]])
        inner_bulge = -np.tan(np.arcsin(half / radius) / 2)
        return Arcs(corners, np.array([0.0, 0.0, 0.0, inner_bulge])).moved(keyway.phase)


def find_standard_keyway(diameter: float) -> tuple[float, float]:
    """Return width and depth in the hub [m] of the keyway of a bore [m] by DIN 6885-1.

    Raises InputError for a bore outside the range of the standard.

    >>> find_standard_keyway(0.020)
    (0.006, 0.0028)
    """
    name = "keyways.toml"
    table = parse_toml(
        resources.files(__package__).joinpath(name).read_text(encoding="utf-8"), name
    )
    limits = [table["least_bore_mm"], *(row["bore_mm"] for row in table["rows"])]
    for (low, high), row in zip(pairwise(limits), table["rows"], strict=True):
        if low < diameter * _MM <= high:
            return row["width_mm"] * 1e-3, row["depth_mm"] * 1e-3
    raise InputError(
        f"a bore of {diameter * _MM:g} mm has no keyway in {table['source']}: choose a bore over "
        f"{limits[0]} mm "
        f"and up to {limits[-1]} mm, or give the width and depth of the keyway"
    )


def check_wall(bore: Bore, outline: Arcs, name: str, limit: float) -> float:
    """Return the smallest wall [m] between a bore with its keyway and the outline of a part.

    Raises InputError if it is below `limit` > 0 [m].
    """
    from shapely import Polygon

    part, edge = (Polygon(arcs.points(_CHORD)) for arcs in (outline, bore.edge))
    wall = float(part.exterior.distance(edge)) if part.contains(edge) else 0.0
    if wall < limit:
        roots = float(np.hypot(*outline.vertices.T).min())
        slot = (
            ""
            if bore.keyway is None
            else f", with its keyway {bore.reach * _MM:.4g} mm from the axis,"
        )
        raise InputError(
            f"{name}: a bore of {bore.diameter * _MM:g} mm{slot} leaves a wall of "
            f"{wall * _MM:.4g} mm; at least "
            f"{limit * _MM:.4g} mm are needed inside an outline whose smallest radius is "
            f"{roots * _MM:.4g} mm"
        )
    return wall
