"""An equation on the page of the audit: as printed, as derived, smallest correction, missing and unexplained terms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from planter.audit import tables
from planter.report.html import cell_text


@dataclass(frozen=True)
class Raw:
    """Complete markup: a block of the page, or a cell of a table."""

    markup: str

    def html(self, name: str) -> str:
        return self.markup


Cell = Raw | str | float | None


def format_table(head: Sequence[str], rows: Iterable[Sequence[Cell]], kind: str = "") -> str:
    """Return a table with right-aligned numbers to six digits; its first column names the rows."""
    class_text = f' class="{kind}"' if kind else ""
    top = "".join(f'<th scope="col">{escape(text)}</th>' for text in head)
    body = "\n".join(f"<tr>{''.join(_format_cell(i, cell) for i, cell in enumerate(row))}</tr>" for row in rows)
    return (
        f'<div class="wide"><table{class_text}><thead><tr>{top}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>'
    )


def _format_cell(index: int, cell: Cell) -> str:
    content = (
        cell.markup if isinstance(cell, Raw) else format_number(cell) if isinstance(cell, float) else cell_text(cell)
    )
    if index == 0:
        return f'<th scope="row">{content}</th>'
    return f'<td class="number">{content}</td>' if cell is None or isinstance(cell, float) else f"<td>{content}</td>"


def format_number(value: float) -> str:
    """Return a number to six digits, with a power of ten as superscript.

    >>> format_number(0.5), format_number(62.33105858)
    ('0.5', '62.3311')
    """
    mantissa, _, exponent = f"{value:.6g}".replace("-", "\N{MINUS SIGN}").partition("e")
    if not exponent:
        return mantissa
    power = exponent.lstrip("+").replace("\N{MINUS SIGN}0", "\N{MINUS SIGN}")
    return f"{mantissa}\N{MULTIPLICATION SIGN}10<sup>{power.lstrip('0')}</sup>"


def mark_verdict(word: str, kind: str = "") -> Raw:
    """Return a coloured verdict."""
    return Raw(f'<span class="mark {escape((kind or word).replace(" ", "-"))}">{escape(word)}</span>')


def format_bar(share: float | None) -> Raw:
    """Return a share of the largest term as a bar and in per cent."""
    if share is None:
        return Raw("\N{EN DASH}")
    width = min(100.0, 100 * share)
    return Raw(f'<span class="bar"><span style="width: {width:.3g}%"></span></span> {format_number(100 * share)} %')


def format_paragraph(text: str, kind: str = "") -> str:
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def format_items(texts: Iterable[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in texts)}</ul>"


STYLE = """\
:root { --good: #0b6b50; --doubt: #8a5a00; --bad: #a8321a; --bar: #0072b2; }
@media (prefers-color-scheme: dark) { :root { --good: #6fd3b1; --doubt: #e9b75a; --bad: #ff9d84; --bar: #56b4e9; } }
body { max-width: 60rem; }
h3 { font-size: 1.05rem; margin: 1.8rem 0 .4rem; }
h4 { font-size: 1rem; font-weight: 600; margin: 0 0 .3rem; }
article { margin: 1rem 0; padding: .7rem 0 .2rem .9rem; border-left: 3px solid var(--rule); }
article.incomplete { border-left-color: var(--doubt); }
article.misprint { border-left-color: var(--doubt); }
article.contradicted { border-left-color: var(--bad); }
article > p { margin: .5rem 0; }
.label { color: var(--soft); font-size: .85rem; margin: .5rem 0 0; }
.formula { overflow-x: auto; overflow-y: hidden; padding: .15rem 0; }
math { font-size: 1.1em; font-family: "STIX Two Math", "Cambria Math", "Latin Modern Math", "Libertinus Math", math; }
math[display="block"] { margin: .2rem 0 .2rem 1rem; text-align: left; display: block math; width: fit-content; }
math mtd { padding: .12em 0; }
math mtd + mtd { padding-left: 1.2em; }
.long math { font-size: 1em; }
td math, th math { font-size: 1em; }
.mark { font-size: .85em; white-space: nowrap; color: var(--soft); }
.mark.confirmed, .mark.reproduced, .mark.holds { color: var(--good); }
.mark.misprint, .mark.incomplete, .mark.not-recomputable { color: var(--doubt); }
.mark.contradicted, .mark.not-reproduced, .mark.fails { color: var(--bad); font-weight: 600; }
h4 .mark { margin-left: .4rem; font-size: .9em; }
.bar { display: inline-block; width: 5rem; height: .55rem; background: var(--rule); margin-right: .4rem; }
.bar > span { display: block; height: 100%; background: var(--bar); }
table.terms td:last-child { white-space: nowrap; }
table.tight { font-size: .82rem; }
.must { white-space: nowrap; }
nav.paper { margin: .4rem 0 0; font-size: .92rem; }
nav.paper a { margin-right: 1rem; }
sup { font-size: .75em; line-height: 0; }
ol.notes { font-size: .85rem; color: var(--soft); list-style: lower-alpha; }
@media print { :root { --good: #0b6b50; --doubt: #8a5a00; --bad: #a8321a; --bar: #0072b2; }
  article { break-inside: auto; } h3, h4, .label { break-after: avoid; } .formula { overflow: visible; }
  .bar, .bar > span { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  .long math { font-size: .95em; } nav.paper { display: none; } }
"""


Entry = Mapping[str, Any]
QUIET = ("confirmed", "confirmed as rebuilt", "untested", "definition", "reconstructed")
"""Verdicts without a correction."""
_LONG = 240
"""Characters from which a formula is set smaller."""


def format_overview(equations: Sequence[Entry]) -> str:
    """Return the table of all equations, each with a link to its article."""
    rows = [(Raw(f'<a href="#{equation_id(e)}">{escape(e["equation"])}</a>'), e.get("claims", ""), e["legibility"],
             mark_verdict(e["verdict"]), tables.list_conditions(e)) for e in equations]  # fmt: skip
    return format_table(("equation", "claims to be", "legibility", "verdict", "hangs on"), rows, "tight")


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
        yield f'<p class="note">{verdict}</p>{format_table(head, rows, "tight")}'


def _formula(label: str, text: str, math: str) -> str:
    kind = "formula long" if len(text) > _LONG else "formula"
    return f'<p class="label">{label}</p><div class="{kind}">{math}</div>'


def _format_terms(label: str, terms: Sequence[Entry], math: Sequence[str]) -> Iterator[str]:
    if terms:
        ordered = sorted(zip(terms, math, strict=True), key=lambda pair: -(pair[0]["share_of_largest"] or 0))
        rows = [
            (Raw(m), _format_size(t["max_abs"]), _format_unit(t["unit"]), format_bar(t["share_of_largest"]))
            for t, m in ordered
        ]
        head = (label, "largest over the cycle", "unit", "share of the largest derived term")
        yield format_table(head, rows, "terms tight")


def _format_size(value: float | None) -> float | str:
    return "no real value" if value is None else float(value)


def _format_unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _format_vanishing(terms: Sequence[Entry], math: Sequence[Entry]) -> Iterator[str]:
    if terms:
        rows = [(Raw(m["term"]), Raw(m["because"]), "yes" if t.get("printed") else "no")
                for t, m in zip(terms, math, strict=True)]  # fmt: skip
        yield format_table(("terms that do not show", "because", "printed"), rows, "terms tight")
