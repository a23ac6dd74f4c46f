"""The audit's findings as data and as a page."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import mpmath
import sympy as sp
from sympy import Expr

from derive.audit.judge import Judgement, judge
from derive.audit.laws import as_lines
from derive.audit.subject import Subject
from derive.audit.terms import expanded
from derive.dimensions import dimension, of_unit
from derive.evaluate import NotEvaluated, Point

Record = dict[str, Any]
DIGITS = 6
_UNITS = (
    "1",
    "m",
    "m2",
    "kg",
    "s",
    "rad/s",
    "m/s",
    "m/s2",
    "N",
    "N m",
    "N/m",
    "W",
    "kg m2",
    "kg m",
    "kg/s",
    "1/m",
    "Pa",
)


def equations(subject: Subject) -> list[Record]:
    """A record for every equation of a paper."""
    return [_record(subject, number) for number in subject.paper.equations]


def _record(subject: Subject, number: str) -> Record:
    printed, derived = subject.pair(number)
    found = judge(printed, derived, subject.points, subject.words)
    return {
        "paper": subject.paper.name,
        "equation": number,
        "legibility": printed.legibility,
        "claims": str(printed.claims),
        "verdict": found.verdict,
        "finding": found.finding,
        "correction": ["; ".join(edits) for edits in found.corrections],
        "reading": subject.read_as(number),
        "terms": _terms(subject, found, derived.residual if derived else sp.S.Zero),
        "printed": str(printed.residual) + f" {printed.relation} 0",
    }


def _terms(subject: Subject, found: Judgement, derived: Expr) -> list[dict[str, Any]]:
    if not found.missing:
        return []
    largest = max((_largest(t, subject.cycle) for t in expanded(derived)), default=mpmath.mpf(0))
    return [
        {"term": str(t), "max_abs": _rounded(size := _largest(t, subject.cycle)), "unit": unit_of(t),
         "share_of_largest": _rounded(size / largest) if largest else 0.0}
        for t in sorted(found.missing, key=sp.default_sort_key)
    ]  # fmt: skip


def _largest(term: Expr, cycle: list[Point]) -> mpmath.mpf:
    try:
        return max((abs(point(term)) for point in cycle), default=mpmath.mpf(0))
    except NotEvaluated:
        return mpmath.mpf(0)


def _rounded(value: mpmath.mpf) -> float:
    return float(mpmath.nstr(value, DIGITS))


def unit_of(expr: Expr) -> str:
    """A unit of the dimension of an expression."""
    found = dimension(expr)
    return next((u for u in _UNITS if of_unit(u) == found), "?") if found else "1"


def summary(records: Iterable[Record]) -> dict[str, dict[str, int]]:
    """How many of each verdict, by paper."""
    counts: dict[str, Counter[str]] = {}
    for record in records:
        counts.setdefault(record["paper"], Counter())[record["verdict"]] += 1
    return {paper: dict(sorted(found.items())) for paper, found in counts.items()}


def as_json(records: Sequence[Record], laws: Sequence[Record] = ()) -> str:
    content = {"equations": list(records), "laws": list(laws), "summary": summary(records)}
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def as_page(records: Sequence[Record], references: dict[str, str], laws: Sequence[Record] = ()) -> str:
    """The findings to read: a table and, where there is something to say, a paragraph for each equation; the laws."""
    lines = ["# Formula audit", "", "Written by `python -m derive audit`; do not edit.", ""]
    for paper, counts in summary(records).items():
        lines += [f"## {references[paper]}", "", ", ".join(f"{n} {word}" for word, n in counts.items()) + ".", ""]
        lines += ["| equation | claims to be | legibility | verdict |", "|---|---|---|---|"]
        own = [r for r in records if r["paper"] == paper]
        lines += [f"| ({r['equation']}) | {r['claims']} | {r['legibility']} | {r['verdict']} |" for r in own] + [""]
        for record in own:
            lines += _paragraph(record)
    return "\n".join(lines + as_lines(laws))


def _paragraph(record: Record) -> list[str]:
    if record["verdict"] in ("confirmed", "definition"):
        return []
    lines = [
        f"### ({record['equation']}) {record['verdict']}",
        "",
        f"As printed: `{record['printed']}`. {record['finding']}.",
        "",
    ]
    if record["reading"]:
        lines += [f"Reading: {record['reading']}.", ""]
    if record["correction"]:
        lines += ["Smallest correction: " + " or ".join(f"`{c}`" for c in record["correction"]) + ".", ""]
    if record["terms"]:
        lines += ["| missing term | largest over the cycle | unit | share of the largest term |", "|---|---|---|---|"]
        lines += [
            f"| `{t['term']}` | {t['max_abs']:.4g} | {t['unit']} | {t['share_of_largest']:.3g} |"
            for t in record["terms"]
        ]
        lines += [""]
    return lines
