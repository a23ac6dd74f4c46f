"""Figures of a clutch's engagement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import formulas
from planter.papers.clutch.report.drawings import build_engagement_scene
from planter.report.animation import draw_stills
from planter.report.style import Panel, Points, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.papers.clutch.contact_simulation import ContactRun, SwitchingRun
    from planter.papers.clutch.modal_engagement import Modal
    from planter.papers.clutch.results import ContactLoadSensitivity

BINS = 900
LINK = "link angle / deg"


def thin_curve(x: Array, y: Array, bins: int = BINS) -> Points:
    """Return the smallest and largest value of each of many parts of a curve (n,), in order."""
    if len(x) <= 2 * bins:
        return x, y
    chosen = {0, len(x) - 1}
    for part in np.array_split(np.arange(len(x)), bins):
        chosen |= {int(part[np.argmin(y[part])]), int(part[np.argmax(y[part])])}
    index = sorted(chosen)
    return x[index], y[index]


def _plot(run: ContactRun, values: Array) -> Points:
    """Values over the link angle while the link moves."""
    moving = (run.time >= 0) & (run.time <= run.inputs.switching_s)
    return thin_curve(run.link_deg[moving], values[moving])


def draw_contact(
    runs: Mapping[str, SwitchingRun],
    rows: Sequence[ContactLoadSensitivity],
    loads: Mapping[str, float],
) -> dict[str, Figure]:
    """Return figures of loads and speeds of both clutches, of the section, and of the loads [N]
    while inputs vary.
    """
    engaged = {name: run.engagement for name, run in runs.items()}
    cut_off = {name: run.cut_off for name, run in runs.items()}
    load = {name: _plot(run, run.load) for name, run in engaged.items()}
    speeds = [
        {name: _plot(run, run.speed * 30 / np.pi) for name, run in way.items()}
        for way in (engaged, cut_off)
    ]
    titles = ("engagement", "cut-off")
    scene = build_engagement_scene(engaged["reuleaux"])
    return {
        "load": draw_panels([Panel("contact load / N", load)], LINK, 3.0),
        "speed": draw_panels(
            [
                Panel("output speed / (r/min)", curves, title)
                for curves, title in zip(speeds, titles, strict=True)
            ],
            LINK,
        ),
        "section": draw_stills({"cut off": (scene, 0), "engaged": (scene, scene.moments - 1)}),
        "sensitivity": draw_sensitivity(rows, loads),
    }


def draw_sensitivity(rows: Sequence[ContactLoadSensitivity], loads: Mapping[str, float]) -> Figure:
    """Draw the largest loads [N] of both clutches while one input runs over a factor of 10."""
    panels = []
    for clutch, load in loads.items():
        curves: dict[str, Points] = {}
        for name in dict.fromkeys(row.input for row in rows):
            varied = [(r.factor, getattr(r, f"{clutch}_N_max_N")) for r in rows if r.input == name]
            factors, largest = np.array(sorted([(1.0, load), *varied])).T
            curves[name] = factors, largest
        panels.append(Panel("largest load / N", curves, clutch, is_log=True))
    return draw_panels(panels, "factor on the input")


def draw_modal_load(engagement: Modal, printed: Mapping[str, float]) -> Figure:
    """Draw the load on the tooth in one mode, derived and as printed, until contact is lost."""
    curves = {}
    for name, at in (("exact", engagement.extremes), ("printed", printed)):
        time = np.linspace(0, at["t_loss"], 241)
        rates = {"B1": at["B1"], "B2": at["B2"]}
        motion = formulas.load("clutch_beam")(
            "motion", t=time, **rates, struck=engagement.struck.packed
        )
        curves[name] = 1e6 * time, motion["N"]
    return draw_panels([Panel("load on the tooth / N", curves, level=0)], "time since contact / μs")
