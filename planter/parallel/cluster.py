"""Jobs run by the workers of a Dask cluster (`planter[cluster]`); the scheduler repeats those of a lost worker."""

from __future__ import annotations

import queue
import threading
from functools import partial
from typing import TYPE_CHECKING, Any

from planter.errors import ComputationError, InputError
from planter.parallel.task import Answer, run_job

if TYPE_CHECKING:
    from distributed import Client, Future

CONNECTED_S = 5
"""Time that a scheduler may take to answer."""
AHEAD = 4
"""Jobs for each thread of the cluster that are submitted before the first of them is done."""


class ClusterWorkers:
    """The workers of a cluster, such as tcp://host:8786, which put the answers of jobs into a queue as they come.

    Raises InputError if Dask is missing, or no scheduler answers.
    """

    def __init__(self, task: bytes, address: str, answers: queue.SimpleQueue[Answer]) -> None:
        self._client, self._task, self._answers = _connect(address), task, answers
        self._jobs: queue.SimpleQueue[tuple[int, Any] | None] = queue.SimpleQueue()
        self._under_way: dict[int, Future] = {}
        self.count = len(self._client.scheduler_info(n_workers=-1)["workers"])
        self._places = threading.Semaphore(AHEAD * max(1, sum(self._client.nthreads().values())))
        threading.Thread(target=self._feed, daemon=True).start()

    def add(self, number: int, job: Any) -> None:
        """Have a job run as soon as a worker is free."""
        self._jobs.put((number, job))

    def end(self) -> None:
        """Leave the cluster, which drops what is not done."""
        self._jobs.put(None)
        self._client.close()

    def _feed(self) -> None:
        """Submit the jobs, never more than the cluster can soon take."""
        while (entry := self._jobs.get()) is not None:
            number, job = entry
            self._places.acquire()
            try:
                future = self._client.submit(run_job, self._task, job, pure=False)
                self._under_way[number] = future
                future.add_done_callback(partial(self._pass_on, number))
            except Exception as error:
                self._answer(number, ComputationError(f"the cluster has failed: {type(error).__name__}: {error}"))

    def _pass_on(self, number: int, future: Future) -> None:
        """Answer a job whose end the cluster reports, whatever it is."""
        try:
            content = future.result()
        except Exception as error:
            content = ComputationError(f"the cluster gave up job {number}: {type(error).__name__}: {error}")
        self._answer(number, content)

    def _answer(self, number: int, content: Any) -> None:
        self._under_way.pop(number, None)  # the cluster forgets what nobody refers to
        self._places.release()
        self._answers.put(Answer(number, content))


def _connect(address: str) -> Client:
    try:
        from distributed import Client
    except ImportError:
        raise InputError("--cluster needs Dask: pip install 'planter[cluster]'") from None
    try:
        return Client(address, timeout=CONNECTED_S, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        allowed = "it must be the address of a Dask scheduler that answers, as tcp://host:8786"
        raise InputError(f"--cluster = {address} is not allowed: {allowed} ({reason})") from None
