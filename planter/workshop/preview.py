"""A drawing to look at: SVG with the very arcs of the DXF, in mm, without any library."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np

from planter.kernels import Array
from planter.workshop.arcs import Arcs
from planter.workshop.drawing import Layer, Line

_MM = 1e3
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


def svg(lines: Iterable[Line], title: str) -> str:
    """Curves as an SVG text of their true size, y upwards: the same curves give the same text."""
    drawn = list(lines)
    corners = np.vstack([line.arcs.vertices for line in drawn]) * _MM
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = _MARGIN * float((high - low).max())
    x, y = low[0] - margin, -high[1] - margin
    width, height = high - low + 2 * margin
    paths = "\n".join(_path(line, float(width)) for line in drawn)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.3f}mm" height="{height:.3f}mm" '
        f'viewBox="{x:.3f} {y:.3f} {width:.3f} {height:.3f}">\n<title>{escape(title)}</title>\n'
        f'<rect x="{x:.3f}" y="{y:.3f}" width="{width:.3f}" height="{height:.3f}" fill="#fefefe"/>\n{paths}\n</svg>\n'
    )


def _path(line: Line, width: float) -> str:
    stroke = width * (0.001 if line.layer in _THIN else 0.002)
    return (
        f'<path class="{line.layer}" fill="none" stroke="{_STYLES[line.layer]}" stroke-width="{stroke:.3f}" '
        f'd="{data(line.arcs)}"/>'
    )


def data(arcs: Arcs) -> str:
    """A curve as the data of an SVG path in mm, y downwards, to a tenth of a micrometre.

    >>> from planter.workshop.arcs import circle
    >>> data(circle(0.01))
    'M-10 0A10 10 0 0 0 10 0A10 10 0 0 0 -10 0Z'
    """
    half, chords = arcs.half_angles, np.hypot(*arcs.chords.T) * _MM
    ends = np.roll(arcs.vertices, -1, axis=0)[: len(chords)] * _MM
    steps = [f"M{_place(arcs.vertices[0] * _MM)}"]
    for angle, chord, end in zip(half.tolist(), chords.tolist(), ends, strict=True):
        if angle == 0:
            steps.append(f"L{_place(end)}")
        else:
            radius = _number(abs(chord / (2 * np.sin(angle))))
            steps.append(f"A{radius} {radius} 0 {int(abs(angle) > np.pi / 2)} {int(angle < 0)} {_place(end)}")
    return "".join(steps) + ("Z" if arcs.closed else "")


def _place(point: Array) -> str:
    return f"{_number(point[0])} {_number(-point[1])}"


def _number(value: float) -> str:
    return f"{round(float(value), 4) + 0.0:.10g}"
