"""Machines to test on: the built-in ones, and random valid ones drawn around them."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from planter.errors import PlanterError
from planter.files import examples
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device

SPREAD = {
    "mass": 0.3,
    "inertia": 0.3,
    "centroid": 0.4,
    "nozzle": 0.2,
    "spring": 0.3,
    "contact": 0.2,
    "operation": 0.3,
}
DESIGN = {
    "theta_deg": (50, 80),
    "gamma_deg": (0, 60),
    "alpha3_deg": (-180, 180),
    "beta6_deg": (-180, 180),
    "R3_mm": (25, 35),
    "e3_mm": (1, 6),
    "m31": (0.8, 1.8),
    "A6_mm": (25, 35),
    "k6": (0.02, 0.15),
    "m61": (0.8, 1.5),
}
CAM = {
    "psi0_deg": 5,
    "rise_delta_deg[0]": 10,
    "rise_delta_deg[1]": 10,
    "fall_delta_deg[0]": 10,
    "fall_delta_deg[1]": 10,
}
BUILT_IN = tuple(examples.list_examples("planting"))
RANDOM = tuple(f"random {seed}" for seed in range(1, 5))
FLANKS = ("modified sine", "3-4-5 polynomial", "modified trapezoid", "cycloidal")
"""Laws of the random machines' cams, in their order."""


def sampled(*seeds: int) -> list[Any]:
    """Every machine as a case of a test: of the random ones those of some seeds, the others for the
    long tests.
    """
    chosen = {f"random {seed}" for seed in seeds}
    return [
        *BUILT_IN,
        *(pytest.param(n, marks=() if n in chosen else pytest.mark.long) for n in RANDOM),
    ]


@cache
def machine(name: str) -> PlantingMachine:
    """A built-in machine, or "random <seed>"."""
    if name in BUILT_IN:
        return load(name)
    rng = np.random.default_rng(int(name.removeprefix("random ")))
    while True:
        try:
            machine = load(BUILT_IN[rng.integers(len(BUILT_IN))])
            changed = with_flank(machine, FLANKS[RANDOM.index(name)]).with_numbers(
                _draw(machine, rng)
            )
            Device(changed)
        except PlanterError:
            continue
        return changed


def with_flank(base: PlantingMachine, law: str) -> PlantingMachine:
    """A machine with another law of its cam's flanks."""
    table = base.table()
    return PlantingMachine.read({**table, "cam": {**table["cam"], "flank": law}}, base.source)


def _draw(base: PlantingMachine, rng: np.random.Generator) -> dict[str, float]:
    changes = {f"design.{name}": float(rng.uniform(*limits)) for name, limits in DESIGN.items()}
    for path, value in base.numbers().items():
        section, _, key = path.partition(".")
        if section in SPREAD:
            shift = rng.uniform(-5, 5) if key.endswith("]") and section == "nozzle" else 0.0
            changes[path] = float(value * (1 + SPREAD[section] * rng.uniform(-1, 1)) + shift)
        elif section == "cam" and key in CAM:
            changes[path] = float(value + CAM[key] * rng.uniform(-1, 1))
    return changes


@cache
def device(name: str, model: Model = "exact") -> Device:
    return Device(machine(name), model)


def tampered(name: str, path: str, factor: float = 1.01) -> PlantingMachine:
    """A machine with one number changed."""
    base = machine(name)
    return base.with_numbers({path: base.numbers()[path] * factor})


def design_near(subject: Device, rng: np.random.Generator) -> np.ndarray:
    """A design in the box of the machine's bounds."""
    return subject.lower + (subject.upper - subject.lower) * rng.uniform(size=subject.size)
