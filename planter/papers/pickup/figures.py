"""Figures of the seedling pick-up: path with tray, pitch curves with locking arcs, contact ratio,
motion, law.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from planter.numerics.arrays import TURN
from planter.papers.pickup.scene import build_pickup_scene
from planter.report.animation import draw_stills
from planter.report.style import Panel, Points, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.papers.pickup.file import Pickup
    from planter.papers.pickup.model import PickupTrain

DENSE = 1441
ADDENDA = (1.0, 1.1, 1.2, 1.3)
"""Addendum coefficients of the first part of Fig. 9 [-]."""
MODULES_MM = (1.5, 2.0, 2.5, 3.0)
"""Modules of its second part."""
GEARS = ("sun", "intermediate gear")


def draw_figures(
    machine: Pickup,
    train: PickupTrain,
    before: PickupTrain | None = None,
    path: Array | None = None,
) -> dict[str, Figure]:
    """Return all figures of a pick-up; `before` is its train before the redesign, `path` (n, 2) [m]
    the value points then.
    """
    scene = build_pickup_scene(machine, train, path)
    gears = replace(scene, bodies=[b for b in scene.bodies if b.name in GEARS], points=())
    stills = {"tip farthest, t = 0°": (gears, 0)}
    dwell, shaded = train.law.dwell, []
    if dwell is not None:
        middle = float(np.degrees(dwell.start + dwell.end)) / 2
        stills[f"in the dwell, t = {middle:.4g}°"] = (
            gears,
            int(np.searchsorted(scene.places, middle)),
        )
        shaded = [(float(np.degrees(dwell.start)), float(np.degrees(dwell.end)))]
    panels = {
        "contact_ratio": _plot_contact_ratio(train),
        "tip_motion": _plot_motion(train),
        "law": _plot_law(train, before),
    }
    axis = "carrier angle t from the farthest tip / deg"
    return {
        "path": draw_stills({"": (scene, 0)}, 5.4),
        "pitch_curves": draw_stills(stills),
    } | {
        name: draw_panels(parts, axis, 1.9, shaded=shaded, end=360.0)
        for name, parts in panels.items()
    }


def _plot_contact_ratio(train: PickupTrain) -> list[Panel]:
    """Contact ratio of the non-circular pair, for several addenda and several modules (Fig. 9)."""
    t = train.samples(DENSE)
    addenda = {f"{ha:g}": train.contact_ratio(t, addendum=ha) for ha in ADDENDA}
    modules = {f"{m:g}": train.contact_ratio(t, module=m / 1000) for m in MODULES_MM}
    titles = (
        f"module {train.teeth[0] * 1000:g} mm, by addendum coefficient",
        f"addendum coefficient {train.teeth[1]:g}, by module / mm",
    )
    return [
        Panel("contact ratio", {name: _over_turn(train, t, y) for name, y in series.items()}, title)
        for title, series in zip(titles, (addenda, modules), strict=True)
    ]


def _plot_motion(train: PickupTrain) -> list[Panel]:
    """Displacement and speed of the tip along x and y (Fig. 13)."""
    t = np.linspace(0, TURN, DENSE)
    state = train.motion(t)

    def plot(*names: str) -> dict[str, Points]:
        return {
            axis: (np.degrees(t), state[f"{name}_S"] * 1000)
            for axis, name in zip("xy", names, strict=True)
        }

    title = f"needle's tip at {np.degrees(train.omega):g}°/s of the carrier; grey: dwell"
    return [
        Panel("displacement / mm", plot("x", "y"), title),
        Panel("speed / (mm/s)", plot("vx", "vy")),
    ]


def _plot_law(train: PickupTrain, before: PickupTrain | None) -> list[Panel]:
    """Angle of the arm, its slope over the carrier's angle, and the total ratio on the teeth."""
    variants = {"": train} if before is None else {"after": train, "before": before}
    lead: dict[str, Points] = {}
    slope: dict[str, Points] = {}
    ratio: dict[str, Points] = {}
    for name, variant in variants.items():
        t, turn = variant.samples(DENSE), np.linspace(0, TURN, DENSE)
        driven = np.linspace(*variant.driven, DENSE)
        lead[name] = np.degrees(turn), np.degrees(variant.law.arm(turn) - turn)
        slope[name] = _over_turn(variant, driven, variant.law.slopes(driven)[0])
        ratio[name] = _over_turn(variant, t, 1 / variant.law.slopes(t)[0])
    return [
        Panel("φ₁ \N{MINUS SIGN} t / deg", lead),
        Panel("dφ₁/dφ₅", slope, level=1),
        Panel("total ratio", ratio),
    ]


def _over_turn(train: PickupTrain, t: Array, values: Array) -> Points:
    """A curve over the teeth, cut where the turn begins and left out in the dwell."""
    angles = np.degrees(t % TURN)
    order = np.argsort(angles, kind="stable")
    x, y = angles[order], values[order].astype(float)
    if train.law.dwell is not None:
        gap = int(np.searchsorted(x, np.degrees(train.law.dwell.start) + 1e-9))
        x, y = np.insert(x, gap, x[gap - 1]), np.insert(y, gap, np.nan)
    return x, y
