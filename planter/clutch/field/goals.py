"""Goals of responses: larger, smaller, or near a value; and the ranking of combinations by several goals."""

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
class ResponseGoal:
    """The goal of a response: larger, smaller, or near `value`."""

    sense: Literal["larger", "smaller", "near"]
    value: float = 0.0

    @classmethod
    def parse(cls, text: str) -> ResponseGoal:
        """Return the goal of a text as users write it, or as results print it. Raises InputError for anything else.

        >>> [str(ResponseGoal.parse(text)) for text in ("larger", "zero", "12.5", "target 3")]
        ['larger', 'nearest 0', 'target 12.5', 'target 3']
        """
        plain = text.strip().lower()
        if plain == "larger":
            return cls("larger")
        if plain == "smaller":
            return cls("smaller")
        value = "0" if plain in ("zero", "nearest 0") else plain.removeprefix("target").strip()
        if not csv_rows.finite(value) or abs(float(value)) > csv_rows.LARGEST:
            raise InputError(f"goal {csv_rows.shortened(text)}: must be {ALLOWED}")
        return cls("near", float(value))

    def __str__(self) -> str:
        if self.sense != "near":
            return self.sense
        return f"target {self.value:.10g}" if self.value else "nearest 0"

    def loss(self, values: Array) -> Array:
        """Return the distances of values (n,) from the goal: less is better."""
        signs = {"larger": -1.0, "smaller": 1.0}
        return np.abs(values - self.value) if self.sense == "near" else signs[self.sense] * values


NEAREST_ZERO = ResponseGoal("near", 0.0)


def parse_goals(texts: Sequence[str]) -> dict[str, ResponseGoal]:
    """Return goals by response from texts NAME=GOAL. Raises InputError for other texts, or two goals of a response."""
    goals: dict[str, ResponseGoal] = {}
    for text in texts:
        name, equals, goal = (part.strip() for part in text.rpartition("="))
        if not equals or not name:
            raise InputError(f"--goal {text}: must be NAME=GOAL, a goal being {ALLOWED}")
        if name in goals:
            raise InputError(f"--goal {text}: {name} has a goal already, but it must have one")
        try:
            goals[name] = ResponseGoal.parse(goal)
        except InputError as error:
            raise InputError(f"--goal {text}: {error}") from None
    return goals


def check_goals(goals: Mapping[str, ResponseGoal], responses: Sequence[str], source: str) -> None:
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


def rank_losses(losses: Array) -> Array:
    """Return ranks (n,) of losses from 1 for the smallest; equal losses, up to rounding, share their mean rank."""
    from scipy.stats import rankdata

    step = _SAME * float(np.max(np.abs(losses)))
    return np.asarray(rankdata(np.round(losses / step) if step else losses))


def order_combinations(losses: Sequence[Array]) -> NDArray[np.intp]:
    """Return indices (n,) of combinations, the best first: by mean rank over all responses, then by worst rank."""
    rank_table = np.array([rank_losses(loss) for loss in losses])
    return np.lexsort((rank_table.max(axis=0), rank_table.mean(axis=0)))


def count_ties(losses: Sequence[Array]) -> int:
    """Return the number of combinations that share the best mean rank."""
    means = np.mean([rank_losses(loss) for loss in losses], axis=0)
    return int(np.sum(means <= means.min() + 1e-9))
