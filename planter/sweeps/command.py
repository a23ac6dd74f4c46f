"""`planter sweep`: a plan's rows found, kept and told."""

from __future__ import annotations

import time
from pathlib import Path

from planter.parallel.task import HERE, Means
from planter.progress import Listener
from planter.report import folder
from planter.sweeps.plan import Plan
from planter.sweeps.results import SweepFound, Varied
from planter.sweeps.room import Held
from planter.sweeps.rows import Rows
from planter.sweeps.run import run
from planter.sweeps.store import open_store
from planter.sweeps.sweep import Sweep

KEPT = "sweep.sqlite"
"""The file of finished chunks in the folder of a sweep."""


def sweep(plan: Plan, out: Path | None = None, means: Means = HERE, progress: Listener | None = None) -> SweepFound:
    """The rows of a plan, in a folder if one is given: what it has of the same plan is not done again.

    Raises InputError for a plan that its machines do not fit, ComputationError where rows cannot be found, and
    Interrupted on Ctrl-C: the same call goes on then.
    """
    begun, asked = time.perf_counter(), Sweep(plan)
    recipe, drawn = asked.recipe, plan.drawn
    with folder.renewing(out):
        place = None if out is None else folder.output_folder(out) / KEPT
        with open_store(place, recipe.question, drawn.rows, len(asked.outputs)) as store:
            done = run(recipe, store, means, progress)
            rows = Rows(asked.inputs, drawn, asked.outputs, store)
            found = SweepFound(
                name=plan.name, machine=plan.machine, scheme=plan.scheme, seed=plan.seed, rows=drawn.rows,
                columns=rows.columns, hash=store.digest(), resumed=done.resumed,
                seconds=time.perf_counter() - begun, workers=done.workers, envelope=rows.envelope(),
            )  # fmt: skip
            if out is not None:
                from planter.sweeps.report import results

                results.write(out, asked, rows, found, progress)
    return found


def varied(source: str) -> Varied:
    """What of a machine can be varied and asked for. Raises InputError where there is no such machine."""
    held = Held(source)
    choices = {name: list(texts) for name, texts in held.choices.items()}
    return Varied(held.machine.name, choices, dict(held.inputs), dict(held.outputs))
