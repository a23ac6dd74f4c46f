"""Drawings with symbols: a scene at one moment, with named points, lengths and angles, and their
names next to it.

Lengths in mm, angles in deg, y upwards, as in a scene.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from shapely import LineString

from planter.files import units
from planter.kernels import Array
from planter.report import style
from planter.report.animation import draw
from planter.report.picture import Frame, Picture
from planter.report.scene import Body, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


CORNERS = 121
"""Number of points of an arc."""
_EXTENT = 1e-9
"""Length below which a direction is undefined [mm]."""


@dataclass(frozen=True)
class Spot:
    """A point (2,) [mm], named by its coordinates."""

    names: Sequence[str]
    at: Array

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the names."""
        return self.at

    def outline(self) -> Array:
        """Return the point (1, 2) [mm]."""
        return np.array([self.at])


@dataclass(frozen=True)
class Length:
    """The distance of two points (2,) [mm]; the line to its names ends at a `share` of it."""

    names: Sequence[str]
    start: Array
    end: Array
    share: float = 0.5

    @property
    def size(self) -> float:
        """Length [mm]."""
        return float(np.hypot(*(np.asarray(self.end) - self.start)))

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the names."""
        return (1 - self.share) * np.asarray(self.start) + self.share * np.asarray(self.end)

    def outline(self) -> Array:
        """Return the end points (2, 2) [mm]."""
        return np.array([self.start, self.end])


@dataclass(frozen=True)
class Angle:
    """An angle [deg] about a vertex (2,) [mm] from a direction, positive anticlockwise, drawn at a
    radius.
    """

    names: Sequence[str]
    vertex: Array
    start: float
    turn: float
    radius: float

    @classmethod
    def between(
        cls, names: Sequence[str], vertex: Array, start: Array, end: Array, radius: float
    ) -> Angle:
        """Return the angle of at most 180 deg from the direction of point `start` (2,) to that of
        `end`.
        """
        first, second = (direction_angle(vertex, point) for point in (start, end))
        return cls(names, vertex, first, (second - first + 180) % 360 - 180, radius)

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the names."""
        return self._points(np.array([self.start + self.turn / 2]))[0]

    def outline(self) -> Array:
        """Return the points (k, 2) [mm] of the arc."""
        return self._points(self.start + np.linspace(0, self.turn, CORNERS))

    def legs(self) -> tuple[Array, Array]:
        """Return both legs from the vertex to slightly beyond the arc, (2, 2) [mm] each."""
        ends = self.vertex + 1.15 * (
            self._points(np.array([self.start, self.start + self.turn])) - self.vertex
        )
        return np.array([self.vertex, ends[0]]), np.array([self.vertex, ends[1]])

    def _points(self, directions: Array) -> Array:
        angles = np.radians(directions)
        return np.asarray(self.vertex) + self.radius * np.column_stack(
            [np.cos(angles), np.sin(angles)]
        )


@dataclass(frozen=True)
class Arrow:
    """A force at a point (2,) [mm], drawn as a `vector` (2,) [mm], with a text of its own."""

    names: Sequence[str]
    at: Array
    vector: Array
    text: str
    colour: str

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the text."""
        return np.asarray(self.at) + 0.7 * np.asarray(self.vector)

    def outline(self) -> Array:
        """Return both ends (2, 2) [mm]."""
        return np.array([self.at, np.asarray(self.at) + self.vector])


@dataclass(frozen=True)
class Couple:
    """A moment about a point (2,) [mm], drawn as an arc by an angle `turn` [deg] with a text of its
    own.
    """

    names: Sequence[str]
    at: Array
    turn: float
    radius: float
    text: str
    colour: str

    @property
    def anchor(self) -> Array:
        """End (2,) [mm] of the line to the text."""
        return self.outline()[CORNERS // 2]

    def outline(self) -> Array:
        """Return the points (k, 2) [mm] of the arc."""
        angles = np.radians(90.0 - self.turn / 2 + np.linspace(0, self.turn, CORNERS))
        arc = np.column_stack([np.cos(angles), np.sin(angles)])
        return np.asarray(self.at) + self.radius * arc


Mark = Spot | Length | Angle | Arrow | Couple


def label_mark(mark: Mark) -> str:
    """Return the text of a mark: its own, or its names for mathtext."""
    return mark.text if isinstance(mark, Arrow | Couple) else set_names(mark.names)


def direction_angle(start: Array, end: Array) -> float:
    """Return the direction from point `start` (2,) to `end` (2,) [deg]."""
    dx, dy = np.asarray(end) - start
    assert np.hypot(dx, dy) > _EXTENT
    return float(np.degrees(np.arctan2(dy, dx)))


def build_still_scene(title: str, bodies: Sequence[Body]) -> Scene:
    """Return a scene of bodies that do not move."""
    return Scene(title, "", "", np.zeros(1), 1.0, bodies, again=False)


@dataclass(frozen=True)
class Sheet:
    """A drawing of a scene at one moment, with marks."""

    name: str
    title: str
    scene: Scene
    marks: Sequence[Mark]
    moment: int = 0

    @property
    def names(self) -> set[str]:
        """Names of all marks."""
        return {name for mark in self.marks for name in mark.names}


COLUMN, LETTER = 1.3, 0.06
"""Minimum width of a column of names, and width of a letter of a long name [inch]."""
LINE = 0.19
"""Height of a name [inch]."""
TALLEST = 8.0
"""Maximum height of a drawing [inch]."""
LEAD = 0.06
"""Distance of names from the drawing, relative to its width."""
GREEK = (
    "alpha",
    "beta",
    "gamma",
    "delta",
    "epsilon",
    "theta",
    "lambda",
    "mu",
    "nu",
    "xi",
    "rho",
    "sigma",
    "tau",
    "phi",
    "psi",
    "omega",
    "Delta",
    "Theta",
    "Phi",
    "Psi",
    "Omega",
)
_NAME = re.compile(rf"({'|'.join(GREEK)}|[A-Za-z])_?(\d*|(?<=_).+)$")
_SHAPES = {"phi": "varphi", "epsilon": "varepsilon"}


@dataclass(frozen=True)
class LabelPosition:
    """Position of a name: its side, and its height relative to the height of the drawing."""

    right: bool
    height: float


@style.with_style
def draw_figure(sheet: Sheet) -> Figure:
    """Return the drawing of a sheet with all its names."""
    picture, frame = Picture(sheet.scene), _frame(sheet)
    column = max(
        COLUMN, LETTER * (5 + max(len(text) for mark in sheet.marks for text in _list_texts(mark)))
    )
    wide = style.WIDTH - 2 * column
    rows = -(-len(sheet.marks) // 2) + 1
    tall = min(max(wide * frame.height / frame.width, rows * LINE), TALLEST)
    labelled = style.new_figure(tall, style.WIDTH)
    labelled.set_layout_engine("none")
    axes = labelled.add_axes((column / style.WIDTH, 0, wide / style.WIDTH, 1))
    draw(axes, picture, sheet.moment)
    scale = max(frame.width / wide, frame.height / tall)
    (x, y), (half_wide, half_tall) = _middle(frame), (scale * wide / 2, scale * tall / 2)
    axes.set(xlim=(x - half_wide, x + half_wide), ylim=(y - half_tall, y + half_tall))
    _marks(axes, sheet)
    low, size = np.array([x - half_wide, y - half_tall]), 2 * np.array([half_wide, half_tall])
    anchors = np.array([(np.asarray(mark.anchor) - low) / size for mark in sheet.marks])
    for mark, anchor, position in zip(
        sheet.marks, anchors, place_labels(anchors, LINE, tall), strict=True
    ):
        _name(axes, label_mark(mark), anchor.tolist(), position)
    return labelled


def _list_texts(mark: Mark) -> Sequence[str]:
    """Return what stands in the column of a mark, without the signs of mathtext."""
    return [re.sub(r"[$_{}]", "", mark.text)] if isinstance(mark, Arrow | Couple) else mark.names


def _frame(sheet: Sheet) -> Frame:
    """Return the frame of the scene at the moment of the sheet, including the marks."""
    bodies = [points[0] for _, points in sheet.scene.placed(slice(sheet.moment, sheet.moment + 1))]
    return Frame.enclosing(np.vstack([*bodies, *(mark.outline() for mark in sheet.marks)]))


def _middle(frame: Frame) -> tuple[float, float]:
    return frame.left + frame.width / 2, frame.bottom + frame.height / 2


def _marks(axes: Axes, sheet: Sheet) -> None:
    for mark in sheet.marks:
        points = mark.outline()
        if isinstance(mark, Spot):
            axes.plot(*points.T, "o", color=style.INK, markersize=2.5)
        elif isinstance(mark, Length):
            axes.plot(*points.T, "-", color=style.INK, linewidth=0.9, marker="|", markersize=5)
        elif isinstance(mark, Angle):
            for leg in mark.legs():
                axes.plot(*leg.T, color=style.SOFT, linewidth=0.4, linestyle=(0, (6, 3)))
            _arrow(axes, points, style.VERMILION, 0.9)
        elif isinstance(mark, Arrow | Couple):
            _arrow(axes, points, mark.colour, 1.4)
            axes.plot(*np.asarray(mark.at), "o", color=style.INK, markersize=2.5)


def _arrow(axes: Axes, points: Array, colour: str, width: float) -> None:
    """Draw a line through points (k, 2) [mm] with an arrow at its end."""
    axes.plot(*points.T, color=colour, linewidth=width)
    head = {
        "arrowstyle": "-|>,head_length=0.35,head_width=0.13",
        "color": colour,
        "linewidth": width,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    axes.annotate("", points[-1], points[-2], arrowprops=head)


def _name(axes: Axes, text: str, anchor: list[float], position: LabelPosition) -> None:
    """Draw a name at the side of the drawing and the line to its anchor, in axes coordinates."""
    edge, beyond = (1.0, 1.0 + LEAD) if position.right else (0.0, -LEAD)
    gap = 0.01 if position.right else -0.01
    line = [[anchor[0], edge, beyond - gap], [anchor[1], position.height, position.height]]
    axes.plot(*line, color=style.SOFT, linewidth=0.5, transform=axes.transAxes, clip_on=False)
    axes.plot(*anchor, "o", color=style.SOFT, markersize=1.6, transform=axes.transAxes)
    axes.text(
        beyond,
        position.height,
        text,
        transform=axes.transAxes,
        va="center",
        ha="left" if position.right else "right",
        fontsize=8.5 if "$" in text else 7,
    )


def place_labels(anchors: Array, line: float, tall: float) -> list[LabelPosition]:
    """Return positions for labels of anchors (k, 2) in a drawing from (0, 0) to (1, 1), half of
    them at either side.

    Labels of a column are at least a `line` apart, where `tall` is the height of the drawing in the
    same unit.
    """
    order = np.argsort(anchors[:, 0], kind="stable")
    left = set(order[: len(order) // 2].tolist())
    positions: dict[int, LabelPosition] = {}
    for right in (False, True):
        side = [index for index in range(len(anchors)) if (index not in left) == right]
        for index, height in zip(
            side, arrange_column(anchors[side], line / tall, 1.0 if right else 0.0), strict=True
        ):
            positions[index] = LabelPosition(right, height)
    return [positions[index] for index in range(len(anchors))]


def arrange_column(anchors: Array, gap: float, edge: float) -> list[float]:
    """Return heights of a column's labels in the order of anchors (k, 2), so that no lines to
    `edge` cross.

    Exchanging the labels of two crossing lines shortens both together, so that the iteration ends.
    """
    order = np.argsort(anchors[:, 1], kind="stable")
    heights = np.empty(len(anchors))
    inner = 1 - gap
    if len(anchors):
        targets = ((anchors[order, 1] - gap / 2) / inner).tolist()
        heights[order] = gap / 2 + inner * np.array(style.spread_heights(targets, gap / inner))
    while (pair := find_crossing(anchors, heights.tolist(), edge)) is not None:
        heights[list(pair)] = heights[list(pair)[::-1]]
    return heights.tolist()


def find_crossing(anchors: Array, heights: Sequence[float], edge: float) -> tuple[int, int] | None:
    """Return the indices of the first two lines that cross, or None if no lines cross."""
    lines = [
        LineString([(edge, height), anchor])
        for height, anchor in zip(heights, anchors, strict=True)
    ]
    return next(
        (
            pair
            for pair in combinations(range(len(lines)), 2)
            if lines[pair[0]].crosses(lines[pair[1]])
        ),
        None,
    )


def set_name(name: str) -> str:
    """Return a name for Matplotlib's mathtext: a letter with its index and without a unit, or the
    word itself.

    >>> set_name("phi52"), set_name("x_A1"), set_name("circumradius"), set_name("x_tip_machine")
    ('$\\\\varphi_{52}$', '$x_{A1}$', 'circumradius', '$x_{tip,machine}$')
    >>> set_name("phi_deg"), set_name("cell_top_mm")
    ('$\\\\varphi$', 'cell_top_mm')
    """
    match = _NAME.match(name.removesuffix(units.unit_suffix(name)))
    if match is None:
        return name
    letter, index = match.groups()
    base = f"\\{_SHAPES.get(letter, letter)}" if letter in GREEK else letter
    return f"${base}_{{{index.replace('_', ',')}}}$" if index else f"${base}$"


def set_names(names: Sequence[str]) -> str:
    """Return distinct names for mathtext, separated by commas."""
    return ", ".join(dict.fromkeys(map(set_name, names)))
