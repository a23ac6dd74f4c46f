"""Audit of statements in the text of papers: each has a measure, and holds if the measure meets its condition."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from typing import Any

from planter.audit.numbers import load_numbers
from planter.audit.registry import Computation, Inputs

EXACT = 1e-9
"""Tolerance of exact claims; lengths and angles are of order one, or in mm and deg."""
_TESTS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip


def judge_claims(paper: str | None = None, content: Mapping[str, Any] | None = None) -> list[dict[str, Any]]:
    """Return every claim, or those of one paper, with measure, condition, and whether it holds.

    Assumed inputs of the measure are listed; the result is valid only for these inputs. A claim holds if some value
    within the rounding of the printed inputs meets its condition.
    """
    table = load_numbers() if content is None else content
    return [_judge_claim(row, table) for row in table["claim"] if paper in (None, row["paper"])]


def meets(value: float, must: str, tolerance: float = EXACT) -> bool:
    """Return whether a value meets a condition.

    >>> meets(0.02, "< 0.05"), meets(1e-12, "= 0"), meets(1e-3, "= 0"), meets(-1e-12, ">= 0")
    (True, True, False, True)
    """
    return interval_meets((value, value), must, tolerance)


def interval_meets(interval: tuple[float, float], must: str, tolerance: float = EXACT) -> bool:
    """Return whether some value of an interval meets a condition.

    >>> interval_meets((-0.02, 0.03), "= 0"), interval_meets((-0.02, 0.03), "> 0")
    (True, True)
    >>> interval_meets((-0.02, -0.01), ">= 0")
    False
    """
    sign, text = must.split()
    (low, high), limit = interval, float(text)
    if sign == "=":
        return low - tolerance <= limit <= high + tolerance
    slack = tolerance if sign in ("<=", ">=") else 0.0
    return _TESTS[sign](high + slack if ">" in sign else low - slack, limit)


def _judge_claim(row: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    inputs = Inputs(row.get("with", {}), table["disclosed"][row["paper"]], table["assumed"][row["paper"]])
    computed = Computation.evaluate(row["by"], inputs)
    interval, limits = computed.interval, (row["must"], row.get("within", EXACT))
    return {
        "paper": row["paper"],
        "claim": row["claim"],
        "measure": row["measure"],
        "value": computed.value,
        "unit": row["unit"],
        "must": re.sub(r"^= ", "be ", row["must"]) if row["must"].startswith("=") else f"be {row['must']}",
        "holds": interval is not None and interval_meets(interval, *limits),
        "assumed_inputs": list(inputs.assumed),
    }
