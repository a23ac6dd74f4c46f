"""Worker processes that take chunks one after another; one that is killed is replaced, and its chunk found again."""

from __future__ import annotations

import queue
import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from planter import workers
from planter.errors import ComputationError
from planter.sweeps import worker
from planter.sweeps.job import Recipe

LOST = 5
"""Processes that one chunk may cost."""
Answer = tuple[int, bytes | str]
"""A chunk's number and its content, or the sentence that says why there is none."""


def answers(recipe: Recipe, chunks: Sequence[int], processes: int) -> Iterator[Answer]:
    """Chunks as they are found, by so many processes; leaving the loop early ends these."""
    waiting: queue.SimpleQueue[int] = queue.SimpleQueue()
    for number in chunks:
        waiting.put(number)
    found: queue.SimpleQueue[Answer] = queue.SimpleQueue()
    with _hands(recipe, min(processes, len(chunks))) as hands:
        for hand in hands:
            threading.Thread(target=hand.work, args=(waiting, found), daemon=True).start()
        for _ in chunks:
            yield found.get()


@contextmanager
def _hands(recipe: Recipe, count: int) -> Iterator[list[Hand]]:
    hands = [Hand(recipe) for _ in range(count)]
    try:
        yield hands
    finally:
        for hand in hands:
            hand.end()


class Hand:
    """A worker process, and another in its place when it has ended."""

    def __init__(self, recipe: Recipe) -> None:
        self._recipe, self._lock, self._ended = recipe, threading.Lock(), False
        self._process = self._started()

    def _started(self) -> subprocess.Popen[str]:
        process = workers.start_worker(worker.__name__, subprocess.PIPE, workers.ONE_THREAD)
        self._tell(process, self._recipe.text)
        return process

    @staticmethod
    def _tell(process: subprocess.Popen[str], line: str) -> None:
        assert process.stdin is not None
        try:
            process.stdin.write(f"{line}\n")
            process.stdin.flush()
        except (OSError, ValueError):
            return  # it has ended: so will its output

    def work(self, waiting: queue.SimpleQueue[int], found: queue.SimpleQueue[Answer]) -> None:
        """Take chunks until there are none."""
        while True:
            try:
                number = waiting.get_nowait()
            except queue.Empty:
                return
            try:
                found.put((number, self._asked(number)))
            except ComputationError as error:
                found.put((number, error.message))
                return

    def _asked(self, number: int) -> bytes | str:
        for _ in range(LOST):
            line = self._line(number)
            if line.endswith("\n"):
                return worker.content(line)
            with self._lock:
                if self._ended:
                    raise ComputationError("the worker processes were ended")
                workers.end_worker(self._process)
                self._process = self._started()
        raise ComputationError(f"chunk {number}: {LOST} processes have ended while they worked on it")

    def _line(self, number: int) -> str:
        self._tell(self._process, str(number))
        assert self._process.stdout is not None
        try:
            return self._process.stdout.readline()
        except (OSError, ValueError):
            return ""

    def end(self) -> None:
        """End the process, and start no other."""
        with self._lock:
            self._ended = True
            workers.end_worker(self._process)
