"""A process that runs jobs: the first message is a task, each other one a job, each answer its result or error."""

from __future__ import annotations

import pickle
from functools import partial

from planter import workers
from planter.errors import ComputationError
from planter.parallel.task import run_job


def main() -> None:
    """Run jobs until there are no more."""
    workers.serve(lambda task: partial(_answer, task))


def _answer(task: bytes, job: bytes) -> bytes:
    content = run_job(task, pickle.loads(job))
    try:
        return pickle.dumps(content)
    except Exception as error:
        return pickle.dumps(ComputationError(f"the result cannot be sent: {type(error).__name__}: {error}"))
