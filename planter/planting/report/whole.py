"""Whole teeth of an optimum on its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from planter.report.html import Block, Table, Text

STAGES = ("stage", "teeth", "module / mm", "length / mm", "free optimum's teeth", "per mm of module", "per tooth")
GEARS = ("gear", "teeth", "margin against undercut", "top land / mm", "least contact ratio")


def whole_teeth(teeth: Mapping[str, Any]) -> Iterator[Block]:
    """Lengths and prices, limits of the gears, and what was tried."""
    keys = ("stage", "z", "module_mm", "pitch_length_mm", "free_teeth", "price_per_module_mm", "price_per_tooth")
    yield Text(f"Objective {teeth['price']:+.4g} against the free optimum's {teeth['free_objective']:.6g}.")
    yield Table(STAGES, [tuple(one[key] for key in keys) for one in teeth["stages"]])
    gears = [
        (gear["name"], gear["teeth"], gear["margin"], gear["top_land_mm"], one["contact_ratio_min"])
        for one in teeth["stages"]
        for gear in one["gears"] or ()
    ]
    if gears:
        yield Table(GEARS, gears)
    for one in teeth["stages"]:
        if one["refused"] is not None:
            yield Text(f"planter gears refuses: {one['refused']}.", "warning")
    if teeth["tried"] is not None:
        tried = [(", ".join(map(str, one["z"])), one["objective"], one["settled"]) for one in teeth["tried"]]
        yield Table(("teeth tried", "objective", "settled"), tried)
