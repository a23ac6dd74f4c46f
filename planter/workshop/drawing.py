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
from typing import TYPE_CHECKING, Literal

import numpy as np

from planter.kernels import Array
from planter.workshop.arcs import Arcs

if TYPE_CHECKING:
    from ezdxf.document import Drawing

Layer = Literal["TEETH", "PITCH", "BORE", "KEYWAY", "CENTRE", "CONTOUR"]
_COLOURS: dict[Layer, int] = {"TEETH": 7, "CONTOUR": 7, "PITCH": 8, "BORE": 5, "KEYWAY": 6, "CENTRE": 1}
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
    drawing.modelspace().add_lwpolyline(points, format="xyb", close=line.arcs.closed, dxfattribs=attributes)


@contextmanager
def _fix_dates() -> Iterator[None]:
    """Make ezdxf write fixed dates and ids; the setting is global, hence the lock."""
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
    "KEYWAY": "#1b2430",
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
        f'<rect x="{x:.3f}" y="{y:.3f}" width="{width:.3f}" height="{height:.3f}" fill="#fefefe"/>\n{paths}\n</svg>\n'
    )


def _format_line(line: DrawingLine, width: float) -> str:
    stroke = width * (0.001 if line.layer in _THIN else 0.002)
    return (
        f'<path class="{line.layer}" fill="none" stroke="{_STYLES[line.layer]}" stroke-width="{stroke:.3f}" '
        f'd="{format_path(line.arcs)}"/>'
    )


def format_path(arcs: Arcs) -> str:
    """Return a curve as the data of an SVG path in mm, y downwards, to a tenth of a micrometre.

    >>> from planter.workshop.arcs import build_circle
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
            steps.append(f"A{radius} {radius} 0 {int(abs(angle) > np.pi / 2)} {int(angle < 0)} {_format_point(end)}")
    return "".join(steps) + ("Z" if arcs.closed else "")


def _format_point(point: Array) -> str:
    return f"{_format_number(point[0])} {_format_number(-point[1])}"


def _format_number(value: float) -> str:
    return f"{round(float(value), 4) + 0.0:.10g}"
