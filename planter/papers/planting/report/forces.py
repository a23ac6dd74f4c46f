"""The figure of the support force over the cycle."""

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
) -> Figure:
    """Vertical support force over a turn, a curve for each model.

    `before` holds the same curves for the design that an optimisation started from; `joints_deg`
    the carrier angles where a derivative jumps, named as in the model's events (part, comma, what
    happens there). A model whose curve is too flat to be read on the common scale is shown again on
    its own.
    """
    before, joints = before or {}, _by_part(joints_deg or {})
    flat = _flat(cycles, before)
    heights = [2.9, *(1.4 for _ in flat)]
    heights += [LABEL * (len(joints) + 1)] if joints else []
    figure = style.new_figure(sum(heights) + 0.3 * len(heights) + 0.3)
    all_axes = list(figure.subplots(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0])
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
