"""Planting devices to be shown and changed by a user (`planter.report.subject`)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.kernels import Array
from planter.measured.section import SECTION
from planter.measured.sensor_view import describe_sensor_inputs, find_sensor_view
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.requirements_section import KINDS, LIMIT_WORDS
from planter.report.labels import load_names
from planter.report.options import MotionFormat
from planter.report.subject import (
    STARTS,
    Control,
    DetailTable,
    Export,
    Reading,
    RequiredOption,
    RequirementCheck,
    Sought,
    Values,
    change_numbers,
    list_controls,
    write_numbers,
)

if TYPE_CHECKING:
    from planter.engine.curves import QuantityCurves
    from planter.papers.planting.requirement_rows import RequirementRows
    from planter.papers.planting.results import Statistics, TrueExtremes
    from planter.report.scene import Scene
    from planter.report.subject import Portable

EXPORTS = (
    Export("report", "page, figures and tables of the cycle", ("simulate",), modelled=True),
    Export(
        "optimum", "report comparing this design with its optimum", ("optimise",), modelled=True
    ),
    Export(
        "gears",
        "teeth of both stages (DXF, SVG, flanks as CSV), their mesh solved and checked",
        ("gears",),
    ),
    Export(
        "cam",
        "the cam's contour (DXF) and what it bears",
        ("cam",),
        asks=(RequiredOption("--roller-mm", "radius of the roller / mm", 6.0),),
    ),
    Export(
        "drive",
        "the carrier on a motor",
        ("simulate",),
        ("--motor",),
        asks=(
            RequiredOption("--stall-Nm", "torque at rest / N m", 6.0),
            RequiredOption("--idle-rpm", "speed without torque / rpm", 42.0),
            RequiredOption("--flywheel-kgm2", "flywheel / kg m\N{SUPERSCRIPT TWO}", 0.1),
        ),
    ),
    *(
        Export(
            f"motion-{form}",
            f"motions and forces over time {form.purpose}",
            ("export", "motion"),
            ("--format", form.value),
            modelled=True,
        )
        for form in MotionFormat
    ),
    Export("c", "motions, forces, objective and gradient in C99", ("export", "c"), modelled=True),
    Export(
        "unit",
        "unit for co-simulation (FMI 2.0)",
        ("export", "fmu"),
        modelled=True,
        file="machine.fmu",
    ),
)


POINTS = "requirements.points_mm"
COUNT = 6
"""Points that are put on a path."""
TUBE_MM = 10.0
"""Radius of the tube about each."""
REACH_MM = 80.0
"""How far a point can be drawn to either side."""
TUBES_MM = (0.5, 50.0)


def list_point_handles(machine: PlantingMachine) -> list[tuple[str, str]]:
    """Paths of the numbers x and y of every point."""
    return [(f"{POINTS}[{k}][0]", f"{POINTS}[{k}][1]") for k in range(len(_list_points(machine)))]


def find_point_bounds(machine: PlantingMachine) -> dict[str, tuple[float, float]]:
    """Return the ranges of the points' numbers by path."""
    bounds = {}
    for k, (x, y, tube) in enumerate(_list_points(machine)):
        bounds[f"{POINTS}[{k}][0]"] = (x - REACH_MM, x + REACH_MM)
        bounds[f"{POINTS}[{k}][1]"] = (y - REACH_MM, y + REACH_MM)
        bounds[f"{POINTS}[{k}][2]"] = (min(TUBES_MM[0], tube), max(TUBES_MM[1], tube))
    return bounds


def add_path_points(device: Device, x: Array, machine: PlantingMachine) -> PlantingMachine:
    """A machine whose tip must pass points on the path of a design x (p,), in SI."""
    turn = device.columns(x, device.engine.list_angles(COUNT))
    places = np.round(np.column_stack([turn["tip_machine_x_mm"], turn["tip_y_mm"]]), 3)
    table = machine.table()
    points = [[*place, TUBE_MM] for place in places.tolist()]
    required = {"tube_excess_max_mm": 0.0, **(table.get("requirements") or {}), "points_mm": points}
    return PlantingMachine.read({**table, "requirements": required}, machine.source)


def _list_points(machine: PlantingMachine) -> list[tuple[float, float, float]]:
    return [] if machine.requirements is None else machine.requirements.points_mm or []


DESIGN = "design."
BESIDE = (
    "operation.speed_rpm",
    "operation.forward_speed_m_s",
    "contact.tooth_friction_angle_deg",
    "contact.cam_friction_angle_deg",
    "mass.planet_kg",
    "mass.middle_kg",
    "mass.half_C2_kg",
    "cam.opening_deg",
    "spring.preload_N",
    "spring.rate_N_m",
)
"""Numbers beside the design that a hand is offered."""


NAMES = load_names(__package__)
TIMES = "\N{MULTIPLICATION SIGN}"
LOCKED = 1e-9
"""Room that a locked number has to either side, in parts of its bounds: a search needs some."""


def _label(name: str) -> str:
    """Return the name of a requirement on a page."""
    entry = NAMES.find(name)
    return entry.name if entry else ""


LOADS = {"M_L": ("largest motor torque", "N m"), "F_E": ("largest force of the cam", "N")}
"""Quantities whose largest size is a reading, with its name and unit."""
SIZES = ("centre distance of stage 1", "centre distance of stage 2")


def _list_force_results(
    objective: float, force: Statistics | TrueExtremes
) -> list[tuple[str, str, float]]:
    """Return name, unit and value of the results of the support force."""
    return [
        ("objective (31)", "", objective),
        ("range of the support force", "N", force.range_N),
        ("largest support force", "N", force.max_N),
        ("least support force", "N", force.min_N),
    ]


class PlantingView:
    """A planting device; the design first, then some of what it is built of."""

    models: Sequence[str] = ("exact", "printed")
    exports: Sequence[Export] = EXPORTS
    search: Sequence[str] = ("optimise",)
    starts = STARTS

    def __init__(self, machine: PlantingMachine) -> None:
        self.machine, self.name = machine, machine.name
        self._devices: dict[str, tuple[Device, Values]] = {}
        self._measures: RequirementRows | None = None
        self._curves: dict[tuple[str, str], QuantityCurves] = {}

    @cached_property
    def controls(self) -> Sequence[Control]:
        """The design within its bounds, then numbers of the machine."""
        device = self._device("exact", {})
        entries = [entry for entry in device.sidecar["vectors"]["machine"] if "shown" in entry]
        meanings = {entry["shown"]: entry["meaning"] for entry in entries}
        names = zip(device.names, device.entries, strict=True)
        meanings |= {f"{DESIGN}{name}": entry["meaning"] for name, entry in names}
        bounds = {f"{DESIGN}{name}": pair for name, pair in self.machine.bounds.items()}
        paths = [f"{DESIGN}{name}" for name in device.names]
        points = find_point_bounds(self.machine)
        sensor = describe_sensor_inputs(find_sensor_view(device.force.machine))
        return list_controls(
            self.machine,
            [*paths, *BESIDE, *points, *sensor],
            meanings | sensor,
            bounds | points,
            NAMES,
        )

    @property
    def rigid(self) -> PlantingView:
        """The device without its sensor, for pages without a server."""
        return PlantingView(self.machine.model_copy(update={SECTION: None}))

    @cached_property
    def handles(self) -> Sequence[tuple[str, str]]:
        """Points that the tip's path must pass, which every search keeps."""
        return list_point_handles(self.machine)

    @property
    def wishes(self) -> bool:
        """Requirements are those of a device that travels."""
        return not self.handles and self.machine.operation.forward_speed_m_s != 0

    def wished(self, values: Values) -> str:
        """Its file with points on its own path, each with a tube that the tip's path must pass."""
        return write_numbers(
            self.machine,
            add_path_points(*self._at(values, "exact"), change_numbers(self.machine, values)),
        )

    def describe_goal(self) -> str:
        """Return the sum of the file, or the weighted one of range and scatter of the support
        force.
        """
        if self.machine.objective_terms:
            from planter.mechanism.optimisation import StatedGoal

            return StatedGoal.read(self._device("exact", {}).force.machine).describe()
        weights = self.machine.objective
        scatter = "variance [N²]" if weights.kind == "paper" else "standard deviation [N]"
        parts = (
            f"{weights.weight_range:g} {TIMES} range [N] + {weights.weight_variance:g} "
            f"{TIMES} {scatter}"
        )
        return f"{parts} of the vertical support force, objective (31)"

    @property
    def words(self) -> Mapping[str, str]:
        """Names of the requirements, and what their limits are."""
        limits = {
            kind.key(side): f"its {LIMIT_WORDS[side]} value"
            for kind in KINDS
            for side in kind.sides
        }
        return limits | {kind.name: _label(kind.name) or kind.meaning for kind in KINDS}

    def sought(self, answer: Mapping[str, Any]) -> Sought:
        """The design that was found."""
        return Sought.from_answer(answer, "design")

    def scenes(self, values: Values, model: str) -> Sequence[Scene]:
        """Both sides over a turn, the path of the machine's own tip beneath."""
        from planter.papers.planting.report.scene import build_scene

        device, x = self._at(values, model)
        before = None if (device.design == x).all() else device.design
        still_scene = build_scene(device, x, before, toothed=False)
        return [replace(still_scene, later=partial(build_scene, device, x, before))]

    def readings(self, values: Values, model: str) -> Sequence[Reading]:
        """Objective, support force, motor torque, centre distances; all of the samples of the
        file.
        """
        from planter.papers.planting.browser_programs import name_over_samples
        from planter.papers.planting.results import Statistics

        device, x = self._at(values, model)
        turn = device.columns(x, device.engine.list_angles())
        over = partial(name_over_samples, samples=device.machine.objective.samples)
        force = Statistics.of_samples(turn["support_N"])
        objective = device.machine.objective.value(force.range_N, force.variance_N2)
        forces = [
            Reading(over(name), unit, value)
            for name, unit, value in _list_force_results(objective, force)
        ]
        sizes = float(abs(turn["M_L_Nm"]).max()), float(turn["F_E_N"].max())
        loads = [
            Reading(over(name), unit, size)
            for (name, unit), size in zip(LOADS.values(), sizes, strict=True)
        ]
        return self._list_readings(device, x, forces, loads)

    def refined(self, values: Values, model: str, quickly: bool = False) -> Sequence[Reading]:
        """Return the readings by true extremes; if `quickly`, those of torque and cam of samples."""
        from planter.engine.solvers.curve_sum import CurveSide
        from planter.engine.solvers.cycle_panels import CyclePanels
        from planter.papers.planting.objective import evaluate_true_extremes

        device, x = self._at(values, model)
        force = evaluate_true_extremes(device, x)
        forces = [Reading(*result) for result in _list_force_results(force.objective, force)]
        if quickly:
            sampled = self.readings(values, model)
            first = len(sampled) - len(SIZES) - len(LOADS)
            return self._list_readings(device, x, forces, sampled[first : first + len(LOADS)])
        loads = []
        for load, (name, unit) in LOADS.items():
            panels = CyclePanels(self._load_curves(device, load), x)
            size = max(panels.top(CurveSide(0, 0, sign)) for sign in (1, -1))
            loads.append(Reading(name, unit, size))
        return self._list_readings(device, x, forces, loads)

    def _load_curves(self, device: Device, load: str) -> QuantityCurves:
        """Return the curve of a load of a device, with all functions of the latest one like it."""
        from planter.engine.curves import QuantityCurves

        key = device.model, load
        latest, machine = self._curves.get(key), device.force.machine
        curves = (
            QuantityCurves(machine, (load,)) if latest is None else latest.with_machine(machine)
        )
        self._curves[key] = curves
        return curves

    def _list_readings(
        self, device: Device, x: Array, forces: Sequence[Reading], loads: Sequence[Reading]
    ) -> list[Reading]:
        from planter.measured.sensor_presentation import list_signal_readings

        signal = device.measure(x, device.columns(x, device.engine.list_angles()))
        distances = device.centre_distances(x) * 1e3
        return [
            *list_signal_readings(signal),
            *forces,
            Reading("weight", "N", device.weight),
            *loads,
            *(
                Reading(name, "mm", float(distance))
                for name, distance in zip(SIZES, distances, strict=True)
            ),
        ]

    def checks(self, values: Values, model: str) -> Sequence[RequirementCheck]:
        """The file's requirements."""
        from planter.mechanism.optimisation import evaluate_limits, list_limit_checks
        from planter.papers.planting.requirement_rows import RequirementRows
        from planter.papers.planting.requirements import evaluate_requirements

        device, x = self._at(values, "exact")
        machine = device.force.machine
        results = (
            evaluate_limits(machine.with_data(machine.build_data(x))) if machine.limits else []
        )
        checks = list_limit_checks(machine, results)
        if not device.machine.limits_motion:
            return checks
        if self._measures is None or self._measures.device is not device:
            self._measures = RequirementRows(device)
        return checks + [
            RequirementCheck(
                r.meaning,
                r.unit,
                r.value,
                r.margin,
                r.verdict != "fail",
                r.lower,
                r.upper,
                _label(r.name),
                r.phi_deg,
            )
            for r in evaluate_requirements(self._measures, x)
        ]

    def details(self, values: Values, model: str) -> Sequence[DetailTable]:
        """The designer's summary: torque, forces, gears with their limits, shocks."""
        from planter.papers.planting.design_results import describe_design, list_design_tables
        from planter.papers.planting.design_summary import summarise_design

        record = summarise_design(*self._at(values, model))
        notes = [[sentence] for sentence in describe_design(record)]
        tables = (
            DetailTable(table.caption, table.head, table.rows)
            for table in list_design_tables(record)
        )
        return [*tables, DetailTable("Notes", ("",), notes)]

    def text(self, values: Values) -> str:
        """The machine file with these numbers."""
        return write_numbers(self.machine, change_numbers(self.machine, values))

    @property
    def lockable(self) -> Sequence[str]:
        """The design."""
        return [f"{DESIGN}{name}" for name in self.machine.bounds]

    def with_locks(self, values: Values, locked: Collection[str]) -> str:
        """The machine file with these numbers, whose bounds leave a locked one no room."""
        machine = change_numbers(self.machine, values)
        bounds = dict(machine.bounds)
        for path in locked:
            name = path.removeprefix(DESIGN)
            value, (lower, upper) = machine.design[name], bounds[name]
            room = LOCKED * (upper - lower)
            bounds[name] = (value - room, value + room)
        return write_numbers(self.machine, machine.model_copy(update={"bounds": bounds}))

    def portable(self, model: str) -> Portable:
        """Return the data from which a page computes the device by itself."""
        from planter.papers.planting.browser_programs import build_portable
        from planter.papers.planting.report.scene import CORNERS, MOMENTS

        return build_portable(self._device(model, self.machine.numbers()), MOMENTS, CORNERS + 1)

    def handed(self, values: Values) -> str:
        """The machine file with these numbers."""
        return self.text(values)

    def _at(self, values: Values, model: str) -> tuple[Device, Array]:
        """The device with these numbers but for the design, which is (p,) [SI]."""
        device = self._device(
            model, {path: value for path, value in values.items() if not path.startswith(DESIGN)}
        )
        design = {
            path.removeprefix(DESIGN): value
            for path, value in values.items()
            if path.startswith(DESIGN)
        }
        return device, device.x(**design)

    def _device(self, model: str, besides: Values) -> Device:
        """The latest device of a model, if it is the same; else one like it."""
        from planter.papers.planting.model import Device

        if model not in self._devices:
            device = Device(self.machine, "printed" if model == "printed" else "exact")
            self._devices[model] = device, self.machine.numbers()
        device, numbers = self._devices[model]
        if any(numbers[path] != value for path, value in besides.items()):
            machine = change_numbers(self.machine, besides)
            device = device.like(machine)
            self._devices[model] = device, machine.numbers()
        return device


def open_view(source: str, changes: Values) -> PlantingView:
    """Return the machine in a file, or the built-in one of that name."""
    from planter.papers.planting.file import load

    return PlantingView(load(source, changes))


def build_scene(thing: object) -> Scene | None:
    """Return the motion of a device with its own design, None of anything else."""
    from planter.papers.planting.model import Device
    from planter.papers.planting.report.scene import build_scene

    return build_scene(thing, thing.design) if isinstance(thing, Device) else None
