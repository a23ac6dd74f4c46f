"""Chunks found by the workers of a Dask cluster (`planter[cluster]`); the scheduler gives those of a lost one again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from planter.errors import ComputationError, InputError, PlanterError
from planter.sweeps import job
from planter.sweeps.job import Job, Recipe
from planter.sweeps.pool import Answer

if TYPE_CHECKING:
    from distributed import Client

CONNECTED_S = 5
"""How long a scheduler may take to answer."""
AHEAD = 4
"""Chunks for each thread of the cluster that are handed over before the first of them is done."""


def answers(recipe: Recipe, chunks: Sequence[int], address: str) -> Iterator[Answer]:
    """Chunks as they are found by the cluster at an address, such as tcp://host:8786.

    Raises InputError where Dask is missing, or where no scheduler answers.
    """
    client = _client(address)
    try:
        yield from _streamed(client, recipe.text, chunks)
    finally:
        client.close()


def workers(address: str) -> int:
    """Workers of the cluster at an address. Raises as `answers`."""
    client = _client(address)
    try:
        return len(client.scheduler_info(n_workers=-1)["workers"])
    finally:
        client.close()


def _client(address: str) -> Client:
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


def _streamed(client: Client, text: str, chunks: Sequence[int]) -> Iterator[Answer]:
    """No more chunks are on the way than the cluster can soon take."""
    from distributed import as_completed

    most = AHEAD * max(1, sum(client.nthreads().values()))
    rest = iter(chunks)
    under_way = as_completed(loop=client.loop)
    for number, _ in zip(rest, range(most), strict=False):
        under_way.add(_submitted(client, text, number))
    for future in under_way:
        yield _result(future)
        for number in rest:
            under_way.add(_submitted(client, text, number))
            break


def _submitted(client: Client, text: str, number: int) -> Any:
    key = f"planter-{job.read(text).question[:16]}-{number}"
    return client.submit(answered, text, number, key=key, pure=False)


def _result(future: Any) -> Answer:
    """What the cluster found. Raises ComputationError where it gave up."""
    try:
        found: Answer = future.result()
    except Exception as error:
        raise ComputationError(f"the cluster did not find {future.key}: {type(error).__name__}: {error}") from error
    return found


def answered(text: str, number: int) -> Answer:
    """On a worker: a chunk of the job of a recipe."""
    try:
        return number, job.found(_job(text), number)
    except PlanterError as error:
        return number, error.message


@lru_cache(maxsize=2)
def _job(text: str) -> Job:
    return job.read(text).job()
