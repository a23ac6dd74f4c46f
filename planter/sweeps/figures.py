"""Figures of sweeps: outputs along each input and over two inputs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers
from planter.report import style
from planter.report.labels import label_axis
from planter.sweeps.plan import Axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PANELS = 3
"""Panels side by side."""
MOST_KINDS = 4
"""Maximum number of texts in a figure."""
SLICES = 24
"""Number of slices of a range with random values, in which rows are averaged over other inputs."""
MARKED, DRAWN_AS_LINES = 61, 2000
"""Number of values up to which each has a marker, and from which a curve is rasterised."""


@dataclass(frozen=True)
class Steps:
    """Abscissae of an output: `values` (k,), the index (m,) of each row among these, and the edges
    (k + 1,) of slices if the values are the centres of slices.
    """

    values: Array
    index: Integers
    edges: Array | None = None

    @property
    def slices(self) -> str:
        """Note of the number of slices for a label, empty without slices."""
        return "" if self.edges is None else f", in {len(self.values)} slices"


@dataclass(frozen=True)
class SweepData:
    """Rows of a sweep: inputs by path, points (m, n); `at_random` if the points are not a grid.

    `meanings` are those of inputs by path and of outputs by name, for the axes.
    """

    inputs: Mapping[str, Axis]
    points: Array
    at_random: bool
    meanings: Mapping[str, str] = field(default_factory=dict)

    def label(self, name: str) -> str:
        """Return the label of an axis: the meaning of an input or an output, or its name, with the
        unit.
        """
        return label_axis(name, self.meanings)

    @property
    def numbers(self) -> list[str]:
        """Names of the numeric inputs with more than one value."""
        return list_numeric_inputs(self.inputs)

    @cached_property
    def kinds(self) -> list[tuple[str, Flags]]:
        """Masks (m,) of the rows of each text of the first input with texts; a mask of all rows
        without one.
        """
        if self._split is None:
            return [("", np.ones(len(self.points), dtype=bool))]
        return [
            (text, self.column(self._split) == i)
            for i, text in enumerate(self.inputs[self._split].texts or ())
        ]

    @property
    def _varied(self) -> list[str]:
        return [name for name, axis in self.inputs.items() if np.ptp(axis.ends) > 0]

    @property
    def _split(self) -> str | None:
        return next((name for name, axis in self.inputs.items() if axis.texts is not None), None)

    def column(self, name: str) -> Array:
        """Return the values (m,) of an input."""
        column: Array = self.points[:, list(self.inputs).index(name)]
        return column

    def has_others(self, name: str) -> bool:
        """Return whether other inputs than this one vary among the rows of one text."""
        return not set(self._varied) <= {name, self._split}

    def steps(self, name: str, averaged: bool) -> Steps:
        """Return the abscissae along an input: its computed values, or slices of its range.

        Random values differ in all rows, so that means over other inputs need slices.
        """
        column, axis = self.column(name), self.inputs[name]
        if averaged and self.at_random and axis.values is None:
            edges = np.linspace(*axis.ends, SLICES + 1)
            index = np.clip(np.searchsorted(edges, column, "right") - 1, 0, SLICES - 1)
            return Steps((edges[1:] + edges[:-1]) / 2, index, edges)
        values, index = np.unique(column, return_inverse=True)
        return Steps(values, index.ravel())


def list_numeric_inputs(inputs: Mapping[str, Axis]) -> list[str]:
    """Return the names of the numeric inputs with more than one value."""
    return [name for name, axis in inputs.items() if axis.texts is None and np.ptp(axis.ends) > 0]


@style.with_style
def draw_envelope(rows: SweepData, output: str, values: Array) -> Figure:
    """Draw an output along each input for each text: computed rows, or mean and extremes over the
    other inputs.
    """
    names, kinds = rows.numbers, rows.kinds[:MOST_KINDS]
    lines, columns = -(-len(names) // PANELS), min(len(names), PANELS)
    figure = style.new_figure(0.3 + 1.9 * lines * len(kinds), min(style.WIDTH, 0.8 + 2.6 * columns))
    panels = figure.subplots(lines * len(kinds), columns, sharey="row", squeeze=False)
    all_steps = {name: rows.steps(name, rows.has_others(name)) for name in names}
    for i, (kind, mask) in enumerate(kinds):
        shared = panels[i * lines : (i + 1) * lines]
        for axes, (name, steps) in zip(shared.ravel(), all_steps.items(), strict=False):
            _curve(axes, steps, mask, values, rows.has_others(name), style.curve_colour(kind, i))
            axes.set_xlabel(f"{rows.label(name)}{steps.slices}")
        for axes in shared[:, 0]:
            axes.set_ylabel(rows.label(output))
        for axes in shared.ravel()[len(names) :]:
            axes.set_visible(False)
        shared[0, 0].set_title(kind)
    figure.legend(
        *panels[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2, frameon=False
    )
    return figure


def _curve(
    axes: Axes, steps: Steps, mask: Flags, values: Array, has_others: bool, shade: str
) -> None:
    """Draw the rows of a mask (m,) along an input; a value without a result is a gap."""
    mask = mask & ~np.isnan(values)
    index, count = steps.index[mask], len(steps.values)
    mean = _means((count,), index, values[mask])
    as_picture = count > DRAWN_AS_LINES
    word = "mean over the other inputs" if has_others else "computed rows"
    if has_others:
        low, high = np.full(count, np.nan), np.full(count, np.nan)
        np.fmin.at(low, index, values[mask])
        np.fmax.at(high, index, values[mask])
        at: Array = steps.values
        if steps.edges is not None:  # a step extends from its edge to the next
            at, low, high = steps.edges, np.append(low, low[-1]), np.append(high, high[-1])
        axes.fill_between(
            at,
            low,
            high,
            step=None if steps.edges is None else "post",
            color=shade,
            alpha=0.2,
            linewidth=0,
            label="minimum to maximum",
            rasterized=as_picture,
        )
    if steps.edges is not None:
        axes.stairs(mean, steps.edges, baseline=None, color=shade, label=word)
    else:
        marker = "." if count <= MARKED else ""
        axes.plot(steps.values, mean, color=shade, marker=marker, label=word, rasterized=as_picture)


def draw_map(rows: SweepData, x: str, y: str, output: str, values: Array) -> Figure | None:
    """Draw the mean of an output over two inputs, a panel for each text; None if no row has a
    result.
    """
    return None if np.isnan(values).all() else _map(rows, x, y, output, values)


@style.with_style
def _map(rows: SweepData, x: str, y: str, output: str, values: Array) -> Figure:
    across, up = rows.steps(x, averaged=True), rows.steps(y, averaged=True)
    kinds, shape = rows.kinds[:MOST_KINDS], (len(up.values), len(across.values))
    figure = style.new_figure(2.8, min(style.WIDTH, 0.5 + 3.6 * len(kinds)))
    panels = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axes, (kind, mask) in zip(panels, kinds, strict=True):
        valid = mask & ~np.isnan(values)
        cells = np.ravel_multi_index((up.index[valid], across.index[valid]), shape)
        field = _means(shape, cells, values[valid])
        edges = (_edges(across), _edges(up))
        mesh = axes.pcolormesh(*edges, field, cmap="cividis", shading="flat", rasterized=True)
        axes.set_xlabel(f"{rows.label(x)}{across.slices}")
        axes.set_title(kind)
        axes.grid(visible=False)
        figure.colorbar(mesh, ax=axes, label=rows.label(output), pad=0.02)
    panels[0].set_ylabel(f"{rows.label(y)}{up.slices}")
    return figure


def _edges(steps: Steps) -> Array:
    """Return the edges (k + 1,) of the cells of a map: midway between computed values, or those of
    the slices.
    """
    if steps.edges is not None:
        return steps.edges
    middles = (steps.values[1:] + steps.values[:-1]) / 2
    first, last = 2 * steps.values[0] - middles[0], 2 * steps.values[-1] - middles[-1]
    edges: Array = np.concatenate([[first], middles, [last]])
    return edges


def _means(shape: tuple[int, ...], cell: Integers, values: Array) -> Array:
    """Return the means of values (m,) in the cells of a table, NaN in empty cells."""
    size = math.prod(shape)
    count, total = np.bincount(cell, minlength=size), np.bincount(cell, values, size)
    means: Array = np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(shape)
    return means
