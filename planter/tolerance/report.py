"""Report folder of `planter tolerance`: summary.json, tolerances.toml, figures and report.html."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter import safe_text
from planter.files.paths import last_part
from planter.kernels import Array
from planter.progress import Listener
from planter.report import bundle, files, style
from planter.report.folder import renews
from planter.report.html import FigureSvg, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.tolerance.analysis import ToleranceAnalysis
from planter.tolerance.job import RandomPoints
from planter.tolerance.results import Band, RobustFound, Share, ToleranceFound, rank_shares

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.report.bundle import Drawn as Rendered


PANELS = 3
BARS = 8
"""Maximum number of inputs in the figure of an output."""
BINS = 60
MIN_TOTAL = 0.005
"""Total index above which an input is in the figure."""
PATHS = 100
"""Maximum number of machines with a path in the figure."""


@style.drawn
def draw_distributions(outputs: Mapping[str, Band], rows: Array) -> Figure:
    """Draw histograms of the outputs, their 5 and 95 % points, and the normal distributions to first order."""
    lines = -(-len(outputs) // PANELS)
    figure = style.new_figure(0.4 + 1.8 * lines)
    panels = figure.subplots(lines, PANELS, squeeze=False).ravel()
    for axes, (name, band), column in zip(panels, outputs.items(), rows.T, strict=False):
        _distribution(axes, band, column[~np.isnan(column)])
        axes.set_xlabel(label(name))
        axes.set_yticks([])
    for axes in panels[len(outputs) :]:
        axes.set_visible(False)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=4, frameon=False)
    return figure


def _distribution(axes: Axes, band: Band, values: Array) -> None:
    axes.hist(values, BINS, density=True, color=style.SKY, alpha=0.6, label="random machines")
    axes.axvspan(band.p5, band.p95, color=style.FAINT, alpha=0.25, linewidth=0, label="5 to 95 %")
    axes.axvline(band.nominal, color=style.INK, linewidth=1, label="nominal")
    if band.first_order_std:
        x = np.linspace(values.min(), values.max(), 200)
        deviation = (x - band.nominal) / band.first_order_std
        axes.plot(x, np.exp(-(deviation**2) / 2) / (band.first_order_std * np.sqrt(2 * np.pi)), color=style.VERMILION,
                  label="first order")  # fmt: skip


@style.drawn
def draw_indices(sobol: Mapping[str, Mapping[str, Share]]) -> Figure:
    """Draw first and total indices of each output in the inputs that matter most."""
    lines = -(-len(sobol) // 2)
    figure = style.new_figure(0.4 + 2.0 * lines)
    panels = figure.subplots(lines, 2, squeeze=False, sharex=True).ravel()
    for axes, (name, shares) in zip(panels, sobol.items(), strict=False):
        largest = [(path, share) for path, share in rank_shares(shares)[:BARS] if share.total > MIN_TOTAL][::-1]
        positions = np.arange(len(largest))
        total, first = ([getattr(share, kind) for _, share in largest] for kind in ("total", "first"))
        errors, thin = [share.total_error for _, share in largest], {"ecolor": style.SOFT, "linewidth": 0.8}
        axes.barh(positions, total, 0.8, color=style.SKY, alpha=0.7, label="total", xerr=errors, error_kw=thin)
        axes.barh(positions, first, 0.35, color=style.BLUE, label="first order")
        axes.set_yticks(positions, [last_part(path) for path, _ in largest])
        axes.set_title(label(name))
        axes.grid(visible=False, axis="y")
        axes.set_xlim(0, None)
    for axes in panels[len(sobol) :]:
        axes.set_visible(False)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=2, frameon=False)
    return figure


@style.drawn
def draw_cycle(phi_deg: Array, key: str, rows: Array, nominal: Array) -> Figure:
    """Draw a quantity (m, n) over a cycle: nominal, median and the 5 to 95 % band of the machines."""
    figure = style.new_figure(2.6)
    axes = figure.subplots()
    low, middle, high = np.percentile(rows, (5, 50, 95), axis=0)
    axes.fill_between(phi_deg, low, high, color=style.SKY, alpha=0.5, linewidth=0, label="5 to 95 %")
    axes.plot(phi_deg, middle, color=style.BLUE, linewidth=0.9, label="median")
    axes.plot(phi_deg, nominal, color=style.INK, linewidth=0.9, linestyle="--", label="nominal")
    style.over_a_turn(axes)
    axes.set_ylabel(label(key))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=3, frameon=False)
    return figure


@style.drawn
def draw_path(keys: Sequence[str], rows: tuple[Array, Array], nominal: tuple[Array, Array]) -> Figure:
    """Draw paths, and percentiles of their distance from the nominal path at each angle."""
    figure = style.new_figure(3.4)
    plane, distance = figure.subplots(1, 2)
    for x, y in zip(rows[0][:PATHS], rows[1][:PATHS], strict=True):
        plane.plot(*_closed(x, y), color=style.SKY, alpha=0.25, linewidth=0.5)
    plane.plot(*_closed(*nominal), color=style.INK, linewidth=0.8)
    style.drawing_board(plane, *map(label, keys))
    off = np.hypot(rows[0] - nominal[0], rows[1] - nominal[1])
    angles = np.linspace(0, 360, off.shape[1], endpoint=False)
    for share, shade in ((50, style.SKY), (95, style.BLUE)):
        distance.plot(angles, np.percentile(off, share, axis=0), color=shade, label=f"{share} % of machines")
    style.over_a_turn(distance)
    distance.set_ylabel("distance from the nominal path / mm")
    distance.set_ylim(0, None)
    distance.legend(frameon=False)
    return figure


def _closed(x: Array, y: Array) -> tuple[Array, Array]:
    return np.append(x, x[0]), np.append(y, y[0])


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
    yield "outputs", draw_distributions(result.outputs, analysis.rows)
    if result.sobol:
        yield "indices", draw_indices(result.sobol)
    keys = [*case.room.curves, *(key for pair in case.room.paths for key in pair)]
    if not keys:
        return
    points = RandomPoints(list(case.spreads.values()), MACHINES, result.seed).block(0, MACHINES)
    subject = case.subject
    cycles, nominal = subject.curves(keys, points), subject.curves(keys, case.centre[None])
    for key in case.room.curves:
        yield f"turn-{key}", draw_cycle(cycles["phi_deg"], key, cycles[key], nominal[key][0])
    for x, y in case.room.paths:
        nominal_path = nominal[x][0], nominal[y][0]
        yield f"path-{x}-{y}", draw_path((x, y), (cycles[x], cycles[y]), nominal_path)


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
