"""Jobs of a task, run by worker processes or a Dask cluster, with their results in order of
completion or of the jobs.

A worker process that ends is replaced and its job repeated; on a cluster (`planter[cluster]`) the
scheduler does this.
"""

from __future__ import annotations

import pickle
import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from planter.errors import ComputationError, InputError
from planter.task import AUTO, JobAnswer, Means, Task, count_cores, run_job
from planter.workers import Worker, WorkerEndedError

if TYPE_CHECKING:
    from distributed import Client


MAX_LOST_PROCESSES = 5
"""Number of ended processes after which a job fails."""


class Workers:
    """Threads that put the answers of jobs into a queue, each by a worker of its own."""

    def __init__(self, threads: int, answers: queue.SimpleQueue[JobAnswer]) -> None:
        self._answers, self._threads = answers, threads
        self._jobs: queue.SimpleQueue[tuple[int, Any] | None] = queue.SimpleQueue()
        for place in range(threads):
            threading.Thread(target=self._feed, args=(place,), daemon=True).start()

    def add(self, number: int, job: Any) -> None:
        """Queue a job for the next free worker."""
        self._jobs.put((number, job))

    def end(self) -> None:
        """End all threads once their jobs have answers."""
        for _ in range(self._threads):
            self._jobs.put(None)

    def run(self, place: int, job: Any) -> Any:
        """Return the result of a job by the worker with an index, or the error."""
        raise NotImplementedError

    def _feed(self, place: int) -> None:
        """Answer one job after another; every job gets an answer, whatever fails."""
        while (entry := self._jobs.get()) is not None:
            number, job = entry
            try:
                content = self.run(place, job)
            except Exception as error:
                content = ComputationError(
                    f"a worker cannot run job {number}: {type(error).__name__}: {error}"
                )
            self._answers.put(JobAnswer(number, content))


class LocalWorkers(Workers):
    """A number of processes, each started with its first job."""

    def __init__(self, task: bytes, count: int, answers: queue.SimpleQueue[JobAnswer]) -> None:
        self.count, self._task = count, task
        self._processes: dict[int, Worker] = {}
        self._lock, self._has_ended = threading.Lock(), False
        super().__init__(count, answers)

    def end(self) -> None:
        """End all processes."""
        with self._lock:
            self._has_ended = True
            for process in self._processes.values():
                process.end()
        super().end()

    def run(self, place: int, job: Any) -> Any:
        """Return the result of a job, or the error; a process that ends is replaced."""
        message = pickle.dumps(job)
        for _ in range(MAX_LOST_PROCESSES):
            process = self._start(place)
            with suppress(WorkerEndedError):
                return pickle.loads(process.ask(message))
        count = MAX_LOST_PROCESSES
        return ComputationError(
            f"{count} worker processes ended at the same job; if memory ran out, use fewer workers"
        )

    def _start(self, place: int) -> Worker:
        """Return the process with an index, a new one if the last has ended.

        Raises WorkerEndedError after `end`.
        """
        with self._lock:
            if self._has_ended:
                raise WorkerEndedError("the workers have been ended")
            if place not in self._processes or not self._processes[place].is_alive:
                self._processes[place] = Worker(run_job.__module__, self._task)
            return self._processes[place]


CONNECT_TIMEOUT_S = 5
"""Maximum response time of a scheduler."""
QUEUE_PER_THREAD, MOST_AHEAD = 4, 512
"""Number of jobs per thread of the cluster, and of all, that are submitted ahead."""


class ClusterWorkers(Workers):
    """Workers of a cluster, such as tcp://host:8786.

    Raises InputError if Dask is missing or no scheduler answers.
    """

    def __init__(self, task: bytes, address: str, answers: queue.SimpleQueue[JobAnswer]) -> None:
        self._client, self._task = _connect(address), task
        self.count = len(self._client.scheduler_info(n_workers=-1)["workers"])
        ahead = QUEUE_PER_THREAD * sum(self._client.nthreads().values())
        super().__init__(min(max(ahead, 1), MOST_AHEAD), answers)

    def run(self, place: int, job: Any) -> Any:
        """Return the result of a job."""
        return self._client.submit(run_job, self._task, job, pure=False).result()

    def end(self) -> None:
        """Disconnect from the cluster, which drops the unfinished jobs."""
        super().end()
        self._client.close()


def _connect(address: str) -> Client:
    try:
        from distributed import Client
    except ImportError:
        raise InputError("--cluster needs Dask: pip install 'planter[cluster]'") from None
    try:
        return Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        allowed = "it must be the address of a Dask scheduler that answers, as tcp://host:8786"
        raise InputError.for_value("--cluster", address, f"{allowed} ({reason})") from None


POLL_INTERVAL_S = 0.2
"""Time between two calls of a function that follows the progress."""
MIN_PARALLEL_S = 10.0
"""Estimated remaining time in this process above which worker processes are started."""
Result = TypeVar("Result")


class Jobs:
    """Jobs of a task, run by worker processes or a cluster until the context is left.

    Raises InputError as `ClusterWorkers`.
    """

    def __init__(self, task: Task, jobs: Sequence[Any] = (), means: Means = AUTO) -> None:
        self._answers: queue.SimpleQueue[JobAnswer] = queue.SimpleQueue()
        self._pending: dict[int, JobAnswer] = {}
        self.count = self._taken = 0
        text, processes = task.to_bytes(), means.processes or count_cores()
        self._workers: LocalWorkers | ClusterWorkers
        if means.cluster is not None:
            self._workers = ClusterWorkers(text, means.cluster, self._answers)
        else:
            self._workers = LocalWorkers(
                text, min(processes, len(jobs)) if jobs else processes, self._answers
            )
        self.add(jobs)

    def add(self, jobs: Sequence[Any]) -> None:
        """Queue more jobs."""
        for job in jobs:
            self._workers.add(self.count, job)
            self.count += 1

    @property
    def workers(self) -> int:
        """Number of worker processes or of workers of the cluster."""
        return self._workers.count

    def __enter__(self) -> Jobs:
        return self

    def __exit__(self, *_: object) -> None:
        self._workers.end()

    def __iter__(self) -> Iterator[JobAnswer]:
        """Yield the answers in order of completion."""
        for _ in range(self.count):
            yield self._answers.get()

    def in_order(self, waiting: Callable[[], None] | None = None) -> Iterator[Any]:
        """Yield each result once, in the order of the jobs; `waiting` is called repeatedly until
        the next is there.

        Raises the first error of a job.
        """
        while self._taken < self.count:
            while self._taken not in self._pending:
                with suppress(queue.Empty):
                    answer = self._answers.get(timeout=POLL_INTERVAL_S)
                    self._pending[answer.job] = answer
                if waiting is not None:
                    waiting()
            answer = self._pending.pop(self._taken)
            self._taken += 1
            yield answer.result


def run_in_order(
    task: Task | None,
    jobs: Sequence[Any],
    means: Means,
    run: Callable[[Any], Result],
    take: Callable[[Any], Result],
    waiting: Callable[[], None] | None = None,
) -> Iterator[Result]:
    """Yield the results of jobs in their order: `run` runs one in this process, `take` receives a
    worker's result.

    Without explicit `means`, workers are started if the rest would take longer than
    `MIN_PARALLEL_S` in this process. Without a task everything runs in this process.
    """
    done, begun = 0, time.perf_counter()
    while done < len(jobs) and (task is None or means == AUTO):
        left = len(jobs) - done
        seconds = (time.perf_counter() - begun) / max(done, 1) * left
        if (
            task is not None
            and done
            and left > 1
            and seconds > MIN_PARALLEL_S
            and count_cores() > 1
        ):
            break
        yield run(jobs[done])
        done += 1
    if task is not None and done < len(jobs):
        with Jobs(task, jobs[done:], means) as under_way:
            yield from map(take, under_way.in_order(waiting))
