"""Branches of a response over a box: where a condition may go both ways, both are followed.

Straight-line code asks its questions (is this below zero, how many whole turns) in one order. Lanes whose question has
several answers over a box go on with one of them, and for each other answer a further lane is noted, which repeats the
answers given before and takes that one. So each lane is one smooth piece of the response, extended over the whole box,
and at every design of the box the response is that of one of its lanes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers
from planter.optimise.proof.balls import Ball, Unbounded

MOST_ANSWERS = 3
"""Answers of one question above which a box is too wide to follow them."""


@dataclass
class Branches:
    """Questions of so many lanes; `script` (q, lanes) holds answers that are given, NaN where the box tells."""

    lanes: int
    script: Array
    answers: list[Array] = field(default_factory=list)
    others: list[tuple[int, int, float]] = field(default_factory=list)
    """(lane, question, another answer)."""
    jumping: Flags = field(init=False)
    """Lanes (lanes,) in which some value may jump where an answer changes."""

    def __post_init__(self) -> None:
        self.jumping = np.zeros(self.lanes, dtype=bool)

    @classmethod
    def none(cls, lanes: int) -> Self:
        return cls(lanes, np.empty((0, lanes)))

    def below(self, value: Ball, strictly: bool, jumps: bool = True) -> Flags:
        """Whether values are below zero (or at it); `jumps` where the response may, as the answer changes."""
        never = ~(value.low < 0 if strictly else value.low <= 0)  # so a ball without bounds asks nothing
        always = value.high < 0 if strictly else value.high <= 0
        usual = np.where(value.mid < 0, 1.0, 0.0)
        found: Flags = self._asked(np.where(never, 0.0, 1.0), np.where(always, 1.0, 0.0), usual, jumps) > 0
        return found

    def floor(self, value: Ball) -> Array:
        high, low, mid = (np.nan_to_num(np.floor(side)) for side in (value.high, value.low, value.mid))
        return self._asked(high, low, mid)

    def _asked(self, largest: Array, least: Array, usual: Array, jumps: bool = True) -> Array:
        """The answer of each lane, between the least and the largest."""
        question = len(self.answers)
        given = self.script[question] if question < len(self.script) else None
        open_ = largest != least
        if given is None and not open_.any():
            self.answers.append(np.broadcast_to(least, (self.lanes,)))
            return least
        self.jumping |= open_ & jumps
        free = np.ones(self.lanes, dtype=bool) if given is None else np.isnan(given)
        answer = np.where(free, np.broadcast_to(usual, free.shape), 0 if given is None else given)
        self.answers.append(answer)
        if (largest - least).max(where=np.broadcast_to(open_, largest.shape), initial=0) >= MOST_ANSWERS:
            raise Unbounded("a box goes through many branches")
        for lane in np.flatnonzero(np.broadcast_to(open_, (self.lanes,)) & free):
            low, high = (np.broadcast_to(side, (self.lanes,))[lane] for side in (least, largest))
            for other in np.arange(low, high + 1):
                if other != answer[lane]:
                    self.others.append((int(lane), question, float(other)))
        return answer

    def further(self) -> tuple[Integers, Array]:
        """Lanes to be followed besides, by the lane they leave, with their scripts (q, further)."""
        lanes = np.array([lane for lane, _, _ in self.others], dtype=np.int64)
        script = np.full((len(self.answers), len(lanes)), np.nan)
        for k, (lane, question, other) in enumerate(self.others):
            script[:question, k] = [answer[lane] for answer in self.answers[:question]]
            script[question, k] = other
        return lanes, script


class Unbranched(Branches):
    """Questions of what cannot be followed along several answers. Raises Unbounded where there are any."""

    def _asked(self, largest: Array, least: Array, usual: Array, jumps: bool = True) -> Array:
        if (largest != least).any():
            raise Unbounded("the gaps of a loop have several branches")
        return least
