"""Figures of a synthesis: poses with the circles of their dyads, linkages with coupler paths, the angle curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.mapping import model
from planter.numerics.arrays import TURN
from planter.report import style
from planter.view.scene import refine_places

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.mapping.curve import AngleCurve
    from planter.mapping.dyads import Dyad
    from planter.mapping.linkage import FourBar
    from planter.mapping.synthesis import Linkage, Synthesis

MM = 1e3
DENSE = np.linspace(0, TURN, 721)
MOMENTS = 120
"""Moments of a cycle from which those that are drawn are refined."""
_ARROW = 0.13
"""Length of a pose's arrow in parts of the extent of the poses."""
_WIDEST = 4
"""Circles with a larger radius than this, in extents of the poses, are not drawn."""


def drawn_shares(bar: FourBar, circuit: int) -> Array:
    """Shares (n,) of the way along a circuit, from 0 to below 1, at which straight pieces follow its curves."""

    def sample(shares: Array) -> list[Array]:
        path = bar.path_at(circuit, shares)
        return [*path.tip, path.phi, path.transmission]

    return refine_places(sample, np.linspace(0.0, 1.0, MOMENTS + 1))[:-1]


@style.drawn
def dyads(synthesis: Synthesis) -> Figure:
    """Poses, and for each dyad its circle, fixed hinge and the places of its moving hinge; members of a family."""
    figure = style.new_figure(6.4)
    axes = figure.subplots()
    extent = _extent(synthesis.poses)
    for number, dyad in enumerate(synthesis.solution.dyads, 1):
        if dyad.radius < _WIDEST * extent:
            _circle(axes, dyad, synthesis.poses, style.PALETTE[(number - 1) % len(style.PALETTE)], f"dyad {number}")
    if synthesis.members:
        _family(
            axes, [d for d in synthesis.members if np.hypot(*(d.centre - synthesis.poses[0, :2])) < _WIDEST * extent]
        )
    poses(axes, synthesis.poses)
    style.drawing_board(axes, "X / mm", "Y / mm")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, loc="best")
    return figure


def _extent(poses: Array) -> float:
    return float(np.ptp(poses[:, :2], axis=0).max()) or 1.0


def _circle(axes: Axes, dyad: Dyad, poses: Array, shade: str, label: str) -> None:
    x, y = MM * (dyad.centre[:, None] + dyad.radius * np.array([np.cos(DENSE), np.sin(DENSE)]))
    axes.plot(x, y, color=shade, linewidth=0.9, label=label)
    axes.plot(*MM * dyad.centre, "+", color=shade, markersize=8)
    hinges = MM * model.place_point(poses, dyad.point)
    axes.plot(*hinges.T, "o", color=style.PAPER, markeredgecolor=shade, markersize=4)
    for tip, hinge in zip(MM * poses[:, :2], hinges, strict=True):
        axes.plot(*np.array([tip, hinge]).T, color=shade, linewidth=0.5, alpha=0.6)


def _family(axes: Axes, members: list[Dyad]) -> None:
    for places, label, shade in (
        (np.array([d.centre for d in members]), "centres of the family", style.BLUE),
        (np.array([d.point for d in members]), "moving points, in the frame of the arm", style.VERMILION),
    ):
        axes.plot(*MM * places.T, ".", color=shade, markersize=3, label=label)


def poses(axes: Axes, placements: Array) -> None:
    """Poses (n, 3) as numbered arrows along the arm's x axis; numbers of places close together stand apart."""
    length = _ARROW * _extent(placements)
    tips = placements[:, :2]
    for number, (place, angle) in enumerate(zip(tips, placements[:, 2], strict=True), 1):
        ahead = place + length * np.array([np.cos(angle), np.sin(angle)])
        axes.update_datalim([MM * (place + 1.3 * (ahead - place))])
        axes.annotate("", MM * ahead, MM * place, arrowprops={"arrowstyle": "-|>", "color": style.INK, "lw": 0.9})
        axes.plot(*MM * place, "o", color=style.INK, markersize=3, zorder=5)
        side = 7 * np.array([np.cos(angle), np.sin(angle)])
        at = (float(MM * ahead[0]), float(MM * ahead[1]))
        axes.annotate(str(number), at, (float(side[0]), float(side[1])), textcoords="offset points", ha="center",
                      va="center", zorder=6, bbox=style.CLEAR)  # fmt: skip


@style.drawn
def linkage(solution: Linkage, pose_rows: Array) -> Figure:
    """A four-bar linkage at the poses, and the path of the tip on both circuits."""
    figure = style.new_figure(6.4)
    axes = figure.subplots()
    for circuit in range(1, len(solution.bar.reaches) + 1):
        path = solution.bar.path_at(circuit, drawn_shares(solution.bar, circuit))
        tip = MM * np.column_stack([path.tip, path.tip[:, :1]])
        axes.plot(*tip, color=style.PALETTE[circuit - 1], label=f"path of the tip, circuit {circuit}")
    for standing, tip in zip(solution.standings, pose_rows[:, :2], strict=True):
        shade = style.PALETTE[standing.circuit - 1]
        chain = np.array([solution.bar.crank.centre, *standing.hinges, solution.bar.follower.centre])
        axes.plot(*MM * chain.T, color=shade, linewidth=0.7, alpha=0.7)
        body = np.array([*standing.hinges, tip])
        axes.fill(*MM * body.T, facecolor=shade, alpha=0.08, edgecolor=shade, linewidth=0.4)
        axes.plot(*MM * standing.hinges.T, "o", color=style.PAPER, markeredgecolor=shade, markersize=3.5)
    for centre in (solution.bar.crank.centre, solution.bar.follower.centre):
        axes.plot(*MM * centre, "^", color=style.INK, markersize=6)
    poses(axes, pose_rows)
    style.drawing_board(axes, "X / mm", "Y / mm")
    axes.set_title(f"dyads {solution.numbers[0]} and {solution.numbers[1]}: {solution.bar.type}")
    axes.legend(frameon=False, loc="best")
    return figure


@style.drawn
def angle_curve(synthesis: Synthesis) -> Figure:
    """Rotation of the arm against the carrier over a turn: through the exact poses, and the curves of the results."""
    figure = style.new_figure(6.2)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.5, 1])
    curves = [
        ("through the poses", synthesis.exact, style.SOFT, (0, (4, 3))),
        ("closest monotone", synthesis.nearest.curve if synthesis.nearest else None, style.BLUE, "-"),
        ("points of both paths", synthesis.path_curve, style.VERMILION, "-"),
    ]
    start = _start(synthesis)
    for label, curve, shade, dashes in curves:
        if curve is not None:
            top.plot(np.degrees(DENSE), _falling(curve, start), color=shade, linestyle=dashes, label=label)
            bottom.plot(np.degrees(DENSE), curve.slopes(DENSE)[0], color=shade, linestyle=dashes)
    if synthesis.carrier is not None and synthesis.exact is not None:
        _exact_poses(top, synthesis.exact, synthesis.carrier, synthesis.poses, start)
    top.set_ylabel("arm angle relative to carrier / deg")
    top.legend(frameon=False, loc="best")
    bottom.axhline(0, color=style.INK, linewidth=0.7)
    bottom.set_ylabel("-d(arm)/d(carrier)")
    style.over_a_turn(bottom)
    bottom.set_xlabel("carrier angle θ / deg")
    return figure


def _start(synthesis: Synthesis) -> float:
    curve = synthesis.exact or (synthesis.nearest.curve if synthesis.nearest else None) or synthesis.path_curve
    return 0.0 if curve is None else float(curve.at(np.array([0.0]))[0])


def _falling(curve: AngleCurve, start: float) -> Array:
    """The curve [deg], by whole turns near another at carrier angle zero."""
    relative = curve.at(DENSE)
    return np.asarray(np.degrees(relative - TURN * np.round((relative[0] - start) / TURN)))


def _exact_poses(axes: Axes, curve: AngleCurve, dyad: Dyad, poses: Array, start: float) -> None:
    away = model.place_point(poses, dyad.point) - dyad.centre
    theta = np.mod(np.arctan2(away[:, 1], away[:, 0]), TURN)
    shift = TURN * np.round((float(curve.at(np.array([0.0]))[0]) - start) / TURN)
    relative = np.degrees(curve.at(theta) - shift)
    axes.plot(np.degrees(theta), relative, "o", color=style.PAPER, markeredgecolor=style.INK, markersize=5, zorder=5)
    for number, (x, y) in enumerate(zip(np.degrees(theta), relative, strict=True), 1):
        axes.annotate(str(number), (float(x), float(y)), (6, 6), textcoords="offset points")
