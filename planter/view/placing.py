"""Where names stand beside a drawing: in a column on either side, none on another, their lines without crossings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from shapely import LineString

from planter.kernels import Array
from planter.report.style import spread


@dataclass(frozen=True)
class Place:
    """Where a name stands: on the right or the left, and how high, in parts of the drawing's height."""

    right: bool
    height: float


def places(anchors: Array, line: float, tall: float) -> list[Place]:
    """A place for each of some points (k, 2) in a drawing from (0, 0) to (1, 1), a `line` apart in each column.

    `tall` is the drawing's height in the unit of a line's, which all names of a column fit into.

    Names go to the side on which their points lie, half of them to either.
    """
    order = np.argsort(anchors[:, 0], kind="stable")
    left = set(order[: len(order) // 2].tolist())
    found: dict[int, Place] = {}
    for right in (False, True):
        own = [index for index in range(len(anchors)) if (index not in left) == right]
        for index, height in zip(own, column(anchors[own], line / tall, 1.0 if right else 0.0), strict=True):
            found[index] = Place(right, height)
    return [found[index] for index in range(len(anchors))]


def column(anchors: Array, gap: float, edge: float) -> list[float]:
    """Heights of a column's names, in the order of their points (k, 2); the lines to the column's edge do not cross.

    Two lines that cross become shorter together when their names change places, so that this comes to an end.
    """
    order = np.argsort(anchors[:, 1], kind="stable")
    heights = np.empty(len(anchors))
    inner = 1 - gap
    if len(anchors):
        wanted = ((anchors[order, 1] - gap / 2) / inner).tolist()
        heights[order] = gap / 2 + inner * np.array(spread(wanted, gap / inner))
    while (pair := crossing(anchors, heights.tolist(), edge)) is not None:
        heights[list(pair)] = heights[list(pair)[::-1]]
    return heights.tolist()


def crossing(anchors: Array, heights: Sequence[float], edge: float) -> tuple[int, int] | None:
    """The first two lines that cross each other, None where none do."""
    lines = [LineString([(edge, height), anchor]) for height, anchor in zip(heights, anchors, strict=True)]
    return next((pair for pair in combinations(range(len(lines)), 2) if lines[pair[0]].crosses(lines[pair[1]])), None)
