"""Registry of the formulas that recompute printed numbers, and inputs that record which were
assumed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from planter.errors import PlanterError
from planter.files.units import unit_factor

Value = float | None
"""Value of a formula; None if it is undefined."""
MM = unit_factor("length_mm")
"""A millimetre [m]."""


def half_place(text: str) -> float:
    """Return half a unit of the last digit of a printed number: by how much rounding may have
    changed it.

    >>> half_place("8.6"), half_place("-8.52e-5"), half_place("144")
    (0.05, 5e-08, 0.5)
    """
    return float(Decimal(1).scaleb(int(Decimal(text).as_tuple().exponent)) / 2)


class Rounded(float):
    """A number that a paper prints with a decimal point; `rounding` is half a unit of its last
    digit.

    It is 0 for what has no last digit, infinities among it: the check of the file refuses those.

    >>> Rounded("-69.1470"), Rounded("-69.1470").rounding
    (-69.147, 5e-05)
    """

    rounding: float

    def __new__(cls, text: str) -> Rounded:
        self = super().__new__(cls, text)
        try:
            self.rounding = half_place(text)
        except (ArithmeticError, ValueError):
            self.rounding = 0.0
        return self


def rounding_ends(value: Any, key: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield a key and two copies of an input for each rounded number in it: that number at its
    lower and upper end.
    """
    if isinstance(value, Rounded):
        yield key, value - value.rounding, value + value.rounding
    elif isinstance(value, list | dict):
        for entry in value if isinstance(value, dict) else range(len(value)):
            for part, *ends in rounding_ends(value[entry], f"{key}[{entry}]"):
                low, high = value.copy(), value.copy()
                low[entry], high[entry] = ends
                yield part, low, high


class Inputs:
    """Inputs of a computation: its arguments, the disclosed inputs of the paper, and the assumed
    ones.

    Every read of an assumed input is recorded, so that no result can pass as one of disclosed
    inputs.

    >>> inputs = Inputs({"side": 1}, {"width_mm": 20.0}, {"friction": 0.15})
    >>> inputs["width_mm"], inputs.assumed
    (20.0, [])
    >>> inputs["friction"], inputs.assumed
    (0.15, ['friction = 0.15'])
    >>> float(inputs.si("width_mm"))
    0.02
    """

    def __init__(
        self, arguments: Mapping[str, Any], disclosed: Mapping[str, Any], assumed: Mapping[str, Any]
    ) -> None:
        self._values, self._arguments = {**disclosed, **arguments}, arguments
        self._assumed = assumed
        self._read: set[str] = set()
        self.assumed: list[str] = []

    def __contains__(self, name: str) -> bool:
        return name in self._values or name in self._assumed

    def __getitem__(self, name: str) -> Any:
        if name in self._values:
            self._read.add(name)
            return self._values[name]
        value = self._assumed[name]
        self.assume(f"{name} = {value}")
        return value

    def si(self, name: str) -> Any:
        """Return an input, or a list of inputs (n,), in SI units by the unit suffix of its name."""
        return np.multiply(self[name], unit_factor(name))

    def assume(self, text: str) -> None:
        """Note an assumed input that a formula took from elsewhere."""
        if text not in self.assumed:
            self.assumed.append(text)

    def at_rounding_ends(self) -> Iterator[tuple[str, Inputs, Inputs]]:
        """Yield, for each rounded number that was read, its key and these inputs with it at its
        lower and upper end.

        Keys of disclosed inputs are the same in every computation of a paper.
        """
        for name in sorted(self._read):
            key = f"{id(self)}: {name}" if name in self._arguments else name
            for part, *ends in rounding_ends(self._values[name], key):
                low, high = (Inputs({**self._values, name: end}, {}, self._assumed) for end in ends)
                yield part, low, high


Formula = Callable[[Inputs], Value]
SomeFormula = TypeVar("SomeFormula", bound=Formula)
FORMULAS: dict[str, Formula] = {}


@dataclass(frozen=True)
class Computation:
    """An evaluated formula: its value, the inputs that it read, and the effect of their rounding.

    Raises what the formula raises.
    """

    formula: Formula
    inputs: Inputs
    value: Value

    @classmethod
    def evaluate(cls, name: str, inputs: Inputs) -> Computation:
        """Evaluate the formula that is registered under a name."""
        return cls(FORMULAS[name], inputs, FORMULAS[name](inputs))

    @cached_property
    def effects(self) -> dict[str, float]:
        """Effect on the value of half a unit of the last digit of each rounded input, by the
        input's key.

        To first order, by a central difference; 0 for an input at an end of which the formula has
        no value.
        """
        ends = {
            key: (self._end(low), self._end(high))
            for key, low, high in self.inputs.at_rounding_ends()
        }
        return {
            key: 0.0 if low is None or high is None else (high - low) / 2
            for key, (low, high) in ends.items()
        }

    @property
    def interval(self) -> tuple[float, float] | None:
        """Lowest and highest value within the rounding of the printed inputs; None without a
        value.
        """
        if self.value is None:
            return None
        reach = sum(map(abs, self.effects.values()))
        return self.value - reach, self.value + reach

    def _end(self, inputs: Inputs) -> Value:
        try:
            return self.formula(inputs)
        except (PlanterError, ArithmeticError, ValueError):
            return None


def formula(name: str) -> Callable[[SomeFormula], SomeFormula]:
    """Return a decorator that registers a formula under its name in data files."""

    def enter(function: SomeFormula) -> SomeFormula:
        FORMULAS[name] = function
        return function

    return enter
