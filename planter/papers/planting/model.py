"""The planting device: a machine in one of its models, with its design vector and its kernels.

`build_machine` describes it for the engine: gear stages and cam law composed in, two sides half a
cycle apart.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import casadi as ca
import numpy as np

from planter import paths
from planter.engine.curves import QuantityCurves
from planter.engine.machine import Documentation, Machine, Quantity, Value, build_vectors
from planter.engine.measures import Kind, Measure
from planter.engine.response import DesignPoint
from planter.errors import InputError
from planter.files import units
from planter.files.fields import read_range
from planter.files.record import format_table
from planter.gears.geometry import families, stage
from planter.gears.geometry.stage import StageCandidate
from planter.kernels import Array, Kernel, formulas
from planter.measured.sensor_curve import SensorSignal, measure_cycle
from planter.measured.sensor_view import add_carried_forces, build_sensor_view, list_carried_forces
from planter.papers.planting import functions
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.functions import Functions, Model

SIDES = (0.0, -np.pi)
"""Where the two sides stand [rad]."""
SPEED = "operation.speed_rpm"
FORCE = "F_support"
"""The vertical force on the support."""
CONTACTS = ("F_NP", "F_NQ", "F_E")
"""Forces that can only push: normal forces of the teeth at P and Q, of the cam on the roller."""
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


class Device:
    """A machine in one of its models.

    Designs `x` are (p,) arrays in SI; angles in rad, forces in N.

    `names` are those of the design vector, `data` (v,) the machine's own design, then its
    constants; `lower` and `upper` (p,) are its bounds [SI], `scale` (p,) is SI per shown unit.

    Raises GeometryError where the machine's own design, or a corner of its bounds, has no gears.
    """

    def __init__(self, machine: PlantingMachine | Machine, model: Model = "exact") -> None:
        """`machine` is the file of a planting device, or the machine that was loaded from one."""
        if isinstance(machine, Machine):
            machine = _find_file(machine)
        self.machine, self.model = machine, model
        self.formulas = formulas.load(f"planting_{model}")
        self.sidecar = self.formulas.sidecar
        pair = [
            families.check_family(stage.family, f"{machine.source}: stage{i}.family")
            for i, stage in enumerate((machine.stage1, machine.stage2), 1)
        ]
        parts = self._parts(pair)
        self.names: tuple[str, ...] = tuple(name for part in parts for name in part)
        machine.check_names(self.names)
        self.scale = np.array([units.unit_factor(name) for name in self.names])
        self._take(machine)
        ends = np.cumsum([len(part) for part in parts])
        first, second = (
            stage.build_stage(
                family,
                self._vectors[f"parameters{i}"],
                self._candidates(slice(ends[i - 1], ends[i])),
            )
            for i, family in enumerate(pair, 1)
        )
        self.stages = first, second
        self.functions = Functions(
            model, self.stages, functions.build_flank_function(machine.cam.flank)
        )

    def _take(self, machine: PlantingMachine) -> None:
        """Take the numbers of a machine in SI: design and bounds (p,), and the model's other inputs
        (c,).
        """
        self.machine, numbers = machine, machine.numbers()
        if (
            machine.measurement is not None
        ):  # names of quantities are checked before anything is computed
            models = [
                formulas.load(f"planting_{model}").sidecar["vectors"] for model in functions.MODELS
            ]
            by_key = {
                quantity.key: quantity
                for vectors in models
                for quantity in list_quantities(vectors)
            }
            quantities = tuple(by_key.values())
            forces = list_carried_forces(
                machine.measurement, self.sidecar.get("supports", {}), quantities, machine.source
            )
            build_sensor_view(machine.measurement, (*quantities, *forces), machine.source)
        design = self.scale * [machine.design[name] for name in self.names]
        constants = [
            numbers[e["shown"]] * units.unit_factor(e["shown"]) for e in self._vectors["machine"]
        ]
        self.data = np.concatenate([design, constants])
        self.lower, self.upper = (
            self.scale * np.array([machine.bounds[name] for name in self.names]).T
        )

    @property
    def design(self) -> Array:
        """The machine's own design (p,) [SI units]: the first of its `data`."""
        return self.data[: self.size]

    @property
    def constants(self) -> Array:
        """Inputs of the model other than the design (c,) [SI units]: the rest of `data`."""
        return self.data[self.size :]

    @property
    def _vectors(self) -> dict[str, Any]:
        vectors: dict[str, Any] = self.sidecar["vectors"]
        return vectors

    def _parts(self, families: list[str]) -> list[tuple[str, ...]]:
        """Names of the design parameters: those of the mounting, then those of each stage."""
        mounting = tuple(entry["shown"] for entry in self._vectors["mounting"])
        return [
            mounting,
            *(
                stage.list_design_names(f, self._vectors[f"parameters{i}"])
                for i, f in enumerate(families, 1)
            ),
        ]

    def _candidates(self, part: slice) -> list[StageCandidate]:
        """The machine's design, then the corners of its box: what a stage must be able to build."""
        source = self.machine.source
        sides = list(zip(self.lower[part], self.upper[part], strict=True))
        corners = [np.array(corner) for corner in itertools.product(*sides)]
        return [
            StageCandidate(self.design[part], lambda name: f"{source}: design.{name}"),
            *(
                StageCandidate(corner, lambda name: f"{source}: bounds.{name}")
                for corner in corners
            ),
        ]

    def like(self, machine: PlantingMachine) -> Device:
        """The device of another machine with the same families, cam law and names: what was built
        for this one serves.

        Raises GeometryError where the machine's own design has no gears; the corners of its bounds
        are not looked at.
        """
        device = Device.__new__(Device)
        vars(device).update(vars(self))
        device._take(machine)
        device.engine = replace(
            self.engine,
            document=machine,
            data=device.data,
            lower=device.lower,
            upper=device.upper,
            samples=machine.objective.samples,
            sampling=machine.objective.samples,
            subject=device,
        )
        device.force = self.force.with_machine(device.engine)
        for index, pair in enumerate(self.stages):
            parameters = device.of_stage(index, device.design)
            candidate = StageCandidate(parameters, lambda name: f"{machine.source}: design.{name}")
            pair.check_parameters(candidate)
            pair.check_radius(candidate)
        return device

    def __reduce__(self) -> tuple[Any, ...]:
        """Return machine, model and numbers for pickling: loading builds the device."""
        return _restore_device, (self.machine, self.model, self.data)

    def compile(self) -> None:
        """Run the force and its slopes in the fastest way that there is here."""
        self.force.curves.compile()

    @cached_property
    def engine(self) -> Machine:
        """The device as a machine of the engine."""
        return build_machine(self)

    @cached_property
    def force(self) -> QuantityCurves:
        """The vertical force on the support over a turn, the only curve, with derivatives and
        breakpoints.
        """
        return QuantityCurves(self.engine, [FORCE])

    @property
    def size(self) -> int:
        """Number of design parameters, p."""
        return len(self.names)

    @property
    def entries(self) -> list[Mapping[str, str]]:
        """Name, unit, meaning and source of each design parameter."""
        entries: list[Mapping[str, str]] = list(self._vectors["mounting"])
        for number, gear_stage in enumerate(self.stages, 1):
            entries += [
                *gear_stage.sidecar["parameters"][:-1],
                self._vectors[f"parameters{number}"]["known"]["-1"],
            ]
        return entries

    def x(self, **values: float) -> Array:
        """The machine's own design (p,) in SI with some values changed, by name and in the unit
        [that it ends in].

        Raises InputError for a name that is none of `names`, with the nearest of them.
        """
        for name in values:
            if name not in self.names:
                hint = paths.suggest_names(name, self.names)
                raise InputError(f"{name} is not a design parameter of {self.machine.name}: {hint}")
        design = self.design.copy()
        for name, value in values.items():
            index = self.names.index(name)
            design[index] = value * self.scale[index]
        return design

    def named(self, x: Array) -> dict[str, float]:
        """A design (p,) in SI as it is shown: values by name, each in the unit [that its name ends
        in].
        """
        return {name: float(value) for name, value in zip(self.names, x / self.scale, strict=True)}

    def show(self) -> Any:
        """Return a notebook widget that animates the device.

        Raises InputError if anywidget is missing.
        """
        from planter.report.animation import show_object

        return show_object(self)

    def _repr_html_(self) -> str:
        values, low, high = (self.named(x) for x in (self.design, self.lower, self.upper))
        rows = (
            (name, values[name], low[name], high[name], units.display_unit(name))
            for name in self.names
        )
        families = " and ".join(stage.family for stage in self.stages)
        title = f"{self.machine.name}, {self.model} model, stages {families}"
        return format_table(title, ("design", "value", "lower", "upper", "unit"), rows)

    @cached_property
    def hoisting_kernel(self) -> Kernel:
        """The prologue without derivatives: h of (x, c) in SI."""
        f = self.functions.prologue_function
        return Kernel(ca.Function("hoisting", f.mx_in(), [f(*f.mx_in())], ["x", "c"], ["h"]))

    def prologue(self, x: Array, c: Array | None = None) -> DesignPoint:
        """Return the invariants of a cycle for a design x (p,) [SI] with their derivatives, which
        all angles share.

        `c` are data of a machine that differs from the device's own in nothing else.
        """
        return self.force.response.at_data(np.concatenate([x, self.constants if c is None else c]))

    @cached_property
    def cycle_kernel(self) -> Kernel:
        """Quantities of side 1, of side 2 and of both at carrier angles, from (phi, x, c, h) in
        SI.
        """
        names, outputs = ["phi", "x", "c", "h"], ["side1", "side2", "totals"]
        f = ca.Function("cycle", self.functions.inputs, list(self.functions.both), names, outputs)
        return Kernel(f, lanes=["phi"])

    def cycle(self, at: DesignPoint, phi: Array) -> dict[str, Array]:
        """`side1`, `side2` and `totals` at carrier angles phi (n,) [rad]: a row (n,) for each
        quantity [SI].
        """
        return self.cycle_kernel(phi=phi, x=at.d[: self.size], c=at.d[self.size :], h=at.h)

    def columns(self, x: Array, phi: Array) -> dict[str, Array]:
        """Return the angle, side 1, side 2 with `_2` in the keys, and totals of a design x (p,) [SI]
        at carrier angles phi (n,) [rad], as columns (n,) [in the units of the keys].
        """
        outputs, vectors = self.cycle(self.prologue(x), phi), self._vectors
        columns = {"phi_deg": np.degrees(phi)}
        for output, vector in (("side1", "side"), ("side2", "side"), ("totals", "totals")):
            for key, row in zip(list_keys(vectors[vector]), outputs[output], strict=True):
                name = name_second_side(key) if output == "side2" else key
                columns[name] = row / units.unit_factor(key)
        return columns

    def measure(self, x: Array, columns: Mapping[str, Array]) -> SensorSignal | None:
        """Return what the sensor of the file sees over columns of a turn of a design x (p,) [SI],
        None if the file states no sensor.
        """
        machine = self.engine.with_data(self.engine.build_data(x))
        return measure_cycle(machine, np.radians(columns["phi_deg"]), columns)

    @property
    def weight(self) -> float:
        """Weight of everything that the frame carries [N]."""
        return self.formulas.at("weight", machine=self.constants)["weight"]

    @property
    def distance_places(self) -> list[int]:
        """The places of the centre distances of both stages among the invariants of a cycle."""
        return [0, 1 + self.stages[0].terms]

    def centre_distances(self, x: Array) -> Array:
        """Return the centre distances (2,) of both stages [m] of a design x (p,) [SI]."""
        return self.prologue(x).h[self.distance_places]

    def side(self, x: Array, phi: Array) -> dict[str, Array]:
        """Quantities (n,) of side 1 by their names [SI], of a design x (p,) at carrier angles phi
        (n,) [rad].
        """
        names = self.formulas.entries("side")
        return dict(zip(names, self.cycle(self.prologue(x), phi)["side1"], strict=True))

    def of_stage(self, stage: int, x: Array) -> Array:
        """The parameters (k,) of a gear stage, 0 or 1, in a design x (p,) [SI]."""
        sizes = [len(self._vectors["mounting"]), *(len(part.names) for part in self.stages)]
        return np.split(x, np.cumsum(sizes))[1 + stage]

    def support(self, at: DesignPoint, phi: Array) -> Array:
        """Vertical support force [N], (n,), at carrier angles phi (n,) [rad]."""
        return self.force.curves.values(at, phi)[0]

    def support_slopes(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Vertical support force (n,) [N] and its Jacobian in (phi, x), (n, 1 + p) [N/rad, N per SI
        unit of x].
        """
        values, slopes = self.force.curves.slopes(at, phi)
        return values[0], slopes[0]


def _restore_device(machine: PlantingMachine, model: Model, data: Array) -> Device:
    """Return a device that was pickled."""
    device = Device(machine, model)
    device.data = data
    return device


def build_machine(device: Device) -> Machine:
    """Return a device as a machine: its values are the design parameters, then the numbers of the
    file.
    """
    functions, vectors = device.functions, device.sidecar["vectors"]
    size = len(device.names)
    design = [
        Value(entry["name"], entry["unit"], entry["meaning"], f"design.{name}", entry["source"])
        for name, entry in zip(device.names, device.entries, strict=True)
    ]
    data = [
        Value(
            e["name"],
            e["unit"],
            e["meaning"],
            e["shown"],
            e["source"],
            read_range(PlantingMachine, e["shown"]),
        )
        for e in vectors["machine"]
    ]
    values = (*design, *data)
    kinds = _find_event_kinds(device.sidecar["events"], device.machine.cam.flank)
    d, q = ca.SX.sym("d", len(values)), ca.SX.sym("q", 0)

    def compose(name: str, output: ca.SX) -> ca.Function:
        (graph,) = ca.substitute([output], [functions.x, functions.c], [d[:size], d[size:]])
        return ca.Function(
            name, [functions.phi, d, functions.h, q], [graph], ["phi", "d", "h", "q"], ["y"]
        )

    lane = compose("lane", functions.side(functions.phi))
    first, second = (ca.SX.sym(side, lane.numel_out(0)) for side in ("one", "two"))
    totals = ca.Function("totals", [first, second, d], [functions.frame(first, second, d[size:])])
    both = ca.MX.sym("d", len(values))
    prologue = ca.Function(
        "prologue", [both], [functions.prologue_function(both[:size], both[size:])], ["d"], ["h"]
    )
    quantities = list_quantities(vectors)
    machine = Machine(
        document=device.machine,
        build=partial(_rebuild_machine, type(device), device.model),
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
        objective=device.machine.objective_terms or build_measures(device.machine),
        sampling=device.machine.objective.samples,
        limits=device.machine.measure_limits,
        genetic=device.machine.genetic_algorithm,
        subject=device,
        documentation=_documentation(device),
    )
    return add_carried_forces(
        machine, device.machine.measurement, device.sidecar.get("supports", {})
    )


def list_keys(entries: Sequence[Mapping[str, str]]) -> list[str]:
    """Return the keys of a vector's entries in tables, each ending in the unit that is shown."""
    return [e.get("shown") or units.display_key(e["name"], e["unit"]) for e in entries]


def name_second_side(key: str) -> str:
    """Return the key of a quantity on side 2.

    >>> name_second_side("F_B1x_N"), name_second_side("ratio")
    ('F_B1x_2_N', 'ratio_2')
    """
    suffix = units.unit_suffix(key)
    return f"{key.removesuffix(suffix)}_2{suffix}"


def list_quantities(vectors: Mapping[str, Any]) -> tuple[Quantity, ...]:
    """Return the quantities of a side, then those of both sides together."""
    return tuple(
        Quantity(
            e["name"],
            e["unit"],
            e["meaning"],
            key,
            total,
            is_push=e["name"] in CONTACTS,
            source=e["source"],
        )
        for vector, total in (("side", False), ("totals", True))
        for key, e in zip(list_keys(vectors[vector]), vectors[vector], strict=True)
    )


def _rebuild_machine(kind: type[Device], model: Model, machine: PlantingMachine) -> Machine:
    return build_machine(kind(machine, model))


def build_measures(machine: PlantingMachine) -> tuple[Measure, Measure]:
    """Return range and scatter of the support force as measures, weighted as in the machine
    file.
    """
    objective = machine.objective
    scatter: Kind = "variance" if objective.kind == "paper" else "std"
    return (
        Measure("range", FORCE, weight=objective.weight_range),
        Measure(scatter, FORCE, weight=objective.weight_variance),
    )


def _documentation(device: Device) -> Documentation:
    sidecar = device.sidecar
    variant = sidecar["name"].removeprefix("planting_")
    return Documentation(
        title=f"{sidecar['title']}; {' and '.join(device.functions.stage_titles)}",
        reference=sidecar["source"],
        equations=tuple(sidecar["equations"]),
        variant="" if variant == "exact" else variant,
    )


def _find_event_kinds(
    entries: Sequence[Mapping[str, Any]], flank: str
) -> dict[int, Mapping[str, Any]]:
    """Return the events of a device by their places among its model's: of those of the flanks, a
    law's joints alone.
    """
    positions = tuple(sorted({entry["position"] for entry in entries if "position" in entry}))
    orders = {
        joint.position: joint.order for joint in functions.find_flank_breakpoints(flank, positions)
    }
    return {
        index: {**entry, "order": orders[entry["position"]]} if "position" in entry else entry
        for index, entry in enumerate(entries)
        if "position" not in entry or entry["position"] in orders
    }


def _tangent(functions: Functions, size: int, moved: tuple[int, ...]) -> ca.Function:
    """Return (d) -> h, dh: the prologue and its sparse Jacobian in the moved values, stage by
    stage.
    """
    count = size + functions.c.numel()
    d = ca.MX.sym("d", count)
    h, along_design = functions.tangent_function(d[:size], d[size:])
    along_data = ca.MX(h.numel(), count - size)
    if any(index >= size for index in moved):
        along_data = functions.data_tangent_function(d[:size], d[size:], h)
    dh = ca.horzcat(along_design, along_data)[:, list(moved)]
    return ca.Function("tangent", [d], [h, dh], ["d"], ["h", "dh"])


def _find_file(machine: Machine) -> PlantingMachine:
    """Return the file of a planting device. Raises InputError for another machine."""
    if not isinstance(machine.document, PlantingMachine):
        raise InputError(f"{machine.source}: {machine.name} is no planting device")
    return machine.document
