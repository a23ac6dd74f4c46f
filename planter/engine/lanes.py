"""Where the lanes of a walk along closed loops are: a machine in each, none of which waits for another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers

VECTOR = 8
"""Lanes that a processor takes at once, at most."""
LARGEST_STEP = np.pi / 180
"""Largest step of the walk [rad]; one that does not close is halved."""
LEAST_STEP = 1e-5
"""Least step of the walk [rad]."""


@dataclass
class WalkLanes:
    """Where the lanes of a walk are: an entry, or a column, for each.

    `index` is the angle that a lane goes to next, `at` where it is, `before` where it was a step before, `target` where
    Newton's method closes it now, from `guess`, after `calls`; a lane is `settled` if it needs another target. Lanes
    that are not `running` repeat one that is.
    """

    lane: Integers
    d: Array
    sense: Array
    index: Integers
    at: Array
    q: Array
    before: Array
    q_before: Array
    step: Array
    target: Array
    guess: Array
    calls: Integers
    settled: Flags
    running: Flags

    @classmethod
    def at_start(cls, d: Array, sense: Array, q: Array, index: int) -> WalkLanes:
        """Return lanes at angle 0, on their way to the angle of an index."""
        count = len(sense)
        return cls(
            lane=np.arange(count),
            d=d.copy(),
            sense=sense.copy(),
            index=np.full(count, index),
            at=np.zeros(count),
            q=q.copy(),
            before=np.zeros(count),
            q_before=q.copy(),
            step=np.full(count, LARGEST_STEP),
            target=np.zeros(count),
            guess=q.copy(),
            calls=np.zeros(count, dtype=np.int64),
            settled=np.ones(count, dtype=bool),
            running=np.ones(count, dtype=bool),
        )

    def compacted(self) -> WalkLanes:
        """Return the lanes that are running, filled up with others to full vectors."""
        count = np.count_nonzero(self.running)
        order = np.argsort(~self.running, kind="stable")[: count + -count % VECTOR]
        return WalkLanes(**{name: np.ascontiguousarray(array[..., order]) for name, array in vars(self).items()})

    def aim(self, angles: Array) -> None:
        """Set target and guess, by the secant through the last two places, where a lane is settled."""
        reach, following = self.at + self.step, angles[self.index]
        target = np.where(reach > following - LEAST_STEP, following, reach)
        apart = self.at - self.before
        slope = np.divide(self.q - self.q_before, apart, out=np.zeros_like(self.q), where=apart > 0)
        guess = self.q + slope * (target - self.at)
        settled = self.settled
        if settled.all():
            self.target, self.guess, self.calls = target, guess, np.zeros_like(self.calls)
        else:
            self.target, self.guess = np.where(settled, target, self.target), np.where(settled, guess, self.guess)
            self.calls = np.where(settled, 0, self.calls)

    def move(self, accepted: Flags, refused: Flags, q: Array) -> None:
        """Take lanes that closed to their targets and double their steps, halve those of lanes that did not close."""
        if accepted.all():
            self.before, self.q_before, self.at, self.q = self.at, self.q, self.target, q
            self.step, self.settled = np.minimum(2 * self.step, LARGEST_STEP), accepted
            return
        self.settled, self.calls = accepted | refused, self.calls + 1
        self.guess = np.where(self.settled, self.guess, q)
        self.before, self.q_before = np.where(accepted, self.at, self.before), np.where(accepted, self.q, self.q_before)
        self.at, self.q = np.where(accepted, self.target, self.at), np.where(accepted, q, self.q)
        changed = np.where(accepted, np.minimum(2 * self.step, LARGEST_STEP), self.step / 2)
        self.step = np.where(self.settled, changed, self.step)

    def stop(self, ended: Flags) -> None:
        """End lanes: they go along with one that is running, so that they cost no further steps."""
        self.running = self.running & ~ended
        if ended.any() and self.running.any():
            guide, lost = int(np.argmax(self.running)), np.flatnonzero(~self.running)
            for name, array in vars(self).items():
                if name not in ("lane", "running"):
                    array[..., lost] = array[..., [guide]]
