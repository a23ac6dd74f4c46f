"""Console tables of the pick-up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planter.files import units
from planter.terminal.console import Console

if TYPE_CHECKING:
    from planter.pickup.results import Demand, Optimised, PickupFound, PickupState

GROUPS = ("dwell", "slope", "sun_radius_mm", "teeth", "locking_arcs", "push")
"""Groups of values, beside the single ones."""


def print_pickup(console: Console, result: PickupFound) -> None:
    """Mechanism, requirements, single angles."""
    print(f"{result.machine}, driven by its {result.driven_by}\n")
    table = result.table()
    single = {key: value for key, value in table.items() if isinstance(value, int | float)}
    for group in GROUPS:
        parts = (table[group] or {}).items()
        single |= {f"{group}: {key}": value for key, value in parts if isinstance(value, int | float)}
    rows = ((key, str(v) if isinstance(v, bool) else v, units.unit(key)) for key, v in single.items())
    console.table("Mechanism", ("", "value", "unit"), rows)
    print_requirements(console, "Requirements", result.requirements)
    if result.at:
        _at(console, result.at)
    if result.optimised:
        _optimised(console, result.optimised)


def print_requirements(console: Console, title: str, print_requirements: Sequence[Demand]) -> None:
    """Requirements with their margins."""
    rows = ((r.name, r.value, r.wanted, r.unit, r.margin, "" if r.holds else "not met") for r in print_requirements)
    console.table(title, ("", "value", "wanted", "unit", "margin", ""), rows)


def _at(console: Console, states: Sequence[PickupState]) -> None:
    flat = [{**row.table(), "tip_x_mm": row.tip_mm[0], "tip_y_mm": row.tip_mm[1]} for row in states]
    keys = [key for key in flat[0] if key not in ("t_deg", "tip_mm")]
    header = ("quantity", *(f"at {row['t_deg']:g} deg" for row in flat), "unit")
    console.table("At single angles", header, ((k, *(row[k] for row in flat), units.unit(k)) for k in keys))


def _optimised(console: Console, optimised: Optimised) -> None:
    print_requirements(console, "Before the value points were moved", optimised.requirements_before)
    print(
        f"Value points were moved by up to {optimised.moved_mm:.4g} mm in {optimised.iterations} iterations; "
        f"{'all requirements hold' if optimised.holds else 'not all requirements can be held'}."
    )
