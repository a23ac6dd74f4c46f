"""`planter calibrate`: undisclosed inputs fitted to a paper's reported force, and how little that settles."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution, least_squares

from planter.errors import InputError
from planter.files import paths, units
from planter.kernels import Array
from planter.planting import cycle
from planter.planting.model import Device
from planter.planting.results import CalibrationFound, Fitted, OtherModel

SEED = 0
MET = 0.01
"""A target is met where none of its numbers is missed by more than this share."""
RANK = 1e-6
"""Singular values below this share of the largest count as zero."""
CLOSE = 1e-12
"""Relative change at which the last, local search ends: a target that can be met is met to rounding of the model."""
GENERATIONS, MEMBERS = 100, 5
"""Generations of the global searches, and members of a population per input."""


@dataclass(frozen=True)
class Inputs:
    """What is fitted: paths in the machine file, with bounds (n,) in SI."""

    paths: tuple[str, ...]
    lower: Array
    upper: Array

    @classmethod
    def load(cls) -> Inputs:
        bounds = _data()["bounds"]
        factors = np.array([units.factor(path) for path in bounds])
        low, high = np.array(list(bounds.values()), dtype=float).T
        return cls(tuple(bounds), low * factors, high * factors)

    def places(self, device: Device) -> list[int]:
        shown = [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]
        return [shown.index(path) for path in self.paths]

    def scaled(self, z: Array) -> Array:
        """Values in SI of a point in the unit box, (n,)."""
        return self.lower + z * (self.upper - self.lower)


class Force:
    """The support force of a device's own design as a function of the fitted inputs z in [0, 1]^n.

    The device stays as it is: values are changed in one of its own.
    """

    def __init__(self, device: Device, inputs: Inputs) -> None:
        self.inputs, self._places = inputs, inputs.places(device)
        self._device = Device(device.machine, device.model)
        self._device.constants = device.constants.copy()
        self._device.compile()
        self._own = device.constants[self._places]

    def __call__(self, z: Array) -> Array:
        device = self._device
        device.constants[self._places] = self.inputs.scaled(z)
        return device.support(device.prologue(device.design), cycle.angles(device.machine.objective.samples))

    def start(self) -> Array:
        """The machine's own values, taken into the bounds."""
        return np.clip((self._own - self.inputs.lower) / (self.inputs.upper - self.inputs.lower), 0, 1)


def calibrate(device: Device, other: Device, target: str) -> CalibrationFound:
    """Fit the undisclosed inputs of a machine to a target, within bounds from common sense; `other` is its other model.

    The result says whether the target is met and how well it is reached, how many of the inputs it settles (`rank`),
    what the other model gives for the same inputs, and the largest range that inertia can reach there at all. Raises
    InputError for a target that there is not.
    """
    targets = _data()["target"]
    if target not in targets:
        close = paths.close(target, targets)
        hint = f"did you mean {close[0]}? " if close else ""
        raise InputError(f"--target = {target} is not allowed: {hint}it must be one of {', '.join(targets)}")
    wanted = targets[target]
    inputs = Inputs.load()
    force, compared = Force(device, inputs), Force(other, inputs)
    z = _fitted(force, wanted)
    other_force = cycle.statistics(compared(z))
    misses = dict(zip(wanted, _residuals(force, z, wanted).tolist(), strict=True))
    return CalibrationFound(
        machine=device.machine.name,
        model=device.model,
        met=all(abs(miss) <= MET for miss in misses.values()),
        statement=_statement(target, misses),
        fitted=_table(inputs, z),
        target=wanted,
        reached=_reached(force(z), wanted),
        miss_percent={key: 100 * miss for key, miss in misses.items()},
        rank=_rank(force, z, wanted),
        other_model=OtherModel(other_force.range_N, other_force.variance_N2, other_force.mean_N),
        largest_inertia_range_N=_largest_range(force if device.model == "exact" else compared),
    )


def _statement(target: str, misses: dict[str, float]) -> str:
    """Whether a target is met, with the relative misses."""
    missed = {key: miss for key, miss in misses.items() if abs(miss) > MET}
    if not missed:
        return f"The target {target} is met, every number of it within {100 * MET:g} %."
    told = ", ".join(f"{key} by {100 * miss:+.1f} %" for key, miss in missed.items())
    return f"The target {target} is missed: {told}. No values within the bounds that were tried come nearer."


def _data() -> dict[str, Any]:
    return tomllib.loads(files("planter.planting").joinpath("calibration.toml").read_text(encoding="utf-8"))


def _reached(force: Array, wanted: dict[str, float]) -> dict[str, float]:
    found = cycle.statistics(force)
    return {key: float(getattr(found, key)) for key in wanted}


def _residuals(force: Force, z: Array, wanted: dict[str, float]) -> Array:
    """Relative misses of the target, (k,)."""
    reached = _reached(force(z), wanted)
    return np.array([reached[key] / value - 1 for key, value in wanted.items()])


def _fitted(force: Force, wanted: dict[str, float]) -> Array:
    """A global search in the bounds, then bounded least squares from there."""
    start = _searched(lambda z: float((_residuals(force, z, wanted) ** 2).sum()), len(force.start()), force.start())
    inside = np.clip(start, 1e-6, 1 - 1e-6)
    exact = {"ftol": CLOSE, "xtol": CLOSE, "gtol": CLOSE}
    found: Array = least_squares(lambda z: _residuals(force, z, wanted), inside, bounds=(0, 1), **exact).x
    return found


def _searched(cost: Callable[[Array], float], size: int, start: Array | None = None) -> Array:
    """The best point of the unit box that differential evolution finds."""
    found = differential_evolution(
        cost, [(0.0, 1.0)] * size, seed=SEED, maxiter=GENERATIONS, popsize=MEMBERS, polish=False, x0=start
    )
    best: Array = found.x
    return best


def _rank(force: Force, z: Array, wanted: dict[str, float]) -> int:
    """How many combinations of the inputs the target settles."""
    step = 1e-6
    columns = []
    for unit in np.eye(len(z)):
        side = -1 if z @ unit > 0.5 else 1
        moved = _residuals(force, z + side * step * unit, wanted)
        columns.append(side * (moved - _residuals(force, z, wanted)) / step)
    values = np.linalg.svd(np.array(columns), compute_uv=False)
    return int((values > RANK * values[0]).sum())


def _largest_range(force: Force) -> float:
    """The largest range of the support force [N] that any inputs within the bounds give, in the exact model."""
    return float(np.ptp(force(_searched(lambda z: -float(np.ptp(force(z))), len(force.inputs.paths)))))


def _table(inputs: Inputs, z: Array) -> list[Fitted]:
    values = zip(inputs.paths, inputs.scaled(z), inputs.lower, inputs.upper, strict=True)
    return [
        Fitted(
            name=path,
            value=value / units.factor(path),
            unit=units.unit(path) or "1",
            lower=low / units.factor(path),
            upper=high / units.factor(path),
            origin="calibrated",
        )
        for path, value, low, high in ((p, float(v), float(a), float(b)) for p, v, a, b in values)
    ]
