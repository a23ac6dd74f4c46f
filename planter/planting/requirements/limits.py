"""Limits of requirements as bounds on rows, and how far a value is from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.planting.requirements.measures import ABSOLUTE, STRICT, Measures, Row
from planter.planting.requirements.section import BY_NAME, Kind, Requirements

INVERSE = "curvature_radius"
"""The requirement on 1/row: its rows are curvatures [1/m]."""


@dataclass(frozen=True)
class Limits:
    """Bounds (k,) on the rows of `Measures` and the size (k,) in which their violations are counted, in SI.

    With margins these are what an optimum has to keep, without them what the file limits.
    """

    lower: Array
    upper: Array
    step: Array

    def excess(self, values: Array) -> Array:
        """By how many steps each row is beyond its bounds, negative inside, (k,)."""
        return np.maximum(self.lower - values, values - self.upper) / self.step


def limits(measures: Measures, margins: bool = True) -> Limits:
    """The bounds of every row."""
    pairs = [_pair(measures.section, row.kind, margins) for row in measures.rows]
    lower, upper = np.array(pairs, dtype=float).T
    return Limits(lower, upper, np.array([_step(measures.section, row.kind) for row in measures.rows]))


def shown(row: Row, value: float) -> float:
    """A row's value as the requirement's number in the shown unit: a size, or a radius."""
    if row.kind.name == INVERSE:
        value = 1 / value
    return (abs(value) if row.kind.name in ABSOLUTE else value) / row.kind.factor


def shown_limits(section: Requirements, kind: Kind) -> tuple[float | None, float | None]:
    """Lower and upper limit as the file has them."""
    return section.limit(kind.name, "min"), section.limit(kind.name, "max")


def reserve(section: Requirements, kind: Kind, value: float) -> float:
    """How far a shown value is inside the nearest limit; negative outside."""
    low, high = shown_limits(section, kind)
    rooms = [value - low] if low is not None else []
    return min([*rooms, *([high - value] if high is not None else [])])


def relaxed(section: Requirements, name: str, value: float) -> tuple[str, float, float]:
    """Key of the limit that a shown value misses, the limit, and the one that it keeps, margin included."""
    kind = BY_NAME[name]
    low, high = shown_limits(section, kind)
    margin = section.limit(name, "margin") or 0.0
    rooms = {"min": np.inf if low is None else value - low, "max": np.inf if high is None else high - value}
    side = min(rooms, key=lambda which: rooms[which])
    old = low if side == "min" else high
    assert old is not None
    strict = 2 * STRICT / kind.factor if name == "pitch_curvature" else 0.0
    return kind.key(side), old, value - margin - strict if side == "min" else value + margin


def _pair(section: Requirements, kind: Kind, margins: bool) -> tuple[float, float]:
    margin = (section.limit(kind.name, "margin") or 0.0) if margins else 0.0
    low, high = shown_limits(section, kind)
    lower = -np.inf if low is None else (low + margin) * kind.factor
    upper = np.inf if high is None else (high - margin) * kind.factor
    if kind.name in ABSOLUTE:
        return -upper, upper
    if kind.name == INVERSE:
        return -np.inf, 1 / lower
    return (lower + STRICT if kind.name == "pitch_curvature" else lower), upper


def _step(section: Requirements, kind: Kind) -> float:
    step = kind.step * kind.factor
    if kind.name != INVERSE:
        return step
    least = (section.limit(kind.name, "min") or 0.0) * kind.factor
    return step / least / (least + step)
