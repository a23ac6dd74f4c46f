"""The presentation of `planter tolerance`: bands, Sobol' indices, the robust design and figures."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from planter import safe_text
from planter.engine.outputs import find_output
from planter.files import units
from planter.kernels import Array
from planter.paths import last_part
from planter.report import files, style
from planter.report.html import Block, Cell, KeyFigure, Keys, Section, Table, Text
from planter.report.labels import format_label, label_axis
from planter.report.presentation import MOST_KEY_FIGURES, ResultPresentation
from planter.rows.points import draw_points
from planter.rows.results import Band, RobustFound, Share, ToleranceFound, rank_shares
from planter.rows.tolerance_analysis import ToleranceAnalysis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PANELS = 3
BARS = 8
"""Maximum number of inputs in the figure of an output."""
NAME_WIDTH, TITLE_WIDTH = 31, 27
"""Characters of a line of an input's name in a figure, and of a panel's title."""
TITLE_HEIGHT, BAR_HEIGHT = 0.7, 0.38
"""Height of a panel's title, and of an input, whose name may have three lines [inch]."""
BINS = 60
LEAST_LINES = 3
"""Number of inputs for which the figure of an output has room at least, so that bars are not
thicker.
"""
MIN_TOTAL = 0.005
"""Total index above which an input is in the figure."""
LEAST_REDUCTION = 0.1
"""Reduction of a standard deviation [%] below which the tolerance of an input is not worth a
row.
"""


@style.with_style
def draw_distributions(
    outputs: Mapping[str, Band], rows: Array, meanings: Mapping[str, str]
) -> Figure:
    """Draw histograms of the outputs, their 5 and 95 % points, and the normal distributions to
    first order.
    """
    lines = -(-len(outputs) // PANELS)
    figure = style.new_figure(0.4 + 2.0 * lines)
    panels = figure.subplots(lines, PANELS, squeeze=False).ravel()
    for axes, (name, band), column in zip(panels, outputs.items(), rows.T, strict=False):
        _distribution(axes, band, column[~np.isnan(column)])
        axes.set_xlabel(label_axis(name, meanings))
        axes.set_yticks([])
        axes.locator_params(axis="x", nbins=4)
    for axes in panels[len(outputs) :]:
        axes.set_visible(False)
    style.add_legend(figure, panels[0], 4)
    return figure


def _distribution(axes: Axes, band: Band, values: Array) -> None:
    axes.hist(values, BINS, density=True, color=style.SKY, alpha=0.6, label="random machines")
    axes.axvspan(band.p5, band.p95, color=style.FAINT, alpha=0.25, linewidth=0, label="5 to 95 %")
    axes.axvline(band.nominal, color=style.INK, linewidth=1, label="nominal")
    if band.first_order_std:
        x = np.linspace(values.min(), values.max(), 200)
        deviation = (x - band.nominal) / band.first_order_std
        axes.plot(
            x,
            np.exp(-(deviation**2) / 2) / (band.first_order_std * np.sqrt(2 * np.pi)),
            color=style.VERMILION,
            label="first order",
        )


@style.with_style
def draw_indices(sobol: Mapping[str, Mapping[str, Share]], meanings: Mapping[str, str]) -> Figure:
    """Draw first and total indices of each output in the inputs that matter most."""
    bars = {
        name: [
            (path, share) for path, share in rank_shares(shares)[:BARS] if share.total > MIN_TOTAL
        ][::-1]
        for name, shares in sobol.items()
    }
    counts = [max(len(each), LEAST_LINES) for each in bars.values()]
    heights = [TITLE_HEIGHT + BAR_HEIGHT * max(counts[k : k + 2]) for k in range(0, len(counts), 2)]
    figure = style.new_figure(0.4 + sum(heights))
    panels = figure.subplots(
        len(heights), 2, squeeze=False, sharex=True, height_ratios=heights
    ).ravel()
    for axes, (name, largest) in zip(panels, bars.items(), strict=False):
        positions = np.arange(len(largest))
        total, first = (
            [getattr(share, kind) for _, share in largest] for kind in ("total", "first")
        )
        errors, thin = (
            [share.total_error for _, share in largest],
            {"ecolor": style.SOFT, "linewidth": 0.8},
        )
        axes.barh(
            positions,
            total,
            0.8,
            color=style.SKY,
            alpha=0.7,
            label="total",
            xerr=errors,
            error_kw=thin,
        )
        axes.barh(positions, first, 0.35, color=style.BLUE, label="first order")
        names = [
            textwrap.fill(meanings.get(path) or last_part(path), NAME_WIDTH) for path, _ in largest
        ]
        axes.set_yticks(positions, names, fontsize=6.5)
        axes.set_title(units.typeset_label(label_axis(name, meanings, TITLE_WIDTH)))
        axes.grid(visible=False, axis="y")
        axes.set_xlim(0, None)
        axes.set_ylim(-0.6, max(len(largest), LEAST_LINES) - 0.4)
    for axes in panels[len(sobol) :]:
        axes.set_visible(False)
    style.add_legend(figure, panels[0], 2)
    return figure


@style.with_style
def draw_cycle(
    places: Array, end: float, label: str, key: str, rows: Array, nominal: Array
) -> Figure:
    """Draw a quantity (m, n) at angles [deg] of a cycle, or times [s] of a motion, with its end:
    nominal, median and the 5 to 95 % band of the machines.
    """
    figure = style.new_figure(2.6)
    axes = figure.subplots()
    low, middle, high = np.percentile(rows, (5, 50, 95), axis=0)
    axes.fill_between(places, low, high, color=style.SKY, alpha=0.5, linewidth=0, label="5 to 95 %")
    axes.plot(places, middle, color=style.BLUE, linewidth=0.9, label="median")
    axes.plot(places, nominal, color=style.INK, linewidth=0.9, linestyle="--", label="nominal")
    style.over_a_turn(axes, label=False, end=end)
    axes.set_xlabel(label)
    axes.set_ylabel(format_label(key))
    style.add_legend(figure, axes, 3)
    return figure


MACHINES, MOTIONS, MOST_CYCLES = 500, 100, 3
"""Numbers of machines of the bands over a cycle, and over a motion, and maximum number of quantities
that have them.
"""
ANGLE_LABEL = "angle of the drive / deg"
LARGEST = 3
"""Maximum number of inputs of an output in a table."""


def present_tolerance(analysis: ToleranceAnalysis) -> ResultPresentation:
    """Return the presentation: bands, the inputs that matter most, the robust design, figures and
    tolerances.
    """
    result, resolved, meanings = analysis.result, analysis.case.resolved, _list_meanings(analysis)
    chosen = "".join(f", {text} {name}" for name, text in result.choices.items())
    return ResultPresentation(
        title=f"Tolerances of {result.machine}{chosen}",
        conclusion=_conclude(result, meanings),
        key_figures=[
            KeyFigure(
                f"\N{PLUS-MINUS SIGN} {100 * band.std / abs(band.mean):.2g} %",
                "",
                f"{meanings[name]}: standard deviation over the mean of {band.mean:.4g} "
                f"{units.display_unit(name)}",
            )
            for name, band in list(result.outputs.items())[:MOST_KEY_FIGURES]
            if band.mean
        ],
        record=result,
        sections=list(_list_sections(result)),
        document=resolved.machine,
        meanings=resolved.inputs,
        figures=lambda: dict(_draw(analysis)),
        captions={"outputs": "Distributions of the outputs.", "indices": "Sobol' indices."}
        | {
            f"turn-{key}": f"Bands of {_count_machines(analysis)} machines."
            for key in _list_cycles(analysis)
        },
        details=partial(_list_details, analysis),
        texts=lambda: {"tolerances.toml": format_tolerances(result)},
        provenance=files.list_provenance(resolved.machine, result.seed),
    )


def _list_meanings(analysis: ToleranceAnalysis) -> dict[str, str]:
    """Return the meanings of inputs by path, and of outputs by name."""
    resolved = analysis.case.resolved
    outputs = {
        name: resolved.describe_output(name, "output")[1] for name in analysis.result.outputs
    }
    return outputs | dict(resolved.inputs)


def _conclude(result: ToleranceFound, meanings: Mapping[str, str]) -> str:
    """Return how many inputs vary, and whose tolerance is worth halving first."""
    sentence = (
        f"{len(result.inputs)} inputs vary over {result.rows} random machines, in "
        f"{result.seconds:.3g} s."
    )
    for name, entries in result.tightened.items():
        path, best = max(entries.items(), key=lambda pair: pair[1].reduction_percent)
        return (
            f"{sentence} Half the tolerance of {meanings[path]} ({last_part(path)}) would reduce "
            f"the standard "
            f"deviation of {meanings[name]} most, by {best.reduction_percent:.3g} %."
        )
    return sentence


def format_tolerances(result: ToleranceFound) -> str:
    """Return the tolerances as a file that `--tolerances` reads."""
    entries = (
        f'"{entry.name}" = {{ from = {entry.low!r}, to = {entry.high!r}, distribution = '
        f'"{entry.distribution}" }}'
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
        "Nominal is the machine at the centre of the tolerances; first order is the standard "
        "deviation from its exact "
        "gradients."
    )
    yield Section("Bands", [Table(head, bands, page_columns=head[-1:]), Text(note, "note")])
    shares: list[tuple[str, ...]] = [
        (
            "" if rank else format_label(name),
            last_part(path),
            f"{share.first:.3f}",
            f"{share.total:.3f}",
            f"{share.total_error:.3f}",
        )
        for name, indices in result.sobol.items()
        for rank, (path, share) in enumerate(rank_shares(indices)[:LARGEST])
        if share.total > 0
    ]
    if shares:
        note = (
            "Sobol' indices: the share of an output's variance that an input causes by itself "
            "(first) and with all "
            f"others (total). {result.index_rows} cycles; errors are half the 95 % intervals."
        )
        yield Section(
            "Largest Sobol' indices",
            [
                Table(("output", "input", "first", "total", "\N{PLUS-MINUS SIGN}"), shares),
                Text(note, "note"),
            ],
        )
    yield from _list_tightening(result, LARGEST)
    if result.robust is not None:
        yield Section("Robust design", list(_describe_robust(result.robust)))


def _list_tightening(result: ToleranceFound, count: int) -> Iterator[Section]:
    """Yield what half of a tolerance buys: for each output the inputs whose tolerance reduces its
    deviation most.
    """
    rows: list[tuple[Cell, ...]] = []
    for name, entries in result.tightened.items():
        ranked = sorted(entries.items(), key=lambda pair: -pair[1].reduction_percent)[:count]
        useful = [
            (path, entry) for path, entry in ranked if entry.reduction_percent > LEAST_REDUCTION
        ]
        rows += [
            (
                "" if rank else format_label(name),
                last_part(path),
                result.outputs[name].std,
                entry.std,
                float(f"{entry.reduction_percent:.3g}"),
            )
            for rank, (path, entry) in enumerate(useful)
        ]
    if rows:
        head = ("output", "input", "std now", "std with half", "reduction / %")
        note = (
            "The standard deviation of an output if the tolerance of one input alone is halved, "
            "by the same machines "
            "with and without."
        )
        yield Section("What half of a tolerance buys", [Table(head, rows), Text(note, "note")])


def _describe_robust(result: RobustFound) -> Iterator[Block]:
    total = f"mean + {result.sigmas:g} std"
    yield Keys(
        {
            total: result.objective,
            "mean": result.mean,
            "standard deviation": result.std,
            f"{total} of the file's design": result.own_objective,
            "machines": result.machines,
            "samples of a cycle": result.samples or "none: true extremes and integrals",
            "starts": result.starts,
        }
    )
    rows = [(format_label(name), value) for name, value in result.design.items()]
    yield Table(("", "robust optimum"), rows, "Design")


def _list_details(analysis: ToleranceAnalysis) -> Iterator[Section]:
    """Yield the tolerances with their meanings."""
    result, meanings = analysis.result, analysis.case.resolved.inputs
    entries = [
        (x.name, x.distribution, x.low, x.high, x.std, meanings[x.name]) for x in result.inputs
    ]
    yield Section(
        "Tolerances", [Table(("input", "distribution", "from", "to", "std", "meaning"), entries)]
    )


def _list_cycles(analysis: ToleranceAnalysis) -> list[str]:
    """Return the keys of the quantities that the outputs are of; none where a machine has no
    cycle.
    """
    if any(band.missing for band in analysis.result.outputs.values()):
        return []
    machine = analysis.case.subject.machine
    terms = (t for name in analysis.result.outputs for t in find_output(machine, name).terms)
    keys = dict.fromkeys(machine.find_quantity(term.name).key for term in terms)
    return list(keys)[:MOST_CYCLES]


def _count_machines(analysis: ToleranceAnalysis) -> int:
    """Return the number of machines of the bands over a cycle."""
    return MACHINES if analysis.case.subject.machine.motion is None else MOTIONS


def _draw(analysis: ToleranceAnalysis) -> Iterator[tuple[str, Figure]]:
    case, result = analysis.case, analysis.result
    yield "outputs", draw_distributions(result.outputs, analysis.rows, _list_meanings(analysis))
    if result.sobol:
        yield "indices", draw_indices(result.sobol, _list_meanings(analysis))
    if not (keys := _list_cycles(analysis)):
        return
    count = _count_machines(analysis)
    points = draw_points(list(case.spreads.values()), count, result.seed).block(0, count)
    subject = case.subject
    cycles, nominal = subject.curves(keys, points), subject.curves(keys, case.centre[None])
    place, end, label = "phi_deg", float(np.degrees(subject.machine.turn)), ANGLE_LABEL
    if (motion := subject.machine.motion) is not None:
        place, end, label = "t_s", motion.span, "time / s"
    for key in keys:
        figure = draw_cycle(cycles[place], end, label, key, cycles[key], nominal[key][0])
        yield f"turn-{key}", figure
