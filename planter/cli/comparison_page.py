"""The presentation of a comparison: a sentence, tables side by side, and curves with their
differences.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from planter.cli.machine_comparison import (
    MARGIN,
    DesignComparison,
    find_objective_owner,
    find_violations,
    list_main_results,
    list_verdicts,
)
from planter.cli.results import (
    ComparedCurve,
    ComparedRequirement,
    ComparedResult,
    ComparedValue,
)
from planter.engine.summary import ROUNDING
from planter.kernels import Array
from planter.report import files
from planter.report.html import Cell, KeyFigure, MarkupCell, Section, Table, Text, escape_markup
from planter.report.presentation import (
    MOST_KEY_FIGURES,
    ResultPresentation,
    describe_failure,
    shorten_failures,
)
from planter.report.style import Panel, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure


MOST_LOADS = 12
"""Forces, torques and powers in the main table; the page has all results that differ."""
MOST_VALUES = 20
"""Values that differ in the main part of the page."""
SEARCH = ("bounds.", "genetic_algorithm.")
"""Sections of files that concern the search alone, whose values only the page has."""
EXACT = (
    "True extremes and integrals of a cycle; smaller is better for the objective, larger for "
    "a margin."
)
LONGEST_LINE = 40
"""Characters of a line of an axis's name."""
CURVES = (
    "Curves of the machines on one scale; below, the differences from A. Angles are those of the "
    "drive."
)


def present_comparison(comparison: DesignComparison) -> ResultPresentation:
    """Return the presentation of a comparison."""
    result, first = comparison.result, comparison.designs[0].machine
    lettered = list(zip(comparison.letters, comparison.designs, strict=True))
    names = [f"{letter} {Path(design.source).name}" for letter, design in lettered]
    versions = files.list_provenance(first.document)
    provenance = {key: versions[key] for key in ("planter", "casadi", "numpy", "python")}
    hashes = {
        f"{letter} sha256": files.list_provenance(design.machine.document)["machine_sha256"]
        for letter, design in lettered
    }
    return ResultPresentation(
        title=f"Comparison: {', '.join(names)}",
        conclusion=describe_comparison(comparison),
        failures=_list_failures(comparison),
        key_figures=list(_list_key_figures(comparison)),
        record=result,
        sections=list(_list_sections(comparison)),
        figures=partial(_draw, comparison),
        captions={_name_figure(curve): CURVES for curve in result.curves},
        details=partial(_list_details, comparison),
        tables=partial(_tabulate_curves, comparison),
        comments=[f"{key}: {value}" for key, value in (provenance | hashes).items()],
        provenance=provenance | hashes,
    )


def describe_comparison(comparison: DesignComparison) -> str:
    """Return what differs, which machine has the best objective, and which violate requirements, in
    a sentence each.
    """
    result, letters = comparison.result, comparison.letters
    if not result.values and not any(any(row.difference) for row in result.results):
        return "No value and no result differs."
    count = len(result.values)
    sentences = [
        f"{count or 'No'} value{'s' * (count != 1)} of the files differ{'s' * (count <= 1)}."
    ]
    objective = next((row for row in result.results if row.name == "objective"), None)
    if objective is not None:
        parts = ", ".join(
            f"{letter} {_number(value)}"
            for letter, value in zip(letters, objective.values, strict=True)
        )
        violated = find_violations(comparison)
        best = _describe_best(objective, letters, [bool(names) for names in violated])
        owner = letters[comparison.designs.index(find_objective_owner(comparison.designs))]
        sentences.append(f"Objective of {owner}'s file: {parts}; {best}.")
    if result.requirements:
        verdicts = list_verdicts(comparison)
        counts = [Counter(row.values()) for row in verdicts]
        notes = [f" ({count[None]} do not apply)" if count[None] else "" for count in counts]
        parts = ", ".join(
            f"{letter} {count[True]}{note}"
            for letter, count, note in zip(letters, counts, notes, strict=True)
        )
        sentences.append(f"Requirements that are satisfied, of {len(verdicts[0])}: {parts}.")
    return " ".join(sentences)


def _describe_best(
    objective: ComparedResult, letters: Sequence[str], violates: Sequence[bool]
) -> str:
    """Return which machine has the best objective among those that satisfy all requirements."""
    allowed = [k for k, fails in enumerate(violates) if not fails]
    if not allowed:
        return "none of them satisfies all requirements, so none is best"
    values = {k: objective.values[k] for k in allowed}
    numbers = {k: value for k, value in values.items() if value is not None}
    if len(allowed) == len(letters):
        better = objective.better
        return "no machine is best" if better is None else f"{letters[better]} is best"
    names = ", ".join(letters[k] for k in range(len(letters)) if violates[k])
    verb = "violates" if sum(violates) == 1 else "violate"
    if not numbers:
        return f"{names} {verb} requirements"
    best = min(numbers, key=lambda k: numbers[k])
    among = " of those that satisfy all requirements" if len(allowed) > 1 else ""
    sole = "" if among else ", which alone satisfies all requirements,"
    return f"{letters[best]}{sole} is best{among}; {names} {verb} requirements"


def _list_failures(comparison: DesignComparison) -> list[str]:
    """Return a sentence for each requirement that a machine violates, with its value, those of the
    first machine first.
    """
    stated = {name: k for k, names in enumerate(find_violations(comparison)) for name in names}
    failures = []
    for k, design in enumerate(comparison.designs):
        for row in comparison.result.requirements if stated else ():
            if row.met[k] is False:
                name, _, _ = row.limit_on.rpartition(" >= ")
                upper, _, _ = row.limit_on.rpartition(" <= ")
                limit = (row.limit, None) if name else (None, row.limit)
                check = design.checks.get(name or upper)
                angle = check.phi_deg if check is not None else None
                words = f"{comparison.letters[k]}, {(check and check.label) or name or upper},"
                place = "" if angle is None else f"{angle:.4g} deg"
                failures.append(describe_failure(words, row.values[k], limit, row.unit, place))
    return shorten_failures(failures)


def _list_key_figures(comparison: DesignComparison) -> Iterator[KeyFigure]:
    """Yield the change of the objective, satisfied requirements, and the largest change of a load."""
    result, last = comparison.result, comparison.letters[-1]
    main = list_main_results(comparison, MOST_LOADS)
    changed = [row for row in main if row.difference[-1] and row.values[0]]
    figures = [_describe_change(comparison, row) for row in changed]
    if result.requirements:
        verdicts = list_verdicts(comparison)[-1]
        met = sum(is_met is True for is_met in verdicts.values())
        count = KeyFigure(f"{met} of {len(verdicts)}", "", f"requirements satisfied by {last}")
        figures.insert(1, count)
    yield from figures[:MOST_KEY_FIGURES]


def _describe_change(comparison: DesignComparison, row: ComparedResult) -> KeyFigure:
    """Return the change of a result of the last machine against the first."""
    last = comparison.letters[-1]
    share = _find_share(row.values[0], row.difference[-1]) or 0.0
    percent = f"{share:+.3g} %".replace("-", "\N{MINUS SIGN}")
    words, _ = _describe_result(comparison, row.name)
    values = f"A {_shorten(row.values[0])}, {last} {_shorten(row.values[-1])} {row.unit}".rstrip()
    return KeyFigure(percent, "", f"{words}: {values}")


def _shorten(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"


def _list_sections(comparison: DesignComparison) -> Iterator[Section]:
    result, letters = comparison.result, comparison.letters
    main = list_main_results(comparison, MOST_LOADS)
    if result.requirements:
        yield Section("Requirements", [_tabulate_requirements(comparison)])
    if main:
        yield Section("Results", [_tabulate_results(comparison, main), Text(EXACT, "note")])
    rows = [row for row in result.values if not row.name.startswith(SEARCH)]
    if rows:
        table = _tabulate_values(rows, letters)
        yield Section("Values that differ", [table], detail=len(rows) > MOST_VALUES)


def _tabulate_values(rows: Sequence[ComparedValue], letters: Sequence[str]) -> Table:
    return Table(("value", *letters, "unit"), [(row.name, *row.values, row.unit) for row in rows])


def _tabulate_requirements(comparison: DesignComparison) -> Table:
    """Return values and verdicts of all requirements, and which machine has the largest margin."""
    letters = comparison.letters
    margins = {row.name: row for row in comparison.result.results}
    head = (
        "requirement",
        *(text for letter in letters for text in (letter, f"{letter} is")),
        "unit",
        "better",
    )
    rows = [
        (
            _typeset_limit(row.limit_on),
            *_list_verdicts(row),
            row.unit,
            _name_better(margins[f"{MARGIN}{row.limit_on}"], letters),
        )
        for row in comparison.result.requirements
    ]
    return Table(head, rows)


def _typeset_limit(limit: str) -> MarkupCell:
    return MarkupCell(
        limit,
        escape_markup(
            limit.replace("<=", "\N{LESS-THAN OR EQUAL TO}").replace(
                ">=", "\N{GREATER-THAN OR EQUAL TO}"
            )
        ),
    )


def _describe_result(comparison: DesignComparison, name: str) -> tuple[str, bool]:
    """Return the name of a result with the meaning of its quantity, and whether it names one."""
    measure, _, quantity = name.rpartition(" ")
    meaning = comparison.meanings.get(quantity)
    return (f"{meaning}, {measure}", True) if measure and meaning else (name, False)


def _head_result(comparison: DesignComparison, name: str) -> str:
    """Return the name of a result, on a page with the meaning of its quantity below."""
    words, is_named = _describe_result(comparison, name)
    return (
        MarkupCell(name, f"{escape_markup(words)} <small>{escape_markup(name)}</small>")
        if is_named
        else name
    )


def _list_verdicts(row: ComparedRequirement) -> Iterator[Cell]:
    words = {True: "met", False: "violated", None: None}
    for value, is_met in zip(row.values, row.met, strict=True):
        yield from (value, words[is_met])


def _name_better(row: ComparedResult, letters: Sequence[str]) -> str | None:
    return None if row.better is None else letters[row.better]


def _tabulate_results(comparison: DesignComparison, rows: Sequence[ComparedResult]) -> Table:
    letters = comparison.letters
    changes = [f"{letter} \N{MINUS SIGN} A" for letter in letters[1:]]
    percents = [f"{change} / %" for change in changes]
    head = ("result", *letters, *changes, *percents, "unit", "better")
    return Table(head, [_list_cells(comparison, row) for row in rows], page_columns=changes)


def _list_cells(comparison: DesignComparison, row: ComparedResult) -> tuple[Cell, ...]:
    shares = [_find_share(row.values[0], difference) for difference in row.difference]
    return (
        _head_result(comparison, row.name),
        *row.values,
        *row.difference,
        *shares,
        row.unit,
        _name_better(row, comparison.letters),
    )


def _find_share(first: float | None, difference: float | None) -> float | None:
    """Return a difference in percent of the first value to three digits, None where that is zero or
    unknown.
    """
    return (
        None if not first or difference is None else float(f"{100 * difference / abs(first):.3g}")
    )


def _list_details(comparison: DesignComparison) -> Iterator[Section]:
    """Yield all results that differ, and the values of the search that do."""
    search = [row for row in comparison.result.values if row.name.startswith(SEARCH)]
    if search:
        yield Section(
            "Values of the search that differ", [_tabulate_values(search, comparison.letters)]
        )
    differing = [row for row in comparison.result.results if any(row.difference)]
    if differing:
        yield Section("All results that differ", [_tabulate_results(comparison, differing)])


def _name_figure(curve: ComparedCurve) -> str:
    return "".join(c if c.isalnum() else "_" for c in curve.name)


def _draw(comparison: DesignComparison) -> Mapping[str, Figure]:
    return {
        _name_figure(curve): draw_comparison(
            curve, comparison.letters, comparison.meanings.get(curve.name, curve.name)
        )
        for curve in comparison.result.curves
    }


def draw_comparison(curve: ComparedCurve, letters: Sequence[str], meaning: str) -> Figure:
    """Draw a quantity of all machines over a cycle, and the differences from the first machine
    below, if there are any.

    Differences below rounding of the largest value are zero.
    """
    moves = curve.phi_deg is None
    angles, values = np.array(curve.t_s if moves else curve.phi_deg), np.array(curve.values)
    differences = values[1:] - values[0]
    differences[np.abs(differences) <= ROUNDING * np.abs(values).max()] = 0.0
    unit = f" / {curve.unit}" if curve.unit else ""
    rows = dict(zip(letters, ((angles, row) for row in values), strict=True))
    panels = [Panel(fill(f"{meaning}{unit}", LONGEST_LINE), rows)]
    if differences.any():
        changes = {
            f"{letter} \N{MINUS SIGN} A": (angles, row)
            for letter, row in zip(letters[1:], differences, strict=True)
        }
        panels.append(Panel(f"difference{unit}", changes, level=0.0))
    if moves:
        return draw_panels(panels, "time / s", end=float(angles[-1]))
    end = round(float(angles[-1] + angles[1]), 6)
    return draw_panels(panels, "angle of the drive / deg", end=end)


def _tabulate_curves(comparison: DesignComparison) -> Mapping[str, Mapping[str, Array]]:
    curves = comparison.result.curves
    if not curves:
        return {}
    first = curves[0]
    columns: dict[str, Array] = (
        {"t_s": np.array(first.t_s)}
        if first.phi_deg is None
        else {"phi_deg": np.array(first.phi_deg)}
    )
    for curve in curves:
        unit = f" [{curve.unit}]" if curve.unit else ""
        for letter, row in zip(comparison.letters, curve.values, strict=True):
            columns[f"{curve.name} {letter}{unit}"] = np.array(row)
    return {"curves.csv": columns}
