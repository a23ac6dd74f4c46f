"""Folders of results of machines that the engine takes: pages, figures, tables, and an optimum as a machine file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from planter.engine.drive import RPM, Drive
from planter.engine.machine import Machine
from planter.engine.sensitivity import SensitivityFound
from planter.engine.tables import (
    describe_directions,
    drive_tables,
    driven_quantities,
    sensitivity_sentences,
    sensitivity_tables,
    summary_tables,
)
from planter.files import units
from planter.files.document import Document, lines
from planter.kernels import Array
from planter.mechanism.cycle import Turn, turn
from planter.mechanism.drawing import Course, curves, scene
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import Model
from planter.mechanism.motion import Motion
from planter.mechanism.optimisation import Found
from planter.mechanism.results import Held, Optimum
from planter.mechanism.tables import CHANGED_START, unit_with_axes
from planter.progress import Listener
from planter.report import bundle, files, style
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.report.proof import describe_proof
from planter.version import __version__
from planter.view.animation import Motion as Moving
from planter.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEN = "Bodies by the points where forces act on them and by their centroids, which is all that the statement says."


class FileDescription(NamedTuple):
    """What a page says of a file: meanings of its values by path, title and source of its model, what this assumes."""

    document: Document
    meanings: Mapping[str, str]
    title: str
    source: str
    assumptions: Sequence[str]


def describe_owner(machine: Machine) -> FileDescription:
    """Return what a page says of the file of a machine that an angle drives."""
    model = machine.documentation
    return FileDescription(machine.document, machine.meanings, model.title, model.reference, machine.assumptions)


def describe_free(file: MechanismFile) -> FileDescription:
    """Return what a page says of the file of a mechanism that moves by itself."""
    sidecar, meanings = file.model.sidecar, {entry["shown"]: entry["meaning"] for entry in file.entries}
    return FileDescription(file, meanings, sidecar["title"], sidecar["source"], sidecar["assumptions"])


def write(
    out: Path, title: str, file: FileDescription, table: Mapping[str, Any], told: Iterable[Section],
    columns: Mapping[str, Array], course: Course, progress: Listener | None, moving: Scene | None,
    more: Mapping[str, str] = MappingProxyType({}),
) -> None:  # fmt: skip
    """Writes summary.json, values.csv, figures and report.html, whole or not at all, and `more` texts by their names.

    `told` are the sections that come first. Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    drawn = bundle.drawn(dict(curves(columns, course)), progress)
    document, provenance = file.document, files.provenance(file.document)
    every = {course.label.replace(" / ", "_"): course.values, **columns}
    motion = [] if moving is None else [Section("Motion", [Moving(moving, SEEN)])]
    figures = Section("Figures", [FigureSvg(figure.svg, "") for figure in drawn.values()])
    texts = {
        "summary.json": files.summary_text({**table, "input": document.table(), "provenance": provenance}),
        "values.csv": files.cycle_csv("values.csv", files.comments(document, "mechanism"), every),
        "report.html": page(title, [*told, *motion, figures, *_end(file, provenance)], document.description),
        **more,
    }
    bundle.write(out, texts, drawn)


def write_tables(out: Path, title: str, machine: Machine, table: Mapping[str, Any], told: Iterable[Section],
                 figures: Mapping[str, Figure] = MappingProxyType({}), texts: Mapping[str, str] = MappingProxyType({}),
                 progress: Listener | None = None) -> None:  # fmt: skip
    """Write summary.json and report.html, with figures by their names and more `texts`.

    Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    drawn = bundle.drawn(dict(figures), progress)
    document, provenance = machine.document, files.provenance(machine.document)
    shown = [Section("Figures", [FigureSvg(figure.svg, "") for figure in drawn.values()])] if drawn else []
    every = {
        "summary.json": files.summary_text({**table, "input": document.table(), "provenance": provenance}),
        "report.html": page(title, [*told, *shown, *_end(describe_owner(machine), provenance)], document.description),
        **texts,
    }
    bundle.write(out, every, drawn)


def _end(file: FileDescription, provenance: Mapping[str, Any]) -> Iterator[Section]:
    assumptions = Text(f"{file.title}, from {file.source}. It assumes:"), Items(file.assumptions)
    yield Section("Model", list(assumptions))
    yield Section("Inputs", list(inputs(file.document, file.meanings, ("turn",))))
    yield provenance_section(provenance)


ONE_SIDED = "Extremes are true ones, not those of samples; where a quantity jumps, those of either side."


def write_turn(out: Path, found: Turn, progress: Listener | None = None) -> None:
    """Write a turn: every quantity, works, laws. Raises InputError for a folder that it cannot write."""
    told = [*_turn(found), *_limits(found.result.holds or ())]
    _write_cycle(out, f"A turn of {found.machine.name}", found, found.result.table(), told, progress)


def _write_cycle(
    out: Path, title: str, cycle: Turn, table: Mapping[str, Any], told: Iterable[Section], progress: Listener | None,
    more: Mapping[str, str] = MappingProxyType({}),
) -> None:  # fmt: skip
    course = Course.from_cycle(cycle)
    seen = scene(title, course, cycle.seconds, cycle.columns, cycle.places) if cycle.places else None
    write(out, title, describe_owner(cycle.machine), table, told, cycle.columns, course, progress, seen, more)


def write_motion(out: Path, found: Motion, machine: MechanismFile, progress: Listener | None = None) -> None:
    """A free motion: every quantity, energy, the state of rest. Raises InputError as `write_turn`."""
    course = Course(found.times, "time / s", turn=False)
    title = f"Motion of {machine.name}"
    seen = scene(title, course, found.result.until_s, found.columns, found.places)
    file = describe_free(machine)
    write(out, title, file, found.result.table(), _motion(found), found.columns, course, progress, seen)


def write_optimum(out: Path, found: Found, progress: Listener | None = None) -> None:
    """An optimum: what moved, the turn it makes, and a file of it. Raises InputError as `write_turn`."""
    best = turn(Model(found.machine))
    told = [*_optimum(found.result), *_limits(found.result.holds), *_turn(best)]
    more = {"optimum.toml": format_optimum_file(found)}
    _write_cycle(out, f"Optimum of {found.machine.name}", best, found.result.table(), told, progress, more)


def write_sensitivity(out: Path, found: SensitivityFound, machine: Machine) -> None:
    """A sensitivity: gradient and combinations. Raises InputError as `write_turn`."""
    title = f"Sensitivity of {machine.name}"
    write_tables(out, title, machine, found.table(), sensitivity_sections(found))


def sensitivity_sections(found: SensitivityFound) -> Iterator[Section]:
    """Yield the gradient, and which combinations matter."""
    tables = [Table(one.head, one.rows, one.title) for one in sensitivity_tables(found)]
    sentences = [Text(sentence) for sentence in sensitivity_sentences(found)]
    yield Section("Gradient", [Text(f"Of {found.least}."), *tables[:1]])
    yield Section("What matters", [*sentences, *tables[1:]])


def _optimum(found: Optimum) -> Iterator[Section]:
    change = f"{found.start_objective:.6g} to {found.objective:.6g}"
    rows = [(label(key), found.start_design[key], value) for key, value in found.design.items()]
    blocks: list[Block] = [Text(f"Least {found.least}: {change}."), Table(("quantity", "before", "optimum"), rows)]
    yield Section("Optimum", blocks)
    proof = found.certificate
    yield Section("Certificate", [Keys({
        "residual of the optimality conditions": proof.kkt_residual,
        "starts that agree": f"{proof.agreeing_starts} of {proof.starts}",
        "bounds that bind": ", ".join(proof.active_bounds) or "none",
        **{f"price of {one.limit_on} per {one.unit or 'unit'}": one.multiplier for one in proof.active_limits},
        "samples of the turn": found.samples,
    })])  # fmt: skip
    effective, count = found.effective_parameters, len(found.design)
    yield Section("What matters", [Text(line) for line in describe_directions(effective, count, found.insensitive)])
    if found.front:
        points = [(point.range, point.variance, *point.design.values()) for point in found.front]
        head = ("range", "variance", *map(label, found.design))
        yield Section("Front of range and variance", [Table(head, points)])
    if found.proof is not None:
        yield Section("Proof", list(describe_proof(found.proof.table())))


def _limits(holds: Sequence[Held]) -> Iterator[Section]:
    if holds:
        rows = [(one.limit_on, one.value, one.active, one.met) for one in holds]
        yield Section("Limits", [Table(("limit", "value", "binds", "satisfied"), rows)])


def _turn(found: Turn) -> Iterator[Section]:
    if told := found.result.warnings:
        yield Section("Warnings", [Items([f"{w.message} ({w.name})" for w in told], "warning")])
    meanings = {quantity.key: quantity.meaning for quantity in found.machine.results}
    rows = [
        (key, meanings[key], unit_with_axes(q), q.min, q.min_deg, q.max, q.max_deg, q.mean, q.rms)
        for key, q in found.result.quantities.items()
    ]
    head = ("quantity", "meaning", "unit", "min", "at / deg", "max", "at / deg", "mean", "rms")
    yield Section("Turn", [Table(head, rows)])
    if found.result.work:
        yield Section("Work of a turn", [_keys(found.result.work)])
    if found.result.designer is not None:
        blocks = [Table(one.head, one.rows, one.title) for one in summary_tables(found.result.designer)]
        yield Section("Designer's summary", [*blocks, Text(ONE_SIDED, "note")])
    if at := found.result.at:
        angles = [f"{one.angle_deg:.6g} deg" for one in at]
        cells: list[list[str | float]] = [
            [key, units.unit(key), *(one.quantities[key] for one in at)] for key in found.result.quantities
        ]
        yield Section("At single angles", [Table(("quantity", "unit", *angles), cells)])
    if found.result.laws:
        laws = [(law.law, law.violation, law.unit) for law in found.result.laws]
        yield Section("Laws", [Table(("law", "largest violation", "unit"), laws)])


def _motion(found: Motion) -> Iterator[Section]:
    result = found.result
    rows = [(key, found.meanings[key], unit_with_axes(q), q.min, q.max, q.last) for key, q in result.quantities.items()]
    yield Section("Motion", [Table(("quantity", "meaning", "unit", "min", "max", "last"), rows)])
    if result.changed_start:
        changed = [(one.quantity, one.unit, one.stated, one.used) for one in result.changed_start]
        yield Section("Start", [Text(f"{CHANGED_START}.", "warning"),
                                Table(("quantity", "unit", "stated", "used"), changed)])  # fmt: skip
    yield Section("Energy", [_keys(result.energy.table())])
    if result.equilibrium is not None and result.eigenvalues_per_s is not None:
        values = Table(("real / 1/s", "imaginary / 1/s"), result.eigenvalues_per_s)
        yield Section("State of rest", [_keys(result.equilibrium), values])


def _keys(values: Mapping[str, float | None]) -> Keys:
    return Keys({label(key): value for key, value in values.items()})


def format_optimum_file(found: Found) -> str:
    """Return the machine's file (TOML) with the optimum's values, and what they were beside them."""
    result, machine = found.result, found.machine
    table, paths = machine.document.written_table(), [machine.values[index].path for index in machine.moved]
    start = dict(zip(paths, result.start_design.values(), strict=True))
    moved = [path for path, value in zip(paths, result.design.values(), strict=True) if value != start[path]]
    notes = {path: f"was {start[path]!r} {units.unit(path)}".rstrip() for path in moved}
    table["origin"] = machine.document.origins | dict.fromkeys(moved, f"optimised (least {result.least})")
    limits = "; ".join(one.limit_on for one in result.holds)
    head = [
        f"# {found.machine.name} with least {result.least}{f' under {limits}' if limits else ''}.",
        f"# By planter {__version__}.",
        f"# Reached {result.objective!r}, before {result.start_objective!r}.",
    ]
    order = dict(sorted(table.items(), key=lambda pair: isinstance(pair[1], dict)))
    return "\n".join([*head, "", *lines(order, notes)]) + "\n"


def write_drive(out: Path, found: Drive, machine: Machine, progress: Listener | None = None) -> None:
    """Write summary.json, turn.csv, figures/drive and report.html.

    Raises InputError for a folder that it cannot write.
    """
    table = files.cycle_csv("turn.csv", files.comments(machine.document, "mechanism"), found.columns())
    write_tables(
        out, f"{machine.name} on a motor", machine, found.result.table(), _sections(found),
        {"drive": draw_speed_and_torque(found)}, {"turn.csv": table}, progress,
    )  # fmt: skip


def _sections(found: Drive) -> Iterator[Section]:
    motor, speed = drive_tables(found.result)
    forces = driven_quantities(found.result)
    yield Section("Motor", [Table(motor.head, motor.rows)])
    yield Section("Speed", [Table(speed.head, speed.rows, speed.title)])
    yield Section("Forces", [Table(forces.head, forces.rows, forces.title)])


@style.drawn
def draw_speed_and_torque(found: Drive) -> Figure:
    """Draw the speed from the start on and over a turn, and the torques on the shaft over that turn."""
    figure = style.new_figure(6.2)
    begun, over, torque = figure.subplots(3, 1, height_ratios=(1, 1, 1.5))
    draw_speeds(found, begun, over)
    angles, ends = np.degrees(found.turn.phi), []
    for name, curve, shade in (
        ("motor", found.driven.torque, style.VERMILION), ("load", found.driven.load, style.BLUE),
        ("load at constant speed", found.constant.load, style.INK),
    ):  # fmt: skip
        torque.plot(angles, curve, color=shade, linewidth=1.2)
        ends.append((float(curve[-1]), name, shade))
    draw_turn(torque, "torque / (N m)", ends)
    for axes in (over, torque):
        axes.set_xlabel("angle of the drive / deg")
    return figure


def draw_speeds(found: Drive, begun: Axes, over: Axes) -> None:
    """Draw the speed from the start on, and over the turn that repeats itself."""
    start, turn = found.started, found.turn
    begun.plot(start.phi / (2 * np.pi), start.omega * RPM, color=style.BLUE, linewidth=1.0)
    begun.set_xlim(0, start.phi[-1] / (2 * np.pi))
    begun.set_xlabel("turns from the start")
    begun.set_ylabel("speed / (r/min)")
    over.plot(np.degrees(turn.phi), turn.omega * RPM, color=style.BLUE)
    mean = found.result.speed.mean_rpm
    over.axhline(mean, color=style.VERMILION, linewidth=1.0)
    draw_turn(over, "speed / (r/min)", [(turn.omega[-1] * RPM, "driven", style.BLUE), (mean, "mean", style.VERMILION)])


def draw_turn(axes: Axes, label: str, ends: list[tuple[float, str, str]]) -> None:
    """Label curves over a turn at their ends."""
    style.over_a_turn(axes)
    axes.set_ylabel(label)
    style.label_ends(axes, ends, 0.12)
