"""Whole teeth as tables that a person likes to read."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from planter.terminal.console import Console

if TYPE_CHECKING:
    from planter.planting.whole.results import WholeTeeth

WIDTH = 80


def show(console: Console, found: WholeTeeth) -> None:
    """Whole teeth and their price, their limits, and what was tried."""
    rows = [
        (one.stage, one.z, one.module_mm, one.pitch_length_mm, one.free_teeth, one.price_per_module_mm,
         one.price_per_tooth)
        for one in found.stages
    ]  # fmt: skip
    head = ("stage", "teeth", "module / mm", "length / mm", "free", "per mm of module", "per tooth")
    console.table("Whole teeth", head, rows)
    print(f"Objective {found.price:+.4g} against the free optimum's {found.free_objective:.6g}.\n")
    gears = [
        (gear.name, gear.teeth, gear.margin, gear.top_land_mm, one.contact_ratio_min)
        for one in found.stages
        for gear in one.gears or ()
    ]
    if gears:
        console.table("Gears", ("gear", "teeth", "undercut margin", "top land / mm", "contact ratio"), gears)
    for one in found.stages:
        if one.refused is not None:
            print(textwrap.fill(f"planter gears refuses: {one.refused}.", WIDTH) + "\n")
    if found.tried is not None:
        tried = [(",".join(map(str, one.z)), one.objective, one.kkt_residual, one.settled) for one in found.tried]
        console.table("Teeth that were tried", ("teeth", "objective", "KKT residual", "settled"), tried)
