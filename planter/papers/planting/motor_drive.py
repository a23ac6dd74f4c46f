"""The planting device whose carrier accelerates, as a motor and a flywheel drive it."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Quantity, Value
from planter.errors import InputError
from planter.files import units
from planter.kernels import generated
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.lifted import NAME, build_side_function
from planter.papers.planting.model import SIDES, SPEED, Device, list_quantities

ASSUMPTIONS = (
    "as the exact model, but for the constant speed",
    "the motor's torque falls with the speed along a line",
    "motor and flywheel turn with the carrier, without slip or backlash",
)
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
    sidecar = generated.sidecar(NAME)
    vectors = sidecar["vectors"]
    (acceleration,) = (e for e in vectors["lifted"] if e["name"] == "speed_rate")
    values = tuple(
        Value(e["name"], e["unit"], e["meaning"], path, e["source"])
        for e, path in (*((e, e["shown"]) for e in vectors["machine"]), (acceleration, PATH))
    )
    size = len(vectors["machine"])
    phi, d, q = ca.SX.sym("phi"), ca.SX.sym("d", len(values)), ca.SX.sym("q", 0)
    h, lifted = ca.SX.sym("h", 0), ca.SX(len(vectors["lifted"]), 1)
    lifted[vectors["lifted"].index(acceleration)] = d[size]
    at_design = device.prologue(device.design).h
    side = build_side_function(device)(phi, device.design, d[:size], at_design, lifted)
    first, second = (ca.SX.sym(name, side.numel()) for name in ("one", "two"))
    energies = ("T_side", "V_side")
    shared = ("F_E_loss", *energies)
    names = [entry["name"] for entry in vectors["side"]]
    sums = [first[names.index(name)] + second[names.index(name)] for name in shared]
    frame = generated.module(NAME).frame()(first, second, d[:size])
    results = {*energies, *(q.name for q in list_quantities(device.sidecar["vectors"]))}
    quantities = (
        quantity if quantity.name in results else replace(quantity, role="inner")
        for quantity in list_quantities(vectors)
    )
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
        assumptions=ASSUMPTIONS,
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
