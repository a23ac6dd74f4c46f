"""The end-face cam of a planting device as a part, from its law: contour for a roller, and when
that lifts off.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import casadi as ca
import numpy as np

from planter.errors import InputError
from planter.gears.workshop import solids
from planter.gears.workshop.cam import (
    Columns,
    Profile,
    Push,
    build_cam_part,
    check_roller,
    find_lift_off,
)
from planter.gears.workshop.cam_report import CamOutput
from planter.kernels import Array, Kernel, generated
from planter.kernels.formulas import HOISTED, load
from planter.papers.planting import functions
from planter.papers.planting.model import Device

CAM = "planting_end_face"
Section = Callable[[Array], Columns]
"""Columns (n,) [SI] of a section of the cam at angles (n,) [rad]."""


class EndFace:
    """Sections of the cam for a roller's radius [m], along the cam angle.

    Raises InputError for a roller of no size, GeometryError, from `Profile.check`, for one that is
    too large.
    """

    def __init__(self, device: Device, roller: float) -> None:
        check_roller(roller)
        self.device, self.roller = device, roller
        module = generated.module(CAM)
        self._prologue = Kernel(module.prologue())
        lane = module.lane(functions.build_flank_function(device.machine.cam.flank))
        self._lane = Kernel(lane, lanes=["delta"])
        self._names = load(CAM).entries("contour")
        self.radius = device.machine.si("base_radius_mm")

    def section(self, station: float) -> Section:
        """Quantities of the generated functions in a section at a distance from the cam's axis
        [m].
        """
        roller = np.array([self.roller, station])
        hoisted = self._prologue(machine=self.device.constants, roller=roller)[HOISTED]

        def evaluate_columns(delta: Array) -> Columns:
            outputs = self._lane(
                delta=delta, machine=self.device.constants, roller=roller, hoisted=hoisted[:, 0]
            )
            return dict(zip(self._names, outputs["contour"], strict=True))

        return evaluate_columns

    @property
    def breaks(self) -> tuple[float, ...]:
        """Angles of a turn between which the cam is smooth, its ends among them."""
        entries = [entry["name"] for entry in self.device.sidecar["vectors"]["machine"]]
        constants = dict(zip(entries, self.device.constants.tolist(), strict=True))
        candidates = tuple(
            sorted({e["position"] for e in self.device.sidecar["events"] if "position" in e})
        )
        breakpoints = functions.find_flank_breakpoints(self.device.machine.cam.flank, candidates)
        positions = [breakpoint.position for breakpoint in breakpoints]
        flanks = [(constants[f"delta_{f}0"], constants[f"delta_{f}1"]) for f in "rf"]
        inner = {start + x * (end - start) for start, end in flanks for x in (0.0, *positions, 1.0)}
        return tuple(sorted({0.0, 2 * np.pi} | {at for at in inner if 0 < at < 2 * np.pi}))

    def at(self, station: float) -> Profile:
        """A section [m], unrolled as seen from outside."""
        section = self.section(station)
        return Profile(
            self.device.machine.name, self.roller, section, self.breaks, False, ("along", "height")
        )


def build_push(device: Device) -> Push:
    """The force of the cam on the roller by the carrier angle and speed, in the device's model."""
    functions = device.functions
    index = device.formulas.entries("side").index("F_E")
    force, names = functions.side(functions.phi)[index], ["phi", "x", "c", "h"]
    kernel = Kernel(ca.Function("push", functions.inputs, [force], names, ["F_E"]), lanes=["phi"])
    speed_at = [entry["name"] for entry in device.sidecar["vectors"]["machine"]].index("omega")

    def at(phi: Array, speed: float) -> Array:
        constants = device.constants.copy()
        constants[speed_at] = speed
        h = device.hoisting_kernel(x=device.design, c=constants)["h"][:, 0]
        force_N: Array = kernel(phi=phi, x=device.design, c=constants, h=h)["F_E"].ravel()
        return force_N

    return at


def build_cam(device: Device, roller: float, tolerance: float, width: float) -> CamOutput:
    """The cam with a rim of a `width` [m] about the base cylinder, for a roller of a radius, arcs
    within `tolerance`.

    Raises InputError for a rim that reaches the axis, GeometryError for a roller that cuts in,
    inside the rim or at it.
    """
    face, machine = EndFace(device, roller), device.machine
    if not width < 2 * face.radius:
        raise InputError(
            f"--width-mm = {width * 1e3:g}: it must be less than the base cylinder's diameter of "
            f"{2e3 * face.radius:g} mm"
        )
    pushing, speed = build_push(device), machine.si("speed_rpm")
    stations = (face.radius - width / 2, face.radius + width / 2)
    for station in stations:
        face.at(station).check_clearance()
    lift_off = find_lift_off(pushing, speed)
    meanings = {entry["shown"]: entry["meaning"] for entry in device.sidecar["vectors"]["machine"]}
    return CamOutput(
        build_cam_part(face.at(face.radius), "end-face", tolerance, lift_off, width),
        machine,
        meanings,
        load(CAM).sidecar,
        pushing,
        speed,
        lambda: _solid(face, stations, width),
    )


def _solid(face: EndFace, stations: tuple[float, float], width: float) -> bytes:
    """The rim between two sections, down to a plane a width below its lowest place."""
    inner, outer = (face.section(station) for station in stations)
    low = min(face.at(station).find_smallest("surface_z").value for station in stations)
    rims = [
        (_build_contact_curve(inner, a, b), _build_contact_curve(outer, a, b))
        for a, b in pairwise(face.breaks)
    ]
    return solids.format_ring(f"cam of {face.device.machine.name}", rims, low - width)


def _build_contact_curve(section: Section, start: float, end: float) -> solids.SpaceCurve:
    """The contact in space along a smooth piece."""

    def evaluate_points(s: Array) -> Array:
        columns = section(start + (end - start) * s)
        return np.column_stack([columns[f"surface_{axis}"] for axis in "xyz"])

    return evaluate_points
