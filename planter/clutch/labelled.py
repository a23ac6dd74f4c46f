"""Adapter of clutches for drawings with symbols (`planter.view.sheet`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planter.view.sheet import Labelled


UNDRAWN: Mapping[str, Sequence[str]] = {
    "of the engagement over time: planter clutch engage --mode contact shows it moving": (
        "derived: clutch in contact",
        "clutch file",
        "contact.",
        "dog.",
        "sleeve_mm",
    ),
    "of any Reuleaux polygon in any polygon: planter clutch rotor tells it": ("derived: rotor",),
    "of the arc rack on the row unit's link, which the file does not place": (
        "r_D",
        "gamma",
        "alpha_max",
        "lift",
        "link_deg",
        "theta_A",
        "theta_AR",
    ),
    "of the shaft's bending: planter clutch engage tells it": ("l", "r1", "y_max"),
    "too small to be seen at the scale of the drawing": (
        "e_3",
        "overlap_mm",
        "rho_C",
        "miss",
        "free",
    ),
    "a margin or a limit of a working clutch, not a part of it": (
        "c_min",
        *(
            f"margin_{name}"
            for name in ("fillet", "tips", "roots", "travel", "least_angle", "largest_angle")
        ),
    ),
    "a rate": ("lever",),
    "a rod that would do as well: planter clutch design tells both": ("l_BC_1", "l_BC_2"),
    "of the field test": ("field.", "levels."),
    "what a clutch is sized for, or may be given in a search": ("wanted.", "limits.", "search."),
    "of the teeth of crank gear and rack": ("linkage.",),
}
"""Reasons why names are on no sheet, with patterns of names, of sources, or of the file's tables as
`table.`.
"""


def draw_labelled(source: str, changes: Mapping[str, float]) -> Labelled:
    """The clutch in a file, or the built-in one of that name."""
    from planter.clutch.file import load_clutch
    from planter.clutch.report.drawings import draw_sheets
    from planter.view.sheet import Labelled

    clutch = load_clutch(source, changes)
    return Labelled(clutch.name, clutch.numbers(), draw_sheets(clutch))
