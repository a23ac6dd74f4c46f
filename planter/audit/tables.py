"""The audit as tables on a terminal, and the short texts that terminal and page share."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from string import ascii_lowercase
from typing import Any

from planter.audit import consequences, fronts
from planter.terminal.console import Console, cell_text

Entry = Mapping[str, Any]
PARTS = ("equations", "causes", "references", "laws", "claims", "numbers", "consequences")
FAULTY = consequences.FAULTY
ROUNDING = 1e-9
"""Size below which a computed value of ordinary magnitude is cell_text as zero."""
_SHORT = 60
"""Characters of a term or finding that a line of a table has room for."""


def show(console: Console, result: Mapping[str, Any]) -> None:
    """Per paper: equations, laws, statements, numbers, consequences, and how often each verdict was given."""
    if "front" in result:
        fronts.show(console, result["front"])
    for paper, summary in result["summary"].items():
        mine = {part: [e for e in result.get(part, ()) if e["paper"] == paper] for part in PARTS}
        equations = ((e["equation"], e.get("claims", ""), e["verdict"], remark(e), hangs_on(e))
                     for e in mine["equations"])  # fmt: skip
        head = ("", "claims to be", "verdict", "why", "hangs on")
        console.table(f"{summary['title']}: equations", head, equations)
        if mine["causes"]:
            rows = ((e["cause"], ", ".join(_unnamed(e["equations"])), len(e["numbers"])) for e in mine["causes"])
            console.table("Causes", ("one slip", "equations", "numbers"), rows)
        for found in mine["references"]:
            _say(reference(found))
        _laws(console, mine["laws"])
        if mine["claims"]:
            claims = ((e["claim"], amount(e["value"], e["unit"]), e["must"], "yes" if e["holds"] else "no")
                      for e in mine["claims"])  # fmt: skip
            console.table("Statements", ("statement", "measure", "must", "holds"), claims)
        _numbers(console, mine["numbers"])
        if mine["consequences"]:
            _consequences(console, mine["consequences"])
        for part in ("equations", "numbers"):
            _say(f"{part}: {tally(summary[part])}")
        print()


def _unnamed(names: Sequence[str]) -> list[str]:
    """Names without that of the paper."""
    return [name.partition(": ")[2] for name in names]


def reference(found: Entry) -> str:
    """A cross-reference that cannot be meant, in a sentence."""
    numbers, instead = (", ".join(f"({n})" for n in found[key]) for key in ("refers_to", "instead"))
    said = f"{', '.join(found['quantities'])} cannot come from {numbers}, as the paper says"
    return f"{said}: these do not give {', '.join(found['lacking'])}; {instead} do."


def _laws(console: Console, found: Sequence[Entry]) -> None:
    """The laws, and what each responsible equation does to those that are broken."""
    if not found:
        return
    laws = ((e["law"], e["violation"], e["violation_literal"], e["unit"], blamed(e)) for e in found)
    console.table("Laws", ("law", "broken by", "read literally", "unit", "restored by repairing"), laws)
    for text in dict.fromkeys(readings(found)):
        _say(f"{text}.")
    for law in found:
        if len(law.get("shares", ())) > 1:
            rows = ((s["equation"], s["alone"], s["without"], s["shapley"]) for s in law["shares"])
            console.table(f"{law['law']} [{law['unit']}]", ("", "repaired alone", "left alone", "Shapley"), rows)
        if law.get("owed"):
            _say(f"{law['law'][:1].upper()}{law['law'][1:]}: {law['owed']}")


def readings(laws: Iterable[Entry]) -> Iterator[str]:
    """Return what the chain of each law is read as that is not read literally, as the printed model computes it."""
    for law in laws:
        if law["reading"]:
            yield f"Broken by: under the kindest joint reading, {law['reading']}. Read literally: the printed model"


@dataclass
class Notes:
    """Texts that are said once, below a table, and marked by letters in it."""

    texts: list[str] = field(default_factory=list)

    def mark(self, text: str) -> str:
        """The letter of a text; nothing for an empty one."""
        if not text:
            return ""
        if text not in self.texts:
            self.texts.append(text)
        first, second = divmod(self.texts.index(text), len(ascii_lowercase))
        return (ascii_lowercase[first - 1] if first else "") + ascii_lowercase[second]


def _numbers(console: Console, found: list[Entry]) -> None:
    if not found:
        return
    notes = Notes()
    keys = ("quantity", "unit", "printed_text", "recomputed")
    places = any(e["place"] for e in found)
    rows = [(*((e["place"],) if places else ()), *(cell_text(e[key]) for key in keys), _apart(e), e["verdict"],
             notes.mark(basis(e))) for e in found]  # fmt: skip
    head = ("quantity", "unit", "printed", "computed", "differs by", "verdict", "")
    console.table("Numbers", (*(("place",) if places else ()), *head), rows)
    if notes.texts:
        console.table("", ("", "numbers rest on"), ((notes.mark(text), text) for text in notes.texts))


def _apart(number: Entry) -> str:
    """What was computed less what is printed, where that is more than its digits say."""
    return f"{number['difference']:+.3g}" if number["verdict"] == "not reproduced" and number["difference"] else ""


def _consequences(console: Console, found: list[Entry]) -> None:
    for about in dict.fromkeys(e["about"] for e in found):
        rows = [(e["quantity"], e["unit"], *(_value(e[key]) for key in ("printed", "as_printed", "as_derived")),
                 ", ".join(e["rests_on"])) for e in found if e["about"] == about]  # fmt: skip
        head = (about, "unit", "in paper", "by print", "derived", "rests on")
        console.table("What follows" if about == found[0]["about"] else "", head, rows)
    for entry in found:
        if entry["statement"]:
            _say(entry["statement"])
    print()


def _value(value: float | None) -> str:
    return cell_text(None if value is None else plain(float(value)))


def _say(text: str) -> None:
    """A sentence over as many lines as it needs."""
    import textwrap

    print(textwrap.fill(text, shutil.get_terminal_size().columns, break_on_hyphens=False))


def remark(equation: Entry) -> str:
    """What is wrong with an equation, in a few words: its correction, and the largest of its missing terms.

    Of one that is not judged, the reason.
    """
    parts = [_cut(equation["finding"])] if equation["verdict"] == "contradicted" else []
    parts += [f"correct {text}" for text in equation["correction"]]
    if equation["terms"]:
        largest = max(equation["terms"], key=lambda term: term["share_of_largest"] or 0)
        count = len(equation["terms"])
        share = largest["share_of_largest"]
        size = "" if share is None else f", {100 * share:.3g} % of the largest term"
        parts.append(f"{count} term{'s' if count > 1 else ''} missing, such as {_cut(largest['term'])}{size}")
    if not parts and (equation["verdict"] in (*FAULTY, consequences.UNJUDGED) or equation.get("domain")):
        parts.append(equation["finding"])
    return "; ".join(parts)


def hangs_on(equation: Entry) -> str:
    """What a verdict rests on: a reading, a single character, pieces that were completed, where a machine uses it."""
    parts = {
        "the reading": not equation.get("robust", True),
        "one character": equation.get("fragile"),
        "the domain of use": equation.get("domain"),
        "pieces completed": equation.get("rebuilt"),
    }
    return ", ".join(text for text, so in parts.items() if so)


def _cut(text: str) -> str:
    """A text as far as a line has room for it.

    >>> _cut("a + b"), len(_cut("x" * 200))
    ('a + b', 60)
    """
    return text if len(text) <= _SHORT else text[: _SHORT - 4].rstrip(" ,;*+-(") + " ..."


def blamed(law: Entry) -> str:
    """The smallest sets of equations whose repair restores a law."""
    if law["violation"] is None:
        return consequences.UNJUDGED
    sets = [law["caused_by"], *law.get("or_by", ())] if law["caused_by"] else []
    return " or ".join(", ".join(chosen) for chosen in sets) or "kept"


def amount(value: float | None, unit: str) -> str:
    """A value with its unit, to three digits.

    >>> amount(0.00275414, ""), amount(31.2514, "deg"), amount(None, "N")
    ('0.00275', '31.3 deg', '-')
    """
    return "-" if value is None else f"{plain(value):.3g} {unit}".strip()


def plain(value: float | None) -> float | None:
    """A value without the rounding errors that stand for zero.

    >>> plain(-1.8e-14), plain(1.8e-6), plain(None)
    (0.0, 1.8e-06, None)
    """
    return 0.0 if value is not None and abs(value) < ROUNDING else value


def headline(entry: Entry) -> str:
    """A headline number by the print and as derived, in a sentence."""
    printed, derived = (amount(entry[key], entry["unit"]) for key in ("as_printed", "as_derived"))
    own = "" if entry["printed"] is None else f" (in the paper {entry['printed']:g})"
    return f"{entry['quantity'][:1].upper()}{entry['quantity'][1:]}{own}: {printed} by the print, {derived} as derived."


def side_by_side(found: Sequence[Entry]) -> str:
    """Numbers that belong together, in the paper, by the print and as derived, in a sentence."""
    parts = (f"{e['quantity']} {e['printed']:g}, {plain(e['as_printed']):.3g}, {amount(e['as_derived'], e['unit'])}"
             for e in found)  # fmt: skip
    about = found[0]["about"]
    return f"{about[:1].upper()}{about[1:]}, in the paper, by the print and as derived: {'; '.join(parts)}."


def measured(claim: Entry) -> str:
    """What was measured of a statement, in a sentence without its full stop."""
    text = f"{claim['measure']}: {amount(claim['value'], claim['unit'])}, where it must {claim['must']}"
    return text[:1].upper() + text[1:]


def basis(number: Entry) -> str:
    """What a number rests on besides what its paper discloses."""
    assumed = number["assumed_inputs"]
    listed = ", ".join(assumed) if len(assumed) <= 2 else f"{len(assumed)} inputs"
    lacking = f"not disclosed: {', '.join(number['needs'])}" if number["needs"] else ""
    rounding = number["verdict"] == "consistent" and number["interval"]
    ends = "rounded inputs: {:.5g} to {:.5g}".format(*rounding) if rounding else ""
    parts = (listed and f"assumed: {listed}", lacking, ends, number["reading"], number["reason"])
    return "; ".join(part for part in parts if part)


def tally(found: Mapping[str, int]) -> str:
    """Verdicts with how often each was given."""
    return ", ".join(f"{count} {name}" for name, count in found.items()) or "none"
