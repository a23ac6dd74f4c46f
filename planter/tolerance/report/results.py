"""Report folder of `planter tolerance`: summary.json, tolerances.toml, figures and report.html."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter import safe_text
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.folder import renews
from planter.report.html import FigureSvg, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.tolerance.command import ToleranceAnalysis
from planter.tolerance.job import RandomPoints
from planter.tolerance.report import figures
from planter.tolerance.results import RobustFound, ToleranceFound
from planter.tolerance.statistics import rank_shares

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.report.bundle import Drawn as Rendered

MACHINES = 500
"""Number of machines of the bands over a cycle."""
MOST_INPUTS = 10
"""Maximum number of inputs in a table of indices."""


@renews
def write_tolerance(out: Path, analysis: ToleranceAnalysis, progress: Listener | None = None) -> None:
    """Write the folder of an analysis. Raises InputError if it cannot be written."""
    folder, result, machine = files.output_folder(out), analysis.result, analysis.case.resolved.machine
    images = bundle.drawn(dict(_figures(analysis)), progress)
    provenance = files.provenance(machine, result.seed)
    sections = [*_sections(analysis, images), provenance_section(provenance)]
    texts = {
        "summary.json": files.summary_text({**result.table(), "input": machine.table(), "provenance": provenance}),
        "tolerances.toml": format_tolerances(result),
        "report.html": page(f"Tolerances of {result.machine}", sections, machine.description),
    }  # fmt: skip
    bundle.write(folder, texts, images)


def format_tolerances(result: ToleranceFound) -> str:
    """Return the tolerances as a file that `--tolerances` reads."""
    entries = (
        f'"{entry.name}" = {{ from = {entry.low!r}, to = {entry.high!r}, distribution = "{entry.distribution}" }}'
        for entry in result.inputs
    )
    title = f"# Tolerances of {safe_text.sanitise_line(result.machine)}."
    return "\n".join([title, "", "[tolerances]", *entries]) + "\n"


def _figures(analysis: ToleranceAnalysis) -> Iterator[tuple[str, Figure]]:
    case, result = analysis.case, analysis.result
    yield "outputs", figures.draw_distributions(result.outputs, analysis.rows)
    if result.sobol:
        yield "indices", figures.draw_indices(result.sobol)
    keys = [*case.room.curves, *(key for pair in case.room.paths for key in pair)]
    if not keys:
        return
    points = RandomPoints(list(case.spreads.values()), MACHINES, result.seed).block(0, MACHINES)
    subject = case.subject
    cycles, nominal = subject.curves(keys, points), subject.curves(keys, case.centre[None])
    for key in case.room.curves:
        yield f"turn-{key}", figures.draw_cycle(cycles["phi_deg"], key, cycles[key], nominal[key][0])
    for x, y in case.room.paths:
        nominal_path = nominal[x][0], nominal[y][0]
        yield f"path-{x}-{y}", figures.draw_path((x, y), (cycles[x], cycles[y]), nominal_path)


def _sections(analysis: ToleranceAnalysis, images: Mapping[str, Rendered]) -> Iterator[Section]:
    result, resolved = analysis.result, analysis.case.resolved
    bands = [
        (label(name), band.nominal, band.mean, band.mean_error, band.std, band.first_order_std, band.p5, band.p95)
        for name, band in result.outputs.items()
    ]
    head = ("output", "nominal", "mean", "standard error", "std", "first order", "5 %", "95 %")
    yield Section("Bands", [
        Text(f"{result.rows} cycles of machines with random values within the tolerances. Nominal is the machine at "
             "their centre; first order is the standard deviation from its exact gradients.", "note"),
        Table(head, bands), FigureSvg(images["outputs"].svg, "distributions of the outputs"),
    ])  # fmt: skip
    if result.sobol:
        yield Section("Which tolerance matters", [
            Text("Sobol' indices: the share of an output's variance that an input causes by itself (first) and with "
                 f"all others (total). {result.index_rows} cycles; errors are half the 95 % intervals.", "note"),
            FigureSvg(images["indices"].svg, "Sobol' indices"), *_shares(result),
        ])  # fmt: skip
    cycles = [FigureSvg(image.svg, name) for name, image in images.items() if name.startswith(("turn-", "path-"))]
    if cycles:
        yield Section("Over a cycle", [Text(f"Bands of {MACHINES} machines.", "note"), *cycles])
    if result.robust is not None:
        yield Section("Robust design", list(_robust(result.robust)))
    rows = [(x.name, x.distribution, x.low, x.high, x.std, resolved.inputs[x.name]) for x in result.inputs]
    yield Section("Tolerances", [Table(("input", "distribution", "from", "to", "std", "meaning"), rows)])
    yield Section("Inputs", list(inputs(resolved.machine, resolved.inputs)))


def _shares(result: ToleranceFound) -> Iterator[Table]:
    for name, shares in result.sobol.items():
        rows = [
            (path, share.first, share.first_error, share.total, share.total_error)
            for path, share in rank_shares(shares)[:MOST_INPUTS]
            if share.total > 0
        ]
        if rows:
            yield Table(("input", "first", "+-", "total", "+-"), rows, label(name))


def _robust(result: RobustFound) -> Iterator[Any]:
    designs = (result.own, result.best_nominal, result.best_robust)
    head = ("", "own design", "nominal optimum", "robust optimum")
    kinds = {"objective without tolerances": "nominal", "mean": "mean", "standard deviation": "std",
             f"mean + {result.sigmas:g} standard deviations": "robust"}  # fmt: skip
    yield Text(f"The robust optimum has the smallest mean plus {result.sigmas:g} standard deviations of the objective "
               f"over {result.machines} machines, within the file's bounds, each over {result.samples} samples of a "
               "cycle.", "note")  # fmt: skip
    yield Table(head, [(name, *(getattr(scored, key) for scored in designs)) for name, key in kinds.items()])
    yield Table(head, [(label(name), *(scored.design[name] for scored in designs)) for name in result.design])
    yield Keys({"starts": result.starts, "relative projected slope at the optimum": result.residual})
