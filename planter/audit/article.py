"""An equation on the audit's page: as printed, as derived, smallest correction, missing and unexplained terms.

Formulas are typeset as MathML when the equations are judged; this module only arranges them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

from planter.audit import markup, tables
from planter.audit.markup import Raw, mark_verdict

Entry = Mapping[str, Any]
QUIET = ("confirmed", "confirmed as rebuilt", "untested", "definition", "reconstructed")
"""Verdicts without a correction."""
_LONG = 240
"""Characters from which a formula is set smaller."""


def format_overview(equations: Sequence[Entry]) -> str:
    """Return the table of all equations, each with a link to its article."""
    rows = [(Raw(f'<a href="#{equation_id(e)}">{escape(e["equation"])}</a>'), e.get("claims", ""), e["legibility"],
             mark_verdict(e["verdict"]), tables.list_conditions(e)) for e in equations]  # fmt: skip
    return markup.format_table(("equation", "claims to be", "legibility", "verdict", "hangs on"), rows, "tight")


def equation_id(entry: Entry) -> str:
    """Return the id of an equation on the page."""
    return escape(f"{entry['paper']}-{entry['equation']}".replace(" ", "-").replace("'", "-"))


def format_trial(entry: Entry, typeset: Entry) -> str:
    """Return the article of an equation; `typeset` are its formulas as MathML."""
    verdict = mark_verdict(entry["verdict"]).markup
    head = f"<h4>({escape(entry['equation'])}) {escape(entry.get('claims', ''))} {verdict}</h4>"
    body = "".join(_list_parts(entry, typeset))
    kind = escape(entry["verdict"].replace(" ", "-"))
    return f'<article id="{equation_id(entry)}" class="{kind}">{head}{body}</article>'


def _list_parts(entry: Entry, typeset: Entry) -> Iterator[str]:
    printed, derived = entry.get("printed", ""), entry.get("derived", "")
    lost = entry["legibility"] == "lost"
    if printed and printed == derived:
        label = "as rebuilt and as derived" if lost else "as printed and as derived"
        yield _formula(label, printed, typeset["printed"])
    else:
        for label, side in (("as rebuilt" if lost else "as printed", "printed"), ("as derived", "derived")):
            if entry.get(side):
                yield _formula(label, entry[side], typeset[side])
    if entry["verdict"] not in QUIET or entry.get("domain"):
        yield f"<p>{typeset['finding'][:1].upper()}{typeset['finding'][1:]}.</p>"
    if typeset["correction"]:
        name = "Smallest correction" if len(typeset["correction"]) == 1 else "Smallest corrections, any of them"
        yield f"<p><strong>{name}:</strong> {'; or '.join(typeset['correction'])}.</p>"
    yield from _format_terms("terms that the print lacks", entry["terms"], typeset["terms"])
    yield from _format_terms(
        "printed terms that nothing explains", entry.get("unexplained", ()), typeset["unexplained"]
    )
    yield from _format_vanishing(entry.get("vanishing", ()), typeset["vanishing"])
    if typeset["reading"]:
        yield f'<p class="note">Read so: {typeset["reading"]}.</p>'
    if entry.get("rebuilt"):
        yield f'<p class="note">Completed: {escape("; ".join(entry["rebuilt"]))}.</p>'
    if entry.get("fragile"):
        yield '<p class="note">One character decides this: it may be an error of reading the print.</p>'
    yield from _format_readings(entry, typeset.get("depends", ()))


def _format_readings(entry: Entry, readings: Sequence[Entry]) -> Iterator[str]:
    """Yield the verdict under every reading that the paper admits."""
    if readings:
        verdict = "The same under every reading." if entry["robust"] else "It depends on the reading."
        rows = [
            (
                *(Raw(reading[key]) for key in ("reading", "because")),
                mark_verdict(reading["verdict"]),
                Raw(reading["finding"]),
            )
            for reading in readings
        ]
        head = ("reading", "admitted by", "verdict", "finding")
        yield f'<p class="note">{verdict}</p>{markup.format_table(head, rows, "tight")}'


def _formula(label: str, text: str, math: str) -> str:
    kind = "formula long" if len(text) > _LONG else "formula"
    return f'<p class="label">{label}</p><div class="{kind}">{math}</div>'


def _format_terms(label: str, terms: Sequence[Entry], math: Sequence[str]) -> Iterator[str]:
    if terms:
        ordered = sorted(zip(terms, math, strict=True), key=lambda pair: -(pair[0]["share_of_largest"] or 0))
        rows = [
            (Raw(m), _format_size(t["max_abs"]), _format_unit(t["unit"]), markup.format_bar(t["share_of_largest"]))
            for t, m in ordered
        ]
        head = (label, "largest over the cycle", "unit", "share of the largest derived term")
        yield markup.format_table(head, rows, "terms tight")


def _format_size(value: float | None) -> float | str:
    return "no real value" if value is None else float(value)


def _format_unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _format_vanishing(terms: Sequence[Entry], math: Sequence[Entry]) -> Iterator[str]:
    if terms:
        rows = [(Raw(m["term"]), Raw(m["because"]), "yes" if t.get("printed") else "no")
                for t, m in zip(terms, math, strict=True)]  # fmt: skip
        yield markup.format_table(("terms that do not show", "because", "printed"), rows, "terms tight")
