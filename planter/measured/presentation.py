"""The presentation of a fit to measured data: sections, residuals, fitted machine and figure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from planter.files import units
from planter.files.document import format_lines
from planter.measured.calibration import Calibrated
from planter.measured.curve import is_nuisance
from planter.measured.findings import MeasuredFound
from planter.report import files, style
from planter.report.html import Cell, Items, Keys, Section, Table
from planter.report.presentation import ResultPresentation, list_warning_sections

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.files.document import Document
    from planter.kernels import Array


MACHINE_FILE = "calibrated.toml"
DENSE_DEG = np.linspace(0, 360, 721)


def present_fit(
    document: Document, calibrated: Calibrated, meanings: Mapping[str, str], angle: str
) -> ResultPresentation:
    """Return the presentation of a fit: inputs with intervals, residuals of the models, treatment of the data.

    `meanings` are those of the numbers of the file by path, `angle` is the name of the angle of the drive.
    """
    result = calibrated.result
    return ResultPresentation(
        title=f"{document.name}, fitted to measured data",
        conclusion=f"{result.statement}.",
        record=result,
        sections=list(_list_sections(result)),
        document=document,
        meanings=meanings,
        figures=lambda: {"measured": draw_measured(calibrated, f"{angle} / deg")},
        captions={"measured": "Measured and fitted values over a revolution, and the residuals of each model."},
        tables=lambda: {"residuals.csv": _tabulate_curves(calibrated)},
        comments=files.list_comments(document, "machine"),
        texts=lambda: {} if calibrated.machine is None else {MACHINE_FILE: machine_text(calibrated)},
    )


def _list_sections(result: MeasuredFound) -> Iterator[Section]:
    yield from list_warning_sections(result.warnings)
    noise = {f"noise / {result.unit}": result.noise.std, "points left out": result.left_out}
    yield Section("Data", [Items([f"{line[0].upper()}{line[1:]}." for line in result.treatment]), Keys(noise)])
    head: tuple[str, ...] = ("input", "value", "from", "to", "unit", "", "lower", "upper", "origin")
    rows: list[tuple[Cell, ...]] = [
        (e.name, e.value, e.low95, e.high95, e.unit, "open" if e.open else "", e.lower, e.upper, e.origin)
        for e in result.fitted
    ]
    title = f"Fitted inputs, with 95 % intervals for {result.noise.model} noise"
    yield Section(title, [Table(head, rows, page_columns=head[-3:])])
    head = ("model", "outcome", f"rms / {result.unit}", "/ noise", f"largest / {result.unit}", "at / deg", "agree",
            "rank")  # fmt: skip
    rows = [
        (name, fit.outcome, fit.rms, fit.rms_of_noise, fit.largest_residual, fit.largest_residual_deg,
         f"{fit.agreeing_starts} of {fit.starts}", fit.rank)
        for name, fit in result.models.items()
    ]  # fmt: skip
    yield Section("Residuals of the models", [Table(head, rows, page_columns=("rank",))])
    correlation = result.models[result.model].correlation
    if correlation is not None:
        rows = [(str(i), *row) for i, row in enumerate(correlation, 1)]
        yield Section("Correlation of the inputs, in their order", [Table(("", *(str(row[0]) for row in rows)), rows)])
    if (prediction := result.prediction) is not None:
        title = f"Prediction of {prediction.points} points at {prediction.speed_rpm:g} r/min, which were not fitted"
        yield Section(title, [Table(("model", f"rms / {result.unit}"), [*prediction.rms.items()])])


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
    return "\n".join([*head, "", *format_lines(table, {})]) + "\n"


def _tabulate_curves(calibrated: Calibrated) -> dict[str, Array]:
    """Return measured and computed values over the cycle, in display units."""
    used, unit = calibrated.measured.used, calibrated.result.unit
    columns = {"phi_deg": np.degrees(calibrated.measured.phi[used])}
    columns |= {key_of("measured", unit): calibrated.measured.values[used]}
    return columns | {key_of(model, unit): fit.curve.values - fit.residuals for model, fit in calibrated.fits.items()}


def key_of(name: str, unit: str) -> str:
    """Return the column of a curve in a display unit."""
    suffix = next((end for end in units.SUFFIXES if units.display_unit(end) == unit), "") if unit else ""
    return f"{name}{suffix}"


@style.with_style
def draw_measured(calibrated: Calibrated, angle: str) -> Figure:
    """Draw measured points with the fitted curves of all models, also where nothing was measured, and residuals."""
    unit, columns = calibrated.result.unit, _tabulate_curves(calibrated)
    figure = style.new_figure(5.0)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1])
    phi = np.mod(columns["phi_deg"], 360)
    values = columns[key_of("measured", unit)]
    top.plot(phi, values, "o", color=style.SOFT, markersize=2, label="measured")
    for index, (model, fit) in enumerate(calibrated.fits.items()):
        shade = style.curve_colour(model, index)
        top.plot(DENSE_DEG, fit.curve(fit.values, np.radians(DENSE_DEG))[0], color=shade, label=f"{model} model")
        bottom.plot(phi, values - columns[key_of(model, unit)], "o", color=shade, markersize=1.6)
    bottom.axhline(0, color=style.SOFT, linewidth=0.6)
    top.set_ylabel(f"measured and fitted / {unit}")
    bottom.set_ylabel(f"residual / {unit}")
    style.over_a_turn(bottom, label=False)
    bottom.set_xlabel(angle)
    figure.legend(*top.get_legend_handles_labels(), loc="outside upper right", ncols=3, frameon=False)
    return figure
