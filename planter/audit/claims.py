"""Statements in the papers' text on trial: each is measured in numbers, and holds if the measure is what it must be."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from typing import Any

from planter.audit.numbers import data
from planter.audit.registry import Computation, Inputs

EXACT = 1e-9
"""What counts as zero where a claim must hold exactly; lengths and angles are of order one, or in mm and deg."""
_TESTS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip


def judged(paper: str | None = None, content: Mapping[str, Any] | None = None) -> list[dict[str, Any]]:
    """Every claim, or those of one paper: its measure, what that must be, and whether it holds.

    What was assumed for the measure is listed; with such inputs a claim holds or fails for these inputs alone. It holds
    if some value within the rounding of the printed inputs is what it must be.
    """
    table = data() if content is None else content
    return [_judged(row, table) for row in table["claim"] if paper in (None, row["paper"])]


def met(value: float, must: str, within: float = EXACT) -> bool:
    """Whether a value is what it must be.

    >>> met(0.02, "< 0.05"), met(1e-12, "= 0"), met(1e-3, "= 0"), met(-1e-12, ">= 0")
    (True, True, False, True)
    """
    return met_by((value, value), must, within)


def met_by(interval: tuple[float, float], must: str, within: float = EXACT) -> bool:
    """Whether some value of an interval is what it must be.

    >>> met_by((-0.02, 0.03), "= 0"), met_by((-0.02, 0.03), "> 0"), met_by((-0.02, -0.01), ">= 0")
    (True, True, False)
    """
    sign, text = must.split()
    (low, high), limit = interval, float(text)
    if sign == "=":
        return low - within <= limit <= high + within
    slack = within if sign in ("<=", ">=") else 0.0
    return _TESTS[sign](high + slack if ">" in sign else low - slack, limit)


def _judged(row: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    inputs = Inputs(row.get("with", {}), table["disclosed"][row["paper"]], table["assumed"][row["paper"]])
    computed = Computation.of(row["by"], inputs)
    interval, limits = computed.interval, (row["must"], row.get("within", EXACT))
    return {
        "paper": row["paper"],
        "claim": row["claim"],
        "measure": row["measure"],
        "value": computed.value,
        "unit": row["unit"],
        "must": re.sub(r"^= ", "be ", row["must"]) if row["must"].startswith("=") else f"be {row['must']}",
        "holds": interval is not None and met_by(interval, *limits),
        "assumed_inputs": list(inputs.assumed),
    }
