"""What is good of a response: larger, smaller, or near a value; and what is best by the goals of several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from planter.errors import InputError
from planter.files import csv_rows

if TYPE_CHECKING:
    from planter.kernels import Array

ALLOWED = "larger, smaller, zero, or a number for a target value"
_SAME = 1e-12
"""Share of the largest loss by which losses may differ that count as equal."""


@dataclass(frozen=True)
class Goal:
    """What is wanted of a response: more of it, less of it, or to be near `value`."""

    wanted: Literal["larger", "smaller", "near"]
    value: float = 0.0

    @classmethod
    def of(cls, text: str) -> Goal:
        """The goal of a text as users write it, or as results show it. Raises InputError for anything else.

        >>> [str(Goal.of(text)) for text in ("larger", "zero", "12.5", "target 3")]
        ['larger', 'nearest 0', 'target 12.5', 'target 3']
        """
        plain = text.strip().lower()
        if plain == "larger":
            return cls("larger")
        if plain == "smaller":
            return cls("smaller")
        value = "0" if plain in ("zero", "nearest 0") else plain.removeprefix("target").strip()
        if not csv_rows.finite(value) or abs(float(value)) > csv_rows.LARGEST:
            raise InputError(f"the goal {csv_rows.shortened(text)} is not allowed: it must be {ALLOWED}")
        return cls("near", float(value))

    def __str__(self) -> str:
        if self.wanted != "near":
            return self.wanted
        return f"target {self.value:.10g}" if self.value else "nearest 0"

    def loss(self, values: Array) -> Array:
        """How far values (n,) are from what is wanted: less is better."""
        signs = {"larger": -1.0, "smaller": 1.0}
        return np.abs(values - self.value) if self.wanted == "near" else signs[self.wanted] * values


NEAREST_ZERO = Goal("near", 0.0)


def asked(texts: Sequence[str]) -> dict[str, Goal]:
    """Goals by response, from texts NAME=GOAL. Raises InputError for anything else, and for two of one response."""
    found: dict[str, Goal] = {}
    for text in texts:
        name, equals, goal = (part.strip() for part in text.rpartition("="))
        if not equals or not name:
            raise InputError(f"--goal {text} is not allowed: it must be NAME=GOAL, a goal being {ALLOWED}")
        if name in found:
            raise InputError(f"--goal {text}: {name} has a goal already, but it must have one")
        try:
            found[name] = Goal.of(goal)
        except InputError as error:
            raise InputError(f"--goal {text}: {error}") from None
    return found


def check(goals: Mapping[str, Goal], responses: Sequence[str], source: str) -> None:
    """Raise InputError unless every response has a goal, and every goal a response."""
    for name, goal in goals.items():
        if name not in responses:
            raise InputError(
                f"--goal {name}={goal}: {source} has no such response, it must be one of {', '.join(responses)}"
            )
    missing = [name for name in responses if name not in goals]
    if missing:
        options = " ".join(f"--goal {name}=larger" for name in missing)
        raise InputError(
            f"{source}: nothing says what is good of {' and '.join(missing)}: each response must have its goal, as in "
            f"{options} ({ALLOWED})"
        )


def ranks(losses: Array) -> Array:
    """Ranks (n,) of losses from 1 for the least; equal ones, rounding apart, share their mean rank."""
    from scipy.stats import rankdata

    step = _SAME * float(np.max(np.abs(losses)))
    return np.asarray(rankdata(np.round(losses / step) if step else losses))


def order(losses: Sequence[Array]) -> NDArray[np.intp]:
    """Indices (n,) of combinations from the best on: by mean rank over all responses, then by their worst rank."""
    each = np.array([ranks(one) for one in losses])
    return np.lexsort((each.max(axis=0), each.mean(axis=0)))


def equally_good(losses: Sequence[Array]) -> int:
    """How many combinations share the best mean rank."""
    means = np.mean([ranks(one) for one in losses], axis=0)
    return int(np.sum(means <= means.min() + 1e-9))
