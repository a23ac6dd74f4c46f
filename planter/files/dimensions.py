"""Units as printed in papers: factors to SI, and dimensions.

>>> measured("kN m").factor, measured("mm/s2").factor, measured("r/min").same_kind(measured("rad/s"))
(1000.0, 0.001, True)
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

Dimension = tuple[float, float, float, float]
"""Exponents of kg, m, s, rad."""
_BASE: dict[str, tuple[float, Dimension]] = {
    "": (1.0, (0, 0, 0, 0)),
    "1": (1.0, (0, 0, 0, 0)),
    "%": (1e-2, (0, 0, 0, 0)),
    "g": (1e-3, (1, 0, 0, 0)),
    "t": (1e3, (1, 0, 0, 0)),
    "m": (1.0, (0, 1, 0, 0)),
    "s": (1.0, (0, 0, 1, 0)),
    "min": (60.0, (0, 0, 1, 0)),
    "h": (3600.0, (0, 0, 1, 0)),
    "rad": (1.0, (0, 0, 0, 1)),
    "deg": (math.pi / 180, (0, 0, 0, 1)),
    "r": (2 * math.pi, (0, 0, 0, 1)),
    "N": (1.0, (1, 1, -2, 0)),
    "J": (1.0, (1, 2, -2, 0)),
    "W": (1.0, (1, 2, -3, 0)),
    "Pa": (1.0, (1, -1, -2, 0)),
}
_ALSO = {"rpm": "r/min"}
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "k": 1e3, "M": 1e6, "G": 1e9}
_PREFIXED = ("g", "m", "s", "rad", "N", "J", "W", "Pa")
_FACTOR = re.compile(r"([^\W\d]+|%|°|1)\^?(-?\d+(?:\.\d+)?)?")


@dataclass(frozen=True)
class Unit:
    """A unit: its text, its factor to SI, and its dimension."""

    text: str
    factor: float
    dimension: Dimension

    def same_kind(self, other: Unit) -> bool:
        """Return whether both have the same dimension; an angle differs from a pure number."""
        return self.dimension == other.dimension

    def squared(self) -> Unit:
        """Return the square of the unit."""
        kg, m, s, rad = (2 * power for power in self.dimension)
        return Unit(f"({self.text})2", self.factor**2, (kg, m, s, rad))


def measured(text: str) -> Unit:
    """Parse a unit such as ``N m``, ``kg m2``, ``mm/s2`` or ``r/min``; an empty text is a pure number.

    Units after a stroke divide. Raises ValueError, which names the part, if the text is not a unit.
    """
    factor, total = 1.0, [0.0, 0.0, 0.0, 0.0]
    above, _, below = _ALSO.get(text.strip(), text).partition("/")
    for sign, part in ((1, above), (-1, below)):
        for name in part.replace("*", " ").replace("·", " ").split():
            scale, dimension, power = _parse_factor(name)
            factor *= scale ** (sign * power)
            total = [t + sign * power * d for t, d in zip(total, dimension, strict=True)]
    kg, m, s, rad = total
    return Unit(text, factor, (kg, m, s, rad))


def _parse_factor(text: str) -> tuple[float, Dimension, float]:
    match = _FACTOR.fullmatch(text)
    if match is None:
        raise ValueError(f"{text} is no unit")
    name, power = "deg" if match[1] == "°" else match[1], float(match[2] or 1)
    if name in _BASE:
        return (*_BASE[name], power)
    prefix, base = name[:1], name[1:]
    if prefix in _PREFIXES and base in _PREFIXED:
        factor, dimension = _BASE[base]
        return _PREFIXES[prefix] * factor, dimension, power
    raise ValueError(f"{name} is no unit")
