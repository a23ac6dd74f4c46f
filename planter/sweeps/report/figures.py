"""What a sweep found, drawn: outputs along each input, and over two of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from planter.files.paths import last_part
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers
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
"""Slices of a range whose values are drawn at random, over which several inputs are averaged."""
MARKED, DRAWN_AS_LINES = 61, 2000
"""Values up to which each has a mark, and beyond which a curve is a picture in a file of lines."""


@dataclass(frozen=True)
class Steps:
    """Where an output is drawn along an input: `values` (k,), the index (m,) of each row among these, and the edges
    (k + 1,) of the slices, if the values are the middles of slices.
    """

    values: Array
    index: Integers
    edges: Array | None = None

    @property
    def slices(self) -> str:
        return "" if self.edges is None else f", in {len(self.values)} slices"


@dataclass(frozen=True)
class Drawn:
    """The rows of a sweep: inputs by path, points (m, n); `at_random` if no grid of values was computed."""

    inputs: Mapping[str, Axis]
    points: Array
    at_random: bool

    @property
    def numbers(self) -> list[str]:
        """Inputs that are numbers and take more than one."""
        return [name for name in self._varied if self.inputs[name].texts is None]

    @cached_property
    def kinds(self) -> list[tuple[str, Flags]]:
        """The rows of each text that the first input of texts takes; all rows if there is none."""
        if self._split is None:
            return [("", np.ones(len(self.points), dtype=bool))]
        return [(text, self.column(self._split) == i) for i, text in enumerate(self.inputs[self._split].texts or ())]

    @property
    def _varied(self) -> list[str]:
        return [name for name, axis in self.inputs.items() if np.ptp(axis.ends) > 0]

    @property
    def _split(self) -> str | None:
        return next((name for name, axis in self.inputs.items() if axis.texts is not None), None)

    def column(self, name: str) -> Array:
        found: Array = self.points[:, list(self.inputs).index(name)]
        return found

    def has_others(self, name: str) -> bool:
        """Whether rows of one text differ in more than this input."""
        return not set(self._varied) <= {name, self._split}

    def steps(self, name: str, averaged: bool) -> Steps:
        """Where outputs are drawn along an input: at every computed value.

        A row at random is alone at its value: to be averaged over other inputs it shares a slice of the range.
        """
        column, axis = self.column(name), self.inputs[name]
        if averaged and self.at_random and axis.values is None:
            edges = np.linspace(*axis.ends, SLICES + 1)
            index = np.clip(np.searchsorted(edges, column, "right") - 1, 0, SLICES - 1)
            return Steps((edges[1:] + edges[:-1]) / 2, index, edges)
        values, index = np.unique(column, return_inverse=True)
        return Steps(values, index.ravel())


@style.drawn
def envelope(rows: Drawn, output: str, values: Array) -> Figure:
    """An output along each input, for each text separately: the computed rows; over other inputs mean and extremes."""
    names, kinds = rows.numbers, rows.kinds[:MOST_KINDS]
    lines, columns = -(-len(names) // PANELS), min(len(names), PANELS)
    figure = style.new_figure(0.3 + 1.9 * lines * len(kinds), min(style.WIDTH, 0.8 + 2.6 * columns))
    panels = figure.subplots(lines * len(kinds), columns, sharey="row", squeeze=False)
    every = {name: rows.steps(name, rows.has_others(name)) for name in names}
    for i, (kind, of) in enumerate(kinds):
        shared = panels[i * lines : (i + 1) * lines]
        for axes, (name, steps) in zip(shared.ravel(), every.items(), strict=False):
            _curve(axes, steps, of, values, rows.has_others(name), style.colour(kind, i))
            axes.set_xlabel(f"{_called(name)}{steps.slices}")
        for axes in shared[:, 0]:
            axes.set_ylabel(_called(output))
        for axes in shared.ravel()[len(names) :]:
            axes.set_visible(False)
        shared[0, 0].set_title(kind)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2, frameon=False)
    return figure


def _called(path: str) -> str:
    return label(last_part(path))


def _curve(axes: Axes, steps: Steps, of: Flags, values: Array, has_others: bool, shade: str) -> None:
    """The rows `of` a text along an input; a value without a result is a gap."""
    of = of & ~np.isnan(values)
    index, count = steps.index[of], len(steps.values)
    mean = _means((count,), index, values[of])
    as_picture = count > DRAWN_AS_LINES
    word = "mean over the other inputs" if has_others else "computed rows"
    if has_others:
        low, high = np.full(count, np.nan), np.full(count, np.nan)
        np.fmin.at(low, index, values[of])
        np.fmax.at(high, index, values[of])
        at: Array = steps.values
        if steps.edges is not None:  # each value reaches from its edge to the next
            at, low, high = steps.edges, np.append(low, low[-1]), np.append(high, high[-1])
        axes.fill_between(
            at, low, high, step=None if steps.edges is None else "post", color=shade, alpha=0.2, linewidth=0,
            label="least to largest", rasterized=as_picture,
        )  # fmt: skip
    if steps.edges is not None:
        axes.stairs(mean, steps.edges, baseline=None, color=shade, label=word)
    else:
        marker = "." if count <= MARKED else ""
        axes.plot(steps.values, mean, color=shade, marker=marker, label=word, rasterized=as_picture)


def mapped(rows: Drawn, x: str, y: str, output: str, values: Array) -> Figure | None:
    """The mean of an output over two inputs, a panel for each text; None if no row has a result."""
    return None if np.isnan(values).all() else _map(rows, x, y, output, values)


@style.drawn
def _map(rows: Drawn, x: str, y: str, output: str, values: Array) -> Figure:
    across, up = rows.steps(x, averaged=True), rows.steps(y, averaged=True)
    kinds, shape = rows.kinds[:MOST_KINDS], (len(up.values), len(across.values))
    figure = style.new_figure(2.8, min(style.WIDTH, 0.5 + 3.6 * len(kinds)))
    panels = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axes, (kind, of) in zip(panels, kinds, strict=True):
        there = of & ~np.isnan(values)
        cells = np.ravel_multi_index((up.index[there], across.index[there]), shape)
        field = _means(shape, cells, values[there])
        edges = (_edges(across), _edges(up))
        shown = axes.pcolormesh(*edges, field, cmap="cividis", shading="flat", rasterized=True)
        axes.set_xlabel(f"{_called(x)}{across.slices}")
        axes.set_title(kind)
        axes.grid(visible=False)
        figure.colorbar(shown, ax=axes, label=_called(output), pad=0.02)
    panels[0].set_ylabel(f"{_called(y)}{up.slices}")
    return figure


def _edges(steps: Steps) -> Array:
    """Edges (k + 1,) of the cells of a map: half way between computed values, or those of the slices."""
    if steps.edges is not None:
        return steps.edges
    middles = (steps.values[1:] + steps.values[:-1]) / 2
    first, last = 2 * steps.values[0] - middles[0], 2 * steps.values[-1] - middles[-1]
    found: Array = np.concatenate([[first], middles, [last]])
    return found


def _means(shape: tuple[int, ...], cell: Integers, values: Array) -> Array:
    """Means of values (m,) in the cells of a table, NaN in empty ones."""
    size = math.prod(shape)
    count, total = np.bincount(cell, minlength=size), np.bincount(cell, values, size)
    found: Array = np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(shape)
    return found


def pairs(names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """The first two inputs, where there are two."""
    if len(names) > 1:
        yield names[0], names[1]
