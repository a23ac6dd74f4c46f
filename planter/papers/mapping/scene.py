"""Drawings of poses, linkages and gear trains: moving scenes, sheets with symbols, figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import TURN, rotation_matrix, unit_vector
from planter.papers.mapping import model
from planter.papers.mapping.synthesis import Linkage, Synthesis
from planter.papers.mapping.train import Training, polar_curves
from planter.report.animation import draw_stills
from planter.report.scene import Body, Curve, Event, Outline, Point, Scene, refine_places
from planter.report.sheet import (
    Angle,
    Length,
    Mark,
    Sheet,
    Spot,
    build_still_scene,
    direction_angle,
)
from planter.report.style import Panel, Points, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.papers.mapping.linkage import FourBar
    from planter.papers.mapping.synthesis import Synthesis
    from planter.papers.mapping.train import Training

MM = 1e3
MOMENTS = 120
"""Moments of a cycle from which those that are drawn are refined."""
SECONDS = 6.0
"""Duration of a cycle [s]: poses have no speed."""
_ARROW = 0.13
"""Length of a pose's arrow in parts of the extent of the poses."""


def drawn_shares(bar: FourBar, circuit: int) -> Array:
    """Shares (n,) of the way along a circuit, from 0 to below 1, at which straight pieces follow
    its curves.
    """

    def sample(shares: Array) -> list[Array]:
        path = bar.path_at(circuit, shares)
        return [*path.tip, path.phi, path.transmission]

    return refine_places(sample, np.linspace(0.0, 1.0, MOMENTS + 1))[:-1]


def build_linkage_scene(solution: Linkage, poses: Array, circuit: int) -> Scene:
    """A linkage on one of its circuits, with the poses (k, 3) [m, rad]."""
    bar, shares = solution.bar, drawn_shares(solution.bar, circuit)
    path = bar.path_at(circuit, shares)
    at = np.column_stack([path.tip.T, path.phi])
    crank, follower = (
        MM * model.place_point(at, dyad.point).T for dyad in (bar.crank, bar.follower)
    )
    tip, fixed = MM * path.tip, (MM * bar.crank.centre, MM * bar.follower.centre)
    points = MM * np.array([bar.crank.point, bar.follower.point, [0.0, 0.0]])
    bodies = (
        Body("frame", (Outline(np.array(fixed), "ground", closed=False),)),
        _bar("crank", fixed[0], crank),
        _bar("follower", fixed[1], follower),
        Body("arm", (Outline(points, "body", shade=0),), tip, np.degrees(path.phi)),
        draw_poses(poses),
    )
    return Scene(
        title=f"Linkage of dyads {solution.numbers[0]} and {solution.numbers[1]}, {bar.type}, "
        f"circuit {circuit}",
        place="crank angle",
        unit="deg",
        places=np.degrees(path.theta),
        seconds=SECONDS,
        bodies=bodies,
        points=(Point("tip", tip[0], tip[1], True),),
        curves=(Curve("transmission angle", "deg", np.degrees(path.transmission)),),
        events=_reached(poses, at, np.degrees(path.theta)),
        shares=shares,
    )


def build_linkage_scenes(linkage: Linkage, poses: Array) -> dict[int, Scene]:
    """Return the scenes of a linkage by those of its circuits that have a pose."""
    circuits = sorted({standing.circuit for standing in linkage.standings})
    return {circuit: build_linkage_scene(linkage, poses, circuit) for circuit in circuits}


def build_train_scene(training: Training) -> Scene | None:
    """A gear train on its carrier, with the arm and the poses if there are any.

    None for a curve along which the arm gains on the carrier: two external meshes do not drive it
    so.
    """
    curve = training.train.curve
    if curve.sense > 0:
        return None

    def sample(theta: Array) -> list[Array]:
        return [
            curve.at(theta),
            *(np.asarray(axis) for point in _tip(training, theta) for axis in (point.x, point.y)),
        ]

    theta = refine_places(sample, np.linspace(curve.carrier[0], curve.carrier[-1], MOMENTS + 1))[
        :-1
    ]
    at, psi = training.train.polar_angles()
    middle, relative = np.degrees(np.interp(theta, at, psi[1])), np.degrees(curve.at(theta))
    hinges, (sun, second, third, planet) = (
        MM * place_hinges(training).T,
        (part.T for part in outline_gears(training)),
    )
    centre, start = _mounted(training, hinges[2])
    parts = (
        Body("middle gears", (_gear(second, 1), _gear(third, 2)), hinges[1].tolist(), middle),
        Body(
            "planet and arm",
            (_gear(planet, 3), *_arm(training, start)),
            hinges[2].tolist(),
            relative - relative[0],
        ),
    )
    bars = Outline(hinges, "frame", closed=False)
    turned = start + np.degrees(theta - theta[0])
    return Scene(
        title="Non-circular gear train",
        place="carrier angle",
        unit="deg",
        places=np.degrees(theta),
        seconds=SECONDS,
        bodies=(
            Body("sun", (_gear(sun, 0),), centre, start),
            Body("carrier", (bars,), centre, turned, parts),
            *([] if training.poses is None else [draw_poses(training.poses)]),
        ),
        points=_tip(training, theta),
        curves=(Curve("arm angle relative to carrier", "deg", relative),),
        shares=(theta - curve.carrier[0]) / (curve.carrier[-1] - curve.carrier[0]),
    )


def _bar(name: str, fixed: Array, moving: Array) -> Body:
    """A link from a fixed hinge (2,) to a moving one (2, n)."""
    dx, dy = moving - fixed[:, None]
    length = float(np.hypot(dx[0], dy[0]))
    bar = Outline(np.array([[0.0, 0.0], [length, 0.0]]), "frame", closed=False)
    return Body(name, (bar,), fixed.tolist(), np.degrees(np.unwrap(np.arctan2(dy, dx))))


def _gear(points: Array, shade: int) -> Outline:
    return Outline(points, "gear", shade=shade)


def draw_poses(poses: Array) -> Body:
    """Return the poses as arrows along the arm's x axis."""
    length = _ARROW * MM * (float(np.ptp(poses[:, :2], axis=0).max()) or 1.0)
    arrow = length * np.array([[0.0, 0.0], [1.0, 0.0], [0.8, 0.08], [1.0, 0.0], [0.8, -0.08]])
    arrows = []
    for x, y, angle in poses:
        arrows.append(
            Outline(arrow @ rotation_matrix(-angle) + [MM * x, MM * y], "mark", closed=False)
        )
    return Body("poses", arrows)


def _reached(poses: Array, at: Array, places: Array) -> list[Event]:
    """Return the crank angles [deg] at which the arm is closest to each pose, tip and direction
    together.
    """
    size = float(np.ptp(poses[:, :2], axis=0).max()) or 1.0
    events = []
    for number, pose in enumerate(poses, 1):
        turned = np.sin((at[:, 2] - pose[2]) / 2)
        away = np.hypot(*(at[:, :2] - pose[:2]).T) / size + np.abs(turned)
        events.append(Event(f"closest to pose {number}", float(places[int(np.argmin(away))])))
    return events


def _mounted(training: Training, moving: Array) -> tuple[list[float], float]:
    """Return the centre of the sun [mm] and the direction of the first centre line at the first
    carrier angle [deg].
    """
    if training.dyad is None:
        return [0.0, 0.0], 0.0
    heading = float(np.degrees(training.train.curve.carrier[0] - np.arctan2(moving[1], moving[0])))
    return (MM * training.dyad.centre).tolist(), heading


def _arm(training: Training, start: float) -> list[Outline]:
    """Return the line from the moving hinge to the tip, in the frame of the planet."""
    if training.dyad is None:
        return []
    places = MM * training.train.motion(training.dyad)["places"][:, 0]
    offset = (places[:2] - places[2:]) @ rotation_matrix(np.radians(start))
    return [Outline(np.array([[0.0, 0.0], offset]), "frame", closed=False)]


def _tip(training: Training, theta: Array) -> list[Point]:
    if training.dyad is None:
        return []
    x, y = MM * model.arm(theta, training.train.curve.at(theta) + theta, training.dyad.vector)[:2]
    return [Point("tip", x, y, traced=True)]


POSE = -2
"""The pose that the linkage is drawn in: the last but one, where its bars lie well apart."""
_HINGES = (0, 1, 1, 2)
"""At which hinge of the carrier each of the four gears turns."""


def draw_sheets(synthesis: Synthesis, train: Training | None) -> list[Sheet]:
    """All drawings of what was found: those of which there is one."""
    linkages = [
        _linkage(linkage, synthesis.poses[POSE], synthesis.poses)
        for linkage in synthesis.linkages[:1]
    ]
    return [*linkages, *([] if train is None else [_train(train)])]


def _linkage(linkage: Linkage, pose: Array, poses: Array) -> Sheet:
    """The first linkage in a pose; the origin of the moving frame is the tip."""
    tip, heading = MM * pose[:2], float(np.degrees(pose[2]))
    crank, follower = (
        MM * model.place_point(pose[None, :], dyad.point)[0]
        for dyad in (linkage.bar.crank, linkage.bar.follower)
    )
    fixed = [MM * dyad.centre for dyad in (linkage.bar.crank, linkage.bar.follower)]
    bodies = (
        Body("frame", (Outline(np.array(fixed), "ground", closed=False),)),
        Body("crank", (Outline(np.array([fixed[0], crank]), "frame", closed=False),)),
        Body("follower", (Outline(np.array([fixed[1], follower]), "frame", closed=False),)),
        Body("arm", (Outline(np.array([crank, follower, tip]), "body", shade=0),)),
    )
    size = float(np.ptp(MM * poses[:, :2], axis=0).max())
    marks: list[Mark] = [
        Spot(("d1", "d2"), tip),
        Spot(("tip_x_mm", "tip_y_mm"), tip),
        Angle(("phi", "phi_deg"), tip, 0, heading, 0.2 * size),
        Spot(("x", "y"), crank),
        Spot(("X", "Y"), crank),
        Spot(("X_c", "Y_c"), fixed[0]),
        Spot(("x_f", "y_f"), follower),
        Spot(("X_f", "Y_f"), fixed[1]),
        Length(("L1",), fixed[0], crank),
        Length(("L_f",), fixed[1], follower),
        Angle(("crank_deg",), fixed[0], 0, direction_angle(fixed[0], crank), 0.1 * size),
        Angle.between(("transmission_deg",), follower, crank, fixed[1], 0.15 * size),
    ]
    return Sheet(
        "linkage",
        f"linkage of dyads {linkage.numbers[0]} and {linkage.numbers[1]} in the last pose but one",
        build_still_scene("linkage", bodies),
        marks,
    )


def place_hinges(training: Training) -> Array:
    """Hinges of the carrier (2, 3) [m]: fixed, middle, moving; straight where the carrier's length
    is not known.
    """
    distance = training.train.distance
    bend = np.pi if training.crank is None else training.train.bend(training.crank)
    end = np.pi - bend
    return distance * np.array([[0, 1, 1 + np.cos(end)], [0, 0, np.sin(end)]])


def outline_gears(training: Training) -> list[Array]:
    """Pitch curves (2, n) [mm] about their centres, each turned to its mesh at the first carrier
    angle.

    A driver's contact lies towards its follower, a follower's towards its driver; on the gear the
    contact moves against its rotation, which is that of its mate reversed.
    """
    psi, radii = polar_curves(training.train)
    bend = np.pi if training.crank is None else training.train.bend(training.crank)
    towards = np.array([0.0, np.pi, np.pi - bend, -bend])
    senses = (1, -1, -1, 1)
    return [MM * radii[k] * unit_vector(towards[k] + senses[k] * psi[k]) for k in range(4)]


def draw_train_bodies(training: Training) -> tuple[Body, Body]:
    """Return the four pitch curves in mesh on the carrier at its first angle, and the carrier."""
    hinges = MM * place_hinges(training).T
    curves = [
        Outline(points.T + hinges[at], "gear", shade=k)
        for k, (points, at) in enumerate(zip(outline_gears(training), _HINGES, strict=True))
    ]
    return Body("gears", curves), Body("carrier", (Outline(hinges, "frame", closed=False),))


def _train(training: Training) -> Sheet:
    """The four pitch curves on the carrier at its first angle."""
    hinges = MM * place_hinges(training).T
    radii = training.train.gears(np.array([training.train.curve.carrier[0]]))
    marks: list[Mark] = [Length(("centre_distance_mm",), hinges[0], hinges[1], 0.8)]
    for stage, names in enumerate((("r1", "r2"), ("r3", "r4"))):
        columns = [f"{gear}_{stage + 1}_radius_mm" for gear in ("driver", "follower")]
        ends = hinges[stage], hinges[stage + 1]
        share = float(radii[names[0]][0]) / training.train.distance
        contact = (1 - share) * ends[0] + share * ends[1]
        marks += [Length((name,), end, contact) for name, end in zip(names, ends, strict=True)]
        marks += [
            Length((name,), end, contact, 0.8) for name, end in zip(columns, ends, strict=True)
        ]
    if training.crank is not None:
        radius = 0.3 * MM * training.train.distance
        marks.append(Length(("L1",), hinges[0], hinges[2], 0.3))
        marks.append(Angle.between(("bend",), hinges[1], hinges[0], hinges[2], radius))
    return Sheet(
        "train",
        "gear train on its carrier, bent as its length wants",
        build_still_scene("train", draw_train_bodies(training)),
        marks,
    )


DENSE = np.linspace(0, TURN, 721)
AXIS = "carrier angle θ / deg"
ANGLE = "arm angle relative to carrier / deg"
_WIDEST = 4
"""Circles with a larger radius than this, in extents of the poses, are not drawn."""


def draw_synthesis(synthesis: Synthesis) -> dict[str, Figure]:
    """Return the figures of a synthesis: dyads, each linkage on its circuits, the angle curve."""
    figures = {"dyads": draw_stills({"": (build_still_scene("dyads", _draw_dyads(synthesis)), 0)})}
    for linkage in synthesis.linkages:
        scenes = build_linkage_scenes(linkage, synthesis.poses)
        names = [f"{linkage.bar.type}, circuit {circuit}" for circuit in scenes]
        stills = {name: (scene, 0) for name, scene in zip(names, scenes.values(), strict=True)}
        figures["linkage_{}_{}".format(*linkage.numbers)] = draw_stills(stills)
    if synthesis.carrier is not None:
        figures["angle_curve"] = draw_panels(_plot_angles(synthesis), AXIS, end=360.0)
    return figures


def draw_train(training: Training) -> dict[str, Figure]:
    """Return the figures of a gear train: ratios, pitch curves, and the path of the tip."""
    pitch = build_still_scene("train", draw_train_bodies(training))
    curve = training.train.curve
    figures = {
        "ratios": draw_panels(_plot_ratios(training), AXIS),
        "pitch_curves": draw_stills({"": (pitch, 0)}),
    }
    moving = build_train_scene(training) if training.dyad is not None and curve.sense < 0 else None
    return figures if moving is None else figures | {"tip_path": draw_stills({"": (moving, 0)})}


def _draw_dyads(synthesis: Synthesis) -> list[Body]:
    """Poses, and for each dyad its circle and bars; members of a family."""
    poses = synthesis.poses
    extent = float(np.ptp(poses[:, :2], axis=0).max()) or 1.0
    bodies = [draw_poses(poses)]
    circle = unit_vector(DENSE).T
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
        theta = np.mod(synthesis.carrier.carrier_angles(synthesis.poses), TURN)
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
