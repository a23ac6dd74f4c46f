"""Presentation of an audit: findings first, then laws, causes, equations, statements and numbers of
each paper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from string import ascii_lowercase
from typing import Any

from planter.audit.equation_page import format_change, list_equation_blocks, mark_verdict
from planter.audit.results import AuditResult
from planter.audit.verdicts import UNJUDGED
from planter.report.html import (
    Block,
    Cell,
    Folded,
    Items,
    KeyFigure,
    Keys,
    Section,
    Table,
    Text,
)
from planter.report.labels import clean_zero
from planter.report.presentation import ResultPresentation
from planter.version import __version__

Entry = Mapping[str, Any]
TRANSCRIBED = "The equations were audited as transcribed, each against an independent derivation."
SOURCE = (
    "The machine-read text of each paper was audited, not its page images; gaps that were filled "
    "in are listed, and a "
    "finding that depends on one character may be an error of reading. If a symbol is ambiguous, "
    "the reading most "
    "favourable to the paper counts."
)
READ = (
    "The displayed equations were read from the text's own LaTeX, and each was compared with the "
    "mechanism's motion at "
    "random values. A name means what the file of names says, else the quantity whose name it "
    "spells: see that it does."
)
NUMBER_VERDICTS = ("not reproduced", "not recomputable", "consistent", "reproduced")
"""Verdicts on numbers, the most serious first."""


def present_audit(result: Mapping[str, Any], typeset: Entry) -> ResultPresentation:
    """Return the presentation of an audit; `typeset` has the formulas as MathML by paper and
    equation.
    """
    counts = result["summary"].values()
    equations, numbers = (
        sum(sum(s[part].values()) for s in counts) for part in ("equations", "numbers")
    )
    at_fault = sum(s["at_fault"] for s in counts)
    unjudged = sum(s["equations"].get("not judged", 0) for s in counts)
    differing = sum(s["numbers"].get("not reproduced", 0) for s in counts)
    laws = result.get("laws", ())
    figures = {
        "printed equations are at fault": (at_fault, equations - unjudged),
        "are not judged": (unjudged, equations if unjudged else 0),
        "laws are broken": (sum(bool(law["caused_by"]) for law in laws), len(laws)),
        "printed numbers are not reproduced": (differing, numbers),
    }
    counted = [(f"{count} of {total}", words) for words, (count, total) in figures.items() if total]
    return ResultPresentation(
        title="Formula audit",
        conclusion=f"{'; '.join(map(' '.join, counted)) or 'No equation was judged'}.",
        key_figures=[KeyFigure(share, "", words) for share, words in counted],
        record=AuditResult.read(result),
        sections=list(_list_sections(result, typeset)),
        details=lambda: [Section("Meanings of the terms", [Keys(MEANINGS)])],
        summary_parts=result,  # its keys are in the order of the stored verdicts
        provenance={"planter": __version__},
    )


def _list_sections(result: Mapping[str, Any], typeset: Entry) -> Iterator[Section]:
    yield Section("Summary", list(_summarise(result)))
    for paper in result["summary"]:
        entries = _group_parts(result, paper)
        formulas = typeset.get(paper, {})
        yield from (
            Section(f"{paper}: {part}", list(list_blocks(entries[part], formulas)))
            for part, list_blocks in PARTS.items()
            if entries[part]
        )
    if "rows" in result:
        yield from _list_text_sections(result)


def _list_text_sections(result: Mapping[str, Any]) -> Iterator[Section]:
    """Yield the corrections in the LaTeX of a text, and the rows of it that are not judged."""
    if corrected := [e for e in result["equations"] if e.get("corrected_latex")]:
        yield Section(
            "Corrections in the text's own LaTeX", [Items([format_change(e) for e in corrected])]
        )
    rows = result["rows"]
    unjudged = [
        (f"{row['file']}:{row['line']}", row["status"], row["reason"])
        for row in rows
        if row["reason"]
    ]
    if unjudged:
        read = sum(row["status"] == "read" for row in rows)
        counted = (
            f"{read} of {len(rows)} displayed rows were read, {len(rows) - len(unjudged)} "
            f"judged; the others:"
        )
        yield Section(
            "Rows that are not judged", [Text(counted), Table(("place", "row", "reason"), unjudged)]
        )


def _group_parts(result: Mapping[str, Any], paper: str) -> dict[str, list[Entry]]:
    return {part: [e for e in result.get(part, ()) if e["paper"] == paper] for part in PARTS}


def _summarise(result: Mapping[str, Any]) -> Iterator[Block]:
    """Yield the counts of verdicts, and the main findings of each paper."""
    is_printed = all(e["legibility"] == "printed" and not e["rebuilt"] for e in result["equations"])
    yield Text(READ if "rows" in result else TRANSCRIBED if is_printed else SOURCE)
    papers = result["summary"].items()
    rows = [
        (name, _tally(s["equations"]), s["at_fault"], s["causes"], _tally(s["numbers"]), s["title"])
        for name, s in papers
    ]
    head = ("paper", "equations", "at fault", "causes", "numbers", "title")
    yield Table(head, rows, page_columns=head[-1:])
    for name, summary in papers:
        if findings := list(list_findings(_group_parts(result, name))):
            yield Text(f"{summary['title']}:")
            yield Items(findings)


def list_findings(parts: Mapping[str, Sequence[Entry]]) -> Iterator[str]:
    """Yield the main findings of a paper: broken laws, changed headline numbers, consequences,
    false statements.
    """
    broken = [e for e in parts["laws"] if e["caused_by"]]
    if broken and broken[0].get("owed"):
        yield _describe_cause(broken[0])
    if broken:
        listed = "; ".join(
            f"{e['law']} (by {format_amount(e['violation'], e['unit'])})" for e in broken
        )
        yield f"Of {len(parts['laws'])} laws the chain as a whole breaks {len(broken)}: {listed}."
    yield from map(_describe_headline, parts["consequences"])
    for entry in parts["claims"]:
        if not entry["holds"]:
            measure = f"{entry['measure']}: {format_amount(entry['value'], entry['unit'])}"
            yield (
                f"Not so: {entry['claim']}. {_capitalise(measure)}, where it must {entry['must']}."
            )


def _describe_cause(law: Entry) -> str:
    return f"{_capitalise(law['law'])}: {law['owed']}"


def _describe_headline(entry: Entry) -> str:
    """Return a sentence on a headline number by the print and as derived."""
    printed, derived = (
        format_amount(entry[key], entry["unit"]) for key in ("as_printed", "as_derived")
    )
    in_paper = "" if entry["printed"] is None else f" (in the paper {entry['printed']:g})"
    return (
        f"{_capitalise(entry['quantity'])}{in_paper}: {printed} by the print, {derived} as derived."
    )


def _list_consequence_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield headline numbers by the equations as printed and as derived, then the consequences."""
    rows = [
        (
            e["quantity"],
            e["unit"],
            None if e["printed"] is None else float(e["printed"]),
            clean_zero(e["as_printed"]),
            clean_zero(e["as_derived"]),
            ", ".join(e["rests_on"]),
        )
        for e in entries
    ]
    head = ("headline number", "unit", "in the paper", "by the print", "as derived", "rests on")
    yield Table(head, rows)
    if assumed := max((e["assumed_inputs"] for e in entries), key=len):
        pairs = (text.partition(" = ")[::2] for text in assumed)
        yield Folded("Assumed for this", [Table(("key", "value"), list(pairs))])


def _list_law_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield the laws that a printed chain satisfies or breaks, and the share of each equation that
    breaks them.
    """
    for reading in dict.fromkeys(e["reading"] for e in entries):
        if reading:
            yield Text(
                f"Broken by: under the kindest joint reading, {reading}. Read literally: as the "
                f"printed model computes."
            )
    rows = [
        (
            e["law"],
            e["violation"],
            e["violation_literal"],
            e["unit"],
            list_repairs(e),
            e.get("search", ""),
        )
        for e in entries
    ]
    head = (
        "law",
        "broken by",
        "read literally",
        "unit",
        "restored by repairing",
        "search for the smallest set",
    )
    yield Table(head, rows, page_columns=head[-1:])
    for law in entries:
        shares = law.get("shares", ())
        if len(shares) > 1:
            cells = [
                (s["equation"], *(float(s[key]) for key in ("alone", "without", "shapley")))
                for s in shares
            ]
            columns = ("equation", "repaired alone", "left alone", "Shapley value")
            yield Table(columns, cells, f"{law['law']} [{law['unit']}]")
        if law.get("owed"):
            yield Text(_describe_cause(law))


def list_repairs(law: Entry) -> str:
    """Return the smallest sets of equations whose repair restores a law."""
    if law["violation"] is None:
        return UNJUDGED
    sets = [law["caused_by"], *law.get("or_by", ())] if law["caused_by"] else []
    return " or ".join(", ".join(chosen) for chosen in sets) or "kept"


def _list_cause_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield the table of errors, each with the equations and the number of printed numbers that it
    affects.
    """
    rows = [
        (e["cause"], ", ".join(n.partition(": ")[2] for n in e["equations"]), len(e["numbers"]))
        for e in entries
    ]
    yield Table(("error", "equations", "numbers that its repair cures"), rows)


def _list_reference_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield sentences on the cross-references that cannot be right."""
    for entry in entries:
        numbers, instead = (
            ", ".join(f"({n})" for n in entry[key]) for key in ("refers_to", "instead")
        )
        yield Text(
            f"{', '.join(entry['quantities'])} cannot come from {numbers}, as the paper says: "
            f"these do not give "
            f"{', '.join(entry['lacking'])}; {instead} do."
        )


def _list_claim_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield the table of the text's statements with their measures."""
    rows = [
        (
            e["claim"],
            clean_zero(e["value"]),
            e["unit"],
            e["must"],
            mark_verdict("holds" if e["holds"] else "fails"),
            e["measure"],
            ", ".join(e["assumed_inputs"]),
        )
        for e in entries
    ]
    head = ("statement", "value", "unit", "must", "verdict", "measure", "assumed")
    yield Table(head, rows, page_columns=head[-2:])


def _list_number_blocks(entries: Sequence[Entry], typeset: Entry) -> Iterator[Block]:
    """Yield a table of numbers for each verdict, and the inputs to which letters in them refer."""
    letters: dict[str, str] = {}
    for verdict in NUMBER_VERDICTS:
        rows = []
        for e in entries:
            if e["verdict"] == verdict:
                basis = describe_basis(e)
                letter = letters.setdefault(basis, _letter(len(letters))) if basis else ""
                difference = e["difference"] if verdict == "not reproduced" else ""
                printed = (e["quantity"], e["place"], e["unit"], e["printed_text"])
                rows.append((*printed, e["recomputed"], difference, letter))
        if rows:
            head = ("quantity", "place", "unit", "printed", "computed", "differs by", "note")
            yield _without_empty_columns(head, rows, f"{verdict}: {len(rows)}")
    if letters:
        yield Table(
            ("note", "numbers rest on"), [(letter, basis) for basis, letter in letters.items()]
        )


def _letter(index: int) -> str:
    """Return the letter of a note.

    >>> _letter(0), _letter(26)
    ('a', 'aa')
    """
    first, second = divmod(index, len(ascii_lowercase))
    return (ascii_lowercase[first - 1] if first else "") + ascii_lowercase[second]


def _without_empty_columns(
    head: Sequence[str], rows: Sequence[Sequence[Cell]], caption: str
) -> Table:
    columns = [k for k in range(len(head)) if any(row[k] != "" for row in rows)]
    return Table([head[k] for k in columns], [[row[k] for k in columns] for row in rows], caption)


def describe_basis(number: Entry) -> str:
    """Return the basis of a number beyond the disclosed inputs."""
    assumed = number["assumed_inputs"]
    listed = ", ".join(assumed) if len(assumed) <= 2 else f"{len(assumed)} inputs"
    lacking = f"not disclosed: {', '.join(number['needs'])}" if number["needs"] else ""
    rounding = number["verdict"] == "consistent" and number["interval"]
    ends = "rounded inputs: {:.5g} to {:.5g}".format(*rounding) if rounding else ""
    parts = (listed and f"assumed: {listed}", lacking, ends, number["reading"], number["reason"])
    return "; ".join(part for part in parts if part)


def format_amount(value: float | None, unit: str) -> str:
    """Return a value with its unit, to three digits.

    >>> format_amount(0.00275414, ""), format_amount(31.2514, "deg"), format_amount(None, "N")
    ('0.00275', '31.3 deg', '-')
    """
    return "-" if value is None else f"{clean_zero(value):.3g} {unit}".strip()


def _capitalise(text: str) -> str:
    """Return a sentence with a capital first letter, the others unchanged."""
    return f"{text[:1].upper()}{text[1:]}"


def _tally(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counts.items()) or "none"


PARTS: dict[str, Callable[[Sequence[Entry], Entry], Iterator[Block]]] = {
    "consequences": _list_consequence_blocks,
    "laws": _list_law_blocks,
    "causes": _list_cause_blocks,
    "references": _list_reference_blocks,
    "equations": list_equation_blocks,
    "claims": _list_claim_blocks,
    "numbers": _list_number_blocks,
}
"""Functions that list the blocks of each part of a paper, of its entries and formulas."""
MEANINGS = {
    "confirmed": "the derivation gives the same",
    "confirmed as rebuilt": "the same, where pieces of the machine-read text were completed",
    "untested": "a definition, or a naming, that nothing here can test",
    "misprint": "what differs is removed by one or two edits",
    "incomplete": "the print lacks terms: of the derivation, or one with which it holds",
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
    "not reproduced": (
        "differs, from disclosed inputs only: by what was computed less what is printed"
    ),
    "not recomputable": "rests on inputs that the paper does not disclose",
    "by the print": "computed with the equations as printed, misprints included",
    "as derived": "computed with the same inputs from the equations derived here",
    "holds, fails": (
        "the measure is, or is not, what the statement needs; with assumed inputs, for these alone"
    ),
}
