"""The planting device whose carrier accelerates, as a motor and a flywheel drive it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Quantity, Value
from planter.errors import InputError
from planter.files import units
from planter.kernels import generated
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.functions import build_flank_function
from planter.papers.planting.model import SIDES, SPEED, Device, list_quantities

NAME = "planting_drive"
PATH = "operation.acceleration_rad_s2"
"""Path of the carrier's acceleration, which no file has: it is zero unless a motor drives the
device.
"""


def build_driven_file(machine: PlantingMachine) -> Machine:
    """Return the driven device of a file."""
    return build_driven_machine(Device(machine))


def build_driven_machine(device: Device) -> Machine:
    """Return a device at its own design whose last value is the carrier's acceleration.

    Raises InputError if printed.

    The design is fixed: the curves of its gears are given to the lane, which finds all else at
    every speed.
    """
    if device.model != "exact":
        raise InputError(
            "a motor drives the exact model: the printed one holds at constant speed alone"
        )
    functions, module = device.functions, generated.module(NAME)
    vectors = generated.sidecar(NAME)["vectors"]
    values = tuple(
        Value(e["name"], e["unit"], e["meaning"], e["shown"], e["source"])
        for e in vectors["machine"]
    )
    values += tuple(
        Value(e["name"], e["unit"], e["meaning"], PATH, e["source"]) for e in vectors["drive"]
    )
    size = len(vectors["machine"])
    phi, d, q = ca.SX.sym("phi"), ca.SX.sym("d", len(values)), ca.SX.sym("q", 0)
    h = ca.SX.sym("h", 0)
    contacts = [stage.contact.function for stage in device.stages]
    lane = module.lane(*contacts, build_flank_function(device.machine.cam.flank))
    prologue = module.prologue(*contacts)
    values_at_design = [device.design, device.prologue(device.design).h]
    _, *packed, _, _ = ca.substitute(
        functions.lane_inputs(phi), [functions.x, functions.h], values_at_design
    )
    machine_values, rate = d[:size], d[size:]
    side = lane(phi, *packed, machine_values, rate, prologue(*packed, machine_values, rate))
    first, second = (ca.SX.sym(name, side.numel()) for name in ("one", "two"))
    shared = ("F_E_loss", "T_side", "V_side")
    names = [entry["name"] for entry in vectors["side"]]
    sums = [first[names.index(name)] + second[names.index(name)] for name in shared]
    frame = module.frame()(first, second, machine_values)
    totals = tuple(
        Quantity(
            f"{name}_sum",
            e["unit"],
            f"{e['meaning']}, both sides",
            units.display_key(f"{name}_sum", e["unit"]),
            True,
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
        quantities=(*list_quantities(vectors), *totals),
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
