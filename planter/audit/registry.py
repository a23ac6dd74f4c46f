"""How a printed number is computed anew: formulas by name, and inputs that note which of them were assumed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from planter.files.units import factor
from planter.progress import Listener

Value = float | None
"""What a formula gives; None where there is no such number."""
MM = factor("length_mm")
"""A millimetre [m]."""


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
        self._known = {**disclosed, **own}
        self._assumed = assumed
        self.assumed: list[str] = []

    def __contains__(self, name: str) -> bool:
        return name in self._known or name in self._assumed

    def __getitem__(self, name: str) -> Any:
        if name in self._known:
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
