"""Results of planting devices as tables for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from planter import safe_text
from planter.files import units
from planter.planting import design_results
from planter.planting.tooth_count_results import list_tooth_count_blocks
from planter.report.html import Section, Table
from planter.report.presentation import print_section, print_sentence
from planter.terminal.console import Console

if TYPE_CHECKING:
    from planter.planting.design_results import DesignersSummary
    from planter.planting.results import (
        CalibrationFound,
        DeviceState,
        ModelFitted,
        OptimisationFound,
        PlantingWarning,
        RequirementResult,
        SimulationFound,
        Validation,
    )

TITLE = "Vertical support force"
TRUE = "true"
KEYS = (
    "objective", "samples", "support_force", "refined", "sampled", "range_N", "variance_N2", "start_objective",
    "start_range_N", "start_variance_N2",
)  # fmt: skip
"""What of a result stands in the table."""
ROWS = {"max_N": ("largest", "N"), "min_N": ("least", "N"), "range_N": ("range", "N"), "mean_N": ("mean", "N"),
        "variance_N2": ("variance", "N2"), "objective": ("objective (31)", "")}  # fmt: skip

SCORES = ("objective", "range_N", "variance_N2")
"""What designs are compared by."""


def tabulate_simulated_force(result: Mapping[str, Any]) -> Table:
    """The force of a machine's own design: its true extremes and integrals beside those of the samples."""
    sampled = {**result["support_force"], "objective": result["objective"]}
    return _tabulate_force({TRUE: result["refined"], _name_kind(result["samples"]): sampled})


def tabulate_optimised_force(result: Mapping[str, Any]) -> Table:
    """The force before and after, in the kind that was optimised, and the optimum's in the others."""
    searched, start = _name_kind(result["samples"]), {key: result[f"start_{key}"] for key in SCORES}
    columns = {f"start, {searched}": start, f"optimum, {searched}": {key: result[key] for key in SCORES}}
    other_kinds = {TRUE: result["refined"], _name_kind(result["sampled"]["samples"]): result["sampled"]}
    return _tabulate_force(
        columns | {f"optimum, {kind}": values for kind, values in other_kinds.items() if kind != searched}, SCORES
    )


def _name_kind(samples: int | str) -> str:
    return TRUE if samples == "refined" else f"{samples} samples"


def _tabulate_force(columns: Mapping[str, Mapping[str, float]], keys: tuple[str, ...] = tuple(ROWS)) -> Table:
    rows = [(ROWS[key][0], *(values.get(key) for values in columns.values()), ROWS[key][1]) for key in keys]
    return Table(("", *columns, "unit"), rows, TITLE)


def print_design(console: Console, values: Mapping[str, float], title: str = "Design") -> None:
    console.table(title, ("parameter", "value", "unit"), ((n, v, units.unit(n)) for n, v in values.items()))


def print_simulation(console: Console, result: SimulationFound) -> None:
    """Support force, work, warnings, single angles."""
    print(f"{result.machine}, {result.model} model\n")
    print_design(console, result.design)
    force = tabulate_simulated_force(result.table())
    console.table(force.caption, force.head, [*force.rows, ("weight", result.weight_N, None, "N")])
    work = (("input", result.work.input_J), ("friction", result.work.friction_J))
    console.table("Work over a turn", ("", "J"), work)
    if result.at:
        _at(console, result.at)
    if result.lifted:
        effects = tabulate_assumption_effects([effect.table() for effect in result.lifted])
        console.table(effects.caption, effects.head, effects.rows)
    _designer(console, result.designer)
    print_requirements(console, result.requirements)
    print_warnings(console, result.warnings)


def _designer(console: Console, summary: DesignersSummary) -> None:
    """Torques, peaks of forces, gears, shocks."""
    for table in design_results.list_design_tables(summary):
        console.table(table.caption, table.head, table.rows)
    for sentence in design_results.describe_design(summary):
        print_sentence(sentence)
    print()


def tabulate_assumption_effects(effects: Sequence[Mapping[str, Any]]) -> Table:
    """Return the largest joint forces as modelled, and by how much they move if an assumption is relaxed."""
    joints = tuple(effects[0]["joints_N"])
    modelled = ("as modelled, largest", *(effects[0]["as_modelled_N"][joint] for joint in joints), None, None)
    rows = [
        (case["assumption"], *(case["joints_N"][joint] for joint in joints), case["support_N"], case["friction_work_J"])
        for case in effects
    ]
    head = ("forces / N", *joints, "support", "friction work / J")
    return Table(head, [modelled, *rows], "Assumptions relaxed one by one: forces move by up to")


def print_validation(console: Console, source: str, result: Validation) -> None:
    """That a file is valid, what its design makes of its requirements, and values that are unusual."""
    print(safe_text.sanitise_line(f"{source}: valid, design parameters {', '.join(result.design)}"))
    print_requirements(console, result.requirements)
    print_warnings(console, result.warnings)


def print_requirements(console: Console, entries: Sequence[RequirementResult] | None) -> None:
    """Requirements with limits and margins, where the machine has any."""
    rows = [
        (r.name, _short(r.value), r.lower, r.upper, r.unit, _short(r.margin), r.wanted_margin, _short(r.phi_deg),
         r.verdict)
        for r in entries or ()
    ]  # fmt: skip
    if rows:
        header = ("requirement", "value", "min", "max", "unit", "margin", "wanted", "phi / deg", "")
        console.table("Requirements", header, rows)


def _short(value: float | None) -> float | None:
    """A number to four digits, to fit a narrow column."""
    return None if value is None else float(f"{value:.4g}")


def _at(console: Console, states: Sequence[DeviceState]) -> None:
    rows = [row.table() for row in states]
    header = ("quantity", *(f"at {row['phi_deg']:g} deg" for row in rows), "unit")
    keys = [key for key in rows[0] if key != "phi_deg"]
    console.table("At single angles", header, ((k, *(row[k] for row in rows), units.unit(k)) for k in keys))


def print_warnings(console: Console, entries: Sequence[PlantingWarning]) -> None:
    if entries:
        rows = ((w.name, w.phi_deg, w.message) for w in entries)
        console.table("Warnings", ("name", "phi / deg", "what"), rows)


def print_optimisation(console: Console, result: OptimisationFound) -> None:
    """Optimum, certificate, both designs in both models."""
    print(f"{result.machine}, {result.model} model, method {result.method}\n")
    print_sentence(f"{result.statement[0].upper()}{result.statement[1:]}.")
    print()
    bounds = {b.name: b.side for b in result.certificate.active_bounds}
    free = {name for direction in result.insensitive if len(direction) == 1 for part in direction for name in part}
    rows = []
    for name, start in result.start_design.items():
        note = "without effect" if name in free else f"at its {bounds[name]} bound" if name in bounds else ""
        rows.append((name, start, result.design[name], units.unit(name), note))
    console.table("Design", ("parameter", "start", "optimum", "unit", ""), rows)
    force = tabulate_optimised_force(result.table())
    console.table(force.caption, force.head, force.rows)
    peaks = design_results.compare_peaks(result.start_designer, result.designer)
    console.table(peaks.caption, peaks.head, peaks.rows)
    print_requirements(console, result.requirements)
    if result.teeth is not None:
        print_section(console, Section("Whole teeth", list(list_tooth_count_blocks(result.teeth))))
    scores = ((model, score.start, score.optimum) for model, score in result.cross.items())
    console.table("Objective of both designs in both models", ("model", "start", "optimum"), scores)
    if result.front:
        front = ((point.range_N, point.variance_N2) for point in result.front)
        console.table("Front of range and variance", ("range / N", "variance / N2"), front)
    print_certificate(console, result)
    if result.proof is not None:
        print(f"{result.proof.statement} ({result.proof.boxes} boxes, {result.proof.seconds:.0f} s)")


def print_certificate(console: Console, result: OptimisationFound) -> None:
    record, counts = result.certificate, result.evaluations
    rows = [
        ("KKT residual", record.kkt_residual),
        ("starts", record.starts),
        ("starts that reached the optimum", record.agreeing_starts),
        ("spread of the starts' objectives", record.spread),
        ("evaluations: objective", counts.objective),
        ("evaluations: gradient", counts.gradient),
        ("evaluations: Hessian", counts.hessian),
        ("seconds", result.seconds),
    ]
    console.table("How sure", ("", "value"), rows)


def print_calibration(console: Console, result: CalibrationFound) -> None:
    """Whether the target is met and by which inputs, then the other model, and what that settles."""
    print(f"{result.machine}: {result.statement}\n")
    _model_fitted(console, result, result.target)
    for model, fit in result.models.items():
        if model != result.model:
            print(fit.statement)
            _model_fitted(console, fit, result.target, inputs=False)
    other = ", ".join(f"{name} {value:.6g}" for name, value in result.other_model.table().items())
    print(f"The other model with the inputs above: {other}.")
    began = ", ".join(f"{name.removesuffix('_deg')} {value:g} deg" for name, value in result.events.items())
    print(f"Flanks begin near the carrier angles that the paper gives (side 1): {began}.")
    ranges = ((words, "none found" if value is None else f"{value:.6g} N") for words, value in (
        ("with the cam only pushing", result.largest_range_N.cam_pushing),
        ("with a free sign", result.largest_range_N.free_sign)))  # fmt: skip
    print(f"Largest range found in the exact model: {', '.join(' '.join(pair) for pair in ranges)}.")


def _model_fitted(console: Console, fit: ModelFitted, target: Mapping[str, float], inputs: bool = True) -> None:
    if inputs:
        rows = ((f.name, f.value, f.unit, f.lower, f.upper) for f in fit.fitted)
        title = f"Fitted (calibrated, not the paper's), {', '.join(fit.choices.values())} flanks"
        console.table(title, ("input", "value", "unit", "lower", "upper"), rows)
    reached = ((name, required, fit.reached[name], fit.miss_percent[name]) for name, required in target.items())
    console.table("Support force", ("", "target", "reached", "miss / %"), reached)
    if fit.front:
        misses = (
            (*tradeoff.choices.values(), *tradeoff.miss_percent.values(), tradeoff.range_N) for tradeoff in fit.front
        )
        head = ("flanks", *(f"{key} missed / %" for key in target), "range / N")
        console.table("The best misses, with a cam that only pushes", head, misses)
    where = f"{fit.distance.rms_share:.2g} widths of their bounds from the machine's own (root mean square)"
    print(f"The target settles {fit.rank} combinations of {len(fit.fitted)} inputs; they lie {where}.")
    if fit.distance.at_bounds:
        print(f"On a bound: {', '.join(fit.distance.at_bounds)}.")
    for message in fit.distance.unusual:
        print(f"Unusual: {message}.")
    print(f"Least force of the cam on the roller: {fit.least_push_N:.4g} N.\n")
