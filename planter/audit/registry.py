"""How a printed number is computed anew: formulas by name, and inputs that note which of them were assumed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from planter.errors import PlanterError
from planter.files.units import factor
from planter.progress import Listener

Value = float | None
"""What a formula gives; None where there is no such number."""
MM = factor("length_mm")
"""A millimetre [m]."""


def half_place(text: str) -> float:
    """Return half a unit of the last digit of a printed number: by how much rounding may have changed it.

    >>> half_place("8.6"), half_place("-8.52e-5"), half_place("144")
    (0.05, 5e-08, 0.5)
    """
    return float(Decimal(1).scaleb(int(Decimal(text).as_tuple().exponent)) / 2)


class Rounded(float):
    """A number that a paper prints with a decimal point; `rounding` is half a unit of its last digit.

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
    """Yield a key and two copies of an input for each rounded number in it: that number at its lower and upper end."""
    if isinstance(value, Rounded):
        yield key, value - value.rounding, value + value.rounding
    elif isinstance(value, list | dict):
        for entry in value if isinstance(value, dict) else range(len(value)):
            for part, *ends in rounding_ends(value[entry], f"{key}[{entry}]"):
                low, high = value.copy(), value.copy()
                low[entry], high[entry] = ends
                yield part, low, high


class Inputs:
    """Inputs of one computation: its own arguments, what the paper discloses, what had to be assumed.

    A formula that reads an assumed input leaves a trace, so that no result can pass for one of disclosed inputs.

    >>> inputs = Inputs({"side": 1}, {"width_mm": 20.0}, {"friction": 0.15})
    >>> inputs["width_mm"], inputs.assumed
    (20.0, [])
    >>> inputs["friction"], inputs.assumed
    (0.15, ['friction = 0.15'])
    >>> float(inputs.si("width_mm"))
    0.02
    """

    def __init__(self, own: Mapping[str, Any], disclosed: Mapping[str, Any], assumed: Mapping[str, Any]) -> None:
        self._known, self._own = {**disclosed, **own}, own
        self._assumed = assumed
        self._read: set[str] = set()
        self.assumed: list[str] = []

    def __contains__(self, name: str) -> bool:
        return name in self._known or name in self._assumed

    def __getitem__(self, name: str) -> Any:
        if name in self._known:
            self._read.add(name)
            return self._known[name]
        value = self._assumed[name]
        self.assume(f"{name} = {value}")
        return value

    def si(self, name: str) -> Any:
        """An input, or a list of them as (n,), in SI units and radians by the unit that its name ends in."""
        return np.multiply(self[name], factor(name))

    def assume(self, text: str) -> None:
        """Note an assumed input that a formula took from elsewhere."""
        if text not in self.assumed:
            self.assumed.append(text)

    def at_rounding_ends(self) -> Iterator[tuple[str, Inputs, Inputs]]:
        """Yield, for each rounded number that was read, its key and these inputs with it at its lower and upper end.

        Keys of disclosed inputs are the same in every computation of a paper.
        """
        for name in sorted(self._read):
            key = f"{id(self)}: {name}" if name in self._own else name
            for part, *ends in rounding_ends(self._known[name], key):
                low, high = (Inputs({**self._known, name: end}, {}, self._assumed) for end in ends)
                yield part, low, high


Formula = Callable[[Inputs], Value]
Entries = list[dict[str, Any]]
Consequence = Callable[[Mapping[str, Any], Mapping[str, Any], Mapping[str, Any]], Entries]
"""From a row of the data file, what its paper discloses, and the paper's trial."""
Front = Callable[[Listener | None], dict[str, Any]]
"""What a model can give at all beside a paper's figures; it may be sought, which is told as it goes."""
SomeFormula = TypeVar("SomeFormula", bound=Formula)
FORMULAS: dict[str, Formula] = {}
CONSEQUENCES: dict[str, Consequence] = {}
FRONTS: dict[str, Front] = {}


@dataclass(frozen=True)
class Computation:
    """A formula evaluated: its value, the inputs that it read, and what their rounding leaves open.

    Raises what the formula raises.
    """

    formula: Formula
    inputs: Inputs
    value: Value

    @classmethod
    def of(cls, name: str, inputs: Inputs) -> Computation:
        """Evaluate the formula that is registered under a name."""
        return cls(FORMULAS[name], inputs, FORMULAS[name](inputs))

    @cached_property
    def effects(self) -> dict[str, float]:
        """What half a unit of the last digit of each rounded input does to the value, by the input's key.

        To first order, by a central difference; 0 for an input at an end of which the formula has no value.
        """
        ends = {key: (self._end(low), self._end(high)) for key, low, high in self.inputs.at_rounding_ends()}
        return {key: 0.0 if low is None or high is None else (high - low) / 2 for key, (low, high) in ends.items()}

    @property
    def interval(self) -> tuple[float, float] | None:
        """Lowest and highest value within the rounding of the printed inputs; None where there is no value."""
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
    """Enters a function in the registry under the name by which the data file calls it."""

    def enter(function: SomeFormula) -> SomeFormula:
        FORMULAS[name] = function
        return function

    return enter


def consequence(name: str) -> Callable[[Consequence], Consequence]:
    """Enters what follows from a chain's broken laws in the registry, under the name by which a data file calls it."""

    def enter(function: Consequence) -> Consequence:
        CONSEQUENCES[name] = function
        return function

    return enter


def front(paper: str) -> Callable[[Front], Front]:
    """Enters what a model can give at all in the registry, under the short name of the paper that it speaks of."""

    def enter(function: Front) -> Front:
        FRONTS[paper] = function
        return function

    return enter
