"""Jobs run by the workers of a Dask cluster (`planter[cluster]`); the scheduler repeats those of a lost worker."""

from __future__ import annotations

import hashlib
import pickle
import queue
import threading
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from planter.errors import ComputationError, InputError
from planter.parallel.task import Answer, run_job

if TYPE_CHECKING:
    from distributed import Client

CONNECTED_S = 5
"""Time that a scheduler may take to answer."""
AHEAD = 4
"""Jobs for each thread of the cluster that are submitted before the first of them is done."""


class ClusterWorkers:
    """The workers of a cluster, such as tcp://host:8786, which put the answers of all jobs into a queue as they come.

    Raises InputError if Dask is missing, or no scheduler answers.
    """

    def __init__(self, task: bytes, jobs: Sequence[Any], address: str, answers: queue.SimpleQueue[Answer]) -> None:
        self._client, self._task, self._jobs, self._answers = _connect(address), task, jobs, answers
        self._hash = hashlib.sha256(pickle.dumps((task, list(jobs)))).hexdigest()[:16]
        self.count = len(self._client.scheduler_info(n_workers=-1)["workers"])
        threading.Thread(target=self._feed, daemon=True).start()

    def end(self) -> None:
        """Leave the cluster, which drops what is not done."""
        self._client.close()

    def _feed(self) -> None:
        """Pass all answers on; a cluster that fails is the answer to the jobs that are left."""
        left = dict.fromkeys(range(len(self._jobs)))
        try:
            for answer in self._stream():
                del left[answer.job]
                self._answers.put(answer)
        except Exception as error:
            failure = ComputationError(f"the cluster has failed: {type(error).__name__}: {error}")
            for number in left:
                self._answers.put(Answer(number, failure))

    def _stream(self) -> Iterator[Answer]:
        """Submit the jobs, never more than the cluster can soon take, and yield their answers."""
        from distributed import as_completed

        most = AHEAD * max(1, sum(self._client.nthreads().values()))
        under_way, rest = as_completed(loop=self._client.loop), iter(range(len(self._jobs)))
        for number, _ in zip(rest, range(most), strict=False):
            under_way.add(self._submit(number))
        for future in under_way:
            yield _read_answer(future)
            for number in rest:
                under_way.add(self._submit(number))
                break

    def _submit(self, number: int) -> Any:
        key = f"planter-{self._hash}-{number}"
        return self._client.submit(run_job, self._task, self._jobs[number], key=key, pure=False)


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


def _read_answer(future: Any) -> Answer:
    """Return the answer of a job; an error if the cluster gave it up."""
    number = int(future.key.rpartition("-")[2])
    try:
        return Answer(number, future.result())
    except Exception as error:
        return Answer(number, ComputationError(f"the cluster gave up job {number}: {type(error).__name__}: {error}"))
