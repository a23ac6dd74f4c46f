"""What the verdicts on equations mean for a paper's headline numbers: each by the print and by what is derived.

A consequence stands only while an equation or a number that it rests on is at fault: nothing here knows a verdict.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from planter.audit.registry import CONSEQUENCES, FORMULAS, Inputs, Value

FAULTY = ("misprint", "incomplete", "contradicted")
UNJUDGED = "not judged"
HEADLINE = "headline number"
Entry = dict[str, Any]


def drawn(paper: str | None, table: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[Entry]:
    """Consequences for all papers, or for one, from the verdicts of a trial: its `equations`, `laws` and `numbers`."""
    found: list[Entry] = []
    for name in table["papers"]:
        if paper in (None, name):
            found += headlines(name, table, trial)
            for row in table.get("chain", ()):
                if row["paper"] == name:
                    found += CONSEQUENCES[row["by"]](row, table["disclosed"][name], trial)
    return found


def headlines(
    paper: str, table: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]
) -> Iterator[Entry]:
    """Printed numbers that rest on something at fault, by the equations as printed and as derived."""
    for row in table.get("headline", ()):
        if row["paper"] != paper:
            continue
        rests_on = _at_fault(row, trial)
        if rests_on:
            for own in _each(row):
                yield _headline(row, own, rests_on, table)


def _at_fault(row: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    mine = {part: [e for e in trial[part] if e["paper"] == row["paper"]] for part in ("equations", "numbers")}
    equations = {e["equation"] for e in mine["equations"] if e["verdict"] in FAULTY}
    numbers = {e["quantity"] for e in mine["numbers"] if e["verdict"] == "not reproduced"}
    return [name for name in row.get("equations", ()) if name in equations] + [
        name for name in row.get("quantities", ()) if name in numbers
    ]


def _each(row: Mapping[str, Any]) -> list[dict[str, Any]]:
    each: Mapping[str, Sequence[Any]] = row.get("each", {})
    count = len(next(iter(each.values()))) if each else 1
    return [{name: values[i] for name, values in each.items()} for i in range(count)]


def _headline(row: Mapping[str, Any], own: Mapping[str, Any], rests_on: list[str], table: Mapping[str, Any]) -> Entry:
    disclosed, assumed = table["disclosed"][row["paper"]], table["assumed"][row["paper"]]
    values: dict[str, Value] = {}
    inputs = []
    for key in ("as_printed", "as_derived"):
        arguments = {**row.get("with", {}), **row.get(f"with_{key}", {}), **own}
        inputs.append(Inputs(arguments, disclosed, assumed))
        values[key] = FORMULAS[row[key]](inputs[-1])
    return {
        "paper": row["paper"],
        "about": HEADLINE,
        "quantity": row["quantity"].format_map(own),
        "unit": row["unit"],
        "printed": float(own["printed"]) if "printed" in own else row.get("printed"),
        **values,
        "rests_on": rests_on,
        "assumed_inputs": list(dict.fromkeys(text for one in inputs for text in one.assumed)),
        "statement": "",
    }
