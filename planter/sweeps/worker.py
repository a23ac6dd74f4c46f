"""A process that finds chunks: a recipe, then a number a line in, a chunk a line out, until there are no more."""

from __future__ import annotations

import base64
import json

from planter import workers
from planter.errors import PlanterError
from planter.sweeps import job


def main() -> None:
    """Answers each line; an error of the job, or in making it, is an answer too."""
    told = workers.read_lines()
    recipe = job.read(next(told))
    task: job.Job | None = None
    for line in told:
        try:
            task = task or recipe.job()
            said = base64.b64encode(job.found(task, int(line))).decode("ascii")
        except PlanterError as error:
            said = json.dumps({"error": error.message})
        except Exception as error:  # nobody sees this process's standard error
            said = json.dumps({"error": f"{type(error).__name__}: {error}"})
        print(said, flush=True)


def content(said: str) -> bytes | str:
    """What a line carries: a chunk, or the sentence that says why there is none."""
    return str(json.loads(said)["error"]) if said.startswith("{") else base64.b64decode(said)
