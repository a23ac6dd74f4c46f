"""A process that optimises pairs of families: a task a line in, a result a line out, until there are no more."""

from __future__ import annotations

import json

from planter import workers
from planter.errors import PlanterError
from planter.planting.compare.pair import narrow, optimised
from planter.planting.file import Machine


def main() -> None:
    for line in workers.read_lines():
        task = json.loads(line)
        try:
            own, pair = Machine.read(task["machine"], task["source"]), task["pair"]
            found = narrow(own) if pair is None else optimised(own, tuple(pair), task["starts"], task["seed"])
        except PlanterError as error:
            found = {"error": {"name": error.name, "message": error.message}}
        print(json.dumps(found, allow_nan=False), flush=True)
