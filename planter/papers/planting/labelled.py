"""Labelled drawings of planting devices from the front, across the nozzle, and of the cam
(`planter.report.sheet`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.kernels.formulas import load as load_formulas
from planter.mechanism.labelled import LOADS, group_loads
from planter.numerics.arrays import rotation_matrix
from planter.papers.planting.file import load
from planter.papers.planting.lifted import NAME, LiftedModel
from planter.papers.planting.model import SIDES, Device
from planter.papers.planting.report.scene import MOMENTS, build_scene, draw_halves
from planter.papers.planting.toothed import locate_pitch_curves
from planter.report.free_body import FreeBodies
from planter.report.scene import Body, Outline, Scene
from planter.report.sheet import Angle, Length, Mark, Sheet, Spot

PHI = 40
"""Carrier angle at which the device is drawn from the front [deg]: nothing lies on anything
else.
"""
STILL = np.zeros(1)
SHAPES = {
    "sun": "sun",
    "carrier arm, side 1": "carrier",
    "carrier arm, side 2": "carrier",
    "middle body, side 1": "middle body",
    "planet and nozzle, side 1": "planet",
}
"""Names of bodies of the statement by those of the scene; it has the nozzle's halves elsewhere."""
_ROUND = np.radians(np.arange(361))

At = Mapping[str, float]
"""Columns of a cycle at one of its angles."""


def draw_sheets(device: Device) -> list[Sheet]:
    """All drawings of the machine's own design."""
    x = device.design
    columns = device.columns(x, device.engine.list_angles(MOMENTS))
    sun, carrier = build_scene(device, x).bodies[:2]
    side = _still(device, (sun, replace(carrier, parts=carrier.parts[:1])), columns["phi_deg"])
    train = _still(
        device, (sun, replace(carrier, parts=[_bare(carrier.parts[0])])), columns["phi_deg"]
    )
    front = {name: float(values[PHI]) for name, values in columns.items()}
    swing = device.machine.cam.opening_deg / 2
    opening = int(np.argmin(np.abs(columns["theta1_deg"] - swing)))
    across = {name: float(values[opening]) for name, values in columns.items()}
    return [
        Sheet(
            "train", "sun and middle body from the front, side 1", train, _train(device, front), PHI
        ),
        Sheet(
            "nozzle", "planet and nozzle from the front, side 1", side, _planet(device, front), PHI
        ),
        Sheet(
            "half",
            "inner half across the nozzle, closed and opening",
            _across(device, across),
            _half(device, across),
        ),
        Sheet(
            "cam",
            "cam angles, seen along the planet's shaft from the carrier",
            _base(device),
            _cam(device),
        ),
    ]


def _at(columns: At, name: str) -> Array:
    return np.array([columns[f"x_{name}_mm"], columns[f"y_{name}_mm"]])


def _turned(vector: Sequence[float] | Array, degrees: float) -> Array:
    return rotation_matrix(np.radians(degrees)) @ np.asarray(vector, dtype=float)


def _angles(device: Device) -> dict[str, float]:
    """The angles of the design by their symbols [deg]."""
    entries = zip(device.names, device.entries, strict=True)
    return {
        entry["name"]: device.machine.design[name]
        for name, entry in entries
        if entry["unit"] == "rad"
    }


def _train(device: Device, at: At) -> list[Mark]:
    """Sun, middle body and what they are turned by; the polar angles count from the inner gears'
    own first radii.
    """
    o, a1, b1, p = (
        np.zeros(2),
        _at(at, "A1"),
        _at(at, "B1"),
        locate_pitch_curves(device, device.design, PHI, samples=4).contacts["P"],
    )
    design, sun, phi = _angles(device), device.machine.centroid, at["phi_deg"]
    line1, line2 = 90 + phi, 90 + phi + design["gamma"]
    reach = float(np.hypot(*a1))
    first, second = line1 - at["t1_deg"], line2 + at["t2_deg"]
    mounted = sun.middle_angle_deg + phi
    return [
        Length(("a1",), o, a1, 0.75),
        Length(("a2",), a1, b1, 0.6),
        Spot(("x_A1", "y_A1"), a1),
        Spot(("x_B1", "y_B1"), b1),
        Spot(("x_P", "y_P"), p),
        Angle(("phi_deg",), o, 90, phi, 0.95 * reach),
        Angle(("alpha3",), o, first, design["alpha3"], 0.62 * reach),
        Angle(("t1",), o, first, at["t1_deg"], 0.75 * reach),
        Angle(("gamma",), a1, line1, design["gamma"], 0.35 * reach),
        Angle(("t2",), a1, second, -at["t2_deg"], 0.72 * reach),
        Angle(("beta6",), a1, second, -design["beta6"], 0.82 * reach),
        Angle(("phi52",), a1, mounted, at["phi52_deg"], 0.5 * reach),
        Length(
            ("rho_CA",), a1, a1 + _turned([sun.middle_radius_mm, 0], mounted + at["phi52_deg"]), 1.0
        ),
        Length(("rho_CO",), o, _turned([sun.sun_radius_mm, 0], sun.sun_angle_deg), 1.0),
        Angle(("beta_CO",), o, 0, sun.sun_angle_deg, 0.3 * reach),
        Angle(("beta_CA",), a1, phi, sun.middle_angle_deg, 0.25 * reach),
    ]


def _planet(device: Device, at: At) -> list[Mark]:
    """Planet and nozzle; x' points along the nozzle."""
    b1, design, nozzle = _at(at, "B1"), _angles(device), device.machine.nozzle
    tip = np.array([at["tip_machine_x_mm"], at["tip_y_mm"]])
    planet = -at["alpha_deg"]
    hinge_x, hinge_y, _ = nozzle.hinge_A_mm
    roller = b1 + _turned([at["x_E_mm"], at["y_E_mm"]], planet)
    mounted = design["theta"] + at["phi_deg"] - 180
    return [
        Length(("L_tip",), b1, tip, 0.55),
        Spot(("x_tip", "y_tip"), tip),
        Spot(("x_tip_machine",), tip),
        Angle(("alpha",), b1, 0, planet, 45),
        Angle(("theta",), b1, at["phi_deg"] - 180, design["theta"], 75),
        Angle(("phi72",), b1, mounted, at["phi72_deg"], 100),
        Spot(("c_CBx", "c_CBy"), b1 + _turned(device.machine.centroid.planet_xy_mm, planet)),
        Spot(("x_A", "y_A"), b1 + _turned([hinge_x, hinge_y], planet)),
        Spot(("x_E", "y_E"), roller),
        Length(("R_b",), b1 + _turned([at["x_E_mm"], 0], planet), roller),
    ]


def _across(device: Device, at: At) -> Scene:
    """The inner half closed, palely, and as it opens; x' to the right, z' upwards, from B1."""
    hinge_x, _, hinge_z = device.machine.nozzle.hinge_A_mm
    shape, hinge = draw_halves(device)[0], np.array([hinge_x, hinge_z])
    rocker = np.array([[0.0, 0.0], _closed_roller(device)])
    swing = -at["theta1_deg"]
    axis = np.array([[0.0, 0.0], [device.machine.nozzle.tip_distance_mm, 0.0]])
    bodies = (
        Body("axis of the nozzle", (Outline(axis, "mark", closed=False),)),
        Body(
            "closed",
            (Outline(shape, "before"), Outline(rocker, "before", closed=False)),
            hinge.tolist(),
        ),
        Body(
            "open",
            (Outline(shape, "body", shade=4), Outline(rocker, "frame", closed=False)),
            hinge.tolist(),
            swing,
        ),
    )
    return _still(device, bodies)


def _still(device: Device, bodies: Sequence[Body], angles: Array = STILL) -> Scene:
    return Scene(device.machine.name, "carrier angle", "deg", angles, 1.0, bodies, again=False)


def _bare(arm: Body) -> Body:
    """A side without its nozzle."""
    middle, planet = arm.parts
    return replace(arm, parts=(middle, replace(planet, outlines=planet.outlines[:1])))


def _closed_roller(device: Device) -> Array:
    """The roller's centre from the hinge with the nozzle closed, x' and z' [mm]."""
    cam = device.machine.cam
    return _turned([cam.rocker_length_mm, 0], 180 - cam.psi0_deg)


def _half(device: Device, at: At) -> list[Mark]:
    """Return the parts that swing about the hinge, at their positions with the nozzle closed."""
    cam, nozzle = device.machine.cam, device.machine.nozzle
    hinge_x, _, hinge_z = nozzle.hinge_A_mm
    hinge = np.array([hinge_x, hinge_z])
    moving = hinge + _turned(_closed_roller(device), -at["theta1_deg"])

    def fixed(letter: str, place: Sequence[float]) -> Spot:
        return Spot([f"c_{letter}{axis}" for axis in "xyz"], hinge + np.array([place[0], place[2]]))

    return [
        Spot(("x_A", "z_A"), hinge),
        Length(("L_AE",), hinge, moving),
        Spot(("x_E",), moving),
        Angle(("psi0",), hinge, 180, -cam.psi0_deg, 0.8 * cam.rocker_length_mm),
        Angle(("theta1",), hinge, 0, -at["theta1_deg"], 60),
        Angle(("H",), hinge, 0, -cam.opening_deg, 100),
        fixed("C1", nozzle.C1_mm),
        fixed("C2", nozzle.C2_mm),
        fixed("F", nozzle.hook_F_mm),
        Length(("L_tip",), np.zeros(2), np.array([nozzle.tip_distance_mm, 0.0])),
    ]


def _base(device: Device) -> Scene:
    """The cam's base cylinder, with the arcs over which the nozzle opens and closes."""
    cam = device.machine.cam
    circle = cam.base_radius_mm * np.column_stack([np.sin(_ROUND), np.cos(_ROUND)])
    arcs = [
        Outline(_arc(cam.base_radius_mm, *ends), "frame", closed=False)
        for ends in (cam.rise_delta_deg, cam.fall_delta_deg)
    ]
    return _still(device, (Body("base cylinder", (Outline(circle, "body", shade=2), *arcs)),))


def _arc(radius: float, start: float, end: float) -> Array:
    angles = np.radians(np.linspace(start, end, 61))
    return radius * np.column_stack([np.sin(angles), np.cos(angles)])


def _cam(device: Device) -> list[Mark]:
    """Cam angles, clockwise from the initial position of the roller."""
    cam, centre = device.machine.cam, np.zeros(2)
    ends = {
        "delta_r0": cam.rise_delta_deg[0],
        "delta_r1": cam.rise_delta_deg[1],
        "delta_f0": cam.fall_delta_deg[0],
        "delta_f1": cam.fall_delta_deg[1],
    }
    radii = cam.base_radius_mm * np.array([0.3, 0.45, 0.6, 0.75])
    angles: list[Mark] = [
        Angle((name,), centre, 90, -end, float(radius))
        for (name, end), radius in zip(ends.items(), radii, strict=True)
    ]
    return [*angles, Length(("R_b",), centre, _arc(cam.base_radius_mm, 60, 60)[0], 0.9)]


def draw(source: str, changes: Mapping[str, float]) -> list[Sheet]:
    """Return the sheets of the machine in a file, or of the built-in one of that name."""
    return draw_sheets(Device(load(source, changes), "exact"))


def cut_bodies(source: str, changes: Mapping[str, float], angle_deg: float) -> FreeBodies:
    """Return the bodies of side 1, and sun and carrier with the loads of both sides, cut free at a
    carrier angle. Raises InputError and GeometryError as file and device do.
    """
    device = Device(load(source, changes), "exact")
    model, formulas = LiftedModel(device), load_formulas(NAME)
    turn = model.turn(np.radians([angle_deg]))
    values = {
        **dict(zip(formulas.entries("mounting"), device.design, strict=False)),
        **dict(zip(formulas.entries("machine"), device.constants, strict=True)),
        **dict(zip(("a1", "a2"), device.centre_distances(device.design), strict=True)),
        **dict.fromkeys(model.inputs, 0.0),
    }
    loads: list[dict[str, float]] = []
    for angle, side in zip(SIDES, (turn.one, turn.two), strict=True):
        moving = {name: row[0] for name, row in {**side, **turn.totals}.items()}
        moving["phi"] = np.radians(angle_deg) + angle
        loads.append(formulas.pick(LOADS, values | moving))
    components, second = loads
    entries: list[Mapping[str, Any]] = list(formulas.sidecar["loads"])
    for number, entry in enumerate(formulas.sidecar["loads"], 1):
        if entry.get("twice"):
            entries.append(entry | {"by": f"{entry['by']} of side 2"})
            start = f"load_{number}_"
            components |= {
                f"load_{len(entries)}_{name.removeprefix(start)}": value
                for name, value in second.items()
                if name.startswith(start)
            }
    bodies = group_loads(entries, components)
    shapes = _place_outlines(device, angle_deg)
    shaped = [replace(body, is_flat=True, outlines=shapes.get(body.name, ())) for body in bodies]
    return FreeBodies(device.machine.name, angle_deg, shaped)


def _place_outlines(device: Device, angle_deg: float) -> dict[str, list[Outline]]:
    """Return the outlines of bodies by name at the whole degree that is nearest to a carrier
    angle.
    """
    scene, moment = build_scene(device, device.design), round(angle_deg) % MOMENTS
    placed = scene.placed(slice(moment, moment + 1))
    shapes: dict[str, list[Outline]] = {}
    for body in scene.all_bodies():
        for outline, (points,) in islice(placed, len(body.outlines)):
            if body.name in SHAPES:
                shapes.setdefault(SHAPES[body.name], []).append(replace(outline, points=points))
    return shapes
