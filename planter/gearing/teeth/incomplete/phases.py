"""Where teeth stand beside a dwell: the phase that leaves the least angle over which none of them drives.

Arcs take away what the teeth would drive with beside the dwell. A flank whose place on the pitch curve is x from the
dwell can drive while the pitch point is sigma from it if the point of contact is left on both gears: below both tips;
on the driving gear inside the convex arc's circle, or where the horns have gone by; on the driven gear, as it stands in
the dwell, outside of the concave arc's. Flanks stand a pitch apart: what of sigma none covers is undriven.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.curve import KAPPA, PitchCurve
from planter.gearing.teeth.flanks import Flanks
from planter.gearing.teeth.incomplete.arcs import Horn, horn_of
from planter.gearing.teeth.incomplete.rolling import Rolling
from planter.gearing.teeth.incomplete.trimming import Circle
from planter.gearing.teeth.rack import RACK, Rack
from planter.kernels import Array
from planter.numerics.arrays import Flags

_PHASES = 96
"""Phases that are tried over a pitch."""
_PLACES = 160
"""Places of the pitch point that are tried beside each end of the dwell."""
_FAR = 3
"""How far from the dwell these go, in pitches."""
_DRIVES = -1.0
"""Side of the driving gear's flanks that drive."""
_ROUNDING = 1e-9
"""Part of a pitch by which rounding may take a tooth from where it is whole."""


@dataclass(frozen=True)
class Phase:
    """Teeth of the driving gear, and the place of the first one's centre from where the rolling begins [m].

    `undriven` are the angles of the driving gear [rad] after the dwell and before it over which they leave no tooth
    that drives; `least` are those that the best phase of either end by itself would leave. `horns` are those beside.
    """

    teeth: int
    first: float
    undriven: tuple[float, float]
    least: tuple[float, float]
    horns: tuple[Horn, Horn]


def best(rolling: Rolling, rack: Rack, radius: float, apart: float) -> Phase:
    """The phase that leaves the least angle undriven in all, with arcs of a radius, so far apart [m].

    Driven gears have their first and last space beside their horns. Raises GeometryError where no tooth has room.
    """
    ends = [_Beside.of(rolling, rack, radius, apart, end) for end in (0, 1)]
    after, before = (end.undriven for end in ends)
    number = np.arange(_PHASES)
    opposite = (round(rolling.length / rack.pitch * _PHASES) - number) % _PHASES
    chosen = int(np.argmin(after + before[opposite]))
    centre = chosen / _PHASES * rack.pitch - _DRIVES * rack.sizes["full"]
    first = ends[0].room + (centre - ends[0].room) % rack.pitch
    teeth = int(np.floor((rolling.length - ends[1].room - first) / rack.pitch + 1 + _ROUNDING))
    if teeth < 1:
        raise GeometryError("the locking arcs leave no room for a tooth: the dwell or the module must be less")
    return Phase(
        teeth, float(first), (float(after[chosen]), float(before[opposite[chosen]])),
        (float(after.min()), float(before.min())), (ends[0].horn, ends[1].horn),
    )  # fmt: skip


@dataclass(frozen=True)
class _Beside:
    """An end of the rolling, 0 where it begins, beside its horn; circles of the arcs and of the horn's tips."""

    rolling: Rolling
    rack: Rack
    end: int
    horn: Horn
    inside: Circle
    gone_by: Circle
    cut: Circle

    @classmethod
    def of(cls, rolling: Rolling, rack: Rack, radius: float, apart: float, end: int) -> _Beside:
        sizes = rack.mate().sizes
        horn = horn_of(rolling, end, radius + apart, sizes["tip"], sizes["root"])
        return cls(
            rolling, rack, end, horn,
            Circle(np.zeros(2), radius, "topping", inside=False),
            Circle(rolling.driven_axis(end), horn.tips + apart, "topping"),
            Circle(rolling.driving_axis, radius + apart, "concave arc"),
        )  # fmt: skip

    @property
    def room(self) -> float:
        """How far from the end the centre of the driving gear's first tooth must be [m], so that the horn is solid."""
        return self.horn.solid + self.rack.pitch / 2

    @property
    def undriven(self) -> Array:
        """Angles (_PHASES,) [rad] over which no flank drives, by the places of flanks in parts of a pitch.

        Raises GeometryError where the horn leaves no place for such flanks.
        """
        pitch, run = self.rack.pitch, self.rack.run(max(one.sizes["tip"] for one in (self.rack, self.rack.mate())))
        sigma, ahead = np.linspace(0, _FAR * pitch, _PLACES), int(np.ceil(run / pitch))
        x = pitch * (np.arange(_PHASES * (2 * ahead + _FAR + 1)) / _PHASES - ahead)
        first = self.room + self.rack.sizes["full"] * (_DRIVES if self.end == 0 else -_DRIVES)
        near: Flags = np.logical_and(np.abs(x - sigma[:, None]) <= run, x >= first)
        if not near.any():
            spare = (_FAR * pitch + run - first + self.horn.solid) / self.rack.module
            raise GeometryError(
                f"a horn of the locking arcs takes {self.horn.solid * 1e3:.4g} mm beside the dwell, where a module of "
                f"{self.rack.module * 1e3:g} mm has no teeth that drive: it must be about "
                f"{self.horn.solid / spare * 1e3:.2g} mm or more"
            )
        row, column = np.nonzero(near)
        can = np.zeros_like(near)
        can[row, column] = self._left(sigma[row], x[column])
        lost: Flags = np.logical_not(can.reshape(len(sigma), -1, _PHASES).any(axis=1))
        last = len(sigma) - 1 - np.argmax(lost[::-1], axis=0)
        turned = self.rolling.places(self._from(sigma))[0][0]
        return np.asarray(np.where(lost.any(axis=0), np.abs(turned - turned[0])[last], 0.0))

    def _left(self, sigma: Array, x: Array) -> Flags:
        """Whether points of contact (n,) are left on both gears."""
        rolling, side = self.rolling, np.full(len(x), _DRIVES)
        gear, mate = (Flanks(curve, self.rack, 1, 0.0) for curve in rolling.pair.curves)
        at, place = self._from(sigma), self._from(x)
        seen = rolling.behind + rolling.length - at
        own = gear.line(rolling.lead + at, rolling.lead + place, side).points.T
        other = mate.line(seen, rolling.behind + rolling.length - place, side).points.T
        below_tips = (at - place <= _reach(gear.curve, rolling.lead + at, self.rack)) & (
            place - at <= _reach(mate.curve, seen, self.rack.mate())
        )
        untopped = np.maximum(self.inside.beyond(own), self.gone_by.beyond(own)) >= 0
        found: Flags = below_tips & untopped & (self.cut.beyond(other) >= 0)
        return found

    def _from(self, distance: Array) -> Array:
        """Rolling lengths (n,) at distances from the end."""
        return distance if self.end == 0 else self.rolling.length - distance


def _reach(curve: PitchCurve, s: Array, rack: Rack) -> Array:
    """Lengths (n,) of a pitch curve over which teeth that touch at arc lengths (n,) are cut up to their tips."""
    kappa = np.maximum(curve.at(s)[KAPPA], 0.0)
    return RACK("reach", kappa=kappa, height=rack.sizes["tip"], alpha=rack.pressure_angle)["reach"]
