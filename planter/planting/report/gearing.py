"""Where the pitch curves of a planting device are: both gear pairs of side 1 at a carrier angle.

A point of a gear is named by t, the polar angle of the inner gear's curve (sun, gear 6) at the contact when it is
there. The inner gear's point lies at r(t) from its centre, its partner's at a - r(t) from the other one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from planter.gearing.stage import Stage
    from planter.kernels import Array
    from planter.planting.model import Device

SAMPLES = 360


@dataclass(frozen=True)
class PitchCurve:
    """A closed pitch curve: its centre (2,) and its points (2, n), the last one the first again [mm]."""

    name: str
    centre: Array
    points: Array


@dataclass(frozen=True)
class Gearing:
    """Four pitch curves (sun, gear 5, gear 6, planet), centres O, A1, B1 and contacts P, Q, each (2,) [mm]."""

    phi_deg: float
    curves: tuple[PitchCurve, ...]
    centres: dict[str, Array]
    contacts: dict[str, Array]


@dataclass(frozen=True)
class _Placed:
    """A stage on the carrier: the inner gear's centre, where its partner is seen from it, and the contact's t.

    `sense` is +1 where t grows counter-clockwise in the inner gear, -1 where it grows clockwise.
    """

    stage: Stage
    parameters: Array
    centre: Array
    towards: float
    t: float
    sense: int

    def contact(self, t: Array) -> dict[str, Array]:
        hoisted = self.stage.prologue(parameters=self.parameters)["hoisted"]
        found = self.stage.contact(t=t, parameters=self.parameters, hoisted=hoisted)
        return {name: row[0] for name, row in found.items()} | {"a": hoisted[0, 0]}

    @property
    def turned(self) -> float:
        """Rotation of the partner since t = 0, relative to the carrier [rad]."""
        return float(self.contact(np.array([self.t]))["turned"][0])

    @property
    def other_centre(self) -> Array:
        distance = self.contact(np.array([self.t]))["a"]
        return self.centre + distance * _direction(self.towards)

    @property
    def pitch_point(self) -> Array:
        radius = self.contact(np.array([self.t]))["r"][0]
        return self.centre + radius * _direction(self.towards)

    def curves(self, t: Array) -> tuple[Array, Array]:
        """Points (2, n) of the inner gear and of its partner that meet at t."""
        at = self.contact(t)
        inner = self.towards + self.sense * (t - self.t)
        outer = self.towards + np.pi - self.sense * (at["turned"] - self.turned)
        return (
            self.centre[:, None] + at["r"] * _direction(inner),
            self.other_centre[:, None] + (at["a"] - at["r"]) * _direction(outer),
        )


def _direction(angle: Array | float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def _placed(device: Device, x: Array, phi: float) -> tuple[_Placed, _Placed]:
    """Both stages of side 1: the sun is fixed to the frame; gear 6 turns with gear 5 about A1."""
    names = [entry["name"] for entry in device.sidecar["vectors"]["mounting"]]
    mounting = dict(zip(names, x, strict=False))
    first, second = device.stages
    split = len(names) + len(first.names)
    upwards = phi + np.pi / 2
    one = _Placed(first, x[len(names) : split], np.zeros(2), upwards, phi + mounting["alpha3"], +1)
    at_zero = one.contact(np.array([mounting["alpha3"]]))["turned"][0]
    t = mounting["beta6"] + one.turned - at_zero
    return one, _Placed(second, x[split:], one.other_centre, upwards + mounting["gamma"], t, -1)


def gearing(device: Device, x: Array, phi_deg: float = 0.0, samples: int = SAMPLES) -> Gearing:
    """The pitch curves of side 1 at a carrier angle, for a design x (p,) in SI.

    The first point of each curve is the one in contact.
    """
    names = (("sun", "gear 5"), ("gear 6", "planet gear"))
    curves: list[PitchCurve] = []
    placed = _placed(device, x, np.radians(phi_deg))
    for pair, stage in zip(names, placed, strict=True):
        points = stage.curves(stage.t + 2 * np.pi * np.arange(samples + 1) / samples)
        for name, centre, found in zip(pair, (stage.centre, stage.other_centre), points, strict=True):
            curves.append(PitchCurve(name, 1e3 * centre, 1e3 * found))
    one, two = placed
    centres = {"O": 1e3 * one.centre, "A1": 1e3 * two.centre, "B1": 1e3 * two.other_centre}
    contacts = {"P": 1e3 * one.pitch_point, "Q": 1e3 * two.pitch_point}
    return Gearing(phi_deg, tuple(curves), centres, contacts)


def ratios(device: Device, x: Array, phi_deg: Array) -> tuple[Array, Array]:
    """Ratios of both stages at carrier angles (n,): dphi52/dphi and -dphi72/dphi52, each (n,) [-]."""
    phi = np.radians(phi_deg)
    one, two = _placed(device, x, 0.0)
    first = one.contact(one.t + phi)
    second = two.contact(two.t + first["turned"] - one.turned)
    return first["ratio"], second["ratio"]
