"""Findings by cause: what removes one finding and others with it is one slip, in however many equations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

Record = Mapping[str, Any]
LACKS = "lacks "
"""How the reason of a finding begins that is an omission."""


def causes(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Every reason of a finding, once, with the equations of its paper that have it; the most shared first.

    An equation that lacks several things for one reason has the one that it shares with most others.
    """
    shared = Counter((r["paper"], reason) for r in records for reason in r["reasons"])
    found: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        for reason in _chosen(record, shared):
            found.setdefault((record["paper"], reason), []).append(record)
    ranked = sorted(found.items(), key=lambda item: -len(item[1]))
    return [_cause(paper, reason, mine) for (paper, reason), mine in ranked]


def _chosen(record: Record, shared: Mapping[tuple[str, str], int]) -> list[str]:
    lacking = [reason for reason in record["reasons"] if reason.startswith(LACKS)]
    most = max(lacking, key=lambda reason: shared[record["paper"], reason], default=None)
    return [reason for reason in record["reasons"] if reason not in lacking or reason == most]


def _cause(paper: str, reason: str, mine: Sequence[Record]) -> dict[str, Any]:
    omitted = reason.startswith(LACKS)
    return {
        "paper": paper,
        "cause": f"{reason.removeprefix(LACKS)} is left out" if omitted else reason,
        "repair": f"add {_terms(mine[0])}" if omitted else reason,
        "equations": [f"{paper}: {record['equation']}" for record in mine],
        "numbers": [],
    }


def _terms(record: Record) -> str:
    return ", ".join(term["term"] for term in record["terms"])


def told(law: Record, equations: Mapping[str, Record]) -> str:
    """Return what is missing where, and by how much its repair alone reduces the violation of a broken law.

    The equation is that of the largest Shapley value. These values may be negative or exceed the violation, so none of
    them is told as a part of it.
    """
    if not law["shares"]:
        return ""
    first = law["shares"][0]
    record = equations[first["equation"]]
    what = f"it lacks {_terms(record)}" if record["terms"] else _repair(record)
    left = max(law["violation"] - first["alone"], 0.0)
    sizes = f"from {law['violation']:.3g} to {left:.3g} {law['unit']}"
    return f"Repairing ({record['equation']}) alone reduces the violation {sizes}: {record['claims']}; {what}."


def _repair(record: Record) -> str:
    return f"correct: {'; or '.join(record['correction'])}" if record["correction"] else str(record["finding"])
