"""What `planter tolerance` writes: summary.json, tolerances.toml, figures and report.html."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter import legible
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.folder import renews
from planter.report.html import FigureSvg, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.tolerance.command import Tolerance
from planter.tolerance.job import Drawn
from planter.tolerance.report import figures
from planter.tolerance.results import RobustFound, ToleranceFound
from planter.tolerance.statistics import ranked

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.report.bundle import Drawn as Rendered

TURNS = 500
"""Machines that bands over a turn rest on."""
SHOWN = 10
"""Inputs in a table of indices."""


@renews
def write(out: Path, found: Tolerance, progress: Listener | None = None) -> None:
    """Writes the folder of a machine's tolerances. Raises InputError for one that it cannot write."""
    folder, result, of = files.output_folder(out), found.result, found.of
    drawn = bundle.drawn(dict(_figures(found)), progress)
    provenance = files.provenance(of.held.machine, result.seed)
    sections = [*_sections(found, drawn), provenance_section(provenance)]
    machine = of.held.machine
    texts = {
        "summary.json": files.summary_text({**result.table(), "input": machine.table(), "provenance": provenance}),
        "tolerances.toml": text(result),
        "report.html": page(f"Tolerances of {result.machine}", sections, machine.description),
    }  # fmt: skip
    bundle.write(folder, texts, drawn)


def text(result: ToleranceFound) -> str:
    """The tolerances as a file that `--tolerances` takes."""
    entries = (
        f'"{one.name}" = {{ from = {one.low!r}, to = {one.high!r}, distribution = "{one.distribution}" }}'
        for one in result.inputs
    )
    return "\n".join([f"# Tolerances of {legible.line(result.machine)}.", "", "[tolerances]", *entries]) + "\n"


def _figures(found: Tolerance) -> Iterator[tuple[str, Figure]]:
    of, result = found.of, found.result
    yield "outputs", figures.distributions(result.outputs, found.rows)
    if result.sobol:
        yield "indices", figures.indices(result.sobol)
    keys = [*of.room.curves, *(key for pair in of.room.paths for key in pair)]
    if not keys:
        return
    points = Drawn(list(of.spreads.values()), TURNS, result.seed).block(0, TURNS)
    turns, nominal = of.subject.curves(keys, points), of.subject.curves(keys, of.centre[None])
    for key in of.room.curves:
        yield f"turn-{key}", figures.turn(turns["phi_deg"], key, turns[key], nominal[key][0])
    for x, y in of.room.paths:
        both, meant = (turns[x], turns[y]), (nominal[x][0], nominal[y][0])
        yield f"path-{x}-{y}", figures.path((x, y), both, meant)


def _sections(found: Tolerance, drawn: Mapping[str, Rendered]) -> Iterator[Section]:
    result, of = found.result, found.of
    bands = [
        (label(name), one.nominal, one.mean, one.mean_error, one.std, one.first_order_std, one.p5, one.p95)
        for name, one in result.outputs.items()
    ]
    head = ("output", "nominal", "mean", "its error", "std", "first order", "5 %", "95 %")
    yield Section("Bands", [
        Text(f"{result.rows} turns of machines that were drawn from the tolerances. Nominal is the machine at their "
             "centre; first order is the standard deviation that its exact gradients give.", "note"),
        Table(head, bands), FigureSvg(drawn["outputs"].svg, "distributions of the outputs"),
    ])  # fmt: skip
    if result.sobol:
        yield Section("Which tolerance matters", [
            Text("Sobol' indices: the share of an output's variance that an input causes by itself (first) and with "
                 f"all others (total). {result.index_rows} turns; errors are half the 95 % intervals.", "note"),
            FigureSvg(drawn["indices"].svg, "Sobol' indices"), *_shares(result),
        ])  # fmt: skip
    over = [FigureSvg(one.svg, name) for name, one in drawn.items() if name.startswith(("turn-", "path-"))]
    if over:
        yield Section("Over a turn", [Text(f"Bands of {TURNS} machines.", "note"), *over])
    if result.robust is not None:
        yield Section("Robust design", list(_robust(result.robust)))
    rows = [(one.name, one.distribution, one.low, one.high, one.std, of.held.inputs[one.name]) for one in result.inputs]
    yield Section("Tolerances", [Table(("input", "distribution", "from", "to", "std", "meaning"), rows)])
    yield Section("Inputs", list(inputs(of.held.machine, of.held.inputs)))


def _shares(result: ToleranceFound) -> Iterator[Table]:
    for name, shares in result.sobol.items():
        rows = [
            (one, share.first, share.first_error, share.total, share.total_error)
            for one, share in ranked(shares)[:SHOWN]
            if share.total > 0
        ]
        if rows:
            yield Table(("input", "first", "+-", "total", "+-"), rows, label(name))


def _robust(found: RobustFound) -> Iterator[Any]:
    designs = (found.own, found.best_nominal, found.best_robust)
    head = ("", "own design", "nominal optimum", "robust optimum")
    kinds = {"objective without tolerances": "nominal", "mean": "mean", "standard deviation": "std",
             f"mean + {found.sigmas:g} standard deviations": "robust"}  # fmt: skip
    yield Text(f"The robust optimum has the least mean plus {found.sigmas:g} standard deviations of the objective over "
               f"{found.machines} machines, within the file's bounds, each over {found.samples} samples of a "
               "cycle.", "note")  # fmt: skip
    yield Table(head, [(name, *(getattr(one, key) for one in designs)) for name, key in kinds.items()])
    yield Table(head, [(label(name), *(one.design[name] for one in designs)) for name in found.design])
    yield Keys({"starts": found.starts, "slope that is left along the box, relative": found.residual})
