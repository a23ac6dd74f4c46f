"""A process that optimises pairs of families: a task a line in, a result a line out, until there are no more.

What it was started by may die: then the next line cannot be written, and it ends.
"""

from __future__ import annotations

import json
import sys

from planter.errors import PlanterError
from planter.planting.compare.pair import narrow, optimised
from planter.planting.file import Machine


def main() -> None:
    for line in sys.stdin:
        task = json.loads(line)
        own = Machine.read(task["machine"], task["source"])
        try:
            pair = task["pair"]
            found = narrow(own) if pair is None else optimised(own, tuple(pair), task["starts"], task["seed"])
        except PlanterError as error:
            found = {"error": {"name": error.name, "message": error.message}}
        print(json.dumps(found, allow_nan=False), flush=True)


if __name__ == "__main__":
    main()
