"""Drawings of pick-ups with symbols."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planter.report.sheet import Sheet


def draw(source: str, changes: Mapping[str, float]) -> list[Sheet]:
    """Return the sheets of the pick-up in a file, or of the built-in one of that name."""
    from planter.papers.pickup.file import load_pickup
    from planter.papers.pickup.model import build_train
    from planter.papers.pickup.scene import draw_sheets

    machine = load_pickup(source, changes)
    return draw_sheets(machine, build_train(machine))
