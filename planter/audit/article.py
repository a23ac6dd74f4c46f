"""An equation's trial on the page: as printed, as derived, its smallest correction, what it lacks or has too much.

Formulas come typeset, as MathML, from where the equations were judged; here they are only placed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

from planter.audit import markup, tables
from planter.audit.markup import Raw, mark

Entry = Mapping[str, Any]
QUIET = ("confirmed", "confirmed as rebuilt", "untested", "definition", "reconstructed")
"""Verdicts that leave nothing to correct."""
_LONG = 240
"""Characters from which a formula is set smaller."""


def overview(found: Sequence[Entry]) -> str:
    """All equations in a table, each with a link to its trial."""
    rows = [(Raw(f'<a href="#{place(e)}">{escape(e["equation"])}</a>'), e.get("claims", ""), e["legibility"],
             mark(e["verdict"]), tables.hangs_on(e)) for e in found]  # fmt: skip
    return markup.table(("equation", "claims to be", "legibility", "verdict", "hangs on"), rows, "tight")


def place(entry: Entry) -> str:
    """The id of an equation on the page."""
    return escape(f"{entry['paper']}-{entry['equation']}".replace(" ", "-").replace("'", "-"))


def trial(entry: Entry, shown: Entry) -> str:
    """The whole trial of one equation; ``shown`` is what is typeset of it."""
    head = f"<h4>({escape(entry['equation'])}) {escape(entry.get('claims', ''))} {mark(entry['verdict']).markup}</h4>"
    body = "".join(_parts(entry, shown))
    kind = escape(entry["verdict"].replace(" ", "-"))
    return f'<article id="{place(entry)}" class="{kind}">{head}{body}</article>'


def _parts(entry: Entry, shown: Entry) -> Iterator[str]:
    printed, derived = entry.get("printed", ""), entry.get("derived", "")
    lost = entry["legibility"] == "lost"
    if printed and printed == derived:
        label = "as rebuilt and as derived" if lost else "as printed and as derived"
        yield _formula(label, printed, shown["printed"])
    else:
        for label, side in (("as rebuilt" if lost else "as printed", "printed"), ("as derived", "derived")):
            if entry.get(side):
                yield _formula(label, entry[side], shown[side])
    if entry["verdict"] not in QUIET or entry.get("domain"):
        yield f"<p>{shown['finding'][:1].upper()}{shown['finding'][1:]}.</p>"
    if shown["correction"]:
        name = "Smallest correction" if len(shown["correction"]) == 1 else "Smallest corrections, any of them"
        yield f"<p><strong>{name}:</strong> {'; or '.join(shown['correction'])}.</p>"
    yield from _terms("terms that the print lacks", entry["terms"], shown["terms"])
    yield from _terms("printed terms that nothing explains", entry.get("unexplained", ()), shown["unexplained"])
    yield from _vanishing(entry.get("vanishing", ()), shown["vanishing"])
    if shown["reading"]:
        yield f'<p class="note">Read so: {shown["reading"]}.</p>'
    if entry.get("rebuilt"):
        yield f'<p class="note">Completed: {escape("; ".join(entry["rebuilt"]))}.</p>'
    if entry.get("fragile"):
        yield '<p class="note">One character decides this: it may be an error of reading the print.</p>'
    yield from _depends(entry, shown.get("depends", ()))


def _depends(entry: Entry, readings: Sequence[Entry]) -> Iterator[str]:
    """The verdict under every reading that the paper admits."""
    if readings:
        said = "The same under every reading." if entry["robust"] else "It depends on the reading."
        rows = [(*(Raw(one[key]) for key in ("reading", "because")), mark(one["verdict"]), Raw(one["finding"]))
                for one in readings]  # fmt: skip
        head = ("reading", "admitted by", "verdict", "finding")
        yield f'<p class="note">{said}</p>{markup.table(head, rows, "tight")}'


def _formula(label: str, text: str, math: str) -> str:
    kind = "formula long" if len(text) > _LONG else "formula"
    return f'<p class="label">{label}</p><div class="{kind}">{math}</div>'


def _terms(label: str, terms: Sequence[Entry], math: Sequence[str]) -> Iterator[str]:
    if terms:
        ordered = sorted(zip(terms, math, strict=True), key=lambda pair: -(pair[0]["share_of_largest"] or 0))
        rows = [(Raw(m), _size(t["max_abs"]), _unit(t["unit"]), markup.bar(t["share_of_largest"])) for t, m in ordered]
        head = (label, "largest over the cycle", "unit", "share of the largest derived term")
        yield markup.table(head, rows, "terms tight")


def _size(value: float | None) -> float | str:
    return "no real value" if value is None else float(value)


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _vanishing(terms: Sequence[Entry], math: Sequence[Entry]) -> Iterator[str]:
    if terms:
        rows = [(Raw(m["term"]), Raw(m["because"]), "yes" if t.get("printed") else "no")
                for t, m in zip(terms, math, strict=True)]  # fmt: skip
        yield markup.table(("terms that do not show", "because", "printed"), rows, "terms tight")
