"""The drawing of a scene at its first moment as SVG; moving elements carry the numbers that a
script refers to.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import count

import numpy as np

from planter.kernels import Array
from planter.report.html import escape_markup
from planter.report.scene import Body, Outline, Point, Scene

EXTENT_MOMENTS = 48
"""Number of moments of a cycle at which the extent of the bodies is measured."""
MARGIN = 0.04
"""Space around a drawing, relative to its width."""
CORNERS = 24
"""Number of points of an outline that are measured for the extent."""
LABEL_SHARE = 32
"""Width of a drawing over the size of its labels, which have at least 7 pt in print."""
STEP, FINE_STEP = 1e-2, 1e-5
"""Rounding of outlines [mm], and of small ones, which can be those of bodies with a scale."""
SMALL = 4.0
"""Extent below which an outline is small [mm]."""
LONGEST = 0.25
"""Length of the largest force, relative to the width of a drawing."""


@dataclass(frozen=True)
class Frame:
    """A rectangle of the plane: its left and bottom edges, width and height [mm]."""

    left: float
    bottom: float
    width: float
    height: float

    @classmethod
    def enclosing(cls, points: Array) -> Frame:
        """Return the frame that encloses points (k, 2) [mm] with a margin."""
        low, high = points.min(axis=0), points.max(axis=0)
        margin = MARGIN * float(max(high - low)) or 1.0
        (left, bottom), (width, height) = low - margin, high - low + 2 * margin
        return cls(float(left), float(bottom), float(width), float(height))

    def __str__(self) -> str:
        """Return the view box of an SVG, whose y axis points down."""
        return " ".join(
            map(format_number, (self.left, -self.bottom - self.height, self.width, self.height))
        )


def draw_picture(scene: Scene) -> str:
    """Return the SVG of a scene."""
    return Picture(scene).text()


class Picture:
    """The SVG drawing of a scene."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.paths = [_path(point, scene.moments) for point in scene.points]

    def text(self) -> str:
        """Return the SVG as text."""
        title, (machine, ground) = escape_markup(self.scene.title), self.frames
        classes = "mechanism toothed" if self.scene.toothed else "mechanism"
        numbers = count()
        return "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" class="{classes}" role="img" '
                f'aria-label="{title}" '
                f'viewBox="{machine}" data-near="{machine}" data-wide="{ground}" '
                f'data-force="{self.force_scale:.6g}">',
                f"<title>{title}</title>",
                '<g transform="scale(1 -1)">',
                *self._ground(),
                "<g data-machine>",
                *self._traces(),
                *(line for body in self.scene.bodies for line in self._body(body, numbers)),
                *self._chains(),
                *self._forces(),
                *self._points(),
                *self._labels(),
                "</g></g></svg>",
            ]
        )

    @cached_property
    def frames(self) -> tuple[Frame, Frame]:
        """Frames of the drawing relative to the machine, and relative to the ground."""
        scene = self.scene
        corners = np.vstack([*self._extent_points(), *self.paths])
        ground = [outline.points for outline in scene.ground]
        if scene.travel is None or not scene.travels:
            frame = Frame.enclosing(np.vstack([corners, *ground]))
            return frame, frame
        shifted = [corners + np.array([x, 0.0]) for x in (scene.travel.min(), scene.travel.max())]
        return Frame.enclosing(corners), Frame.enclosing(np.vstack([*shifted, *ground]))

    @property
    def force_scale(self) -> float:
        """Scale of force arrows [mm/N]."""
        largest = self.scene.largest_force
        return LONGEST * self.frames[0].width / largest if largest else 0.0

    def _extent_points(self) -> Iterator[Array]:
        """Yield corners (k, 2) [mm] of all bodies at some moments of the cycle."""
        moments = slice(None, None, max(1, self.scene.moments // EXTENT_MOMENTS))
        for outline, points in self.scene.placed(moments):
            yield points[:, :: max(1, len(outline.points) // CORNERS)].reshape(-1, 2)

    def _body(self, body: Body, numbers: Iterator[int]) -> Iterator[str]:
        x, y, turn, *scale = (float(channel[0]) for channel in self.scene.pose(body))
        place = f"translate({format_number(x)} {format_number(y)}) rotate({format_number(turn)})"
        stretch = "" if scale == [1.0, 1.0] else f" scale({scale[0]:.6g} {scale[1]:.6g})"
        yield f'<g data-body="{next(numbers)}" transform="{place}{stretch}">'
        yield f"<title>{escape_markup(body.name)}</title>"
        yield from map(_outline, body.outlines)
        for part in body.parts:
            yield from self._body(part, numbers)
        yield "</g>"

    def _ground(self) -> Iterator[str]:
        if self.scene.ground:
            yield "<g data-ground>"
            yield from map(_outline, self.scene.ground)
            yield "</g>"

    def _traces(self) -> Iterator[str]:
        for k, (point, path) in enumerate(zip(self.scene.points, self.paths, strict=True)):
            attributes = (
                f'd="{format_line(path, self.scene.again)}"'
                if point.traced
                else 'visibility="hidden"'
            )
            yield f'<path class="trace" data-trace="{k}" {attributes}/>'

    def _points(self) -> Iterator[str]:
        size = format_number(self.frames[0].width / 160)
        for k, (point, path) in enumerate(zip(self.scene.points, self.paths, strict=True)):
            attributes = (
                f'cx="{format_number(path[0, 0])}" cy="{format_number(path[0, 1])}" r="{size}"'
            )
            yield (
                f'<circle data-point="{k}" '
                f"{attributes}><title>{escape_markup(point.name)}</title></circle>"
            )

    def _chains(self) -> Iterator[str]:
        for k, chain in enumerate(self.scene.chains):
            corners = np.array([self.paths[index][0] for index in chain.points])
            yield (
                f'<path class="body link s{chain.shade}" data-chain="{k}" '
                f'd="{format_line(corners, chain.closed)}">'
            )
            yield f"<title>{escape_markup(chain.name)}</title></path>"

    def _forces(self) -> Iterator[str]:
        for k, force in enumerate(self.scene.forces):
            x, y = _path(force.at, self.scene.moments)[0].tolist()
            path = format_arrow(
                x, y, self.force_scale * float(force.x[0]), self.force_scale * float(force.y[0])
            )
            yield f'<path class="force s{k % 6}" data-arrow="{k}" d="{path}">'
            yield f"<title>{escape_markup(force.name)}</title></path>"

    def _labels(self) -> Iterator[str]:
        size = format_number(self.frames[0].width / LABEL_SHARE)
        for label in self.scene.labels:
            at = f"{format_number(label.x)} {format_number(label.y)}"
            attributes = (
                f'transform="translate({at}) scale(1 -1)" font-size="{size}" '
                f'text-anchor="{label.anchor}"'
            )
            yield f"<text {attributes}>{escape_markup(label.text)}</text>"


def format_number(value: float) -> str:
    """Return a number with at most two decimals, without trailing zeros.

    >>> format_number(12.500001), format_number(-0.001), format_number(30)
    ('12.5', '0', '30')
    """
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def format_line(points: Array, closed: bool) -> str:
    """Return points (k, 2) as the path of an SVG.

    >>> format_line(np.array([[0.0, 1.0], [2.5, 3.0]]), closed=True)
    'M0.00 1.00 2.50 3.00Z'
    """
    steps = " ".join(["%.2f %.2f"] * len(points)) % tuple(points.ravel().tolist())
    return f"M{steps}{'Z' if closed else ''}"


def format_steps(points: Array, closed: bool, step: float = STEP) -> str:
    """Return points (k, 2) as a relative path of an SVG in whole steps, which takes half as many
    characters.

    >>> format_steps(np.array([[0.0, 1.0], [2.5, 3.0], [2.0, 0.0]]), closed=True)
    'm0 100 250 200-50-300z'
    """
    moves = np.diff(np.rint(points / step).astype(int), axis=0, prepend=0)
    return (
        f"m{' '.join(map(str, moves.ravel().tolist())).replace(' -', '-')}{'z' if closed else ''}"
    )


def _outline(outline: Outline) -> str:
    step = STEP if np.ptp(outline.points, axis=0).max() > SMALL else FINE_STEP
    path = format_steps(outline.points, outline.closed, step)
    return f'<path class="{outline.look} s{outline.shade}" transform="scale({step:g})" d="{path}"/>'


def _path(point: Point, moments: int) -> Array:
    """Return the positions of a point at all moments, (n, 2) [mm]."""
    return np.column_stack(
        [np.broadcast_to(np.asarray(v, dtype=float), (moments,)) for v in (point.x, point.y)]
    )


def format_arrow(x: float, y: float, dx: float, dy: float) -> str:
    """Return the path of the shaft and head of an arrow from a point (x, y) by (dx, dy) [mm]."""
    head = 0.18 * float(np.hypot(dx, dy))
    if head == 0:
        return f"M{format_number(x)} {format_number(y)}"
    end, direction = np.array([x + dx, y + dy]), np.array([dx, dy]) / np.hypot(dx, dy)
    back, side = end - head * direction, 0.4 * head * np.array([-direction[1], direction[0]])
    shaft = format_line(np.array([[x, y], end]), False)
    return shaft + format_line(np.array([back + side, end, back - side]), False)
