"""Drawings of a pick-up with its symbols: from the front, and the needle in the cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.arrays import TURN
from planter.pickup.file import Pickup
from planter.pickup.law import NEEDLE
from planter.pickup.model import PickupTrain
from planter.pickup.report.scene import build_pickup_scene
from planter.pickup.tray import Cell, CellEntry
from planter.view.scene import Body, Outline
from planter.view.sheet import Angle, Length, Mark, Sheet, Spot, heading, still

MOMENT = 60
"""Carrier angle from the farthest tip at which the pick-up is drawn [deg]: teeth drive it there."""
BEFORE = 10
"""How long before the pick the needle is drawn, in carrier angle [deg]: it stands askew in the cell."""
_MM = 1e3


def draw_sheets(machine: Pickup, train: PickupTrain) -> list[Sheet]:
    """All drawings of a machine."""
    front_view = build_pickup_scene(machine, train)
    bars = replace(front_view, bodies=[body for body in front_view.bodies if body.name != "tray"], points=())
    gears = replace(bars, bodies=[body for body in bars.bodies if body.name != "arm and needle"])
    at = {name: float(value[0]) * _MM for name, value in train.motion(np.radians([MOMENT])).items()}
    return [
        Sheet("bars", "bars and angles from the front", bars, _bars(train, at), MOMENT),
        Sheet("gears", "carrier and gears from the front", gears, _gears(train, at), MOMENT),
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
    tip = heading(o, s)
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
        Angle(("phi1",), o1, heading(o1, o), -arm, 0.3 * size),
        Angle(("Z1",), o1, 0, float(np.degrees(train.arm_heading(np.radians([MOMENT]))[0])), 0.45 * size),
    ]


def _gears(train: PickupTrain, at: dict[str, float]) -> list[Mark]:
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
    bodies = (Body("tray", [Outline(part, "body", shade=4) for part in parts]),
              Body("needle", (Outline(needle, "body", shade=2),)))  # fmt: skip
    return Sheet("cell", "needle and cell, across the tray", still("cell", bodies), [*_needle(entry, t), *_tray(cell)])


def _needle(entry: CellEntry, t: float) -> list[Mark]:
    """Tip, corners, and where the edges pass the surface of the tray."""
    (depth, across), tilt = entry.place(np.array([t]))[0], float(entry.tilt(np.array([t]))[0])
    size = {"length": entry.cell.needle_length, "width": entry.cell.needle_width}
    corner_places = load(NEEDLE).at("needle", along=depth, across=across, tilt=tilt, **size)
    at = {name: value * _MM for name, value in corner_places.items()}
    corners = [f"{end}_{side}" for end in ("tip", "root") for side in ("right", "left")]
    places = {corner: np.array([at[f"{corner}_along"], at[f"{corner}_across"]]) for corner in corners}
    tip, root = ((places[f"{end}_right"] + places[f"{end}_left"]) / 2 for end in ("tip", "root"))
    return [
        Spot(("along", "across"), tip),
        *(Spot((f"{corner}_{axis}",), place) for corner, place in places.items() for axis in ("along", "across")),
        Spot(("right_surface",), np.array([0.0, at["right_surface"]])),
        Spot(("left_surface",), np.array([0.0, at["left_surface"]])),
        Length(("length_mm",), root, tip, 0.25),
        Length(("width_mm",), places["root_right"], places["root_left"]),
    ]


def _tray(cell: Cell) -> list[Mark]:
    depth, top, bottom, pitch = (_MM * value for value in (cell.depth, cell.top, cell.bottom, cell.pitch))
    return [
        Length(("cell_depth_mm",), np.array([0.0, pitch]), np.array([depth, pitch])),
        Length(("cell_top_mm",), np.array([0.0, pitch - top / 2]), np.array([0.0, pitch + top / 2]), 0.9),
        Length(("cell_bottom_mm",), np.array([depth, pitch - bottom / 2]), np.array([depth, pitch + bottom / 2])),
        Length(("cell_pitch_mm",), np.array([depth, 0.0]), np.array([depth, -pitch])),
        Length(("entry_depth_mm",), np.array([0.0, 0.0]), np.array([_MM * cell.entry, 0.0])),
    ]
