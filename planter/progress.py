"""Progress of long tasks, reported to a listener step by step with an estimate of the remaining
time.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

REPORT_INTERVAL = 10.0
"""Seconds after which a task reports again although no step was completed."""

SLOW_S = 2.0
"""Seconds after which a step says what it does."""


@dataclass
class RunningStep:
    """A step of the main thread: what it does, when it is due to be reported [s], and what was said
    of it last.
    """

    describe: Callable[[], str]
    due: float = field(default_factory=lambda: time.monotonic() + SLOW_S)
    reported: str = ""


_running: list[RunningStep] = []


@contextmanager
def name_step(text: str | Callable[[], str]) -> Iterator[None]:
    """Name what the main thread does meanwhile; a command says it on standard error if it takes
    more than `SLOW_S`.

    A function gives a text that changes, such as one with the time that a motion has reached. It is
    called in another thread. Steps within steps are named in place of those around them.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    step = RunningStep(text if callable(text) else lambda: text)
    _running.append(step)
    try:
        yield
    finally:
        _running.remove(step)


def describe_slow_step() -> str | None:
    """Return what the innermost running step does if it is slow and this was not said before, else
    None.
    """
    for step in _running[-1:]:  # a copy: the main thread may end the step meanwhile
        if time.monotonic() < step.due:
            continue
        before, step.reported = step.reported, step.describe()
        step.due = time.monotonic() + REPORT_INTERVAL
        return step.reported if step.reported != before else None
    return None


@dataclass(frozen=True)
class Progress:
    """Progress of a task: `done` of `total` steps, such as generations, starts or figures, are
    complete.

    `best` is the smallest objective so far if the task is a search; `remaining` [s] is extrapolated
    from the steps so far, None before the first step.

    >>> print(Progress("ga", "generation", 20, 200, best=1.9, remaining=27.0))
    ga: generation 20 of 200, best objective 1.9, about 27 s left
    >>> print(Progress("drawing", "figure", 5, 5, "force"))
    drawing: figure 5 of 5, force
    """

    task: str
    step: str
    done: int
    total: int
    note: str = ""
    best: float | None = None
    remaining: float | None = None

    def __str__(self) -> str:
        parts = [f"{self.task}: {self.step} {self.done} of {self.total}", self.note]
        if self.best is not None:
            parts.append(f"best objective {self.best:.9g}")
        if self.remaining:
            parts.append(f"about {max(1, round(self.remaining))} s left")
        return ", ".join(filter(None, parts))


Listener = Callable[[Progress], None]


class ProgressPhase:
    """Counter of the completed steps of one task, which reports to a listener.

    `done` steps were restored from an earlier run; they do not count for the remaining time.
    """

    def __init__(
        self, task: str, step: str, total: int, listener: Listener | None, done: int = 0
    ) -> None:
        self.task, self.step, self.total, self.listener = task, step, total, listener
        self.done, self._restored, self._start = done, done, time.perf_counter()
        self._last = self._start

    def report(self, done: int, note: str = "", best: float | None = None) -> None:
        """Report that `done` steps are complete."""
        self.done, self._last = done, time.perf_counter()
        if self.listener is None:
            return
        steps, rest = done - self._restored, self.total - done
        remaining = (self._last - self._start) / steps * rest if steps and rest else None
        self.listener(Progress(self.task, self.step, done, self.total, note, best, remaining))

    def advance(self, note: str = "") -> None:
        """Report that one more step is complete."""
        self.report(self.done + 1, note)

    def finish(self) -> None:
        """Report the end of a task that needed fewer steps than expected."""
        if 0 < self.done < self.total:
            self.total = self.done
            self.report(self.done)

    def report_if_slow(self, best: float | None, note: str = "") -> None:
        """Report again if the last report was `REPORT_INTERVAL` ago."""
        if time.perf_counter() - self._last > REPORT_INTERVAL:
            self.report(self.done, note, best)
