"""Figures of forces: the support force over the cycle, and the joint forces as polar load
diagrams.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array

Curve = tuple["Array", "Array"]
"""Carrier angles [deg] and a force there [N], each (n,)."""

JOINTS = {
    "F_A1": "A1: carrier on the middle shaft, side 1",
    "F_B1": "B1: carrier on the planet's shaft, side 1",
    "F_O": "O: frame on the sun",
    "F_O1": "O1: sun's shaft on the carrier",
}
"""Joint forces of a cycle, by what their components' names start with."""

LABEL = 0.17
"""Height of a line of text in a figure [inch]."""
BEFORE = "dashed: before the optimisation"
FLAT = 0.2
"""A curve with less than this share of the common range gets a panel of its own."""


@style.with_style
def draw_support_force(
    cycles: Mapping[str, Curve],
    weight_N: float,
    joints_deg: Mapping[str, Sequence[float]] | None = None,
    before: Mapping[str, Curve] | None = None,
    reference: Mapping[str, tuple[float, float]] | None = None,
) -> Figure:
    """Vertical support force over a turn, a curve for each model.

    `before` holds the same curves for the design that an optimisation started from; `joints_deg`
    the carrier angles where a derivative jumps, named as in the model's events (part, comma, what
    happens there); `reference` the (largest, smallest) force that somebody else reports, drawn as a
    bar below those of the models. A model whose curve is too flat to be read on the common scale is
    shown again on its own.
    """
    before, joints, reference = before or {}, _by_part(joints_deg or {}), reference or {}
    flat = _flat(cycles, before)
    heights = [2.9, *(1.4 for _ in flat)]
    heights += [LABEL * (len(joints) + 1)] if joints else []
    heights += [LABEL * (len(reference) + len(cycles))] if reference else []
    figure = style.new_figure(sum(heights) + 0.3 * len(heights) + (0.9 if reference else 0.3))
    all_axes = list(figure.subplots(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0])
    if reference:
        _bars(all_axes.pop(), cycles, reference)
    angular = all_axes.copy()
    if joints:
        _strip(all_axes.pop(), joints)
    for label, axes, height in zip((None, *flat), all_axes, heights, strict=False):
        displayed = cycles if label is None else {label: cycles[label]}
        _curves(axes, displayed, before, weight_N, LABEL / height)
        _faint_lines(axes, joints)
        titles = [
            f"{label} model on its own scale" if label else "",
            _ranges(displayed, before),
            BEFORE if before else "",
        ]
        axes.set_title("; ".join(part for part in titles if part))
    for axes in angular:
        last = axes is angular[-1]
        style.over_a_turn(axes, label=last)
        axes.tick_params(labelbottom=last)
    return figure


def _ranges(cycles: Mapping[str, Curve], before: Mapping[str, Curve]) -> str:
    """Largest less smallest force of each curve, after what it was before."""
    ranges = []
    for label, (_, force) in cycles.items():
        before_text = f"{np.ptp(before[label][1]):.4g} to " if label in before else ""
        ranges.append(f"{label} {before_text}{np.ptp(force):.4g} N")
    return f"range: {', '.join(ranges)}"


def _flat(cycles: Mapping[str, Curve], before: Mapping[str, Curve]) -> list[str]:
    forces = [force for _, force in (*cycles.values(), *before.values())]
    common = max(f.max() for f in forces) - min(f.min() for f in forces)
    return [label for label, (_, force) in cycles.items() if np.ptp(force) < FLAT * common]


def _by_part(joints: Mapping[str, Sequence[float]]) -> dict[str, list[float]]:
    parts: dict[str, list[float]] = {}
    for name, angles in joints.items():
        parts.setdefault(name.partition(",")[0], []).extend(float(angle) % 360 for angle in angles)
    return parts


def _curves(
    axes: Axes, cycles: Mapping[str, Curve], before: Mapping[str, Curve], weight: float, gap: float
) -> None:
    ends = []
    for index, (label, (phi, force)) in enumerate(cycles.items()):
        shade = style.curve_colour(label, index)
        if label in before:
            axes.plot(
                *before[label],
                color=shade,
                linewidth=0.9,
                linestyle=(0, (4, 2)),
                label=f"{label}, before",
            )
        axes.plot(phi, force, color=shade, label=label)
        ends.append((float(force[-1]), label, shade))
    axes.axhline(weight, color=style.INK, linewidth=0.8, linestyle=(0, (1, 2)), label="weight")
    ends.append((weight, f"weight {weight:.1f} N", style.INK))
    axes.set_ylabel("support force / N")
    axes.grid(visible=False, axis="x")
    axes.margins(y=0.08)
    style.label_ends(axes, ends, gap)


def _bars(
    axes: Axes, cycles: Mapping[str, Curve], reference: Mapping[str, tuple[float, float]]
) -> None:
    """Draw bars from the smallest to the largest force: those of the models, then those of the
    reference.
    """
    extremes = {
        label: (float(force.max()), float(force.min())) for label, (_, force) in cycles.items()
    }
    rows = extremes | dict(reference)
    for row, (label, (high, low)) in enumerate(rows.items()):
        shade = style.curve_colour(label, row) if label in extremes else style.SOFT
        axes.plot(
            [low, high], [row, row], color=shade, linewidth=4, solid_capstyle="butt", label=label
        )
        for force, offset, side in ((low, -4, "right"), (high, 4, "left")):
            axes.annotate(
                f"{force:.2f}".replace("-", "\N{MINUS SIGN}"),
                (force, row),
                (offset, 0),
                textcoords="offset points",
                ha=side,
                va="center",
            )
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks(range(len(rows)), list(rows))
    axes.margins(x=0.12)
    axes.tick_params(left=False)
    axes.spines["left"].set_visible(False)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("support force, smallest to largest / N")


def _strip(axes: Axes, joints: Mapping[str, Sequence[float]]) -> None:
    """A row of ticks for each part: where the curves may have a kink."""
    for row, (part, angles) in enumerate(joints.items()):
        axes.plot(angles, [row] * len(angles), "|", color=style.SOFT, markersize=6, label=part)
    axes.set_title("angles where gears, cam or tooth contact change regime")
    axes.set_ylim(len(joints) - 0.4, -0.6)
    axes.set_yticks(range(len(joints)), list(joints))
    axes.tick_params(left=False)
    axes.spines["left"].set_visible(False)
    axes.grid(False)


def _faint_lines(axes: Axes, joints: Mapping[str, Sequence[float]]) -> None:
    for angle in sorted({angle for angles in joints.values() for angle in angles}):
        axes.axvline(angle, color=style.FAINT, linewidth=0.4, alpha=0.5, zorder=0.5, gid="joint")


@style.with_style
def draw_joint_forces(cycles: Mapping[str, Mapping[str, Array]], every_deg: int = 30) -> Figure:
    """Polar load diagrams of the joints: the tip of the force vector over a turn, for each model.

    `cycles` holds columns of a turn, `phi_deg` and `F_A1x_N`, `F_A1y_N` and so on. Dots stand every
    `every_deg` of carrier angle; those a quarter turn apart are named. Distance from the cross is
    the size of the force.
    """
    figure = style.new_figure(6.9)
    for axes, (name, title) in zip(figure.subplots(2, 2).flat, JOINTS.items(), strict=True):
        for index, (model, columns) in enumerate(cycles.items()):
            _hodograph(axes, model, columns, name, style.curve_colour(model, index), every_deg)
        _polar_grid(axes, _name_angles(axes, cycles, name))
        axes.set_title(title)
        style.drawing_board(axes, "Fx / N", "Fy / N")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return figure


def _hodograph(
    axes: Axes, model: str, columns: Mapping[str, Array], name: str, shade: str, step_deg: int
) -> None:
    x, y = columns[f"{name}x_N"], columns[f"{name}y_N"]
    axes.plot(
        np.append(x, x[0]), np.append(y, y[0]), color=shade, linewidth=1.0, label=f"{model} model"
    )
    marks = [_index(columns, angle) for angle in range(0, 360, step_deg)]
    axes.plot(x[marks], y[marks], "o", color=shade, markersize=2.2)


def _index(columns: Mapping[str, Array], angle: float) -> int:
    return int(np.argmin(np.abs(columns["phi_deg"] - angle)))


def _name_angles(
    axes: Axes, cycles: Mapping[str, Mapping[str, Array]], name: str
) -> list[tuple[Array, Array]]:
    """Write quarter turns next to their dots, and return the dots and the offsets [points] of their
    names.

    A dot too close to one that has its name already goes without.
    """
    forces = {model: np.array([c[f"{name}x_N"], c[f"{name}y_N"]]) for model, c in cycles.items()}
    size = max(float(np.ptp(force, axis=1).max()) for force in forces.values())
    labelled_points: list[Array] = []
    names: list[tuple[Array, Array]] = []
    for index, (model, columns) in enumerate(cycles.items()):
        for angle in (0, 90, 180, 270):
            point = forces[model][:, _index(columns, angle)]
            if all(np.hypot(*(point - other)) > 0.12 * size for other in labelled_points):
                shade = style.curve_colour(model, index)
                i = _index(columns, angle)
                direction = (
                    forces[model][:, (i + 1) % len(columns["phi_deg"])] - forces[model][:, i - 1]
                )
                offset = np.array([direction[1], -direction[0]]) / max(
                    float(np.hypot(*direction)), 1e-12
                )
                offset *= 11 if offset @ (point - forces[model].mean(axis=1)) >= 0 else -11
                axes.annotate(
                    f"{angle}°",
                    tuple(point),
                    (float(offset[0]), float(offset[1])),
                    color=shade,
                    ha="center",
                    va="center",
                    textcoords="offset points",
                    bbox=style.CLEAR,
                )
                labelled_points.append(point)
                names.append((point, offset))
    return names


POINTS = 170.0
"""Width of a diagram, about [points]."""


def _polar_grid(axes: Axes, names: Sequence[tuple[Array, Array]]) -> None:
    """Circles about the origin, where the force is zero, with radii beside the curves and `names`
    with offsets.
    """
    from matplotlib.patches import Circle
    from matplotlib.ticker import MaxNLocator

    axes.plot(0, 0, "+", color=style.INK, markersize=7, markeredgewidth=0.8)
    axes.grid(False)
    farthest = 1.5 * max(np.hypot(x, y) for x in axes.get_xlim() for y in axes.get_ylim())
    limits = axes.get_xlim(), axes.get_ylim()
    extent = np.ptp(np.array(limits), axis=1)
    lines = [np.asarray(line.get_xydata()) for line in axes.get_lines()]
    points = np.vstack([*lines, *(point + offset * extent / POINTS for point, offset in names)])
    for radius in MaxNLocator(9).tick_values(0, float(farthest))[1:]:
        # As an artist, not a patch: a circle does not widen the axes.
        axes.add_artist(
            Circle((0, 0), radius, fill=False, edgecolor=style.FAINT, alpha=0.5, linewidth=0.5)
        )
        place = _free_place(float(radius), limits, points)
        if place is not None:
            axes.text(
                *place, f"{radius:g}", fontsize=6.5, color=style.SOFT, ha="center", va="center"
            )


def _free_place(
    radius: float, limits: tuple[tuple[float, float], ...], points: Array
) -> tuple[float, float] | None:
    """The place of a circle about zero, well within limits, that is farthest from what is drawn."""
    angles = np.radians(np.arange(0, 360, 5))
    places = radius * np.array([np.cos(angles), np.sin(angles)]).T
    low, high = np.array(limits).T
    inset = 0.06 * (high - low)
    inside = places[((places > low + inset) & (places < high - inset)).all(axis=1)]
    if not len(inside):
        return None
    gaps = np.hypot(*(inside[:, None, :] - points[None, :, :]).T).min(axis=0)
    x, y = inside[int(np.argmax(gaps))]
    return float(x), float(y)
