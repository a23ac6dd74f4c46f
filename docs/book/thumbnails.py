"""Thumbnails of the gallery: machines as line drawings, each a small SVG."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import shapely

from book.derived import derive_example
from planter.kernels import Array
from planter.report.picture import format_steps
from planter.report.scene import Scene
from planter.report.style import BLUE, PALETTE, SOFT
from planter.report.subject import first_scene, open_machine

WIDTH, HEIGHT, MARGIN = 160.0, 120.0, 6.0
"""Size of a thumbnail, and its margin [pixel]."""
TOLERANCE = 0.2
"""Largest deviation of a line from the drawn one [pixel]."""
LEAST_SIZE = 8.0
"""Size of the smallest line that is drawn [pixel]."""
MOMENT = 1 / 6
"""Share of the cycle at which a machine is drawn."""
HIDDEN = ("before", "ground", "mark", "soil", "teeth")
"""Outlines that a machine is drawn without."""
Line = tuple[Array, str, bool]
"""Points (k, 2) [mm], a colour, and whether they enclose a body."""


def list_machine_lines(scene: Scene) -> Iterator[Line]:
    """Yield the paths and the bodies of a machine."""
    moment = round(MOMENT * scene.moments)
    for point in scene.points:
        if point.traced:
            yield _follow(scene, point.x, point.y), SOFT, False
    for outline, points in scene.placed(slice(moment, moment + 1)):
        if outline.look not in HIDDEN:
            yield points[0], PALETTE[outline.shade % len(PALETTE)], outline.closed
    for chain in scene.chains:
        ends = [_follow(scene, scene.points[k].x, scene.points[k].y)[moment] for k in chain.points]
        yield np.array(ends), PALETTE[chain.shade % len(PALETTE)], chain.closed


def list_tooth_lines(scene: Scene) -> Iterator[Line]:
    """Yield the teeth of the first two gears in mesh."""
    teeth = [points[0] for outline, points in scene.placed(slice(0, 1)) if outline.look == "teeth"]
    for points, shade in zip(teeth[:2], PALETTE, strict=False):
        yield points, shade, True


def list_curve_lines(scene: Scene) -> Iterator[Line]:
    """Yield the first curve of a machine over a cycle, and its reference."""
    values = scene.curves[0].values
    x = np.linspace(0, WIDTH, len(values))
    y = HEIGHT * (values - values.min()) / np.ptp(values)
    yield np.column_stack([x, np.full_like(x, y.mean())])[[0, -1]], SOFT, False
    yield np.column_stack([x, y]), BLUE, False


THUMBNAILS: dict[str, tuple[str, Callable[[Scene], Iterator[Line]]]] = {
    "planting_device": ("wang2017", list_machine_lines),
    "gears_to_cut": ("wang2017", list_tooth_lines),
    "measured": ("wang2017", list_curve_lines),
    "clutch": ("shi2021", list_machine_lines),
    "pick_up": ("yu2023", list_machine_lines),
    "poses": ("sun2019-corrected", list_machine_lines),
    "own_mechanism": ("slider_crank", list_machine_lines),
    "library": ("stephenson_six_bar", list_machine_lines),
}
"""Machines by pages of the gallery, and what is drawn of each."""


def draw_thumbnail(lines: list[Line]) -> str:
    """Return lines as an SVG, without those that are too small to be seen."""
    corners = np.vstack([points for points, *_ in lines])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = min((np.array([WIDTH, HEIGHT]) - 2 * MARGIN) / np.maximum(high - low, 1e-9))
    shift = np.array([WIDTH, -HEIGHT]) / 2 - scale * (low + high) / 2
    visible = [line for line in lines if scale * np.ptp(line[0], axis=0).max() > LEAST_SIZE]
    paths = [
        f'<path fill="{shade if filled else "none"}" stroke="{shade}" '
        f'd="{_format(scale * points + shift, filled)}"/>'
        for points, shade, filled in visible
    ]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {HEIGHT:g}">'
    group = (
        '<g transform="scale(.01 -.01)" fill-opacity=".15" stroke-width="120" '
        'stroke-linejoin="round">'
    )
    return "\n".join([head, group, *paths, "</g></svg>"])


def _follow(scene: Scene, x: float | Array, y: float | Array) -> Array:
    """Return the positions (n, 2) [mm] of a point over the cycle."""
    return np.column_stack(
        [np.broadcast_to(np.asarray(v, dtype=float), (scene.moments,)) for v in (x, y)]
    )


def _format(points: Array, closed: bool) -> str:
    """Return a line (k, 2) [pixel] as a path in hundredths, without the points that change nothing visible."""
    return format_steps(np.array(shapely.LineString(points).simplify(TOLERANCE).coords), closed)


def draw_thumbnails(folder: Path) -> None:
    """Write every thumbnail into a folder. Raises RuntimeError if an example cannot be derived."""
    for page, (machine, list_lines) in THUMBNAILS.items():
        scene = first_scene(open_machine(derive_example(machine)), None, "")[0]
        (folder / f"gallery-{page}.svg").write_text(
            draw_thumbnail(list(list_lines(scene))), encoding="utf-8"
        )
