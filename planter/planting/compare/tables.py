"""The comparison as tables that a person likes to read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from planter.terminal.console import Console


def comparison(console: Console, result: Mapping[str, Any]) -> None:
    """Devices by rank, the narrow box, and what conflicts."""
    rows = [_row(rank, entry) for rank, entry in enumerate(result["devices"], 1)]
    narrow = result["narrow"]
    if narrow is not None:
        rows.append(_row("narrow", {**narrow, "stage1": "paper's", "stage2": "narrow box"}))
    header = ("rank", "sun", "gear 6", "objective (31)", "range / N", "variance / N2", "KKT", "requirements")
    console.table(f"{result['machine']}: pairs of gear families, true extremes and integrals", header, rows)
    found = result["proposal"]
    if found is not None:
        told = ", ".join(found["conflicting"]) or "no single one"
        limits = ", ".join(f"{key} = {value:.6g}" for key, value in found["limits"].items())
        print(f"No pair keeps all requirements; every pair breaks: {told}.")
        print(f"{found['stage1']} with {found['stage2']} keeps them with {limits}.")
    print(f"{result['seconds']:.3g} s")


def _residual(entry: Mapping[str, Any]) -> str:
    residual = entry.get("kkt_residual")
    return "-" if residual is None else f"{residual:.0e}"


def _row(rank: int | str, entry: Mapping[str, Any]) -> tuple[Any, ...]:
    word = "held by " if entry["feasible"] else "breaks "
    names = ", ".join(entry["binding"])
    amounts = [f"{one['name']} by {one['amount']:.3g} {one['unit']}" for one in entry.get("violations", [])]
    told = word + (", ".join(amounts) or names) if names else "all kept"
    keys = ("objective", "range_N", "variance_N2")
    return (str(rank), entry["stage1"], entry["stage2"], *(entry[key] for key in keys), _residual(entry), told)
