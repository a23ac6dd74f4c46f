"""A pick-up over a turn as it is seen: carrier, non-circular pair, planet arm with its needle, tray."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.pickup.file import Pickup
from planter.pickup.locking import locking
from planter.pickup.model import Train
from planter.pickup.report.figures import locking_arcs
from planter.pickup.requirements import push
from planter.pickup.tray import Cell, Entry
from planter.view.sampling import refine_places
from planter.view.scene import Body, Curve, Event, Outline, Point, Scene

MOMENTS = 360
"""Moments of a turn from which those that are drawn are refined."""
DENSE = 361
_MM = 1000.0


def scene(machine: Pickup, train: Train, before: Array | None = None) -> Scene:
    """The turn of a train from its farthest tip; `before` (n, 2) [m] is a path of value points to compare with."""

    def moved(t: Array) -> tuple[dict[str, Array], Array, Array]:
        """Places and speeds in mm and mm/s, speed of the tip, slope of the arm's angle."""
        found = {name: value * _MM for name, value in train.motion(t).items()}
        return found, np.hypot(found["vx_S"], found["vy_S"]), train.slope(t)

    def drawn(t: Array) -> list[Array]:
        found, speed, slope = moved(t)
        return [speed, slope, *(found[name] for name in ("L3", "x_S", "y_S"))]

    t = refine_places(drawn, np.arange(MOMENTS + 1) * TURN / MOMENTS)[:-1]
    found, speed, slope = moved(t)
    old = [] if before is None else [Body("path before", (Outline(before * _MM, "before"),))]
    return Scene(
        title=f"Seedling pick-up {machine.name}",
        place="carrier angle from the farthest tip",
        unit="deg",
        places=np.degrees(t),
        seconds=TURN / abs(train.omega),
        bodies=(*_tray(machine, train), *_gears(train, t, found), _carrier(t, found),
                _arm(machine, train, t, found), *old),
        points=(Point("tip", found["x_S"], found["y_S"], traced=True),),
        curves=(
            Curve("speed of the tip", "mm/s", speed),
            Curve("slope of the arm's angle over the carrier's", "", slope),
            Curve("distance of the tip from the sun's centre", "mm", found["L3"]),
        ),
        events=_events(train),
        shares=t / TURN,
    )  # fmt: skip


def _gears(train: Train, t: Array, found: dict[str, Array]) -> tuple[Body, Body]:
    """The sun, which stands still, and the intermediate gear; their own frames lie along the centre line at t = 0."""
    teeth = train.pitch(train.samples(DENSE))
    sun = [Outline(_MM * np.column_stack([teeth["x1"], teeth["y1"]]), "gear", closed=False, shade=0)]
    middle = [Outline(_MM * np.column_stack([teeth["x2"], teeth["y2"]]), "gear", closed=False, shade=1)]
    arcs = locking(train)
    if arcs is not None:
        convex, concave = (_MM * part.T for part in locking_arcs(train, arcs))
        sun.append(Outline(convex, "frame", closed=False))
        middle.append(Outline(concave, "frame", closed=False))
    centre_line = np.degrees(np.arctan2(found["y_M1"], found["x_M1"]))
    turned = centre_line[0] + np.degrees(t + train.law.arm(t))
    return (
        Body("sun", sun, turn=float(centre_line[0])),
        Body("intermediate gear", middle, (found["x_M1"], found["y_M1"]), turned),
    )


def _carrier(t: Array, found: dict[str, Array]) -> Body:
    corners = np.array([[0.0, 0.0], *([found[f"x_{at}"][0], found[f"y_{at}"][0]] for at in ("M1", "O1"))])
    return Body("carrier", (Outline(corners, "frame"),), turn=np.degrees(t))


def _arm(machine: Pickup, train: Train, t: Array, found: dict[str, Array]) -> Body:
    """The planet's arm, along its own x, with the needle at its tip."""
    length = train.geometry.L2 * _MM
    entry = Entry(train, Cell.of(machine))
    heading = train.arm_heading(t)
    corners = entry.to_frame(entry.needle(0.0)) * _MM - [found["x_S"][0], found["y_S"][0]]
    c, s = np.cos(heading[0]), np.sin(heading[0])
    needle = corners @ np.array([[c, -s], [s, c]]) + [length, 0.0]
    bar = Outline(np.array([[0.0, 0.0], [length, 0.0]]), "frame", closed=False)
    return Body("arm and needle", (bar, Outline(needle, "body", shade=2)), (found["x_O1"], found["y_O1"]),
                np.degrees(heading))  # fmt: skip


def _tray(machine: Pickup, train: Train) -> list[Body]:
    entry = Entry(train, Cell.of(machine))
    walls = entry.cell.walls()
    parts = [np.asarray(part.exterior.coords) for part in getattr(walls, "geoms", [walls])]
    return [Body("tray", [Outline(entry.to_frame(part / _MM) * _MM, "body", shade=4) for part in parts])]


def _events(train: Train) -> list[Event]:
    """Pick, push and the ends of the dwell."""
    found = [Event("the tip is farthest: pick", 0.0), Event("push", float(np.degrees(push(train)[0] % TURN)))]
    dwell = train.law.dwell
    if dwell is not None:
        ends = (("the dwell begins", dwell.start), ("the dwell ends", dwell.end))
        found += [Event(name, float(np.degrees(at % TURN))) for name, at in ends]
    return found
