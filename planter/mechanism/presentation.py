"""Presentations of cycles, free motions, optima, sensitivities, motor drives and checks of the
engine's machines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from planter.engine import tables
from planter.engine.drive import Drive
from planter.engine.machine import Machine
from planter.engine.measures import parse_limit
from planter.engine.sensitivity import SensitivityResult
from planter.engine.solvers.result import OptimalityCertificate, WiderOptimum
from planter.files import units
from planter.files.document import Document, format_lines
from planter.files.fields import SET
from planter.files.record import Record
from planter.kernels import Array
from planter.measured.sensor_curve import SensorSignal
from planter.measured.sensor_presentation import (
    CAPTION,
    FIGURE,
    draw_signals,
    list_measurement_sections,
)
from planter.mechanism import drawing
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.drawing import PlotAxis
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.extension import find_extension
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import MechanismCycle, Model
from planter.mechanism.motion import MechanismMotion, compute_motion
from planter.mechanism.motion_response import TOLERANCE
from planter.mechanism.optimisation import MechanismOptimum, StatedGoal, UnfinishedOptimum
from planter.mechanism.results import (
    ChangedStart,
    EnsembleResult,
    LimitResult,
    MachineValidation,
    MechanismCycleResult,
    MechanismOptimumResult,
    MotionResult,
    QuantityHistory,
    QuantityStatistics,
)
from planter.report import files
from planter.report.animation import MotionBlock as MotionBlock
from planter.report.folder import CLOSEST_FILE, OPTIMUM_FILE, drop_file, write_file
from planter.report.html import Cell, Items, KeyFigure, Keys, Section, Table, Text
from planter.report.labels import (
    count_things,
    format_label,
    format_name,
    list_values,
    tabulate_angles,
    tabulate_named,
)
from planter.report.presentation import (
    MOST_KEY_FIGURES,
    ModelAssumptions,
    ResultPresentation,
    describe_basis,
    describe_failure,
    describe_proof,
    describe_violations,
    list_proof_files,
    list_warning_sections,
    shorten_failures,
)
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.mechanism.ensemble import MechanismEnsemble

CHANGED_START = (
    "The constraints change these values of the start; `hold` of `begin` names those "
    "that keep theirs."
)
ONE_SIDED = (
    "Extremes are true ones, not those of samples; where a quantity jumps, those of either side."
)
SET_ORIGIN = f"assumed; {SET}"
"""Origin of a number that was set for one call, to which the origin in the file no longer
applies.
"""
LAW_ROUNDING = 1e-8
"""Residual of a law below which it holds, as a share of its scale: rounding is 1e-16, and
elimination loses digits.
"""
EXTREME_SHARE = 1e-6
"""Share within which the value of a limit is that of an extreme, both true ones."""
UNITS_FIRST = ("N m", "N", "W", "mm", "deg")
"""Units of the quantities that a page opens with, in this order."""
MOTION_CAPTION = (
    "Bodies by the points where forces act on them and by their centroids; springs, guides, cams and "
    "gears as stated."
)


def present_cycle(cycle: MechanismCycle) -> ResultPresentation:
    """Return the presentation of a cycle: quantities, works, laws, limits, and what its kind of
    machine adds.
    """
    result, extension = cycle.result, find_extension(cycle.machine)
    title = f"Cycle of {result.machine} in {result.samples} samples"
    sections = [
        *list_limit_sections(result.holds or ()),
        *extension.list_sections(result),
        *_list_cycle_sections(cycle),
        *list_measurement_sections(result.measurement),
    ]
    added = extension.list_parts(result)
    key_figures = [*added.get("key_figures", ()), *_list_cycle_figures(result)]
    parts = {
        "conclusion": _conclude_cycle(result),
        "failures": list_cycle_failures(result),
        **added,
        "key_figures": key_figures[:MOST_KEY_FIGURES],
        "captions": {FIGURE: CAPTION, **added.get("captions", {})},
        **_draw_cycle(title, lambda: cycle, cycle.measured),
    }
    return _present(_describe_machine(cycle.machine), title, result, sections, **parts)


def present_optimum(optimum: MechanismOptimum) -> ResultPresentation:
    """Return the presentation of an optimum: changed values, limits, certificate, its cycle, and a
    file of it.
    """
    result, machine = optimum.result, optimum.machine
    title, best = f"Optimum of {machine.name}", cache(lambda: compute_cycle(Model(machine)))
    parts: dict[str, Any] = (
        _draw_motion(title, cache(lambda: _move(machine)), cast(MechanismFile, machine.document))
        if machine.motion is not None
        else {"details": lambda: _list_cycle_sections(best()), **_draw_cycle(title, best)}
    )
    return _present(
        _describe_machine(machine),
        title,
        result,
        _list_optimum_sections(result),
        conclusion=_conclude_optimum(result),
        failures=list_limit_failures(result.holds),
        key_figures=list(_list_optimum_figures(result)),
        texts=lambda: {
            OPTIMUM_FILE: format_optimum_file(optimum),
            **list_proof_files(optimum.certificate),
        },
        **parts,
    )


def _move(machine: Machine) -> MechanismMotion:
    """Return the motion of a machine that moves freely over its span of time."""
    assert machine.motion is not None
    dynamics = Dynamics(cast(MechanismFile, machine.document))
    return compute_motion(dynamics, machine.motion.span, machine.samples + 1, TOLERANCE)


def present_sensitivity(result: SensitivityResult, machine: Machine) -> ResultPresentation:
    """Return the presentation of a sensitivity: gradient and combinations of values."""
    title = f"Sensitivity of {machine.name}"
    conclusion = describe_strongest(result)
    return _present(
        _describe_machine(machine),
        title,
        result,
        list_sensitivity_sections(result),
        conclusion=conclusion,
    )


def describe_strongest(result: SensitivityResult) -> str:
    """Return which value changes the objective most over the width of its bounds, and how many
    combinations count.
    """
    name, change = max(result.scaled.items(), key=lambda pair: abs(pair[1]))
    count, depends = len(result.scaled), result.effective_parameters
    return (
        f"{format_label(name)} changes the objective of {result.objective:.4g} most: by "
        f"{change:.3g} over the width of "
        f"its bounds, to first order. The curves depend on {depends} of "
        f"{count_things(count, 'combination')} of values."
    )


def _conclude_cycle(result: MechanismCycleResult) -> str:
    parts = []
    if result.holds:
        violated = [limit.limit_on for limit in result.holds if not limit.met]
        parts.append(describe_violations(violated, len(result.holds), "limit"))
    if result.designer is not None and result.designer.motor is not None:
        motor = result.designer.motor
        parts.append(
            f"The motor's torque is between {motor.min_Nm:.4g} and {motor.max_Nm:.4g} N m, its "
            f"peak power "
            f"{motor.peak_power_W:.4g} W."
        )
    if result.laws and all(law.violation < LAW_ROUNDING * law.scale for law in result.laws):
        parts.append(
            f"All {len(result.laws)} laws hold to {LAW_ROUNDING:g} of their largest quantities."
        )
    return " ".join(parts) or f"A cycle of {result.machine} closes; its quantities are below."


def _list_cycle_figures(result: MechanismCycleResult) -> Iterator[KeyFigure]:
    """Yield the largest sizes of a torque, a force and a power, or of what there is."""
    extremes = []
    for peak in [] if result.designer is None else result.designer.peaks:
        ends = (peak.max, peak.max_phi_deg), (peak.min, peak.min_phi_deg)
        value, angle = max(ends, key=lambda pair: abs(pair[0]))
        words = f"{peak.name}, {peak.meaning}, largest in size, at {angle:.4g} deg"
        extremes.append((peak.unit, value, words))
    yield from _list_largest(extremes)


def _list_motion_figures(motion: MechanismMotion) -> Iterator[KeyFigure]:
    """Yield the largest sizes of a torque, a force and a power over a motion, or of what there is."""
    extremes = []
    for key, column in motion.columns.items():
        largest = int(np.abs(column).argmax())
        words = f"{format_name(key)}, {motion.meanings[key]}, largest in size, at "
        words += f"{motion.times[largest]:.4g} s"
        extremes.append((motion.result.quantities[key].unit, float(column[largest]), words))
    yield from _list_largest(extremes)


def _list_largest(extremes: Sequence[tuple[str, float, str]]) -> Iterator[KeyFigure]:
    """Yield the largest of extremes, units with values and words, in each unit."""
    by_unit: dict[str, list[tuple[float, str]]] = {}
    for unit, value, words in extremes:
        by_unit.setdefault(unit, []).append((value, words))
    order = sorted(by_unit, key=lambda unit: (*UNITS_FIRST, unit).index(unit))
    for unit in order[:MOST_KEY_FIGURES]:
        value, words = max(by_unit[unit], key=lambda pair: abs(pair[0]))
        yield KeyFigure(f"{value:.4g}".replace("-", "\N{MINUS SIGN}"), unit, words)


def _conclude_optimum(result: MechanismOptimumResult) -> str:
    certificate, before, after = result.certificate, result.start_objective, result.objective
    change = f", {100 * (after / before - 1):+.3g} %" if before else ""
    violated = [limit.limit_on for limit in result.holds if not limit.met]
    limits = describe_violations(violated, len(result.holds), "limit") if result.holds else ""
    starts = f"{certificate.agreeing_starts} of {certificate.starts} starts agree"
    certain = f"Residual of the optimality conditions {certificate.kkt_residual:.1e}; {starts}."
    return " ".join(
        filter(
            None,
            (f"{result.least} falls from {before:.5g} to {after:.5g}{change}.", limits, certain),
        )
    )


def _list_optimum_figures(result: MechanismOptimumResult) -> Iterator[KeyFigure]:
    before, after = result.start_objective, result.objective
    if before:
        percent = f"{100 * (after / before - 1):+.3g} %".replace("-", "\N{MINUS SIGN}")
        yield KeyFigure(percent, "", f"{result.least}, {before:.4g} to {after:.4g}")
    if result.holds:
        met = sum(limit.met for limit in result.holds)
        yield KeyFigure(f"{met} of {len(result.holds)}", "", "limits satisfied")
    certificate = result.certificate
    yield KeyFigure(
        f"{certificate.agreeing_starts} of {certificate.starts}", "", "starts agree on the optimum"
    )
    yield KeyFigure(
        f"{len(certificate.active_bounds)} of {len(result.design)}", "", "values end at a bound"
    )


def list_sensitivity_sections(result: SensitivityResult) -> Iterator[Section]:
    """Yield the gradient, and the combinations of values that the objective depends on."""
    gradient, *combinations = tables.sensitivity_tables(result)
    sentences = [Text(sentence) for sentence in tables.sensitivity_sentences(result)]
    yield Section("Gradient", [Text(f"Objective: {result.least}."), gradient])
    yield Section("Effective combinations", [*sentences, *combinations])


def present_drive(drive: Drive) -> ResultPresentation:
    """Return the presentation of a machine on a motor: speed, torques and forces."""
    parts = (
        *tables.drive_tables(drive.result),
        tables.driven_quantities(drive.result, drive.machine),
    )
    return _present(
        _describe_machine(drive.machine),
        f"{drive.machine.name} on a motor",
        drive.result,
        [
            Section(title, [table])
            for title, table in zip(("Motor", "Speed", "Forces"), parts, strict=True)
        ],
        key_figures=tables.list_drive_figures(drive.result),
        conclusion=f"The speed varies by {drive.result.speed.fluctuation:.2%} of its mean, "
        f"{drive.result.speed.mean_rpm:.4g} r/min.",
        figures=lambda: {"drive": drawing.draw_drive(drive)},
        tables=lambda: {"turn.csv": drive.columns()},
    )


def present_motion(motion: MechanismMotion, file: MechanismFile) -> ResultPresentation:
    """Return the presentation of a free motion: quantities, energy, constraints, equilibrium."""
    result = motion.result
    title = f"Motion of {file.name} until {result.until_s:g} s"
    violated = [limit.limit_on for limit in result.holds or () if not limit.met]
    conclusion = describe_violations(violated, len(result.holds), "limit") if result.holds else ""
    sections = [*list_limit_sections(result.holds or ()), *_list_motion_sections(motion)]
    return _present(
        describe_file(file),
        title,
        result,
        sections,
        conclusion=conclusion,
        failures=list_limit_failures(result.holds or ()),
        key_figures=list(_list_motion_figures(motion)),
        **_draw_motion(title, lambda: motion, file),
    )


SEPARATION_NAMES = {
    "runs": "Runs",
    "parted_runs": "Runs that part from the motion of the stated start",
    "threshold": "Separation from which on a run has parted / ranges of the states",
    "last_median": "Median of the separation at the end / ranges of the states",
    "lyapunov_per_s": "Largest Lyapunov exponent / 1/s",
    "lyapunov_per_s.error": "Standard error of the exponent / 1/s",
    "parted_after_s.mean": "Mean time until a run has parted / s",
    "parted_after_s.mean_error": "Standard error of that mean / s",
    "parted_after_s.std": "Standard deviation of that time / s",
    "parted_after_s.p5": "Time that 5 % of the parted runs need less than / s",
    "parted_after_s.median": "Median time until a run has parted / s",
    "parted_after_s.p95": "Time that 95 % of the parted runs need less than / s",
}
"""Names of the separation of an ensemble's runs, with units."""


def present_ensemble(ensemble: MechanismEnsemble, file: MechanismFile) -> ResultPresentation:
    """Return the presentation of an ensemble of free motions: statistics, separation, bands over
    time.
    """
    result = ensemble.result
    title = f"{result.runs} motions of {file.name} until {result.until_s:g} s"
    return _present(
        describe_file(file),
        title,
        result,
        _list_ensemble_sections(ensemble),
        conclusion=_conclude_ensemble(result),
        figures=lambda: dict(drawing.draw_ensemble(ensemble)),
        tables=lambda: _tabulate_ensemble(ensemble),
    )


def _conclude_ensemble(result: EnsembleResult) -> str:
    separation = result.separation
    parted = (
        f"{separation.parted_runs} of {result.runs} runs part from the motion of the stated start "
        f"by more than "
        f"{separation.threshold:.0%} of the ranges of its states"
    )
    after = (
        ""
        if separation.parted_after_s is None
        else f", after {separation.parted_after_s.median:.4g} s (median)"
    )
    exponent = separation.lyapunov_per_s
    if exponent is None:
        growth = "The output times are too far apart for the largest Lyapunov exponent: take more."
    else:
        error = "" if exponent.error is None else f" ± {exponent.error:.1g}"
        growth = f"The largest Lyapunov exponent is {exponent.value:.3g}{error} 1/s."
    return f"{parted}{after}. {growth}"


def _list_start_changes(changes: Sequence[ChangedStart]) -> Iterator[Section]:
    if changes:
        rows = [
            (format_name(value.quantity), value.stated, value.used, value.unit) for value in changes
        ]
        table = Table(("quantity", "stated", "used", "unit"), rows)
        yield Section("Start", [Text(CHANGED_START, "warning"), table])


def _list_ensemble_sections(ensemble: MechanismEnsemble) -> Iterator[Section]:
    result, meanings = ensemble.result, ensemble.meanings
    for name in ("range", "variance", "peak"):
        rows = [
            (
                format_name(key),
                meanings[key],
                value.mean,
                value.mean_error,
                value.std,
                value.p5,
                value.median,
                value.p95,
                _square_unit(q.unit) if name == "variance" else q.unit,
            )
            for key, q in result.quantities.items()
            for value in [getattr(q, name)]
        ]
        head = ("quantity", tables.MEANING, "mean", "error", "std", "5 %", "median", "95 %", "unit")
        yield Section(
            f"{name.capitalize()} of a period", [Table(head, rows, page_columns=(tables.MEANING,))]
        )
    separation = result.separation
    values: dict[str, Cell] = {
        "runs": result.runs,
        "parted_runs": separation.parted_runs,
        "last_median": separation.last_median,
        "threshold": separation.threshold,
    }
    if exponent := separation.lyapunov_per_s:
        values |= {"lyapunov_per_s": exponent.value, "lyapunov_per_s.error": exponent.error}
    if after := separation.parted_after_s:
        values |= {f"parted_after_s.{key}": value for key, value in after.table().items()}
    yield Section("Separation", [tabulate_named(values, SEPARATION_NAMES)])
    yield from _list_start_changes(result.changed_start)


def _square_unit(unit: str) -> str:
    return f"{unit}2" if unit.isalpha() else unit and f"({unit})2"


def _tabulate_ensemble(ensemble: MechanismEnsemble) -> Mapping[str, Mapping[str, Array]]:
    """Return the bands over time with the median separation, and the statistics of each period of
    each run.
    """
    from planter.mechanism.ensemble import QUANTILES  # free motions alone need its solvers

    bands = {
        f"p{share}_{key}": line
        for key, band in ensemble.bands.items()
        for share, line in zip(QUANTILES, band, strict=True)
    }
    runs, periods = ensemble.result.runs, ensemble.result.periods
    pieces = {
        f"{name}_{key}{'_squared' if name == 'variance' else ''}": values.ravel()
        for key, statistics in ensemble.pieces.items()
        for name, values in statistics.items()
    }
    separation = {"median_separation": np.median(ensemble.separation, axis=0)}
    numbers = {
        "run": np.repeat(np.arange(runs), periods),
        "period": np.tile(np.arange(periods), runs),
    }
    return {
        "values.csv": {"time_s": ensemble.times, **separation, **bands},
        "runs.csv": {**numbers, **pieces},
    }


def present_validation(
    result: MachineValidation, source: str, machine: Machine | None = None
) -> ResultPresentation:
    """Return the presentation of a valid file: its limits and warnings."""
    design = f"; design values {', '.join(result.design)}" if result.design else ""
    sections = [
        *(() if machine is None else find_extension(machine).list_sections(result)),
        *list_limit_sections(result.holds or ()),
        *list_own_sections(result.own_numbers),
    ]
    return ResultPresentation(
        f"{source}: valid{design}", result, [*sections, *list_warning_sections(result.warnings)]
    )


def list_own_sections(own_numbers: Sequence[str]) -> list[Section]:
    """Return a section of the numbers whose origin is the file, not that of its [origin], or an
    empty list.
    """
    reason = (
        "They differ from those that the entries of [origin] were written for; their origin "
        "is this file"
    )
    text = f"{reason}: {', '.join(own_numbers)}."
    return [Section("Numbers of this file", [Text(text)])] if own_numbers else []


def format_optimum_file(optimum: MechanismOptimum) -> str:
    """Return the machine's file (TOML) with the optimum's values; comments state the values
    before.
    """
    result = optimum.result
    limits = "; ".join(limit.limit_on for limit in result.holds)
    head = [
        f"{optimum.machine.name} with least {result.least}{f' under {limits}' if limits else ''}.",
        f"By planter {__version__}.",
        f"Reached {result.objective!r}, before {result.start_objective!r}.",
    ]
    origin = f"optimised (least {result.least})"
    before = dict(zip(optimum.machine.moved_paths, result.start_design.values(), strict=True))
    return format_design_file(
        optimum.machine.document, before, head, origin, optimum.goal, result.samples
    )


def write_unfinished(out: Path, unfinished: UnfinishedOptimum) -> None:
    """Write what a search has without a result (yet): its machine file, and summary.json, which
    says so.

    The file is optimum.toml, or closest.toml while no design satisfies the limits.
    """
    machine, candidate, folder = unfinished.machine, unfinished.candidate, files.output_folder(out)
    if candidate.is_feasible:
        name, title, origin = (
            OPTIMUM_FILE,
            "the best design",
            f"optimised (least {unfinished.sum_text}, unfinished)",
        )
    else:
        name, title, origin = (
            CLOSEST_FILE,
            "the design closest to satisfying its limits",
            "optimised (closest design)",
        )
    head = [
        f"{machine.name}: {title} of a search for the least {unfinished.sum_text} that has no "
        f"result (yet).",
        f"By planter {__version__}, after {candidate.seconds:.4g} s.",
    ]
    before = dict(zip(machine.moved_paths, unfinished.start_design.values(), strict=True))
    text = format_design_file(machine.document, before, head, origin, unfinished.goal)
    write_file(folder / name, text.encode())
    basis = describe_basis(None, machine.document, files.list_provenance(machine.document))
    files.write_summary(folder / "summary.json", {**unfinished.table(), "finished": False, **basis})
    if candidate.is_feasible:
        drop_file(folder / CLOSEST_FILE)


def _enter_goal(
    document: Document, table: dict[str, Any], goal: StatedGoal, samples: int | None
) -> None:
    """Enter the sum and the limits of a call, and the samples of its search, into the table of a
    document, if files of its kind may have them.
    """
    if not document.states_goals:
        return
    if goal.sum_text:
        table["objective"] = {**(table.get("objective") or {}), "least": goal.sum_text}
    if samples is not None and "least" in (table.get("objective") or {}):
        table["objective"]["samples"] = samples
    if goal.holds:
        table["requirements"] = {**(table.get("requirements") or {}), "hold": list(goal.holds)}


def format_design_file(
    document: Document,
    before: Mapping[str, float],
    head: Sequence[str],
    origin: str,
    goal: StatedGoal | None = None,
    samples: int | None = None,
) -> str:
    """Return the file (TOML) of a document with the values of a search, by path, that it had
    `before`, and with the goal of the search over `samples` of a cycle, if there are any; comments
    have lines `head`, and these values.
    """
    numbers, table = document.numbers(), document.written_table()
    if goal is not None:
        _enter_goal(document, table, goal, samples)
    moved = [path for path, value in before.items() if numbers[path] != value]
    notes = {path: f"was {before[path]!r} {units.display_unit(path)}".rstrip() for path in moved}
    stated = dict.fromkeys((path for path in document.changed if path not in before), SET_ORIGIN)
    table["origin"] = document.origins | stated | dict.fromkeys(moved, origin)
    order = dict(sorted(table.items(), key=lambda pair: isinstance(pair[1], dict)))
    return "\n".join([*(f"# {line}" for line in head), "", *format_lines(order, notes)]) + "\n"


def _describe_machine(machine: Machine) -> tuple[Document, ModelAssumptions]:
    text = machine.documentation
    title = ", from ".join(filter(None, (text.title or machine.name, text.reference)))
    return machine.document, ModelAssumptions(title, machine.assumptions, machine.meanings, False)


def describe_file(file: MechanismFile) -> tuple[Document, ModelAssumptions]:
    """Return the file with the assumptions of its model and the meanings of its numbers."""
    sidecar, meanings = (
        file.model.sidecar,
        {entry["shown"]: entry["meaning"] for entry in file.entries},
    )
    title = f"{sidecar['title']}, from {sidecar['source']}"
    return file, ModelAssumptions(title, sidecar["assumptions"], meanings, False)


def _present(
    described: tuple[Document, ModelAssumptions],
    title: str,
    result: Record,
    sections: Iterable[Section],
    **parts: Any,
) -> ResultPresentation:
    document, model = described
    comments = list(files.list_comments(document, "mechanism"))
    return ResultPresentation(
        title, result, list(sections), document=document, model=model, comments=comments, **parts
    )


def _draw_cycle(
    title: str, find_cycle: Callable[[], MechanismCycle], measured: SensorSignal | None = None
) -> dict[str, Any]:
    """Return figures, table and moving scene of a cycle, which is computed only if a folder is
    written.
    """

    def animate() -> Iterator[MotionBlock]:
        cycle = find_cycle()
        yield from find_extension(cycle.machine).animate()
        if cycle.places:
            yield MotionBlock(drawing.build_cycle_scene(title, cycle), MOTION_CAPTION)

    return _draw_quantities(
        lambda: (PlotAxis.from_cycle(find_cycle()), find_cycle().columns),
        animate,
        measured,
        lambda: find_extension(find_cycle().machine).draw_figures(),
    )


def _draw_motion(
    title: str, find_motion: Callable[[], MechanismMotion], file: MechanismFile
) -> dict[str, Any]:
    """Return figures, table and moving scene of a free motion of a file's mechanism, which is
    computed only if a folder is written.
    """

    def animate() -> Iterator[MotionBlock]:
        yield MotionBlock(drawing.build_motion_scene(title, find_motion(), file), MOTION_CAPTION)

    return _draw_quantities(
        lambda: (PlotAxis.from_motion(find_motion()), find_motion().columns), animate
    )


def _draw_quantities(
    find_curves: Callable[[], tuple[PlotAxis, Mapping[str, Array]]],
    animate: Callable[[], Iterable[MotionBlock]],
    measured: SensorSignal | None = None,
    draw_first: Callable[[], Mapping[str, Figure]] = dict,
) -> dict[str, Any]:
    """Return figures, table and moving scene of quantities (n,) by key over an axis, and of what a
    sensor sees; `draw_first` makes figures that come before these.
    """

    def draw() -> dict[str, Figure]:
        axis, columns = find_curves()
        return {
            **draw_first(),
            **draw_signals(measured, axis.label, axis.end),
            **dict(drawing.draw_curves(columns, axis)),
        }

    def tabulate() -> Mapping[str, Mapping[str, Array]]:
        axis, columns = find_curves()
        table = {axis.column: axis.values, **columns}
        return {"values.csv": table | ({} if measured is None else measured.column)}

    return {"figures": draw, "tables": tabulate, "motions": animate}


def _list_cycle_sections(cycle: MechanismCycle) -> Iterator[Section]:
    result = cycle.result
    yield from list_warning_sections(result.warnings)
    if result.at:
        angle = f"{cycle.machine.angle}_deg"
        yield Section("At single angles", [tabulate_angles(result.at, angle)])
    if result.designer is not None:
        blocks = find_extension(cycle.machine).list_summary_blocks(result.designer)
        yield Section("Designer's summary", [*blocks, Text(ONE_SIDED, "note")])
    meanings = {quantity.key: quantity.meaning for quantity in cycle.machine.results}
    head = ("quantity", tables.MEANING, "min", "at / deg", "max", "at / deg", "mean", "rms", "unit")
    rows = [
        (
            format_name(key),
            meanings[key],
            q.min,
            q.min_deg,
            q.max,
            q.max_deg,
            tables.round_mean(q.mean, q.rms),
            q.rms,
            format_unit(q),
        )
        for key, q in result.quantities.items()
    ]
    table = Table(head, rows, page_columns=(tables.MEANING,))
    yield Section("Quantities", [table], detail=result.designer is not None)
    if result.work:
        yield Section("Work of a cycle", [list_values(result.work)], detail=True)
    if result.laws:
        laws = [(law.law, float(f"{law.violation:.2g}"), law.unit) for law in result.laws]
        table = Table(("law", "largest violation", "unit"), laws)
        yield Section("Laws", [table], detail=True)


def _list_motion_sections(motion: MechanismMotion) -> Iterator[Section]:
    result = motion.result
    head = ("quantity", tables.MEANING, "min", "max", "last", "unit")
    rows = [
        (format_name(key), motion.meanings[key], q.min, q.max, q.last, format_unit(q))
        for key, q in result.quantities.items()
    ]
    yield Section("Quantities", [Table(head, rows, page_columns=(tables.MEANING,))])
    yield from _list_start_changes(result.changed_start)
    if result.events:
        yield Section(
            "Events",
            [
                Table(
                    ("event", "rises", "falls", "first / s", "last / s"),
                    list(_count_events(result)),
                )
            ],
        )
    yield Section("Energy of weights, springs and motion", [list_values(result.energy.table())])
    if sentences := list(_describe_constraints(motion)):
        yield Section("Constraints", [Items(sentences)])
    if result.equilibrium is not None and result.eigenvalues_per_s is not None:
        values = Table(("real / 1/s", "imaginary / 1/s"), result.eigenvalues_per_s, "Eigenvalues")
        yield Section("Equilibrium", [list_values(result.equilibrium), values])


def _count_events(result: MotionResult) -> Iterator[tuple[str, int, int, float, float]]:
    """Yield each event of a motion: how often its value rises and falls through zero, and the first
    and last time.
    """
    for name in dict.fromkeys(event.event for event in result.events):
        events = [event for event in result.events if event.event == name]
        rises = sum(event.rising for event in events)
        yield name, rises, len(events) - rises, events[0].time_s, events[-1].time_s


def _describe_constraints(motion: MechanismMotion) -> Iterator[str]:
    result = motion.result
    if result.redundant_constraints:
        names = ", ".join(result.dependent_constraints)
        yield f"{result.redundant_constraints} redundant among the constraints {names}"
    if result.undetermined_actions:
        yield f"Statically indeterminate reactions: {', '.join(result.undetermined_actions)}"


def _list_optimum_sections(result: MechanismOptimumResult) -> Iterator[Section]:
    change = f"{result.start_objective:.6g} to {result.objective:.6g}"
    rows = [
        (format_label(key), result.start_design[key], value) for key, value in result.design.items()
    ]
    table = Table(("quantity", "before", "optimum"), rows)
    yield from list_limit_sections(result.holds)
    yield Section("Optimum", [Text(f"Least {result.least}: {change}."), table])
    certificate = result.certificate
    yield Section(
        "Certificate",
        [
            Keys(
                {
                    "residual of the optimality conditions": certificate.kkt_residual,
                    "agreeing starts": f"{certificate.agreeing_starts} of {certificate.starts}",
                    "active bounds": ", ".join(
                        f"{bound.name} {bound.side}" for bound in certificate.active_bounds
                    )
                    or "none",
                    "samples of the cycle": "none: true extremes and integrals"
                    if result.samples is None
                    else result.samples,
                }
            ),
            *describe_search(result),
        ],
        detail=True,
    )
    sentences = tables.describe_directions(
        result.effective_parameters, len(result.design), result.insensitive
    )
    yield Section("Effective combinations", list(map(Text, sentences)), detail=True)
    if result.front:
        points = [(point.range, point.variance, *point.design.values()) for point in result.front]
        head = ("range", "variance", *map(format_label, result.design))
        yield Section("Pareto front of range and variance", [Table(head, points)])
    if result.proof is not None:
        yield Section("Proof", list(describe_proof(result.proof.table())), detail=True)


def list_cycle_failures(result: MechanismCycleResult) -> list[str]:
    """Return a sentence for each limit that a cycle violates, with the angle of its extreme."""
    peaks = [] if result.designer is None else result.designer.peaks
    extremes = {
        peak.name: ((peak.max, peak.max_phi_deg), (peak.min, peak.min_phi_deg)) for peak in peaks
    }
    return list_limit_failures(result.holds or (), extremes)


Extremes = tuple[tuple[float, float], tuple[float, float]]
"""The largest and the least value of a quantity, each with its angle [deg]."""


def list_limit_failures(
    limits: Sequence[LimitResult], extremes: Mapping[str, Extremes] = MappingProxyType({})
) -> list[str]:
    """Return a sentence for each limit that is violated, with the angle of the extreme that is
    limited, if `extremes` by quantity have it.
    """
    failures = []
    for limit in limits:
        if not limit.met:
            stated = parse_limit(limit.limit_on)
            bounds = (None, limit.limit) if stated.sign > 0 else (limit.limit, None)
            words, angle = str(stated.measure), ""
            if limit.value is not None and stated.measure.kind in ("max", "min", "all"):
                ends = extremes.get(stated.measure.name, ())
                angle = _find_extreme_angle(limit.value, ends)
            failures.append(describe_failure(words, limit.value, bounds, limit.unit, angle))
    return shorten_failures(failures)


def _find_extreme_angle(value: float, ends: Iterable[tuple[float, float]]) -> str:
    """Return the angle of the extreme that has the size of a value, empty if none has."""
    angles = [
        angle
        for extreme, angle in ends
        if abs(abs(extreme) - abs(value)) <= EXTREME_SHARE * abs(value)
    ]
    return f"{angles[0]:.4g} deg" if angles else ""


class _SearchedResult(Protocol):
    """The part of an optimum's result that says how it was searched for."""

    @property
    def objective(self) -> float: ...
    @property
    def certificate(self) -> OptimalityCertificate: ...
    @property
    def searches(self) -> str: ...
    @property
    def wider(self) -> WiderOptimum | None: ...


def describe_search(result: _SearchedResult) -> Iterator[Text]:
    """Yield sentences on what a search has run, and on what wider bounds would bring."""
    if result.searches:
        yield Text(f"Run: {result.searches}.")
    if sentence := describe_wider(result):
        yield Text(sentence)


def describe_wider(result: _SearchedResult) -> str:
    """Return the sentence on the optimum within wider bounds, empty if there is none."""
    wider = result.wider
    if wider is None:
        return ""
    names = {bound.name for bound in result.certificate.active_bounds}
    size = len(wider.design)
    change = wider.objective - result.objective
    share = f" ({100 * change / abs(result.objective):+.3g} %)" if result.objective else ""
    again = f"; {wider.active_bounds} of {size} are at a bound again" if change < 0 else ""
    return (
        f"Active bounds: {len(names)} of {size}; with bounds twice as wide: objective "
        f"{wider.objective:.6g}{share}{again}."
    )


def list_limit_sections(limits: Sequence[LimitResult]) -> Iterator[Section]:
    """Yield the limits on measures with their values, if there are any."""
    if limits:
        columns = ["limit", "value", "bound", "unit", "active", "satisfied"]
        rows = [
            [limit.limit_on, limit.value, limit.limit, limit.unit, limit.active, limit.met]
            for limit in limits
        ]
        if any(limit.price is not None for limit in limits):
            columns.append("price")
            rows = [[*row, limit.price] for row, limit in zip(rows, limits, strict=True)]
        yield Section("Limits", [Table(columns, rows)])


def format_unit(quantity: QuantityStatistics | QuantityHistory) -> str:
    """Return a unit, and the frame of a component if it is not the world's."""
    return quantity.unit if quantity.axes is None else f"{quantity.unit}, axes of {quantity.axes}"
