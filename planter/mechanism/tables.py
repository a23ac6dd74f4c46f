"""A turn of a mechanism as tables on the screen."""

from __future__ import annotations

from planter.files import units
from planter.mechanism.motion import Motion
from planter.mechanism.turn import Quantity, Turn
from planter.report.labels import name
from planter.terminal.console import Console

HEAD = ("quantity", "min", "at", "max", "at", "mean", "rms", "unit")
ROUNDING = 1e-12
"""Means below this share of the root mean square are shown as zero."""


def _mean(quantity: Quantity) -> float:
    return quantity.mean if abs(quantity.mean) > ROUNDING * quantity.rms else 0.0


def show(console: Console, found: Turn) -> None:
    """Quantities, works and laws."""
    rows = [
        (name(key), q.min, f"{q.min_deg:g}", q.max, f"{q.max_deg:g}", _mean(q), q.rms, q.unit)
        for key, q in found.quantities.items()
    ]
    console.table(f"{found.machine}: a turn in {len(found.angles_deg)} samples", HEAD, rows)
    if found.work:
        console.table("Work of a turn", ("by", "J"), [(key.removesuffix("_J"), v) for key, v in found.work.items()])
    laws = [(law.law, law.violation, law.unit) for law in found.laws]
    console.table("Laws, and the largest violation", ("law", "violation", "unit"), laws)


def show_motion(console: Console, found: Motion) -> None:
    """Quantities, energy, constraints, and the state of rest if it was asked for."""
    rows = [(name(key), v.min(), v.max(), v[-1], units.unit(key)) for key, v in found.columns.items()]
    console.table(
        f"{found.machine}: motion until {found.times[-1]:g} s", ("quantity", "min", "max", "last", "unit"), rows
    )
    energy = [(name(key), value) for key, value in found.energy_J.items()]
    console.table("Energy of weights, springs and motion", ("", "J"), energy)
    if found.redundant:
        console.say(f"{found.redundant} constraints follow from the others; multipliers are those of least squares")
    if found.equilibrium is not None and found.eigenvalues is not None:
        console.table("State of rest", ("coordinate", "value", "unit"),
                      [(name(key), value, units.unit(key)) for key, value in found.equilibrium.items()])  # fmt: skip
        console.table("Eigenvalues there", ("real / 1/s", "imaginary / 1/s"), found.eigenvalues)
