"""Figures of curves: panels above or beside each other, each with named curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array
from planter.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Points = tuple[Array, Array]
"""Abscissas and ordinates, (n,) each; ordinates that are NaN interrupt a curve."""


@dataclass(frozen=True)
class Panel:
    """Curves by name over the axes of a figure; `points` are drawn on those of their name."""

    label: str
    curves: Mapping[str, Points]
    title: str = ""
    points: Mapping[str, Points] = field(default_factory=dict)
    level: float | None = None
    """Height of a horizontal line, as zero or one."""
    is_log: bool = False


@style.with_style
def draw_panels(
    panels: Sequence[Panel],
    axis: str,
    height: float = 2.4,
    side_by_side: bool = False,
    shaded: Sequence[tuple[float, float]] = (),
    end: float | None = None,
) -> Figure:
    """Return a figure of panels of a height [inch] over a common axis.

    `shaded` are ranges of the abscissa with a grey ground, `end` is the end of a cycle that the
    axis ends at.
    """
    shape = (1, len(panels)) if side_by_side else (len(panels), 1)
    figure = style.new_figure(height * shape[0] + 0.4)
    grid = figure.subplots(*shape, squeeze=False, sharex=not side_by_side, sharey=side_by_side)
    for axes, panel in zip(grid.ravel(), panels, strict=True):
        ends = []
        for index, (name, (x, y)) in enumerate(panel.curves.items()):
            shade = style.curve_colour(name, index)
            axes.plot(x, y, color=shade)
            finite = np.flatnonzero(np.isfinite(y))
            if len(finite) and name:
                ends.append((float(y[finite[np.argmax(x[finite])]]), name, shade))
            if name in panel.points:
                axes.plot(*panel.points[name], "o", color=shade, markersize=4)
        if panel.level is not None:
            axes.axhline(panel.level, color=style.SOFT, linewidth=0.6, linestyle=(0, (4, 3)))
        for low, high in shaded:
            axes.axvspan(low, high, color=style.FAINT, alpha=0.25, lw=0)
        if panel.is_log:
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter("")
        if end is not None:
            style.over_a_turn(axes, label=False, end=end)
        if len(panel.curves) > 1:
            style.label_ends(axes, ends, 0.2 / height)
        axes.set_title(panel.title)
        axes.set_ylabel(panel.label)
    for axes in grid[-1]:
        axes.set_xlabel(axis)
    return figure
