"""Figure of what friction of the teeth does over a turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

from planter.files import units
from planter.gears.rubbing import Rubbing
from planter.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 2
_HEIGHT = 1.6
"""Of a row of axes [inch]."""
_SHADES = {"convention": style.VERMILION, "sliding": style.BLUE}


@style.drawn
def friction(found: Rubbing) -> Figure:
    """By how much friction changes each quantity, that of the convention and that against the sliding."""
    count = -(-len(found.curves) // _COLUMNS)
    figure = style.new_figure(_HEIGHT * count)
    every = list(figure.subplots(count, _COLUMNS, squeeze=False).flat)
    for spare in every[len(found.curves) :]:
        spare.set_visible(False)
    for axes, (key, kinds) in zip(every, found.curves.items(), strict=False):
        for kind, shade in _SHADES.items():
            axes.plot(found.phi_deg, kinds[kind] - kinds["without"], color=shade, label=kind, linewidth=0.8)
        unit = units.suffix(key)
        axes.set_title(f"{key.removesuffix(unit)} / {units.unit(key)}")
        style.over_a_turn(axes, label=False)
    figure.legend(*every[0].get_legend_handles_labels(), loc="outside upper right", frameon=False, ncols=2)
    figure.supxlabel("carrier angle φ / deg", fontsize=8.5)
    figure.supylabel("change by friction of the teeth", fontsize=8.5)
    return figure
