"""`planter sweep`: compute the rows of a plan, store and report them."""

from __future__ import annotations

import time
from pathlib import Path

from planter.progress import Listener
from planter.report import folder
from planter.report.presentation import ResultPresentation
from planter.rows.sweeps.adapter import ResolvedMachine
from planter.rows.sweeps.job import open_store, run_job
from planter.rows.sweeps.plan import Plan
from planter.rows.sweeps.presentation import present_sweep
from planter.rows.sweeps.results import SweepFound, Varied
from planter.rows.sweeps.sweep import Rows, Sweep, write_rows
from planter.task import AUTO, Means

STORE_NAME = "sweep.sqlite"
"""The file of finished chunks in the folder of a sweep."""


def compute_sweep(
    plan: Plan, out: Path | None = None, means: Means = AUTO, progress: Listener | None = None
) -> ResultPresentation:
    """Compute the rows of a plan and return their presentation, which is written to the folder
    `out`, if any.

    Finished chunks of the same plan in that folder are reused.

    Raises InputError if the plan does not fit its machines, ComputationError if rows cannot be
    computed, and Interrupted on Ctrl-C, after which the same call resumes.
    """
    started, request = time.perf_counter(), Sweep(plan)
    recipe, points = request.recipe, plan.sample_points
    with folder.renew_files(out):
        path = None if out is None else folder.output_folder(out) / STORE_NAME
        with open_store(path, recipe.question, points.rows, len(request.outputs)) as store:
            outcome = run_job(recipe, store, means, progress)
            rows = Rows(request.inputs, points, request.outputs, store)
            result = SweepFound(
                name=plan.name,
                machine=plan.machine,
                scheme=plan.scheme,
                seed=plan.seed,
                rows=points.rows,
                columns=rows.columns,
                hash=store.digest(),
                resumed=outcome.resumed,
                seconds=time.perf_counter() - started,
                workers=outcome.workers,
                envelope=rows.envelope(),
            )
            presentation = present_sweep(request, result, rows)
            if out is not None:
                scheme = f"scheme: {plan.scheme}, seed {plan.seed}"
                names = [f"sweep: {plan.name}", f"machine: {', '.join(plan.machine)}"]
                write_rows(
                    out, rows, [*names, scheme, f"hash of the numbers: {result.hash}"], progress
                )
                presentation.write(out, progress)
    return presentation


def list_inputs(source: str) -> Varied:
    """List the inputs and outputs of a machine. Raises InputError if there is no such machine."""
    resolved = ResolvedMachine(source)
    choices = {name: list(texts) for name, texts in resolved.adapter.choices.items()}
    return Varied(resolved.machine.name, choices, dict(resolved.inputs), dict(resolved.outputs))
