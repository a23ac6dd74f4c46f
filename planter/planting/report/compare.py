"""Files of a comparison of gear families: summary, one CSV table, one figure, the page."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.kernels import generated
from planter.planting.design_results import BORNE, COMPARED, list_largest_loads
from planter.planting.family_comparison import describe_comparison, describe_pair, pair_name
from planter.planting.report.page import meanings
from planter.planting.results import ComparedPair, ComparisonFound, NarrowBox
from planter.report import files, style
from planter.report.folder import renews
from planter.report.html import Cell, FigureSvg, Items, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.planting.file import Machine

COLUMNS = (
    "rank", "stage1", "stage2", "feasible", "settled", "objective", "range_N", "variance_N2", "kkt_residual", "seconds",
)  # fmt: skip


@renews
def write(out: Path, machine: Machine, result: ComparisonFound) -> None:
    """Writes summary.json, devices.csv, figures/comparison and report.html. Raises InputError if it cannot."""
    folder = files.output_folder(out)
    provenance = files.provenance(machine, result.seed)
    files.write_summary(folder / "summary.json", {**result.table(), "input": machine.table(), "provenance": provenance})
    files.write_text(folder / "devices.csv", table(machine, result))
    drawn = style.save(comparison(result), files.output_folder(folder / "figures"), "comparison")
    files.write_text(folder / "report.html", text(machine, result, drawn, provenance))


def text(machine: Machine, result: ComparisonFound, drawn: str, provenance: Mapping[str, Any]) -> str:
    """The page: what is settled, the pairs by rank, what holds each, what the others lack, and what it rests on."""
    devices = result.devices
    model = generated.sidecar("planting_exact")
    kept = [one for one in devices if one.settled], [one for one in devices if not one.settled]
    head = ("rank", "sun, gear 6", "feasible", "objective", "range / N", "variance / N2", "KKT residual", "told")
    tables = [
        Table(head, [_row(one) for one in group], caption)
        for group, caption in zip(kept, ("settled", "not settled: the best points that were reached"), strict=True)
        if group
    ]
    bear: list[tuple[Cell, ...]] = [(pair_name(one), *list_largest_loads(one.designer)) for one in devices]
    parts = [
        Section(
            "Pairs of gear families", [Text(describe_comparison(result), "" if not kept[1] else "warning"), *tables]
        ),
        Section("What each has to bear, largest over a turn", [Table(("sun, gear 6", *COMPARED), bear)]),
        Section("Figure", [FigureSvg(drawn, "Objective of every pair, by rank.")]),
        Section("Model", [Text(f"{model['title']} ({model['source']}). It assumes:"), Items(model["assumptions"])]),
        Section("Inputs", list(inputs(machine, meanings(model), besides=("design", "bounds")))),
        provenance_section(provenance),
    ]
    return page(f"Comparison of gear families in the planting device {machine.name}", parts, machine.description)


def _row(entry: ComparedPair) -> tuple[Any, ...]:
    keys = ("objective", "range_N", "variance_N2", "kkt_residual")
    feasible = "yes" if entry.feasible else "no"
    return (
        entry.rank,
        pair_name(entry),
        feasible,
        *(getattr(entry, key) for key in keys),
        "; ".join(describe_pair(entry)),
    )


def table(machine: Machine, result: ComparisonFound) -> str:
    """The ranked devices as CSV, with what binds or is broken."""
    told = f"# machine: {machine.name}, {result.starts} starts, seed {result.seed}"
    lines = [told, ",".join((*COLUMNS, *BORNE, "binding"))]
    for entry in result.devices:
        values = (getattr(entry, key) for key in COLUMNS)
        cells = ["" if value is None else str(value) for value in (*values, *list_largest_loads(entry.designer))]
        lines.append(",".join([*cells, " ".join(entry.binding)]))
    return "\n".join(lines) + "\n"


@style.drawn
def comparison(result: ComparisonFound) -> Figure:
    """Objective of every device by rank; those that do not keep the requirements hollow, with what they break."""
    devices = result.devices
    labels = [f"{_short(d.stage1)} / {_short(d.stage2)}" for d in devices]
    bars: list[tuple[str, ComparedPair | NarrowBox, str]] = [(labels[k], d, style.BLUE) for k, d in enumerate(devices)]
    bars.append(("the paper's narrow box", result.narrow, style.ORANGE))
    drawing = style.new_figure(1.0 + 0.24 * len(bars))
    axes = drawing.subplots()
    for place, (_, entry, shade) in enumerate(bars):
        fill = shade if entry.feasible else "none"
        open_ = 0.45 if isinstance(entry, ComparedPair) and not entry.settled else 1.0
        axes.barh(place, entry.objective, color=fill, edgecolor=shade, height=0.7, alpha=open_)
        axes.annotate(_told(entry), (entry.objective, place), (4, 0), textcoords="offset points", va="center",
                      fontsize=7)  # fmt: skip
    axes.set_yticks(range(len(bars)), [label for label, _, _ in bars])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("objective (31); pale: not settled; hollow: breaks requirements")
    axes.set_xlim(0, 1.5 * max(entry.objective for _, entry, _ in bars))
    return drawing


def _short(family: str) -> str:
    return family.replace("_", " ")


def _told(entry: ComparedPair | NarrowBox) -> str:
    if entry.feasible:
        return f"{entry.objective:.4g}"
    violations = entry.violations if isinstance(entry, ComparedPair) else []
    amounts = [f"{one.name.replace('_', ' ')} {one.amount:.3g} {one.unit}" for one in violations]
    return "breaks " + ", ".join(amounts or [name.replace("_", " ") for name in entry.binding])
