"""Orders of teeth on a pair of pitch curves, and the integer tooth counts and module that follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from planter.errors import InputError
from planter.gearing.teeth.pair import CurvePair
from planter.gearing.teeth.rack import Rack

Process = Literal["hob", "shaper", "wire"]
Keep = Literal["size", "module"]

MIN_TEETH = 6
MAX_TEETH = 1000
"""Largest number of teeth on a gear: every flank is solved, which takes some ten milliseconds per tooth."""
DEFAULT_MODULE = 2e-3
"""Module without an order of module or teeth [m]."""
_INTEGER_TOLERANCE = 1e-9
_SCALE_TOLERANCE = 1e-12
"""Relative change of size below which a pair is not scaled."""


@dataclass(frozen=True)
class ToothOrder:
    """Tooth count of the gear, module [m], which of size and module to keep, rack in modules, backlash [m], process.

    The default of `keep` is the size if teeth are given without a module, else the module. `cutter_teeth` is the tooth
    count of the pinion cutter with which a shaper cuts concave curves.
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
        """Return the gear's rack; its mate's has the opposite profile shift."""
        return Rack(module, self.pressure_angle, self.addendum, self.clearance, self.shift, self.play,
                    self.tip_radius)  # fmt: skip


@dataclass(frozen=True)
class SizedPair:
    """A pair with integer tooth counts: scaled from its designed size by `scale`, with its module [m]."""

    pair: CurvePair
    scale: float
    module: float
    teeth: tuple[int, int]


def size_pair(pair: CurvePair, order: ToothOrder, name: str) -> SizedPair:
    """Return the pair with integer tooth counts. Raises InputError, naming the pair, for an impossible order."""
    module = order.module or (None if order.teeth else DEFAULT_MODULE)
    length = pair.gear.length
    exact_count = length / (np.pi * module) if module else float(order.teeth or 0)
    z = order.teeth or round(exact_count)
    if order.teeth and module and abs(exact_count - z) > 0.5:
        raise InputError(
            f"{name}: teeth = {z} and module = {module * 1e3:g} mm disagree: the pitch curve is {length * 1e3:.6g} mm "
            f"long, which makes {round(exact_count)} teeth of that module"
        )
    keep = order.keep or ("module" if module else "size")
    fitted_module = module if module and keep == "module" else length / (np.pi * z)
    scale = np.pi * fitted_module * z / length if keep == "module" else 1.0
    scale = 1.0 if abs(scale - 1) <= _SCALE_TOLERANCE else scale
    mate = pair.mate.length * z / length
    if abs(mate - round(mate)) > _INTEGER_TOLERANCE * mate:
        raise InputError(
            f"{name}: teeth = {z} is not allowed: the mate, whose pitch curve is {pair.mate.length / length:.6g} times "
            f"as long, would have {mate:.6g} teeth"
        )
    for count in (z, round(mate)):
        if not MIN_TEETH <= count <= MAX_TEETH:
            raise InputError(
                f"{name}: {count} teeth are not allowed: there must be {MIN_TEETH} to {MAX_TEETH} on a gear"
            )
    return SizedPair(pair.scaled(scale), float(scale), float(fitted_module), (z, round(mate)))
