"""Figures of a gear train: ratio and split, pitch curves on the carrier, path of the tip against the poses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.mapping import model
from planter.mapping.report.figures import MM, poses
from planter.mapping.train import GEARS
from planter.mapping.training import polar_curves
from planter.numerics.arrays import TURN
from planter.report import style
from planter.view.scene import refine_places

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.mapping.training import Training

_ARMS = 12
"""Carrier angles at which carrier and arm are drawn."""
_STRAIGHT = np.pi


@style.drawn
def ratios(training: Training) -> Figure:
    """The angle curve with its points, the total ratio, and the ratios of the two stages."""
    curve = training.train.curve
    named = (("i", "total"), ("i1", "stage 1"), ("i2", "stage 2"))

    def sample(theta: Array) -> list[Array]:
        gears = training.train.gears(theta)
        return [curve.at(theta), *(np.log(gears[name]) for name, _ in named)]

    theta = refine_places(sample, np.linspace(curve.carrier[0], curve.carrier[-1], 721))
    degrees, gears = np.degrees(theta), training.train.gears(theta)
    figure = style.new_figure(6.2)
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot(degrees, np.degrees(curve.at(theta)), color=style.BLUE)
    top.plot(np.degrees(curve.carrier), np.degrees(curve.relative), "o", color=style.PAPER,
             markeredgecolor=style.BLUE, markersize=4)  # fmt: skip
    top.set_ylabel("arm angle relative to carrier / deg")
    for index, (name, label) in enumerate(named):
        bottom.plot(degrees, gears[name], color=style.PALETTE[index], label=label)
    bottom.axhline(1, color=style.SOFT, linewidth=0.6, linestyle=(0, (4, 3)), zorder=1)
    bottom.set_yscale("log")
    bottom.yaxis.set_major_formatter("{x:g}")
    bottom.set_ylabel("ratio / 1")
    bottom.legend(frameon=False, loc="best")
    bottom.set_xlim(degrees[0], degrees[-1])
    bottom.set_xticks(np.arange(np.ceil(degrees[0] / 60) * 60, degrees[-1] + 1, 60))
    bottom.set_xlabel("carrier angle θ / deg")
    return figure


@style.drawn
def pitch_curves(training: Training) -> Figure:
    """The four pitch curves in mesh on the carrier at the first carrier angle, named where not convex."""
    figure = style.new_figure(5.4)
    axes = figure.subplots()
    hinges = MM * centres(training)
    for index, (name, outline) in enumerate(zip(GEARS, outlines(training), strict=True)):
        shade = style.PALETTE[index]
        place = hinges[:, (0, 1, 1, 2)[index]][:, None]
        axes.fill(*place + outline, facecolor=shade, alpha=0.06, edgecolor="none")
        axes.plot(*place + outline, color=shade, label=name if training.train.convex[index] else f"{name}, not convex")
    axes.plot(*hinges, color=style.INK, linewidth=0.7, linestyle=(0, (8, 2, 1, 2)), zorder=3)
    axes.plot(*hinges, "+", color=style.INK, markersize=7, zorder=4)
    style.drawing_board(axes)
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def centres(training: Training) -> Array:
    """Hinges of the carrier (2, 3) [m]: fixed, middle, moving; straight where the carrier's length is not known."""
    distance = training.train.distance
    bend = _STRAIGHT if training.crank is None else training.train.bend(training.crank)
    end = np.pi - bend
    return distance * np.array([[0, 1, 1 + np.cos(end)], [0, 0, np.sin(end)]])


def outlines(training: Training) -> list[Array]:
    """Pitch curves (2, n) [mm] about their centres, each turned to its mesh at the first carrier angle.

    A driver's contact lies towards its follower, a follower's towards its driver; on the gear the contact moves
    against its rotation, which is that of its mate reversed.
    """
    psi, radii = polar_curves(training.train)
    bend = _STRAIGHT if training.crank is None else training.train.bend(training.crank)
    towards = np.array([0.0, np.pi, np.pi - bend, -bend])
    senses = (1, -1, -1, 1)
    return [
        MM * radii[k] * np.array([np.cos(towards[k] + senses[k] * psi[k]), np.sin(towards[k] + senses[k] * psi[k])])
        for k in range(4)
    ]


@style.drawn
def tip_path(training: Training) -> Figure:
    """The path of the tip as the train drives it, carrier and arm on the way, and the poses."""
    assert training.dyad is not None
    assert training.poses is not None
    curve, vector = training.train.curve, training.dyad.vector

    def sample(theta: Array) -> Array:
        """Tip and moving hinge (4, n) [mm]."""
        return MM * model.arm(theta, curve.at(theta) + theta, vector)

    theta = refine_places(sample, training.train.motion(training.dyad)["theta"])
    places = sample(theta)
    figure = style.new_figure(6.4)
    axes = figure.subplots()
    axes.plot(*places[2:], color=style.FAINT, linewidth=0.8, linestyle=(0, (4, 3)), label="moving hinge")
    axes.plot(*places[:2], color=style.BLUE, linewidth=1.5, label="tip")
    _arms(axes, theta, places, MM * training.dyad.centre)
    axes.plot(*MM * training.dyad.centre, "^", color=style.INK, markersize=6)
    poses(axes, training.poses)
    style.drawing_board(axes, "X / mm", "Y / mm")
    axes.legend(frameon=False, loc="best")
    return figure


def _arms(axes: Axes, theta: Array, places: Array, centre: Array) -> None:
    for angle in theta[0] + TURN * np.arange(_ARMS) / _ARMS:
        k = int(np.argmin(np.abs(theta - angle)))
        axes.plot(*np.array([centre, places[2:, k]]).T, color=style.FAINT, linewidth=0.7)
        axes.plot(*np.array([places[2:, k], places[:2, k]]).T, color=style.SOFT, linewidth=0.6, alpha=0.7)
