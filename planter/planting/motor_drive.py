"""The planting device on a motor and a flywheel: the machine whose carrier accelerates, and its cycle."""

from __future__ import annotations

from dataclasses import dataclass, fields

import casadi as ca
import numpy as np

from planter.engine.drive import Drive, DriveResult, Motor, drive_machine
from planter.engine.machine import Machine, Quantity, Value
from planter.errors import InputError
from planter.files import units
from planter.kernels import Array, generated
from planter.planting.cycle import compute_statistics
from planter.planting.file import PlantingMachine
from planter.planting.functions import build_flank_function
from planter.planting.model import FORCE, SIDES, SPEED, Device
from planter.planting.results import DriveFound

NAME = "planting_drive"
PATH = "operation.acceleration_rad_s2"
"""Path of the carrier's acceleration, which no file has: it is zero unless a motor drives the device."""


def build_driven_file(machine: PlantingMachine) -> Machine:
    """Return the driven device of a file."""
    return build_driven_machine(Device(machine))


def build_driven_machine(device: Device) -> Machine:
    """Return a device at its own design whose last value is the carrier's acceleration. Raises InputError if printed.

    The design is fixed: the curves of its gears are given to the lane, which finds all else at every speed.
    """
    if device.model != "exact":
        raise InputError("a motor drives the exact model: the printed one holds at constant speed alone")
    functions, module = device.functions, generated.module(NAME)
    vectors = generated.sidecar(NAME)["vectors"]
    values = tuple(Value(e["name"], e["unit"], e["meaning"], e["shown"], e["source"]) for e in vectors["machine"])
    values += tuple(Value(e["name"], e["unit"], e["meaning"], PATH, e["source"]) for e in vectors["drive"])
    size = len(vectors["machine"])
    phi, d, q = ca.SX.sym("phi"), ca.SX.sym("d", len(values)), ca.SX.sym("q", 0)
    h = ca.SX.sym("h", 0)
    contacts = [stage.contact.function for stage in device.stages]
    lane = module.lane(*contacts, build_flank_function(device.machine.cam.flank))
    prologue = module.prologue(*contacts)
    values_at_design = [device.design, device.prologue(device.design).h]
    _, *packed, _, _ = ca.substitute(functions.lane_inputs(phi), [functions.x, functions.h], values_at_design)
    machine_values, rate = d[:size], d[size:]
    side = lane(phi, *packed, machine_values, rate, prologue(*packed, machine_values, rate))
    first, second = (ca.SX.sym(name, side.numel()) for name in ("one", "two"))
    shared = ("F_E_loss", "T_side", "V_side")
    names = [entry["name"] for entry in vectors["side"]]
    sums = [first[names.index(name)] + second[names.index(name)] for name in shared]
    frame = module.frame()(first, second, machine_values)
    quantities = tuple(
        Quantity(e["name"], e["unit"], e["meaning"], e.get("shown") or units.display_key(e["name"], e["unit"]), total)
        for vector, total in (("side", False), ("totals", True))
        for e in vectors[vector]
    )
    totals = tuple(
        Quantity(
            f"{name}_sum", e["unit"], f"{e['meaning']}, both sides", units.display_key(f"{name}_sum", e["unit"]), True
        )
        for name in shared
        for e in vectors["side"]
        if e["name"] == name
    )
    data = np.append(device.constants, 0.0)
    return Machine(
        document=device.machine,
        build=build_driven_file,
        assumptions=tuple(generated.sidecar(NAME)["assumptions"]),
        values=values,
        data=data,
        moved=(),
        lower=np.empty(0),
        upper=np.empty(0),
        quantities=(*quantities, *totals),
        prologue=ca.Function("prologue", [d], [ca.SX.zeros(0, 1)], ["d"], ["h"]),
        lane=ca.Function("lane", [phi, d, h, q], [side], ["phi", "d", "h", "q"], ["y"]),
        speed=[value.path for value in values].index(SPEED),
        totals=ca.Function("totals", [first, second, d], [ca.vertcat(frame, *sums)]),
        offsets=SIDES,
        samples=device.machine.objective.samples,
        motors=("M_L",),
        acceleration=size,
        losses=("F_E_loss_sum",),
        energies=("T_side_sum", "V_side_sum"),
    )


COLUMN = {FORCE: "support_N"}
"""The quantity that is reported, and its column."""


@dataclass(frozen=True)
class DeviceDrive:
    """A device on a motor: the drive of the machine that it is, and the result with its support force."""

    drive: Drive
    result: DriveFound

    def columns(self) -> dict[str, Array]:
        """Return the turn as a table, each column in the unit that its name ends in."""
        return self.drive.columns(COLUMN)


def drive_device(
    device: Device, motor: Motor, turns: int = 5, start: float | None = None, samples: int | None = None
) -> DeviceDrive:
    """The device at its own design, driven from a speed [rad/s] on, its machine's unless told.

    Raises InputError for the printed model, ComputationError where the motor stalls.
    """
    machine = build_driven_machine(device)
    names = tuple(quantity.name for quantity in machine.results if quantity.unit in ("N", "N m"))
    driven = drive_machine(machine, motor, turns, start, samples, names)
    varying, steady = (state.values[FORCE][:-1] for state in (driven.driven, driven.constant))
    general = {field.name: getattr(driven.result, field.name) for field in fields(DriveResult)}
    result = DriveFound(
        **general,
        support_force=compute_statistics(varying),
        constant_speed=compute_statistics(steady),
        change_N=float(np.abs(varying - steady).max()),
    )
    return DeviceDrive(driven, result)
