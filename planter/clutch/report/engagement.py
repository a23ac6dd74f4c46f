"""Figures of a clutch's engagement."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from planter.clutch.contact_dynamics import ANGLE, FREE, REULEAUX, TRAVEL
from planter.clutch.geometry import SIDES, VERTICES
from planter.clutch.rotor import Rotor, body_outline, polygon_outline
from planter.kernels import formulas
from planter.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.clutch.contact_simulation import ContactRun, SwitchingRun
    from planter.clutch.modal_engagement import Modal
    from planter.clutch.results import ContactLoadSensitivity
    from planter.kernels import Array

Mask = NDArray[np.bool_]
BINS = 900
COLOURS = {"reuleaux": style.BLUE, "dog": style.VERMILION}
LABELS = {"reuleaux": "Reuleaux", "dog": "dog"}
LINK = "link angle / deg"
LOAD_TICKS = tuple(digit * 10.0**power for power in range(5) for digit in (1, 2, 5))


def thin_curve(x: Array, y: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Return the smallest and largest value of each of many parts of a curve (n,), in their
    order.
    """
    if len(x) <= 2 * bins:
        return x, y
    edges = np.linspace(0, len(x), bins + 1).astype(int)
    extremes = [_extremes(y, a, b) for a, b in pairwise(edges)]
    index = np.array([0, *(i for pair in extremes for i in pair), len(x) - 1])
    return x[index], y[index]


def _extremes(y: Array, a: int, b: int) -> list[int]:
    return sorted({a + int(np.argmin(y[a:b])), a + int(np.argmax(y[a:b]))})


def _while_moving(run: ContactRun) -> Mask:
    return (run.time >= 0) & (run.time <= run.inputs.switching_s)


@style.with_style
def draw_loads(runs: Mapping[str, SwitchingRun]) -> Figure:
    """Contact loads of both clutches at engagement over the falling link angle, and the dog
    clutch's impact in time.
    """
    figure = style.new_figure(3.2)
    left, right = figure.subplots(1, 2, width_ratios=[1.8, 1])
    for name, run in runs.items():
        moving = _while_moving(run.engagement)
        angle, load = run.engagement.link_deg[moving], run.engagement.load[moving]
        left.plot(*thin_curve(angle, load), color=COLOURS[name], linewidth=0.9, label=LABELS[name])
        time, load = _round_the_peak(run.engagement)
        right.plot(time, load, color=COLOURS[name], linewidth=1.0)
    left.invert_xaxis()
    left.set_xlabel(LINK)
    left.set_ylabel("contact load / N")
    left.legend(frameon=False, loc="upper left")
    right.set_xlabel("time from 80 % of the peak / ms")
    right.set_title("round the peak")
    return figure


def _round_the_peak(run: ContactRun) -> tuple[Array, Array]:
    """Load from 3 ms before the first time at which it reaches 80 % of its peak to 9 ms after it,
    in ms.
    """
    peak_time = run.time[np.flatnonzero(run.load >= 0.8 * run.load.max())[0]]
    window = np.abs(run.time - peak_time - 3e-3) <= 6e-3
    return 1e3 * (run.time[window] - peak_time), run.load[window]


@style.with_style
def draw_speeds(runs: Mapping[str, SwitchingRun]) -> Figure:
    """Output speed of both clutches over the link angle: falling at engagement, rising at
    cut-off.
    """
    figure = style.new_figure(3.0)
    panels = figure.subplots(1, 2, sharey=True)
    for name, switching in runs.items():
        for axes, run in zip(panels, (switching.engagement, switching.cut_off), strict=True):
            moving = _while_moving(run)
            rpm = run.speed[moving] * 30 / math.pi
            axes.plot(
                *thin_curve(run.link_deg[moving], rpm),
                color=COLOURS[name],
                linewidth=0.9,
                label=LABELS[name],
            )
            axes.set_xlabel(LINK)
    panels[0].invert_xaxis()
    panels[0].set_title("engagement")
    panels[1].set_title("cut-off")
    panels[0].set_ylabel("output speed / (r/min)")
    panels[1].legend(frameon=False, loc="upper right")
    return figure


@style.with_style
def draw_section(run: ContactRun) -> Figure:
    """Teeth, outline and sleeve round the shaft, as it sees them: when cut off, and when engaged;
    lengths in mm.
    """
    figure = style.new_figure(3.8)
    for axes, index, title in zip(
        figure.subplots(1, 2), (0, -1), ("cut off", "engaged"), strict=True
    ):
        _pose(axes, run, index)
        axes.set_title(title)
        style.drawing_board(axes)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return figure


def _pose(axes: Axes, run: ContactRun, index: int) -> None:
    inputs, state = run.inputs, run.states[:, index]
    model = formulas.load(REULEAUX)
    seen = model.at("seen", places=[*state[:FREE], state[ANGLE], run.seen["pushed"][0, index]])
    sizes = {name: inputs.packed(model.entries(name)) for name in ("tooth_shape", "hole_shape")}
    section_sizes = model.at("section", **sizes, way=state[TRAVEL])
    centre, angle = 1e3 * np.array([seen["c_x"], seen["c_y"]]), seen["heading"]
    shaft = 1e3 * polygon_outline(SIDES, inputs.apothem, inputs.fillet)
    hole = 1e3 * polygon_outline(SIDES, section_sizes["room"])
    axes.fill(*shaft, color=style.FAINT, alpha=0.5, linewidth=0)
    axes.plot(*shaft, color=style.INK, linewidth=1.0, label="shaft")
    axes.plot(*hole, color=style.SOFT, linewidth=1.0, label="sleeve, its hole")
    body = body_outline(Rotor(VERTICES, SIDES, inputs.width), angle, centre * 1e-3)
    axes.plot(
        *(1e3 * np.hstack([body, body[:, :1]])), color=style.BLUE, linewidth=1.0, label="polygon"
    )
    for number, tooth in enumerate(_teeth(run, angle, section_sizes["half_tooth"])):
        name = "teeth" if number == 0 else None
        axes.plot(
            *(1e3 * tooth + centre[:, None]), color=style.VERMILION, linewidth=1.6, label=name
        )
    axes.plot(0, 0, "+", color=style.INK, markersize=5, linestyle="none", label="its axis")
    axes.plot(*centre, "x", color=style.BLUE, markersize=4, linestyle="none", label="its centroid")


def _teeth(run: ContactRun, angle: float, half: float) -> list[Array]:
    """Faces of each tooth from root over tip to root (2, 3) round the centroid [m]."""
    radii = np.array([run.inputs.root, run.inputs.tip, run.inputs.root])
    middles = angle + 2 * math.pi * np.arange(VERTICES) / VERTICES
    return [
        radii * np.array([np.cos(a), np.sin(a)])
        for a in middles[:, None] + half * np.array([-1, 0, 1])
    ]


@style.with_style
def draw_sensitivity(rows: Sequence[ContactLoadSensitivity], reuleaux: float, dog: float) -> Figure:
    """Largest loads [N] of both clutches, each in a plot, while one input runs over a factor of
    10.
    """
    figure = style.new_figure(2.8)
    loads = {"Reuleaux": ("reuleaux_N_max_N", reuleaux), "dog": ("dog_N_max_N", dog)}
    factors = sorted({row.factor for row in rows} | {1.0})
    for axes, (title, (key, load)) in zip(
        figure.subplots(1, 2, sharey=True), loads.items(), strict=True
    ):
        ends = []
        for name, shade in zip(
            dict.fromkeys(row.input for row in rows), style.PALETTE, strict=False
        ):
            points = sorted(
                [
                    (1.0, load),
                    *((row.factor, getattr(row, key)) for row in rows if row.input == name),
                ]
            )
            axes.plot(*zip(*points, strict=True), "o-", color=shade, markersize=3)
            ends.append((points[-1][1], name, shade))
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel(f"factor on the input, {title}")
        axes.set_xticks(factors, [f"{factor:.3g}" for factor in factors])
        axes.set_xticks([], minor=True)
        style.label_ends(axes, ends, 0.15)
    ticks = [tick for tick in LOAD_TICKS if axes.get_ylim()[0] <= tick <= axes.get_ylim()[1]]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
    axes.set_yticks([], minor=True)
    figure.axes[0].set_ylabel("largest load / N")
    return figure


@style.with_style
def draw_modal_load(engagement: Modal, printed: Mapping[str, float]) -> Figure:
    """Load on the tooth over time in one mode, derived and by the printed formulas, until contact
    is lost.
    """
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    for name, at in (("exact", engagement.extremes), ("printed", printed)):
        time = np.linspace(0, at["t_loss"], 241)
        motion = formulas.load("clutch_beam")(
            "motion", t=time, B1=at["B1"], B2=at["B2"], struck=engagement.struck.packed
        )
        axes.plot(1e6 * time, motion["N"], color=style.curve_colour(name, 0), label=name)
    axes.axhline(0, color=style.SOFT, linewidth=0.6)
    axes.set_xlabel("time since contact / μs")
    axes.set_ylabel("load on the tooth / N")
    axes.legend(frameon=False)
    return figure
