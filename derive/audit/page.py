"""The audit's findings as a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from .causes import causes
from .judgement import FAULTS
from .record import Record, summary

SILENT = ("confirmed", "confirmed as rebuilt", "definition", "untested")
"""Verdicts that leave nothing to say but what a symbol is read as or what vanishes."""
LAW_DIGITS = 4
HEAD = ("| equation | claims to be | legibility | verdict | depends on |", "|---|---|---|---|---|")
SOURCE = (
    "The machine-read text of each paper was audited, not its page images. Gaps that were filled in are listed",
    "(`confirmed as rebuilt`); where the text is lost, only the derivation is given (`reconstructed`). A finding that",
    "depends on one character may be an error of reading. If a symbol is ambiguous, every admissible reading is tried.",
    "Equations that share a symbol are judged under one meaning of it: the joint reading most favourable to all of",
    "them decides, and the verdicts under the others are listed. One mistake in several equations counts once.",
)


def as_page(
    records: Sequence[Record],
    titles: Mapping[str, str],
    laws: Sequence[Record] = (),
    references: Sequence[Record] = (),
) -> str:
    """The findings to read: a table and, where there is something to say, a paragraph for each equation; the laws."""
    lines = ["# Formula audit", "", "Written by `python -m derive audit`; do not edit.", "", *SOURCE, ""]
    lines += [*overview(records), ""]
    for paper, counts in summary(records).items():
        lines += [f"## {titles[paper]}", "", ", ".join(f"{n} {word}" for word, n in counts.items()) + ".", ""]
        own = [r for r in records if r["paper"] == paper]
        lines += [*_causes(own), *HEAD]
        lines += [_row(r) for r in own] + [""]
        for record in own:
            lines += _paragraph(record)
        lines += [line for one in references if one["paper"] == paper for line in _reference(one)]
    return "\n".join([*lines, *_laws(laws)])


def overview(records: Sequence[Record]) -> list[str]:
    """A table of the papers: verdicts, equations at fault, causes, and what hangs on a reading or a character."""
    lines = ["| paper | verdicts | at fault | causes | on a reading | on one character |", "|---|---|---|---|---|---|"]
    for paper, counts in summary(records).items():
        own = [r for r in records if r["paper"] == paper]
        verdicts = ", ".join(f"{n} {word}" for word, n in counts.items())
        found = (
            sum(r["verdict"] in FAULTS for r in own),
            len(causes(own)),
            sum(not r["robust"] for r in own),
            sum(r["fragile"] for r in own),
        )
        lines.append(f"| {paper} | {verdicts} | {' | '.join(map(str, found))} |")
    return lines


def _reference(found: Record) -> list[str]:
    """A cross-reference, where it cannot be meant."""
    if not found["lacking"]:
        return []
    numbers, instead = (", ".join(f"({n})" for n in found[key]) for key in ("refers_to", "instead"))
    said = f"{', '.join(found['quantities'])} are said to come from {numbers}, which do not give"
    return ["### Reference that cannot be meant", "", f"{said} {', '.join(found['lacking'])}; {instead} do.", ""]


def _row(record: Record) -> str:
    cells = (f"({record['equation']})", record["claims"], record["legibility"], record["verdict"], hangs_on(record))
    return f"| {' | '.join(cells)} |"


def hangs_on(record: Record) -> str:
    """What a verdict rests on: a reading, a single character, pieces that were completed, where a machine uses it."""
    parts = ["" if record["robust"] else "the reading", "one character" if record["fragile"] else ""]
    parts.append("the domain of use" if record["domain"] else "")
    parts.append("pieces completed" if record["rebuilt"] else "")
    return ", ".join(part for part in parts if part)


def _causes(records: Sequence[Record]) -> list[str]:
    """How many findings there are, and of how many causes; each cause with its equations."""
    found = causes(records)
    if not found:
        return []
    faulty = sum(1 for record in records if record["verdict"] in FAULTS)
    lines = [f"{faulty} equations are at fault, for {len(found)} causes.", "", "| cause | equations |", "|---|---|"]
    names = ((cause["cause"], (e.partition(": ")[2] for e in cause["equations"])) for cause in found)
    return [*lines, *(f"| {cause} | {', '.join(f'({n})' for n in numbers)} |" for cause, numbers in names), ""]


def _paragraph(record: Record) -> list[str]:
    if record["verdict"] in SILENT and not any(record[part] for part in ("vanishing", "depends", "domain")):
        return []
    lines = [f"### ({record['equation']}) {record['verdict']}", ""]
    for label, text in (("As printed", record["printed"]), ("As derived", record["derived"])):
        lines += [f"{label}: `{text}`", ""] if text else []
    lines += [f"Finding: {record['finding']}.", ""]
    if record["rebuilt"]:
        lines += [f"Completed: {'; '.join(record['rebuilt'])}.", ""]
    if record["fragile"]:
        lines += ["One character decides: it may be an error of reading.", ""]
    if record["reading"]:
        lines += [f"Reading: {record['reading']}.", ""]
    lines += _depends(record["depends"])
    if record["correction"]:
        lines += ["Smallest correction: " + " or ".join(f"`{c}`" for c in record["correction"]) + ".", ""]
    lines += _sizes("missing term", record["terms"])
    lines += _sizes("unexplained term", record["unexplained"])
    lines += _vanishing(record["vanishing"])
    return lines


def _depends(readings: Sequence[Record]) -> Iterator[str]:
    if readings:
        yield "| reading | admitted by | verdict | finding |"
        yield "|---|---|---|---|"
        for one in readings:
            yield f"| {' | '.join(one[key] for key in ('reading', 'because', 'verdict', 'finding'))} |"
        yield ""


def _sizes(name: str, terms: Sequence[Record]) -> Iterator[str]:
    if terms:
        yield f"| {name} | largest over the cycle | unit | share of the largest term |"
        yield "|---|---|---|---|"
        for t in terms:
            yield f"| `{t['term']}` | {_number(t['max_abs'], 4)} | {t['unit']} | {_number(t['share_of_largest'], 3)} |"
        yield ""


def _vanishing(terms: Sequence[Record]) -> Iterator[str]:
    if terms:
        yield "| term that vanishes | because | printed |"
        yield "|---|---|---|"
        for t in terms:
            yield f"| `{t['term']}` | {t['because']} | {'yes' if t['printed'] else 'no'} |"
        yield ""


def _number(value: float | None, digits: int, absent: str = "no real value") -> str:
    return absent if value is None else f"{value:.{digits}g}"


def _laws(records: Sequence[Record]) -> list[str]:
    """A section of the page, a table of the laws by paper."""
    if not records:
        return []
    lines = ["## Laws of each chain as a whole", "", "Each printed chain, executed over the reference cycle; a law is"]
    lines += ["laid to the smallest set of equations whose repair restores it. A search is exhaustive if every smaller"]
    lines += ["set, and every other of that size, was tried; one by elimination may have missed a smaller set.", ""]
    for paper, reading in {r["paper"]: r["reading"] for r in records if r["reading"]}.items():
        lines += [
            f"{paper} is read under the kindest joint reading: {reading}. Read literally: what the generated printed"
        ]
        lines += ["model computes, in which each symbol means what the equation that gives it says.", ""]
    lines += ["| paper | law | broken by | read literally | unit | laid to | search |", "|---|---|---|---|---|---|---|"]
    for record in records:
        sets = [record["caused_by"], *record["or_by"]] if record["caused_by"] else []
        laid = " or ".join(", ".join(f"({number})" for number in chosen) for chosen in sets) or "kept"
        if record["violation"] is None:
            laid = record["owed"]
        sizes = (_number(record[key], LAW_DIGITS, "unknown") for key in ("violation", "violation_literal"))
        cells = (record["paper"], record["law"], *sizes, record["unit"], laid, record["search"])
        lines += [f"| {' | '.join(cells)} |"]
    lines += ["", "What each of these equations does: what its repair alone takes away, what it alone leaves when all"]
    lines += [
        "others are repaired, and its Shapley value, the mean over all orders of repair. These values add up to",
        "the violation; some may be negative, so that others exceed it.",
        "",
    ]
    for record in records:
        lines += _shares(record)
    return lines


def _shares(law: Record) -> list[str]:
    if not law["shares"]:
        return []
    lines = [f"**{law['law']}**: {law['owed']}", "", f"| equation | alone [{law['unit']}] | left | Shapley |"]
    lines += ["|---|---|---|---|"]
    sizes = ((s["equation"], *(f"{s[key]:.4g}" for key in ("alone", "without", "shapley"))) for s in law["shares"])
    return [*lines, *(f"| ({number}) | {' | '.join(shown)} |" for number, *shown in sizes), ""]
