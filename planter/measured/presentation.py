"""Report folder of a fit to measured data: summary, residuals, fitted machine, figure and page."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planter.files import units
from planter.files.document import lines
from planter.measured.calibration import Calibrated
from planter.measured.curve import is_nuisance
from planter.measured.findings import MeasuredFound
from planter.report import files, style
from planter.report.folder import check, renews
from planter.report.html import FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.writing import figure_files
from planter.terminal.console import Console

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.files.document import Document
    from planter.kernels import Array


MACHINE_FILE = "calibrated.toml"
DENSE_DEG = np.linspace(0, 360, 721)


@renews
def write_measured_report(
    out: Path, machine: Document, calibrated: Calibrated, meanings: Mapping[str, str], angle: str
) -> None:
    """Write summary.json, residuals.csv, calibrated.toml, figures/measured and report.html.

    `meanings` are those of the numbers of the file by path, `angle` is the name of the angle of the drive. Raises
    InputError if the folder cannot be written.
    """
    folder = files.output_folder(out)
    provenance = files.provenance(machine)
    summary = {**calibrated.result.table(), "input": machine.table(), "provenance": provenance}
    written = [*([MACHINE_FILE] if calibrated.machine is not None else []), "residuals.csv", *figure_files("measured")]
    check(folder, written)
    files.write_summary(folder / "summary.json", summary)
    columns = _columns(calibrated)
    files.write_cycle_csv(folder / "residuals.csv", files.comments(machine, "machine"), columns)
    if calibrated.machine is not None:
        files.write_text(folder / MACHINE_FILE, machine_text(calibrated))
    figure = draw_measured(columns, _curves(calibrated), calibrated.result.unit, f"{angle} / deg")
    image = style.save(figure, files.output_folder(folder / "figures"), "measured")
    files.write_text(folder / "report.html", _page(machine, calibrated, image, meanings))


def machine_text(calibrated: Calibrated) -> str:
    """Return the machine file (TOML) with the fitted inputs, and with nuisance parameters as comments at its top."""
    machine = calibrated.machine
    assert machine is not None
    table = machine.written_table()
    origin = f"calibrated ({calibrated.result.model} model, {calibrated.result.reached.points} points)"
    names = [entry.name for entry in calibrated.result.fitted if not is_nuisance(entry.name)]
    origins = {name: words for name, words in machine.origins.items() if name not in names}
    table["origin"] = origins | {name.partition("[")[0]: origin for name in names}
    nuisances = [f"# {e.name} = {e.value!r}" for e in calibrated.result.fitted if is_nuisance(e.name)]
    head = [f"# {machine.name}, inputs fitted to measured data: {calibrated.result.statement}.", *nuisances]
    return "\n".join([*head, "", *lines(table, {})]) + "\n"


def _columns(calibrated: Calibrated) -> dict[str, Array]:
    """Return measured and computed values over the cycle, in display units."""
    used, unit = calibrated.measured.used, calibrated.result.unit
    columns = {"phi_deg": np.degrees(calibrated.measured.phi[used])}
    columns |= {key_of("measured", unit): calibrated.measured.values[used]}
    return columns | {key_of(model, unit): fit.curve.values - fit.residuals for model, fit in calibrated.fits.items()}


def key_of(name: str, unit: str) -> str:
    """Return the column of a curve in a display unit."""
    suffix = next((end for end in units.SUFFIXES if units.unit(end) == unit), "") if unit else ""
    return f"{name}{suffix}"


def _curves(calibrated: Calibrated) -> dict[str, Array]:
    """Return the fitted curves of all models over the whole cycle, also where nothing was measured."""
    phi = np.radians(DENSE_DEG)
    return {model: fit.curve(fit.values, phi)[0] for model, fit in calibrated.fits.items()}


@style.drawn
def draw_measured(columns: dict[str, Array], curves: dict[str, Array], unit: str, angle: str) -> Figure:
    """Draw measured points with the fitted curves of all models at `DENSE_DEG`, and the residuals of each."""
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


def _page(machine: Document, calibrated: Calibrated, image: str, meanings: Mapping[str, str]) -> str:
    result, unit = calibrated.result, calibrated.result.unit
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
            "Figure", [FigureSvg(image, "Measured and fitted over a revolution, and the residuals of each model.")]
        ),
    ]
    if result.prediction is not None:
        errors = list(result.prediction.rms.items())
        caption = f"{result.prediction.points} points at {result.prediction.speed_rpm:g} r/min, not fitted"
        parts.append(Section("Prediction", [Table(("model", f"rms / {unit}"), errors, caption)]))
    parts.append(Section("Inputs", list(inputs(machine, meanings, besides=("design", "bounds")))))
    parts.append(provenance_section(files.provenance(machine)))
    return page(f"{machine.name}, fitted to measured data", parts, machine.description)


WIDTH = 80


def print_measured(console: Console, result: MeasuredFound) -> None:
    """Print the statement, the treatment of the data, the inputs with intervals, the models, the prediction."""
    _say(f"{result.machine}: {result.statement}.")
    for line in result.treatment:
        _say(f"{line[0].upper()}{line[1:]}.")
    print()
    rows = [(e.name, e.value, e.low95, e.high95, e.unit, "open" if e.open else "") for e in result.fitted]
    console.table(
        f"Fitted (calibrated), with 95 % intervals for {result.noise.model} noise",
        ("input", "value", "from", "to", "unit", ""),
        rows,
    )
    models = [(name, fit.outcome, fit.rms, fit.rms_of_noise, fit.largest_residual, fit.largest_residual_deg,
               f"{fit.agreeing_starts} of {fit.starts}") for name, fit in result.models.items()]  # fmt: skip
    unit = result.unit
    head = ("model", "outcome", f"rms / {unit}", "/ noise", f"largest / {unit}", "at / deg", "agree")
    console.table("Residuals of the fits", head, models)
    first = result.models[result.model]
    if first.correlation is not None:
        names = [str(i) for i in range(1, len(first.fitted) + 1)]
        table = [(str(i), *row) for i, row in enumerate(first.correlation, 1)]
        console.table("Correlation of the inputs, in their order", ("", *names), table)
    if result.prediction is not None:
        prediction = result.prediction
        residuals = ", ".join(f"{name} {value:.4g} {unit}" for name, value in prediction.rms.items())
        _say(f"Predicted at {prediction.speed_rpm:g} r/min ({prediction.points} points), RMS residuals: {residuals}.")


def _say(text: str) -> None:
    print(textwrap.fill(text, WIDTH))
