"""Figures of sweeps: outputs along each input and over two inputs.

Of a grid these are means and extremes over the other inputs; random points are drawn one by one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array, Flags, Integers
from planter.report import style
from planter.report.labels import label_axis
from planter.rows.sweeps.plan import Axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PANELS = 3
"""Panels side by side."""
MOST_KINDS = 4
"""Maximum number of texts in a figure."""
MARKED, DRAWN_AS_LINES = 61, 2000
"""Number of values up to which each has a marker, and from which a curve is rasterised."""


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
        name = next((name for name, axis in self.inputs.items() if axis.texts is not None), None)
        if name is None:
            return [("", np.ones(len(self.points), dtype=bool))]
        column = self.column(name)
        return [(text, column == i) for i, text in enumerate(self.inputs[name].texts or ())]

    def column(self, name: str) -> Array:
        """Return the values (m,) of an input."""
        column: Array = self.points[:, list(self.inputs).index(name)]
        return column


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
    for i, (kind, mask) in enumerate(kinds):
        shared = panels[i * lines : (i + 1) * lines]
        for axes, name in zip(shared.ravel(), names, strict=False):
            has_result = mask & (~np.isnan(values) | (not rows.at_random))
            _draw_curve(axes, rows, name, has_result, values, style.curve_colour(kind, i))
            axes.set_xlabel(rows.label(name))
        for axes in shared[:, 0]:
            axes.set_ylabel(rows.label(output))
        for axes in shared.ravel()[len(names) :]:
            axes.set_visible(False)
        shared[0, 0].set_title(kind)
    style.add_legend(figure, panels[0, 0], 2)
    return figure


def _draw_curve(
    axes: Axes, rows: SweepData, name: str, mask: Flags, values: Array, shade: str
) -> None:
    """Draw the rows of a mask (m,) along an input; a value without a result is a gap."""
    column = rows.column(name)[mask]
    if rows.at_random:
        axes.plot(
            column, values[mask], ".", color=shade, markersize=2, label="rows", rasterized=True
        )
        return
    at, places = np.unique(column, return_inverse=True)
    mean, low, high = _reduce(places.ravel(), values[mask], len(at))
    as_picture = len(at) > DRAWN_AS_LINES
    has_others = len(at) < len(column)
    if has_others:
        axes.fill_between(
            at,
            low,
            high,
            color=shade,
            alpha=0.2,
            linewidth=0,
            label="minimum to maximum",
            rasterized=as_picture,
        )
    word = "mean over the other inputs" if has_others else "computed rows"
    marker = "." if len(at) <= MARKED else ""
    axes.plot(at, mean, color=shade, marker=marker, label=word, rasterized=as_picture)


def draw_map(rows: SweepData, x: str, y: str, output: str, values: Array) -> Figure | None:
    """Draw an output over two inputs, a panel for each text: means of a grid, or random points;
    None if no row has a result.
    """
    return None if np.isnan(values).all() else _draw_panels(rows, x, y, output, values)


@style.with_style
def _draw_panels(rows: SweepData, x: str, y: str, output: str, values: Array) -> Figure:
    kinds = rows.kinds[:MOST_KINDS]
    figure = style.new_figure(2.8, min(style.WIDTH, 0.5 + 3.6 * len(kinds)))
    panels = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axes, (kind, mask) in zip(panels, kinds, strict=True):
        across, up, cell_values = rows.column(x)[mask], rows.column(y)[mask], values[mask]
        if rows.at_random:
            mesh = axes.scatter(across, up, 4, cell_values, cmap="cividis", rasterized=True)
        else:
            places, cells = np.unique(np.column_stack([up, across]), axis=0, return_inverse=True)
            heights, widths = np.unique(places[:, 0]), np.unique(places[:, 1])
            means = _reduce(cells.ravel(), cell_values, len(places))[0]
            grid = means.reshape(len(heights), len(widths))
            mesh = axes.pcolormesh(
                widths, heights, grid, cmap="cividis", shading="nearest", rasterized=True
            )
        axes.set_xlabel(rows.label(x))
        axes.set_title(kind)
        axes.grid(visible=False)
        figure.colorbar(mesh, ax=axes, label=rows.label(output), pad=0.02)
    panels[0].set_ylabel(rows.label(y))
    return figure


def _reduce(places: Integers, values: Array, count: int) -> tuple[Array, Array, Array]:
    """Return mean, minimum and maximum (k,) of values (m,) at places (m,) from 0 on, NaN without
    one.
    """
    valid = ~np.isnan(values)
    places, values = places[valid], values[valid]
    counts = np.bincount(places, minlength=count)
    mean = np.full(count, np.nan)
    total = np.bincount(places, values, count)
    np.divide(total, counts, out=mean, where=counts > 0)
    low, high = np.full(count, np.nan), np.full(count, np.nan)
    np.fmin.at(low, places, values)
    np.fmax.at(high, places, values)
    return mean, low, high
