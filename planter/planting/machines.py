"""Planting devices as the engine takes them: gear stages and a cam law composed in, two sides half a turn apart."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Quantity, Value, build_vectors
from planter.files import examples, units
from planter.planting import file
from planter.planting.functions import Functions, Model
from planter.planting.model import Device
from planter.planting.swept.room import KIND, OWN

SIDES = (0.0, -np.pi)
"""Where the two sides stand [rad]."""
SPEED = "operation.speed_rpm"
VECTORS = {
    "tooth_P": ("F_Px", "F_Py"),
    "tooth_Q": ("F_Qx", "F_Qy"),
    "bearing_A1": ("F_A1x", "F_A1y"),
    "bearing_B1": ("F_B1x", "F_B1y"),
    "hinge_inner": ("F_Ax", "F_Ay", "F_Az"),
    "hinge_outer": ("F_Aox", "F_Aoy", "F_Aoz"),
    "bearing_O1": ("F_O1x", "F_O1y"),
    "mount_O": ("F_Ox", "F_Oy"),
    "frame": ("F_support_x", "F_support"),
}
"""Forces by their components; those that a model does not report are left out."""


def takes(source: str) -> bool:
    """Return whether a source is a planting device's file, or the name of a built-in one."""
    return examples.belongs(source, KIND, OWN)


def load(source: str, changes: Mapping[str, float], model: Model = "exact") -> Machine:
    """Return the machine of a planting device; raises InputError and GeometryError as its file and device do."""
    return build_machine(Device(file.load(source, changes), model))


def build_machine(device: Device) -> Machine:
    """Return a device as a machine: its values are the design parameters, then the numbers of the file."""
    functions, vectors = device.functions, device.sidecar["vectors"]
    size = device.size
    design = [
        Value(entry["name"], entry["unit"], entry["meaning"], f"design.{name}", entry["source"])
        for name, entry in zip(device.names, device.entries, strict=True)
    ]
    data = [Value(e["name"], e["unit"], e["meaning"], e["shown"], e["source"]) for e in vectors["machine"]]
    values = (*design, *data)
    d, q = ca.SX.sym("d", len(values)), ca.SX.sym("q", 0)

    def compose(name: str, output: ca.SX) -> ca.Function:
        (graph,) = ca.substitute([output], [functions.x, functions.c], [d[:size], d[size:]])
        return ca.Function(name, [functions.phi, d, functions.h, q], [graph], ["phi", "d", "h", "q"], ["y"])

    lane = compose("lane", functions.side(functions.phi))
    one, two = (ca.SX.sym(side, lane.numel_out(0)) for side in ("one", "two"))
    totals = ca.Function("totals", [one, two, d], [functions.frame(one, two, d[size:])])
    both = ca.MX.sym("d", len(values))
    prologue = ca.Function("prologue", [both], [functions.prologue_function(both[:size], both[size:])], ["d"], ["h"])
    quantities = tuple(
        Quantity(
            e["name"], e["unit"], e["meaning"], e.get("shown") or units.key(e["name"], e["unit"]), total,
            source=e["source"],
        )
        for vector, total in (("side", False), ("totals", True))
        for e in vectors[vector]
    )  # fmt: skip
    return Machine(
        name=device.machine.name,
        source=device.machine.source,
        assumptions=tuple(device.sidecar["assumptions"]),
        values=values,
        data=np.concatenate([device.design, device.constants]),
        moved=tuple(range(size)),
        lower=device.lower,
        upper=device.upper,
        quantities=quantities,
        prologue=prologue,
        lane=lane,
        speed=[value.path for value in values].index(SPEED),
        totals=totals,
        events=compose("events", functions.events),
        event_kinds=tuple(device.sidecar["events"]),
        offsets=SIDES,
        samples=device.machine.objective.samples,
        tangent=lambda moved: _tangent(functions, size, moved),
        vectors=tuple(build_vectors(VECTORS, quantities)),
        motors=("M_L",),
    )


def _tangent(functions: Functions, size: int, moved: tuple[int, ...]) -> ca.Function:
    """Return (d) -> h, dh: the prologue and its sparse Jacobian in the moved values, stage by stage."""
    count = size + functions.c.numel()
    d = ca.MX.sym("d", count)
    h, along_design = functions.tangent_function(d[:size], d[size:])
    along_data = ca.MX(h.numel(), count - size)
    if any(index >= size for index in moved):
        along_data = functions.data_tangent_function(d[:size], d[size:], h)
    dh = ca.horzcat(along_design, along_data)[:, list(moved)]
    return ca.Function("tangent", [d], [h, dh], ["d"], ["h", "dh"])
