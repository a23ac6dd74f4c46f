"""A field test's evaluation as files: summary.json, CSV tables, figures and report.html."""

from __future__ import annotations

import hashlib
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.clutch.field import figures, tables
from planter.clutch.field.evaluation import FieldEvaluation
from planter.clutch.field.trial import Factor
from planter.clutch.results.field import FieldTest
from planter.files import csv_rows
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.html import Block, Cell, FigureSvg, Folded, Items, Keys, Section, Table, Text, page
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Rows = list[Sequence[Any]]
MOST_ROWS = 500
"""Combinations of levels that the page shows; prediction.csv holds all."""


def write_field_report(out: str | Path, evaluation: FieldEvaluation, progress: Listener | None = None) -> None:
    """Write all files into a folder, or none. Raises InputError if the folder cannot be written."""
    files.output_folder(out)
    summary = files.summary_text({**evaluation.result.table(), "provenance": build_provenance(evaluation)})
    listing = {
        f"{name}.csv": csv_rows.written([f"data: {evaluation.result.source}"], head, rows)
        for name, (head, rows) in list_tables(evaluation.result).items()
    }
    saved = bundle.drawn(draw_figures(evaluation), progress)
    report = render_page(evaluation, {name: figure.svg for name, figure in saved.items()})
    bundle.write(out, {"summary.json": summary, **listing, "report.html": report}, saved)


def build_provenance(evaluation: FieldEvaluation) -> dict[str, Any]:
    """Return versions, and a hash of all evaluated values."""
    trial = evaluation.trial
    values = [
        *((f.name, f.levels, f.codes.tolist()) for f in (*trial.factors, *trial.blanks)),
        *((response.name, response.values.tolist()) for response in trial.responses),
        *(vars(sample) for sample in evaluation.samples),
    ]
    versions = {name: metadata.version(name) for name in ("numpy", "scipy")}
    digest = hashlib.sha256(repr(values).encode("utf-8")).hexdigest()
    return {"planter": __version__, **versions, "python": platform.python_version(), "data_sha256": digest}


def list_tables(result: FieldTest) -> dict[str, tuple[Sequence[str], Rows]]:
    """Return head and rows of every table."""
    factors, responses = result.factors, result.responses
    listing: dict[str, tuple[Sequence[str], Rows]] = {}
    if result.range:
        listing["range"] = (("response", "factor", "level", "k", "R"), list(tables.range_rows(result)))
    columns = ("response", "source", "ss", "df", "ms", "F", "p")
    listing["anova"] = (columns, [row[: len(columns)] for row in tables.anova_rows(result)])
    predicted: Rows = [(*row.levels, *(row.means[name] for name in responses)) for row in result.prediction]
    listing["prediction"] = ((*factors, *responses), predicted)
    pairs = [*result.comparison, *result.other_comparisons]
    if pairs:
        listing["comparison"] = (tuple(pairs[0].table()), [tuple(pair.table().values()) for pair in pairs])
    return listing


def draw_figures(evaluation: FieldEvaluation) -> dict[str, Figure]:
    """Return the figures by the names of their files."""
    trial = evaluation.trial
    order = order_factors(evaluation)
    labels = {response.name: response.label for response in trial.responses}
    plots = {"effects": figures.draw_effects(evaluation, order)}
    if figures.has_surface(order):
        for index, response in enumerate(trial.responses, 1):
            plots[surface_name(response.name, index)] = figures.draw_response_surface(evaluation, response, order)
    if evaluation.samples:
        plots["comparison"] = figures.draw_comparison(evaluation.samples, labels)
    return plots


def surface_name(response: str, index: int) -> str:
    """Return the name of a response's figure: the response's name if it is a valid file name.

    >>> surface_name("Y1", 1), surface_name("Y 1/2", 3)
    ('surface_Y1', 'surface_3')
    """
    return f"surface_{response}" if re.fullmatch(r"[A-Za-z]\w*", response, re.ASCII) else f"surface_{index}"


def order_factors(evaluation: FieldEvaluation) -> list[Factor]:
    """Return all factors in the order of the design, or if they are many, by their largest share of a variation."""
    factors = list(evaluation.trial.factors)
    if len(factors) <= figures.SURFACE_FACTORS:
        return factors
    anova = evaluation.result.anova.values()
    share = {f.name: max(table[f.name].ss / (table["total"].ss or 1) for table in anova) for f in factors}
    return sorted(factors, key=lambda factor: -share[factor.name])


def render_page(evaluation: FieldEvaluation, svgs: Mapping[str, str]) -> str:
    """Return the page of an evaluation, with the SVG texts of its figures."""
    result = evaluation.result
    facts: dict[str, Cell] = {"runs": result.runs, "factors": ", ".join(result.factors)}
    facts |= {"responses": ", ".join(result.responses), "sums of squares": result.sums_of_squares}
    facts |= {f"goal of {name}": goal for name, goal in result.goals.items()}
    subtitle = "Main effects, prediction and comparison from the runs of a field test"
    first: list[Block] = [Keys(facts)]
    if result.warnings:
        first.append(Items([f"{warning}." for warning in result.warnings], "warning"))
    sections = [Section("The test", [*first, _meanings(evaluation)]), *_sections(result, svgs)]
    sections.append(Section("How this was computed", [Keys(build_provenance(evaluation))]))
    return page(f"Field test {result.source}", sections, subtitle)


def _meanings(evaluation: FieldEvaluation) -> Block:
    rows = [
        (f.name, f.label, ", ".join(map(str, f.levels)), ", ".join(f"{v:g}" for v in f.values) if f.values else None)
        for f in evaluation.trial.factors
    ]
    return Table(("factor", "meaning", "levels", "values"), rows)


def _sections(result: FieldTest, svgs: Mapping[str, str]) -> Iterator[Section]:
    caption = "Predicted mean at each level (blue), single runs (grey), mean of all runs (dashed)"
    if result.best:
        caption += ", the levels that are best by the response's goal (green)"
    effects: list[Block] = [FigureSvg(svgs["effects"], caption)]
    if result.range:
        effects.append(Table(tables.RANGE, list(tables.range_rows(result)), "Range analysis"))
    yield Section("Effects", effects)
    stars = "** p < 0.01, * p < 0.05; mean squares and F from unrounded sums"
    yield Section("Analysis of variance", [Table(tables.ANOVA, list(tables.anova_rows(result))), Text(stars, "note")])
    yield Section("Prediction", list(_prediction(result, svgs)))
    if result.comparison or result.other_comparisons:
        yield Section("Comparison of clutches", list(_comparison(result, svgs)))


def _prediction(result: FieldTest, svgs: Mapping[str, str]) -> Iterator[Block]:
    head = tuple(result.factors)
    if result.best:
        yield Table(tables.BEST + head, list(tables.best_rows(result)), "Best levels")
    note = "The prediction adds main effects: interactions, if there are any, are neither in it nor tested."
    yield Text(note, "note")
    surfaces = [name for name in svgs if name.startswith("surface")]
    for name in surfaces:
        caption = "Additive prediction over pairs of factors, the others at their middle level; contours below"
        yield FigureSvg(svgs[name], caption)
    rows = list(tables.prediction_rows(result))
    ordered = ", best by mean rank first" if result.goals else ""
    title = f"{min(len(rows), MOST_ROWS)} of {len(rows)} combinations{ordered}"
    yield Folded(title, [Table((*head, *result.responses), rows[:MOST_ROWS])])


def _comparison(result: FieldTest, svgs: Mapping[str, str]) -> Iterator[Block]:
    yield FigureSvg(svgs["comparison"], "Mean and standard deviation")
    for pairs, title in ((result.comparison, "The first two clutches"), (result.other_comparisons, "Other pairs")):
        if pairs:
            yield Table(tables.COMPARISON, list(tables.comparison_rows(pairs)), title)
    yield Text("p: Welch's test; Holm: the same, held together over all pairs", "note")
