"""Basic racks of gear teeth (ISO 53), and the curves that they cut on a pitch curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.kernels import Array, formulas

RACK = formulas.load("rack_teeth")


@dataclass(frozen=True)
class Cut:
    """Curve cut by a rack: points (2, n) [m], unit tangents (2, n), rate and turning (n,) of `rack_teeth`."""

    points: Array
    tangents: Array
    rate: Array
    turning: Array

    @classmethod
    def from_columns(cls, columns: Mapping[str, Array]) -> Cut:
        px, py, ex, ey, rate, turning = columns.values()
        return cls(np.array([px, py]), np.array([ex, ey]), rate, turning)


@dataclass(frozen=True)
class Rack:
    """Module [m], pressure angle [rad], heights and profile shift in modules, backlash of a pair [m].

    The tip radius is the largest with which the straight flanks end at the addendum, but at most `tip_radius` modules;
    a smaller one lets them reach deeper.
    """

    module: float
    pressure_angle: float = np.pi / 9
    addendum: float = 1.0
    clearance: float = 0.25
    shift: float = 0.0
    play: float = 0.0
    tip_radius: float = 1.0

    @cached_property
    def sizes(self) -> dict[str, float]:
        """Sizes of the rack [m] by the names of the derivation."""
        heights = self.addendum, self.clearance, self.shift
        parameters = [self.module, *heights, self.pressure_angle, self.play, self.tip_radius]
        return RACK.at("sizes", rack=parameters)

    @property
    def pitch(self) -> float:
        return self.sizes["pitch_"]

    def mate(self) -> Rack:
        """Return the rack of the conjugate gear, with the opposite profile shift."""
        return replace(self, shift=0.0 - self.shift)

    def without_play(self) -> Rack:
        return replace(self, play=0.0)

    def run(self, depth: float) -> float:
        """Return the length of the pitch curve [m] on which a straight flank is cut down to a depth [m]."""
        return RACK.at("reach", kappa=0.0, height=depth, alpha=self.pressure_angle)["reach"]


TEETH = formulas.load("gear_teeth")
"""Functions of teeth at the curvatures of two pitch curves; `teeth`: module, addenda in modules, pressure angle."""
