"""The drawing of a scene at its first moment as SVG; what moves carries a number by which a script finds it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.report.html import escape
from planter.view.channels import every
from planter.view.scene import Body, Outline, Point, Scene

LOOKED_AT = 48
"""Moments of a cycle at which the bodies' reach is measured."""
MARGIN = 0.04
"""Space around a drawing, in parts of its width."""
LONGEST = 0.25
"""Length of the largest force, in parts of a drawing's width."""


@dataclass(frozen=True)
class Frame:
    """A part of the plane: its left, its bottom, width and height [mm]."""

    left: float
    bottom: float
    width: float
    height: float

    @classmethod
    def around(cls, points: Array) -> Frame:
        """The part with all of some points (k, 2) and a margin."""
        low, high = points.min(axis=0), points.max(axis=0)
        margin = MARGIN * float(max(high - low)) or 1.0
        (left, bottom), (width, height) = low - margin, high - low + 2 * margin
        return cls(float(left), float(bottom), float(width), float(height))

    def __str__(self) -> str:
        """As an SVG has it, where y goes down."""
        return " ".join(map(number, (self.left, -self.bottom - self.height, self.width, self.height)))


def picture(scene: Scene) -> str:
    """The SVG of a scene."""
    near, wide = frames(scene)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="mechanism" role="img" aria-label="{escape(scene.title)}" '
        f'viewBox="{near}" data-near="{near}" data-wide="{wide}" data-force="{number(force_scale(scene))}">',
        f"<title>{escape(scene.title)}</title>",
        '<g transform="scale(1 -1)">',
        *_ground(scene),
        "<g data-machine>",
        *_traces(scene),
        *(line for body in scene.bodies for line in _body(scene, body, {b.name: i for i, b in _numbered(scene)})),
        *_chains(scene),
        *_forces(scene),
        *_points(scene),
        *_labels(scene),
        "</g></g></svg>",
    ]
    return "\n".join(parts)


def frames(scene: Scene) -> tuple[Frame, Frame]:
    """What the drawing shows seen from the machine, and from the ground."""
    seen = np.vstack([*_reached(scene), *([_path(p) for p in scene.points])])
    ground = [outline.points for outline in scene.ground]
    if scene.travel is None or not scene.travels:
        frame = Frame.around(np.vstack([seen, *ground]))
        return frame, frame
    shifted = [seen + np.array([x, 0.0]) for x in (scene.travel.min(), scene.travel.max())]
    return Frame.around(seen), Frame.around(np.vstack([*shifted, *ground]))


def force_scale(scene: Scene) -> float:
    """Length of a force's arrow [mm/N]."""
    largest = max((float(np.hypot(force.x, force.y).max()) for force in scene.forces), default=0.0)
    return LONGEST * frames(scene)[0].width / largest if largest else 0.0


def number(value: float) -> str:
    """A number with at most two decimals, in few letters.

    >>> number(12.500001), number(-0.001), number(30)
    ('12.5', '0', '30')
    """
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def line(points: Array, closed: bool) -> str:
    """Points (k, 2) as the path of an SVG."""
    steps = " ".join(f"{number(x)} {number(y)}" for x, y in points.tolist())
    return f"M{steps}{'Z' if closed else ''}"


def _numbered(scene: Scene) -> Iterator[tuple[int, Body]]:
    return iter(enumerate(every(scene.bodies)))


def _reached(scene: Scene) -> Iterator[Array]:
    """Corners (k, 2) of all bodies, at some moments of the cycle."""
    step = max(1, scene.moments // LOOKED_AT)
    for moment in range(0, scene.moments, step):
        for body in scene.bodies:
            yield from _placed(scene, body, moment, np.zeros(2), 0.0)


def _placed(scene: Scene, body: Body, moment: int, origin: Array, turned: float) -> Iterator[Array]:
    x, y, turn = (float(channel[moment]) for channel in scene.pose(body))
    here = origin + _turned(np.array([[x, y]]), turned)[0]
    for outline in body.outlines:
        yield here + _turned(outline.points, turned + turn)
    for part in body.parts:
        yield from _placed(scene, part, moment, here, turned + turn)


def _turned(points: Array, degrees: float) -> Array:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    found: Array = points @ np.array([[c, s], [-s, c]])
    return found


def _body(scene: Scene, body: Body, numbers: dict[str, int]) -> Iterator[str]:
    x, y, turn = (number(float(channel[0])) for channel in scene.pose(body))
    yield f'<g data-body="{numbers[body.name]}" transform="translate({x} {y}) rotate({turn})">'
    yield f"<title>{escape(body.name)}</title>"
    yield from map(_outline, body.outlines)
    for part in body.parts:
        yield from _body(scene, part, numbers)
    yield "</g>"


def _outline(outline: Outline) -> str:
    return f'<path class="{outline.look} s{outline.shade}" d="{line(outline.points, outline.closed)}"/>'


def _ground(scene: Scene) -> Iterator[str]:
    if scene.ground:
        yield "<g data-ground>"
        yield from map(_outline, scene.ground)
        yield "</g>"


def _path(point: Point) -> Array:
    return np.column_stack(np.broadcast_arrays(point.x, point.y)).astype(float)


def _traces(scene: Scene) -> Iterator[str]:
    for k, point in enumerate(scene.points):
        hidden = "" if point.traced else ' visibility="hidden"'
        yield f'<path class="trace" data-trace="{k}"{hidden} d="{line(_path(point), scene.again)}"/>'


def _points(scene: Scene) -> Iterator[str]:
    for k, point in enumerate(scene.points):
        (x, y), size = _path(point)[0], frames(scene)[0].width / 160
        place = f'cx="{number(x)}" cy="{number(y)}" r="{number(size)}"'
        yield f'<circle data-point="{k}" {place}><title>{escape(point.name)}</title></circle>'


def _forces(scene: Scene) -> Iterator[str]:
    scale = force_scale(scene)
    for k, force in enumerate(scene.forces):
        x, y = _path(force.at)[0].tolist()
        shown = arrow(x, y, scale * float(force.x[0]), scale * float(force.y[0]))
        yield f'<path class="force s{k % 6}" data-arrow="{k}" d="{shown}">'
        yield f"<title>{escape(force.name)}</title></path>"


def _chains(scene: Scene) -> Iterator[str]:
    for k, chain in enumerate(scene.chains):
        corners = np.array([_path(scene.points[index])[0] for index in chain.points])
        yield f'<path class="body link s{chain.shade}" data-chain="{k}" d="{line(corners, chain.closed)}">'
        yield f"<title>{escape(chain.name)}</title></path>"


def _labels(scene: Scene) -> Iterator[str]:
    size = number(frames(scene)[0].width / 42)
    for label in scene.labels:
        place = f'transform="translate({number(label.x)} {number(label.y)}) scale(1 -1)"'
        yield f'<text {place} font-size="{size}" text-anchor="{label.anchor}">{escape(label.text)}</text>'


def arrow(x: float, y: float, along: float, up: float) -> str:
    """The path of an arrow from a point: its shaft and its head."""
    head = 0.18 * float(np.hypot(along, up))
    if head == 0:
        return f"M{number(x)} {number(y)}"
    end, way = np.array([x + along, y + up]), np.array([along, up]) / np.hypot(along, up)
    back, side = end - head * way, 0.4 * head * np.array([-way[1], way[0]])
    return f"{line(np.array([[x, y], end]), False)}{line(np.array([back + side, end, back - side]), False)}"
