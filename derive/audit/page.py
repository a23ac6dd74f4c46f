"""The audit's findings as a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from .record import Record, summary

SILENT = ("confirmed", "definition")
"""Verdicts that leave nothing to say but what a symbol is read as or what vanishes."""
LAW_DIGITS = 4


def as_page(records: Sequence[Record], references: Mapping[str, str], laws: Sequence[Record] = ()) -> str:
    """The findings to read: a table and, where there is something to say, a paragraph for each equation; the laws."""
    lines = ["# Formula audit", "", "Written by `python -m derive audit`; do not edit.", ""]
    for paper, counts in summary(records).items():
        lines += [f"## {references[paper]}", "", ", ".join(f"{n} {word}" for word, n in counts.items()) + ".", ""]
        lines += ["| equation | claims to be | legibility | verdict |", "|---|---|---|---|"]
        own = [r for r in records if r["paper"] == paper]
        lines += [f"| ({r['equation']}) | {r['claims']} | {r['legibility']} | {r['verdict']} |" for r in own] + [""]
        for record in own:
            lines += _paragraph(record)
    return "\n".join([*lines, *_laws(laws)])


def _paragraph(record: Record) -> list[str]:
    if record["verdict"] in SILENT and not record["vanishing"]:
        return []
    lines = [f"### ({record['equation']}) {record['verdict']}", ""]
    for label, text in (("As printed", record["printed"]), ("As derived", record["derived"])):
        lines += [f"{label}: `{text}`", ""] if text else []
    lines += [f"Finding: {record['finding']}.", ""]
    if record["reading"]:
        lines += [f"Reading: {record['reading']}.", ""]
    if record["correction"]:
        lines += ["Smallest correction: " + " or ".join(f"`{c}`" for c in record["correction"]) + ".", ""]
    lines += _sizes("missing term", record["terms"])
    lines += _sizes("unexplained term", record["unexplained"])
    lines += _vanishing(record["vanishing"])
    return lines


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


def _number(value: float | None, digits: int) -> str:
    return "no real value" if value is None else f"{value:.{digits}g}"


def _laws(records: Sequence[Record]) -> list[str]:
    """A section of the page, a table of the laws by paper."""
    if not records:
        return []
    lines = ["## Laws of each chain as a whole", "", "Each printed chain, executed over the reference cycle; a law is"]
    lines += ["laid to the smallest set of equations whose repair restores it. A search is exhaustive if every smaller"]
    lines += ["set, and every other of that size, was tried; one by elimination may have missed a smaller set.", ""]
    lines += ["| paper | law | broken by | unit | laid to | search |", "|---|---|---|---|---|---|"]
    for record in records:
        sets = [record["caused_by"], *record["or_by"]] if record["caused_by"] else []
        laid = " or ".join(", ".join(f"({number})" for number in chosen) for chosen in sets) or "kept"
        size = f"{record['violation']:.{LAW_DIGITS}g}"
        lines += [f"| {record['paper']} | {record['law']} | {size} | {record['unit']} | {laid} | {record['search']} |"]
    return [*lines, ""]
