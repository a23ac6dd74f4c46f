"""The planting device over a cycle: samples, extremes, integrals, warnings. One text for both models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from planter.engine.response import DesignPoint
from planter.files import units
from planter.kernels import Array
from planter.numerics.extrema import index_first_extremum
from planter.planting import quantities
from planter.planting.model import Device
from planter.planting.results.stated import Statistics, Warned

Columns = dict[str, Array]


@dataclass(frozen=True)
class Cycle:
    """Quantities at carrier angles `phi` [rad], each (n,), under the keys they are shown with, in shown units.

    `sides` are those of side 1 and of side 2, half a turn behind; `totals` those of what both share.
    """

    phi: Array
    sides: tuple[Columns, Columns]
    totals: Columns

    @property
    def support(self) -> Array:
        """Vertical support force [N], (n,)."""
        return self.totals["support_N"]

    def columns(self) -> Columns:
        """Everything as one table: the angle, side 1, side 2 with `_2` in the names, totals."""
        second = {quantities.second(key): values for key, values in self.sides[1].items()}
        return {"phi_deg": np.degrees(self.phi), **self.sides[0], **second, **self.totals}


def cycle(device: Device, at: DesignPoint, phi: Array) -> Cycle:
    """All forces and motions at carrier angles (n,) [rad]."""
    found = device.cycle(at, phi)
    vectors = device.sidecar["vectors"]
    one, two = (_shown(vectors["side"], found[name]) for name in ("side1", "side2"))
    return Cycle(np.asarray(phi, dtype=float), (one, two), _shown(vectors["totals"], found["totals"]))


def _shown(entries: Sequence[Mapping[str, str]], rows: Array) -> Columns:
    return {key: row / units.factor(key) for key, row in zip(quantities.keys(entries), rows, strict=True)}


def angles(samples: int) -> Array:
    """Carrier angles of a cycle's samples [rad]: 2 pi i / N."""
    return 2 * np.pi * np.arange(samples) / samples


def over_samples(name: str, samples: int) -> str:
    """Return the name of a number that is that of so many samples of a cycle, not the true one."""
    return f"{name}, {samples} samples"


def statistics(force: Array) -> Statistics:
    """Extremes, range, mean and population variance of samples (n,) of a force [N]."""
    high, low = float(force.max()), float(force.min())
    return Statistics(high, low, high - low, float(force.mean()), float(force.var()))


def centre_distances(device: Device, at: DesignPoint) -> Array:
    """Centre distances of both stages [m], (2,)."""
    return at.h[distance_places(device)]


def distance_places(device: Device) -> list[int]:
    """Where the centre distances of both stages stand in what a prologue finds."""
    return [0, 1 + device.stages[0].terms]


def weight(device: Device) -> float:
    """Weight of everything that the frame carries [N]."""
    return device.formulas.at("weight", machine=device.constants)["weight"]


ONE_SIDED = {
    "F_E_N": ("roller_contact", "the cam would have to pull the roller"),
    "F_NP_N": ("tooth_contact_P", "the teeth of sun and gear 5 would have to pull"),
    "F_NQ_N": ("tooth_contact_Q", "the teeth of gear 6 and planet would have to pull"),
}
"""Contacts that can only push, by the key of their force."""


def warnings(device: Device, x: Array, turn: Cycle) -> list[Warned]:
    """Lost contacts over the cycle and values outside the machine's bounds."""
    found = [_lost(turn, key, name, text) for key, (name, text) in ONE_SIDED.items() if turn.sides[0][key].min() < 0]
    low, high = device.lower / device.scale, device.upper / device.scale
    for name, value, a, b in zip(device.names, x / device.scale, low, high, strict=True):
        if not a <= value <= b:
            found.append(
                Warned(
                    name="design_out_of_bounds", phi_deg=0.0,
                    message=f"{name} = {value:.6g} lies outside its bounds [{a:g}, {b:g}]",
                )
            )  # fmt: skip
    return found


def _lost(turn: Cycle, key: str, name: str, text: str) -> Warned:
    force = turn.sides[0][key]
    pulled = force < 0
    worst = index_first_extremum(turn.phi, force, -1)
    share = 100 * pulled.mean()
    message = (
        f"{text}: by up to {-force[worst]:.3g} N on side 1, over {share:.0f} % of the turn; side 2 half a turn later"
    )
    return Warned(name=name, phi_deg=float(np.degrees(turn.phi[worst])), message=message)
