"""Figures of tolerances: distributions of outputs, Sobol' indices, bands over a cycle and paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.files.paths import last_part
from planter.kernels import Array
from planter.report import style
from planter.report.labels import format_label
from planter.tolerance.results import Band, Share, rank_shares

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PANELS = 3
BARS = 8
"""Maximum number of inputs in the figure of an output."""
BINS = 60
MIN_TOTAL = 0.005
"""Total index above which an input is in the figure."""
PATHS = 100
"""Maximum number of machines with a path in the figure."""


@style.with_style
def draw_distributions(outputs: Mapping[str, Band], rows: Array) -> Figure:
    """Draw histograms of the outputs, their 5 and 95 % points, and the normal distributions to first order."""
    lines = -(-len(outputs) // PANELS)
    figure = style.new_figure(0.4 + 1.8 * lines)
    panels = figure.subplots(lines, PANELS, squeeze=False).ravel()
    for axes, (name, band), column in zip(panels, outputs.items(), rows.T, strict=False):
        _distribution(axes, band, column[~np.isnan(column)])
        axes.set_xlabel(format_label(name))
        axes.set_yticks([])
    for axes in panels[len(outputs) :]:
        axes.set_visible(False)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=4, frameon=False)
    return figure


def _distribution(axes: Axes, band: Band, values: Array) -> None:
    axes.hist(values, BINS, density=True, color=style.SKY, alpha=0.6, label="random machines")
    axes.axvspan(band.p5, band.p95, color=style.FAINT, alpha=0.25, linewidth=0, label="5 to 95 %")
    axes.axvline(band.nominal, color=style.INK, linewidth=1, label="nominal")
    if band.first_order_std:
        x = np.linspace(values.min(), values.max(), 200)
        deviation = (x - band.nominal) / band.first_order_std
        axes.plot(x, np.exp(-(deviation**2) / 2) / (band.first_order_std * np.sqrt(2 * np.pi)), color=style.VERMILION,
                  label="first order")  # fmt: skip


@style.with_style
def draw_indices(sobol: Mapping[str, Mapping[str, Share]]) -> Figure:
    """Draw first and total indices of each output in the inputs that matter most."""
    lines = -(-len(sobol) // 2)
    figure = style.new_figure(0.4 + 2.0 * lines)
    panels = figure.subplots(lines, 2, squeeze=False, sharex=True).ravel()
    for axes, (name, shares) in zip(panels, sobol.items(), strict=False):
        largest = [(path, share) for path, share in rank_shares(shares)[:BARS] if share.total > MIN_TOTAL][::-1]
        positions = np.arange(len(largest))
        total, first = ([getattr(share, kind) for _, share in largest] for kind in ("total", "first"))
        errors, thin = [share.total_error for _, share in largest], {"ecolor": style.SOFT, "linewidth": 0.8}
        axes.barh(positions, total, 0.8, color=style.SKY, alpha=0.7, label="total", xerr=errors, error_kw=thin)
        axes.barh(positions, first, 0.35, color=style.BLUE, label="first order")
        axes.set_yticks(positions, [last_part(path) for path, _ in largest])
        axes.set_title(format_label(name))
        axes.grid(visible=False, axis="y")
        axes.set_xlim(0, None)
    for axes in panels[len(sobol) :]:
        axes.set_visible(False)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=2, frameon=False)
    return figure


@style.with_style
def draw_cycle(phi_deg: Array, key: str, rows: Array, nominal: Array) -> Figure:
    """Draw a quantity (m, n) over a cycle: nominal, median and the 5 to 95 % band of the machines."""
    figure = style.new_figure(2.6)
    axes = figure.subplots()
    low, middle, high = np.percentile(rows, (5, 50, 95), axis=0)
    axes.fill_between(phi_deg, low, high, color=style.SKY, alpha=0.5, linewidth=0, label="5 to 95 %")
    axes.plot(phi_deg, middle, color=style.BLUE, linewidth=0.9, label="median")
    axes.plot(phi_deg, nominal, color=style.INK, linewidth=0.9, linestyle="--", label="nominal")
    style.over_a_turn(axes)
    axes.set_ylabel(format_label(key))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=3, frameon=False)
    return figure


@style.with_style
def draw_path(keys: Sequence[str], rows: tuple[Array, Array], nominal: tuple[Array, Array]) -> Figure:
    """Draw paths, and percentiles of their distance from the nominal path at each angle."""
    figure = style.new_figure(3.4)
    plane, distance = figure.subplots(1, 2)
    for x, y in zip(rows[0][:PATHS], rows[1][:PATHS], strict=True):
        plane.plot(*_closed(x, y), color=style.SKY, alpha=0.25, linewidth=0.5)
    plane.plot(*_closed(*nominal), color=style.INK, linewidth=0.8)
    style.drawing_board(plane, *map(format_label, keys))
    off = np.hypot(rows[0] - nominal[0], rows[1] - nominal[1])
    angles = np.linspace(0, 360, off.shape[1], endpoint=False)
    for share, shade in ((50, style.SKY), (95, style.BLUE)):
        distance.plot(angles, np.percentile(off, share, axis=0), color=shade, label=f"{share} % of machines")
    style.over_a_turn(distance)
    distance.set_ylabel("distance from the nominal path / mm")
    distance.set_ylim(0, None)
    distance.legend(frameon=False)
    return figure


def _closed(x: Array, y: Array) -> tuple[Array, Array]:
    return np.append(x, x[0]), np.append(y, y[0])
