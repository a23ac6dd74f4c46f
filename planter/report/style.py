"""The common style of all figures, and their rendering as SVG and PNG.

A user's matplotlibrc is ignored, so that the same data give the same bytes everywhere.
"""

from __future__ import annotations

import io
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeAlias, TypeVar

from planter.files import units

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array


WIDTH = 6.7
"""Width of a figure [inch]: the text of an A4 page."""
DOTS = 160
"""Resolution of the PNG [1/inch]."""

INK, PAPER, SOFT, FAINT = "#1b2430", "#fefefe", "#6f7884", "#a9b0b9"
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#b0568f",
    "#e69f00",
    "#56b4e9",
)
CLEAR = {"boxstyle": "square,pad=0.1", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.75}
"""Background of a text that is drawn over lines."""
PALETTE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
"""Colours that people with any kind of colour vision can tell apart (Okabe and Ito)."""

TEXT_SHADES = {
    VERMILION: "#b54f00",
    GREEN: "#00795a",
    PURPLE: "#a04a80",
    ORANGE: "#8f6400",
    SKY: "#1b6d9c",
}
"""Darker shades of the palette's colours for text, with a contrast of 4.5 to the paper."""
DARK_SHADES = {
    BLUE: "#4ea3e6",
    PURPLE: "#cf7db2",
    "#b54f00": "#e8742b",
    "#00795a": "#2bb58c",
    "#a04a80": "#cf7db2",
    "#8f6400": ORANGE,
    "#1b6d9c": SKY,
}
"""Colours on a dark page in the place of those that are too dark for it."""

_MODEL_COLOURS = {"exact": BLUE, "printed": VERMILION}
_LOCK = threading.RLock()
_SETTINGS: dict[Any, Any] = {
    "figure.facecolor": PAPER,
    "savefig.facecolor": PAPER,
    "axes.facecolor": "none",
    "axes.edgecolor": SOFT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 8.5,
    "axes.titlecolor": INK,
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "axes.formatter.useoffset": False,
    "grid.color": FAINT,
    "grid.alpha": 0.35,
    "grid.linewidth": 0.5,
    "text.color": INK,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "patch.linewidth": 0.8,
    "svg.hashsalt": "planter",
    "svg.fonttype": "path",
}

P = ParamSpec("P")
T = TypeVar("T")


@contextmanager
def _settings() -> Iterator[None]:
    """Apply the settings of this style to one thread at a time, because Matplotlib's settings are
    global.
    """
    import matplotlib

    with _LOCK, matplotlib.rc_context():
        matplotlib.rcdefaults()
        for name, value in _SETTINGS.items():
            matplotlib.rcParams[name] = value
        yield


def with_style(draw: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function that draws a figure, so that it draws in this style."""

    @wraps(draw)
    def styled(*args: P.args, **kwargs: P.kwargs) -> T:
        with _settings():
            return draw(*args, **kwargs)

    return styled


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """Return an empty figure of a height and width [inch] with constrained layout."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def curve_colour(label: str, index: int) -> str:
    """Return the colour of a curve: a fixed one for a model's label, or else the palette's at the
    index.
    """
    return _MODEL_COLOURS.get(label, PALETTE[index % len(PALETTE)])


def over_a_turn(axes: Axes, label: bool = True, end: float = 360.0) -> None:
    """Set the carrier angle as the horizontal axis, up to the end of a cycle [deg]."""
    axes.set_xlim(0, end)
    if end == 360:
        axes.set_xticks(range(0, 361, 60))
    if label:
        axes.set_xlabel("carrier angle φ / deg")


def add_legend(figure: Figure, axes: Axes, columns: int = 1) -> None:
    """Add the legend of axes above all axes of a figure, away from the labels at the left."""
    handles = axes.get_legend_handles_labels()
    figure.legend(*handles, loc="outside upper right", ncols=columns, frameon=False)


def drawing_board(axes: Axes, x: str = "x / mm", y: str = "y / mm") -> None:
    """Set equal scales and labels of the axes, for figures that show shapes."""
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(x)
    axes.set_ylabel(y)


def draw_tubes(axes: Axes, points: Sequence[Sequence[float]]) -> None:
    """Draw points (x, y, radius) that a path must pass, each as a circle of its tolerance
    radius.
    """
    from matplotlib.patches import Circle

    for number, (x, y, radius) in enumerate(points, 1):
        axes.add_patch(
            Circle(
                (x, y), radius, facecolor=GREEN, alpha=0.2, edgecolor=GREEN, linewidth=0.6, zorder=1
            )
        )
        axes.annotate(
            str(number), (x, y), color=GREEN, ha="center", va="center", fontsize=7, zorder=1
        )


def label_ends(axes: Axes, ends: Sequence[tuple[float, str, str]], gap: float) -> None:
    """Label curves at the right edge of the axes by (height in data units, text, colour).

    Labels are moved so that neighbours are at least `gap` apart, a share of the height of the axes.
    """
    if not ends:
        return
    order = sorted(ends)
    axes.autoscale_view()  # the transformations below need the limits, which are otherwise computed when drawing
    on_screen = axes.transData.transform([(1, end[0]) for end in order])
    targets = axes.transAxes.inverted().transform(on_screen)[:, 1].tolist()
    for (_, text, shade), height in zip(order, spread_heights(targets, gap), strict=True):
        shade = TEXT_SHADES.get(shade, shade)
        axes.text(
            1.012, height, text, color=shade, transform=axes.transAxes, va="center", ha="left"
        )


def spread_heights(heights: Sequence[float], gap: float) -> list[float]:
    """Return sorted heights in [0, 1], raised, and lowered at the top, so that neighbours are `gap`
    apart.

    >>> [round(h, 3) for h in spread_heights([0.1, 0.5, 0.52], 0.1)]
    [0.1, 0.5, 0.6]
    >>> [round(h, 3) for h in spread_heights([0.01, 0.97, 0.98], 0.1)]
    [0.01, 0.9, 1.0]
    """
    spread: list[float] = []
    for height in heights:
        spread.append(max(height, spread[-1] + gap) if spread else height)
    highest = 1.0
    for k in reversed(range(len(spread))):
        spread[k] = min(spread[k], highest)
        highest = spread[k] - gap
    return spread


def render_svg(figure: Figure) -> str:
    """Return the figure as SVG text; the same figure always gives the same bytes."""
    return _rendered(figure, "svg", {"Date": None, "Creator": None}).decode("utf-8")


def render_figure(figure: Figure) -> dict[str, str | bytes]:
    """Return the figure as SVG, PNG and PDF by their endings; the same figure always gives the same
    bytes.
    """
    undated = {"CreationDate": None, "Creator": None, "Producer": None}
    return {
        "svg": render_svg(figure),
        "png": _rendered(figure, "png", {"Software": None}),
        "pdf": _rendered(figure, "pdf", undated),
    }


def fix_layout(figure: Figure) -> None:
    """Typeset the units of a figure's axes and texts, and fix its layout, so that drawing it again
    moves nothing.
    """
    for axes in figure.axes:
        for axis in filter(None, (axes.xaxis, axes.yaxis, getattr(axes, "zaxis", None))):
            axis.set_label_text(units.typeset_label(axis.get_label_text()))
    for text in figure.texts:
        text.set_text(units.typeset_label(text.get_text()))
    with _settings():
        engine = figure.get_layout_engine()
        if engine is not None:
            # Twice: equal scales change the limits, and with them the space that tick labels need.
            engine.execute(figure)
            engine.execute(figure)
            figure.set_layout_engine("none")


def _rendered(figure: Figure, kind: str, metadata: dict[str, None]) -> bytes:
    fix_layout(figure)
    buffer = io.BytesIO()
    with _settings():
        figure.savefig(buffer, format=kind, dpi=DOTS, metadata=metadata)
    return buffer.getvalue()


Points: TypeAlias = "tuple[Array, Array]"
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


@with_style
def draw_panels(
    panels: Sequence[Panel],
    axis: str,
    height: float = 2.4,
    shaded: Sequence[tuple[float, float]] = (),
    end: float | None = None,
) -> Figure:
    """Return a figure of panels of a height [inch] over a common axis.

    `shaded` are ranges of the abscissa with a grey ground, `end` is the end of a cycle that the
    axis ends at.
    """
    import numpy as np

    figure = new_figure(height * len(panels) + 0.4)
    grid = figure.subplots(len(panels), 1, squeeze=False, sharex=True)
    for axes, panel in zip(grid.ravel(), panels, strict=True):
        ends = []
        for index, (name, (x, y)) in enumerate(panel.curves.items()):
            shade = curve_colour(name, index)
            axes.plot(x, y, color=shade)
            finite = np.flatnonzero(np.isfinite(y))
            if len(finite) and name:
                ends.append((float(y[finite[np.argmax(x[finite])]]), name, shade))
            if name in panel.points:
                axes.plot(*panel.points[name], "o", color=shade, markersize=4)
        if panel.level is not None:
            axes.axhline(panel.level, color=SOFT, linewidth=0.6, linestyle=(0, (4, 3)))
        for low, high in shaded:
            axes.axvspan(low, high, color=FAINT, alpha=0.25, lw=0)
        if panel.is_log:
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter("")
        if end is not None:
            over_a_turn(axes, label=False, end=end)
        if len(panel.curves) > 1:
            label_ends(axes, ends, 0.2 / height)
        axes.set_title(panel.title)
        axes.set_ylabel(panel.label)
    for axes in grid[-1]:
        axes.set_xlabel(axis)
    return figure
