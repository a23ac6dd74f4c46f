"""Files of the audit: summary.json, and report.html with every equation as printed and as derived, and its verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from planter.audit import tables
from planter.audit.attainable_front import list_front_sections, write_front
from planter.audit.equation_page import (
    QUIET,
    STYLE,
    Cell,
    Raw,
    format_items,
    format_overview,
    format_paragraph,
    format_table,
    format_trial,
    mark_verdict,
)
from planter.audit.verdicts import HEADLINE
from planter.report import files
from planter.report.folder import renews
from planter.report.html import Keys, Section, page
from planter.version import __version__

Entry = Mapping[str, Any]
PARTS = ("consequences", "laws", "causes", "references", "equations", "claims", "numbers")
TITLES = {
    "consequences": "What follows",
    "laws": "Laws of the chain as a whole",
    "causes": "Causes",
    "references": "References",
    "equations": "Equations",
    "claims": "Statements",
    "numbers": "Numbers",
}
TRANSCRIBED = "The equations were audited as transcribed, each against an independent derivation."
SOURCE = (
    "The machine-read text of each paper was audited, not its page images; gaps that were filled in are listed, and a "
    "finding that depends on one character may be an error of reading. If a symbol is ambiguous, the reading most "
    "favourable to the paper counts."
)
_ORDER = ("not reproduced", "not recomputable", "consistent", "reproduced")
"""Verdicts on numbers, the most serious first."""


@renews
def write_audit(out: str | Path, result: Mapping[str, Any], typeset: Entry) -> None:
    """Write summary.json and report.html with the `typeset` formulas by paper and equation.

    Raises InputError if the folder cannot be written.
    """
    folder = files.output_folder(out)
    files.write_summary(folder / "summary.json", {**result, "provenance": {"planter": __version__}})
    files.write_text(folder / "report.html", format_page(result, typeset))
    if "front" in result:
        write_front(folder, result["front"])


def format_page(result: Mapping[str, Any], typeset: Entry) -> str:
    """Return the page of an audit."""
    subtitle = "Every equation, law, statement and number of the papers, as printed, derived anew and judged"
    return page("Formula audit", list(list_sections(result, typeset)), subtitle, STYLE)


def list_sections(result: Mapping[str, Any], typeset: Entry) -> Iterator[Section]:
    """Yield a summary, each paper, and the glossary."""
    yield Section("Summary", [Raw(format_summary(result))])
    for name, counted in result["summary"].items():
        yield Section(counted["title"], [Raw(format_paper(name, result, typeset.get(name, {})))])
    if "front" in result:
        yield from list_front_sections(result["front"])
    yield Section("What the words mean", [Keys(MEANINGS)])


def format_summary(result: Mapping[str, Any]) -> str:
    """Return the counts of verdicts, and the main findings of each paper."""
    rows = [(s["title"], tables.format_tally(s["equations"]), f"{s['at_fault']} equations, {s['causes']} causes",
             tables.format_tally(s["numbers"])) for s in result["summary"].values()]  # fmt: skip
    all_printed = all(e["legibility"] == "printed" and not e["rebuilt"] for e in result["equations"])
    parts = [
        format_paragraph(TRANSCRIBED if all_printed else SOURCE),
        format_table(("paper", "equations", "at fault", "numbers"), rows, "tight"),
    ]
    for name, counted in result["summary"].items():
        paper_findings = list(list_findings({part: _select_paper(result.get(part, ()), name) for part in PARTS}))
        if paper_findings:
            parts.append(f"<h3>{escape(counted['title'])}</h3>{format_items(paper_findings)}")
    return "\n".join(parts)


def list_findings(parts: Mapping[str, Sequence[Entry]]) -> Iterator[str]:
    """Yield the main findings of a paper: broken laws, changed headline numbers, consequences, false statements."""
    broken = [e for e in parts["laws"] if e["caused_by"]]
    if broken and broken[0].get("owed"):
        yield f"{_capitalise(broken[0]['law'])}: {broken[0]['owed']}"
    if broken:
        listed = "; ".join(f"{e['law']} (by {tables.format_amount(e['violation'], e['unit'])})" for e in broken)
        yield f"Of {len(parts['laws'])} laws the chain as a whole breaks {len(broken)}: {listed}."
    compared = [e for e in parts["consequences"] if e["printed"] is not None and e["about"] != HEADLINE]
    if compared:
        yield tables.compare_numbers(compared)
    for entry in parts["consequences"]:
        if entry["statement"]:
            yield entry["statement"]
        elif entry["about"] == HEADLINE:
            yield tables.describe_headline(entry)
    failing = [e for e in parts["claims"] if not e["holds"]]
    for entry in failing:
        yield f"Not so: {entry['claim']}. {tables.describe_measure(entry)}."


def format_paper(name: str, result: Mapping[str, Any], typeset: Entry) -> str:
    """Return the part of a paper, with a line of contents."""
    bodies = _BODIES | {"equations": lambda entries: format_equations(entries, typeset)}
    parts = {part: _select_paper(result.get(part, ()), name) for part in PARTS}
    present = [part for part in PARTS if parts[part]]
    links = "".join(f'<a href="#{name}-{part}">{TITLES[part]}</a>' for part in present)
    sections_html = (f'<h3 id="{name}-{part}">{TITLES[part]}</h3>{bodies[part](parts[part])}' for part in present)
    return f'<nav class="paper" aria-label="{escape(name)}">{links}</nav>\n' + "\n".join(sections_html)


def format_equations(entries: Sequence[Entry], typeset: Entry) -> str:
    """Return all equations in a table, then the article of each, those with a finding first.

    `typeset` has their formulas as MathML from the time of judging.
    """
    loud = [e for e in entries if e["verdict"] not in QUIET]
    quiet = [e for e in entries if e["verdict"] in QUIET]
    return "\n".join([format_overview(entries), *(format_trial(e, typeset[e["equation"]]) for e in (*loud, *quiet))])


def format_laws(entries: Sequence[Entry]) -> str:
    """Return the laws that a printed chain satisfies or breaks, and the equations that break them."""
    sizes = ("violation", "violation_literal")
    rows = [
        (e["law"], *(e[size] for size in sizes), e["unit"], tables.list_repairs(e), e.get("search", ""))
        for e in entries
    ]
    head = ("law", "broken by", "read literally", "unit", "restored by repairing", "search for the smallest set")
    parts = [format_paragraph(f"{text}.") for text in dict.fromkeys(tables.describe_readings(entries))]
    parts += [format_table(head, rows, "tight"), *(_format_shares(law) for law in entries if law.get("shares"))]
    parts += [format_paragraph(f"{_capitalise(e['law'])}: {e['owed']}.") for e in entries if e["violation"] is None]
    return "\n".join(parts)


def _format_shares(law: Entry) -> str:
    """Return the sentence on the cause of a broken law and, for several equations, the share of each."""
    if len(law["shares"]) == 1:
        return format_paragraph(f"{_capitalise(law['law'])}: {law['owed']}")
    rows = [(s["equation"], *(float(s[key]) for key in ("alone", "without", "shapley"))) for s in law["shares"]]
    head = ("equation", f"its repair alone takes away [{law['unit']}]", "it alone leaves", "Shapley value")
    title = f"<h4>{escape(law['law'])}</h4>"
    return f"{title}{format_paragraph(law['owed'])}{format_table(head, rows, 'tight')}"


def _capitalise(text: str) -> str:
    """Return a sentence with a capital first letter."""
    return f"{text[:1].upper()}{text[1:]}"


def format_causes(entries: Sequence[Entry]) -> str:
    """Return findings by cause: the equations and numbers that one error affects."""
    rows = [
        (e["cause"], ", ".join(n.partition(": ")[2] for n in e["equations"]), float(len(e["numbers"]))) for e in entries
    ]
    return format_table(("one slip", "equations", "numbers that its repair cures"), rows, "tight")


def format_references(entries: Sequence[Entry]) -> str:
    """Return the cross-references that cannot be right."""
    return "\n".join(format_paragraph(tables.describe_reference(e)) for e in entries)


def format_claims(entries: Sequence[Entry]) -> str:
    """Return the statements of the text with their measures."""
    head = ("statement", "measure", "value", "unit", "must", "verdict", "assumed")
    return format_table(head, map(_list_claim_cells, entries), "tight")


def _list_claim_cells(entry: Entry) -> tuple[Cell, ...]:
    must = Raw(f'<span class="must">{escape(entry["must"])}</span>')
    verdict = mark_verdict("holds" if entry["holds"] else "fails")
    value, assumed = tables.clean_zero(entry["value"]), ", ".join(entry["assumed_inputs"])
    return entry["claim"], entry["measure"], value, entry["unit"], must, verdict, assumed


def format_consequences(entries: Sequence[Entry]) -> str:
    """Return headline numbers by the equations as printed and as derived, then the consequences."""
    parts = []
    for about in dict.fromkeys(e["about"] for e in entries):
        rows = [
            (
                e["quantity"],
                e["unit"],
                e["printed"] if e["printed"] is None else float(e["printed"]),
                tables.clean_zero(e["as_printed"]),
                tables.clean_zero(e["as_derived"]),
                ", ".join(e["rests_on"]),
            )
            for e in entries
            if e["about"] == about
        ]
        head = (about, "unit", "in the paper", "by the print", "as derived", "rests on")
        parts.append(format_table(head, rows, "tight"))
    statements = [e["statement"] for e in entries if e["statement"]]
    parts += [format_items(statements)] if statements else []
    assumed: list[str] = max((e["assumed_inputs"] for e in entries), key=len, default=[])
    if assumed:
        parts.append(format_paragraph(f"Assumed for this: {', '.join(assumed)}.", "note"))
    return "\n".join(parts)


def format_numbers(entries: Sequence[Entry]) -> str:
    """Return numbers in a table for each verdict, with notes on their inputs."""
    notes = tables.Notes()
    parts = []
    for verdict in (v for v in _ORDER if any(e["verdict"] == v for e in entries)):
        chosen = [e for e in entries if e["verdict"] == verdict]
        rows = [(e["quantity"], e["place"], e["unit"], Raw(escape(e["printed_text"])), e["recomputed"],
                 e["difference"] if verdict == "not reproduced" else "", notes.mark(tables.describe_basis(e)))
                for e in chosen]  # fmt: skip
        parts.append(f"<h4>{mark_verdict(verdict).markup} {len(chosen)}</h4>")
        head = ("quantity", "place", "unit", "printed", "recomputed", "differs by", "note")
        parts.append(format_table(*_drop_empty_columns(head, rows), "tight"))
    listed = "".join(f"<li>{escape(text)}</li>" for text in notes.texts)
    return "\n".join([*parts, f'<ol class="notes">{listed}</ol>' if listed else ""])


def _drop_empty_columns(head: Sequence[str], rows: Sequence[Sequence[Cell]]) -> tuple[list[str], list[list[Cell]]]:
    """Return a table without empty columns."""
    columns = [k for k in range(len(head)) if any(row[k] != "" for row in rows)]
    return [head[k] for k in columns], [[row[k] for k in columns] for row in rows]


_BODIES: dict[str, Callable[[Sequence[Entry]], str]] = {
    "consequences": format_consequences,
    "laws": format_laws,
    "causes": format_causes,
    "references": format_references,
    "claims": format_claims,
    "numbers": format_numbers,
}


def _select_paper(entries: Sequence[Entry], paper: str) -> list[Entry]:
    return [e for e in entries if e["paper"] == paper]


MEANINGS = {
    "confirmed": "the derivation gives the same",
    "confirmed as rebuilt": "the same, where pieces of the machine-read text were completed",
    "untested": "a definition, or a naming, that nothing here can test",
    "misprint": "what differs is removed by one or two edits",
    "incomplete": "the print lacks terms that the derivation has",
    "contradicted": "a printed term is neither derived nor explained by an edit",
    "reconstructed": "the print is lost; the derivation stands alone",
    "definition": "names a quantity, and agrees with what else the paper prints of it",
    "not judged": "the equation could not be judged, for the reason that stands with it",
    "hangs on": "a reading that the paper leaves open, a single character that may be misread, pieces completed, the "
    "domain of use: it holds where the machine uses it, and not everywhere",
    "repaired alone, left alone, Shapley": "what an equation's repair takes away, what it leaves when all others are "
    "repaired, and the mean over all orders of repair",
    "reproduced": "equal at the printed precision, from disclosed inputs only",
    "consistent": "equal within the rounding of the printed inputs; or equal by assumed inputs that meet more printed "
    "values than they are many",
    "not reproduced": "differs, from disclosed inputs only: by what was computed less what is printed",
    "not recomputable": "rests on inputs that the paper does not disclose",
    "by the print": "computed with the equations as printed, misprints included",
    "as derived": "computed with the same inputs from the equations derived here",
    "holds, fails": "the measure is, or is not, what the statement needs; with assumed inputs, for these alone",
}
