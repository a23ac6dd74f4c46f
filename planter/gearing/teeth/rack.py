"""The basic rack of a gear's teeth (ISO 53), and the curves that it cuts on a pitch curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.kernels import Array, formulas

RACK = formulas.load("rack_teeth")


@dataclass(frozen=True)
class Cut:
    """What a rack cuts: points (2, n) [m], unit tangents (2, n), and what `rack_teeth` calls rate and turning (n,)."""

    points: Array
    tangents: Array
    rate: Array
    turning: Array

    @classmethod
    def of(cls, found: Mapping[str, Array]) -> Cut:
        px, py, ex, ey, rate, turning = found.values()
        return cls(np.array([px, py]), np.array([ex, ey]), rate, turning)


@dataclass(frozen=True)
class Rack:
    """Module [m], pressure angle [rad], heights and profile shift in modules, play of a pair [m].

    The round at the rack's tips is as large as lets its straight flanks end at the addendum, but not above `tip_radius`
    modules: a smaller one lets them reach deeper.
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
        """What of it a gear feels [m], by the names of the derivation."""
        heights = self.addendum, self.clearance, self.shift
        given = [self.module, *heights, self.pressure_angle, self.play, self.tip_radius]
        return RACK.at("sizes", rack=given)

    @property
    def pitch(self) -> float:
        return self.sizes["pitch_"]

    def mate(self) -> Rack:
        """The rack of the conjugate gear: shifted the other way."""
        return replace(self, shift=0.0 - self.shift)

    def without_play(self) -> Rack:
        return replace(self, play=0.0)

    def run(self, depth: float) -> float:
        """Length of the pitch curve over which a straight flank is cut from there down to a depth [m]."""
        return RACK.at("reach", kappa=0.0, height=depth, alpha=self.pressure_angle)["reach"]
