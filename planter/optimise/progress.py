"""What an optimiser tells while it runs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """A method has done `done` of `total` generations or starts; `best` is the least objective so far.

    >>> print(Progress("ga", "generation", 20, 200, 1.9))
    ga: generation 20 of 200, best objective 1.9
    """

    method: str
    step: str
    done: int
    total: int
    best: float

    def __str__(self) -> str:
        return f"{self.method}: {self.step} {self.done} of {self.total}, best objective {self.best:.9g}"
