"""Drawings of a pick-up: the scene of a cycle, sheets with symbols, figures."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.arrays import TURN, rotation_matrix, unit_vector
from planter.papers.pickup.file import Pickup
from planter.papers.pickup.gears import Locking, compute_locking_arcs
from planter.papers.pickup.law import NEEDLE
from planter.papers.pickup.model import PickupTrain
from planter.papers.pickup.requirements import Cell, CellEntry, find_push
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

    from planter.kernels import Array
    from planter.papers.pickup.file import Pickup
    from planter.papers.pickup.model import PickupTrain

MOMENTS = 360
"""Moments of a turn from which those that are drawn are refined."""
DENSE = 361
_MM = 1000.0


def build_pickup_scene(machine: Pickup, train: PickupTrain, before: Array | None = None) -> Scene:
    """The turn of a train from its farthest tip; `before` (n, 2) [m] is a path of value points to
    compare with.
    """

    def moved(t: Array) -> tuple[dict[str, Array], Array, Array]:
        """Places and speeds in mm and mm/s, speed of the tip, slope of the arm's angle."""
        state = {name: value * _MM for name, value in train.motion(t).items()}
        return state, np.hypot(state["vx_S"], state["vy_S"]), train.slope(t)

    def curve_rows(t: Array) -> list[Array]:
        state, speed, slope = moved(t)
        return [speed, slope, *(state[name] for name in ("L3", "x_S", "y_S"))]

    t = refine_places(curve_rows, np.arange(MOMENTS + 1) * TURN / MOMENTS)[:-1]
    state, speed, slope = moved(t)
    old = [] if before is None else [Body("path before", (Outline(before * _MM, "before"),))]
    return Scene(
        title=f"Seedling pick-up {machine.name}",
        place="carrier angle from the farthest tip",
        unit="deg",
        places=np.degrees(t),
        seconds=TURN / abs(train.omega),
        bodies=(
            *_tray(machine, train),
            *_gears(train, t, state),
            _carrier(t, state),
            _arm(machine, train, t, state),
            *old,
            Body("points", [_tube(*point) for point in machine.tip_path.points_mm])
            if machine.tip_path
            else Body("points", ()),
        ),
        points=(Point("tip", state["x_S"], state["y_S"], traced=True),),
        curves=(
            Curve("speed of the tip", "mm/s", speed),
            Curve("slope of the arm's angle over the carrier's", "", slope),
            Curve("distance of the tip from the sun's centre", "mm", state["L3"]),
        ),
        events=_events(train),
        shares=t / TURN,
    )


def _tube(x: float, y: float, radius: float) -> Outline:
    """A point that the path must pass, with its tolerance."""
    angles = np.linspace(0, TURN, 37)
    return Outline(radius * unit_vector(angles).T + [x, y], "mark")


def _gears(train: PickupTrain, t: Array, state: dict[str, Array]) -> tuple[Body, Body]:
    """The sun, which stands still, and the intermediate gear; their own frames lie along the centre
    line at t = 0.
    """
    teeth = train.pitch(train.samples(DENSE))
    sun = [
        Outline(_MM * np.column_stack([teeth["x1"], teeth["y1"]]), "gear", closed=False, shade=0)
    ]
    middle = [
        Outline(_MM * np.column_stack([teeth["x2"], teeth["y2"]]), "gear", closed=False, shade=1)
    ]
    arcs = compute_locking_arcs(train)
    if arcs is not None:
        convex, concave = (_MM * part.T for part in outline_locking_arcs(train, arcs))
        sun.append(Outline(convex, "frame", closed=False))
        middle.append(Outline(concave, "frame", closed=False))
    centre_line = np.degrees(np.arctan2(state["y_M1"], state["x_M1"]))
    turned = centre_line[0] + np.degrees(t + train.law.arm(t))
    return (
        Body("sun", sun, turn=float(centre_line[0])),
        Body("intermediate gear", middle, (state["x_M1"], state["y_M1"]), turned),
    )


def outline_locking_arcs(train: PickupTrain, arcs: Locking) -> tuple[Array, Array]:
    """Convex arc in the sun's frame and concave one in the intermediate gear's, each (2, n) [m].

    In the dwell both lie on one circle about the sun's centre; the concave one reaches to its
    gear's tips.
    """
    dwell = train.law.dwell
    assert dwell is not None
    convex, concave = (
        np.linspace(dwell.start, dwell.end, 181),
        np.linspace(-arcs.reaches[0], arcs.reaches[1], 121),
    )
    seen = arcs.radius * unit_vector(concave) - np.array([[train.geometry.a1], [0.0]])
    arm_angle = float(train.law.arm(np.array([dwell.start]))[0])
    return arcs.radius * unit_vector(convex), rotation_matrix(-arm_angle) @ seen


def _carrier(t: Array, state: dict[str, Array]) -> Body:
    corners = np.array(
        [[0.0, 0.0], *([state[f"x_{at}"][0], state[f"y_{at}"][0]] for at in ("M1", "O1"))]
    )
    return Body("carrier", (Outline(corners, "frame"),), turn=np.degrees(t))


def _arm(machine: Pickup, train: PickupTrain, t: Array, state: dict[str, Array]) -> Body:
    """The planet's arm, along its own x, with the needle at its tip."""
    length = train.geometry.L2 * _MM
    entry = CellEntry(train, Cell.from_pickup(machine))
    heading = train.arm_heading(t)
    corners = entry.to_frame(entry.needle(0.0)) * _MM - [state["x_S"][0], state["y_S"][0]]
    needle = corners @ rotation_matrix(heading[0]) + [length, 0.0]
    bar = Outline(np.array([[0.0, 0.0], [length, 0.0]]), "frame", closed=False)
    return Body(
        "arm and needle",
        (bar, Outline(needle, "body", shade=2)),
        (state["x_O1"], state["y_O1"]),
        np.degrees(heading),
    )


def _tray(machine: Pickup, train: PickupTrain) -> list[Body]:
    entry = CellEntry(train, Cell.from_pickup(machine))
    walls = entry.cell.walls()
    parts = [np.asarray(part.exterior.coords) for part in getattr(walls, "geoms", [walls])]
    return [
        Body("tray", [Outline(entry.to_frame(part / _MM) * _MM, "body", shade=4) for part in parts])
    ]


def _events(train: PickupTrain) -> list[Event]:
    """Pick, push and the ends of the dwell."""
    events = [
        Event("the tip is farthest: pick", 0.0),
        Event("push", float(np.degrees(find_push(train)[0] % TURN))),
    ]
    dwell = train.law.dwell
    if dwell is not None:
        ends = (("the dwell begins", dwell.start), ("the dwell ends", dwell.end))
        events += [Event(name, float(np.degrees(at % TURN))) for name, at in ends]
    return events


MOMENT = 60
"""Carrier angle from the farthest tip at which the pick-up is drawn [deg]: teeth drive it there."""
BEFORE = 10
"""How long before the pick the needle is drawn, in carrier angle [deg]: it stands askew in the
cell.
"""


def draw_sheets(machine: Pickup, train: PickupTrain) -> list[Sheet]:
    """All drawings of a machine."""
    front_view = build_pickup_scene(machine, train)
    bars = replace(
        front_view, bodies=[body for body in front_view.bodies if body.name != "tray"], points=()
    )
    gears = replace(bars, bodies=[body for body in bars.bodies if body.name != "arm and needle"])
    at = {name: float(value[0]) * _MM for name, value in train.motion(np.radians([MOMENT])).items()}
    return [
        Sheet("bars", "bars and angles from the front", bars, _bars(train, at), MOMENT),
        Sheet("gears", "carrier and gears from the front", gears, _mark_gears(train, at), MOMENT),
        _cell(CellEntry(train, Cell.from_pickup(machine))),
    ]


def _points(at: dict[str, float]) -> tuple[Array, Array, Array, Array]:
    """Axes O, M1, O1 and the tip S [mm]."""
    m1, o1, s = (np.array([at[f"x_{name}"], at[f"y_{name}"]]) for name in ("M1", "O1", "S"))
    return np.zeros(2), m1, o1, s


def _bars(train: PickupTrain, at: dict[str, float]) -> list[Mark]:
    """The triangle O-O1-S; the arm's angle is drawn clockwise."""
    o, _, o1, s = _points(at)
    size = train.geometry.L1 * _MM
    arm = np.degrees(float(train.law.arm(np.radians([MOMENT]))[0])) % 360
    phi5 = float(np.degrees(train.phi5_far)) + MOMENT
    tip = direction_angle(o, s)
    return [
        Length(("L1",), o, o1),
        Length(("L2",), o1, s),
        Length(("L3",), o, s, 0.6),
        Spot(("x_S", "y_S"), s),
        Spot(("x_O1", "y_O1"), o1),
        Angle(("phi5",), o, 0, phi5, 0.6 * size),
        Angle(("t_deg",), o, phi5 - MOMENT, MOMENT, 0.45 * size),
        Angle(("phi4",), o, 0, tip, 0.75 * size),
        Angle(("phi6",), o, tip, (phi5 - tip) % 360, 0.9 * size),
        Angle(("phi1",), o1, direction_angle(o1, o), -arm, 0.3 * size),
        Angle(
            ("Z1",),
            o1,
            0,
            float(np.degrees(train.arm_heading(np.radians([MOMENT]))[0])),
            0.45 * size,
        ),
    ]


def _mark_gears(train: PickupTrain, at: dict[str, float]) -> list[Mark]:
    """The rigid triangle O-M1-O1 and the pitch point between O and M1."""
    o, m1, o1, _ = _points(at)
    size = train.geometry.L1 * _MM
    pitch = train.pitch(np.radians([MOMENT]))
    contact = m1 * float(pitch["R1"][0]) / train.geometry.a1
    return [
        Length(("a1",), o, m1, 0.85),
        Length(("a2",), m1, o1),
        Length(("R1",), o, contact, 0.6),
        Length(("R2",), m1, contact, 0.4),
        Length(("intermediate_radius_mm",), m1, contact, 0.7),
        Spot(("x_M1", "y_M1"), m1),
        Spot(("x1", "y1", "x2", "y2"), contact),
        Angle.between(("beta1",), o, o1, m1, 0.75 * size),
        Angle.between(("gamma",), m1, o, o1, 0.15 * size),
        Angle.between(("U1",), o1, m1, o, 0.35 * size),
    ]


def _cell(entry: CellEntry) -> Sheet:
    """The needle shortly before the pick in the frame of the cell, its axis to the right."""
    cell, t = entry.cell, np.radians(-BEFORE) % TURN
    walls = entry.cell.walls()
    parts = [np.asarray(part.exterior.coords) for part in getattr(walls, "geoms", [walls])]
    needle = entry.needle(t) * _MM
    bodies = (
        Body("tray", [Outline(part, "body", shade=4) for part in parts]),
        Body("needle", (Outline(needle, "body", shade=2),)),
    )
    marks = [*_mark_needle(entry, t), *_mark_tray(cell)]
    return Sheet(
        "cell", "needle and cell, across the tray", build_still_scene("cell", bodies), marks
    )


def _mark_needle(entry: CellEntry, t: float) -> list[Mark]:
    """Tip, corners, and where the edges pass the surface of the tray."""
    (depth, across), tilt = entry.place(np.array([t]))[0], float(entry.tilt(np.array([t]))[0])
    size = {"length": entry.cell.needle_length, "width": entry.cell.needle_width}
    corner_places = load(NEEDLE).at("needle", along=depth, across=across, tilt=tilt, **size)
    at = {name: value * _MM for name, value in corner_places.items()}
    corners = [f"{end}_{side}" for end in ("tip", "root") for side in ("right", "left")]
    places = {
        corner: np.array([at[f"{corner}_along"], at[f"{corner}_across"]]) for corner in corners
    }
    tip, root = ((places[f"{end}_right"] + places[f"{end}_left"]) / 2 for end in ("tip", "root"))
    return [
        Spot(("along", "across"), tip),
        *(
            Spot((f"{corner}_{axis}",), place)
            for corner, place in places.items()
            for axis in ("along", "across")
        ),
        Spot(("right_surface",), np.array([0.0, at["right_surface"]])),
        Spot(("left_surface",), np.array([0.0, at["left_surface"]])),
        Length(("length_mm",), root, tip, 0.25),
        Length(("width_mm",), places["root_right"], places["root_left"]),
    ]


def _mark_tray(cell: Cell) -> list[Mark]:
    depth, top, bottom, pitch = (
        _MM * value for value in (cell.depth, cell.top, cell.bottom, cell.pitch)
    )
    return [
        Length(("cell_depth_mm",), np.array([0.0, pitch]), np.array([depth, pitch])),
        Length(
            ("cell_top_mm",),
            np.array([0.0, pitch - top / 2]),
            np.array([0.0, pitch + top / 2]),
            0.9,
        ),
        Length(
            ("cell_bottom_mm",),
            np.array([depth, pitch - bottom / 2]),
            np.array([depth, pitch + bottom / 2]),
        ),
        Length(("cell_pitch_mm",), np.array([depth, 0.0]), np.array([depth, -pitch])),
        Length(("entry_depth_mm",), np.array([0.0, 0.0]), np.array([_MM * cell.entry, 0.0])),
    ]


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
