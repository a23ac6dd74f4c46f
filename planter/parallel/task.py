"""A task that any process can prepare, whose jobs have the same results wherever they are run."""

from __future__ import annotations

import os
import pickle
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from planter.errors import ComputationError, InputError, PlanterError
from planter.version import __version__

_LOCK = threading.Lock()
"""Threads of one process run the jobs of most tasks one after another: their solvers share state."""


@dataclass(frozen=True)
class Means:
    """What runs the jobs: so many processes of this computer, or the Dask cluster at an address; None: as it pays."""

    processes: int | None = None
    cluster: str | None = None


HERE = Means()


@dataclass(frozen=True)
class Task:
    """A function of a module and its arguments, of which pickles can be made.

    It returns the function that runs a job: job -> result. With `is_thread_safe` several threads may call that at once.
    """

    prepare: Callable[..., Callable[[Any], Any]]
    arguments: Mapping[str, Any]
    is_thread_safe: bool = False

    def to_bytes(self) -> bytes:
        """Return the task as a worker reads it: only one of the same version of planter reads more than that."""
        return pickle.dumps((__version__, pickle.dumps(self)))


class Answer(NamedTuple):
    """The number of a job, counted from 0, and its result or the error instead of it."""

    job: int
    content: Any

    @property
    def is_error(self) -> bool:
        return isinstance(self.content, PlanterError)

    @property
    def result(self) -> Any:
        """The result. Raises the error of the job."""
        if self.is_error:
            raise self.content
        return self.content


def run_job(task: bytes, job: Any) -> Any:
    """Return the result of a job of a task; the error instead if there is one."""
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
        raise InputError(f"the worker has planter {__version__}: install {version} there, as it is here")
    task: Task = pickle.loads(content)
    return task.is_thread_safe, task.prepare(**task.arguments)


def count_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
