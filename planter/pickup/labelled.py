"""The drawings of pick-ups with their symbols (`planter.view.sheet`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planter.view.sheet import Labelled


UNDRAWN: Mapping[str, Sequence[str]] = {
    "of the standard helical pair, which is seen from the side here": (
        "m_n",
        "B",
        "alpha_n",
        "beta",
        "alpha_t",
    ),
    "a carrier angle or an arm's angle at another moment than the one that is drawn": (
        "dwell_start",
        "dwell_end",
        "phi1_far",
        "phi5_far_deg",
        "dwell_t_deg",
        "transition_deg",
    ),
    "a derivative or a rate": ("dR1", "ddR1", "arc"),
    "any place in the machine's frame": ("x", "y"),
    "nothing where the arm only goes forward": ("arm_turned_back_deg",),
    "of the teeth: planter gears draws them": ("noncircular_stage.",),
    "what the path is asked for, not a part of the machine": ("targets.", "path."),
    "zero where the needle lies along the arm, as it is drawn": ("mounting_deg",),
    "of the box before the cells, whose axis the needle's direction gives here": (
        "box_inclination_deg",
    ),
}
"""Reasons why names are on no sheet, with patterns of names, of sources, or of the file's tables as
`table.`.
"""


def draw_labelled(source: str, changes: Mapping[str, float]) -> Labelled:
    """The pick-up in a file, or the built-in one of that name."""
    from planter.pickup.file import load_pickup
    from planter.pickup.model import build_train
    from planter.pickup.scene import draw_sheets
    from planter.view.sheet import Labelled

    machine = load_pickup(source, changes)
    return Labelled(machine.name, machine.numbers(), draw_sheets(machine, build_train(machine)))
