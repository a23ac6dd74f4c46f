"""What the rigid exact model can and cannot say about a measured force: the size of each effect that it can compute."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.planting import cycle
from planter.planting.lifted import LiftedModel
from planter.planting.model import Device

RPM = units.factor("_rpm")
RIPPLES = (1, 2, 4, 8, 16, 32)
"""How often a turn the speed goes up and down."""
PHASES = 12
PER_RIPPLE = 24
"""Angles for each time that the speed goes up and down, at least."""
FEWEST = 720
LOST_MM = 0.2
"""Circumferential backlash that an impact is computed for [mm]; the impulse goes with its cube root."""
NOT_COMPUTED = (
    "soil", "elastic frame and sensor", "duration of an impact, and so its force", "errors of the cam's shape",
    "the carrier's own inertia and the motor",
)  # fmt: skip
"""What a measured force holds and a rigid model without these data has no size for."""


@dataclass(frozen=True)
class Speeds:
    """The support force at any speed: F = weight + omega^2 a + d(omega)/dt b, each of a and b (n,) at equal angles."""

    phi: Array
    weight: float
    a: Array
    b: Array

    @classmethod
    def of(cls, model: LiftedModel, count: int) -> Speeds:
        phi, speed = cycle.sample_angles(count), model.device.machine.si("operation.speed_rpm")
        steady = model.turn(phi).totals["F_support"]
        speeding = model.turn(phi, {"speed_rate": 1.0}).totals["F_support"]
        weight = cycle.compute_weight(model.device)
        return cls(phi, weight, (steady - weight) / speed**2, speeding - steady)

    def rippling(self, low: float, high: float, often: float) -> Array:
        """The largest-range force [N] of some phases, the speed going up and down between two speeds [rad/s]."""
        mean, swing = (low + high) / 2, (high - low) / 2
        found = []
        for phase in np.linspace(0, 2 * np.pi, PHASES, endpoint=False):
            speed = mean + swing * np.sin(often * self.phi + phase)
            rate = swing * often * np.cos(often * self.phi + phase) * speed
            found.append(self.weight + speed**2 * self.a + rate * self.b)
        return max(found, key=np.ptp)


def told(device: Device, observed_rpm: tuple[float, float], measured: dict[str, float]) -> dict[str, Any]:
    """Sizes of the effects that the exact model of a device can compute, beside a measured range [N]."""
    model = LiftedModel(device)
    low, high = (rpm * RPM for rpm in observed_rpm)
    steady = Speeds.of(model, FEWEST)
    return {
        "measured": measured,
        "constant_speed": [
            {"speed_rpm": rpm, "range_N": float(np.ptp(steady.a)) * (rpm * RPM) ** 2}
            for rpm in (*observed_rpm, device.machine.operation.speed_rpm)
        ],
        "rippling_speed": [_ripple(model, low, high, often) for often in RIPPLES],
        "ripples_needed": _needed(model, low, high, measured["range_N"]),
        "backlash": impacts(model, LOST_MM),
        "not_computed": list(NOT_COMPUTED),
    }


def _ripple(model: LiftedModel, low: float, high: float, often: int) -> dict[str, float]:
    force = Speeds.of(model, max(FEWEST, PER_RIPPLE * often)).rippling(low, high, often)
    return {"per_turn": often, "range_N": float(np.ptp(force)), "variance_N2": float(force.var())}


def _needed(model: LiftedModel, low: float, high: float, range_: float) -> int:
    """How often a turn the speed would have to go up and down for a range: the rate's force grows with that."""
    mean, swing = (low + high) / 2, (high - low) / 2
    largest = float(abs(Speeds.of(model, FEWEST).b).max())
    return int(np.ceil(range_ / (2 * swing * mean * largest)))


def impacts(model: LiftedModel, lost_mm: float) -> list[dict[str, Any]]:
    """Where a tooth moment changes its sign teeth part and meet again: the largest impulse on teeth and on the support.

    What is driven is free on the way, and the moment that it lacks grows evenly; it meets the teeth again at the speed
    (9 rate way^2 / (2 J))^(1/3). The support feels the jump of its momentum, at most its static moment times the speed.
    """
    phi = cycle.sample_angles(FEWEST)
    turn, driven = model.turn(phi), _driven(model.device)
    distances = cycle.find_centre_distances(model.device, model.device.prologue(model.device.design))
    return [
        _impact(model.device, turn.one[f"M_{tag}"], phi, {"contact": tag, "backlash_mm": lost_mm}, *driven[tag],
                float(distance) / 2)
        for tag, distance in zip("PQ", distances, strict=True)
    ]  # fmt: skip


def _driven(device: Device) -> dict[str, tuple[float, float]]:
    """Moment of inertia [kg m2] and static moment [kg m] about its pin of what each mesh drives, the nozzle closed.

    The first mesh drives the middle body and, by the second stage at a ratio of 1, the planet with its nozzle.
    """
    si = device.machine.si
    planet = [(si("mass.planet_kg"), *(si(f"centroid.planet_xy_mm[{i}]") for i in (0, 1)))]
    halves = [
        (si(f"mass.half_{part}_kg"), *(si(f"nozzle.hinge_A_mm[{i}]") + si(f"nozzle.{part}_mm[{i}]") for i in (0, 1)))
        for part in ("C1", "C2")
    ]
    turning = si("inertia.J7_about_B1_kg_m2") + 2 * sum(m * (x**2 + y**2) for m, x, y in halves)
    turning += 2 * sum(si(f"inertia.{part}_centroidal_xx_yy_zz_kg_m2[2]") for part in ("C1", "C2"))
    moments = np.array([m * np.array([x, y]) for m, x, y in (*planet, *halves, *halves)]).sum(axis=0)
    static = float(np.hypot(*moments))
    middle = si("inertia.J56_about_A1_kg_m2"), si("mass.middle_kg") * si("centroid.middle_radius_mm")
    return {"P": (turning + middle[0], static + middle[1]), "Q": (turning, static)}


def _impact(
    device: Device, moment: Array, phi: Array, contact: dict[str, Any], inertia: float, static: float, radius: float
) -> dict[str, Any]:
    after = np.roll(moment, -1)
    changes = np.flatnonzero(np.sign(moment) != np.sign(after))
    rates = np.abs(after - moment)[changes] / (phi[1] - phi[0]) * device.machine.si("operation.speed_rpm")
    way = contact["backlash_mm"] * 1e-3 / radius
    speed = float(((9 * rates * way**2 / (2 * inertia)) ** (1 / 3)).max(initial=0.0))
    return {**contact, "changes_per_turn": 2 * len(changes), "tooth_impulse_Ns": inertia * speed / radius,
            "support_impulse_Ns": static * speed}  # fmt: skip
