"""Tables of the audit for the terminal, and the short texts that terminal and page share."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from string import ascii_lowercase
from typing import Any

from planter.audit.attainable_front import show_front
from planter.audit.verdicts import FAULTY, UNJUDGED
from planter.terminal.console import Console, cell_text

Entry = Mapping[str, Any]
PARTS = ("equations", "causes", "references", "laws", "claims", "numbers", "consequences")
ROUNDING = 1e-9
"""Magnitude below which a computed value is shown as zero."""
_SHORT = 60
"""Largest number of characters of a term or finding in a line of a table."""


def show_audit(console: Console, result: Mapping[str, Any]) -> None:
    """Print equations, laws, statements, numbers, consequences and the counts of verdicts of each paper."""
    if "front" in result:
        show_front(console, result["front"])
    for paper, summary in result["summary"].items():
        parts = {part: [e for e in result.get(part, ()) if e["paper"] == paper] for part in PARTS}
        equations = ((e["equation"], e.get("claims", ""), e["verdict"], describe_fault(e), list_conditions(e))
                     for e in parts["equations"])  # fmt: skip
        head = ("", "claims to be", "verdict", "why", "hangs on")
        console.table(f"{summary['title']}: equations", head, equations)
        if parts["causes"]:
            rows = ((e["cause"], ", ".join(_strip_paper(e["equations"])), len(e["numbers"])) for e in parts["causes"])
            console.table("Causes", ("one slip", "equations", "numbers"), rows)
        for entry in parts["references"]:
            _print_wrapped(describe_reference(entry))
        _show_laws(console, parts["laws"])
        if parts["claims"]:
            claims = ((e["claim"], format_amount(e["value"], e["unit"]), e["must"], "yes" if e["holds"] else "no")
                      for e in parts["claims"])  # fmt: skip
            console.table("Statements", ("statement", "measure", "must", "holds"), claims)
        _show_numbers(console, parts["numbers"])
        if parts["consequences"]:
            _show_consequences(console, parts["consequences"])
        for part in ("equations", "numbers"):
            _print_wrapped(f"{part}: {format_tally(summary[part])}")
        print()


def _strip_paper(names: Sequence[str]) -> list[str]:
    """Return names without that of the paper."""
    return [name.partition(": ")[2] for name in names]


def describe_reference(entry: Entry) -> str:
    """Return a sentence on a cross-reference that cannot be right."""
    numbers, instead = (", ".join(f"({n})" for n in entry[key]) for key in ("refers_to", "instead"))
    sentence = f"{', '.join(entry['quantities'])} cannot come from {numbers}, as the paper says"
    return f"{sentence}: these do not give {', '.join(entry['lacking'])}; {instead} do."


def _show_laws(console: Console, laws_judged: Sequence[Entry]) -> None:
    """Print the laws, and the share of each responsible equation in the broken ones."""
    if not laws_judged:
        return
    laws = ((e["law"], e["violation"], e["violation_literal"], e["unit"], list_repairs(e)) for e in laws_judged)
    console.table("Laws", ("law", "broken by", "read literally", "unit", "restored by repairing"), laws)
    for text in dict.fromkeys(describe_readings(laws_judged)):
        _print_wrapped(f"{text}.")
    for law in laws_judged:
        if len(law.get("shares", ())) > 1:
            rows = ((s["equation"], s["alone"], s["without"], s["shapley"]) for s in law["shares"])
            console.table(f"{law['law']} [{law['unit']}]", ("", "repaired alone", "left alone", "Shapley"), rows)
        if law.get("owed"):
            _print_wrapped(f"{law['law'][:1].upper()}{law['law'][1:]}: {law['owed']}")


def describe_readings(laws: Iterable[Entry]) -> Iterator[str]:
    """Return what the chain of each law is read as that is not read literally, as the printed model computes it."""
    for law in laws:
        if law["reading"]:
            yield f"Broken by: under the kindest joint reading, {law['reading']}. Read literally: the printed model"


@dataclass
class Notes:
    """Notes below a table, to which letters in the table refer."""

    texts: list[str] = field(default_factory=list)

    def mark(self, text: str) -> str:
        """Return the letter of a text, empty for an empty text."""
        if not text:
            return ""
        if text not in self.texts:
            self.texts.append(text)
        first, second = divmod(self.texts.index(text), len(ascii_lowercase))
        return (ascii_lowercase[first - 1] if first else "") + ascii_lowercase[second]


def _show_numbers(console: Console, numbers: list[Entry]) -> None:
    if not numbers:
        return
    notes = Notes()
    keys = ("quantity", "unit", "printed_text", "recomputed")
    places = any(e["place"] for e in numbers)
    rows = [
        (
            *((e["place"],) if places else ()),
            *(cell_text(e[key]) for key in keys),
            _format_difference(e),
            e["verdict"],
            notes.mark(describe_basis(e)),
        )
        for e in numbers
    ]
    head = ("quantity", "unit", "printed", "computed", "differs by", "verdict", "")
    console.table("Numbers", (*(("place",) if places else ()), *head), rows)
    if notes.texts:
        console.table("", ("", "numbers rest on"), ((notes.mark(text), text) for text in notes.texts))


def _format_difference(number: Entry) -> str:
    """Return the computed minus the printed value if it exceeds the printed precision, else an empty text."""
    return f"{number['difference']:+.3g}" if number["verdict"] == "not reproduced" and number["difference"] else ""


def _show_consequences(console: Console, consequences: list[Entry]) -> None:
    for about in dict.fromkeys(e["about"] for e in consequences):
        rows = [(e["quantity"], e["unit"], *(_format_value(e[key]) for key in ("printed", "as_printed", "as_derived")),
                 ", ".join(e["rests_on"])) for e in consequences if e["about"] == about]  # fmt: skip
        head = (about, "unit", "in paper", "by print", "derived", "rests on")
        console.table("What follows" if about == consequences[0]["about"] else "", head, rows)
    for entry in consequences:
        if entry["statement"]:
            _print_wrapped(entry["statement"])
    print()


def _format_value(value: float | None) -> str:
    return cell_text(None if value is None else clean_zero(float(value)))


def _print_wrapped(text: str) -> None:
    """Print a sentence wrapped to the width of the terminal."""
    import textwrap

    print(textwrap.fill(text, shutil.get_terminal_size().columns, break_on_hyphens=False))


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
        parts.append(f"{count} term{'s' if count > 1 else ''} missing, such as {_shorten(largest['term'])}{size}")
    if not parts and (equation["verdict"] in (*FAULTY, UNJUDGED) or equation.get("domain")):
        parts.append(equation["finding"])
    return "; ".join(parts)


def list_conditions(equation: Entry) -> str:
    """Return the conditions of a verdict: a reading, a single character, completed pieces, the domain of use."""
    parts = {
        "the reading": not equation.get("robust", True),
        "one character": equation.get("fragile"),
        "the domain of use": equation.get("domain"),
        "pieces completed": equation.get("rebuilt"),
    }
    return ", ".join(text for text, applies in parts.items() if applies)


def _shorten(text: str) -> str:
    """Return a text shortened to a line.

    >>> _shorten("a + b"), len(_shorten("x" * 200))
    ('a + b', 60)
    """
    return text if len(text) <= _SHORT else text[: _SHORT - 4].rstrip(" ,;*+-(") + " ..."


def list_repairs(law: Entry) -> str:
    """Return the smallest sets of equations whose repair restores a law."""
    if law["violation"] is None:
        return UNJUDGED
    sets = [law["caused_by"], *law.get("or_by", ())] if law["caused_by"] else []
    return " or ".join(", ".join(chosen) for chosen in sets) or "kept"


def format_amount(value: float | None, unit: str) -> str:
    """Return a value with its unit, to three digits.

    >>> format_amount(0.00275414, ""), format_amount(31.2514, "deg"), format_amount(None, "N")
    ('0.00275', '31.3 deg', '-')
    """
    return "-" if value is None else f"{clean_zero(value):.3g} {unit}".strip()


def clean_zero(value: float | None) -> float | None:
    """Return a value with rounding errors replaced by zero.

    >>> clean_zero(-1.8e-14), clean_zero(1.8e-6), clean_zero(None)
    (0.0, 1.8e-06, None)
    """
    return 0.0 if value is not None and abs(value) < ROUNDING else value


def describe_headline(entry: Entry) -> str:
    """Return a sentence on a headline number by the print and as derived."""
    printed, derived = (format_amount(entry[key], entry["unit"]) for key in ("as_printed", "as_derived"))
    printed_text = "" if entry["printed"] is None else f" (in the paper {entry['printed']:g})"
    quantity = f"{entry['quantity'][:1].upper()}{entry['quantity'][1:]}"
    return f"{quantity}{printed_text}: {printed} by the print, {derived} as derived."


def compare_numbers(entries: Sequence[Entry]) -> str:
    """Return a sentence that compares related numbers in the paper, by the print and as derived."""
    parts = (
        f"{e['quantity']} {e['printed']:g}, {clean_zero(e['as_printed']):.3g}, "
        f"{format_amount(e['as_derived'], e['unit'])}"
        for e in entries
    )
    about = entries[0]["about"]
    return f"{about[:1].upper()}{about[1:]}, in the paper, by the print and as derived: {'; '.join(parts)}."


def describe_measure(claim: Entry) -> str:
    """Return a sentence on the measure of a statement, without a full stop."""
    text = f"{claim['measure']}: {format_amount(claim['value'], claim['unit'])}, where it must {claim['must']}"
    return text[:1].upper() + text[1:]


def describe_basis(number: Entry) -> str:
    """Return the basis of a number beyond the disclosed inputs."""
    assumed = number["assumed_inputs"]
    listed = ", ".join(assumed) if len(assumed) <= 2 else f"{len(assumed)} inputs"
    lacking = f"not disclosed: {', '.join(number['needs'])}" if number["needs"] else ""
    rounding = number["verdict"] == "consistent" and number["interval"]
    ends = "rounded inputs: {:.5g} to {:.5g}".format(*rounding) if rounding else ""
    parts = (listed and f"assumed: {listed}", lacking, ends, number["reading"], number["reason"])
    return "; ".join(part for part in parts if part)


def format_tally(counts: Mapping[str, int]) -> str:
    """Return verdicts with their counts."""
    return ", ".join(f"{count} {name}" for name, count in counts.items()) or "none"
