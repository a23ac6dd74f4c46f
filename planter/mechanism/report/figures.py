"""Curves of many quantities: those of one unit together, a few in a figure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.report import style
from planter.report.labels import name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.mechanism.turn import Turn

MOST_CURVES = 6
"""Curves in one figure."""


@dataclass(frozen=True)
class Course:
    """What curves are drawn over: values (n,), their name with its unit, and whether they are angles of a turn.

    Of a turn `end` is its last angle, `ends` are the curves' values there by key, and `repeats` says whether it ends as
    it began.
    """

    values: Array
    label: str
    turn: bool
    ends: Mapping[str, float] = field(default_factory=dict)
    repeats: bool = False
    end: float = 360.0

    @classmethod
    def from_cycle(cls, cycle: Turn) -> Course:
        """Return what the curves of a cycle are drawn over."""
        end = float(np.degrees(cycle.machine.turn))
        return cls(cycle.angles_deg, f"{cycle.machine.angle} / deg", True, cycle.ends, cycle.repeats, end)


def curves(columns: Mapping[str, Array], course: Course) -> Iterator[tuple[str, Figure]]:
    """Figures of all columns, by the names of their files."""
    by_unit: dict[str, list[str]] = {}
    for key in columns:
        by_unit.setdefault(units.unit(key), []).append(key)
    for unit, keys in by_unit.items():
        for first in range(0, len(keys), MOST_CURVES):
            some = {key: columns[key] for key in keys[first : first + MOST_CURVES]}
            word = "".join(c if c.isalnum() else "_" for c in unit or "number")
            yield f"{word}_{first // MOST_CURVES + 1}", _figure(some, unit, course)


@style.drawn
def _figure(columns: Mapping[str, Array], unit: str, course: Course) -> Figure:
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    if course.turn:
        style.over_a_turn(axes, end=course.end)
    axes.set_xlabel(course.label)
    axes.set_ylabel(unit or "1")
    ends = []
    for index, (key, values) in enumerate(columns.items()):
        shade = style.colour(key, index)
        x, y = _with_end(course, key, values)
        axes.plot(x, y, color=shade, linewidth=1.2)
        ends.append((float(y[-1]), name(key), shade))
    if not course.turn:
        axes.set_xlim(course.values[0], course.values[-1])
    axes.autoscale_view()
    style.label_ends(axes, ends, 0.07)
    return figure


def _with_end(course: Course, key: str, values: Array) -> tuple[Array, Array]:
    """A curve (n,), of a turn with its value at the end, as far as that is known."""
    if key not in course.ends:
        return course.values, values
    return np.append(course.values, course.end), np.append(values, course.ends[key])
