"""Consequences of the verdicts for a paper's headline numbers, computed as printed and as derived.

A consequence is reported only while an equation or a number that it rests on is at fault; no verdict is fixed here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from planter.audit.registry import CONSEQUENCES, FORMULAS, Inputs, Value

FAULTY = ("misprint", "incomplete", "contradicted")
UNJUDGED = "not judged"
HEADLINE = "headline number"
Entry = dict[str, Any]


def derive_consequences(
    paper: str | None, table: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[Entry]:
    """Return the consequences for all papers, or for one, from the verdicts on `equations`, `laws` and `numbers`."""
    consequences: list[Entry] = []
    for name in table["papers"]:
        if paper in (None, name):
            consequences += list_headlines(name, table, trial)
            for row in table.get("chain", ()):
                if row["paper"] == name:
                    consequences += CONSEQUENCES[row["by"]](row, table["disclosed"][name], trial)
    return consequences


def list_headlines(
    paper: str, table: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]
) -> Iterator[Entry]:
    """Yield printed numbers that rest on a fault, by the equations as printed and as derived."""
    for row in table.get("headline", ()):
        if row["paper"] != paper:
            continue
        rests_on = _find_faults(row, trial)
        if rests_on:
            for entry in _list_entries(row):
                yield _build_headline(row, entry, rests_on, table)


def _find_faults(row: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    judged = {part: [e for e in trial[part] if e["paper"] == row["paper"]] for part in ("equations", "numbers")}
    equations = {e["equation"] for e in judged["equations"] if e["verdict"] in FAULTY}
    numbers = {e["quantity"] for e in judged["numbers"] if e["verdict"] == "not reproduced"}
    return [name for name in row.get("equations", ()) if name in equations] + [
        name for name in row.get("quantities", ()) if name in numbers
    ]


def _list_entries(row: Mapping[str, Any]) -> list[dict[str, Any]]:
    each: Mapping[str, Sequence[Any]] = row.get("each", {})
    count = len(next(iter(each.values()))) if each else 1
    return [{name: values[i] for name, values in each.items()} for i in range(count)]


def _build_headline(
    row: Mapping[str, Any], entry: Mapping[str, Any], rests_on: list[str], table: Mapping[str, Any]
) -> Entry:
    disclosed, assumed = table["disclosed"][row["paper"]], table["assumed"][row["paper"]]
    values: dict[str, Value] = {}
    inputs = []
    for key in ("as_printed", "as_derived"):
        arguments = {**row.get("with", {}), **row.get(f"with_{key}", {}), **entry}
        inputs.append(Inputs(arguments, disclosed, assumed))
        values[key] = FORMULAS[row[key]](inputs[-1])
    return {
        "paper": row["paper"],
        "about": HEADLINE,
        "quantity": row["quantity"].format_map(entry),
        "unit": row["unit"],
        "printed": float(entry["printed"]) if "printed" in entry else row.get("printed"),
        **values,
        "rests_on": rests_on,
        "assumed_inputs": list(dict.fromkeys(text for arguments_read in inputs for text in arguments_read.assumed)),
        "statement": "",
    }
