"""How far long work is: told step by step, with the time left, to whoever listens."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

QUIET = 10.0
"""Seconds after which work that is at one long step tells where it is."""


@dataclass(frozen=True)
class Progress:
    """Of the steps of a work, such as generations, starts or figures, `done` of `total` are done.

    `best` is the least objective so far, where the work is a search; `left` [s] is how long the rest takes if it goes
    on alike, None where nothing is known of that.

    >>> print(Progress("ga", "generation", 20, 200, best=1.9, left=27.0))
    ga: generation 20 of 200, best objective 1.9, about 27 s left
    >>> print(Progress("drawing", "figure", 5, 5, "force"))
    drawing: figure 5 of 5, force
    """

    work: str
    step: str
    done: int
    total: int
    note: str = ""
    best: float | None = None
    left: float | None = None

    def __str__(self) -> str:
        parts = [f"{self.work}: {self.step} {self.done} of {self.total}", self.note]
        if self.best is not None:
            parts.append(f"best objective {self.best:.9g}")
        if self.left:
            parts.append(f"about {max(1, round(self.left))} s left")
        return ", ".join(filter(None, parts))


Listener = Callable[[Progress], None]


class Phase:
    """The steps of one work, told to a listener as they are done, and where one takes long.

    `done` of them were done before, in no time that counts.
    """

    def __init__(self, work: str, step: str, total: int, listener: Listener | None, done: int = 0) -> None:
        self.work, self.step, self.total, self.listener = work, step, total, listener
        self.done, self._before, self._begun = done, done, time.perf_counter()
        self._last = self._begun

    def reached(self, done: int, note: str = "", best: float | None = None) -> None:
        """So many steps are done."""
        self.done = done
        self._tell(note, best)

    def next(self, note: str = "") -> None:
        """One more step is done."""
        self.reached(self.done + 1, note)

    def end(self) -> None:
        """What is not done is not to be done."""
        if 0 < self.done < self.total:
            self.total = self.done
            self._tell("", None)

    def under_way(self, best: float | None) -> None:
        """A step goes on: told where nothing else has been for some time."""
        if time.perf_counter() - self._last > QUIET:
            self._tell("", best)

    def _tell(self, note: str, best: float | None) -> None:
        self._last = time.perf_counter()
        if self.listener is None:
            return
        own, rest = self.done - self._before, self.total - self.done
        left = (self._last - self._begun) / own * rest if own and rest else None
        self.listener(Progress(self.work, self.step, self.done, self.total, note, best, left))
