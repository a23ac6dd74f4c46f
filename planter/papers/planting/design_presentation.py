"""Presentations of a planting device's design: simulated, checked, and optimised."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.engine.outputs import evaluate_many
from planter.engine.solvers.curve_sum import Sampling
from planter.engine.solvers.response import list_breakpoints
from planter.files import units
from planter.measured.sensor_presentation import (
    CAPTION,
    FIGURE,
)
from planter.mechanism.presentation import (
    describe_search,
    format_design_file,
)
from planter.papers.planting.design_results import (
    DesignersSummary,
    compare_peaks,
    describe_design,
    list_design_tables,
    list_tooth_count_blocks,
)
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.functions import MODELS
from planter.papers.planting.model import Device
from planter.papers.planting.objective import find_curve_angles
from planter.papers.planting.report import figures
from planter.papers.planting.report.forces import draw_support_force
from planter.papers.planting.results import (
    Lifted,
    OptimisationFound,
    RequirementResult,
)
from planter.papers.planting.toothed import locate_pitch_curves
from planter.report import files
from planter.report.animation import MotionBlock
from planter.report.folder import CLOSEST_FILE, OPTIMUM_FILE, drop_file, write_file
from planter.report.html import (
    Block,
    Cell,
    Folded,
    KeyFigure,
    Keys,
    MarkupCell,
    Section,
    Table,
    Text,
    escape_markup,
)
from planter.report.labels import count_things, format_label, load_names
from planter.report.presentation import (
    ModelAssumptions,
    ResultPresentation,
    describe_basis,
    describe_failure,
    describe_proof,
    list_proof_files,
    shorten_failures,
)
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.engine.solvers.result import OptimalityCertificate
    from planter.files.record import Record
    from planter.kernels import Array
    from planter.papers.planting.optimisation import Optimisation

CAPTIONS = {
    "support_force": "Vertical force of the frame on sun and carrier over a cycle. Ticks below: angles at which a "
    "gear's pitch curve, the cam or the loaded tooth flank changes from one formula to the next.",
    "tip_path": "Path of the nozzle's tip, side 1, with the nozzle at twelve carrier angles. Its outline is a sketch: "
    "the machine file contains its length only. It opens out of the plane of the drawing.",
    "pitch_curves": (
        "Pitch curves in mesh. P and Q are the pitch points, where the teeth are assumed to touch."
    ),
    "convergence": "Best objective so far against evaluations: of the genetic algorithm (ga), of local searches from "
    "points within the bounds (ipopt), of local searches from the best individuals of the genetic "
    "algorithm (polish).",
    "pareto": "Range against variance of the support force.",
    FIGURE: CAPTION,
}
MEASURES = ("support_range_N", "support_variance_N2")
CLOUD_SIZE = 300
"""Random designs that are drawn beside a front."""
MOTION_CAPTION = (
    "The device over a cycle, both sides, with the path of the tip. The width of the nozzle is a "
    "sketch: the machine "
    "file contains its length only; its halves, which the cam opens, are drawn separately, seen "
    "from the front."
)
FORCE = "Vertical support force"
TRUE = "true"
FORCE_ROWS = {
    "max_N": ("largest", "N"),
    "min_N": ("least", "N"),
    "range_N": ("range", "N"),
    "mean_N": ("mean", "N"),
    "variance_N2": ("variance", "N2"),
    "objective": ("objective (31)", ""),
}
SCORES = ("objective", "range_N", "variance_N2")
"""Keys of `FORCE_ROWS` that designs are compared by."""
BOUNDS = ("lower", "upper", "origin")
"""Columns of a design for which a terminal is too narrow."""
SAMPLES = "objective.samples"
"""Path of the number of samples of a search."""


def present_optimum(optimisation: Optimisation, device: Device) -> ResultPresentation:
    """Return the presentation of an optimum, its certificate, its front, and the machine file of
    it.
    """
    result, optimum = optimisation.result, optimisation.optimum
    x, sampling = optimum.design, optimum.sampling
    samples = device.machine.objective.samples if sampling == "refined" else sampling
    return _present(
        device,
        f"Optimisation of the planting device {result.machine}, {result.model} model, method "
        f"{result.method}",
        result,
        _list_optimum_sections(result, device.machine),
        optimum.seed,
        conclusion=f"{result.statement[0].upper()}{result.statement[1:]}.",
        failures=list_requirement_failures(result.requirements),
        key_figures=list(_list_optimum_figures(result)),
        motions=lambda: [animate(device, x, device.design)],
        figures=lambda: {
            **draw_forces(device, x, device.design),
            **draw_motion(device, x, device.design),
            **_draw_search(device, optimisation),
        },
        tables=lambda: {"cycle.csv": device.columns(x, device.engine.list_angles(samples))},
        comments=_list_comments(device, x, optimum.seed),
        texts=lambda: {
            OPTIMUM_FILE: format_optimum_file(device.machine, device.model, result, sampling),
            **list_proof_files(optimisation.certificate),
        },
    )


def _list_optimum_figures(result: OptimisationFound) -> Iterator[KeyFigure]:
    before, after, requirements = result.start_range_N, result.range_N, result.requirements or ()
    yield KeyFigure(
        _percent(after / before - 1),
        "",
        f"variation of the support force, {before:.3g} to {after:.3g} N",
    )
    torques = result.start_designer.motor.max_Nm, result.designer.motor.max_Nm
    yield KeyFigure(
        _percent(torques[1] / torques[0] - 1),
        "",
        f"largest motor torque, {torques[0]:.3g} to {torques[1]:.3g} N m",
    )
    if requirements:
        met = sum(row.verdict != "fail" for row in requirements)
        yield KeyFigure(f"{met} of {len(requirements)}", "", "requirements met by the optimum")
    else:
        starts = result.certificate
        yield KeyFigure(
            f"{starts.agreeing_starts} of {starts.starts}", "", "starts agree on the optimum"
        )


def _percent(share: float) -> str:
    return f"{100 * share:+.0f} %".replace("-", "\N{MINUS SIGN}")


def write_partial(
    out: Path, device: Device, partial: Mapping[str, Any], interrupted: bool = False
) -> None:
    """Write the best design so far of an unfinished optimisation as a machine file, and
    summary.json, which says so.

    The file is optimum.toml, or closest.toml while no design satisfies the requirements.
    """
    marks = {"finished": False, **({"interrupted": True} if interrupted else {})}
    model = ModelAssumptions.from_sidecar(device.sidecar)
    basis = describe_basis(model, device.machine, files.list_provenance(device.machine))
    folder, is_feasible = files.output_folder(out), partial.get("met", True)
    name = OPTIMUM_FILE if is_feasible else CLOSEST_FILE
    title = (
        "its best design so far"
        if is_feasible
        else "the design closest to satisfying its requirements"
    )
    method = (
        f"unfinished, {device.model} model"
        if is_feasible
        else f"closest design, {device.model} model"
    )
    head = [
        f"The machine {json.dumps(device.machine.name)} with {title}, by planter {__version__}: "
        f"{method}."
    ]
    text = _format_design_file(device.machine, partial["design"], method, head)
    write_file(folder / name, text.encode())
    files.write_summary(folder / "summary.json", {**partial, **marks, **basis})
    if is_feasible:
        drop_file(folder / CLOSEST_FILE)


def _present(
    device: Device,
    title: str,
    result: Record,
    sections: Iterator[Section] | Sequence[Section],
    seed: int | None = None,
    **parts: Any,
) -> ResultPresentation:
    return ResultPresentation(
        title,
        result,
        list(sections),
        document=device.machine,
        model=ModelAssumptions.from_sidecar(device.sidecar),
        displayed_inputs=("design", "bounds"),
        captions=CAPTIONS,
        provenance=files.list_provenance(device.machine, seed),
        **parts,
    )


def _list_comments(device: Device, x: Array, seed: int | None = None) -> list[str]:
    design = ", ".join(f"{name} = {value!r}" for name, value in device.named(x).items())
    return list(
        files.list_comments(
            device.machine, "machine", (f"model: {device.model}", f"design: {design}"), seed
        )
    )


def _list_optimum_sections(
    result: OptimisationFound, machine: PlantingMachine
) -> Iterator[Section]:
    yield from list_requirement_sections(result.requirements)
    yield Section(FORCE, [_tabulate_optimised_force(result)])
    yield tabulate_design(machine, result)
    details = Folded(
        "torques, forces, gears and shocks of the optimum",
        list(describe_designer(result.designer)),
    )
    peaks = compare_peaks(result.start_designer, result.designer)
    yield Section("Designer's summary", [peaks, details], detail=True)
    if result.teeth is not None:
        yield Section("Integer tooth numbers", list(list_tooth_count_blocks(result.teeth)))
    scores = [
        (f"{model} model", score.start, score.optimum) for model, score in result.cross.items()
    ]
    table = Table(("design", "machine file", "optimum"), scores)
    yield Section("Objective of both designs in both models", [table], detail=True)
    if result.front:
        yield Section("Pareto front of range and variance", [_tabulate_front(result)])
    directions = list(_describe_insensitive_directions(result))
    yield Section("Insensitive directions", directions, detail=True)
    yield Section("Certificate", list(_describe_certificate(result)), detail=True)
    if result.proof is not None:
        yield Section("Proof", list(describe_proof(result.proof.table())), detail=True)


def _tabulate_optimised_force(result: OptimisationFound) -> Table:
    """Return the force before and after as the search evaluated it, and the optimum's as evaluated
    otherwise.
    """
    searched = name_sampling(result.samples)
    start = {key: getattr(result, f"start_{key}") for key in SCORES}
    columns = {
        f"start, {searched}": start,
        f"optimum, {searched}": {key: getattr(result, key) for key in SCORES},
    }
    kinds = {
        TRUE: result.refined.table(),
        name_sampling(result.sampled.samples): result.sampled.table(),
    }
    columns |= {f"optimum, {kind}": values for kind, values in kinds.items() if kind != searched}
    return tabulate_force(columns, SCORES)


def name_sampling(samples: int | str) -> str:
    """Return the name of the kind of extremes and integrals."""
    return TRUE if samples == "refined" else f"{samples} samples"


def tabulate_force(
    columns: Mapping[str, Mapping[str, float]],
    keys: Sequence[str],
    more: Sequence[Sequence[Cell]] = (),
) -> Table:
    """Return the measures of the support force under `keys`, a column for each kind."""
    rows = [
        (FORCE_ROWS[key][0], *(values.get(key) for values in columns.values()), FORCE_ROWS[key][1])
        for key in keys
    ]
    return Table(("", *columns, "unit"), [*rows, *more])


def tabulate_design(machine: PlantingMachine, optimum: OptimisationFound | None = None) -> Section:
    """Return the machine's own design with its bounds, and the optimum with what limits each
    parameter.
    """
    start = machine.design
    values, notes = [start], dict.fromkeys(start, "")
    if optimum is not None:
        values = [optimum.start_design, optimum.design]
        notes |= {
            bound.name: f"at its {bound.side} bound" for bound in optimum.certificate.active_bounds
        }
        single = (direction[0] for direction in optimum.insensitive if len(direction) == 1)
        notes |= {name: "no effect" for weights in single for name in weights}
    head = ("value",) if optimum is None else ("start", "optimum")
    note = () if optimum is None else ("",)
    rows: list[tuple[Cell, ...]] = [
        (
            name,
            *(design[name] for design in values),
            units.display_unit(name),
            *(notes[name] for _ in note),
            *machine.bounds[name],
            machine.origin(f"design.{name}"),
        )
        for name in start
    ]
    table = Table(("parameter", *head, "unit", *note, *BOUNDS), rows, page_columns=BOUNDS)
    return Section("Design", [table], detail=optimum is None)


def describe_designer(summary: DesignersSummary) -> Iterator[Block]:
    """Yield tables and sentences of the designer's summary."""
    yield from list_design_tables(summary)
    yield from map(Text, describe_design(summary))
    yield Text(
        "Angles are those of the carrier for side 1; side 2 follows half a revolution later.",
        "note",
    )


def tabulate_assumption_effects(effects: Sequence[Lifted]) -> Table:
    """Return the largest joint forces as modelled, and by how much they change if an assumption is
    relaxed.
    """
    modelled: tuple[Cell, ...] = (
        "as modelled, largest",
        *effects[0].as_modelled_N.values(),
        None,
        None,
    )
    rows: list[tuple[Cell, ...]] = [
        (effect.assumption, *effect.joints_N.values(), effect.support_N, effect.friction_work_J)
        for effect in effects
    ]
    head = ("forces / N", *effects[0].joints_N, "support", "friction work / J")
    return Table(
        head, [modelled, *rows], "Largest change of forces as assumptions are relaxed one by one"
    )


REQUIREMENT_HEAD = (
    "requirement",
    "value",
    "min",
    "max",
    "unit",
    "margin",
    "needed",
    "phi / deg",
    "",
    "origin",
)


def list_requirement_sections(
    requirements: Sequence[RequirementResult] | None,
) -> Iterator[Section]:
    """Yield the requirements with their limits, margins and verdicts, if there are any."""
    rows: list[tuple[Cell, ...]] = [
        (
            _name_requirement(row),
            _round(row.value),
            row.lower,
            row.upper,
            row.unit,
            _round(row.margin),
            row.wanted_margin,
            _round(row.phi_deg),
            row.verdict,
            row.origin,
        )
        for row in requirements or ()
    ]
    if rows:
        yield Section(
            "Requirements", [Table(REQUIREMENT_HEAD, rows, page_columns=REQUIREMENT_HEAD[-1:])]
        )


def list_requirement_failures(requirements: Sequence[RequirementResult] | None) -> list[str]:
    """Return a sentence for each requirement that fails, with its value and carrier angle."""
    failures = []
    for row in requirements or ():
        if row.verdict == "fail":
            entry = load_names("planter.papers.planting").find(row.name)
            name = entry.name if entry else row.name
            angle = "" if row.phi_deg is None else f"{row.phi_deg:.4g} deg"
            limits = row.lower, row.upper
            failures.append(describe_failure(name, row.value, limits, row.unit, angle))
    return shorten_failures(failures)


def _name_requirement(row: RequirementResult) -> MarkupCell:
    """Return the key of a requirement, in whose place a page has its name and meaning."""
    entry = load_names("planter.papers.planting").find(row.name)
    name = entry.name if entry else row.name
    return MarkupCell(
        row.name, f"{escape_markup(name)} <small>{escape_markup(row.meaning)}</small>"
    )


def _round(value: float | None) -> float | None:
    """Return a number with four digits, for a narrow column."""
    return None if value is None else float(f"{value:.4g}")


def _tabulate_front(result: OptimisationFound) -> Table:
    names = [format_label(name) for name in result.start_design]
    rows: list[tuple[Cell, ...]] = [
        (point.range_N, point.variance_N2, *point.design.values()) for point in result.front or ()
    ]
    return Table(("range / N", "variance / N2", *names), rows, page_columns=names)


def _describe_insensitive_directions(result: OptimisationFound) -> Iterator[Block]:
    yield Text(
        f"The support force depends on {count_things(result.effective_parameters, 'combination')} "
        f"of the {len(result.design)} parameters."
    )
    if result.insensitive:
        yield Text(
            "It does not change if these parameters change together, in parts of the widths of "
            "their bounds:"
        )
    for direction in result.insensitive:
        yield Table(
            ("parameter", "weight"), [pair for weights in direction for pair in weights.items()]
        )


def _describe_certificate(result: OptimisationFound) -> Iterator[Block]:
    certificate, counts = result.certificate, result.evaluations
    yield Keys(
        {
            "KKT residual": certificate.kkt_residual,
            "local searches": certificate.starts,
            "local searches that ended at the optimum": certificate.agreeing_starts,
            "spread of their objectives": certificate.spread,
            "evaluations: objective": counts.objective,
            "evaluations: gradient": counts.gradient,
            "evaluations: Hessian": counts.hessian,
            "seconds": result.seconds,
        }
    )
    yield from describe_search(result)
    yield Text(
        "The KKT residual is zero at an exact local optimum. The spread is the largest less the "
        "least objective at "
        "which a local search ended. Neither proves that there is no better design elsewhere.",
        "note",
    )
    if multipliers := _list_multipliers(certificate):
        table = Table(("", "side", "multiplier", "per"), multipliers)
        yield Folded("active bounds and requirements, with what relaxing them would gain", [table])


def _list_multipliers(certificate: OptimalityCertificate) -> list[tuple[Cell, ...]]:
    bounds = [
        (bound.name, bound.side, bound.multiplier, "width of its bounds")
        for bound in certificate.active_bounds
    ]
    active = certificate.active_constraints
    return [*bounds, *((row.name, row.side, row.multiplier, row.unit) for row in active)]


def format_optimum_file(
    machine: PlantingMachine, model: str, result: OptimisationFound, sampling: Sampling
) -> str:
    """Return a machine file (TOML) with an optimum of `machine` as its design.

    Its objective is that of the optimum: the file contains the number of samples of the search, if
    it had one.
    """
    method = f"{model} model, {result.method}, seed {result.seed}, " + (
        "true extremes and integrals" if sampling == "refined" else f"{sampling} samples"
    )
    head = [
        f"The machine {json.dumps(machine.name)} with its design optimised by planter "
        f"{__version__}: {method}.",
        f"Objective {result.objective!r}, before {result.start_objective!r}. Comments give the "
        f"values before.",
    ]
    if result.teeth is not None:
        stages = (
            f"stage {stage.stage} has {stage.z} teeth of {stage.module_mm:.12g} mm"
            for stage in result.teeth.stages
        )
        head.append(f"Integer tooth numbers: {', '.join(stages)}.")
    return _format_design_file(machine, result.design, method, head, sampling)


def _format_design_file(
    machine: PlantingMachine,
    design: Mapping[str, float],
    method: str,
    head: Sequence[str],
    sampling: Sampling = "refined",
) -> str:
    """Return a machine file (TOML) with another design; `method` says how it was found, `head` are
    comments.
    """
    usual = ("refined", machine.objective.samples)
    searched = machine.with_numbers({} if sampling in usual else {SAMPLES: float(sampling)})
    values = {}
    for name, value in design.items():
        lower, upper = machine.bounds[name]
        values[f"design.{name}"] = min(max(float(f"{value:.15g}"), lower), upper)
    before = {path: machine.numbers()[path] for path in values}
    return format_design_file(searched.with_numbers(values), before, head, f"optimised ({method})")


def animate(device: Device, x: Array, start: Array | None = None) -> MotionBlock:
    """Return the moving drawing of a design x (p,) [SI], with the path of the tip before it."""
    from planter.papers.planting.report.scene import (
        build_scene,  # with teeth, which few results need
    )

    dashed = "" if start is None else " Dashed: the path before the optimisation."
    return MotionBlock(build_scene(device, x, start), f"{MOTION_CAPTION}{dashed}")


def draw_forces(device: Device, x: Array, start: Array | None = None) -> dict[str, Figure]:
    """Draw the support force of a design x (p,) [SI] in both models, and that of a design before
    it.
    """
    models: dict[str, Device] = {
        m: device if m == device.model else Device(device.machine, m) for m in MODELS
    }
    curves = {model: _compute_support(each, x) for model, each in models.items()}
    before = {}
    if start is not None:
        before = {model: _compute_support(each, start) for model, each in models.items()}
    breakpoints = _find_breakpoints(models["exact"], x)
    figure = draw_support_force(curves, device.weight, breakpoints, before)
    return {"support_force": figure}


def draw_motion(device: Device, x: Array, start: Array | None = None) -> dict[str, Figure]:
    """Draw the path of the tip and the pitch curves of a design x (p,) [SI], and of one before it."""
    phi = device.engine.list_angles(device.machine.objective.samples)
    columns = device.columns(x, phi)
    columns_before = None if start is None else device.columns(start, phi)
    required = device.machine.requirements
    soil_mm = None if required is None else required.surface_mm(float(columns["tip_y_mm"].min()))
    points_mm = [] if required is None else required.points_mm or []
    curves = locate_pitch_curves(device, x)
    curves_before = None if start is None else locate_pitch_curves(device, start)
    return {
        "tip_path": figures.draw_tip_path(columns, columns_before, soil_mm, points_mm),
        "pitch_curves": figures.draw_pitch_curves(curves, curves_before),
    }


def _draw_search(device: Device, optimisation: Optimisation) -> dict[str, Figure]:
    """Draw the best objective over the search, and the front beside random designs."""
    plots = {"convergence": figures.draw_convergence(optimisation.optimum.history)}
    result = optimisation.result
    if not result.front:
        return plots
    shares = np.random.default_rng(optimisation.optimum.seed).random((CLOUD_SIZE, device.size))
    designs = device.lower + shares * (device.upper - device.lower)
    cloud = evaluate_many(device, designs, device.machine.objective.samples, outputs=MEASURES)
    marks = {
        "machine file": (result.start_range_N, result.start_variance_N2),
        "optimum": (result.range_N, result.variance_N2),
    }
    points = [(point.range_N, point.variance_N2) for point in result.front]
    points += map(tuple, cloud.values.tolist())
    weights = device.machine.objective
    line = (weights.weight_range, weights.weight_variance) if weights.kind == "paper" else None
    front = figures.draw_pareto(np.array([*points, *marks.values()]), marks, line)
    return plots | {"pareto": front}


def _compute_support(device: Device, x: Array) -> tuple[Array, Array]:
    """Return carrier angles [deg] and the support force there [N], (n,) each."""
    phi = find_curve_angles(device, x)
    return np.degrees(phi), device.support(device.prologue(x), phi)


def _find_breakpoints(device: Device, x: Array) -> dict[str, list[float]]:
    """Return the carrier angles [deg] of both sides' breakpoints by name, in the order of the
    model's events.
    """
    angles_deg: dict[str, list[float]] = {event["name"]: [] for event in device.sidecar["events"]}
    for breakpoint_ in list_breakpoints(device.force, device.prologue(x)):
        angles_deg[breakpoint_.name].append(float(np.degrees(breakpoint_.angle)))
    return {name: angles for name, angles in angles_deg.items() if angles}
