"""A variable for other programs: name, units, meaning, range."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Causality = Literal["input", "parameter", "output"]

_POWERS: dict[str, Mapping[str, int]] = {
    "m": {"m": 1}, "kg": {"kg": 1}, "s": {"s": 1}, "rad": {"rad": 1}, "1": {},
    "N": {"kg": 1, "m": 1, "s": -2}, "J": {"kg": 1, "m": 2, "s": -2}, "W": {"kg": 1, "m": 2, "s": -3},
}  # fmt: skip
_FACTOR = re.compile(r"([A-Za-z]+|1)(\d*)")


@dataclass(frozen=True)
class Variable:
    """A number of a simulation unit, in SI units and radians.

    `shown` is the display unit, `factor` what one of these is in SI; `start` and the range from `low` to
    `high` are in SI, None where there is none. A parameter that is `fixed` keeps its value from the start on.
    """

    name: str
    unit: str
    meaning: str
    causality: Causality
    start: float | None = None
    low: float | None = None
    high: float | None = None
    shown: str = ""
    factor: float = 1.0
    fixed: bool = False


def powers(unit: str) -> dict[str, int]:
    """The powers of the base units kg, m, s and rad that a unit of SI is made of. Raises ValueError for another one.

    >>> powers("N m"), powers("rad/s2"), powers("1")
    ({'kg': 1, 'm': 2, 's': -2}, {'rad': 1, 's': -2}, {})
    """
    above, _, below = unit.partition("/")
    exponents: dict[str, int] = {}
    for text, sign in ((above, 1), (below, -1)):
        for word in text.split():
            factor = _FACTOR.fullmatch(word)
            if factor is None or factor[1] not in _POWERS:
                raise ValueError(f"{unit} is not a product of {', '.join(_POWERS)}")
            for base, power in _POWERS[factor[1]].items():
                exponents[base] = exponents.get(base, 0) + sign * power * int(factor[2] or 1)
    return {base: power for base, power in exponents.items() if power}
