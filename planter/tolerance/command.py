"""`planter tolerance`: cycles of a machine at random values within its tolerances."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.parallel.task import AUTO, Means
from planter.progress import Listener
from planter.report import folder
from planter.sweeps.room import ResolvedMachine
from planter.sweeps.run import run_job
from planter.sweeps.store import open_store
from planter.tolerance import job
from planter.tolerance.file import Tolerances
from planter.tolerance.results import Band, Share, Toleranced, ToleranceFound
from planter.tolerance.room import Room, Settings, Subject
from planter.tolerance.spread import Spread
from planter.tolerance.statistics import bands, indices

ROWS, BASE = 100_000, 2048
"""Default numbers of random machines and of points of the Sobol' indices."""


@dataclass(frozen=True)
class ToleranceRequest:
    """Request of an analysis: outputs, number of random machines, points of the indices (a power of 2, or 0), a seed.

    `robust` are the settings of the robust design, None for an analysis without it.
    """

    outputs: Sequence[str] = ()
    rows: int = ROWS
    base: int = BASE
    seed: int = 0
    robust: Settings | None = field(default_factory=Settings)


@dataclass(frozen=True)
class ToleranceCase:
    """A machine with the distributions of its inputs, and the outputs to evaluate."""

    resolved: ResolvedMachine
    choices: Mapping[str, str]
    spreads: Mapping[str, Spread]
    outputs: Sequence[str]

    @property
    def room(self) -> Room:
        """Adapter of the machine."""
        room: Room = self.resolved.room
        return room

    @property
    def subject(self) -> Subject:
        """The machine, built for inputs between the ends of their tolerances."""
        ends = {name: (spread.low, spread.high) for name, spread in self.spreads.items()}
        subject: Any = self.room.subject(self.room.frozen(self.resolved.machine), self.choices, ends, self.outputs)
        return cast(Subject, subject)

    @property
    def centre(self) -> Array:
        """Means of the inputs, (n,)."""
        return np.array([spread.centre for spread in self.spreads.values()])


@dataclass(frozen=True)
class ToleranceAnalysis:
    """Analysis of a case: outputs (m, k) of the random machines, and the result."""

    case: ToleranceCase
    rows: Array
    result: ToleranceFound


def tolerance(
    resolved: ResolvedMachine, choices: Mapping[str, str], tolerances: Tolerances, source: str,
    request: ToleranceRequest, out: Path | None = None, means: Means = AUTO, progress: Listener | None = None,
) -> ToleranceAnalysis:  # fmt: skip
    """Compute bands, indices and the robust design of a machine; `source` is the file of its tolerances, for messages.

    Rows are stored in the folder `out`, if any. Raises InputError if tolerances or outputs do not fit the machine,
    ComputationError if it has no cycles, and Interrupted on Ctrl-C, after which the same call resumes.
    """
    if request.base & (request.base - 1):
        raise InputError(f"--indices = {request.base}: the number must be a power of 2, or 0")
    started, room = time.perf_counter(), cast(Room, resolved.room)
    outputs = resolved.resolve_outputs(request.outputs or room.banded, "--output")
    case = ToleranceCase(resolved, choices, tolerances.spreads(resolved, source), outputs)
    cycles = _CycleRows(case, out, means, progress)
    rows, digest = cycles.compute("bands", request.rows, rows=request.rows, seed=request.seed)
    index_rows, shares = 0, dict[str, dict[str, Share]]()
    if request.base:
        index_rows = request.base * (len(case.spreads) + 2)
        index_outputs, index_digest = cycles.compute("indices", index_rows, base=request.base, seed=request.seed)
        shares = indices(case.outputs, list(case.spreads), index_outputs, request.base, request.seed)
        digest = hashlib.sha256(f"{digest}{index_digest}".encode()).hexdigest()
    robust = (
        None
        if request.robust is None
        else room.robust(resolved.machine, choices, case.spreads, request.robust, progress)
    )
    result = ToleranceFound(
        machine=resolved.machine.name, choices=dict(choices), seed=request.seed, rows=request.rows,
        inputs=[Toleranced(name, s.kind, s.low, s.high, s.std) for name, s in case.spreads.items()],
        index_rows=index_rows, outputs=_bands(case, rows), sobol=shares,
        seconds=time.perf_counter() - started, hash=digest, robust=robust,
    )  # fmt: skip
    return ToleranceAnalysis(case, rows, result)


@dataclass(frozen=True)
class _CycleRows:
    """Computation of rows of cycles, stored in a folder unless it is None."""

    case: ToleranceCase
    out: Path | None
    means: Means
    progress: Listener | None

    def compute(self, name: str, count: int, **sampling: int) -> tuple[Array, str]:
        """Return `count` rows of outputs at the points of `sampling`, and their hash."""
        case = self.case
        recipe = job.build_recipe(case.resolved, case.choices, case.spreads, case.outputs, **sampling)
        path = None if self.out is None else folder.output_folder(self.out) / f"{name}.sqlite"
        with open_store(path, recipe.question, count, len(case.outputs)) as store:
            run_job(recipe, store, self.means, self.progress)
            return np.vstack(list(store.blocks())), store.digest()


def _bands(case: ToleranceCase, rows: Array) -> dict[str, Band]:
    subject = case.subject
    linear = subject.slopes(case.centre)
    nominal, slopes = (subject.evaluated(case.centre[None], 1)[0], None) if linear is None else linear
    return bands(case.outputs, rows, nominal, slopes, list(case.spreads.values()))


def default_tolerances(resolved: ResolvedMachine) -> Tolerances:
    """Return the default tolerances of a machine. Raises InputError if its kind has none."""
    table = cast(Room, resolved.room).tolerances(resolved.machine)
    if not table:
        raise InputError(f"{resolved.source}: this machine has no default tolerances; add --tolerances FILE")
    return Tolerances.read({"tolerances": table}, f"{resolved.source}: default tolerances")
