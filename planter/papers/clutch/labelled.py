"""Drawings of clutches with symbols."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planter.report.sheet import Sheet


def draw(source: str, changes: Mapping[str, float]) -> list[Sheet]:
    """Return the sheets of the clutch in a file, or of the built-in one of that name."""
    from planter.papers.clutch.file import load_clutch
    from planter.papers.clutch.scene import draw_sheets

    return draw_sheets(load_clutch(source, changes))
