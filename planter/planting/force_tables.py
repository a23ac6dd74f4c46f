"""The support force of a result as a table, for the terminal and for pages: each column says what kind it is of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from planter.engine.tables import Shown

TITLE = "Vertical support force"
TRUE = "true"
KEYS = (
    "objective", "samples", "support_force", "refined", "sampled", "range_N", "variance_N2", "start_objective",
    "start_range_N", "start_variance_N2",
)  # fmt: skip
"""What of a result stands in the table."""
ROWS = {"max_N": ("largest", "N"), "min_N": ("least", "N"), "range_N": ("range", "N"), "mean_N": ("mean", "N"),
        "variance_N2": ("variance", "N2"), "objective": ("objective (31)", "")}  # fmt: skip

SCORES = ("objective", "range_N", "variance_N2")
"""What designs are compared by."""


def simulated(result: Mapping[str, Any]) -> Shown:
    """The force of a machine's own design: its true extremes and integrals beside those of the samples."""
    sampled = {**result["support_force"], "objective": result["objective"]}
    return _table({TRUE: result["refined"], _kind(result["samples"]): sampled})


def optimised(result: Mapping[str, Any]) -> Shown:
    """The force before and after, in the kind that was optimised, and the optimum's in the others."""
    searched, start = _kind(result["samples"]), {key: result[f"start_{key}"] for key in SCORES}
    columns = {f"start, {searched}": start, f"optimum, {searched}": {key: result[key] for key in SCORES}}
    others = {TRUE: result["refined"], _kind(result["sampled"]["samples"]): result["sampled"]}
    return _table(columns | {f"optimum, {kind}": found for kind, found in others.items() if kind != searched}, SCORES)


def _kind(samples: int | str) -> str:
    return TRUE if samples == "refined" else f"{samples} samples"


def _table(columns: Mapping[str, Mapping[str, float]], keys: tuple[str, ...] = tuple(ROWS)) -> Shown:
    rows = [(ROWS[key][0], *(found.get(key) for found in columns.values()), ROWS[key][1]) for key in keys]
    return Shown(TITLE, ("", *columns, "unit"), rows)
