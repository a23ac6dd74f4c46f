"""Figures of syntheses and gear trains: poses with dyads, coupler paths, angle curve, ratios, pitch
curves, tip.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.mapping import model
from planter.mapping.train import GEARS, polar_curves
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
    from planter.mapping.train import Training


MM = 1e3
DENSE = np.linspace(0, TURN, 721)
MOMENTS = 120
"""Moments of a cycle from which those that are drawn are refined."""
_ARROW = 0.13
"""Length of a pose's arrow in parts of the extent of the poses."""
_LEAST_GAP = 0.025
"""Ends of arrows closer than this, in parts of what is drawn, share the text with their numbers."""
_WIDEST = 4
"""Circles with a larger radius than this, in extents of the poses, are not drawn."""


def drawn_shares(bar: FourBar, circuit: int) -> Array:
    """Shares (n,) of the way along a circuit, from 0 to below 1, at which straight pieces follow
    its curves.
    """

    def sample(shares: Array) -> list[Array]:
        path = bar.path_at(circuit, shares)
        return [*path.tip, path.phi, path.transmission]

    return refine_places(sample, np.linspace(0.0, 1.0, MOMENTS + 1))[:-1]


@style.with_style
def dyads(synthesis: Synthesis) -> Figure:
    """Poses, and for each dyad its circle, fixed hinge and the places of its moving hinge; members
    of a family.
    """
    figure = style.new_figure(6.4)
    axes = figure.subplots()
    extent = _extent(synthesis.poses)
    for number, dyad in enumerate(synthesis.solution.dyads, 1):
        if dyad.radius < _WIDEST * extent:
            _circle(
                axes,
                dyad,
                synthesis.poses,
                style.PALETTE[(number - 1) % len(style.PALETTE)],
                f"dyad {number}",
            )
    if synthesis.members:
        _family(
            axes,
            [
                d
                for d in synthesis.members
                if np.hypot(*(d.centre - synthesis.poses[0, :2])) < _WIDEST * extent
            ],
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
        (
            np.array([d.point for d in members]),
            "moving points, in the frame of the arm",
            style.VERMILION,
        ),
    ):
        axes.plot(*MM * places.T, ".", color=shade, markersize=3, label=label)


def poses(axes: Axes, placements: Array) -> None:
    """Poses (n, 3) as numbered arrows along the arm's x axis; numbers of ends close together stand
    in one text.
    """
    length = _ARROW * _extent(placements)
    named: list[tuple[Array, Array, str]] = []
    for number, (x, y, angle) in enumerate(placements, 1):
        place, direction = np.array([x, y]), np.array([np.cos(angle), np.sin(angle)])
        ahead = place + length * direction
        axes.update_datalim([MM * (place + 1.3 * (ahead - place))])
        end, begin = ((float(a), float(b)) for a, b in (MM * ahead, MM * place))
        axes.annotate(
            "", end, begin, arrowprops={"arrowstyle": "-|>", "color": style.INK, "lw": 0.9}
        )
        axes.plot(*MM * place, "o", color=style.INK, markersize=3, zorder=5)
        named.append((MM * ahead, 7 * direction, str(number)))
    gap = _LEAST_GAP * max(axes.dataLim.width, axes.dataLim.height)
    while named:
        ahead, offset, _ = named[0]
        group = [entry for entry in named if np.hypot(*(entry[0] - ahead)) < gap]
        named = [entry for entry in named if np.hypot(*(entry[0] - ahead)) >= gap]
        text, (x, y), (dx, dy) = (
            ", ".join(number for *_, number in group),
            ahead.tolist(),
            offset.tolist(),
        )
        axes.annotate(
            text,
            (x, y),
            (dx, dy),
            textcoords="offset points",
            ha="center",
            va="center",
            zorder=6,
            bbox=style.CLEAR,
        )


@style.with_style
def linkage(solution: Linkage, pose_rows: Array) -> Figure:
    """A four-bar linkage at the poses, and the path of the tip on both circuits."""
    figure = style.new_figure(6.4)
    axes = figure.subplots()
    for circuit in range(1, len(solution.bar.reaches) + 1):
        path = solution.bar.path_at(circuit, drawn_shares(solution.bar, circuit))
        tip = MM * np.column_stack([path.tip, path.tip[:, :1]])
        axes.plot(
            *tip, color=style.PALETTE[circuit - 1], label=f"path of the tip, circuit {circuit}"
        )
    for standing, tip in zip(solution.standings, pose_rows[:, :2], strict=True):
        shade = style.PALETTE[standing.circuit - 1]
        chain = np.array(
            [solution.bar.crank.centre, *standing.hinges, solution.bar.follower.centre]
        )
        axes.plot(*MM * chain.T, color=shade, linewidth=0.7, alpha=0.7)
        body = np.array([*standing.hinges, tip])
        axes.fill(*MM * body.T, facecolor=shade, alpha=0.08, edgecolor=shade, linewidth=0.4)
        axes.plot(
            *MM * standing.hinges.T, "o", color=style.PAPER, markeredgecolor=shade, markersize=3.5
        )
    for centre in (solution.bar.crank.centre, solution.bar.follower.centre):
        axes.plot(*MM * centre, "^", color=style.INK, markersize=6)
    poses(axes, pose_rows)
    style.drawing_board(axes, "X / mm", "Y / mm")
    axes.set_title(f"dyads {solution.numbers[0]} and {solution.numbers[1]}: {solution.bar.type}")
    axes.legend(frameon=False, loc="best")
    return figure


@style.with_style
def angle_curve(synthesis: Synthesis) -> Figure:
    """Rotation of the arm against the carrier over a turn: through the exact poses, and the curves
    of the results.
    """
    figure = style.new_figure(6.2)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.5, 1])
    curves = [
        ("through the poses", synthesis.exact, style.SOFT, (0, (4, 3))),
        (
            "closest monotone",
            synthesis.nearest.curve if synthesis.nearest else None,
            style.BLUE,
            "-",
        ),
        ("points of both paths", synthesis.path_curve, style.VERMILION, "-"),
    ]
    start = _start(synthesis)
    for label, curve, shade, dashes in curves:
        if curve is not None:
            top.plot(
                np.degrees(DENSE),
                _falling(curve, start),
                color=shade,
                linestyle=dashes,
                label=label,
            )
            bottom.plot(np.degrees(DENSE), curve.slopes(DENSE)[0], color=shade, linestyle=dashes)
    if synthesis.carrier is not None and synthesis.exact is not None:
        _exact_poses(top, synthesis.exact, synthesis.carrier, synthesis.poses, start)
    top.set_ylabel("arm angle relative to carrier / deg")
    top.legend(frameon=False, loc="best")
    bottom.axhline(0, color=style.INK, linewidth=0.7)
    bottom.set_ylabel(r"$-$d(arm)/d(carrier)")
    style.over_a_turn(bottom)
    bottom.set_xlabel("carrier angle θ / deg")
    return figure


def _start(synthesis: Synthesis) -> float:
    curve = (
        synthesis.exact
        or (synthesis.nearest.curve if synthesis.nearest else None)
        or synthesis.path_curve
    )
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
    axes.plot(
        np.degrees(theta),
        relative,
        "o",
        color=style.PAPER,
        markeredgecolor=style.INK,
        markersize=5,
        zorder=5,
    )
    for number, (x, y) in enumerate(zip(np.degrees(theta), relative, strict=True), 1):
        axes.annotate(str(number), (float(x), float(y)), (6, 6), textcoords="offset points")


_ARMS = 12
"""Carrier angles at which carrier and arm are drawn."""
_STRAIGHT = np.pi


@style.with_style
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
    top.plot(
        np.degrees(curve.carrier),
        np.degrees(curve.relative),
        "o",
        color=style.PAPER,
        markeredgecolor=style.BLUE,
        markersize=4,
    )
    top.set_ylabel("arm angle relative to carrier / deg")
    for index, (name, label) in enumerate(named):
        bottom.plot(degrees, gears[name], color=style.PALETTE[index], label=label)
    bottom.axhline(1, color=style.SOFT, linewidth=0.6, linestyle=(0, (4, 3)), zorder=1)
    bottom.set_yscale("log")
    bottom.yaxis.set_major_formatter("{x:g}")
    bottom.yaxis.set_minor_formatter("{x:g}")
    bottom.set_ylabel("ratio / 1")
    bottom.legend(frameon=False, loc="best")
    bottom.set_xlim(degrees[0], degrees[-1])
    bottom.set_xticks(np.arange(np.ceil(degrees[0] / 60) * 60, degrees[-1] + 1, 60))
    bottom.set_xlabel("carrier angle θ / deg")
    return figure


@style.with_style
def pitch_curves(training: Training) -> Figure:
    """The four pitch curves in mesh on the carrier at the first carrier angle, named where not
    convex.
    """
    figure = style.new_figure(5.4)
    axes = figure.subplots()
    hinges = MM * centres(training)
    for index, (name, outline) in enumerate(zip(GEARS, outlines(training), strict=True)):
        shade = style.PALETTE[index]
        place = hinges[:, (0, 1, 1, 2)[index]][:, None]
        axes.fill(*place + outline, facecolor=shade, alpha=0.06, edgecolor="none")
        axes.plot(
            *place + outline,
            color=shade,
            label=name if training.train.convex[index] else f"{name}, not convex",
        )
    axes.plot(*hinges, color=style.INK, linewidth=0.7, linestyle=(0, (8, 2, 1, 2)), zorder=3)
    axes.plot(*hinges, "+", color=style.INK, markersize=7, zorder=4)
    style.drawing_board(axes)
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def centres(training: Training) -> Array:
    """Hinges of the carrier (2, 3) [m]: fixed, middle, moving; straight where the carrier's length
    is not known.
    """
    distance = training.train.distance
    bend = _STRAIGHT if training.crank is None else training.train.bend(training.crank)
    end = np.pi - bend
    return distance * np.array([[0, 1, 1 + np.cos(end)], [0, 0, np.sin(end)]])


def outlines(training: Training) -> list[Array]:
    """Pitch curves (2, n) [mm] about their centres, each turned to its mesh at the first carrier
    angle.

    A driver's contact lies towards its follower, a follower's towards its driver; on the gear the
    contact moves against its rotation, which is that of its mate reversed.
    """
    psi, radii = polar_curves(training.train)
    bend = _STRAIGHT if training.crank is None else training.train.bend(training.crank)
    towards = np.array([0.0, np.pi, np.pi - bend, -bend])
    senses = (1, -1, -1, 1)
    return [
        MM
        * radii[k]
        * np.array(
            [np.cos(towards[k] + senses[k] * psi[k]), np.sin(towards[k] + senses[k] * psi[k])]
        )
        for k in range(4)
    ]


@style.with_style
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
    axes.plot(
        *places[2:], color=style.FAINT, linewidth=0.8, linestyle=(0, (4, 3)), label="moving hinge"
    )
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
        axes.plot(
            *np.array([places[2:, k], places[:2, k]]).T, color=style.SOFT, linewidth=0.6, alpha=0.7
        )
