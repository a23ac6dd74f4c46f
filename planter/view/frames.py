"""A machine's scene as an animated GIF, and its drawing at one moment with Matplotlib: `planter animate`."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.report import files, style
from planter.report.folder import check
from planter.safe_text import file_name
from planter.view.picture import Picture
from planter.view.results import Animated
from planter.view.scene import Scene
from planter.view.subject import first_scene, opened

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RATE = 20
"""Frame rate [1/s]."""
MAX_FRAMES = 200
"""Maximum number of frames of a cycle."""
EARLY = 1e-9
"""Share of a cycle by which a moment may be early because of rounding."""
_LINES: dict[str, dict[str, Any]] = {
    "body": {"linewidth": 1.0}, "gear": {"linewidth": 0.9}, "teeth": {"linewidth": 0.6},
    "frame": {"linewidth": 1.6, "color": style.INK},
    "mark": {"linewidth": 0.6, "color": style.SOFT}, "ground": {"linewidth": 1.0, "color": "#7a5c34"},
    "before": {"linewidth": 0.6, "color": style.FAINT, "linestyle": (0, (3, 2))},
}  # fmt: skip


def animate(
    source: str, changes: Mapping[str, float], out: Path, model: str | None = None, seconds: float | None = None
) -> Animated:
    """Write the motion of a machine as a GIF, to a file, or into a folder under the machine's name.

    `seconds` is the duration of a cycle [s]. Raises InputError if the machine or model does not exist, or if the file
    cannot be written.
    """
    machine = opened(source, changes)
    scene, model_name = first_scene(machine, model, f"--model {model}")
    path = out / f"{file_name(machine.name)}.gif" if out.is_dir() else out
    if path.suffix.lower() != ".gif":
        raise InputError(f"--out {path}: the animation is a GIF; name a folder or a file that ends in .gif")
    check(path.parent, [path.name])
    files.write_bytes(path, gif(scene, seconds))
    return Animated(str(path), machine.name, model_name)


@style.drawn
def gif(scene: Scene, seconds: float | None = None, width: float = 4.5) -> bytes:
    """Return a cycle as a GIF that repeats, with a duration [s], by default that of the cycle, and a width [inch]."""
    from matplotlib.animation import PillowWriter

    picture = Picture(scene)
    frame = picture.frames[0]
    figure = style.new_figure(width * frame.height / frame.width, width)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0, 0, 1, 1))
    count = int(np.clip(round(RATE * (scene.seconds if seconds is None else seconds)), 2, MAX_FRAMES))
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
    """Clear the axes and draw a scene at one of its moments."""
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
