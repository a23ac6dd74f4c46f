"""Pitch curves of every family at sizes drawn at random, and machines with any two families."""

from __future__ import annotations

from functools import cache

import numpy as np

from derive.mechanics.gearing.families import FAMILIES
from planter.files import units
from planter.gears.geometry import families
from planter.gears.geometry.stage import Stage, StageCandidate, converge_series
from planter.papers.planting.file import PlantingMachine, load
from tests.support.sizing import Size, Sizing

Drawn = tuple[str, int]
"""A family and a seed."""
EVERY_CURVE: list[Drawn] = [(family, seed) for family in sorted(FAMILIES) for seed in (1, 2, 3)]
PAIRS = [(first, second) for first in sorted(FAMILIES) for second in sorted(FAMILIES)]


@cache
def sizing(family: str) -> Sizing:
    return Sizing(family)


def size(family: str, seed: int, swing: float | None = None) -> Size:
    """A size from one box for all families; the shape from the family's own."""
    rng = np.random.default_rng([seed, *family.encode()])
    mean, relative, m = rng.uniform((0.02, 0.05, 0.7), (0.05, 0.8, 1.7))
    shape = tuple(
        rng.uniform(entry["lower"], entry["upper"]) for entry in sizing(family).sidecar["shapes"]
    )
    return Size(mean, relative if swing is None else swing, m, shape)


@cache
def parameters(family: str, seed: int) -> np.ndarray:
    return sizing(family).parameters(size(family, seed))


@cache
def stage(family: str, seed: int) -> Stage:
    return stage_of(family, parameters(family, seed))


def stage_of(family: str, parameters: np.ndarray) -> Stage:
    names = tuple(entry["shown"] for entry in families.load_sidecar(family)["parameters"])
    return converge_series(Stage(family, names), [StageCandidate(parameters, lambda name: name)])


@cache
def machine(first: str, second: str) -> PlantingMachine:
    """The built-in machine with other gears: families of both stages, sizes near the paper's."""
    table = load("wang2017").table()
    mounting = {
        name: table["design"][name]
        for name in ("theta_deg", "gamma_deg", "alpha3_deg", "beta6_deg")
    }
    gears = _describe_size(first, "3", Size(0.0307, 0.35, 1.4)) | _describe_size(
        second, "6", Size(0.0307, 0.1, 1.2)
    )
    table["stage1"], table["stage2"], table["design"] = (
        {"family": first},
        {"family": second},
        mounting | gears,
    )
    table["bounds"] = {name: _vary(value) for name, value in table["design"].items()}
    table["origin"] = {"default": "assumed"}
    sections = {key: value for key, value in table.items() if key != "requirements"}
    return PlantingMachine.read(sections | {"name": f"{first}-{second}"}, f"{first}-{second}.toml")


def _describe_size(family: str, gear: str, size: Size) -> dict[str, float]:
    shapes = sizing(family).sidecar["shapes"]
    parameters = sizing(family).parameters(
        Size(
            size.mean_radius,
            size.swing,
            size.deformation,
            tuple(entry["upper"] / 2 for entry in shapes),
        )
    )
    *names, last = (entry["shown"] for entry in sizing(family).sidecar["parameters"])
    parts = [name.partition("_") for name in names]
    keys = [*(f"{base}{gear}{dash}{unit}" for base, dash, unit in parts), f"{last}{gear}1"]
    return {
        key: float(value / units.unit_factor(key))
        for key, value in zip(keys, parameters, strict=True)
    }


def _vary(value: float) -> list[float]:
    width = abs(value) / 100 + 1e-3
    return [value - width, value + width]
