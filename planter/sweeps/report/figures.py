"""What a sweep found, drawn: outputs along each input, and over two of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planter.files.paths import last_part
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.report import style
from planter.report.labels import label
from planter.sweeps.axes import Axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANELS = 3
"""Panels side by side."""
MOST_KINDS = 4
"""Texts that are drawn."""
SLICES = 24
"""Slices of an input that has more values than that."""


@dataclass(frozen=True)
class Drawn:
    """The rows of a sweep: inputs by path, points (m, n), and of an output its values (m,)."""

    inputs: Mapping[str, Axis]
    points: Array

    @property
    def numbers(self) -> list[str]:
        """Inputs that are numbers and take more than one."""
        return [name for name, axis in self.inputs.items() if axis.texts is None and np.ptp(axis.ends) > 0]

    @property
    def kinds(self) -> list[tuple[str, Array]]:
        """The rows of each text that the first input of texts takes; all rows where there is none."""
        for index, axis in enumerate(self.inputs.values()):
            if axis.texts is not None:
                return [(text, self.points[:, index] == place) for place, text in enumerate(axis.texts)]
        return [("", np.ones(len(self.points), dtype=bool))]

    def column(self, name: str) -> Array:
        found: Array = self.points[:, list(self.inputs).index(name)]
        return found

    def steps(self, name: str) -> tuple[Array, Integers]:
        """Where an output is drawn along an input (k,), and the place (m,) of each row among these."""
        column = self.column(name)
        values, place = np.unique(column, return_inverse=True)
        if len(values) <= SLICES:
            return values, place
        edges = np.linspace(*self.inputs[name].ends, SLICES + 1)
        return (edges[1:] + edges[:-1]) / 2, np.clip(np.searchsorted(edges, column, "right") - 1, 0, SLICES - 1)


@style.drawn
def envelope(rows: Drawn, output: str, values: Array) -> Figure:
    """An output along each input, for each text by itself: least, mean and largest over all others."""
    names, kinds = rows.numbers, rows.kinds[:MOST_KINDS]
    lines, columns = -(-len(names) // PANELS), min(len(names), PANELS)
    figure = style.new_figure(0.3 + 1.9 * lines * len(kinds), min(style.WIDTH, 0.8 + 2.6 * columns))
    panels = figure.subplots(lines * len(kinds), columns, sharey="row", squeeze=False)
    for index, (kind, of) in enumerate(kinds):
        own = panels[index * lines : (index + 1) * lines]
        for axes, name in zip(own.ravel(), names, strict=False):
            at, place = rows.steps(name)
            _band(axes, at, place[of], values[of], style.colour(kind, index))
            axes.set_xlabel(_called(name))
        for axes in own[:, 0]:
            axes.set_ylabel(_called(output))
        for axes in own.ravel()[len(names) :]:
            axes.set_visible(False)
        own[0, 0].set_title(kind)
    return figure


def _called(path: str) -> str:
    return label(last_part(path))


def _band(axes: Axes, at: Array, place: Integers, values: Array, shade: str) -> None:
    there = ~np.isnan(values)
    place, values = place[there], values[there]
    held = np.unique(place)
    if not len(held):
        return
    low, high = np.full(len(at), np.inf), np.full(len(at), -np.inf)
    np.minimum.at(low, place, values)
    np.maximum.at(high, place, values)
    mean = np.bincount(place, values, len(at))[held] / np.bincount(place, minlength=len(at))[held]
    axes.fill_between(at[held], low[held], high[held], color=shade, alpha=0.2, linewidth=0)
    axes.plot(at[held], mean, color=shade, marker="." if len(held) <= SLICES else "")


def mapped(rows: Drawn, x: str, y: str, output: str, values: Array) -> Figure | None:
    """The mean of an output over two inputs, a panel for each text; None where no row has a result."""
    return None if np.isnan(values).all() else _map(rows, x, y, output, values)


@style.drawn
def _map(rows: Drawn, x: str, y: str, output: str, values: Array) -> Figure:
    (across, column), (up, line) = rows.steps(x), rows.steps(y)
    kinds = rows.kinds[:MOST_KINDS]
    figure = style.new_figure(2.8, min(style.WIDTH, 0.5 + 3.6 * len(kinds)))
    panels = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axes, (kind, of) in zip(panels, kinds, strict=True):
        field = _means((len(up), len(across)), line[of], column[of], values[of])
        shown = axes.pcolormesh(across, up, field, cmap="cividis", shading="nearest", rasterized=True)
        axes.set_xlabel(_called(x))
        axes.set_title(kind)
        axes.grid(visible=False)
        figure.colorbar(shown, ax=axes, label=_called(output), pad=0.02)
    panels[0].set_ylabel(_called(y))
    return figure


def _means(shape: tuple[int, int], line: Integers, column: Integers, values: Array) -> Array:
    """Means of values (m,) in the cells of a table, NaN in empty ones."""
    there = ~np.isnan(values)
    cell, size = (line * shape[1] + column)[there], shape[0] * shape[1]
    count = np.bincount(cell, minlength=size)
    total = np.bincount(cell, values[there], size)
    found: Array = np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(shape)
    return found


def pairs(names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """The first two inputs, where there are two."""
    if len(names) > 1:
        yield names[0], names[1]
