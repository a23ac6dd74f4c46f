"""Slips in what a paper discloses: a sign that, put right, makes printed numbers come out that do not as they stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from planter.audit.registry import Computation, Inputs
from planter.errors import PlanterError

FEWEST = 3
"""Numbers that a slip must explain: fewer may come out by chance."""
SAMPLE = 12
"""Numbers that a sign is tried on first."""


@dataclass(frozen=True)
class Slip:
    """A disclosed input with another sign, and the numbers that come out with it: by place, and what they come to."""

    what: str
    inputs: Mapping[str, Any]
    cured: Mapping[int, float]


def found(numbers: Sequence[Any], disclosed: Mapping[str, Any], assumed: Mapping[str, Any]) -> list[Slip]:
    """Signs that explain numbers of one paper which are not reproduced, the one that explains most first.

    Each takes the numbers that none before it explains.
    """
    left, slips = dict(enumerate(numbers)), list[Slip]()
    while len(left) >= FEWEST:
        tried = [_tried(what, inputs, left, disclosed, assumed) for what, inputs in _signs(disclosed)]
        best = max(tried, key=lambda slip: len(slip.cured), default=None)
        if best is None or len(best.cured) < FEWEST:
            break
        slips.append(best)
        left = {place: number for place, number in left.items() if place not in best.cured}
    return slips


def _signs(disclosed: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every number among the disclosed inputs with its sign reversed, in lists of up to a few."""
    for name, value in disclosed.items():
        if isinstance(value, list) and len(value) <= FEWEST and all(isinstance(v, int | float) for v in value):
            for place, entry in enumerate(value):
                if entry:
                    yield f"sign of {entry:g} in {name}", {name: [*value[:place], -entry, *value[place + 1 :]]}


def _tried(
    what: str, inputs: Mapping[str, Any], numbers: Mapping[int, Any], disclosed: Mapping[str, Any],
    assumed: Mapping[str, Any],
) -> Slip:  # fmt: skip
    """What a sign explains; nothing if it explains none of the first few."""
    cured: dict[int, float] = {}
    for count, (place, number) in enumerate(numbers.items()):
        if count == SAMPLE and not cured:
            break
        found = _computed(number, {**disclosed, **inputs}, assumed)
        if found is not None and found.value is not None and number.agrees_with(found):
            cured[place] = found.value
    return Slip(what, inputs, cured)


def _computed(number: Any, disclosed: Mapping[str, Any], assumed: Mapping[str, Any]) -> Computation | None:
    try:
        return Computation.of(number.by, Inputs(number.arguments, disclosed, assumed))
    except (PlanterError, ArithmeticError, ValueError):
        return None
