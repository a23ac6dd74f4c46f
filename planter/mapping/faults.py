"""Warnings about the gears of a train that can be made, each with the carrier angle where it is worst."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planter.mapping.results import Warned
from planter.mapping.train import GEARS, Train
from planter.numerics.arrays import to_degrees

MOST_RATIO = 3.0
"""Ratio of a stage, or its reciprocal, from which on it is told: a pitch radius is a quarter of the distance."""
DEDENDUM, ADDENDUM = 1.25, 1.0
"""Depth of the roots below a pitch curve, and height of the tips above it, in modules."""
LEAST_MODULE = 1e-3
"""Module [m] below which what limits it is told."""
_MM = 1e3


def warnings(train: Train) -> list[Warned]:
    """Return all warnings of a train."""
    return [*_sense(train), *_ratios(train), *_sharp(train), *_hollow(train)]


def largest_module(train: Train) -> float:
    """The largest module [m] at which no curve of roots or tips has a cusp."""
    return float(min(min(_rooms(train, gear)) for gear in range(len(GEARS))))


def _rooms(train: Train, gear: int) -> tuple[float, float]:
    """Largest modules [m] of a gear: by its roots where the pitch curve is convex, by its tips where it is hollow."""
    kappa = train.curvatures[1][gear]
    sharpest, hollowest = float(kappa.max()), float(-kappa.min())
    return 1 / (DEDENDUM * sharpest), 1 / (ADDENDUM * hollowest) if hollowest > 0 else np.inf


def _sense(train: Train) -> Iterator[Warned]:
    if train.curve.sense > 0:
        yield Warned(
            "sense", None,
            "the arm gains on the carrier: two external meshes turn it the other way, so that one mesh needs an idler",
        )  # fmt: skip


def _ratios(train: Train) -> Iterator[Warned]:
    """Ratios that leave one gear of a stage a small pitch radius."""
    for extreme in train.curve.extremes:
        at = train.gears(np.array([extreme.angle]))
        stages = [float(at[name][0]) for name in ("i1", "i2")]
        if max(*stages, *(1 / stage for stage in stages)) >= MOST_RATIO:
            radii = {gear: float(at[f"r{k}"][0]) for k, gear in enumerate(GEARS, 1)}
            gear = min(radii, key=lambda gear: radii[gear])
            yield _warning(
                "ratio", extreme.angle,
                f"the total ratio is {float(at['i'][0]):.4g} (stages {stages[0]:.4g} and {stages[1]:.4g})",
                f": the pitch radius of {gear} is only {radii[gear] * _MM:.4g} mm of {train.distance * _MM:.4g} mm",
            )  # fmt: skip


def _sharp(train: Train) -> Iterator[Warned]:
    """Pitch curves so sharp that the roots of ordinary teeth meet."""
    theta, kappa = train.curvatures
    for gear, name in enumerate(GEARS):
        module = _rooms(train, gear)[0]
        if module < LEAST_MODULE:
            worst = int(np.argmax(kappa[gear]))
            yield _warning(
                "cusp", float(theta[worst]),
                f"the pitch curve of {name} is nearly a cusp, of a radius of {_MM / kappa[gear][worst]:.4g} mm",
                f": the roots of teeth meet there from a module of {module * _MM:.3g} mm on",
            )  # fmt: skip


def _hollow(train: Train) -> Iterator[Warned]:
    """Pitch curves that are not convex, which a rack or hob cannot cut."""
    theta, kappa = train.curvatures
    for gear, name in enumerate(GEARS):
        if not train.convex[gear]:
            worst = int(np.argmin(kappa[gear]))
            ranges = ", ".join(f"{to_degrees(a):.4g} to {to_degrees(b):.4g}" for a, b in train.concave(gear))
            module = _rooms(train, gear)[1]
            limit = f"; the tips of teeth meet there from a module of {module * _MM:.3g} mm on"
            yield _warning(
                "hollow pitch curve", float(theta[worst]),
                f"the pitch curve of {name} is hollow, of a radius of {_MM / -kappa[gear][worst]:.4g} mm (all in all "
                f"from {ranges} deg)",
                f": a rack or hob cannot cut it there{limit if module < LEAST_MODULE else ''}",
            )  # fmt: skip


def _warning(name: str, angle: float, cause: str, consequence: str) -> Warned:
    return Warned(name, to_degrees(angle), f"at carrier angle {to_degrees(angle):.5g} deg {cause}{consequence}")
