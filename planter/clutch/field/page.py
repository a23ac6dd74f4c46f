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
from planter.clutch.field.evaluation import Evaluation
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


def write(out: str | Path, found: Evaluation, progress: Listener | None = None) -> None:
    """Writes everything into a folder, whole or not at all. Raises InputError for one that cannot be written."""
    files.output_folder(out)
    summary = files.summary_text({**found.result.table(), "provenance": provenance(found)})
    listing = {
        f"{name}.csv": csv_rows.written([f"data: {found.result.source}"], head, rows)
        for name, (head, rows) in listed(found.result).items()
    }
    drawn = bundle.drawn(drawings(found), progress)
    report = html(found, {name: figure.svg for name, figure in drawn.items()})
    bundle.write(out, {"summary.json": summary, **listing, "report.html": report}, drawn)


def provenance(found: Evaluation) -> dict[str, Any]:
    """Versions, and a hash of every value that was evaluated."""
    trial = found.trial
    values = [
        *((f.name, f.levels, f.codes.tolist()) for f in (*trial.factors, *trial.blanks)),
        *((response.name, response.values.tolist()) for response in trial.responses),
        *(vars(sample) for sample in found.samples),
    ]
    versions = {name: metadata.version(name) for name in ("numpy", "scipy")}
    digest = hashlib.sha256(repr(values).encode("utf-8")).hexdigest()
    return {"planter": __version__, **versions, "python": platform.python_version(), "data_sha256": digest}


def listed(result: FieldTest) -> dict[str, tuple[Sequence[str], Rows]]:
    """Head and rows of every table."""
    factors, responses = result.factors, result.responses
    found: dict[str, tuple[Sequence[str], Rows]] = {}
    if result.range:
        found["range"] = (("response", "factor", "level", "k", "R"), list(tables.ranges(result)))
    columns = ("response", "source", "ss", "df", "ms", "F", "p")
    found["anova"] = (columns, [row[: len(columns)] for row in tables.anova(result)])
    predicted: Rows = [(*row.levels, *(row.means[name] for name in responses)) for row in result.prediction]
    found["prediction"] = ((*factors, *responses), predicted)
    pairs = [*result.comparison, *result.other_comparisons]
    if pairs:
        found["comparison"] = (tuple(pairs[0].table()), [tuple(pair.table().values()) for pair in pairs])
    return found


def drawings(found: Evaluation) -> dict[str, Figure]:
    """Figures by the names of their files."""
    trial = found.trial
    order = leading(found)
    labels = {response.name: response.label for response in trial.responses}
    drawn = {"effects": figures.effects(found, order)}
    if figures.has_surface(order):
        for index, response in enumerate(trial.responses, 1):
            drawn[surface_name(response.name, index)] = figures.surface(found, response, order)
    if found.samples:
        drawn["comparison"] = figures.comparison(found.samples, labels)
    return drawn


def surface_name(response: str, index: int) -> str:
    """Name of a response's figure: its own name where a file may have it.

    >>> surface_name("Y1", 1), surface_name("Y 1/2", 3)
    ('surface_Y1', 'surface_3')
    """
    return f"surface_{response}" if re.fullmatch(r"[A-Za-z]\w*", response, re.ASCII) else f"surface_{index}"


def leading(found: Evaluation) -> list[Factor]:
    """All factors: in their own order, or if they are many, those with the largest share of a variation first."""
    factors = list(found.trial.factors)
    if len(factors) <= figures.SURFACE_FACTORS:
        return factors
    anova = found.result.anova.values()
    share = {f.name: max(table[f.name].ss / (table["total"].ss or 1) for table in anova) for f in factors}
    return sorted(factors, key=lambda factor: -share[factor.name])


def html(found: Evaluation, drawn: Mapping[str, str]) -> str:
    """The page of an evaluation, with the SVG texts of its figures."""
    result = found.result
    told: dict[str, Cell] = {"runs": result.runs, "factors": ", ".join(result.factors)}
    told |= {"responses": ", ".join(result.responses), "sums of squares": result.sums_of_squares}
    told |= {f"goal of {name}": goal for name, goal in result.goals.items()}
    subtitle = "Main effects, prediction and comparison from the runs of a field test"
    first: list[Block] = [Keys(told)]
    if result.warnings:
        first.append(Items([f"{warning}." for warning in result.warnings], "warning"))
    sections = [Section("The test", [*first, _meanings(found)]), *_sections(result, drawn)]
    sections.append(Section("How this was computed", [Keys(provenance(found))]))
    return page(f"Field test {result.source}", sections, subtitle)


def _meanings(found: Evaluation) -> Block:
    rows = [
        (f.name, f.label, ", ".join(map(str, f.levels)), ", ".join(f"{v:g}" for v in f.values) if f.values else None)
        for f in found.trial.factors
    ]
    return Table(("factor", "meaning", "levels", "values"), rows)


def _sections(result: FieldTest, drawn: Mapping[str, str]) -> Iterator[Section]:
    caption = "Predicted mean at each level (blue), single runs (grey), mean of all runs (dashed)"
    if result.best:
        caption += ", the levels that are best by the response's goal (green)"
    effects: list[Block] = [FigureSvg(drawn["effects"], caption)]
    if result.range:
        effects.append(Table(tables.RANGE, list(tables.ranges(result)), "Range analysis"))
    yield Section("Effects", effects)
    stars = "** p < 0.01, * p < 0.05; mean squares and F from unrounded sums"
    yield Section("Analysis of variance", [Table(tables.ANOVA, list(tables.anova(result))), Text(stars, "note")])
    yield Section("Prediction", list(_prediction(result, drawn)))
    if result.comparison or result.other_comparisons:
        yield Section("Comparison of clutches", list(_comparison(result, drawn)))


def _prediction(result: FieldTest, drawn: Mapping[str, str]) -> Iterator[Block]:
    head = tuple(result.factors)
    if result.best:
        yield Table(tables.BEST + head, list(tables.best(result)), "Best levels")
    note = "The prediction adds main effects: interactions, if there are any, are neither in it nor tested."
    yield Text(note, "note")
    surfaces = [name for name in drawn if name.startswith("surface")]
    for name in surfaces:
        caption = "Additive prediction over pairs of factors, the others at their middle level; contours below"
        yield FigureSvg(drawn[name], caption)
    rows = list(tables.predictions(result))
    ordered = ", best by mean rank first" if result.goals else ""
    title = f"{min(len(rows), MOST_ROWS)} of {len(rows)} combinations{ordered}"
    yield Folded(title, [Table((*head, *result.responses), rows[:MOST_ROWS])])


def _comparison(result: FieldTest, drawn: Mapping[str, str]) -> Iterator[Block]:
    yield FigureSvg(drawn["comparison"], "Mean and standard deviation")
    for pairs, title in ((result.comparison, "The first two clutches"), (result.other_comparisons, "Other pairs")):
        if pairs:
            yield Table(tables.COMPARISON, list(tables.comparisons(pairs)), title)
    yield Text("p: Welch's test; Holm: the same, held together over all pairs", "note")
