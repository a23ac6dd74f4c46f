"""Animated drawings of a scene: a block of a page, a widget of a notebook, a GIF."""

from __future__ import annotations

import base64
import json
import re
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.errors import InputError
from planter.files import units
from planter.kernels import Array
from planter.report import files, style
from planter.report.folder import check_files
from planter.report.html import escape_markup
from planter.report.picture import Picture, draw_picture
from planter.report.results import Animated
from planter.report.scene import Scene
from planter.report.subject import Values, build_scene, first_scene, open_machine
from planter.safe_text import file_name

if TYPE_CHECKING:
    from matplotlib.animation import AbstractMovieWriter
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Record = Mapping[str, Any]
EVEN = 1e-9
"""Deviation of a linear series from its line, relative to its range; it is below the resolution of
float32.
"""


class Channels:
    """Series (n,) in one block of float32, each referred to by its number.

    A constant series is replaced by its value, and a linear one by its first value and its step.
    """

    def __init__(self, moments: int) -> None:
        self.moments = moments
        self._series: list[bytes] = []
        self._numbers: dict[bytes, int] = {}

    def add(self, values: float | Array) -> float | dict[str, float]:
        """Add a series, and return its value, its first value and step, or the number of its series
        and its lead.

        A series that equals an earlier one shifted by half a cycle refers to that one.
        """
        exact = np.broadcast_to(np.asarray(values, dtype=float), (self.moments,))
        series = exact.astype("<f4")
        if np.ptp(series) == 0:
            return float(series[0])
        if np.ptp(exact - np.linspace(exact[0], exact[-1], self.moments)) < EVEN * np.ptp(exact):
            return {
                "from": float(exact[0]),
                "step": float(exact[-1] - exact[0]) / (self.moments - 1),
            }
        for ahead in (0, self.moments // 2):
            number = self._numbers.get(np.roll(series, ahead).tobytes())
            if number is not None:
                return {"series": number, "ahead": ahead}
        self._numbers[series.tobytes()] = len(self._series)
        self._series.append(series.tobytes())
        return {"series": len(self._series) - 1, "ahead": 0}

    def text(self) -> str:
        """Return all series, one after another, in base64."""
        return base64.b64encode(b"".join(self._series)).decode("ascii")


def pack_curves(scene: Scene) -> Record:
    """Return the curves of a scene in the format of `pack_scene`."""
    series = Channels(scene.moments)
    curves = _curves(scene, series)
    return {"moments": scene.moments, "curves": curves, "data": series.text()}


def _curves(scene: Scene, series: Channels) -> list[dict[str, Any]]:
    return [
        {
            "name": curve.name,
            "unit": units.typeset_unit(curve.unit),
            "values": series.add(curve.values),
            "reference": curve.reference,
        }
        for curve in scene.curves
    ]


def pack_scene(scene: Scene) -> Record:
    """Return the JSON record that animates the picture of a scene; bodies are in the order of the
    picture.
    """
    series = Channels(scene.moments)
    return {
        "moments": scene.moments,
        "seconds": scene.seconds,
        "place": scene.place,
        "unit": scene.unit,
        "places": series.add(scene.places),
        "shares": series.add(scene.times),
        "travel": series.add(scene.travel) if scene.travel is not None and scene.travels else 0.0,
        "bodies": [
            [series.add(v) for v in (*body.at, body.turn, *body.scale)]
            for body in scene.all_bodies()
        ],
        "points": [[series.add(v) for v in (point.x, point.y)] for point in scene.points],
        "chains": [
            {"points": list(chain.points), "closed": chain.closed} for chain in scene.chains
        ],
        "forces": [[series.add(v) for v in (f.at.x, f.at.y, f.x, f.y)] for f in scene.forces],
        "largest_N": scene.largest_force,
        "curves": _curves(scene, series),
        "events": [
            [event.name, event.place] for event in sorted(scene.events, key=lambda e: e.place)
        ],
        "data": series.text(),
    }


@dataclass(frozen=True)
class MotionBlock:
    """An animated scene as a block of a page."""

    scene: Scene
    caption: str = ""

    @property
    def script(self) -> str:
        """The ES module that moves drawings."""
        return compact_script(read_text("view.js"))

    @property
    def style(self) -> str:
        """The style of drawings."""
        return read_text("view.css")

    def html(self, name: str) -> str:
        """Return the block as HTML; `name` is unique on the page."""
        caption = f"<figcaption>{escape_markup(self.caption)}</figcaption>" if self.caption else ""
        return "\n".join(
            (
                f'<figure id="{name}">',
                '<div class="planter-view" data-view="still" tabindex="0">',
                draw_picture(self.scene),
                f"<script "
                f'type="application/json">{_safe(json.dumps(pack_scene(self.scene)))}</script>',
                "</div>",
                caption,
                "</figure>",
            )
        )


@cache
def read_text(name: str) -> str:
    """Return the text of a file of this package."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


_COMMENT = re.compile(r"^\s*/\*\*.*?\*/$", re.MULTILINE | re.DOTALL)


def compact_script(text: str) -> str:
    """Return a script without indentation and without lines that are comments, for pages that
    contain it.

    >>> compact_script("/** One\\n  block. */\\n  let x = 1; // stays\\n  // goes\\n")
    'let x = 1; // stays'
    """
    lines = (line.strip() for line in _COMMENT.sub("", text).splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("//"))


def _safe(text: str) -> str:
    """Return JSON for an HTML script element, which nothing in it can end."""
    return text.replace("<", "\\u003c").replace("&", "\\u0026")


def build_widget(scene: Scene) -> Any:
    """Return a scene as a widget; its traits `picture` and `record` can be replaced together with
    `hold_sync`.

    Raises InputError if anywidget is missing, which `planter[notebook]` installs.
    """
    return _kind()(picture=draw_picture(scene), record=dict(pack_scene(scene)))


def show(source: str, changes: Values | None = None, model: str | None = None) -> Any:
    """Return the motion of a machine, a file or built-in name, in one of its models, with changed
    numbers in the units of its file.

    Raises InputError if the machine or model does not exist, or if anywidget is missing.
    """
    return build_widget(first_scene(open_machine(source, changes), model, f"model = {model}")[0])


def show_object(thing: object) -> Any:
    """Return the motion of an object as a widget.

    Raises InputError if the object cannot be drawn, or if anywidget is missing.
    """
    return build_widget(build_scene(thing))


@cache
def _kind() -> Any:
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise InputError(
            "show needs anywidget, which is not installed: pip install 'planter[notebook]'"
        ) from None

    class Drawing(anywidget.AnyWidget):
        """A mechanism in motion."""

        _esm = read_text("view.js")
        _css = read_text("view.css")
        picture = traitlets.Unicode().tag(sync=True)
        record = traitlets.Dict().tag(sync=True)

    return Drawing


RATE = 20.0
"""Default frame rate [1/s]."""
WIDTH_PX = 432
"""Default width of an animation [pixel]."""
MAX_FRAMES = 200
"""Maximum number of frames of a cycle, unless a rate is given."""
DPI = 96
VIDEO_CODECS = {".mp4": "libx264", ".webm": "libvpx-vp9"}
"""Codecs of videos by the ending of their file; ffmpeg writes them."""
EARLY = 1e-9
"""Share of a cycle by which a moment may be early because of rounding."""
_LINES: dict[str, dict[str, Any]] = {
    "body": {"linewidth": 1.0},
    "gear": {"linewidth": 0.9},
    "teeth": {"linewidth": 0.6},
    "frame": {"linewidth": 1.6, "color": style.INK},
    "line": {"linewidth": 1.0},
    "mark": {"linewidth": 0.6, "color": style.SOFT},
    "ground": {"linewidth": 1.0, "color": "#7a5c34"},
    "soil": {"linewidth": 0.0, "color": "#7a5c34"},
    "before": {"linewidth": 0.6, "color": style.FAINT, "linestyle": (0, (3, 2))},
}


@dataclass(frozen=True)
class AnimationOptions:
    """The duration of a cycle [s], by default its own, the width [pixel], and the frame rate [1/s]
    of an animation.

    Without a rate a long cycle has fewer frames per second, so that a GIF stays small.
    """

    seconds: float | None = None
    width_px: int = WIDTH_PX
    rate: float | None = None

    def count_frames(self, scene: Scene) -> tuple[int, float]:
        """Return the number of frames of a cycle, and the frame rate [1/s] at which it lasts as
        long as it should.
        """
        seconds = scene.seconds if self.seconds is None else self.seconds
        max_count = MAX_FRAMES if self.rate is None else max(MAX_FRAMES, round(self.rate * seconds))
        count = int(np.clip(round((self.rate or RATE) * seconds), 2, max_count))
        return count, min(count / seconds, self.rate or RATE)


def animate(
    source: str,
    changes: Mapping[str, float],
    out: Path,
    model: str | None = None,
    options: AnimationOptions = AnimationOptions(),
) -> Animated:
    """Write the motion of a machine, to a file, or as a GIF into a folder under the machine's name.

    A file that ends in .mp4 or .webm is a video, which needs ffmpeg. Raises InputError if the
    machine or model does not exist, if the file cannot be written, or if there is no ffmpeg for a
    video.
    """
    machine = open_machine(source, changes)
    scene, model_name = first_scene(machine, model, f"--model {model}")
    path = out / f"{file_name(machine.name)}.gif" if out.is_dir() else out
    suffix = path.suffix.lower()
    if suffix != ".gif" and suffix not in VIDEO_CODECS:
        raise InputError(f"--out {path}: name a folder, or a file that ends in .gif, .mp4 or .webm")
    check_files(path.parent, [path.name])
    content, (frames, rate) = render_animation(scene, options, suffix), options.count_frames(scene)
    files.write_bytes(path, content)
    return Animated(str(path), machine.name, model_name, frames, frames / rate, len(content))


def gif(scene: Scene, seconds: float | None = None) -> bytes:
    """Return a cycle as a GIF that repeats, with a duration [s], by default that of the cycle."""
    return render_animation(scene, AnimationOptions(seconds), ".gif")


@style.with_style
def render_animation(scene: Scene, options: AnimationOptions, suffix: str) -> bytes:
    """Return a cycle as a GIF that repeats, or as a video, by the ending of its file.

    Raises InputError if there is no ffmpeg for a video, or if it cannot write this kind.
    """
    picture = Picture(scene)
    frame = picture.frames[0]
    width_px = 2 * (options.width_px // 2)  # videos have even numbers of pixels
    height_px = 2 * round(width_px * frame.height / frame.width / 2)
    figure = style.new_figure(height_px / DPI, width_px / DPI)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0, 0, 1, 1))
    count, rate = options.count_frames(scene)
    writer = _create_writer(suffix, rate)
    with tempfile.TemporaryDirectory(prefix="planter-") as scratch, _refuse_failed_video(suffix):
        path = Path(scratch) / f"moving{suffix}"
        with writer.saving(figure, str(path), dpi=DPI):
            times = np.linspace(0.0, 1.0, count, endpoint=False) + EARLY
            for moment in np.searchsorted(scene.times, times, side="right") - 1:
                draw(axes, picture, int(moment))
                writer.grab_frame()
        return path.read_bytes()


def _create_writer(suffix: str, rate: float) -> AbstractMovieWriter:
    """Return the writer of an animation. Raises InputError if there is no ffmpeg for a video."""
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if suffix not in VIDEO_CODECS:
        return PillowWriter(fps=rate)  # type: ignore[arg-type]
    if not FFMpegWriter.isAvailable():
        raise InputError(
            f"{suffix}: ffmpeg writes videos, and it is not installed; name a file that ends in "
            f".gif"
        )
    steady = (
        "-pix_fmt",
        "yuv420p",
        "-fflags",
        "+bitexact",
        "-flags:v",
        "+bitexact",
        "-threads",
        "1",
    )
    return FFMpegWriter(fps=rate, codec=VIDEO_CODECS[suffix], extra_args=steady)  # type: ignore[arg-type]


@contextmanager
def _refuse_failed_video(suffix: str) -> Iterator[None]:
    """Turn a failure of ffmpeg into an InputError."""
    try:
        yield
    except (subprocess.CalledProcessError, BrokenPipeError) as error:
        codec = VIDEO_CODECS.get(suffix, "")
        raise InputError(
            f"{suffix}: ffmpeg cannot write it with {codec} ({error}); name a .gif"
        ) from None


def draw(axes: Axes, picture: Picture, moment: int) -> None:
    """Clear the axes and draw a scene at one of its moments."""
    scene, frame = picture.scene, picture.frames[0]
    axes.clear()
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set(
        xlim=(frame.left, frame.left + frame.width),
        ylim=(frame.bottom, frame.bottom + frame.height),
    )
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
        axes.text(label.x, label.y, label.text, ha=side, color=style.SOFT, fontsize=7)


@style.with_style
def draw_stills(stills: Mapping[str, tuple[Scene, int]], height: float = 4.4) -> Figure:
    """Return a figure of scenes at one of their moments each, side by side under their titles."""
    figure = style.new_figure(height)
    for axes, (title, (scene, moment)) in zip(
        figure.subplots(1, len(stills), squeeze=False)[0], stills.items(), strict=True
    ):
        draw(axes, Picture(scene), moment)
        axes.set_axis_on()
        style.drawing_board(axes)
        axes.set_title(title)
    return figure


def _line(axes: Axes, points: Array, look: str, shade: int, closed: bool) -> None:
    corners = np.vstack([points, points[:1]]) if closed else points
    colour = style.PALETTE[shade % len(style.PALETTE)]
    axes.plot(*corners.T, **({"color": colour} | _LINES[look]))
    if closed and look in ("body", "gear", "teeth", "soil"):
        fill = _LINES[look].get("color", colour)
        axes.fill(*corners.T, facecolor=fill, alpha=0.1, edgecolor="none")
