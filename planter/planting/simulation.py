"""`planter simulate` and `planter sensitivity`: the results of a machine's own design, as the interface gives them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.optimise.refined import Panels, Refined
from planter.optimise.samples import Samples
from planter.optimise.spread import Weighed
from planter.planting import cycle as planting
from planter.planting import plausible, response
from planter.planting.model import Device
from planter.planting.objective import weights
from planter.planting.requirements import record as requirements
from planter.planting.response import Planting

FEWEST_SAMPLES, MOST_SAMPLES = 8, 100_000
AT = (
    "phi52_deg", "phi72_deg", "alpha_deg", "omega_rad_s", "omega_dot_rad_s2", "tip_x_mm", "tip_y_mm", "theta1_deg",
    "F_E_N", "F_Ex_N", "M_Q_Nm", "M_P_Nm", "F_B1x_N", "F_B1y_N", "F_A1x_N", "F_A1y_N",
)  # fmt: skip
AT_TOTALS = ("F_Ox_N", "F_Oy_N", "F_O1x_N", "F_O1y_N", "support_N", "M_L_Nm", "M_1_Nm")


@dataclass(frozen=True)
class Simulation:
    """A simulated cycle: the table of its samples and the result as the interface gives it."""

    cycle: planting.Cycle
    result: dict[str, Any]


def simulate(device: Device, samples: int | None = None, at_deg: Sequence[float] = ()) -> Simulation:
    """A machine's own design over a cycle of `samples` angles, and at single carrier angles [deg].

    Raises InputError for a number of samples out of range or an angle that is not finite.
    """
    count = checked_samples(device.machine.objective.samples if samples is None else samples)
    prologue = device.prologue(device.design)
    turn = planting.cycle(device, prologue, planting.angles(count))
    objective = weights(device.machine)
    sampled = planting.statistics(turn.support)
    found = Refined(Planting(device)).look(device.design)
    result = {
        "machine": device.machine.name,
        "model": device.model,
        "samples": count,
        "design": planting.shown_design(device, device.design),
        "weight_N": planting.weight(device),
        "centre_distance_mm": dict(zip(("a1", "a2"), planting.centre_distances(device, prologue) * 1e3, strict=True)),
        "support_force": sampled,
        "objective": objective.value(sampled["range_N"], sampled["variance_N2"]),
        "warnings": [
            *plausible.warnings(device.machine), *(w.table() for w in planting.warnings(device, device.design, turn))
        ],
        "refined": {
            "max_N": found.high, "min_N": found.low, "range_N": found.range,
            "variance_N2": found.variance, "objective": objective.value(found.range, found.variance),
        },
        "work": work(device),
        "at": at(device, at_deg),
        **requirements.of(device),
    }  # fmt: skip
    return Simulation(turn, result)


def checked_samples(samples: int) -> int:
    if not FEWEST_SAMPLES <= samples <= MOST_SAMPLES:
        allowed = f"it must be between {FEWEST_SAMPLES} and {MOST_SAMPLES}"
        raise InputError(f"--samples = {samples} is not allowed: {allowed}")
    return samples


def at(device: Device, angles_deg: Sequence[float]) -> list[dict[str, float]]:
    """Forces and motions at single carrier angles: of side 1, and totals."""
    if not angles_deg:
        return []
    degrees = np.asarray(angles_deg, dtype=float)
    if not np.isfinite(degrees).all():
        raise InputError(f"--at = {degrees[~np.isfinite(degrees)][0]} is not allowed: it must be a finite angle in deg")
    found = planting.cycle(device, device.prologue(device.design), np.radians(degrees))
    columns = {key: found.sides[0][key] for key in AT} | {key: found.totals[key] for key in AT_TOTALS}
    return [
        {"phi_deg": float(phi)} | {key: float(values[i]) for key, values in columns.items()}
        for i, phi in enumerate(degrees)
    ]


def work(device: Device) -> dict[str, float]:
    """Work over a turn [J], by quadrature between joints: of the motor, and lost to friction at both cams."""
    panels = Panels(Planting(device), device.design)
    found = planting.cycle(device, device.prologue(device.design), panels.nodes)
    lost = found.sides[0]["F_E_loss_W"] + found.sides[1]["F_E_loss_W"]
    turn = 2 * np.pi * panels.weights
    return {
        "input_J": float(turn @ found.totals["M_L_Nm"]),
        "friction_J": float(turn @ lost) / device.machine.si("speed_rpm"),
    }


def sensitivity(device: Device, samples: int | None = None) -> dict[str, Any]:
    """Objective, its gradient in shown units, and which directions of the design the support force does not feel."""
    count = checked_samples(device.machine.objective.samples if samples is None else samples)
    value, gradient = objective_gradient(device, count)
    named = dict(zip(device.names, (gradient * device.scale).tolist(), strict=True))
    return {"objective": value, "gradient": named, **response.sensitivity(device, device.design, count)}


def objective_gradient(device: Device, samples: int) -> tuple[float, Array]:
    """Objective (31) of the machine's own design and its gradient in x (p,); an extreme's is that of its sample."""
    angles = Samples(Planting(device), samples).angles
    force, slopes = device.support_slopes(device.prologue(device.design), angles)
    turn = Weighed(weights(device.machine), force)
    return turn.value, turn.gradient(slopes[:, 1:])
