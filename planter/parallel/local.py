"""Worker processes that take jobs one after another; one that ends is replaced, and its job run again."""

from __future__ import annotations

import pickle
import queue
import threading
from contextlib import suppress
from typing import Any

from planter.errors import ComputationError
from planter.parallel import worker
from planter.parallel.task import Answer
from planter.workers import Worker, WorkerEndedError

LOST = 5
"""Processes that one job may cost."""


class LocalWorkers:
    """So many processes, which put the answers of jobs into a queue as they come; each starts with its first job."""

    def __init__(self, task: bytes, count: int, answers: queue.SimpleQueue[Answer]) -> None:
        self.count, self._task, self._answers = count, task, answers
        self._jobs: queue.SimpleQueue[tuple[int, Any] | None] = queue.SimpleQueue()
        self._workers: dict[int, Worker] = {}
        self._lock, self._has_ended = threading.Lock(), False
        for place in range(count):
            threading.Thread(target=self._feed, args=(place,), daemon=True).start()

    def add(self, number: int, job: Any) -> None:
        """Have a job run as soon as a process is free."""
        self._jobs.put((number, job))

    def end(self) -> None:
        """End all processes, and start no others."""
        with self._lock:
            self._has_ended = True
            for process in self._workers.values():
                process.end()
        for _ in range(self.count):
            self._jobs.put(None)

    def _feed(self, place: int) -> None:
        """Answer one job after another; whatever happens, none stays without an answer."""
        while (entry := self._jobs.get()) is not None:
            number, job = entry
            try:
                content = self._run(place, pickle.dumps(job))
            except Exception as error:
                content = ComputationError(f"a worker process cannot run this job: {type(error).__name__}: {error}")
            self._answers.put(Answer(number, content))

    def _run(self, place: int, message: bytes) -> Any:
        """Return the result of a job, or the error instead."""
        for _ in range(LOST):
            process = self._start(place)
            with suppress(WorkerEndedError):
                return pickle.loads(process.ask(message))
        return ComputationError(
            f"{LOST} processes have ended one after another at the same job; if memory ran out, take fewer workers"
        )

    def _start(self, place: int) -> Worker:
        """Return the process of a place, a new one if the last has ended. Raises WorkerEndedError after `end`."""
        with self._lock:
            if self._has_ended:
                raise WorkerEndedError("no more processes are started")
            if place not in self._workers or not self._workers[place].is_alive:
                self._workers[place] = Worker(worker.__name__, self._task)
            return self._workers[place]
