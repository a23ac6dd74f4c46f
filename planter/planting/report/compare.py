"""Files of a comparison of gear families: summary, one CSV table, one figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.optimise.descent import STATIONARY
from planter.report import files, style
from planter.report.folder import renews

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.planting.file import Machine

Entry = Mapping[str, Any]
COLUMNS = ("stage1", "stage2", "feasible", "objective", "range_N", "variance_N2", "kkt_residual", "seconds")


@renews
def write(out: Path, machine: Machine, result: Mapping[str, Any]) -> None:
    """Writes summary.json, devices.csv and figures/comparison. Raises InputError for a folder that it cannot write."""
    folder = files.output_folder(out)
    provenance = files.provenance(machine, result["seed"])
    files.write_summary(folder / "summary.json", {**result, "input": machine.table(), "provenance": provenance})
    files.write_text(folder / "devices.csv", table(machine, result))
    style.save(comparison(result), files.output_folder(folder / "figures"), "comparison")


def table(machine: Machine, result: Mapping[str, Any]) -> str:
    """The ranked devices as CSV, with what binds or is broken."""
    told = f"# machine: {machine.name}, {result['starts']} starts, seed {result['seed']}"
    lines = [told, ",".join((*COLUMNS, "binding"))]
    for entry in result["devices"]:
        cells = ["" if entry[key] is None else str(entry[key]) for key in COLUMNS]
        lines.append(",".join([*cells, " ".join(entry["binding"])]))
    return "\n".join(lines) + "\n"


@style.drawn
def comparison(result: Mapping[str, Any]) -> Figure:
    """Objective of every device by rank; those that do not keep the requirements hollow, with what they break."""
    devices: Sequence[Entry] = result["devices"]
    labels = [f"{_short(d['stage1'])} / {_short(d['stage2'])}" for d in devices]
    bars = [(labels[k], d, style.BLUE) for k, d in enumerate(devices)]
    if result["narrow"] is not None:
        bars.append(("the paper's narrow box", {**result["narrow"], "violations": []}, style.ORANGE))
    drawing = style.new_figure(1.0 + 0.24 * len(bars))
    axes = drawing.subplots()
    for place, (_, entry, shade) in enumerate(bars):
        fill = shade if entry["feasible"] else "none"
        open_ = 0.45 if entry["feasible"] and not settled(entry) else 1.0
        axes.barh(place, entry["objective"], color=fill, edgecolor=shade, height=0.7, alpha=open_)
        axes.annotate(_told(entry), (entry["objective"], place), (4, 0), textcoords="offset points", va="center",
                      fontsize=7)  # fmt: skip
    axes.set_yticks(range(len(bars)), [label for label, _, _ in bars])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("objective (31); pale: not settled; hollow: breaks requirements")
    axes.set_xlim(0, 1.5 * max(entry["objective"] for _, entry, _ in bars))
    return drawing


def settled(entry: Entry) -> bool:
    """Whether an entry is a local minimum by its certificate, rather than the best point that was reached."""
    residual = entry.get("kkt_residual")
    return residual is not None and residual < STATIONARY


def _short(family: str) -> str:
    return family.replace("_", " ")


def _told(entry: Entry) -> str:
    if entry["feasible"]:
        return f"{entry['objective']:.4g}"
    amounts = [f"{one['name'].replace('_', ' ')} {one['amount']:.3g} {one['unit']}" for one in entry["violations"]]
    return "breaks " + ", ".join(amounts or [name.replace("_", " ") for name in entry["binding"]])
