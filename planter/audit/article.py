"""An equation's trial on the page: as printed, as derived, its smallest correction, what it lacks or has too much."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

from planter.audit import markup
from planter.audit.markup import Raw, mark

Entry = Mapping[str, Any]
QUIET = ("confirmed", "definition", "reconstructed")
"""Verdicts that leave nothing to correct."""
_LONG = 240
"""Characters from which a formula is set smaller."""


def overview(found: Sequence[Entry]) -> str:
    """All equations in a table, each with a link to its trial."""
    rows = [(Raw(f'<a href="#{place(e)}">{escape(e["equation"])}</a>'), e.get("claims", ""), e["legibility"],
             mark(e["verdict"])) for e in found]  # fmt: skip
    return markup.table(("equation", "claims to be", "legibility", "verdict"), rows, "tight")


def place(entry: Entry) -> str:
    """The id of an equation on the page."""
    return escape(f"{entry['paper']}-{entry['equation']}".replace(" ", "-").replace("'", "-"))


def trial(entry: Entry) -> str:
    """The whole trial of one equation."""
    head = f"<h4>({escape(entry['equation'])}) {escape(entry.get('claims', ''))} {mark(entry['verdict']).markup}</h4>"
    return f'<article id="{place(entry)}" class="{escape(entry["verdict"])}">{head}{"".join(_parts(entry))}</article>'


def _parts(entry: Entry) -> Iterator[str]:
    printed, derived = entry.get("printed", ""), entry.get("derived", "")
    lost = entry["legibility"] == "lost"
    if printed and printed == derived:
        yield _formula("as rebuilt and as derived" if lost else "as printed and as derived", printed, entry)
    else:
        yield from (_formula(label, text, entry)
                    for label, text in (("as rebuilt" if lost else "as printed", printed), ("as derived", derived))
                    if text)  # fmt: skip
    if entry["verdict"] not in QUIET:
        yield f"<p>{markup.prose(entry['finding'][:1].upper() + entry['finding'][1:])}.</p>"
    corrections = entry["correction"]
    if corrections:
        name = "Smallest correction" if len(corrections) == 1 else "Smallest corrections, any of them"
        yield f"<p><strong>{name}:</strong> {'; or '.join(map(markup.prose, corrections))}.</p>"
    yield from _terms("terms that the print lacks", entry["terms"])
    yield from _terms("printed terms that nothing explains", entry.get("unexplained", ()))
    yield from _vanishing(entry.get("vanishing", ()))
    if entry["reading"]:
        yield f'<p class="note">Read so: {markup.prose(entry["reading"])}.</p>'


def _formula(label: str, text: str, entry: Entry) -> str:
    kind = "formula long" if len(text) > _LONG else "formula"
    defines = entry.get("defines", "")
    shown = markup.equation(text, bool(defines) or not entry.get("printed"), defines)
    return f'<p class="label">{label}</p><div class="{kind}">{shown}</div>'


def _terms(label: str, terms: Sequence[Entry]) -> Iterator[str]:
    if terms:
        ordered = sorted(terms, key=lambda t: -(t["share_of_largest"] or 0))
        rows = [(markup.term(t["term"]), _size(t["max_abs"]), _unit(t["unit"]), markup.bar(t["share_of_largest"]))
                for t in ordered]  # fmt: skip
        head = (label, "largest over the cycle", "unit", "share of the largest derived term")
        yield markup.table(head, rows, "terms tight")


def _size(value: float | None) -> float | str:
    return "no real value" if value is None else float(value)


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _vanishing(terms: Sequence[Entry]) -> Iterator[str]:
    if terms:
        rows = [
            (markup.term(t["term"]), Raw(markup.prose(t["because"])), "yes" if t.get("printed") else "no")
            for t in terms
        ]
        yield markup.table(("terms that do not show", "because", "printed"), rows, "terms tight")
