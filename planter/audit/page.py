"""The audit as files: summary.json, and report.html with every equation as printed and as derived, and its verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from planter.audit import article, fronts, markup, tables
from planter.audit.consequences import HEADLINE
from planter.audit.markup import Cell, Raw, mark
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
"""Verdicts on numbers, the gravest first."""


@renews
def write(out: str | Path, result: Mapping[str, Any], typeset: Entry) -> None:
    """Writes summary.json and report.html, formulas as `typeset` has them by paper and equation.

    Raises InputError for a folder that it cannot write.
    """
    folder = files.output_folder(out)
    files.write_summary(folder / "summary.json", {**result, "provenance": {"planter": __version__}})
    files.write_text(folder / "report.html", html(result, typeset))
    if "front" in result:
        fronts.write(folder, result["front"])


def html(result: Mapping[str, Any], typeset: Entry) -> str:
    """The page of an audit."""
    subtitle = "Every equation, law, statement and number of the papers, as printed, derived anew and judged"
    return page("Formula audit", list(sections(result, typeset)), subtitle, markup.STYLE)


def sections(result: Mapping[str, Any], typeset: Entry) -> Iterator[Section]:
    """A summary, each paper, and what the words mean."""
    yield Section("Summary", [Raw(summary(result))])
    for name, counted in result["summary"].items():
        yield Section(counted["title"], [Raw(paper(name, result, typeset.get(name, {})))])
    if "front" in result:
        yield from fronts.sections(result["front"])
    yield Section("What the words mean", [Keys(MEANINGS)])


def summary(result: Mapping[str, Any]) -> str:
    """How often each verdict was given, and what matters most in a few sentences for each paper."""
    rows = [(s["title"], tables.tally(s["equations"]), f"{s['at_fault']} equations, {s['causes']} causes",
             tables.tally(s["numbers"])) for s in result["summary"].values()]  # fmt: skip
    whole = all(e["legibility"] == "printed" and not e["rebuilt"] for e in result["equations"])
    parts = [
        markup.paragraph(TRANSCRIBED if whole else SOURCE),
        markup.table(("paper", "equations", "at fault", "numbers"), rows, "tight"),
    ]
    for name, counted in result["summary"].items():
        found = list(findings({part: _of(result.get(part, ()), name) for part in PARTS}))
        if found:
            parts.append(f"<h3>{escape(counted['title'])}</h3>{markup.items(found)}")
    return "\n".join(parts)


def findings(mine: Mapping[str, Sequence[Entry]]) -> Iterator[str]:
    """What matters most of one paper: broken laws, false statements, headline numbers that change, what follows."""
    broken = [e for e in mine["laws"] if e["caused_by"]]
    if broken and broken[0].get("owed"):
        yield f"{_begun(broken[0]['law'])}: {broken[0]['owed']}"
    if broken:
        listed = "; ".join(f"{e['law']} (by {tables.amount(e['violation'], e['unit'])})" for e in broken)
        yield f"Of {len(mine['laws'])} laws the chain as a whole breaks {len(broken)}: {listed}."
    beside = [e for e in mine["consequences"] if e["printed"] is not None and e["about"] != HEADLINE]
    if beside:
        yield tables.side_by_side(beside)
    for entry in mine["consequences"]:
        if entry["statement"]:
            yield entry["statement"]
        elif entry["about"] == HEADLINE:
            yield tables.headline(entry)
    failing = [e for e in mine["claims"] if not e["holds"]]
    for entry in failing:
        yield f"Not so: {entry['claim']}. {tables.measured(entry)}."


def paper(name: str, result: Mapping[str, Any], typeset: Entry) -> str:
    """All of one paper, with a line of contents."""
    bodies = _BODIES | {"equations": lambda found: equations(found, typeset)}
    mine = {part: _of(result.get(part, ()), name) for part in PARTS}
    there = [part for part in PARTS if mine[part]]
    links = "".join(f'<a href="#{name}-{part}">{TITLES[part]}</a>' for part in there)
    shown = (f'<h3 id="{name}-{part}">{TITLES[part]}</h3>{bodies[part](mine[part])}' for part in there)
    return f'<nav class="paper" aria-label="{escape(name)}">{links}</nav>\n' + "\n".join(shown)


def equations(found: Sequence[Entry], typeset: Entry) -> str:
    """All equations in a table, then the trial of each that has something to it, then the rest in short.

    `typeset` holds their formulas as MathML, as they were written when they were judged.
    """
    loud = [e for e in found if e["verdict"] not in article.QUIET]
    quiet = [e for e in found if e["verdict"] in article.QUIET]
    return "\n".join([article.overview(found), *(article.trial(e, typeset[e["equation"]]) for e in (*loud, *quiet))])


def laws(found: Sequence[Entry]) -> str:
    """Laws that a printed chain as a whole obeys or breaks, and which equations break them."""
    sizes = ("violation", "violation_literal")
    rows = [(e["law"], *(e[size] for size in sizes), e["unit"], tables.blamed(e), e.get("search", "")) for e in found]
    head = ("law", "broken by", "read literally", "unit", "restored by repairing", "search for the smallest set")
    parts = [markup.paragraph(f"{text}.") for text in dict.fromkeys(tables.readings(found))]
    parts += [markup.table(head, rows, "tight"), *(_shares(law) for law in found if law.get("shares"))]
    parts += [markup.paragraph(f"{_begun(e['law'])}: {e['owed']}.") for e in found if e["violation"] is None]
    return "\n".join(parts)


def _shares(law: Entry) -> str:
    """The sentence that names what a broken law is laid to, and, of several equations, what each does to it."""
    if len(law["shares"]) == 1:
        return markup.paragraph(f"{_begun(law['law'])}: {law['owed']}")
    rows = [(s["equation"], *(float(s[key]) for key in ("alone", "without", "shapley"))) for s in law["shares"]]
    head = ("equation", f"its repair alone takes away [{law['unit']}]", "it alone leaves", "Shapley value")
    title = f"<h4>{escape(law['law'])}</h4>"
    return f"{title}{markup.paragraph(law['owed'])}{markup.table(head, rows, 'tight')}"


def _begun(text: str) -> str:
    """A sentence with a capital."""
    return f"{text[:1].upper()}{text[1:]}"


def causes(found: Sequence[Entry]) -> str:
    """Findings by cause: what one slip did to how many equations and numbers."""
    rows = [
        (e["cause"], ", ".join(n.partition(": ")[2] for n in e["equations"]), float(len(e["numbers"]))) for e in found
    ]
    return markup.table(("one slip", "equations", "numbers that its repair cures"), rows, "tight")


def references(found: Sequence[Entry]) -> str:
    """Cross-references that cannot be meant."""
    return "\n".join(markup.paragraph(tables.reference(e)) for e in found)


def claims(found: Sequence[Entry]) -> str:
    """Statements of the text, each with what was measured."""
    head = ("statement", "measure", "value", "unit", "must", "verdict", "assumed")
    return markup.table(head, map(_claim, found), "tight")


def _claim(entry: Entry) -> tuple[Cell, ...]:
    must = Raw(f'<span class="must">{escape(entry["must"])}</span>')
    verdict = mark("holds" if entry["holds"] else "fails")
    value, assumed = tables.plain(entry["value"]), ", ".join(entry["assumed_inputs"])
    return entry["claim"], entry["measure"], value, entry["unit"], must, verdict, assumed


def consequences(found: Sequence[Entry]) -> str:
    """Headline numbers by the equations as printed and as derived, then what that means."""
    parts = []
    for about in dict.fromkeys(e["about"] for e in found):
        rows = [(e["quantity"], e["unit"], e["printed"] if e["printed"] is None else float(e["printed"]),
                 tables.plain(e["as_printed"]), tables.plain(e["as_derived"]), ", ".join(e["rests_on"])) for e in found
                if e["about"] == about]  # fmt: skip
        head = (about, "unit", "in the paper", "by the print", "as derived", "rests on")
        parts.append(markup.table(head, rows, "tight"))
    said = [e["statement"] for e in found if e["statement"]]
    parts += [markup.items(said)] if said else []
    assumed: list[str] = max((e["assumed_inputs"] for e in found), key=len, default=[])
    if assumed:
        parts.append(markup.paragraph(f"Assumed for this: {', '.join(assumed)}.", "note"))
    return "\n".join(parts)


def numbers(found: Sequence[Entry]) -> str:
    """Numbers in a table for each verdict; what they rest on is said once, in notes."""
    notes = tables.Notes()
    parts = []
    for verdict in (v for v in _ORDER if any(e["verdict"] == v for e in found)):
        mine = [e for e in found if e["verdict"] == verdict]
        rows = [(e["quantity"], e["place"], e["unit"], Raw(escape(e["printed_text"])), e["recomputed"],
                 e["difference"] if verdict == "not reproduced" else "", notes.mark(tables.basis(e)))
                for e in mine]  # fmt: skip
        parts.append(f"<h4>{mark(verdict).markup} {len(mine)}</h4>")
        head = ("quantity", "place", "unit", "printed", "recomputed", "differs by", "note")
        parts.append(markup.table(*_filled(head, rows), "tight"))
    listed = "".join(f"<li>{escape(text)}</li>" for text in notes.texts)
    return "\n".join([*parts, f'<ol class="notes">{listed}</ol>' if listed else ""])


def _filled(head: Sequence[str], rows: Sequence[Sequence[Cell]]) -> tuple[list[str], list[list[Cell]]]:
    """A table without the columns that hold nothing."""
    kept = [k for k in range(len(head)) if any(row[k] != "" for row in rows)]
    return [head[k] for k in kept], [[row[k] for k in kept] for row in rows]


_BODIES: dict[str, Callable[[Sequence[Entry]], str]] = {
    "consequences": consequences, "laws": laws, "causes": causes, "references": references, "claims": claims,
    "numbers": numbers,
}  # fmt: skip


def _of(entries: Sequence[Entry], paper: str) -> list[Entry]:
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
