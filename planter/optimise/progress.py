"""What an optimiser tells while it runs."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

QUIET = 10.0
"""Seconds after which a search that is at one long step tells where it is."""


@dataclass(frozen=True)
class Progress:
    """A method has done `done` of `total` generations or starts; `best` is the least objective so far.

    `seconds` is how long that took: what is left is taken to go on alike.

    >>> print(Progress("ga", "generation", 20, 200, 1.9, 3.0))
    ga: generation 20 of 200, best objective 1.9, about 27 s left
    >>> print(Progress("ipopt", "start", 8, 8, 1.9, 60.0))
    ipopt: start 8 of 8, best objective 1.9
    """

    method: str
    step: str
    done: int
    total: int
    best: float
    seconds: float = 0.0

    def __str__(self) -> str:
        left = self.seconds / self.done * (self.total - self.done) if self.done else 0.0
        told = f", about {max(1, round(left))} s left" if left else ""
        return f"{self.method}: {self.step} {self.done} of {self.total}, best objective {self.best:.9g}{told}"


Told = Callable[[Progress], None]


class Phase:
    """The steps of one method, told to `told` as they are done, and where one takes long."""

    def __init__(self, method: str, step: str, total: int, told: Told | None) -> None:
        self.method, self.step, self.total, self.told = method, step, total, told
        self.done, self.begun = 0, time.perf_counter()
        self._last = self.begun

    def reached(self, done: int, best: float | None) -> None:
        """So many steps are done, with this least objective; nothing is told before there is one."""
        self.done = done
        self._tell(best)

    def under_way(self, best: float | None) -> None:
        """A step goes on: told where nothing else has been for some time."""
        if time.perf_counter() - self._last > QUIET:
            self._tell(best)

    def _tell(self, best: float | None) -> None:
        self._last = time.perf_counter()
        if self.told is not None and best is not None:
            self.told(Progress(self.method, self.step, self.done, self.total, best, self._last - self.begun))
