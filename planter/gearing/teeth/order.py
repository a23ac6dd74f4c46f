"""What teeth are wanted on a pair of pitch curves, and how many whole ones of which module that makes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from planter.errors import InputError
from planter.gearing.teeth.pair import Pair
from planter.gearing.teeth.rack import Rack

Process = Literal["hob", "shaper", "wire"]
Keep = Literal["size", "module"]

LEAST_TEETH = 6
MOST_TEETH = 1000
"""Largest number of teeth on a gear: every flank is solved, which takes some ten milliseconds a tooth."""
MODULE = 2e-3
"""Module where nothing is said of module or teeth [m]."""
_WHOLE = 1e-9
_DRAWN = 1e-12
"""A pair that its teeth would change by this share is drawn for them, and is not scaled."""


@dataclass(frozen=True)
class Order:
    """Teeth of the gear, module [m], which of size and module to keep, the rack in modules, play [m], how it is cut.

    Without `keep` the size is kept where teeth are given and no module, else the module. `cutter_teeth` are those of
    the pinion that a shaper cuts hollow places with.
    """

    teeth: int | None = None
    module: float | None = None
    keep: Keep | None = None
    pressure_angle: float = np.pi / 9
    addendum: float = 1.0
    clearance: float = 0.25
    shift: float = 0.0
    play: float = 0.0
    tip_radius: float = 1.0
    process: Process = "hob"
    allow_undercut: bool = False
    cutter_teeth: int = 12

    def rack(self, module: float) -> Rack:
        """The gear's rack; its mate's is shifted the other way."""
        return Rack(module, self.pressure_angle, self.addendum, self.clearance, self.shift, self.play,
                    self.tip_radius)  # fmt: skip


@dataclass(frozen=True)
class Sized:
    """A pair with whole teeth: scaled from its drawn size by `scale`, with its module [m] and both numbers of teeth."""

    pair: Pair
    scale: float
    module: float
    teeth: tuple[int, int]


def sized(pair: Pair, order: Order, name: str) -> Sized:
    """Whole teeth for a pair. Raises InputError, naming the pair, for what cannot be."""
    module = order.module or (None if order.teeth else MODULE)
    length = pair.gear.length
    wanted = length / (np.pi * module) if module else float(order.teeth or 0)
    z = order.teeth or round(wanted)
    if order.teeth and module and abs(wanted - z) > 0.5:
        raise InputError(
            f"{name}: teeth = {z} and module = {module * 1e3:g} mm disagree: the pitch curve is {length * 1e3:.6g} mm "
            f"long, which makes {round(wanted)} teeth of that module"
        )
    keep = order.keep or ("module" if module else "size")
    own = module if module and keep == "module" else length / (np.pi * z)
    scale = np.pi * own * z / length if keep == "module" else 1.0
    scale = 1.0 if abs(scale - 1) <= _DRAWN else scale
    mate = pair.mate.length * z / length
    if abs(mate - round(mate)) > _WHOLE * mate:
        raise InputError(
            f"{name}: teeth = {z} is not allowed: the mate, whose pitch curve is {pair.mate.length / length:.6g} times "
            f"as long, would have {mate:.6g} teeth"
        )
    for count in (z, round(mate)):
        if not LEAST_TEETH <= count <= MOST_TEETH:
            raise InputError(
                f"{name}: {count} teeth are not allowed: there must be {LEAST_TEETH} to {MOST_TEETH} on a gear"
            )
    return Sized(pair.scaled(scale), float(scale), float(own), (z, round(mate)))
