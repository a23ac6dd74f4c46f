"""Presentations of compared gear families, and of a calibration to figures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planter.files import units
from planter.kernels import generated
from planter.papers.planting.design_results import BORNE, COMPARED, list_largest_loads
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.results import (
    CalibrationFound,
    ComparedPair,
    ComparisonFound,
    NarrowBox,
)
from planter.report import files, style
from planter.report.html import Cell, Items, KeyFigure, Keys, Section, Table, Text
from planter.report.labels import count_things, format_name, list_values, load_names, separate_words
from planter.report.presentation import ModelAssumptions, ResultPresentation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAIR = "sun, gear 6"
NARROW = "the paper's narrow box"
PAGE_COLUMNS = ("feasible", "KKT residual")
PAIR_HEAD = ("rank", PAIR, "settled", "objective", "range / N", "variance / N2", *PAGE_COLUMNS)
CSV_COLUMNS = (
    "rank",
    "stage1",
    "stage2",
    "feasible",
    "settled",
    "objective",
    "range_N",
    "variance_N2",
    "kkt_residual",
    "seconds",
)


def present_comparison(result: ComparisonFound, machine: PlantingMachine) -> ResultPresentation:
    """Return the presentation of compared gear families: ranks, requirements, loads, conflicting
    requirements.
    """
    return ResultPresentation(
        title=f"Comparison of gear families in the planting device {machine.name}",
        conclusion=_conclude_comparison(result),
        record=result,
        key_figures=list(_list_comparison_figures(result)),
        sections=list(_list_comparison_sections(result)),
        document=machine,
        model=ModelAssumptions.from_sidecar(generated.sidecar("planting_exact"), in_summary=False),
        figures=lambda: {"comparison": draw_comparison(result)},
        captions={"comparison": "Objective of every pair, by rank."},
        texts=lambda: {"devices.csv": format_devices_csv(machine, result)},
        provenance=files.list_provenance(machine, result.seed),
    )


def _conclude_comparison(result: ComparisonFound) -> str:
    best = next((pair for pair in result.devices if pair.feasible), None)
    if best is None:
        return "No pair satisfies all requirements."
    kind = "settled" if best.settled else "feasible, but not settled,"
    narrow = f"{NARROW} has {result.narrow.objective:.6g}"
    return (
        f"The best {kind} pair is {pair_name(best)}, with objective {best.objective:.6g}; {narrow}."
    )


def _list_comparison_figures(result: ComparisonFound) -> Iterator[KeyFigure]:
    best = next((pair for pair in result.devices if pair.feasible), None)
    if best is not None:
        yield KeyFigure(f"{best.objective:.4g}", "", f"least objective, {pair_name(best)}")
        yield KeyFigure(
            f"{best.range_N:.4g}", "N", f"range of the support force, {pair_name(best)}"
        )
    feasible = sum(pair.feasible for pair in result.devices)
    yield KeyFigure(f"{feasible} of {len(result.devices)}", "", "pairs satisfy all requirements")


def _list_comparison_sections(result: ComparisonFound) -> Iterator[Section]:
    devices = result.devices
    rows = [*map(_tabulate_pair, devices), _tabulate_pair(result.narrow)]
    table = Table(
        PAIR_HEAD, rows, "Pairs, settled ones first, true extremes and integrals", PAGE_COLUMNS
    )
    description = (
        f"{result.settled} of {len(devices)} pairs are settled: a KKT residual below 1e-6 and a "
        f"second start that "
        "agrees, or a violation that is least to first order. The others are only the best points "
        "reached. The "
        f"computation took {result.seconds:.3g} s."
    )
    yield Section(
        "Pairs of gear families",
        [Text(description, "" if result.settled == len(devices) else "warning"), table],
    )
    items = [f"{pair_name(pair)}: {'; '.join(describe_pair(pair))}" for pair in devices]
    yield Section(
        "Requirements",
        [Text("Requirements that each pair makes active or violates:"), Items(items)],
    )
    if result.proposal is not None:
        proposal = result.proposal
        conflicting = ", ".join(proposal.conflicting) or "no single one"
        limits = ", ".join(f"{key} = {value:.6g}" for key, value in proposal.limits.items())
        remedy = f"{proposal.stage1} with {proposal.stage2} satisfies them with {limits}."
        sentences = (f"Requirements that every pair violates: {conflicting}.", remedy)
        yield Section(
            "Conflicting requirements", [Text(sentence, "warning") for sentence in sentences]
        )
    loads: list[tuple[Cell, ...]] = [
        (pair_name(pair), *list_largest_loads(pair.designer)) for pair in devices
    ]
    yield Section("Largest loads over a cycle", [Table((PAIR, *COMPARED), loads)])


def _tabulate_pair(entry: ComparedPair | NarrowBox) -> tuple[Cell, ...]:
    scores = (entry.objective, entry.range_N, entry.variance_N2, entry.feasible)
    if isinstance(entry, NarrowBox):
        return None, NARROW, None, *scores, None
    return entry.rank, pair_name(entry), entry.settled, *scores, entry.kkt_residual


def pair_name(entry: ComparedPair) -> str:
    """Return the families of a pair in words."""
    return f"{entry.stage1}, {entry.stage2}".replace("_", " ")


def describe_pair(entry: ComparedPair) -> Iterator[str]:
    """Yield the requirements that are active or violated, and what the pair lacks to be settled."""
    amounts = [
        f"{_name_requirement(violation.name)} by {violation.amount:.3g} {violation.unit}"
        for violation in entry.violations
    ]
    names = ", ".join(amounts or map(_name_requirement, entry.binding))
    yield (
        f"{'active' if entry.feasible else 'violated'}: {names}"
        if names
        else "no active requirement"
    )
    if entry.lacks:
        yield f"lacks {' and '.join(entry.lacks)}"


def _name_requirement(key: str) -> str:
    entry = load_names("planter.papers.planting").find(key)
    return separate_words(key) if entry is None else f"{entry.name[0].lower()}{entry.name[1:]}"


def format_devices_csv(machine: PlantingMachine, result: ComparisonFound) -> str:
    """Return the ranked devices with their loads and their active or violated requirements as
    CSV.
    """
    head = f"# machine: {machine.name}, {result.starts} starts, seed {result.seed}"
    rows = [head, ",".join((*CSV_COLUMNS, *BORNE, "binding"))]
    for entry in result.devices:
        values = (
            *(getattr(entry, key) for key in CSV_COLUMNS),
            *list_largest_loads(entry.designer),
        )
        cells = ["" if value is None else str(value) for value in values]
        rows.append(",".join([*cells, " ".join(entry.binding)]))
    return "\n".join(rows) + "\n"


@style.with_style
def draw_comparison(result: ComparisonFound) -> Figure:
    """Return the figure of the objectives by rank; pairs that violate requirements are hollow and
    say by how much.
    """
    bars: list[tuple[str, ComparedPair | NarrowBox, str]] = [
        (f"{pair.stage1} / {pair.stage2}".replace("_", " "), pair, style.BLUE)
        for pair in result.devices
    ]
    bars.append((NARROW, result.narrow, style.ORANGE))
    figure = style.new_figure(1.0 + 0.24 * len(bars))
    axes = figure.subplots()
    for row, (_, entry, shade) in enumerate(bars):
        fill = shade if entry.feasible else "none"
        opacity = 0.45 if isinstance(entry, ComparedPair) and not entry.settled else 1.0
        axes.barh(row, entry.objective, color=fill, edgecolor=shade, height=0.7, alpha=opacity)
        axes.annotate(
            _label_bar(entry),
            (entry.objective, row),
            (4, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
        )
    axes.set_yticks(range(len(bars)), [label for label, _, _ in bars])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("objective (31); pale: not settled; hollow: violates requirements")
    axes.set_xlim(0, 1.5 * max(entry.objective for _, entry, _ in bars))
    return figure


def _label_bar(entry: ComparedPair | NarrowBox) -> str:
    if entry.feasible:
        return f"{entry.objective:.4g}"
    violations = entry.violations if isinstance(entry, ComparedPair) else []
    amounts = [
        f"{_name_requirement(violation.name)} by {violation.amount:.3g} {violation.unit}"
        for violation in violations
    ]
    return f"violates {', '.join(amounts or map(_name_requirement, entry.binding))}"


def present_calibration(result: CalibrationFound, device: Device) -> ResultPresentation:
    """Return the presentation of inputs fitted to a paper's figures, and of what they give."""
    return ResultPresentation(
        title=f"Calibration of the planting device {result.machine}",
        conclusion=result.statement,
        record=result,
        sections=list(_list_calibration_sections(result)),
        document=device.machine,
        model=ModelAssumptions.from_sidecar(device.sidecar),
    )


def _list_calibration_sections(result: CalibrationFound) -> Iterator[Section]:
    head = ("name", "value", "unit", "lower", "upper")
    fitted = [[getattr(row, key) for key in head] for row in result.fitted]
    caption = f"Calibrated, not the paper's; {', '.join(result.choices.values())} flanks"
    yield Section("Fitted inputs", [Table(head, fitted, caption)])
    rows = []
    for key, value in result.target.items():
        reached, unit = result.reached[key], units.display_unit(key)
        rows.append((format_name(key), value, reached, unit, result.miss_percent[key]))
    determined = (
        f"The target determines {count_things(result.rank, 'combination')} of the "
        f"{len(result.fitted)} inputs."
    )
    yield Section(
        f"What the {result.model} model can reach",
        [
            Table(("support force", "target", "reached", "unit", "miss / %"), rows),
            Text(determined),
            Keys({"least force of the cam on the roller / N": result.least_push_N}),
        ],
    )
    if result.front:
        missed = [f"{format_name(key)} missed / %" for key in result.target]
        misses: list[tuple[Cell, ...]] = [
            (*best.choices.values(), *best.miss_percent.values(), best.range_N)
            for best in result.front
        ]
        yield Section(
            "The smallest misses, with a cam that only pushes",
            [Table(("flanks", *missed, "range / N"), misses)],
        )
    other = list_values(result.other_model.table())
    yield Section("The other model with the fitted inputs", [other])
