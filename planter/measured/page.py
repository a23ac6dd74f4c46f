"""Files of a fit to measured data: summary, residuals, the fitted machine, one figure, the page."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planter.files import units
from planter.files.written import lines
from planter.measured.calibration import Calibrated
from planter.measured.curve import is_nuisance
from planter.report import files, style
from planter.report.folder import check, renews
from planter.report.html import FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.writing import figure_files

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.files.document import Document
    from planter.kernels import Array

MACHINE_FILE = "calibrated.toml"
DENSE_DEG = np.linspace(0, 360, 721)


@renews
def write(out: Path, machine: Document, found: Calibrated, meanings: Mapping[str, str], angle: str) -> None:
    """Write summary.json, residuals.csv, calibrated.toml, figures/measured and report.html.

    `meanings` are those of the file's numbers by path, `angle` is what the drive's is called. Raises InputError for a
    folder that it cannot write.
    """
    folder = files.output_folder(out)
    provenance = files.provenance(machine)
    summary = {**found.result.table(), "input": machine.table(), "provenance": provenance}
    written = [*([MACHINE_FILE] if found.machine is not None else []), "residuals.csv", *figure_files("measured")]
    check(folder, written)
    files.write_summary(folder / "summary.json", summary)
    columns = _columns(found)
    files.write_cycle_csv(folder / "residuals.csv", files.comments(machine, "machine"), columns)
    if found.machine is not None:
        files.write_text(folder / MACHINE_FILE, machine_text(found))
    figure = measured(columns, _curves(found), found.result.unit, f"{angle} / deg")
    drawn = style.save(figure, files.output_folder(folder / "figures"), "measured")
    files.write_text(folder / "report.html", _page(machine, found, drawn, meanings))


def machine_text(found: Calibrated) -> str:
    """The machine file (TOML) with the fitted inputs; what was fitted beside them stands in its head."""
    machine = found.machine
    assert machine is not None
    table = machine.written_table()
    how = f"calibrated ({found.result.model} model, {found.result.reached.points} points)"
    names = [entry.name for entry in found.result.fitted if not is_nuisance(entry.name)]
    origins = {name: words for name, words in machine.origins.items() if name not in names}
    table["origin"] = origins | {name.partition("[")[0]: how for name in names}
    beside = [f"# {e.name} = {e.value!r}" for e in found.result.fitted if is_nuisance(e.name)]
    head = [f"# {machine.name}, inputs fitted to measured data: {found.result.statement}.", *beside]
    return "\n".join([*head, "", *lines(table, {})]) + "\n"


def _columns(found: Calibrated) -> dict[str, Array]:
    """Measured and computed values over the turn, in shown units."""
    used, unit = found.measured.used, found.result.unit
    columns = {"phi_deg": np.degrees(found.measured.phi[used])}
    columns |= {key_of("measured", unit): found.measured.values[used]}
    return columns | {key_of(model, unit): fit.curve.values - fit.residuals for model, fit in found.fits.items()}


def key_of(name: str, unit: str) -> str:
    """Return the column of a curve in a display unit."""
    suffix = next((end for end in units.SUFFIXES if units.unit(end) == unit), "") if unit else ""
    return f"{name}{suffix}"


def _curves(found: Calibrated) -> dict[str, Array]:
    """Fitted curves of both models over the whole turn, whatever part of it was measured."""
    phi = np.radians(DENSE_DEG)
    return {model: fit.curve(fit.values, phi)[0] for model, fit in found.fits.items()}


@style.drawn
def measured(columns: dict[str, Array], curves: dict[str, Array], unit: str, angle: str) -> Figure:
    """Measured points with the fitted curves of both models at `DENSE_DEG`, and the residuals of each."""
    figure = style.new_figure(5.0)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1])
    phi = np.mod(columns["phi_deg"], 360)
    values = columns[key_of("measured", unit)]
    top.plot(phi, values, "o", color=style.SOFT, markersize=2, label="measured")
    for index, (model, fitted) in enumerate(curves.items()):
        shade = style.colour(model, index)
        top.plot(DENSE_DEG, fitted, color=shade, label=f"{model} model")
        bottom.plot(phi, values - columns[key_of(model, unit)], "o", color=shade, markersize=1.6)
    bottom.axhline(0, color=style.SOFT, linewidth=0.6)
    top.set_ylabel(f"measured and fitted / {unit}")
    bottom.set_ylabel(f"residual / {unit}")
    style.over_a_turn(bottom, label=False)
    bottom.set_xlabel(angle)
    figure.legend(*top.get_legend_handles_labels(), loc="outside upper right", ncols=3, frameon=False)
    return figure


def _page(machine: Document, found: Calibrated, drawn: str, meanings: Mapping[str, str]) -> str:
    result, unit = found.result, found.result.unit
    head = ("input", "value", "from", "to", "unit", "lower", "upper", "open", "origin")
    rows = [
        (e.name, e.value, e.low95, e.high95, e.unit, e.lower, e.upper, "yes" if e.open else "", e.origin)
        for e in result.fitted
    ]
    models = [(name, m.outcome, m.rms, m.rms_of_noise, m.rank, f"{m.agreeing_starts} of {m.starts}")
              for name, m in result.models.items()]  # fmt: skip
    parts = [
        Section("Result", [Text(f"{result.statement}."), *([Items(result.warnings)] if result.warnings else [])]),
        Section(
            "Data", [Items(result.treatment), Keys({f"noise / {unit}": result.noise.std, "left out": result.left_out})]
        ),
        Section(f"Fitted inputs, with 95 % intervals for {result.noise.model} noise", [Table(head, rows)]),
        Section("Models", [Table(("model", "outcome", f"rms / {unit}", "over noise", "rank", "starts agree"), models)]),
        Section(
            "Figure", [FigureSvg(drawn, "Measured and fitted over a revolution, and the residuals of each model.")]
        ),
    ]
    if result.prediction is not None:
        left = list(result.prediction.rms.items())
        caption = f"{result.prediction.points} points at {result.prediction.speed_rpm:g} r/min, nothing fitted to them"
        parts.append(Section("Prediction", [Table(("model", f"rms / {unit}"), left, caption)]))
    parts.append(Section("Inputs", list(inputs(machine, meanings, besides=("design", "bounds")))))
    parts.append(provenance_section(files.provenance(machine)))
    return page(f"{machine.name}, fitted to measured data", parts, machine.description)
