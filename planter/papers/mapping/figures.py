"""Figures of syntheses and gear trains: poses with dyads, linkages, angle curve, ratios, trains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.papers.mapping import model, scene
from planter.papers.mapping.scene import MM
from planter.report.animation import draw_stills
from planter.report.scene import Body, Outline, refine_places
from planter.report.sheet import build_still_scene
from planter.report.style import Panel, Points, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.papers.mapping.synthesis import Synthesis
    from planter.papers.mapping.train import Training

DENSE = np.linspace(0, TURN, 721)
AXIS = "carrier angle θ / deg"
ANGLE = "arm angle relative to carrier / deg"
_WIDEST = 4
"""Circles with a larger radius than this, in extents of the poses, are not drawn."""


def draw_synthesis(synthesis: Synthesis) -> dict[str, Figure]:
    """Return the figures of a synthesis: dyads, each linkage on its circuits, the angle curve."""
    figures = {"dyads": draw_stills({"": (build_still_scene("dyads", _draw_dyads(synthesis)), 0)})}
    for linkage in synthesis.linkages:
        stills = {
            f"{linkage.bar.type}, circuit {circuit}": (
                scene.linkage(linkage, synthesis.poses, circuit),
                0,
            )
            for circuit in sorted({standing.circuit for standing in linkage.standings})
        }
        first, second = linkage.numbers
        figures[f"linkage_{first}_{second}"] = draw_stills(stills)
    if synthesis.carrier is not None:
        figures["angle_curve"] = draw_panels(_plot_angles(synthesis), AXIS, end=360.0)
    return figures


def draw_train(training: Training) -> dict[str, Figure]:
    """Return the figures of a gear train: ratios, pitch curves, and the path of the tip."""
    pitch = build_still_scene("train", scene.draw_train_bodies(training))
    curve = training.train.curve
    figures = {
        "ratios": draw_panels(_plot_ratios(training), AXIS),
        "pitch_curves": draw_stills({"": (pitch, 0)}),
    }
    moving = scene.train(training) if training.dyad is not None and curve.sense < 0 else None
    return figures if moving is None else figures | {"tip_path": draw_stills({"": (moving, 0)})}


def _draw_dyads(synthesis: Synthesis) -> list[Body]:
    """Poses, and for each dyad its circle and bars; members of a family."""
    poses = synthesis.poses
    extent = float(np.ptp(poses[:, :2], axis=0).max()) or 1.0
    bodies = [scene.draw_poses(poses)]
    circle = np.column_stack([np.cos(DENSE), np.sin(DENSE)])
    for number, dyad in enumerate(synthesis.solution.dyads):
        if dyad.radius < _WIDEST * extent:
            hinges = model.place_point(poses, dyad.point)
            bars = [
                Outline(MM * np.array([dyad.centre, at]), "mark", closed=False) for at in hinges
            ]
            outline = Outline(MM * (dyad.centre + dyad.radius * circle), "gear", shade=number)
            bodies.append(Body(f"dyad {number + 1}", [outline, *bars]))
    members = [
        d for d in synthesis.members if np.hypot(*(d.centre - poses[0, :2])) < _WIDEST * extent
    ]
    for name in ("centre", "point"):
        if places := [getattr(dyad, name) for dyad in members]:
            line = Outline(MM * np.array(places), "before", closed=False)
            bodies.append(Body(f"{name}s of the family", (line,)))
    return bodies


def _plot_angles(synthesis: Synthesis) -> list[Panel]:
    """Rotation of the arm against the carrier: through the exact poses, and of the results."""
    nearest = None if synthesis.nearest is None else synthesis.nearest.curve
    curves = {
        "through the poses": synthesis.exact,
        "closest monotone": nearest,
        "points of both paths": synthesis.path_curve,
    }
    present = {name: curve for name, curve in curves.items() if curve is not None}
    start = next((float(curve.at(np.zeros(1))[0]) for curve in present.values()), 0.0)
    angles: dict[str, Points] = {}
    for name, curve in present.items():
        relative = curve.at(DENSE)
        turns = np.round((relative[0] - start) / TURN)
        angles[name] = np.degrees(DENSE), np.degrees(relative - TURN * turns)
    slopes = {name: (np.degrees(DENSE), c.slopes(DENSE)[0]) for name, c in present.items()}
    points: dict[str, Points] = {}
    if synthesis.carrier is not None and synthesis.exact is not None:
        dx, dy = (
            model.place_point(synthesis.poses, synthesis.carrier.point) - synthesis.carrier.centre
        ).T
        theta = np.mod(np.arctan2(dy, dx), TURN)
        relative = synthesis.exact.at(theta)
        points["through the poses"] = np.degrees(theta), np.degrees(relative)
    return [
        Panel(ANGLE, angles, points=points),
        Panel(r"$-$d(arm)/d(carrier)", slopes, level=0),
    ]


def _plot_ratios(training: Training) -> list[Panel]:
    """The angle curve with its points, the total ratio, and the ratios of the two stages."""
    curve = training.train.curve
    names = {"i": "total", "i1": "stage 1", "i2": "stage 2"}

    def sample(theta: Array) -> list[Array]:
        gears = training.train.gears(theta)
        return [curve.at(theta), *(np.log(gears[name]) for name in names)]

    theta = refine_places(sample, np.linspace(curve.carrier[0], curve.carrier[-1], 721))
    gears, degrees = training.train.gears(theta), np.degrees(theta)
    points = {"": (np.degrees(curve.carrier), np.degrees(curve.relative))}
    ratios = {label: (degrees, gears[name]) for name, label in names.items()}
    return [
        Panel(ANGLE, {"": (degrees, np.degrees(curve.at(theta)))}, points=points),
        Panel("ratio / 1", ratios, level=1, is_log=True),
    ]
