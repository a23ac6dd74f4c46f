"""Planting devices as the engine takes them: gear stages and a cam law composed in, two sides half a turn apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Protocol

import casadi as ca
import numpy as np

from planter.engine.machine import Documentation, Machine, Quantity, Value, build_vectors
from planter.engine.measures import Kind, Measure
from planter.files import units
from planter.files.fields import read_range
from planter.kernels import Array
from planter.planting import flanks
from planter.planting.file import Machine as MachineFile
from planter.planting.functions import Functions, Model

SIDES = (0.0, -np.pi)
"""Where the two sides stand [rad]."""
SPEED = "operation.speed_rpm"
FORCE = "F_support"
"""The vertical force on the support."""
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


class Parts(Protocol):
    """What a device is made of: its file, its data (v,) and bounds (p,) in SI, and its functions."""

    machine: MachineFile
    model: Model
    functions: Functions
    sidecar: dict[str, Any]
    names: tuple[str, ...]
    data: Array
    lower: Array
    upper: Array

    @property
    def entries(self) -> list[Mapping[str, str]]:
        """Name, unit and meaning of each design parameter."""


def build_machine(device: Parts) -> Machine:
    """Return a device as a machine: its values are the design parameters, then the numbers of the file."""
    functions, vectors = device.functions, device.sidecar["vectors"]
    size = len(device.names)
    design = [
        Value(entry["name"], entry["unit"], entry["meaning"], f"design.{name}", entry["source"])
        for name, entry in zip(device.names, device.entries, strict=True)
    ]
    data = [
        Value(e["name"], e["unit"], e["meaning"], e["shown"], e["source"], read_range(MachineFile, e["shown"]))
        for e in vectors["machine"]
    ]
    values = (*design, *data)
    kinds = _find_event_kinds(device.sidecar["events"], device.machine.cam.flank)
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
        document=device.machine,
        build=partial(_rebuild, type(device), device.model),
        assumptions=tuple(device.sidecar["assumptions"]),
        values=values,
        data=device.data,
        moved=tuple(range(size)),
        lower=device.lower,
        upper=device.upper,
        quantities=quantities,
        prologue=prologue,
        lane=lane,
        speed=[value.path for value in values].index(SPEED),
        totals=totals,
        events=compose("events", functions.events[list(kinds)]),
        event_kinds=tuple(kinds.values()),
        offsets=SIDES,
        samples=device.machine.objective.samples,
        tangent=lambda moved: _tangent(functions, size, moved),
        vectors=tuple(build_vectors(VECTORS, quantities)),
        motors=("M_L",),
        least=_least(device.machine),
        sampling=device.machine.objective.samples,
        genetic=device.machine.genetic_algorithm,
        documentation=_documentation(device),
    )


def _rebuild(kind: Callable[[MachineFile, Model], Parts], model: Model, machine: MachineFile) -> Machine:
    return build_machine(kind(machine, model))


def _least(machine: MachineFile) -> tuple[Measure, ...]:
    """Return the sum that a file minimises: range and spread of the support force, weighed."""
    objective = machine.objective
    spread: Kind = "variance" if objective.kind == "paper" else "std"
    return (
        Measure("range", FORCE, weight=objective.weight_range),
        Measure(spread, FORCE, weight=objective.weight_variance),
    )


def _documentation(device: Parts) -> Documentation:
    sidecar = device.sidecar
    variant = sidecar["name"].removeprefix("planting_")
    return Documentation(
        title=f"{sidecar['title']}; {' and '.join(device.functions.stage_titles)}",
        reference=sidecar["source"],
        equations=tuple(sidecar["equations"]),
        variant="" if variant == "exact" else variant,
    )


def _find_event_kinds(entries: Sequence[Mapping[str, Any]], flank: str) -> dict[int, Mapping[str, Any]]:
    """Return the events of a device by their places among its model's: of those of the flanks, a law's joints alone."""
    positions = tuple(sorted({entry["position"] for entry in entries if "position" in entry}))
    orders = {joint.position: joint.order for joint in flanks.joints(flank, positions)}
    return {
        index: {**entry, "order": orders[entry["position"]]} if "position" in entry else entry
        for index, entry in enumerate(entries)
        if "position" not in entry or entry["position"] in orders
    }


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
