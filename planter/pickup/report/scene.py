"""Scene of a pick-up over a cycle: carrier, non-circular pair, planet arm with its needle, tray."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.pickup.file import Pickup
from planter.pickup.locking import compute_locking_arcs
from planter.pickup.model import PickupTrain
from planter.pickup.report.figures import locking_arcs
from planter.pickup.requirements import find_push
from planter.pickup.tray import Cell, CellEntry
from planter.view.scene import Body, Curve, Event, Outline, Point, Scene, refine_places

MOMENTS = 360
"""Moments of a turn from which those that are drawn are refined."""
DENSE = 361
_MM = 1000.0


def build_pickup_scene(machine: Pickup, train: PickupTrain, before: Array | None = None) -> Scene:
    """The turn of a train from its farthest tip; `before` (n, 2) [m] is a path of value points to compare with."""

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
        bodies=(*_tray(machine, train), *_gears(train, t, state), _carrier(t, state),
                _arm(machine, train, t, state), *old),
        points=(Point("tip", state["x_S"], state["y_S"], traced=True),),
        curves=(
            Curve("speed of the tip", "mm/s", speed),
            Curve("slope of the arm's angle over the carrier's", "", slope),
            Curve("distance of the tip from the sun's centre", "mm", state["L3"]),
        ),
        events=_events(train),
        shares=t / TURN,
    )  # fmt: skip


def _gears(train: PickupTrain, t: Array, state: dict[str, Array]) -> tuple[Body, Body]:
    """The sun, which stands still, and the intermediate gear; their own frames lie along the centre line at t = 0."""
    teeth = train.pitch(train.samples(DENSE))
    sun = [Outline(_MM * np.column_stack([teeth["x1"], teeth["y1"]]), "gear", closed=False, shade=0)]
    middle = [Outline(_MM * np.column_stack([teeth["x2"], teeth["y2"]]), "gear", closed=False, shade=1)]
    arcs = compute_locking_arcs(train)
    if arcs is not None:
        convex, concave = (_MM * part.T for part in locking_arcs(train, arcs))
        sun.append(Outline(convex, "frame", closed=False))
        middle.append(Outline(concave, "frame", closed=False))
    centre_line = np.degrees(np.arctan2(state["y_M1"], state["x_M1"]))
    turned = centre_line[0] + np.degrees(t + train.law.arm(t))
    return (
        Body("sun", sun, turn=float(centre_line[0])),
        Body("intermediate gear", middle, (state["x_M1"], state["y_M1"]), turned),
    )


def _carrier(t: Array, state: dict[str, Array]) -> Body:
    corners = np.array([[0.0, 0.0], *([state[f"x_{at}"][0], state[f"y_{at}"][0]] for at in ("M1", "O1"))])
    return Body("carrier", (Outline(corners, "frame"),), turn=np.degrees(t))


def _arm(machine: Pickup, train: PickupTrain, t: Array, state: dict[str, Array]) -> Body:
    """The planet's arm, along its own x, with the needle at its tip."""
    length = train.geometry.L2 * _MM
    entry = CellEntry(train, Cell.from_pickup(machine))
    heading = train.arm_heading(t)
    corners = entry.to_frame(entry.needle(0.0)) * _MM - [state["x_S"][0], state["y_S"][0]]
    c, s = np.cos(heading[0]), np.sin(heading[0])
    needle = corners @ np.array([[c, -s], [s, c]]) + [length, 0.0]
    bar = Outline(np.array([[0.0, 0.0], [length, 0.0]]), "frame", closed=False)
    return Body("arm and needle", (bar, Outline(needle, "body", shade=2)), (state["x_O1"], state["y_O1"]),
                np.degrees(heading))  # fmt: skip


def _tray(machine: Pickup, train: PickupTrain) -> list[Body]:
    entry = CellEntry(train, Cell.from_pickup(machine))
    walls = entry.cell.walls()
    parts = [np.asarray(part.exterior.coords) for part in getattr(walls, "geoms", [walls])]
    return [Body("tray", [Outline(entry.to_frame(part / _MM) * _MM, "body", shade=4) for part in parts])]


def _events(train: PickupTrain) -> list[Event]:
    """Pick, push and the ends of the dwell."""
    events = [Event("the tip is farthest: pick", 0.0), Event("push", float(np.degrees(find_push(train)[0] % TURN)))]
    dwell = train.law.dwell
    if dwell is not None:
        ends = (("the dwell begins", dwell.start), ("the dwell ends", dwell.end))
        events += [Event(name, float(np.degrees(at % TURN))) for name, at in ends]
    return events
