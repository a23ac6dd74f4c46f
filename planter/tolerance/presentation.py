"""The presentation of `planter tolerance`: bands, Sobol' indices, the robust design and figures."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from planter import safe_text
from planter.files.paths import last_part
from planter.report import files
from planter.report.html import Block, Cell, Keys, Section, Table, Text
from planter.report.labels import format_label
from planter.report.presentation import ResultPresentation
from planter.tolerance import figures
from planter.tolerance.analysis import ToleranceAnalysis
from planter.tolerance.job import RandomPoints
from planter.tolerance.results import RobustFound, ToleranceFound, rank_shares

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MACHINES = 500
"""Number of machines of the bands over a cycle."""
LARGEST, MOST_INPUTS = 3, 10
"""Maximum number of inputs of an output in the common table of indices, and in the table of the output."""


def present_tolerance(analysis: ToleranceAnalysis) -> ResultPresentation:
    """Return the presentation: bands, the inputs that matter most, the robust design, figures and tolerances."""
    result, resolved = analysis.result, analysis.case.resolved
    chosen = "".join(f", {text} {name}" for name, text in result.choices.items())
    return ResultPresentation(
        title=f"Tolerances of {result.machine}{chosen}",
        conclusion=f"{len(result.inputs)} inputs vary over {result.rows} random machines, in {result.seconds:.3g} s.",
        record=result,
        sections=list(_list_sections(result)),
        document=resolved.machine,
        meanings=resolved.inputs,
        figures=lambda: dict(_draw(analysis)),
        captions={"outputs": "Distributions of the outputs.", "indices": "Sobol' indices."}
        | dict.fromkeys(_name_cycles(analysis), f"Bands of {MACHINES} machines."),
        details=partial(_list_details, analysis),
        texts=lambda: {"tolerances.toml": format_tolerances(result)},
        provenance=files.list_provenance(resolved.machine, result.seed),
    )


def format_tolerances(result: ToleranceFound) -> str:
    """Return the tolerances as a file that `--tolerances` reads."""
    entries = (
        f'"{entry.name}" = {{ from = {entry.low!r}, to = {entry.high!r}, distribution = "{entry.distribution}" }}'
        for entry in result.inputs
    )
    title = f"# Tolerances of {safe_text.sanitise_line(result.machine)}."
    return "\n".join([title, "", "[tolerances]", *entries]) + "\n"


def _list_sections(result: ToleranceFound) -> Iterator[Section]:
    bands = [
        (
            format_label(name),
            band.nominal,
            band.mean,
            band.std,
            band.first_order_std,
            band.p5,
            band.p95,
            band.mean_error,
        )
        for name, band in result.outputs.items()
    ]
    head = ("output", "nominal", "mean", "std", "first order", "5 %", "95 %", "standard error")
    note = (
        "Nominal is the machine at the centre of the tolerances; first order is the standard deviation from its exact "
        "gradients."
    )
    yield Section("Bands", [Table(head, bands, page_columns=head[-1:]), Text(note, "note")])
    shares: list[tuple[str, ...]] = [
        ("" if rank else format_label(name), last_part(path), f"{share.first:.3f}", f"{share.total:.3f}",
         f"{share.total_error:.3f}")
        for name, indices in result.sobol.items()
        for rank, (path, share) in enumerate(rank_shares(indices)[:LARGEST])
        if share.total > 0
    ]  # fmt: skip
    if shares:
        note = (
            "Sobol' indices: the share of an output's variance that an input causes by itself (first) and with all "
            f"others (total). {result.index_rows} cycles; errors are half the 95 % intervals."
        )
        yield Section(
            "Largest Sobol' indices", [Table(("output", "input", "first", "total", "+-"), shares), Text(note, "note")]
        )
    if result.robust is not None:
        yield Section("Robust design", list(_describe_robust(result.robust)))


def _describe_robust(result: RobustFound) -> Iterator[Block]:
    designs = (result.own, result.best_nominal, result.best_robust)
    head = ("", "own design", "nominal optimum", "robust optimum")
    attributes = {"without tolerances": "nominal", "mean": "mean", "standard deviation": "std",
                  f"mean + {result.sigmas:g} std": "robust"}  # fmt: skip
    rows = [(name, *(getattr(scored, key) for scored in designs)) for name, key in attributes.items()]
    yield Table(head, rows, f"Objective over {result.machines} machines, {result.samples} samples of a cycle")
    yield Table(
        head, [(format_label(name), *(scored.design[name] for scored in designs)) for name in result.design], "Design"
    )
    yield Text(f"The robust optimum has the smallest mean plus {result.sigmas:g} standard deviations within the bounds "
               "of the file.", "note")  # fmt: skip
    yield Keys({"starts": result.starts, "relative projected slope at the optimum": result.residual})


def _list_details(analysis: ToleranceAnalysis) -> Iterator[Section]:
    """Yield the indices of each output, and the tolerances with their meanings."""
    result, meanings = analysis.result, analysis.case.resolved.inputs
    tables = []
    for name, shares in result.sobol.items():
        rows: list[tuple[Cell, ...]] = [
            (path, share.first, share.first_error, share.total, share.total_error)
            for path, share in rank_shares(shares)[:MOST_INPUTS]
            if share.total > 0
        ]
        tables += [Table(("input", "first", "+-", "total", "+-"), rows, format_label(name))] if rows else []
    if tables:
        yield Section("Sobol' indices of each output", tables)
    entries = [(x.name, x.distribution, x.low, x.high, x.std, meanings[x.name]) for x in result.inputs]
    yield Section("Tolerances", [Table(("input", "distribution", "from", "to", "std", "meaning"), entries)])


def _name_cycles(analysis: ToleranceAnalysis) -> list[str]:
    adapter = analysis.case.adapter
    return [*(f"turn-{key}" for key in adapter.curves), *(f"path-{x}-{y}" for x, y in adapter.paths)]


def _draw(analysis: ToleranceAnalysis) -> Iterator[tuple[str, Figure]]:
    case, result = analysis.case, analysis.result
    yield "outputs", figures.draw_distributions(result.outputs, analysis.rows)
    if result.sobol:
        yield "indices", figures.draw_indices(result.sobol)
    keys = [*case.adapter.curves, *(key for pair in case.adapter.paths for key in pair)]
    if not keys:
        return
    points = RandomPoints(list(case.spreads.values()), MACHINES, result.seed).block(0, MACHINES)
    subject = case.subject
    cycles, nominal = subject.curves(keys, points), subject.curves(keys, case.centre[None])
    for key in case.adapter.curves:
        yield f"turn-{key}", figures.draw_cycle(cycles["phi_deg"], key, cycles[key], nominal[key][0])
    for x, y in case.adapter.paths:
        nominal_path = nominal[x][0], nominal[y][0]
        yield f"path-{x}-{y}", figures.draw_path((x, y), (cycles[x], cycles[y]), nominal_path)
