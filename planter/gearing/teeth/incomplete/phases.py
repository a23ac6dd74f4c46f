"""Phases of teeth relative to a dwell: the phase with the smallest angle over which no tooth drives.

The arcs remove driving flanks next to the dwell. A flank that crosses the pitch curve at x from the dwell can drive
while the pitch point is sigma from it if the point of contact remains on both gears: below both tips; on the driving
gear inside the convex arc's circle, or after the horns have passed; on the driven gear, in its position in the dwell,
outside of the concave arc's. Flanks are a pitch apart; the part of sigma that none covers is undriven.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.curve import KAPPA, PitchCurve
from planter.gearing.teeth.flanks import Flanks
from planter.gearing.teeth.incomplete.arcs import Horn, compute_horn
from planter.gearing.teeth.incomplete.rolling import Rolling
from planter.gearing.teeth.incomplete.trimming import TrimmingCircle
from planter.gearing.teeth.rack import RACK, Rack
from planter.kernels import Array
from planter.numerics.arrays import Flags

_PHASES = 96
"""Number of trial phases over a pitch."""
_PITCH_POINTS = 160
"""Positions of the pitch point that are tried at each end of the dwell."""
_FAR = 3
"""Range of these positions from the dwell, in pitches."""
_DRIVES = -1.0
"""Side of the driving gear's flanks that drive."""
_ROUNDING = 1e-9
"""Share of a pitch by which rounding may change a tooth count."""


@dataclass(frozen=True)
class ToothPhase:
    """Teeth of the driving gear, and the distance of the first tooth's centre from the start of the rolling [m].

    `undriven` are the angles of the driving gear [rad] after the dwell and before it over which no tooth drives;
    `best_undriven` are those of the best phase of either end only. `horns` are those of both ends.
    """

    teeth: int
    first: float
    undriven: tuple[float, float]
    best_undriven: tuple[float, float]
    horns: tuple[Horn, Horn]


def find_best_phase(rolling: Rolling, rack: Rack, radius: float, clearance: float) -> ToothPhase:
    """Return the phase with the smallest undriven angle in total, for arcs of a radius and a clearance [m].

    Driven gears have their first and last space next to their horns. Raises GeometryError if no tooth fits.
    """
    ends = [_DwellEnd.build(rolling, rack, radius, clearance, end) for end in (0, 1)]
    after, before = (end.undriven for end in ends)
    number = np.arange(_PHASES)
    opposite = (round(rolling.length / rack.pitch * _PHASES) - number) % _PHASES
    chosen = int(np.argmin(after + before[opposite]))
    centre = chosen / _PHASES * rack.pitch - _DRIVES * rack.sizes["full"]
    first = ends[0].margin + (centre - ends[0].margin) % rack.pitch
    teeth = int(np.floor((rolling.length - ends[1].margin - first) / rack.pitch + 1 + _ROUNDING))
    if teeth < 1:
        raise GeometryError("no tooth fits between the locking arcs: reduce the dwell or the module")
    return ToothPhase(
        teeth, float(first), (float(after[chosen]), float(before[opposite[chosen]])),
        (float(after.min()), float(before.min())), (ends[0].horn, ends[1].horn),
    )  # fmt: skip


@dataclass(frozen=True)
class _DwellEnd:
    """An end of the rolling, 0 at its start, with its horn, and the circles of the arcs and of the horn's tips."""

    rolling: Rolling
    rack: Rack
    end: int
    horn: Horn
    inside: TrimmingCircle
    gone_by: TrimmingCircle
    cut: TrimmingCircle

    @classmethod
    def build(cls, rolling: Rolling, rack: Rack, radius: float, clearance: float, end: int) -> _DwellEnd:
        sizes = rack.mate().sizes
        horn = compute_horn(rolling, end, radius + clearance, sizes["tip"], sizes["root"])
        return cls(
            rolling, rack, end, horn,
            TrimmingCircle(np.zeros(2), radius, "topping", inside=False),
            TrimmingCircle(rolling.driven_axis(end), horn.tips + clearance, "topping"),
            TrimmingCircle(rolling.driving_axis, radius + clearance, "concave arc"),
        )  # fmt: skip

    @property
    def margin(self) -> float:
        """Smallest distance of the driving gear's first tooth centre from the end [m] for a solid horn."""
        return self.horn.solid + self.rack.pitch / 2

    @property
    def undriven(self) -> Array:
        """Angles (_PHASES,) [rad] over which no flank drives, by the places of flanks in parts of a pitch.

        Raises GeometryError if the horn leaves no such flanks.
        """
        pitch, run = self.rack.pitch, self.rack.run(max(rack.sizes["tip"] for rack in (self.rack, self.rack.mate())))
        sigma, ahead = np.linspace(0, _FAR * pitch, _PITCH_POINTS), int(np.ceil(run / pitch))
        x = pitch * (np.arange(_PHASES * (2 * ahead + _FAR + 1)) / _PHASES - ahead)
        first = self.margin + self.rack.sizes["full"] * (_DRIVES if self.end == 0 else -_DRIVES)
        in_reach: Flags = np.logical_and(np.abs(x - sigma[:, None]) <= run, x >= first)
        if not in_reach.any():
            spare = (_FAR * pitch + run - first + self.horn.solid) / self.rack.module
            raise GeometryError(
                f"a horn of the locking arcs takes {self.horn.solid * 1e3:.4g} mm next to the dwell, where a module of "
                f"{self.rack.module * 1e3:g} mm has no teeth that drive: it must be about "
                f"{self.horn.solid / spare * 1e3:.2g} mm or more"
            )
        row, column = np.nonzero(in_reach)
        drives = np.zeros_like(in_reach)
        drives[row, column] = self._remain_on_gears(sigma[row], x[column])
        undriven: Flags = np.logical_not(drives.reshape(len(sigma), -1, _PHASES).any(axis=1))
        last = len(sigma) - 1 - np.argmax(undriven[::-1], axis=0)
        turned = self.rolling.places(self._measure_from_end(sigma))[0][0]
        return np.asarray(np.where(undriven.any(axis=0), np.abs(turned - turned[0])[last], 0.0))

    def _remain_on_gears(self, sigma: Array, x: Array) -> Flags:
        """Return whether points of contact (n,) remain on both gears."""
        rolling, side = self.rolling, np.full(len(x), _DRIVES)
        gear, mate = (Flanks(curve, self.rack, 1, 0.0) for curve in rolling.pair.curves)
        at, place = self._measure_from_end(sigma), self._measure_from_end(x)
        seen = rolling.behind + rolling.length - at
        gear_points = gear.line(rolling.lead + at, rolling.lead + place, side).points.T
        mate_points = mate.line(seen, rolling.behind + rolling.length - place, side).points.T
        below_tips = (at - place <= _compute_reach(gear.curve, rolling.lead + at, self.rack)) & (
            place - at <= _compute_reach(mate.curve, seen, self.rack.mate())
        )
        untopped = np.maximum(self.inside.beyond(gear_points), self.gone_by.beyond(gear_points)) >= 0
        remains: Flags = below_tips & untopped & (self.cut.beyond(mate_points) >= 0)
        return remains

    def _measure_from_end(self, distance: Array) -> Array:
        """Return rolling lengths (n,) [m] at distances (n,) [m] from the end."""
        return distance if self.end == 0 else self.rolling.length - distance


def _compute_reach(curve: PitchCurve, s: Array, rack: Rack) -> Array:
    """Return lengths (n,) [m] of a pitch curve on which teeth that touch at arc lengths (n,) are cut up to their "
    "tips."""
    kappa = np.maximum(curve.at(s)[KAPPA], 0.0)
    return RACK("reach", kappa=kappa, height=rack.sizes["tip"], alpha=rack.pressure_angle)["reach"]
