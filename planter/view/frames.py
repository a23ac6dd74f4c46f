"""A scene as a moving picture: its drawing at some moments of the cycle, as a GIF."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.kernels import Array
from planter.report import style
from planter.view.picture import Picture
from planter.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RATE = 20
"""Pictures a second."""
MOST = 200
"""Pictures of a cycle."""
EARLY = 1e-9
"""Share of a cycle by which a moment may be early: what rounding makes of one that is due."""
_LINES: dict[str, dict[str, Any]] = {
    "body": {"linewidth": 1.0}, "gear": {"linewidth": 0.9}, "teeth": {"linewidth": 0.6},
    "frame": {"linewidth": 1.6, "color": style.INK},
    "mark": {"linewidth": 0.6, "color": style.SOFT}, "ground": {"linewidth": 1.0, "color": "#7a5c34"},
    "before": {"linewidth": 0.6, "color": style.FAINT, "linestyle": (0, (3, 2))},
}  # fmt: skip


@style.drawn
def gif(scene: Scene, seconds: float | None = None, width: float = 4.5) -> bytes:
    """A cycle as a GIF that goes on for ever: of `seconds`, as long as it takes unless told; `width` in inches."""
    from matplotlib.animation import PillowWriter

    picture = Picture(scene)
    frame = picture.frames[0]
    figure = style.new_figure(width * frame.height / frame.width, width)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0, 0, 1, 1))
    count = int(np.clip(round(RATE * (scene.seconds if seconds is None else seconds)), 2, MOST))
    writer = PillowWriter(fps=RATE)
    with tempfile.TemporaryDirectory(prefix="planter-") as scratch:
        path = Path(scratch) / "moving.gif"
        with writer.saving(figure, str(path), dpi=96):
            times = np.linspace(0.0, 1.0, count, endpoint=False) + EARLY
            for moment in np.searchsorted(scene.times, times, side="right") - 1:
                draw(axes, picture, int(moment))
                writer.grab_frame()
        return path.read_bytes()


def draw(axes: Axes, picture: Picture, moment: int) -> None:
    """A scene at one of its moments, in place of what the axes showed."""
    scene, frame = picture.scene, picture.frames[0]
    axes.clear()
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set(xlim=(frame.left, frame.left + frame.width), ylim=(frame.bottom, frame.bottom + frame.height))
    for point, path in zip(scene.points, picture.paths, strict=True):
        if point.traced:
            axes.plot(*path.T, color=style.SOFT, linewidth=0.7, linestyle=(0, (4, 3)))
    for outline, points in scene.placed(slice(moment, moment + 1)):
        pitch = scene.toothed and outline.look == "gear"
        _line(axes, points[0], "mark" if pitch else outline.look, outline.shade, outline.closed)
    for chain in scene.chains:
        corners = np.array([picture.paths[index][moment] for index in chain.points])
        _line(axes, corners, "body", chain.shade, chain.closed)
    for path in picture.paths:
        axes.plot(*path[moment], "o", color=style.PAPER, markeredgecolor=style.INK, markersize=3)
    for label in scene.labels:
        side = {"start": "left", "middle": "center", "end": "right"}[label.anchor]
        axes.text(label.x, label.y, label.text, ha=side, color=style.SOFT, fontsize=6)


def _line(axes: Axes, points: Array, look: str, shade: int, closed: bool) -> None:
    corners = np.vstack([points, points[:1]]) if closed else points
    colour = style.PALETTE[shade % len(style.PALETTE)]
    axes.plot(*corners.T, **({"color": colour} | _LINES[look]))
    if closed and look in ("body", "gear", "teeth"):
        axes.fill(*corners.T, facecolor=colour, alpha=0.1, edgecolor="none")
