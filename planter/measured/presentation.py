"""The presentation of a fit to measured data: sections, residuals, fitted machine and figure."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.engine.wording import name_quantity
from planter.files import units
from planter.files.document import format_lines
from planter.measured.calibration import Calibrated
from planter.measured.curve import MeasuredCurve, find_measured, is_nuisance
from planter.measured.explanations import ExplanationFits
from planter.measured.findings import (
    ExplanationFound,
    FittedInput,
    MeasuredFound,
    MeasuredPreview,
    ModelMeasured,
    Noise,
    Outcome,
    PathFound,
)
from planter.measured.reading import (
    DataReading,
    Measurement,
    describe_dropped,
)
from planter.measured.section import SECTION, MeasurementSection
from planter.numerics.arrays import TURN
from planter.report import files, style
from planter.report.html import Block, Cell, Folded, Items, KeyFigure, Keys, Section, Table
from planter.report.labels import format_name, tabulate_records
from planter.report.presentation import (
    MOST_KEY_FIGURES,
    ResultPresentation,
    list_warning_sections,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.files.document import Document
    from planter.kernels import Array


MACHINE_FILE = "calibrated.toml"
DATA_CAPTION = (
    "What was understood of the file before anything was fitted: the record and its revolutions."
)
EXPLAINED_CAPTION = (
    "Measured values with the rigid machine and the explanations that the data "
    "allow, and residuals."
)
FIT_CAPTION = (
    "Measured and fitted values over a cycle with the 95 % bands of the curves, and the "
    "residuals of each model."
)
REFUTED: Outcome = "not explained"
"""Outcome of a model whose curve has no band, which would be that of noise that is none."""
MOST_DRAWN = 5000
"""Maximum number of points of a drawing."""
OUTLIER = "#c0392b"
LEAST_PROBABILITY, BELOW = 1e-6, "below 1e-6"
"""Probabilities below this are not given as numbers: the model of the noise is less certain than
that.
"""
INPUTS = {"input": "name", "value": "value", "interval": "interval", "unit": "unit"}
PARAMETERS = {
    "parameter": "name",
    "value": "value",
    "interval": "interval",
    "unit": "unit",
    "lower": "lower",
    "upper": "upper",
    "prior uniform in": "prior",
}
CHANNELS = {
    "column": "column",
    "unit": "unit",
    "used": "used",
    "gaps": "gaps",
    "outliers": "outliers",
    "noise": "noise_std",
    "correlation": "noise_rho",
}
"""Columns of tables: attributes of inputs, of parameters of effects, and of measured columns."""
LEGEND_WIDTH, LABEL_WIDTH = 90, 34
"""Characters of a line of a legend, and of the label of an axis."""


def present_fit(
    document: Document, calibrated: Calibrated, meanings: Mapping[str, str], label: str
) -> ResultPresentation:
    """Return the presentation of a fit: inputs with intervals, residuals of the models, treatment
    of the data.

    `meanings` are those of the numbers of the file by path, `label` is that of the angle of the
    drive, or of the time.
    """
    result = calibrated.result
    return ResultPresentation(
        title=f"{document.name}, fitted to measured data",
        **_state(result.statement, result.outcome == REFUTED),
        key_figures=list_fitted_figures(result.fitted),
        record=result,
        sections=list(_list_sections(result)),
        document=document,
        meanings=meanings,
        figures=lambda: {
            "measured": draw_measured(calibrated, label),
            "data": draw_reading(calibrated.measured),
        },
        captions={"data": DATA_CAPTION, "measured": FIT_CAPTION},
        tables=lambda: {"residuals.csv": _tabulate_curves(calibrated)},
        comments=files.list_comments(document, "machine"),
        texts=lambda: write_machine(calibrated.machine, result, f"{result.reached.points} points"),
    )


def _state(statement: str, is_refuted: bool) -> dict[str, Any]:
    """Return the sentence on a fit as what a page opens with: as a failure if no model explains the
    data.
    """
    return {"failures": [f"{statement}."]} if is_refuted else {"conclusion": f"{statement}."}


def list_fitted_figures(fitted: Sequence[FittedInput]) -> list[KeyFigure]:
    """Return inputs with their 95 % intervals, first those whose interval ends within the bounds."""
    ordered = sorted(fitted, key=lambda entry: entry.open)
    return [
        KeyFigure(
            f"{entry.value:.4g}".replace("-", "\N{MINUS SIGN}"), entry.unit, _name_fitted(entry)
        )
        for entry in ordered[:MOST_KEY_FIGURES]
    ]


def _name_fitted(entry: FittedInput) -> str:
    lower, upper = entry.interval
    end = ", which ends at a bound" if entry.open else ""
    return f"{entry.name}, 95 % interval {lower:.4g} to {upper:.4g}{end}"


def present_preview(
    document: Document,
    result: MeasuredPreview,
    measured: Measurement | None,
    meanings: Mapping[str, str],
) -> ResultPresentation:
    """Return the presentation of what was understood of a file, before anything is fitted."""
    has_curves = measured is not None and bool(measured.channels) and not measured.is_path
    sections = [_list_columns(result)]
    conclusion = f"{len(result.columns)} columns; nothing was fitted."
    if (reading := result.reading) is not None:
        sections += list_data_sections(reading, result.treatment)
        speed = (
            ""
            if reading.speed_rpm is None
            else f" at {reading.speed_rpm[0]:.4g} to {reading.speed_rpm[2]:.4g} r/min"
        )
        extent = "as points of a path"
        if reading.revolutions is not None:
            extent = f"over {reading.revolutions:.4g} revolutions"
        elif reading.duration_s is not None:
            extent = f"over {reading.duration_s:.4g} s"
        conclusion = (
            f"{reading.used} of {reading.rows} rows are used, {extent}{speed}; nothing was fitted."
        )
    return ResultPresentation(
        title=f"Measured data for {document.name}",
        conclusion=conclusion,
        record=result,
        sections=sections,
        document=document,
        meanings=meanings,
        figures=lambda: (
            {"data": draw_reading(measured)} if measured is not None and has_curves else {}
        ),
        captions={"data": DATA_CAPTION} if has_curves else {},
    )


def _list_columns(result: MeasuredPreview) -> Section:
    columns = {
        "number": "number",
        "column": "name",
        "unit": "unit",
        "numbers": "numbers",
        "least": "min",
        "greatest": "max",
        "text": "text",
    }
    return Section("Columns", [tabulate_records(result.columns, columns)])


def present_explained(
    document: Document, explained: ExplanationFits, meanings: Mapping[str, str], label: str
) -> ResultPresentation:
    """Return the presentation of what explains a measured curve: explanations compared, parameters,
    inputs, data.
    """
    result = explained.result
    return ResultPresentation(
        title=f"{document.name}: explanations of measured data",
        conclusion=f"{result.statement}.",
        key_figures=list_fitted_figures(result.fitted),
        record=result,
        sections=[
            *_list_explanations(explained),
            *list_data_sections(result.reading, result.treatment),
        ],
        document=document,
        meanings=meanings,
        figures=lambda: {
            "explained": draw_explained(explained, label),
            "data": draw_reading(explained.measured),
        },
        captions={"data": DATA_CAPTION, "explained": EXPLAINED_CAPTION},
        comments=files.list_comments(document, "machine"),
        texts=lambda: _write_explained(explained),
    )


def _list_explanations(explained: ExplanationFits) -> Iterator[Section]:
    result, words = explained.result, {name: fit.words for name, fit in explained.fits.items()}
    ordered = sorted(result.explanations, key=lambda e: -e.log10_bayes)
    base = result.explanations[0].name
    caption = (
        f"p: probability that any of {result.compared} explanations improves {base} as much by "
        f"chance; log10 Bayes: decimal logarithm of the evidence over that of {base}."
    )
    columns: dict[str, str | Callable[[Any], Cell]] = {
        "explanation": lambda e: words[e.name],
        "outcome": "outcome",
        f"rms / {result.unit}": "rms",
        "p": lambda e: _format_probability(e.probability_of_any),
        "log10 Bayes": lambda e: round(e.log10_bayes, 1),
    }
    details: dict[str, str | Callable[[Any], Cell]] = {
        "key": "name",
        "starts": "starts",
        "starts that agree": "agreeing_starts",
        "correlation of the noise": "noise.rho",
        "p of what is left": lambda e: _format_probability(e.lack_of_fit.probability),
    }
    folded = Folded("Fits, by their keys", [tabulate_records(ordered, details)])
    yield Section("Explanations", [tabulate_records(ordered, columns, caption), folded])
    considered = [e for e in result.explanations if e.name in (result.preferred, *result.undecided)]
    tables = [
        tabulate_records(e.parameters, PARAMETERS, words[e.name], list(PARAMETERS)[-3:])
        for e in considered
        if e.parameters
    ]
    if tables:
        yield Section("Parameters, with 95 % intervals", tables)
    caption = f"Fitted inputs, {words[result.preferred]}"
    yield Section("Fitted inputs", [tabulate_records(result.fitted, INPUTS, caption)])


def _format_probability(probability: float | None) -> Cell:
    """Return a probability as a cell, without digits if it is as good as zero, empty for None."""
    if probability is None:
        return ""
    return probability if probability > LEAST_PROBABILITY else BELOW


def list_data_sections(reading: DataReading, treatment: Sequence[str]) -> Iterator[Section]:
    """Yield the section on how a file was read and what was left out."""
    dropped_rows = {describe_dropped(entry) for entry in reading.dropped}
    lines = [f"{line[0].upper()}{line[1:]}." for line in treatment if line not in dropped_rows]
    extents = {
        "revolutions": reading.revolutions,
        "step / deg": reading.step_deg,
        "duration / s": reading.duration_s,
        "step / s": reading.step_s,
    }
    keys: dict[str, Cell] = {name: value for name, value in extents.items() if value is not None}
    if reading.speed_rpm is not None:
        names = ("least", "mean", "greatest")
        keys |= {
            f"{name} speed / (r/min)": v for name, v in zip(names, reading.speed_rpm, strict=True)
        }
    blocks: list[Block] = [Items(lines)]
    if keys:
        blocks.append(Keys(keys))
    if reading.channels:
        blocks.append(tabulate_records(reading.channels, CHANNELS))
    if reading.dropped:
        dropped = {"rows": "count", "left out": "reason", "lines": "lines"}
        blocks.append(tabulate_records(reading.dropped, dropped))
    yield Section("Data", blocks, detail=True)


def _list_sections(result: MeasuredFound) -> Iterator[Section]:
    yield from list_warning_sections(result.warnings)
    yield build_fitted_section(result.fitted, result.noise)
    unit = result.unit
    place = ("at / deg", "largest_residual_deg")
    if result.reading.duration_s is not None:
        place = ("at / s", "largest_residual_s")
    columns = {
        "outcome": "outcome",
        f"rms / {unit}": "rms",
        "/ noise": "rms_of_noise",
        f"largest / {unit}": "largest_residual",
        "p": "lack_of_fit.probability",
        "starts": "starts",
        "agree": "agreeing_starts",
        place[0]: place[1],
        "rank": "rank",
    }
    tables = [
        tabulate_records([fit], columns, f"{name} model", (place[0], "rank"))
        for name, fit in result.models.items()
    ]
    yield Section("Residuals of the models", tables)
    channels = result.models[result.model].channels
    if len(channels) > 1:
        columns = {
            "quantity": "quantity",
            "unit": "unit",
            "points": "points",
            "rms": "rms",
            "noise": "noise.std",
            "correlation": "noise.rho",
        }
        title = f"Residuals of the quantities, {result.model} model"
        yield Section(title, [tabulate_records(channels, columns)])
    yield from list_correlation_sections(result.models[result.model])
    if (prediction := result.prediction) is not None:
        title = (
            f"Prediction of {prediction.points} points at {prediction.speed_rpm:g} r/min, "
            f"which were not fitted"
        )
        yield Section(title, [Table(("model", f"rms / {result.unit}"), [*prediction.rms.items()])])
    yield from list_data_sections(result.reading, result.treatment)


def build_fitted_section(fitted: Sequence[FittedInput], noise: Noise) -> Section:
    """Return the section on fitted inputs, with their intervals for a noise."""
    words = "white noise" if noise.model == "white" else f"noise correlated by {noise.rho:.2f}"
    further = {"open": "open", "lower": "lower", "upper": "upper", "origin": "origin"}
    table = tabulate_records(fitted, INPUTS | further, "", list(further)[1:])
    return Section(f"Fitted inputs, with 95 % intervals for {words}", [table])


def list_correlation_sections(fit: ModelMeasured) -> Iterator[Section]:
    """Yield the section on the correlation of fitted inputs, unless the data leave some open."""
    if fit.correlation is not None:
        rows: list[list[Cell]] = [[str(i), *row] for i, row in enumerate(fit.correlation, 1)]
        table = Table(("", *(str(row[0]) for row in rows)), rows)
        yield Section("Correlation of the inputs, in their order", [table], detail=True)


def _write_explained(explained: ExplanationFits) -> dict[str, str]:
    result = explained.result
    has_effects = bool(explained.fits[result.preferred].effects)
    if not has_effects and all(is_nuisance(entry.name) for entry in result.fitted):
        return {}
    source = f"{result.reading.used} points, {result.preferred}"
    return write_machine(explained.machine, result, source, has_effects)


def write_machine(
    machine: Document | None,
    result: MeasuredFound | ExplanationFound | PathFound,
    source: str,
    is_sensor_fitted: bool = False,
) -> dict[str, str]:
    """Return the machine file (TOML) with the fitted inputs by its name, and with nuisance
    parameters as comments at its top; nothing without a machine.
    """
    if machine is None:
        return {}
    fitted, origin = result.fitted, f"calibrated ({result.model} model, {source})"
    table = machine.written_table()
    names = [entry.name for entry in fitted if not is_nuisance(entry.name)]
    origins = {name: words for name, words in machine.origins.items() if name not in names}
    if is_sensor_fitted and SECTION in table:
        keys = {SECTION, *MeasurementSection.model_fields}
        origins = {
            name: words
            for name, words in origins.items()
            if name.removeprefix(f"{SECTION}.") not in keys
        }
        names.append(SECTION)
    table["origin"] = origins | {name.partition("[")[0]: origin for name in names}
    nuisances = [f"# {e.name} = {e.value!r}" for e in fitted if is_nuisance(e.name)]
    head = [f"# {machine.name}, inputs fitted to measured data: {result.statement}.", *nuisances]
    return {MACHINE_FILE: "\n".join([*head, "", *format_lines(table, {})]) + "\n"}


def _tabulate_curves(calibrated: Calibrated) -> dict[str, Array]:
    """Return measured and computed values of the first quantity over the cycle, with 95 % bands, in
    display units.
    """
    used, unit = calibrated.measured.used, calibrated.result.unit
    first = next(iter(calibrated.fits.values())).curve
    key = "phi_deg" if first.duration is None else "t_s"
    columns = {key: first.to_places(calibrated.measured.phi[used])}
    columns |= {key_of("measured", unit): calibrated.measured.values[used]}
    bands = {}
    for model, fit in calibrated.fits.items():
        points = fit.curve.channels[0]
        columns[key_of(model, unit)] = computed = (fit.curve.values - fit.residuals)[points]
        if calibrated.result.models[model].outcome != REFUTED:
            half_width = fit.curve_band(fit.curve.phi[points])[1][0]
            bands[key_of(f"{model}_low95", unit)] = computed - half_width
            bands[key_of(f"{model}_high95", unit)] = computed + half_width
    return columns | bands


def key_of(name: str, unit: str) -> str:
    """Return the column of a curve in a display unit."""
    suffix = (
        next((end for end in units.SUFFIXES if units.display_unit(end) == unit), "") if unit else ""
    )
    return f"{name}{suffix}"


@dataclass(frozen=True)
class _FittedCurve:
    """A curve of a figure: values (d,) at its angles, half the width of its band or None, and the
    residuals (m,) of the points.
    """

    label: str
    shade: str
    values: Array
    half_widths: Array | None
    residuals: Array


def _draw_channel(
    panels: Sequence[Axes],
    points: tuple[Array, Array, str],
    dense: Array,
    curves: Iterable[_FittedCurve],
    labels: tuple[str, str],
) -> None:
    """Draw measured points (angles [deg] or times [s], values, label) with curves at such, and their
    residuals below; `labels` are the quantity and its unit.
    """
    top, bottom = panels
    phi, values, label = points
    thin = slice(None, None, 1 + len(phi) // MOST_DRAWN)
    phi = phi[thin]
    phi = np.where((phi < 0) | (phi > dense[-1]), np.mod(phi, dense[-1]), phi)
    top.plot(phi, values[thin], "o", color=style.SOFT, markersize=2, label=label)
    for curve in curves:
        top.plot(dense, curve.values, color=curve.shade, label=curve.label)
        if curve.half_widths is not None:
            low, high = curve.values - curve.half_widths, curve.values + curve.half_widths
            top.fill_between(dense, low, high, color=curve.shade, alpha=0.25, linewidth=0)
        bottom.plot(phi, curve.residuals[thin], "o", color=curve.shade, markersize=1.6)
    bottom.axhline(0, color=style.SOFT, linewidth=0.6)
    name, unit = labels
    top.set_ylabel(f"{name} / {unit or '1'}")
    bottom.set_ylabel(f"residual / {unit or '1'}")


def _list_angles(curve: MeasuredCurve) -> Array:
    """Return the angles [rad] of a cycle at which curves are drawn, half a degree apart."""
    end = curve.machine.turn
    return np.linspace(0, end, round(2 * np.degrees(end)) + 1)


@style.with_style
def draw_measured(calibrated: Calibrated, angle: str) -> Figure:
    """Draw measured points with the fitted curves of all models, also where nothing was measured,
    and residuals.
    """
    first = next(iter(calibrated.fits.values())).curve
    count, angles = len(first.keys), _list_angles(first)
    dense = first.to_places(angles)
    figure = style.new_figure(5.0 if count == 1 else 2.6 * count + 2)
    panels = figure.subplots(2 * count, 1, sharex=True, height_ratios=[1.6, 1] * count)
    bands = {model: fit.curve_band(angles) for model, fit in calibrated.fits.items()}
    for k, (key, unit, points) in enumerate(
        zip(first.keys, first.units, first.channels, strict=True)
    ):
        curves = []
        for index, (model, fit) in enumerate(calibrated.fits.items()):
            values, half_widths = bands[model]
            is_refuted = calibrated.result.models[model].outcome == REFUTED
            curves.append(
                _FittedCurve(
                    f"{model} model",
                    style.curve_colour(model, index),
                    values[k],
                    None if is_refuted else half_widths[k],
                    fit.residuals[points],
                )
            )
        measured = first.to_places(first.phi[points]), first.values[points], "measured"
        name = format_name("measured and fitted" if count == 1 else key)
        _draw_channel(panels[2 * k : 2 * k + 2], measured, dense, curves, (name, unit))
    style.over_a_turn(panels[-1], label=False, end=dense[-1])
    panels[-1].set_xlabel(angle)
    style.add_legend(figure, panels[0], 3)
    return figure


@style.with_style
def draw_explained(explained: ExplanationFits, angle: str) -> Figure:
    """Draw measured points with the rigid curve and those of the explanations that the data allow,
    and residuals.
    """
    figure = style.new_figure(5.0)
    panels = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1])
    result, fits = explained.result, explained.fits
    preferred = fits[result.preferred].fit
    first, dense = preferred.curve, np.degrees(_list_angles(preferred.curve))
    drift = first.drift(preferred.values)[0]
    label = "measured, less the drift" if drift.any() else "measured"
    names = dict.fromkeys([fits[result.preferred].base, result.preferred, *result.undecided[:2]])
    curves = []
    for index, name in enumerate(names):
        fit = fits[name].fit
        values = fit.curve.evaluate(fit.values, np.radians(dense))[0][0]
        words, shade = (
            textwrap.fill(fits[name].words, LEGEND_WIDTH),
            style.curve_colour(name, index),
        )
        curves.append(_FittedCurve(words, shade, values, None, fit.residuals))
    quantity = name_quantity(find_measured(first.machine, result.quantity))
    points = np.degrees(first.phi), first.values - drift, label
    labels = textwrap.fill(quantity, LABEL_WIDTH), result.unit
    _draw_channel(panels, points, dense, curves, labels)
    style.over_a_turn(panels[1], label=False, end=dense[-1])
    panels[1].set_xlabel(angle)
    style.add_legend(figure, panels[0])
    return figure


@style.with_style
def draw_reading(measured: Measurement) -> Figure:
    """Draw the record over its revolutions, and these over each other, with outliers; that of what
    moves freely over its time.
    """
    count = len(measured.channels)
    figure = style.new_figure(1.0 + 2.6 * count)
    revolutions = (measured.phi - measured.phi.min()) / TURN
    places = {"revolutions": revolutions, "angle / deg": np.degrees(measured.phi) % 360}
    if measured.duration is not None:
        places = {"time / s": revolutions * measured.duration}
    widths = [2, 1][: len(places)]
    grid = figure.subplots(count, len(places), squeeze=False, width_ratios=widths)
    thin = slice(None, None, 1 + len(revolutions) // MOST_DRAWN)
    shade = style.curve_colour("exact", 0)
    for panels, channel in zip(grid, measured.channels, strict=True):
        used, values = np.flatnonzero(channel.used)[thin], channel.values
        out = np.flatnonzero(np.isfinite(values) & ~channel.used)
        low, high = float(values[used].min()), float(values[used].max())
        margin = 0.1 * ((high - low) or 1.0)
        # outliers beyond the edge do not hide the curve
        clipped = np.clip(values[out], low - margin, high + margin)
        for axes, x in zip(panels, places.values(), strict=True):
            axes.plot(x[used], values[used], ".", color=shade, markersize=1.5)
            axes.plot(x[out], clipped, "x", color=OUTLIER, markersize=5)
            axes.set_ylim(low - 1.5 * margin, high + 1.5 * margin)
        panels[0].set_ylabel(f"{channel.name} / {channel.unit or '1'}")
        panels[0].set_title(f"record, noise {channel.noise:.2g} {channel.unit}", loc="left")
        if measured.duration is None:
            panels[1].set_title(f"{revolutions.max():.3g} revolutions", loc="left")
    for axes, label in zip(grid[-1], places, strict=True):
        axes.set_xlabel(label)
    return figure
