"""Task whose jobs any process can run with the same results, and the main function of a worker
process.
"""

from __future__ import annotations

import os
import pickle
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, NamedTuple

from planter import workers
from planter.errors import ComputationError, InputError, PlanterError
from planter.version import __version__

_LOCK = threading.Lock()
"""Threads of one process run the jobs of most tasks in sequence because their solvers share
state.
"""


@dataclass(frozen=True)
class Means:
    """Processes that run jobs: a number of local processes, or a Dask cluster at an address
    (default: automatic).
    """

    processes: int | None = None
    cluster: str | None = None


AUTO = Means()


@dataclass(frozen=True)
class Task:
    """Function of a module with picklable arguments, which returns the function that runs a job:
    job -> result.

    With `is_thread_safe` several threads may call that function at once.
    """

    prepare: Callable[..., Callable[[Any], Any]]
    arguments: Mapping[str, Any]
    is_thread_safe: bool = False

    def to_bytes(self) -> bytes:
        """Return the task as sent to a worker, the version first: a worker of another version
        refuses the rest.
        """
        return pickle.dumps((__version__, pickle.dumps(self)))


class JobAnswer(NamedTuple):
    """Number of a job, counted from 0, and its result or error."""

    job: int
    content: Any

    @property
    def is_error(self) -> bool:
        return isinstance(self.content, PlanterError)

    @property
    def result(self) -> Any:
        """Result of the job. Raises the error of the job."""
        if self.is_error:
            raise self.content
        return self.content


def run_job(task: bytes, job: Any) -> Any:
    """Return the result of a job of a task, or the error."""
    try:
        safe, run = _prepare(task)
        if safe:
            return run(job)
        with _LOCK:
            return run(job)
    except PlanterError as error:
        return error
    except Exception as error:  # nobody reads the standard error of a worker
        return ComputationError(f"{type(error).__name__}: {error}")


@lru_cache(maxsize=2)
def _prepare(text: bytes) -> tuple[bool, Callable[[Any], Any]]:
    version, content = pickle.loads(text)
    if version != __version__:
        raise InputError(f"the worker has planter {__version__}: install {version} there as well")
    task: Task = pickle.loads(content)
    return task.is_thread_safe, task.prepare(**task.arguments)


def count_cores() -> int:
    """Return the number of cores which this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def main() -> None:
    """Run a worker process: the first message is a task, every other a job, every answer its result
    or error.
    """
    workers.serve(lambda task: partial(_answer_job, task))


def _answer_job(task: bytes, job: bytes) -> bytes:
    content = run_job(task, pickle.loads(job))
    try:
        return pickle.dumps(content)
    except Exception as error:
        return pickle.dumps(
            ComputationError(f"the result cannot be sent: {type(error).__name__}: {error}")
        )
