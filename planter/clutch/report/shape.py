"""Figures of a clutch's shape, and the animation of its rotation."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planter.clutch.geometry import CrankLinkage
from planter.clutch.rotor import Rotor, body_outline, polygon_outline
from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array

GHOSTS = 4
FRAMES = 60


@style.with_style
def draw_turning(rotor: Rotor) -> Figure:
    """The body at several rotations in the smallest polygon that lets it turn, and what a rotation
    needs beyond R.
    """
    figure = style.new_figure(3.6)
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.15])
    _sleeve(left, rotor)
    step = 2 * math.pi / rotor.vertices / (GHOSTS + 1)
    for i in range(GHOSTS, -1, -1):
        x, y = _body(rotor, math.pi / 2 + i * step)
        left.plot(x, y, color=style.FAINT if i else style.BLUE, linewidth=0.7 if i else 1.4)
    orbit = (
        1e3
        * np.array(
            [rotor.tightest(r)[1] for r in np.linspace(0, 2 * math.pi / rotor.vertices, 61)]
        ).T
    )
    left.plot(*orbit, color=style.VERMILION, linewidth=1.0, label="orbit of the centroid")
    left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    style.drawing_board(left)
    rotations = np.linspace(0, 2 * math.pi / rotor.vertices, 181)
    needed = 1e3 * (2 * np.array([rotor.tightest(r)[0] for r in rotations]) / rotor.width - 1)
    right.plot(np.degrees(rotations), needed, color=style.BLUE)
    right.set_xlabel("rotation of the polygon / deg")
    right.set_ylabel("extra clearance needed / (R/1000)")
    right.set_title("clearance error of the polygon (0 = perfect rotor)")
    return figure


def _sleeve(axes: Axes, rotor: Rotor) -> None:
    axes.plot(
        *(1e3 * polygon_outline(rotor.sides, rotor.smallest_apothem)),
        color=style.INK,
        linewidth=1.2,
    )


def _body(rotor: Rotor, rotation: float) -> Array:
    closed = body_outline(rotor, rotation, rotor.tightest(rotation)[1])
    return 1e3 * np.hstack([closed, closed[:, :1]])


@style.with_style
def draw_vertex_path(rotor: Rotor, fillets: Mapping[str, float]) -> Figure:
    """Path of a vertex over a turn with the ellipse of one corner, and that corner with rounded
    ones [m] inside.
    """
    figure = style.new_figure(3.6)
    overview, corner = figure.subplots(1, 2)
    theta = np.linspace(*rotor.passage, 61)
    arc = rotor.path(theta)
    x, y = 1e3 * arc["x_C"], 1e3 * arc["y_C"]
    for axes in (overview, corner):
        axes.plot(
            *(1e3 * polygon_outline(rotor.sides, rotor.width / 2)), color=style.INK, linewidth=0.9
        )
        axes.plot(*(1e3 * rotor.track()), color=style.BLUE, linewidth=1.0)
        axes.plot(x, y, color=style.VERMILION, linewidth=1.8)
        axes.plot(*_ellipse(rotor), color=style.VERMILION, linewidth=0.7, linestyle=(0, (4, 2)))
    _axes_of(overview, rotor)
    style.drawing_board(overview)
    for index, (name, radius) in enumerate(fillets.items()):
        rounded = 1e3 * polygon_outline(rotor.sides, rotor.width / 2, radius, 40)
        shade = (style.GREEN, style.PURPLE, style.ORANGE)[index % 3]
        corner.plot(
            *rounded, color=shade, linewidth=1.0, label=f"{name}: {radius / rotor.width:.4f} R"
        )
    reach = 0.1 * 1e3 * rotor.width
    middle = x[len(x) // 2], y[len(y) // 2]
    style.drawing_board(corner)
    corner.set(
        xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach)
    )
    corner.set_aspect("equal", adjustable="box")
    corner.legend(loc="upper left", frameon=False, fontsize=7)
    overview.set_title("path of a vertex; dashed: its ellipse at one corner")
    corner.set_title("the corner, with fillets inside")
    return figure


def _ellipse(rotor: Rotor) -> Array:
    ellipse, angle = rotor.ellipse, np.linspace(0, 2 * math.pi, 241)
    major = np.array([math.cos(ellipse["axis"]), math.sin(ellipse["axis"])])
    across = np.array([-major[1], major[0]])
    centre = np.array([ellipse["x_E"], ellipse["y_E"]])
    points = np.outer(major, ellipse["s_1"] * np.cos(angle)) + np.outer(
        across, ellipse["s_2"] * np.sin(angle)
    )
    return 1e3 * (centre[:, None] + points)


def _axes_of(axes: Axes, rotor: Rotor) -> None:
    ellipse = rotor.ellipse
    for size, turn in ((ellipse["s_1"], 0.0), (ellipse["s_2"], math.pi / 2)):
        direction = size * np.array(
            [math.cos(ellipse["axis"] + turn), math.sin(ellipse["axis"] + turn)]
        )
        ends = 1e3 * np.array([[ellipse["x_E"]], [ellipse["y_E"]]]) + 1e3 * np.outer(
            direction, [-1, 1]
        )
        axes.plot(*ends, color=style.SOFT, linewidth=0.5)
    axes.plot(1e3 * ellipse["x_E"], 1e3 * ellipse["y_E"], "+", color=style.INK, markersize=6)


@style.with_style
def draw_travels(angles_deg: Array, curves: Mapping[str, Array], marks: Sequence[float]) -> Figure:
    """Least travel [mm] over the axial angle, a curve for each model, with the file's levels
    marked.
    """
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    ends = []
    for index, (name, curve) in enumerate(curves.items()):
        shade = style.curve_colour(name, index)
        axes.plot(angles_deg, curve, color=shade)
        axes.plot(marks, np.interp(marks, angles_deg, curve), "o", color=shade, markersize=4)
        ends.append((float(curve[-1]), name, shade))
    axes.set_ylim(bottom=0)
    axes.set_xlabel("axial angle / deg")
    axes.set_ylabel("least travel of the sleeve / mm")
    style.label_ends(axes, ends, 0.07)
    return figure


@style.with_style
def draw_linkages(labelled: Mapping[str, tuple[CrankLinkage, float, float]]) -> Figure:
    """Each linkage at both ends of its travel: label -> (linkage, travel [m], pitch radius of the
    crank gear [m]).
    """
    figure = style.new_figure(2.6 * len(labelled))
    for axes, (name, (linkage, travel, gear)) in zip(
        figure.subplots(len(labelled), 1, squeeze=False)[:, 0], labelled.items(), strict=True
    ):
        _linkage(axes, linkage, travel, gear)
        turned = math.degrees(linkage.rotation(travel))
        axes.set_title(f"{name}: crank turns {turned:.3g}° for a travel of {1e3 * travel:.3g} mm")
    return figure


def _linkage(axes: Axes, linkage: CrankLinkage, travel: float, gear: float) -> None:
    from matplotlib.patches import Circle, Rectangle

    reach = 1e3 * (linkage.distance + travel)
    axes.plot([0, 1.15 * reach], [0, 0], color=style.FAINT, linewidth=0.8, linestyle=(0, (6, 3)))
    axes.add_patch(Circle((0, 0), 1e3 * gear, fill=False, edgecolor=style.FAINT, linewidth=0.9))
    for name, shift, shade in (
        ("engaged", 0.0, style.BLUE),
        ("disengaged", travel, style.VERMILION),
    ):
        at = linkage.evaluate(np.array([shift]))
        x, y = 1e3 * at["pin_x"][0], 1e3 * at["pin_y"][0]
        pin = 1e3 * (linkage.distance + shift)
        axes.plot(
            [0, x, pin], [0, y, 0], "o-", color=shade, markersize=3.5, linewidth=1.6, label=name
        )
        axes.add_patch(
            Rectangle((pin - 2.5, -1.5), 5, 3, fill=False, edgecolor=shade, linewidth=0.9)
        )
    axes.annotate("A", (0, 0), (-9, -10), textcoords="offset points")
    axes.legend(loc="upper right", frameon=False)
    style.drawing_board(axes, "along the guide / mm", "across / mm")


@style.with_style
def animate_turning(rotor: Rotor, frames: int = FRAMES) -> bytes:
    """The body turning once in the smallest polygon that lets it, as a GIF; a vertex draws its
    path.
    """
    from matplotlib.animation import PillowWriter

    figure = style.new_figure(3.4, 3.4)
    axes = figure.subplots()
    _sleeve(axes, rotor)
    (body,) = axes.plot([], [], color=style.BLUE)
    (trail,) = axes.plot([], [], color=style.VERMILION, linewidth=1.0)
    axes.set_axis_off()
    axes.set_aspect("equal")
    limit = 1.05e3 * rotor.smallest_apothem / math.cos(math.pi / rotor.sides)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit))
    rho, tips = float(rotor.support(0.0)[0]), np.empty((2, 0))
    writer = PillowWriter(fps=20)
    with tempfile.TemporaryDirectory(prefix="planter-") as scratch:
        path = Path(scratch) / "turning.gif"
        with writer.saving(figure, str(path), dpi=90):
            for rotation in 2 * math.pi * np.arange(frames) / frames:
                centroid = rotor.tightest(float(rotation))[1]
                tip = 1e3 * (centroid + rho * np.array([math.cos(rotation), math.sin(rotation)]))
                tips = np.column_stack([tips, tip])
                body.set_data(*_body(rotor, float(rotation)))
                trail.set_data(*tips)
                writer.grab_frame()
        return path.read_bytes()
