"""User-defined mechanisms as machines of the engine."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import casadi as ca
import numpy as np

from planter.engine.loops import KinematicLoops
from planter.engine.machine import (
    PLACES,
    Description,
    Documentation,
    FreeMotion,
    FunctionSignature,
    Machine,
    MachineStage,
    Quantity,
    Role,
    Value,
    Vector,
    build_vectors,
)
from planter.engine.measures import TIME
from planter.errors import InputError
from planter.files import units
from planter.kernels.formulas import HOISTED, Formulas
from planter.measured.sensor_view import add_carried_forces, find_sensor_view
from planter.mechanism import file
from planter.mechanism.file import MechanismFile
from planter.text_files import read_toml

if TYPE_CHECKING:
    from planter.mechanism.motion_response import Motions

ROLES: dict[str, Role] = {"law_": "law", "pivot_": "pivot", "states_": "states"}
"""Roles of quantities by the beginnings of their names."""

FURTHER = (PLACES, "followers", "meshes", "elements")
"""Further generated functions along the angle."""
LOSS = "power lost to friction"
"""Beginning of the meanings of derived powers of friction."""


def takes(source: str) -> bool:
    """Return whether a source is the file of a mechanism that an angle drives, or its name."""
    try:
        return "functions" in read_toml(file.find_file(source))
    except InputError:
        return False


def find_mechanism(source: str, changes: Mapping[str, float]) -> MechanismFile | None:
    """Return the file of a mechanism, driven or free; None for any other machine.

    Raises InputError as the file does.
    """
    return file.load(source, changes) if takes(source) else None


def load(source: str, changes: Mapping[str, float]) -> Machine:
    """Return the machine of a mechanism's file, driven or free. Raises InputError as the file does."""
    return build_machine(file.load(source, changes))


def describe(source: str, changes: Mapping[str, float]) -> Description:
    """Return the description of a mechanism, driven or not. Raises InputError as its file does."""
    mechanism = file.load(source, changes)
    formulas = mechanism.model
    sidecar, values = formulas.sidecar, _values(formulas)
    return Description(
        name=mechanism.name,
        title=sidecar["title"],
        source=sidecar["source"],
        assumptions=tuple(sidecar["assumptions"]),
        values=values,
        data=mechanism.data(),
        bounds={
            value.path: mechanism.bounds[value.key]
            for value in values
            if value.key in mechanism.bounds
        },
        origins=mechanism.number_origins(),
        quantities=list_quantities(formulas),
        functions=tuple(
            FunctionSignature(
                name,
                tuple(entry["inputs"]),
                formulas.function(name).numel_out(0),
                entry["operations"],
            )
            for name, entry in sidecar["functions"].items()
        ),
        vectors=_vectors(formulas) if mechanism.is_driven else (),
    )


def build_machine(mechanism: MechanismFile) -> Machine:
    """Return the machine of a mechanism's file, driven or free.

    Raises InputError for its sensor.
    """
    if not mechanism.is_driven:
        return build_free_machine(mechanism)
    formulas = mechanism.model
    sidecar = formulas.sidecar
    stages = _stages(formulas)
    names = [value.name for value in _values(formulas)]
    machine = Machine(
        **_describe_design(mechanism),
        build=build_machine,
        quantities=list_quantities(formulas),
        prologue=stages.prologue,
        lane=stages.lane,
        speed=names.index(sidecar["speed"]),
        loops=stages.loops,
        events=stages.events,
        event_kinds=tuple(sidecar.get("events", [])),
        vectors=_vectors(formulas),
        motors=_motors(formulas),
        acceleration=names.index(sidecar["acceleration"]) if "acceleration" in sidecar else None,
        losses=tuple(
            q.name
            for q in list_quantities(formulas)
            if q.role == "result" and q.meaning.startswith(LOSS)
        ),
        stages=stages.further,
        angle=formulas.function("lane").name_in(0),
    )
    machine = add_carried_forces(machine, mechanism.measurement, sidecar.get("supports", {}))
    find_sensor_view(machine)  # raises InputError if [measurement] names what the machine lacks
    return machine


def _describe_design(mechanism: MechanismFile) -> dict[str, Any]:
    """Return what a machine has of its file alone: values, bounds, objective, limits, texts."""
    sidecar, values = mechanism.model.sidecar, _values(mechanism.model)
    keys = [value.key for value in values]
    moved = tuple(keys.index(key) for key in mechanism.bounds)
    factors = np.array([values[index].factor for index in moved])
    ends = np.array(list(mechanism.bounds.values()), dtype=float).reshape(-1, 2) * factors[:, None]
    return {
        "document": mechanism,
        "assumptions": tuple(sidecar["assumptions"]),
        "values": values,
        "data": mechanism.data(),
        "moved": moved,
        "lower": ends[:, 0],
        "upper": ends[:, 1],
        "samples": mechanism.turn.samples,
        "objective": mechanism.objective_terms,
        "limits": mechanism.measure_limits,
        "sampling": mechanism.objective.samples if mechanism.objective else "refined",
        "genetic": mechanism.genetic_algorithm,
        "documentation": Documentation(
            sidecar["title"], sidecar["source"], tuple(sidecar["equations"])
        ),
    }


def build_free_machine(
    mechanism: MechanismFile, span: float = 1.0, motions: Motions | None = None
) -> Machine:
    """Return the machine of a mechanism that moves freely, whose turn is the time from 0 to `span`
    [s].

    `motions` over another span of the same file spare building its functions anew. Its states q are
    coordinates and rates, then the signs of normal forces that friction follows from. Actions that
    are statically indeterminate are no quantities of it.
    """
    from planter.mechanism import motion_response  # with integrators

    motions = motion_response.Motions(mechanism, span) if motions is None else motions.over(span)
    model, turn = motions.model, 2 * np.pi
    entries = {q.name: q for q in list_quantities(mechanism.model)}
    determined = {v.name: row for row, v in enumerate(model.outputs) if v.name in entries}
    names = [*motions.dynamics.names, *determined]
    phi, d, h = ca.SX.sym("phi"), ca.SX.sym("d", len(motions.dynamics.data)), ca.SX.sym("h", 0)
    count = len(motions.dynamics.names)
    q = ca.SX.sym("q", count + len(model.start_signs))
    time = phi * span / turn
    outputs = model.y(time, q[:count], *motions.split(d), q[count:])
    inputs, labels = [phi, d, h, q], ["phi", "d", "h", "q"]
    lane = ca.vertcat(q[:count], outputs[list(determined.values())], time)
    events = outputs[len(model.outputs) - model.events :]
    return Machine(
        **_describe_design(mechanism),
        build=partial(build_free_machine, span=span),
        quantities=(
            *(entries[name] for name in names),
            Quantity(TIME, "s", "time", units.display_key(TIME, "s")),
        ),
        prologue=ca.Function("prologue", [d], [ca.SX.zeros(0, 1)], ["d"], ["y"]),
        lane=ca.Function("lane", inputs, [ca.densify(lane)], labels, ["y"]),
        speed=-1,
        events=ca.Function("events", inputs, [ca.densify(events)], labels, ["y"])
        if model.events
        else None,
        event_kinds=tuple({"name": name, "order": 0} for name in motions.dynamics.event_names),
        motion=FreeMotion(
            span,
            motions,
            motion_response.MotionResponse,
            partial(build_free_machine, mechanism, motions=motions),
        ),
        states=q.numel(),
    )


class _Stages(NamedTuple):
    """The functions of a mechanism of the inputs (phi, d, h, q) of the engine."""

    prologue: ca.Function
    lane: ca.Function
    loops: KinematicLoops | None
    events: ca.Function | None
    further: Mapping[str, MachineStage]


@cache
def _stages(formulas: Formulas) -> _Stages:
    """Return the functions of a generated model: composed once, so that they are compiled once."""
    lane = formulas.function("lane")
    sizes = {name: lane.size1_in(name) for name in lane.name_in()}
    phi, d = ca.SX.sym("phi"), ca.SX.sym("d", len(formulas.entries("data")))
    h, q = ca.SX.sym("h", sizes.get(HOISTED, 0)), ca.SX.sym("q", sizes.get("loops", 0))
    symbols = {lane.name_in(0): phi, "data": d, HOISTED: h, "loops": q}

    def compose(stage: str, inputs: dict[str, ca.SX]) -> ca.Function:
        function = formulas.function(stage)
        output = ca.densify(function(*(symbols[name] for name in function.name_in())))
        return ca.Function(stage, list(inputs.values()), [output], list(inputs), ["y"])

    inputs = {"phi": phi, "d": d, "h": h, "q": q}
    none = ca.Function("prologue", [d], [ca.SX.zeros(0, 1)], ["d"], ["y"])
    loops = None
    if "closure" in formulas.sidecar["functions"]:
        loops = KinematicLoops(
            gaps=compose("closure", {"phi": phi, "d": d, "q": q}),
            assembly=compose("assembly", {"d": d}),
            names=tuple(formulas.outputs("assembly")),
            units=tuple(entry["unit"] for entry in formulas.sidecar["vectors"]["start"]),
            gap_names=tuple(formulas.outputs("closure")),
        )
    return _Stages(
        prologue=compose("prologue", {"d": d}) if HOISTED in sizes else none,
        lane=compose("lane", inputs),
        loops=loops,
        events=compose("events", inputs) if "events" in formulas.sidecar["functions"] else None,
        further={
            name: MachineStage(compose(name, inputs), _list_quantities(formulas, (name,)))
            for name in FURTHER
            if name in formulas.sidecar["functions"]
        },
    )


@cache
def _values(formulas: Formulas) -> tuple[Value, ...]:
    entries = formulas.sidecar["vectors"]["data"]
    return tuple(
        Value(
            e["name"],
            e["unit"],
            e["meaning"],
            e["shown"],
            e["source"],
            (0.0 if e["unit"] == "kg" else None, None),
        )
        for e in entries
    )


def list_quantities(formulas: Formulas) -> tuple[Quantity, ...]:
    """Return the quantities of a mechanism's states and outputs."""
    return _list_quantities(formulas, ("start_state", "outputs"))


@cache
def _list_quantities(formulas: Formulas, vectors: tuple[str, ...]) -> tuple[Quantity, ...]:
    axes, pushing = formulas.sidecar.get("axes", {}), formulas.sidecar.get("pushing", [])
    return tuple(
        Quantity(
            e["name"],
            e["unit"],
            e["meaning"],
            units.display_key(e["name"], e["unit"]),
            role=next(
                (role for start, role in ROLES.items() if e["name"].startswith(start)), "result"
            ),
            axes=axes.get(e["name"]),
            is_push=e["name"] in pushing,
            source=e["source"],
        )
        for part in vectors
        for e in formulas.sidecar["vectors"].get(part, ())
    )


@cache
def _vectors(formulas: Formulas) -> tuple[Vector, ...]:
    """Return the results that end in x, y and perhaps z, as one vector each: those of one unit and
    one frame.
    """
    results = {q.name: q for q in list_quantities(formulas) if q.role == "result"}
    parts = {}
    for name, first in results.items():
        stem = name.removesuffix("x")
        alike = [results[stem + axis] for axis in "xyz" if stem + axis in results]
        components = tuple(q.name for q in alike if (q.unit, q.axes) == (first.unit, first.axes))
        label = stem.rstrip("_")
        if stem != name and len(components) > 1 and label and label not in results:
            parts[label] = components
    return tuple(build_vectors(parts, list(results.values())))


@cache
def _motors(formulas: Formulas) -> tuple[str, ...]:
    """Return the names of the torques that have a power."""
    units_of = {q.name: q.unit for q in list_quantities(formulas)}
    return tuple(
        name
        for name, unit in units_of.items()
        if unit == "N m" and units_of.get(f"P_{name}") == "W"
    )
