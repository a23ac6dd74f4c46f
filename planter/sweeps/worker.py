"""A process that finds chunks: a recipe, then a number a line in, a chunk a line out, until there are no more."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping

from planter.errors import PlanterError
from planter.optimise import workers
from planter.sweeps import job


def main() -> None:
    """Answers each line; an error of the job, or in making it, is an answer too."""
    told = workers.lines()
    recipe = job.read(next(told))
    task: job.Job | None = None
    for line in told:
        try:
            task = task or recipe.job()
            said = {"content": base64.b64encode(job.found(task, int(line))).decode("ascii")}
        except PlanterError as error:
            said = {"error": error.message}
        except Exception as error:  # nobody sees this process's standard error
            said = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(said), flush=True)


def content(said: Mapping[str, str]) -> bytes | str:
    """What an answer carries: a chunk, or the sentence that says why there is none."""
    return said["error"] if "error" in said else base64.b64decode(said["content"])
