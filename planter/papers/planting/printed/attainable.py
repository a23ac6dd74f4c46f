"""Attainable forces of the exact model compared with table 1 of wang2017, and its effects in the
experiment.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from planter.audit import numbers
from planter.audit.registry import front
from planter.files import units
from planter.kernels import Array
from planter.papers.planting.file import load
from planter.papers.planting.lifted import LiftedModel
from planter.papers.planting.model import Device
from planter.progress import Listener

PAPER = "wang2017"
RPM = units.unit_factor("_rpm")
RIPPLES = (1, 2, 4, 8, 16, 32)
"""Speed oscillations per revolution."""
PHASES = 12
SAMPLES_PER_RIPPLE = 24
"""Minimum number of angles per speed oscillation."""
MIN_SAMPLES = 720
BACKLASH_MM = 0.2
"""Circumferential backlash that an impact is computed for [mm]; the impulse goes with its cube
root.
"""
NOT_COMPUTED = (
    "soil",
    "elastic frame and sensor",
    "duration of an impact, and so its force",
    "errors of the cam's shape",
    "the carrier's own inertia and the motor",
)
"""Effects in a measured force whose size a rigid model without these data cannot compute."""
Entry = Mapping[str, Any]


FRONT_FILE = "attainable_front.json"
"""Front of range and variance that docs/studies/attainable_front.py has searched for."""
PAPER_ROWS = ("theory", "experiment")


def load_paper_points(paper: str) -> dict[str, dict[str, float]]:
    """Return range [N] and variance [N2] of the support force as a paper gives them, by row of its
    table.
    """
    disclosed = numbers.load_numbers()["disclosed"][paper]
    return {
        row: {key: disclosed[row][key] for key in ("range_N", "variance_N2")} for row in PAPER_ROWS
    }


def read_saved_front() -> dict[str, Any]:
    """Return the saved front."""
    file = files("planter.papers.planting").joinpath(FRONT_FILE)
    saved: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return saved


@front(PAPER)
def attainable(progress: Listener | None) -> dict[str, Any]:
    """Return the front with the paper's points, and the sizes of the effects in the experiment."""
    points = load_paper_points(PAPER)
    content = read_saved_front()
    fronts = [
        {**curve, "most_variance_N2": max(float(point["variance_N2"]) for point in curve["points"])}
        for curve in content["fronts"]
    ]
    content = {**content, "fronts": fronts}
    low, high = numbers.load_numbers()["disclosed"][PAPER]["observed_speed_rpm"]
    sizes = describe_experiment(Device(load(PAPER), "exact"), (low, high), points["experiment"])
    statements = [*_describe_front(content), *_describe_sizes(sizes)]
    return {"paper": PAPER, **content, "experiment": sizes, "statements": statements}


def _describe_front(content: Entry) -> Iterator[str]:
    for curve in content["fronts"]:
        yield (
            f"Exact model, {curve['contact']}: the search reached a range of "
            f"{curve['largest_range']['range_N']:.4g} N "
            f"and a variance of {curve['most_variance_N2']:.4g} N2, within the stated bounds and "
            f"with any law of the "
            "flanks, wherever they begin."
        )
    for row in content["table"]:
        attained = {c: v for c, v in row["most_variance_N2"].items() if v is not None}
        variances = ", ".join(
            f"{value:.4g} N2 with {contact}" for contact, value in attained.items()
        )
        verdict = "reached" if max(attained.values()) >= row["variance_N2"] else "not reached"
        yield (
            f"Table 1, {row['name']}: at its range of {row['range_N']:g} N the search reached a "
            f"variance of "
            f"{variances}; the paper's {row['variance_N2']:g} N2 was {verdict}."
        )
    yield (
        "The search is a heuristic one: it shows what can be attained, and does not prove that "
        "nothing else can."
    )


def _describe_sizes(sizes: Entry) -> Iterator[str]:
    measured = sizes["measured"]["range_N"]
    steady = ", ".join(
        f"{s['range_N']:.3g} N at {s['speed_rpm']:g} r/min" for s in sizes["constant_speed"]
    )
    rippling = max(sizes["rippling_speed"], key=lambda ripple: ripple["range_N"])
    yield (
        f"The experiment's {measured:g} N, with the assumed inputs: the exact range is {steady}. "
        f"Of the speeds tried "
        f"that swing over what was observed, one that does so {rippling['per_turn']} times a turn "
        f"gives the largest "
        f"range, {rippling['range_N']:.3g} N; some {sizes['ripples_needed']} times a turn would "
        f"give what was measured."
    )
    for impact in sizes["backlash"]:
        yield (
            f"Teeth at {impact['contact']} change the flank that bears "
            f"{impact['changes_per_turn']} times a turn. A "
            f"backlash of {impact['backlash_mm']:g} mm then gives the support an impulse of up to "
            f"{impact['support_impulse_Ns']:.2g} N s: {measured:g} N for "
            f"{1e3 * impact['support_impulse_Ns'] / measured:.2g} ms. How long an impact lasts a "
            f"rigid model does not "
            "say."
        )
    yield f"What a rigid model has no size for: {', '.join(sizes['not_computed'])}."


@dataclass(frozen=True)
class SpeedDependence:
    """The support force at any speed: F = weight + omega^2 a + d(omega)/dt b, each of a and b (n,)
    at equal angles.
    """

    phi: Array
    weight: float
    a: Array
    b: Array

    @classmethod
    def from_model(cls, model: LiftedModel, count: int) -> SpeedDependence:
        """Return the dependence from a cycle at constant speed, and from one with an
        acceleration.
        """
        phi, speed = (
            model.device.engine.list_angles(count),
            model.device.machine.si("operation.speed_rpm"),
        )
        steady = model.turn(phi).totals["F_support"]
        accelerated = model.turn(phi, {"speed_rate": 1.0}).totals["F_support"]
        weight = model.device.weight
        return cls(phi, weight, (steady - weight) / speed**2, accelerated - steady)

    def rippling_force(self, low: float, high: float, per_turn: float) -> Array:
        """Return the force [N] of largest range over phases of a speed that oscillates between two
        values [rad/s].
        """
        mean, swing = (low + high) / 2, (high - low) / 2
        forces = []
        for phase in np.linspace(0, 2 * np.pi, PHASES, endpoint=False):
            speed = mean + swing * np.sin(per_turn * self.phi + phase)
            rate = swing * per_turn * np.cos(per_turn * self.phi + phase) * speed
            forces.append(self.weight + speed**2 * self.a + rate * self.b)
        return max(forces, key=np.ptp)


def describe_experiment(
    device: Device, observed_rpm: tuple[float, float], measured: Mapping[str, float]
) -> dict[str, Any]:
    """Return the sizes of the effects that the exact model can compute, compared with a measured
    range [N].
    """
    model = LiftedModel(device)
    low, high = (rpm * RPM for rpm in observed_rpm)
    steady = SpeedDependence.from_model(model, MIN_SAMPLES)
    # The force of the acceleration grows with the number of oscillations
    rate_range = (high - low) * (low + high) / 2 * float(abs(steady.b).max())
    return {
        "measured": measured,
        "constant_speed": [
            {"speed_rpm": rpm, "range_N": float(np.ptp(steady.a)) * (rpm * RPM) ** 2}
            for rpm in (*observed_rpm, device.machine.operation.speed_rpm)
        ],
        "rippling_speed": [_compute_ripple(model, low, high, per_turn) for per_turn in RIPPLES],
        "ripples_needed": int(np.ceil(measured["range_N"] / rate_range)),
        "backlash": compute_impacts(model, BACKLASH_MM),
        "not_computed": list(NOT_COMPUTED),
    }


def _compute_ripple(model: LiftedModel, low: float, high: float, per_turn: int) -> dict[str, float]:
    dependence = SpeedDependence.from_model(model, max(MIN_SAMPLES, SAMPLES_PER_RIPPLE * per_turn))
    force = dependence.rippling_force(low, high, per_turn)
    return {
        "per_turn": per_turn,
        "range_N": float(np.ptp(force)),
        "variance_N2": float(force.var()),
    }


def compute_impacts(model: LiftedModel, backlash_mm: float) -> list[dict[str, Any]]:
    """Return, for each mesh, the largest impulse on teeth and support where the tooth moment
    changes its sign.

    There the teeth part and meet again. The driven body is free in between, and the missing moment
    grows linearly; it meets the teeth again at the speed (9 rate gap^2 / (2 J))^(1/3). The support
    takes the jump of the body's momentum, at most its static moment times the speed.
    """
    phi, device = model.device.engine.list_angles(MIN_SAMPLES), model.device
    turn, driven = model.turn(phi), _compute_driven_inertia(device)
    distances = device.centre_distances(device.design)
    impacts = []
    for tag, distance in zip("PQ", distances, strict=True):
        (inertia, static), radius = driven[tag], float(distance) / 2
        moment = turn.one[f"M_{tag}"]
        following = np.roll(moment, -1)
        changes = np.flatnonzero(np.sign(moment) != np.sign(following))
        rates = (
            np.abs(following - moment)[changes]
            / (phi[1] - phi[0])
            * device.machine.si("operation.speed_rpm")
        )
        gap = backlash_mm * 1e-3 / radius
        speed = float(((9 * rates * gap**2 / (2 * inertia)) ** (1 / 3)).max(initial=0.0))
        # Both sides of the device pass every change once per cycle
        impacts.append(
            {
                "contact": tag,
                "backlash_mm": backlash_mm,
                "changes_per_turn": 2 * len(changes),
                "tooth_impulse_Ns": inertia * speed / radius,
                "support_impulse_Ns": static * speed,
            }
        )
    return impacts


def _compute_driven_inertia(device: Device) -> dict[str, tuple[float, float]]:
    """Return moment of inertia [kg m2] and static moment [kg m] about its pin of each driven body,
    nozzle closed.

    The first mesh drives the middle body and, by the second stage at a ratio of 1, the planet with
    its nozzle.
    """
    si = device.machine.si
    planet = [(si("mass.planet_kg"), *(si(f"centroid.planet_xy_mm[{i}]") for i in (0, 1)))]
    halves = [
        (
            si(f"mass.half_{part}_kg"),
            *(si(f"nozzle.hinge_A_mm[{i}]") + si(f"nozzle.{part}_mm[{i}]") for i in (0, 1)),
        )
        for part in ("C1", "C2")
    ]
    inertia = si("inertia.J7_about_B1_kg_m2") + 2 * sum(m * (x**2 + y**2) for m, x, y in halves)
    inertia += 2 * sum(si(f"inertia.{part}_centroidal_xx_yy_zz_kg_m2[2]") for part in ("C1", "C2"))
    moments = np.array([m * np.array([x, y]) for m, x, y in (*planet, *halves, *halves)]).sum(
        axis=0
    )
    static = float(np.hypot(*moments))
    middle = (
        si("inertia.J56_about_A1_kg_m2"),
        si("mass.middle_kg") * si("centroid.middle_radius_mm"),
    )
    return {"P": (inertia + middle[0], static + middle[1]), "Q": (inertia, static)}
