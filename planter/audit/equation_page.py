"""Equations on the page of the audit: as printed, as derived, smallest correction, missing and
unexplained terms.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from html import escape
from typing import Any

from planter.audit.verdicts import AT_FAULT, FAULTY, UNJUDGED
from planter.report.html import Block, Cell, MarkupCell, Table, cell_text

Entry = Mapping[str, Any]
CONFIRMED = ("confirmed", "confirmed as rebuilt", "untested", "definition", "reconstructed")
"""Verdicts without a correction."""
LONG_FORMULA = 50
"""Characters from which a formula has a line of the page for itself."""
SHORT_TERM = 60
"""Largest number of characters of a term or finding in a line of a table."""


def list_equation_blocks(equations: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield the table of all equations, each with a link to its article, then the articles, faulty
    equations first.

    `typeset` has their formulas as MathML by equation.
    """
    rows = [
        (
            MarkupCell(e["equation"], f'<a href="#{equation_id(e)}">{escape(e["equation"])}</a>'),
            e.get("claims", ""),
            mark_verdict(name_verdict(e)),
            describe_fault(e),
            list_conditions(e),
            e["legibility"],
        )
        for e in equations
    ]
    head = ("equation", "claims to be", "verdict", "why", "hangs on", "legibility")
    yield Table(head, rows, page_columns=head[-1:])
    for entry in sorted(equations, key=lambda entry: entry["verdict"] in CONFIRMED):
        yield EquationArticle(entry, typeset[entry["equation"]])


_LATEX_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|\d+|\s+|.", re.S)


def list_changes(before: str, after: str) -> list[tuple[str, str]]:
    r"""Return the pieces of a changed source with marks: " " for both, "-" for the old one, "+" for
    the new one.

    >>> list_changes(r"a + \sin b", r"a - \sin b")
    [(' ', 'a '), ('-', '+'), ('+', '-'), (' ', ' \\sin b')]
    """
    old, new = (_LATEX_TOKEN.findall(text) for text in (before, after))
    pieces: list[tuple[str, str]] = []
    for operation, i, j, k, m in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if operation == "equal":
            pieces.append((" ", "".join(old[i:j])))
        else:
            pieces += [
                (mark, text)
                for mark, text in (("-", "".join(old[i:j])), ("+", "".join(new[k:m])))
                if text
            ]
    return pieces


def format_change(equation: Entry) -> str:
    """Return the correction of an equation in the LaTeX of its text, on one line: [-old-]{+new+} at
    its place.
    """
    marks = {" ": "{}", "-": "[-{}-]", "+": "{{+{}+}}"}
    changes = list_changes(equation["latex"], equation["corrected_latex"])
    text = " ".join("".join(marks[mark].format(piece) for mark, piece in changes).split())
    return f"{equation['file']}:{equation['line']}: ({equation['equation']}) {text}"


def describe_fault(equation: Entry) -> str:
    """Return the fault of an equation in a few words: its correction, and the largest missing term.

    For an equation that is not judged, return the reason.
    """
    parts = [_shorten(equation["finding"])] if equation["verdict"] == "contradicted" else []
    parts += [f"correct {text}" for text in equation["correction"]]
    if equation["terms"]:
        largest = max(equation["terms"], key=lambda term: term["share_of_largest"] or 0)
        count = len(equation["terms"])
        share = largest["share_of_largest"]
        size = "" if share is None else f", {100 * share:.3g} % of the largest term"
        parts.append(
            f"{count} term{'s' if count > 1 else ''} missing, such as "
            f"{_shorten(largest['term'])}{size}"
        )
    if not parts and (equation["verdict"] in (*FAULTY, UNJUDGED) or equation.get("domain")):
        parts.append(equation["finding"])
    return "; ".join(parts)


def _shorten(text: str) -> str:
    """Return a text shortened to a line.

    >>> _shorten("a + b"), len(_shorten("x" * 200))
    ('a + b', 60)
    """
    return text if len(text) <= SHORT_TERM else text[: SHORT_TERM - 4].rstrip(" ,;*+-(") + " ..."


def list_conditions(equation: Entry) -> str:
    """Return the conditions of a verdict: a reading, a single character, completed pieces, the
    domain of use.
    """
    parts = {
        "the reading": not equation.get("robust", True),
        "one character": equation.get("fragile"),
        "the domain of use": equation.get("domain"),
        "pieces completed": equation.get("rebuilt"),
    }
    return ", ".join(text for text, applies in parts.items() if applies)


def name_verdict(equation: Entry) -> str:
    """Return the verdict as it is shown: what is neglected or approximate is called so."""
    return equation["verdict"] if equation["grade"] in ("", AT_FAULT) else equation["grade"]


def mark_verdict(verdict: str) -> MarkupCell:
    """Return a verdict, coloured on a page."""
    return MarkupCell(
        verdict, f'<span class="mark {escape(verdict.replace(" ", "-"))}">{escape(verdict)}</span>'
    )


def equation_id(entry: Entry) -> str:
    """Return the id of an equation on the page."""
    return escape(f"{entry['paper']}-{entry['equation']}".replace(" ", "-").replace("'", "-"))


CLASS = "changed"
"""Class of the elements that differ."""
_LEAF = re.compile(r"<(?!annotation)(\w+)[^<>]*?(?:/>|>[^<]*</\1>)")
"""An element of MathML without elements in it."""


def mark_changes(before: str, after: str) -> list[str]:
    """Return two formulas in MathML with the elements marked in which they differ.

    >>> mark_changes("<math><mi>a</mi><mo>+</mo></math>", "<math><mi>a</mi><mo>-</mo></math>")[1]
    '<math><mi>a</mi><mo class="changed">-</mo></math>'
    """
    leaves = [list(_LEAF.finditer(text)) for text in (before, after)]
    old, new = ([leaf[0] for leaf in part] for part in leaves)
    marked: list[list[int]] = [[], []]
    for operation, i, j, k, m in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if operation != "equal":
            marked[0] += [leaf.end(1) for leaf in leaves[0][i:j]]
            marked[1] += [leaf.end(1) for leaf in leaves[1][k:m]]
    texts = [before, after]
    for number, places in enumerate(marked):
        for place in reversed(places):
            text = texts[number]
            texts[number] = f'{text[:place]} class="{CLASS}"{text[place:]}'
    return texts


@dataclass(frozen=True)
class EquationArticle:
    """All findings on an equation; `typeset` are its formulas as MathML."""

    entry: Entry
    typeset: Entry
    script = ""

    @property
    def style(self) -> str:
        """The CSS of all articles."""
        return STYLE

    def html(self, name: str) -> str:
        entry, verdict = self.entry, name_verdict(self.entry)
        head = (
            f"<h4>({escape(entry['equation'])}) {escape(entry.get('claims', ''))} "
            f"{mark_verdict(verdict).markup}</h4>"
        )
        kind = escape(verdict.replace(" ", "-"))
        return (
            f'<article id="{equation_id(entry)}" '
            f'class="{kind}">{head}{"".join(self._parts())}</article>'
        )

    def _parts(self) -> Iterator[str]:
        entry, typeset = self.entry, self.typeset
        yield from self._formulas()
        if entry.get("latex") and not entry["printed"]:
            yield _format_source(entry)
        if entry["verdict"] not in CONFIRMED or entry.get("domain"):
            yield f"<p>{typeset['finding'][:1].upper()}{typeset['finding'][1:]}.</p>"
        if entry.get("corrected_latex"):
            yield _format_source(entry)
        if typeset["correction"]:
            title = (
                "Smallest correction"
                if len(typeset["correction"]) == 1
                else "Smallest corrections, any of them"
            )
            yield f"<p><strong>{title}:</strong> {'; or '.join(typeset['correction'])}.</p>"
        yield _format_terms("terms that the print lacks", entry["terms"], typeset["terms"])
        yield _format_terms(
            "unexplained printed terms", entry.get("unexplained", ()), typeset["unexplained"]
        )
        yield _format_difference(entry)
        vanishing = [
            (_markup(math["term"]), _markup(math["because"]), bool(term.get("printed")))
            for term, math in zip(entry.get("vanishing", ()), typeset["vanishing"], strict=True)
        ]
        yield _format_rows(("vanishing terms", "because", "printed"), vanishing)
        if typeset["reading"]:
            yield f'<p class="note">Read so: {typeset["reading"]}.</p>'
        if entry.get("rebuilt"):
            yield f'<p class="note">Completed: {escape("; ".join(entry["rebuilt"]))}.</p>'
        if entry.get("fragile"):
            yield (
                '<p class="note">One character decides this: it may be an error of reading the '
                "print.</p>"
            )
        if readings := typeset.get("depends"):
            verdict = (
                "The same under every reading." if entry["robust"] else "It depends on the reading."
            )
            rows = [
                (
                    _markup(r["reading"]),
                    _markup(r["because"]),
                    mark_verdict(r["verdict"]),
                    _markup(r["finding"]),
                )
                for r in readings
            ]
            yield f'<p class="note">{verdict}</p>'
            yield _format_rows(("reading", "admitted by", "verdict", "finding"), rows)

    def _formulas(self) -> Iterator[str]:
        printed, derived = (self.entry.get(side, "") for side in ("printed", "derived"))
        label = "as rebuilt" if self.entry["legibility"] == "lost" else "as printed"
        sides = {"printed": label, "derived": "as derived"}
        if printed and printed == derived:
            sides = {"printed": f"{label} and as derived"}
        formulas = {side: self.typeset[side] for side in sides if self.entry.get(side)}
        if self.typeset.get("corrected"):
            formulas["printed"], formulas["corrected"] = mark_changes(
                formulas["printed"], self.typeset["corrected"]
            )
            sides = {"printed": label, "corrected": "corrected", "derived": "as derived"}
        if self.typeset.get("transcription") and "printed" in sides:
            sides = {"transcription": "as printed"} | sides | {"printed": "as read"}
            formulas["transcription"] = self.typeset["transcription"]
        boxes = [
            _format_formula(title, formulas[side])
            for side, title in sides.items()
            if side in formulas
        ]
        if boxes:
            yield f'<div class="sides">{"".join(boxes)}</div>'


def _format_formula(title: str, formula: str) -> str:
    text = re.sub(r"<annotation.*?</annotation>|<[^>]*>", "", formula, flags=re.DOTALL)
    kind = "side long" if len(text) > LONG_FORMULA else "side"
    fit = f' style="--fit: {find_print_size(formula):.2f}"'
    return (
        f'<div class="{kind}"><p class="label">{title}</p><div '
        f'class="formula"{fit}>{formula}</div></div>'
    )


LINE = 70
"""Characters of a formula on a printed line, at its own size."""


def find_print_size(formula: str) -> float:
    """Return the size of type, at most 1, at which the longest line of a formula in MathML fits on
    a printed line.

    >>> find_print_size("<math><mi>x</mi></math>"), find_print_size(f"<math><mi>{140 * 'x'}</mi></math>")
    (1, 0.5)
    """
    text = re.sub(r"<annotation.*?</annotation>", "", formula, flags=re.DOTALL)
    lines = re.findall(r"<mtr>.*?</mtr>", text, re.DOTALL) or [text]
    longest = max(len(re.sub(r"<[^>]*>|[\u2061\u2062]", "", line)) for line in lines)
    return min(1, LINE / longest)


def _format_source(entry: Entry) -> str:
    """Return the LaTeX of an equation with its correction marked in it, if it has one, and its
    place in the text.
    """
    tags = {" ": "{}", "-": "<del>{}</del>", "+": "<ins>{}</ins>"}
    pieces = list_changes(entry["latex"], entry["corrected_latex"] or entry["latex"])
    source = "".join(tags[mark].format(escape(piece)) for mark, piece in pieces)
    place = escape(f"{entry['file']}, line {entry['line']}")
    label = "corrected in its LaTeX" if entry["corrected_latex"] else "as printed"
    return f'<p class="label">{label}, {place}</p><pre class="source">{source}</pre>'


def _markup(markup: str) -> MarkupCell:
    """Return a cell of a page alone."""
    return MarkupCell(markup, markup)


def _format_rows(head: Sequence[str], rows: Sequence[Sequence[Cell]]) -> str:
    return Table(head, rows).html("") if rows else ""


def _format_terms(label: str, terms: Sequence[Entry], math: Sequence[str]) -> str:
    """Return the table of terms by falling share of the largest derived term, which a bar shows."""
    ordered = sorted(
        zip(terms, math, strict=True), key=lambda pair: -(pair[0]["share_of_largest"] or 0)
    )
    rows = [
        (
            _markup(formula),
            "no real value" if term["max_abs"] is None else float(term["max_abs"]),
            "" if term["unit"] == "1" else term["unit"],
            _format_share(term["share_of_largest"]),
        )
        for term, formula in ordered
    ]
    return _format_rows(
        (label, "largest over the cycle", "unit", "share of the largest derived term"), rows
    )


def _format_difference(entry: Entry) -> str:
    """Return how much several terms are together, which may be far less than any of them."""
    left = entry.get("difference")
    if (
        not left
        or len(entry["terms"]) + len(entry.get("unexplained", ())) < 2
        or not left["share_of_largest"]
    ):
        return ""
    share, unit = (
        cell_text(100 * left["share_of_largest"]),
        "" if left["unit"] == "1" else f" {left['unit']}",
    )
    size = cell_text(float(left["max_abs"]))
    return f"<p>Together at most {size}{escape(unit)}, {share} % of the largest derived term.</p>"


def _format_share(share: float | None) -> Cell:
    if share is None:
        return None
    bar = f'<span class="bar"><span style="width: {min(100.0, 100 * share):.3g}%"></span></span>'
    return _markup(f'<span class="share">{bar} {cell_text(100 * share)} %</span>')


STYLE = """\
:root { --good: #0b6b50; --doubt: #8a5a00; --bad: #a8321a; --bar: #0072b2; }
@media (prefers-color-scheme: dark) { :root { --good: #6fd3b1; --doubt: #e9b75a; --bad: #ff9d84; --bar: #56b4e9; } }
body { max-width: 60rem; }
h4 { font-size: 1rem; font-weight: 600; margin: 0 0 .3rem; }
article { margin: 1rem 0; padding: .7rem 0 .2rem .9rem; border-left: 3px solid var(--rule); }
article.incomplete { border-left-color: var(--doubt); }
article.misprint { border-left-color: var(--doubt); }
article.contradicted { border-left-color: var(--bad); }
article > p { margin: .5rem 0; overflow: auto hidden; }
.label { color: var(--soft); font-size: .85rem; margin: .5rem 0 0; }
.formula { overflow-x: auto; overflow-y: hidden; padding: .15rem 0; }
math { font-size: 1.1em; font-family: "STIX Two Math", "Cambria Math", "Latin Modern Math", "Libertinus Math", math; }
math[display="block"] { margin: .2rem 0 .2rem 1rem; text-align: left; display: block math; width: fit-content; }
math mtd { padding: .12em 0; }
math mtd + mtd { padding-left: 1.2em; }
.sides { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); gap: 0 1.5rem; }
.side { min-width: 0; }
.side.long, .sides:has(.long) .side { grid-column: 1 / -1; }
.long math { font-size: 1em; }
.changed { color: var(--bad); }
.side + .side .changed { color: var(--good); font-weight: 600; }
.source { margin: .2rem 0 .4rem 1rem; white-space: pre-wrap; font-size: .9em; }
.source del { color: var(--bad); text-decoration: line-through; }
.source ins { color: var(--good); text-decoration: underline; font-weight: 600; }
td math, th math { font-size: 1em; } tbody th:has(math) { position: static; max-width: none;
  padding-right: 2rem; }
.mark { font-size: .85em; white-space: nowrap; color: var(--soft); }
.mark.confirmed, .mark.reproduced, .mark.holds { color: var(--good); }
.mark.misprint, .mark.incomplete, .mark.not-recomputable { color: var(--doubt); }
.mark.contradicted, .mark.not-reproduced, .mark.fails { color: var(--bad); font-weight: 600; }
h4 .mark { margin-left: .4rem; font-size: .9em; }
.bar { display: inline-block; width: 5rem; height: .55rem; background: var(--rule); margin-right: .4rem; }
.bar > span { display: block; height: 100%; background: var(--bar); }
.share { white-space: nowrap; }
@media print { :root { --good: #0b6b50; --doubt: #8a5a00; --bad: #a8321a; --bar: #0072b2; }
  article { break-inside: auto; } h4, .label { break-after: avoid; } .formula { overflow: visible; }
  .bar, .bar > span { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  .formula math { font-size: calc(1em * var(--fit, 1)); } td math { font-size: .75em; } }
"""
