"""Texts of a figure as they are drawn: those that overlap, and those that its edges cut."""

from __future__ import annotations

import itertools
from unittest import mock

import shapely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from shapely.affinity import rotate

from planter.report import style

MARGIN = 0.8
"""Width that every box loses on each side [pixel]: letters do not fill it."""


def find_text_faults(figure: Figure) -> list[str]:
    """Return the pairs of texts of a figure that overlap, and the texts that reach beyond its
    edges.
    """
    style.fix_layout(figure)
    boxes = _draw_boxes(figure)
    faults = [
        f"{text.get_text()!r} overlaps {other.get_text()!r}"
        for (text, box), (other, other_box) in itertools.combinations(boxes.items(), 2)
        if box.intersects(other_box)
    ]
    sheet = shapely.box(*figure.bbox.extents)
    return faults + [
        f"{text.get_text()!r} is cut" for text, box in boxes.items() if not sheet.contains(box)
    ]


@style.with_style
def _draw_boxes(figure: Figure) -> dict[Text, shapely.Polygon]:
    """Draw a figure, and return each text that is drawn with the box of its letters [pixel]."""
    texts: dict[Text, None] = {}
    draw = Text.draw

    def record(text: Text, renderer: object) -> None:
        if text.get_visible() and text.get_text().strip():
            texts[text] = None
        draw(text, renderer)

    canvas = FigureCanvasAgg(figure)
    with mock.patch.object(Text, "draw", record):
        canvas.draw()
    return {text: _find_box(text, canvas.get_renderer()) for text in texts}


def _find_box(text: Text, renderer: object) -> shapely.Polygon:
    """Return the box of a text, rotated as it is."""
    angle, outer = text.get_rotation(), Text.get_window_extent(text, renderer)
    text.set_rotation(0)
    upright = Text.get_window_extent(text, renderer)
    text.set_rotation(angle)
    x, y = (outer.x0 + outer.x1) / 2, (outer.y0 + outer.y1) / 2
    width, height = (max(size / 2 - MARGIN, 0.1) for size in (upright.width, upright.height))
    return rotate(shapely.box(x - width, y - height, x + width, y + height), angle)
