"""Sign errors in the disclosed inputs of a paper: a corrected sign that reproduces printed numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from planter.audit.registry import Computation, Inputs
from planter.errors import PlanterError

MIN_NUMBERS = 3
"""Smallest number of printed numbers that a sign error must explain; fewer may agree by chance."""
SAMPLE_SIZE = 12
"""Numbers on which a sign is tried first."""


@dataclass(frozen=True)
class Slip:
    """A disclosed input with reversed sign, and the values of the numbers that it reproduces, by index."""

    cause: str
    inputs: Mapping[str, Any]
    cured: Mapping[int, float]


def find_sign_errors(numbers: Sequence[Any], disclosed: Mapping[str, Any], assumed: Mapping[str, Any]) -> list[Slip]:
    """Return sign errors that explain numbers of a paper that are not reproduced, the most explanatory first.

    Each explains only numbers that no earlier one explains.
    """
    remaining, slips = dict(enumerate(numbers)), list[Slip]()
    while len(remaining) >= MIN_NUMBERS:
        trials = [_try_sign(name, inputs, remaining, disclosed, assumed) for name, inputs in _reverse_signs(disclosed)]
        best = max(trials, key=lambda slip: len(slip.cured), default=None)
        if best is None or len(best.cured) < MIN_NUMBERS:
            break
        slips.append(best)
        remaining = {place: number for place, number in remaining.items() if place not in best.cured}
    return slips


def _reverse_signs(disclosed: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the numbers in short lists of disclosed inputs with reversed signs."""
    for name, value in disclosed.items():
        if isinstance(value, list) and len(value) <= MIN_NUMBERS and all(isinstance(v, int | float) for v in value):
            for index, entry in enumerate(value):
                if entry:
                    yield f"sign of {entry:g} in {name}", {name: [*value[:index], -entry, *value[index + 1 :]]}


def _try_sign(
    name: str, inputs: Mapping[str, Any], numbers: Mapping[int, Any], disclosed: Mapping[str, Any],
    assumed: Mapping[str, Any],
) -> Slip:  # fmt: skip
    """Return the numbers that a sign explains, none if it explains none of the first `SAMPLE_SIZE`."""
    cured: dict[int, float] = {}
    for count, (place, number) in enumerate(numbers.items()):
        if count == SAMPLE_SIZE and not cured:
            break
        computed = _compute(number, {**disclosed, **inputs}, assumed)
        if computed is not None and computed.value is not None and number.agrees_with(computed):
            cured[place] = computed.value
    return Slip(name, inputs, cured)


def _compute(number: Any, disclosed: Mapping[str, Any], assumed: Mapping[str, Any]) -> Computation | None:
    try:
        return Computation.evaluate(number.by, Inputs(number.arguments, disclosed, assumed))
    except (PlanterError, ArithmeticError, ValueError):
        return None
