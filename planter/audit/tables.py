"""The audit as tables on a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from planter.console import Console

Entry = Mapping[str, Any]


def show(console: Console, result: Mapping[str, Any]) -> None:
    """Per paper: equations, violated laws, numbers, and how often each verdict was given."""
    for paper, summary in result["summary"].items():
        mine = {part: [e for e in result[part] if e["paper"] == paper] for part in ("equations", "laws", "numbers")}
        equations = ((e["equation"], e.get("claims", ""), e["verdict"], remark(e)) for e in mine["equations"])
        console.table(f"{summary['title']}: equations", ("", "claims to be", "verdict", "why"), equations)
        if mine["laws"]:
            laws = ((e["law"], e["violation"], e["unit"], ", ".join(e["caused_by"])) for e in mine["laws"])
            console.table("Violated laws", ("law", "by", "unit", "caused by"), laws)
        numbers = ((e["quantity"], e["unit"], e["printed_text"], e["recomputed"], e["verdict"], basis(e))
                   for e in mine["numbers"])  # fmt: skip
        console.table("Numbers", ("quantity", "unit", "printed", "recomputed", "verdict", "rests on"), numbers)
        for part in ("equations", "numbers"):
            print(f"{part}: {tally(summary[part])}")
        print()


def remark(equation: Entry) -> str:
    """What is wrong with an equation, in a few words: its correction, and the largest of its missing terms."""
    parts = [equation["finding"]] if equation["verdict"] == "contradicted" else []
    parts += [f"correct {text}" for text in equation["correction"]]
    if equation["terms"]:
        largest = max(equation["terms"], key=lambda term: term["share_of_largest"] or 0)
        count = len(equation["terms"])
        share = largest["share_of_largest"]
        size = "" if share is None else f", {100 * share:.3g} % of the largest term"
        parts.append(f"{count} term{'s' if count > 1 else ''} missing, such as {largest['term']}{size}")
    if not parts and equation["verdict"] != "confirmed":
        parts.append(equation["finding"])
    return "; ".join(parts)


def basis(number: Entry) -> str:
    """What a number rests on besides what its paper discloses."""
    assumed = number["assumed_inputs"]
    listed = ", ".join(assumed) if len(assumed) <= 2 else f"{len(assumed)} inputs"
    lacking = f"not disclosed: {', '.join(number['needs'])}" if number["needs"] else ""
    return "; ".join(part for part in (listed and f"assumed: {listed}", lacking, number["reading"]) if part)


def tally(found: Mapping[str, int]) -> str:
    """Verdicts with how often each was given."""
    return ", ".join(f"{count} {name}" for name, count in found.items()) or "none"
