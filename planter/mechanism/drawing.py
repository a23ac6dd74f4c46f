"""Drawings of a mechanism: curves of its quantities, its moving scene, and the program that
computes it in a page.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from planter.engine.drive import RPM
from planter.engine.loops import split_gaps
from planter.engine.machine import LEAST_PIVOT, Machine, Quantity
from planter.engine.wording import name_angle, name_quantity
from planter.files import units
from planter.kernels import Array, Integers
from planter.kernels.elimination import solve_system
from planter.kernels.formulas import HOISTED, Formulas
from planter.kernels.programs import Program, ProgramStep
from planter.mechanism.elements import (
    Graphs,
    Kinds,
    Meshes,
    draw_elements,
    evaluate_measures,
    mark_ground,
    measure_elements,
)
from planter.mechanism.file import MechanismFile
from planter.mechanism.machines import build_machine, list_quantities
from planter.report import labels, style
from planter.report.scene import Body, Chain, Curve, Force, Point, Scene
from planter.report.subject import Input, Portable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.engine.drive import Drive
    from planter.mechanism.ensemble import MechanismEnsemble
    from planter.mechanism.model import MechanismCycle
    from planter.mechanism.motion import MechanismMotion

UNIT_WORDS = {
    "N": "force",
    "N m": "torque",
    "W": "power",
    "J": "energy",
    "deg": "angle",
    "rad/s": "angular velocity",
    "rad/s2": "angular acceleration",
    "mm": "length",
    "m/s": "speed",
    "m/s2": "acceleration",
}
"""What quantities are that share a figure, by their unit."""
MOST_CURVES = 6
"""Curves in one figure."""
MOST_BANDS = 4
"""Bands in one figure."""
MOST_SEPARATIONS = 40
"""Runs whose separation is drawn."""


@dataclass(frozen=True)
class PlotAxis:
    """The abscissa of curves: values (n,), its name with its unit, and whether it is the angle of a
    cycle [deg].

    `column` is its name in tables. For a cycle, `end` is its last angle, `ends` are the values of
    the curves there by key, and `repeats` holds if it ends in the state in which it began.
    """

    values: Array
    label: str
    is_angle: bool
    ends: Mapping[str, float] = field(default_factory=dict)
    repeats: bool = False
    end: float = 360.0
    column: str = ""

    @classmethod
    def from_cycle(cls, cycle: MechanismCycle) -> PlotAxis:
        """Return the angle of a cycle as an abscissa."""
        end = float(np.degrees(cycle.machine.turn))
        column = f"{cycle.machine.angle}_deg"
        label = f"{name_angle(cycle.machine)} / deg"
        return cls(cycle.angles_deg, label, True, cycle.ends, cycle.repeats, end, column)

    @classmethod
    def from_motion(cls, motion: MechanismMotion) -> PlotAxis:
        """Return the time of a free motion as an abscissa."""
        return cls(motion.times, "time / s", is_angle=False, column="time_s")


def draw_curves(columns: Mapping[str, Array], axis: PlotAxis) -> Iterator[tuple[str, Figure]]:
    """Yield figures of all columns (n,) by the names of their files; columns of one unit share
    figures.
    """
    by_unit: dict[str, list[str]] = {}
    for key in columns:
        by_unit.setdefault(units.display_unit(key), []).append(key)
    for unit, keys in by_unit.items():
        stem = "".join(c if c.isalnum() else "_" for c in unit or "number")
        for number, first in enumerate(range(0, len(keys), MOST_CURVES), 1):
            group = {key: columns[key] for key in keys[first : first + MOST_CURVES]}
            yield f"{stem}_{number}", _draw_group(group, unit, axis)


@style.with_style
def _draw_group(columns: Mapping[str, Array], unit: str, axis: PlotAxis) -> Figure:
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    if axis.is_angle:
        style.over_a_turn(axes, end=axis.end)
    axes.set_xlabel(axis.label)
    axes.set_ylabel(f"{UNIT_WORDS.get(unit, 'value')} / {unit or '1'}")
    ends = []
    for index, (key, values) in enumerate(columns.items()):
        shade = style.curve_colour(key, index)
        x, y = axis.values, values
        if key in axis.ends:
            x, y = np.append(x, axis.end), np.append(y, axis.ends[key])
        axes.plot(x, y, color=shade, linewidth=1.2)
        ends.append((float(y[-1]), labels.format_name(key), shade))
    if not axis.is_angle:
        axes.set_xlim(axis.values[0], axis.values[-1])
    axes.autoscale_view()
    style.label_ends(axes, ends, 0.07)
    return figure


def draw_ensemble(ensemble: MechanismEnsemble) -> Iterator[tuple[str, Figure]]:
    """Yield figures of the bands of an ensemble by the names of their files, then that of the runs'
    separation.
    """
    by_unit: dict[str, list[str]] = {}
    for key in ensemble.curves:
        if not ensemble.bands[key].any():  # what is zero in all runs
            continue
        by_unit.setdefault(units.display_unit(key), []).append(key)
    bands = ensemble.bands
    for unit, keys in by_unit.items():
        stem = "".join(c if c.isalnum() else "_" for c in unit or "number")
        for number, first in enumerate(range(0, len(keys), MOST_BANDS), 1):
            group = {key: bands[key] for key in keys[first : first + MOST_BANDS]}
            yield f"{stem}_{number}", _draw_bands(ensemble.times, group, unit)
    yield "separation", _draw_separation(ensemble)


@style.with_style
def _draw_bands(times: Array, bands: Mapping[str, Array], unit: str) -> Figure:
    """Draw the percentiles (5, n) of quantities by key: median, and bands of 50 % and 90 % of the
    runs.
    """
    figure = style.new_figure(0.8 + 1.5 * len(bands))
    rows = figure.subplots(len(bands), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (key, (low, lower, middle, upper, high)) in zip(rows, bands.items(), strict=True):
        axes.fill_between(times, low, high, color=style.SKY, alpha=0.35, linewidth=0)
        axes.fill_between(times, lower, upper, color=style.SKY, alpha=0.7, linewidth=0)
        axes.plot(times, middle, color=style.BLUE, linewidth=0.9)
        axes.set_ylabel(f"{labels.format_name(key)} / {unit or '1'}")
    rows[-1].set_xlim(times[0], times[-1])
    rows[-1].set_xlabel("time / s")
    rows[0].set_title("median, 50 % and 90 % of the runs")
    return figure


@style.with_style
def _draw_separation(ensemble: MechanismEnsemble) -> Figure:
    """Draw the separation of each run from the stated motion, their median, and the threshold of
    parted runs.
    """
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    separation = np.maximum(ensemble.separation, np.finfo(float).tiny)
    axes.semilogy(
        ensemble.times, separation[:MOST_SEPARATIONS].T, color=style.SKY, linewidth=0.5, alpha=0.6
    )
    axes.semilogy(ensemble.times, np.median(separation, axis=0), color=style.BLUE)
    threshold = ensemble.result.separation.threshold
    axes.axhline(threshold, color=style.VERMILION, linewidth=0.8)
    axes.set_xlim(ensemble.times[0], ensemble.times[-1])
    axes.set_xlabel("time / s")
    axes.set_ylabel("separation / range")
    ends = [
        (float(np.median(separation[:, -1])), "median", style.BLUE),
        (threshold, "parted", style.VERMILION),
    ]
    style.label_ends(axes, ends, 0.07)
    return figure


@style.with_style
def draw_drive(drive: Drive) -> Figure:
    """Draw the speed of a machine on a motor from the start and over the steady cycle, and that
    cycle's torques.
    """
    figure = style.new_figure(6.2)
    start, cycle, torque = figure.subplots(3, 1, height_ratios=(1, 1, 1.5))
    draw_drive_speeds(drive, start, cycle)
    curves = [
        ("motor", drive.driven.torque, style.VERMILION),
        ("load", drive.driven.load, style.BLUE),
        ("load at constant speed", drive.constant.load, style.INK),
    ]
    for _, curve, shade in curves:
        torque.plot(np.degrees(drive.turn.phi), curve, color=shade, linewidth=1.2)
    label_cycle_curves(
        torque, "torque / (N m)", [(float(curve[-1]), text, shade) for text, curve, shade in curves]
    )
    for axes in (cycle, torque):
        axes.set_xlabel("angle of the drive / deg")
    return figure


def draw_drive_speeds(drive: Drive, start: Axes, cycle: Axes) -> None:
    """Draw the speed of a machine on a motor from the start, and over the steady cycle with its
    mean.
    """
    begun, steady, mean = drive.started, drive.turn, drive.result.speed.mean_rpm
    start.plot(begun.phi / (2 * np.pi), begun.omega * RPM, color=style.BLUE, linewidth=1.0)
    start.set_xlim(0, begun.phi[-1] / (2 * np.pi))
    start.set_xlabel("revolutions from the start")
    start.set_ylabel("speed / (r/min)")
    cycle.plot(np.degrees(steady.phi), steady.omega * RPM, color=style.BLUE)
    cycle.axhline(mean, color=style.VERMILION, linewidth=1.0)
    ends = [(steady.omega[-1] * RPM, "driven", style.BLUE), (mean, "mean", style.VERMILION)]
    label_cycle_curves(cycle, "speed / (r/min)", ends)


def label_cycle_curves(axes: Axes, label: str, ends: list[tuple[float, str, str]]) -> None:
    """Label curves over a cycle at their ends: value, name and colour of each."""
    style.over_a_turn(axes)
    axes.set_ylabel(label)
    style.label_ends(axes, ends, 0.12)


GROUND = "ground"
SHAPES = "elements", "meshes"
"""Functions of a mechanism that its elements are drawn from."""
MOST_FRAMES = 400
"""Frames of a scene."""
MOST_SCENE_CURVES = 32
"""Curves of a scene."""
FIRST_UNITS = ("N m", "N")
"""Units of the quantities that come first: torques, then forces."""
RIGID = 1e-6
"""Change of a distance, relative to the extent of a drawing, below which two points belong to one
body; loops are closed more closely.
"""
OBLIQUE = 0.35
"""Share of a length towards the viewer that is drawn to the left and down: the cabinet view of a
spatial mechanism.
"""


def select_curves(keys: Iterable[str], motors: Collection[str] = ()) -> list[str]:
    """Return the keys of quantities that a scene has."""
    return sort_curves(keys, motors)[:MOST_SCENE_CURVES]


def sort_curves(keys: Iterable[str], motors: Collection[str] = ()) -> list[str]:
    """Return keys of quantities in order: those of motors, then that of `FIRST_UNITS`."""
    order = {unit: index for index, unit in enumerate(FIRST_UNITS)}
    return sorted(
        keys,
        key=lambda key: -1 if key in motors else order.get(units.display_unit(key), len(order)),
    )


def find_motors(machine: Machine) -> list[str]:
    """Return the keys of the torques and forces of a machine's motors."""
    return [machine.find_quantity(name).key for name in machine.motors]


def build_cycle_scene(title: str, cycle: MechanismCycle) -> Scene:
    """Return the moving scene of a cycle."""
    axis, machine = PlotAxis.from_cycle(cycle), cycle.machine
    scene = DrawnMotion(axis, cycle.seconds, cycle.columns, cycle.places, cycle.shapes)
    file = machine.document if isinstance(machine.document, MechanismFile) else None
    return build_scene(title, scene, file, machine.results, find_motors(machine))


def build_motion_scene(title: str, motion: MechanismMotion, file: MechanismFile) -> Scene:
    """Return the moving scene of a free motion of a file's mechanism."""
    axis = PlotAxis.from_motion(motion)
    scene = DrawnMotion(axis, motion.result.until_s, motion.columns, motion.places, motion.shapes)
    return build_scene(title, scene, file, list_quantities(file.model))


@dataclass(frozen=True)
class DrawnMotion:
    """A motion over an axis, as a scene draws it: its duration [s], curves (n,) by key in display
    units, and by name coordinates of points (n,) [m] and the `shapes` (n,) [SI] of elements.
    """

    axis: PlotAxis
    seconds: float
    columns: Mapping[str, Array]
    places: Mapping[str, Array]
    shapes: Mapping[str, Array] = field(default_factory=dict)


def build_scene(
    title: str,
    motion: DrawnMotion,
    file: MechanismFile | None = None,
    quantities: Sequence[Quantity] = (),
    motors: Collection[str] = (),
) -> Scene:
    """Return a moving scene.

    The `file` of a mechanism names its elements; `quantities` give the curves their names, and
    forces at points of the drawing their arrows. Curves of `motors` come first.
    """
    axis, columns = motion.axis, motion.columns
    named = {quantity.key: name_quantity(quantity) for quantity in quantities}
    frames = select_frames(len(axis.values))
    points: list[Point] = []
    numbers: dict[tuple[str, bytes], int] = {}
    chains: list[Chain] = []
    bodies = _project_bodies(motion.places)
    extent = 1e3 * float(
        max(np.ptp([at for corners in bodies.values() for at in corners.values()], axis=(0, 2)))
    )
    kinds, meshes = list_elements(file)
    at_frames = {name: values[frames] for name, values in motion.shapes.items()}
    measures = evaluate_measures(kinds, meshes, at_frames, extent)
    mark = float(measures["ground mark"][0])
    elements = list(draw_elements(kinds, meshes, measures))
    gears = {body.name: body for body in elements if body.outlines[0].look == "gear"}
    for shade, (body, corners) in enumerate(bodies.items()):
        places_mm = {name: 1e3 * at[:, frames] for name, at in corners.items()}
        ends = {name: _number_point(points, numbers, name, at) for name, at in places_mm.items()}
        words = body.replace("_", " ")
        joints = [ends[name] for name in select_rigid(places_mm, extent, gears.get(words))]
        if body != GROUND and len(joints) > 1:
            chains.append(Chain(words, joints, len(joints) > 2, shade % 6))
    place, _, unit = axis.label.partition(" / ")
    return Scene(
        title=title,
        place=place,
        unit=unit,
        places=axis.values[frames],
        seconds=motion.seconds,
        bodies=[
            *mark_ground(bodies.get(GROUND, {}), mark),
            *elements,
        ],
        points=points,
        again=axis.repeats,
        chains=chains,
        forces=list(
            _list_forces(
                quantities, points, {key: column[frames] for key, column in columns.items()}
            )
        ),
        curves=[
            Curve(
                named.get(key, labels.format_name(key)),
                units.display_unit(key),
                columns[key][frames],
            )
            for key in select_curves(columns, motors)
        ],
    )


def list_elements(file: MechanismFile | None) -> tuple[Kinds, Meshes]:
    """Return kinds and bodies of what is drawn between bodies, and the gears that mesh."""
    if file is None:
        return {}, {}
    sidecar = file.model.sidecar
    return sidecar.get("drawn", {}), sidecar.get("meshes", {})


def _list_forces(
    quantities: Sequence[Quantity], points: Sequence[Point], columns: Mapping[str, Array]
) -> Iterator[Force]:
    """Yield the joint forces F_Px, F_Py at points P of the drawing."""
    by_name = {quantity.name: quantity for quantity in quantities if quantity.key in columns}
    for point in points:
        components = [by_name.get(f"F_{point.name}{axis}") for axis in "xy"]
        x, y = components
        if x is not None and y is not None and x.unit == y.unit == "N":
            yield Force(x.meaning.removesuffix(", x"), point, columns[x.key], columns[y.key])


def select_frames(count: int) -> Integers:
    """Return the indices of the samples, of `count`, that are frames of a scene."""
    return np.unique(np.linspace(0, count - 1, min(MOST_FRAMES, count)).astype(np.int64))


def _project_bodies(places: Mapping[str, Array]) -> dict[str, dict[str, Array]]:
    """Return points (2, n) [m] in the drawing, by body and by name."""
    bodies: dict[str, dict[str, Array]] = {}
    for name, x in places.items():
        axis, _, rest = name.partition("_")
        if axis == "x":
            body, _, point = rest.partition("__")
            depth = OBLIQUE * places.get(f"z_{rest}", np.zeros_like(x))
            bodies.setdefault(body, {})[point] = np.array([x - depth, places[f"y_{rest}"] - depth])
    return bodies


def select_rigid(points: Mapping[str, Array], extent: float, gear: Body | None) -> list[str]:
    """Return the names of the points (2, n) [mm] that a body carries along: those that stay where
    they are in its gear, or else most that keep their distances.

    A contact moves against both bodies that touch there.
    """
    places = np.array(list(points.values()))
    if gear is not None:
        x, y = (np.asarray(value) for value in gear.at)
        turned = np.exp(-1j * np.radians(gear.turn))
        local_places = (places[:, 0] - x + 1j * (places[:, 1] - y)) * turned
        is_carried = np.abs(local_places - local_places[:, :1]).max(axis=1) <= RIGID * extent
    else:
        distances = np.hypot(*np.moveaxis(places[:, None] - places[None, :], 2, 0))
        is_rigid = np.ptp(distances, axis=2) <= RIGID * extent
        is_carried = is_rigid[np.argmax(is_rigid.sum(axis=1))]
    return [name for name, carried in zip(points, is_carried, strict=True) if carried]


def _number_point(
    points: list[Point], numbers: dict[tuple[str, bytes], int], name: str, at: Array
) -> int:
    """Return the number of a point (2, n), which is added unless another body has it already."""
    key = name, at.tobytes()
    if key not in numbers:
        numbers[key] = len(points)
        points.append(Point(name, at[0], at[1]))
    return numbers[key]


NEWTON_STEPS = 8
"""Newton steps at an angle, from the solution at the angle before."""
START_ROUNDS = 6
"""Rounds of Newton steps at the first angle."""
OPEN = 1e-11
"""A loop is closed where Newton's next step is below this share of the coordinates' size."""
NOTES = (
    "Laws of mechanics, contacts that lift off, limits and optima are not computed here: save the "
    "file in the folder "
    "of its generated functions, and run planter simulate.",
)


def build_loop_closure(model: Formulas, name: str, count: int) -> ca.Function:
    """Return (angles (n,), data) -> loops (n, k), open (n,), senses (n, l), with a fixed number of
    Newton steps.

    `loops` are the coordinates, `open` the largest change by another step, relative to their size,
    and `senses` those of the Jacobian (`planter.kernels.elimination`): where one changes, a loop
    has passed to another assembly.
    """
    closure, assembly = model.function("closure"), model.function("assembly")
    solve = _build_newton_steps(closure, assembly.numel_out(0))
    phi, data = ca.MX.sym("angles", count), ca.MX.sym("data", closure.numel_in(1))
    start = assembly(data)
    for _ in range(START_ROUNDS):
        start = solve(start, phi[0], data)[0]
    walk = solve.mapaccum("walk", count, [0], [0])
    outputs = [output.T for output in walk(start, phi.T, ca.repmat(data, 1, count))]
    return ca.Function(name, [phi, data], outputs, ["angles", "data"], ["loops", "open", "senses"])


def _build_newton_steps(closure: ca.Function, size: int) -> ca.Function:
    """Return (coordinates (k,), angle, data) -> coordinates, relative change by another step,
    senses.
    """
    q, phi, data = ca.SX.sym("q", size), ca.SX.sym("phi"), ca.SX.sym("data", closure.numel_in(1))
    gaps, jacobian = split_gaps(closure(phi, data, q), size)
    solved = solve_system(jacobian, -gaps)
    relative = ca.mmax(ca.fabs(solved.solution) / (1 + ca.fabs(q)))
    step = ca.Function("step", [q, phi, data], [q + solved.solution, relative, solved.senses])
    start, angle, values = (
        ca.MX.sym("q", size),
        ca.MX.sym("phi"),
        ca.MX.sym("data", closure.numel_in(1)),
    )
    at = start
    for _ in range(NEWTON_STEPS):
        at = step(at, angle, values)[0]
    return ca.Function("at", [start, angle, values], [at, *step(at, angle, values)[1:]])


class MechanismCycleProgram:
    """The cycle of a mechanism at the samples of its file, as a program that a page runs without
    Python.
    """

    def __init__(self, file: MechanismFile) -> None:
        self.file, self.machine, self.formulas = file, build_machine(file), file.model
        self.samples = self.machine.samples
        self.angles = 2 * np.pi * np.arange(self.samples) / self.samples
        self.has_loops = self.machine.loops is not None

    def build_portable(self) -> Portable:
        """Return the program with its inputs, outputs and texts."""
        return Portable(
            inputs=[
                Input(value.path, "data", k, value.factor)
                for k, value in enumerate(self.machine.values)
            ],
            seen=Program(
                "turn", {"angles": self.angles, "data": self.machine.data}, self._list_steps()
            ),
            rows={"rows": len(self._columns)},
            singles=list(self._singles),
            assumptions=self.formulas.sidecar["assumptions"],
            notes=NOTES,
        )

    def _list_steps(self) -> list[ProgramStep]:
        steps = (
            [ProgramStep(build_loop_closure(self.formulas, "turn_loops", self.samples))]
            if self.has_loops
            else []
        )
        if HOISTED in self._lane.name_in():
            prologue = self.formulas.function("prologue")
            data = ca.MX.sym("data", prologue.numel_in(0))
            steps.append(
                ProgramStep(
                    ca.Function("turn_prologue", [data], [prologue(data)], ["data"], [HOISTED])
                )
            )
        names = ["angles", *self._lane.name_in()[1:]]
        rows = ca.Function(
            "turn_rows", self._inputs, [ca.cse(ca.vertcat(*self._rows.values()))], names, ["all"]
        )
        steps.append(
            ProgramStep(rows, tuple(name for name in names if name in ("angles", "loops")))
        )
        columns = ca.horzcat(*self._columns)
        steps.append(
            ProgramStep(ca.Function("turn_drawn", [self._matrix], [columns], ["all"], ["rows"]))
        )
        inputs, singles = self._single_inputs, ca.vertcat(*self._singles.values())
        steps.append(
            ProgramStep(
                ca.Function(
                    "turn_singles", list(inputs.values()), [singles], list(inputs), ["singles"]
                )
            )
        )
        return steps

    # --- quantities along the angle
    # --------------------------------------------------------------------

    @cached_property
    def _lane(self) -> ca.Function:
        return self.formulas.function("lane")

    @cached_property
    def _inputs(self) -> list[ca.SX]:
        return list(self._lane.sx_in())

    @cached_property
    def _rows(self) -> Mapping[str, ca.SX]:
        """All graphs at an angle: results in display units by key, guards, coordinates of points,
        the angle [deg].
        """
        quantities = list(
            zip(self.machine.quantities, ca.vertsplit(self._lane(*self._inputs)), strict=True)
        )
        results = {q.key: value / q.factor for q, value in quantities if q.role == "result"}
        guards = {q.name: value for q, value in quantities if q.role in ("pivot", "states")}
        return {
            **results,
            **guards,
            **self._points,
            **self._shapes,
            "angle": self._inputs[0] / units.unit_factor("angle_deg"),
        }

    @cached_property
    def _points(self) -> Mapping[str, ca.SX]:
        """Coordinates of points of bodies in the drawing [mm], as `x BODY__POINT` and
        `y BODY__POINT`.
        """
        at = self._evaluate("places")
        return {
            f"{axis} {point}": 1e3 * (at[f"{axis}_{point}"] - OBLIQUE * at.get(f"z_{point}", 0.0))
            for name in at
            for axis, _, point in [name.partition("_")]
            if axis in "xy"
        }

    @cached_property
    def _shapes(self) -> Mapping[str, ca.SX]:
        """What springs, guides, cams and gears are drawn from [SI], as `shape NAME`."""
        stated = self.formulas.sidecar["functions"]
        shapes: dict[str, ca.SX] = {}
        for name in SHAPES:
            if name in stated:
                shapes |= self._evaluate(name)
        return {f"shape {name}": value for name, value in shapes.items()}

    def _evaluate(self, name: str) -> Mapping[str, ca.SX]:
        """Return the outputs of a function of the mechanism at an angle, by name."""
        function = self.formulas.function(name)
        inputs = dict(zip(self._lane.name_in(), self._inputs, strict=True))
        values = ca.vertsplit(function(*(inputs[key] for key in function.name_in())))
        return dict(zip(self.formulas.outputs(name), values, strict=True))

    @cached_property
    def _columns(self) -> Sequence[ca.MX]:
        """What a scene draws along the angle, at its frames."""
        results = [quantity.key for quantity in self.machine.results]
        curves = select_curves(results, find_motors(self.machine))
        keys = ["angle", *curves, *self._points]
        measures = (graph for graph in self._measures.values() if graph.numel() > 1)
        return [*(self._at_frames(key) for key in keys), *measures]

    @cached_property
    def _measures(self) -> Graphs:
        """What elements are drawn from."""
        extent = ca.fmax(*(self._find_range(axis) for axis in "xy"))
        shapes = {key.removeprefix("shape "): self._at_frames(key) for key in self._shapes}
        return measure_elements(*list_elements(self.file), shapes, extent)

    def _at_frames(self, key: str) -> ca.MX:
        frames = select_frames(self.samples).tolist()
        return self._matrix[frames, list(self._rows).index(key)]

    def _find_range(self, axis: str) -> ca.MX:
        """Return the range of all points along an axis [mm]."""
        rows = dict(zip(self._rows, ca.horzsplit(self._matrix), strict=True))
        values = ca.vertcat(*(row for name, row in rows.items() if name.startswith(f"{axis} ")))
        return ca.mmax(values) - ca.mmin(values)

    # --- single numbers
    # --------------------------------------------------------------------------------

    @cached_property
    def _matrix(self) -> ca.MX:
        return ca.MX.sym("all", self.samples, len(self._rows))

    @cached_property
    def _single_inputs(self) -> Mapping[str, ca.MX]:
        """The inputs of the single numbers: values, the matrix of all rows, the state of the
        loops.
        """
        loops = {}
        if self.machine.loops is not None:
            sizes = {"open": 1, "senses": self.machine.loops.count}
            loops = {name: ca.MX.sym(name, self.samples, size) for name, size in sizes.items()}
        return {"data": ca.MX.sym("data", len(self.machine.data)), "all": self._matrix, **loops}

    @cached_property
    def _singles(self) -> Mapping[str, ca.MX]:
        rows = dict(zip(self._rows, ca.horzsplit(self._matrix), strict=True))
        speed = self._single_inputs["data"][self.machine.speed]
        return {
            "seconds": 2 * np.pi / ca.fabs(speed),
            "sound": 1 / self._build_soundness(rows),
            **{f"{name_quantity(q)}, largest": ca.mmax(rows[q.key]) for q in self.machine.results},
            **{f"{name_quantity(q)}, least": ca.mmin(rows[q.key]) for q in self.machine.results},
            **{name: graph for name, graph in self._measures.items() if graph.numel() == 1},
            **self._place_ground(rows),
        }

    def _build_soundness(self, rows: Mapping[str, ca.MX]) -> ca.MX:
        """Return 1 if all loops are closed in one assembly and the equations determine the forces,
        else 0.
        """
        thresholds = {"pivot": LEAST_PIVOT, "states": 0}
        checks = [
            ca.mmin(rows[q.name]) > thresholds[q.role]
            for q in self.machine.quantities
            if q.role in thresholds
        ]
        if self.has_loops:
            senses = self._single_inputs["senses"]
            first = ca.repmat(senses[0, :], self.samples, 1)
            checks += [
                ca.mmax(self._single_inputs["open"]) < OPEN,
                ca.mmin(ca.vec(senses * first)) > 0,
            ]
        product = ca.MX(1)
        for check in checks:
            product *= check
        return product

    def _place_ground(self, rows: Mapping[str, ca.MX]) -> Mapping[str, ca.MX]:
        """Return coordinates of the points of the ground."""
        names = [name for name in self._points if name[2:].startswith(f"{GROUND}__")]
        return {name: rows[name][0] for name in names}
