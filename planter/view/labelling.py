"""A sheet as a figure: the drawing, its marks, and names beside it with lines to what they name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.report import style
from planter.view.frames import draw
from planter.view.picture import Frame, Picture
from planter.view.placing import Place, places
from planter.view.sheet import Angle, Length, Sheet, Spot
from planter.view.symbols import set_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMN, LETTER = 1.3, 0.06
"""Least width of a column of names, and that of a letter of a long one [inch]."""
LINE = 0.19
"""Height of a name [inch]."""
TALLEST = 8.0
"""Of a drawing [inch]."""
LEAD = 0.06
"""How far names stand from the drawing, in parts of its width."""


@style.drawn
def figure(sheet: Sheet) -> Figure:
    """The drawing of a sheet with all its names."""
    picture, frame = Picture(sheet.scene), _frame(sheet)
    column = max(COLUMN, LETTER * (5 + max(len(name) for mark in sheet.marks for name in mark.names)))
    wide = style.WIDTH - 2 * column
    rows = -(-len(sheet.marks) // 2) + 1
    tall = min(max(wide * frame.height / frame.width, rows * LINE), TALLEST)
    found = style.new_figure(tall, style.WIDTH)
    found.set_layout_engine("none")
    axes = found.add_axes((column / style.WIDTH, 0, wide / style.WIDTH, 1))
    draw(axes, picture, sheet.moment)
    scale = max(frame.width / wide, frame.height / tall)
    (x, y), (half_wide, half_tall) = _middle(frame), (scale * wide / 2, scale * tall / 2)
    axes.set(xlim=(x - half_wide, x + half_wide), ylim=(y - half_tall, y + half_tall))
    _marks(axes, sheet)
    low, size = np.array([x - half_wide, y - half_tall]), 2 * np.array([half_wide, half_tall])
    anchors = np.array([(np.asarray(mark.anchor) - low) / size for mark in sheet.marks])
    for mark, anchor, place in zip(sheet.marks, anchors, places(anchors, LINE, tall), strict=True):
        _name(axes, set_names(mark.names), anchor.tolist(), place)
    return found


def _frame(sheet: Sheet) -> Frame:
    """What there is to be seen at the moment, with the marks."""
    bodies = [points[0] for _, points in sheet.scene.placed(slice(sheet.moment, sheet.moment + 1))]
    return Frame.around(np.vstack([*bodies, *(mark.outline() for mark in sheet.marks)]))


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
            _arrow(axes, mark)


def _arrow(axes: Axes, mark: Angle) -> None:
    """The arc with an arrow at the end of the turn, its sides palely."""
    for leg in mark.legs():
        axes.plot(*leg.T, color=style.SOFT, linewidth=0.4, linestyle=(0, (6, 3)))
    points = mark.outline()
    axes.plot(*points.T, color=style.VERMILION, linewidth=0.9)
    head = {"arrowstyle": "-|>,head_length=0.35,head_width=0.13", "color": style.VERMILION, "linewidth": 0.9,
            "shrinkA": 0, "shrinkB": 0}  # fmt: skip
    axes.annotate("", points[-1], points[-2], arrowprops=head)


def _name(axes: Axes, text: str, anchor: list[float], place: Place) -> None:
    """A name beside the drawing and the line to its point; places are parts of the axes."""
    edge, beyond = (1.0, 1.0 + LEAD) if place.right else (0.0, -LEAD)
    line = [[anchor[0], edge, beyond - (0.01 if place.right else -0.01)], [anchor[1], place.height, place.height]]
    axes.plot(*line, color=style.SOFT, linewidth=0.5, transform=axes.transAxes, clip_on=False)
    axes.plot(*anchor, "o", color=style.SOFT, markersize=1.6, transform=axes.transAxes)
    axes.text(beyond, place.height, text, transform=axes.transAxes, va="center",
              ha="left" if place.right else "right", fontsize=8.5 if "$" in text else 7)  # fmt: skip
