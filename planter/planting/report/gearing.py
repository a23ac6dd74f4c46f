"""Where the pitch curves of a planting device are: both gear pairs of side 1 at a carrier angle.

A point of a gear is named by t, the polar angle of the inner gear's curve (sun, gear 6) at the contact when it is
there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planter.planting import cycle

if TYPE_CHECKING:
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


def gearing(device: Device, x: Array, phi_deg: float = 0.0, samples: int = SAMPLES) -> Gearing:
    """The pitch curves of side 1 at a carrier angle, for a design x (p,) in SI.

    The first point of each curve is the one in contact.
    """
    phi = float(np.radians(phi_deg))
    side = {name: float(row[0]) for name, row in device.side(x, np.array([phi])).items()}
    a1, a2 = cycle.centre_distances(device, device.prologue(x))
    mounting = dict(zip(device.formulas.entries("mounting"), x, strict=False))
    known = side | mounting | {"phi": phi, "a1": a1, "a2": a2}
    centres = {
        "O": np.zeros(2),
        **{name: 1e3 * np.array([side[f"x_{name}"], side[f"y_{name}"]]) for name in ("A1", "B1")},
    }
    curves: list[PitchCurve] = []
    contacts: dict[str, Array] = {}
    for stage, (names, axes, contact) in enumerate((
        (("sun", "gear 5"), ("O", "A1"), "P"),
        (("gear 6", "planet gear"), ("A1", "B1"), "Q"),
    )):  # fmt: skip
        t = side[f"t{stage + 1}"] + 2 * np.pi * np.arange(samples + 1) / samples
        points = [1e3 * found for found in _points(device, x, stage, known, t)]
        curves += [
            PitchCurve(name, centres[axis], found) for name, axis, found in zip(names, axes, points, strict=True)
        ]
        contacts[contact] = points[0][:, 0]
    return Gearing(phi_deg, tuple(curves), centres, contacts)


def _points(device: Device, x: Array, stage: int, known: dict[str, float], t: Array) -> tuple[Array, Array]:
    """Points (2, n) of a stage's inner gear and of its partner that meet at t, whose first is in contact [m]."""
    at = _contact(device, x, stage, t)
    known = known | {f"T{stage + 1}": float(at["turned"][0])}
    form = f"pair{stage + 1}"
    names = device.sidecar["functions"][form]["inputs"]
    point = {"point": np.array([t, at["r"], at["turned"]])}
    found = device.formulas(form, **{name: point.get(name, known.get(name)) for name in names})
    return np.array([found["x_inner"], found["y_inner"]]), np.array([found["x_outer"], found["y_outer"]])


def _contact(device: Device, x: Array, stage: int, t: Array) -> dict[str, Array]:
    """Contact of a stage at polar angles (n,) of its inner gear."""
    pair, parameters = device.stages[stage], device.of_stage(stage, x)
    hoisted = pair.prologue(parameters=parameters)["hoisted"]
    return {name: row[0] for name, row in pair.contact(t=t, parameters=parameters, hoisted=hoisted).items()}


def ratios(device: Device, x: Array, phi_deg: Array) -> tuple[Array, Array]:
    """Ratios of both stages at carrier angles (n,): dphi52/dphi and -dphi72/dphi52, each (n,) [-]."""
    side = device.side(x, np.radians(phi_deg))
    first, second = (_contact(device, x, stage, side[f"t{stage + 1}"])["ratio"] for stage in (0, 1))
    return first, second
