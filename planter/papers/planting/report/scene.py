"""Animated scene of a planting device over a cycle: carrier, gears, middle bodies and nozzles of
both sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.engine.solvers.response import list_breakpoints
from planter.errors import GeometryError, InputError
from planter.files import units
from planter.gears.geometry.cutting import DEFAULT_MODULE, ToothOrder
from planter.gears.geometry.polygons import build_polygon
from planter.kernels import Array
from planter.numerics.arrays import rotation_matrix
from planter.papers.planting.model import Device
from planter.papers.planting.toothed import Gearing, cut_gear_train, locate_pitch_curves
from planter.report.scene import (
    Body,
    Curve,
    Event,
    Force,
    Label,
    Outline,
    Point,
    Scene,
    simplify_outline,
)

ORDER = ToothOrder(keep="size", process="wire")
"""What is drawn leaves open what cuts it."""
WITHIN = 0.025 * DEFAULT_MODULE
"""How far a drawn outline may be from the teeth [m]: less than a screen shows."""


def build_tooth_outlines(device: Device, x: Array) -> tuple[Body, ...]:
    """Return the outlines of sun, gear 5, gear 6 and planet gear of a design x (p,) in SI; none if
    they cannot be cut.

    Each is turned about its gear's axis to its position on side 1 at carrier angle 0.
    """
    try:
        train = cut_gear_train(device, (ORDER, ORDER), x)
    except (GeometryError, InputError):
        return ()
    gears = [gear for stage in train.stages for gear in stage.gears]
    return tuple(
        Body(
            f"teeth of the {gear.name}",
            (Outline(1e3 * simplify_outline(build_polygon(gear), WITHIN), "teeth", shade=shade),),
            turn=float(np.degrees(place.angle)),
        )
        for shade, (gear, place) in enumerate(zip(gears, train.place_gears(), strict=True))
    )


MOMENTS, CORNERS = 360, 180
"""Of a turn, and of a pitch curve."""
CURVES = {
    "support_N": "vertical support force",
    "M_L_Nm": "torque of the motor",
    "F_E_N": "force of the cam on the roller, side 1",
    "theta1_deg": "swing of a nozzle half, side 1",
    "F_A1_N": "force of the middle shaft on the carrier, side 1",
    "F_B1_N": "force of the planet's shaft on the carrier, side 1",
    "phi52_deg": "rotation of the middle body on the carrier, side 1",
    "tip_y_mm": "height of the tip, side 1",
}
"""Columns of a cycle that are drawn, and what they are called."""
FORCES = {
    "F_A1": ("A1", "middle shaft on the carrier at A1"),
    "F_B1": ("B1", "planet's shaft on the carrier at B1"),
}
WIDE = 0.06
"""Half the width of a nozzle half at its root, in parts of its length: the machine file does not
hold it.
"""
CHANGES = {"cam, start of the rise": True, "cam, start of the fall": False}
"""Breakpoints at which a nozzle begins to open (True) or to close."""
STEP_DEG = 1.0
"""Angle after a breakpoint at which it is seen which side's nozzle swings."""


@dataclass(frozen=True)
class NozzleChange:
    """A carrier angle [deg] at which the nozzle of a side begins to open or to close."""

    angle_deg: float
    side: int
    opens: bool


def list_nozzle_changes(device: Device, x: Array) -> list[NozzleChange]:
    """Return where the nozzles of a design x (p,) in SI begin to open and to close, over a cycle."""
    changes = []
    for breakpoint_ in list_breakpoints(device.force, device.prologue(x)):
        if breakpoint_.name in CHANGES:
            angles = breakpoint_.angle + np.radians([0.0, STEP_DEG])
            swings = np.ptp(device.columns(x, angles)["theta1_deg"]) > 0
            angle_deg = float(np.degrees(breakpoint_.angle))
            side = 1 if swings else 2
            changes.append(NozzleChange(angle_deg, side, CHANGES[breakpoint_.name]))
    return sorted(changes, key=lambda change: change.angle_deg)


SOIL_BELOW, SOIL_BESIDE = 30.0, 40.0
"""How far soil is drawn below the lowest tip, and beside the path of the tips [mm]."""


def build_scene(
    device: Device, x: Array, before: Array | None = None, toothed: bool = True
) -> Scene:
    """The turn of a design x (p,) in SI; the path of the tip `before` it is drawn palely.

    Its gears have teeth where those can be made, but for a scene that is not `toothed`: it is found
    ten times faster.
    """
    columns = device.columns(x, device.engine.list_angles(MOMENTS))
    measured = device.measure(x, columns)
    columns |= {
        f"{name}_N": np.hypot(columns[f"{name}x_N"], columns[f"{name}y_N"]) for name in FORCES
    }
    gears = locate_pitch_curves(device, x, samples=CORNERS)
    speed, forward = (
        device.machine.si(f"operation.{key}") for key in ("speed_rpm", "forward_speed_m_s")
    )
    seconds = 2 * np.pi / abs(speed)
    cut = build_tooth_outlines(device, x) if toothed else ()
    sides = [_side(device, gears, columns, cut, side) for side in (1, 2)]
    corner = _corner(device, columns)
    carrier = Body("carrier", (), turn=columns["phi_deg"], parts=sides)
    points = [_tip(columns, side) for side in (1, 2)]
    return Scene(
        title=f"{device.machine.name}, {device.model} model",
        place="carrier angle",
        unit="deg",
        places=columns["phi_deg"],
        seconds=seconds,
        bodies=(
            _sun(gears, cut),
            carrier,
            *_halves(device, columns, corner),
            *_before(device, before),
            *_soil_beneath(device, columns),
        ),
        points=points,
        forces=[_force(columns, name, side) for side in (1, 2) for name in FORCES],
        curves=[
            *(
                []
                if measured is None
                else [Curve(measured.name, measured.result.unit, measured.signal)]
            ),
            *(_curve(device, columns, key) for key in CURVES),
        ],
        events=[
            Event(p.name, float(np.degrees(p.angle)))
            for p in list_breakpoints(device.force, device.prologue(x))
        ],
        labels=(
            Label("nozzle opening (front view)", float(corner[0]), float(corner[1]) + 70, "end"),
        ),
        ground=_planted_soil(device, columns, forward * seconds * 1e3),
        travel=1e3 * forward * columns["phi_deg"] / 360 * seconds,
    )


def _sun(gears: Gearing, cut: Sequence[Body]) -> Body:
    return Body("sun", (Outline(gears.curves[0].points.T, "gear", shade=0),), parts=cut[:1])


def _side(
    device: Device, gears: Gearing, columns: dict[str, Array], cut: Sequence[Body], side: int
) -> Body:
    """Return the body of a side, with cut gears, seen from the carrier; side 2 is rotated by half a
    revolution.
    """
    a1, b1 = gears.centres["A1"], gears.centres["B1"]
    mounted = float(columns["alpha_deg"][0])
    planet_rotation = -columns["alpha_deg"] - columns["phi_deg"]
    middle = Body(
        f"middle body, side {side}",
        [Outline((gears.curves[k].points.T - a1), "gear", shade=k) for k in (1, 2)],
        a1.tolist(),
        _delay_side(columns["phi52_deg"], side),
        cut[1:3],
    )
    planet = gears.curves[3].points.T - b1
    planet_outline = Outline(planet @ rotation_matrix(-np.radians(mounted)), "gear", shade=3)
    outlines = [planet_outline, *_nozzle(device)]
    planet_teeth = [replace(body, turn=body.turn + mounted) for body in cut[3:]]
    nozzle = Body(
        f"planet and nozzle, side {side}",
        outlines,
        b1.tolist(),
        _delay_side(planet_rotation, side),
        planet_teeth,
    )
    bar = Outline(np.array([[0.0, 0.0], a1, b1]), "frame", closed=False)
    return Body(
        f"carrier arm, side {side}", (bar,), turn=180.0 * (side - 1), parts=(middle, nozzle)
    )


def _delay_side(values: Array, side: int) -> Array:
    """Return the motion of a side; side 2 follows side 1 half a revolution later."""
    return np.roll(values, 0 if side == 1 else MOMENTS // 2)


def _nozzle(device: Device) -> list[Outline]:
    """Sketch of the nozzle in the planet's frame: its length is the machine's, its width is not."""
    length = device.machine.nozzle.tip_distance_mm
    half = WIDE * length
    shape = np.array(
        [
            [-0.6 * half, half],
            [0.45 * length, half],
            [length, 0.0],
            [0.45 * length, -half],
            [-0.6 * half, -half],
        ]
    )
    return [Outline(shape, "body", shade=4)]


def _corner(device: Device, columns: dict[str, Array]) -> Array:
    """Return the position of the view across the nozzle, right of all moving bodies."""
    hinge_x, _, hinge_z = device.machine.nozzle.hinge_A_mm
    right = (
        float(np.max(columns["tip_machine_x_mm"])) + device.machine.nozzle.tip_distance_mm - hinge_x
    )
    return np.array([right, float(np.max(columns["y_B1_mm"])) - hinge_z])


def draw_halves(device: Device) -> tuple[Array, Array]:
    """Sketch of the inner and the outer half of the nozzle across it, from their hinges with x' to
    the right.
    """
    hinge_x, _, hinge_z = device.machine.nozzle.hinge_A_mm
    length = device.machine.nozzle.tip_distance_mm - hinge_x
    inner = np.array(
        [[-0.15 * length, 0.0], [0.0, 0.07 * length], [length, -hinge_z], [0.5 * length, -hinge_z]]
    )
    return inner, inner * [1, -1]


def _halves(device: Device, columns: dict[str, Array], corner: Array) -> list[Body]:
    """Both halves of the nozzle of side 1, seen across it: the cam swings them about their
    hinges.
    """
    hinge_x, _, hinge_z = device.machine.nozzle.hinge_A_mm
    length = device.machine.nozzle.tip_distance_mm - hinge_x
    bodies = []
    for name, sense, shape in zip(("inner", "outer"), (1, -1), draw_halves(device), strict=True):
        outline = Outline(shape, "body", shade=4)
        x, y = corner[0] - length, corner[1] + sense * hinge_z
        bodies.append(
            Body(
                f"{name} half, side 1",
                (outline,),
                (float(x), float(y)),
                sense * columns["theta1_deg"],
            )
        )
    return bodies


def _tip(columns: dict[str, Array], side: int) -> Point:
    mark = "" if side == 1 else "_2"
    return Point(
        f"tip, side {side}",
        columns[f"tip_machine_x{mark}_mm"],
        columns[f"tip_y{mark}_mm"],
        traced=side == 1,
    )


def _force(columns: dict[str, Array], name: str, side: int) -> Force:
    mark = "" if side == 1 else "_2"
    at, words = FORCES[name]
    place = Point(at, columns[f"x_{at}{mark}_mm"], columns[f"y_{at}{mark}_mm"])
    return Force(
        f"{words}, side {side}", place, columns[f"{name}x{mark}_N"], columns[f"{name}y{mark}_N"]
    )


def _curve(device: Device, columns: dict[str, Array], key: str) -> Curve:
    reference = device.weight if key == "support_N" else None
    return Curve(CURVES[key], units.display_unit(key), columns[key], reference)


def _before(device: Device, x: Array | None) -> list[Body]:
    """The path of the tip in another design."""
    if x is None:
        return []
    columns = device.columns(x, device.engine.list_angles(MOMENTS))
    path = np.column_stack([columns["tip_machine_x_mm"], columns["tip_y_mm"]])
    return [Body("path of the tip before, side 1", (Outline(path, "before"),))]


def _find_surface(device: Device, lowest: float) -> float | None:
    """Return the level of the soil [mm] with the lowest tip point, None if the file does not say
    it.
    """
    required = device.machine.requirements
    return None if required is None else required.surface_mm(lowest)


def _lay_soil(ends: tuple[float, float], surface: float, lowest: float) -> list[Outline]:
    """Return the ground between two ends [mm], and its surface."""
    (left, right), bottom = ends, lowest - SOIL_BELOW
    corners = [[left, surface], [right, surface], [right, bottom], [left, bottom]]
    line = Outline(np.array(corners[:2]), "ground", closed=False)
    return [Outline(np.array(corners), "soil"), line]


def _soil_beneath(device: Device, columns: dict[str, Array]) -> list[Body]:
    """Return the soil beneath the path of the tips, where the machine is at rest."""
    lowest = float(np.min(columns["tip_y_mm"]))
    surface = _find_surface(device, lowest)
    if surface is None:
        return []
    x = columns["tip_machine_x_mm"]
    ends = float(np.min(x)) - SOIL_BESIDE, float(np.max(x)) + SOIL_BESIDE
    return [Body("soil", _lay_soil(ends, surface, lowest))]


def _planted_soil(device: Device, columns: dict[str, Array], advance: float) -> list[Outline]:
    """Return the soil over the way of a turn, and where both sides plant; only where the file says
    how deep.
    """
    low = int(np.argmin(columns["tip_y_mm"]))
    lowest = float(columns["tip_y_mm"][low])
    surface = _find_surface(device, lowest)
    if surface is None:
        return []
    depth = surface - lowest
    first = float(columns["tip_x_mm"][low])
    x = columns["tip_machine_x_mm"]
    left, right = sorted((float(np.min(x)), float(np.max(x)) + advance))
    plants = first + advance / 2 * np.arange(-1, 2)
    inside = plants[(plants >= left) & (plants <= right)]
    holes = [
        Outline(np.array([[at, surface], [at, surface - depth]]), "ground", closed=False)
        for at in inside
    ]
    return [*_lay_soil((left, right), surface, lowest), *holes]
