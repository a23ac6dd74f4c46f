"""`planter tolerance`: turns of a machine as its tolerances make it."""

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
from planter.parallel.task import HERE, Means
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
"""Turns that are drawn, and points that Sobol' indices rest on."""


@dataclass(frozen=True)
class Asked:
    """What is asked for: outputs, turns, points for the indices (a power of 2, or none), a robust design."""

    outputs: Sequence[str] = ()
    rows: int = ROWS
    base: int = BASE
    seed: int = 0
    robust: Settings | None = field(default_factory=Settings)


@dataclass(frozen=True)
class Spreading:
    """A machine whose inputs spread, and the outputs that are watched."""

    held: ResolvedMachine
    choices: Mapping[str, str]
    spreads: Mapping[str, Spread]
    outputs: Sequence[str]

    @property
    def room(self) -> Room:
        found: Room = self.held.room
        return found

    @property
    def subject(self) -> Subject:
        """The machine between the ends of its tolerances."""
        ends = {name: (one.low, one.high) for name, one in self.spreads.items()}
        made: Any = self.room.subject(self.room.frozen(self.held.machine), self.choices, ends, self.outputs)
        found: Subject = made
        return found

    @property
    def centre(self) -> Array:
        """Means of the inputs, (n,)."""
        return np.array([one.centre for one in self.spreads.values()])


@dataclass(frozen=True)
class Tolerance:
    """What was found of a machine: the turns that were drawn, (m, k), and the result."""

    of: Spreading
    rows: Array
    result: ToleranceFound


def tolerance(
    held: ResolvedMachine, choices: Mapping[str, str], tolerances: Tolerances, source: str, asked: Asked,
    out: Path | None = None, means: Means = HERE, progress: Listener | None = None,
) -> Tolerance:  # fmt: skip
    """Bands, indices and the robust design of a machine; `source` names where its tolerances stand.

    With a folder, turns are kept there as they are found. Raises InputError for what does not fit the machine,
    ComputationError where it has no turns, Interrupted on Ctrl-C: the same call goes on then.
    """
    if asked.base & (asked.base - 1):
        raise InputError(f"--indices = {asked.base} is not allowed: it must be a power of 2, or 0")
    begun, room = time.perf_counter(), cast(Room, held.room)
    of = Spreading(
        held, choices, tolerances.spreads(held, source), held.resolve_outputs(asked.outputs or room.banded, "--output")
    )
    turns = _Turns(of, out, means, progress)
    rows, digest = turns.found("bands", asked.rows, rows=asked.rows, seed=asked.seed)
    index_rows, shares = 0, dict[str, dict[str, Share]]()
    if asked.base:
        index_rows = asked.base * (len(of.spreads) + 2)
        mixed, more = turns.found("indices", index_rows, base=asked.base, seed=asked.seed)
        shares = indices(of.outputs, list(of.spreads), mixed, asked.base, asked.seed)
        digest = hashlib.sha256(f"{digest}{more}".encode()).hexdigest()
    robust = None if asked.robust is None else room.robust(held.machine, choices, of.spreads, asked.robust, progress)
    result = ToleranceFound(
        machine=held.machine.name, choices=dict(choices), seed=asked.seed, rows=asked.rows, index_rows=index_rows,
        inputs=[Toleranced(name, one.kind, one.low, one.high, one.std) for name, one in of.spreads.items()],
        outputs=_bands(of, rows), sobol=shares, seconds=time.perf_counter() - begun, hash=digest, robust=robust,
    )  # fmt: skip
    return Tolerance(of, rows, result)


@dataclass(frozen=True)
class _Turns:
    """Finds turns, in a folder if there is one."""

    of: Spreading
    out: Path | None
    means: Means
    progress: Listener | None

    def found(self, name: str, count: int, **drawn: int) -> tuple[Array, str]:
        """So many rows of outputs, as `drawn` says, and their hash."""
        of = self.of
        recipe = job.recipe(of.held, of.choices, of.spreads, of.outputs, **drawn)
        place = None if self.out is None else folder.output_folder(self.out) / f"{name}.sqlite"
        with open_store(place, recipe.question, count, len(of.outputs)) as store:
            run_job(recipe, store, self.means, self.progress)
            return np.vstack(list(store.blocks())), store.digest()


def _bands(of: Spreading, rows: Array) -> dict[str, Band]:
    told = of.subject.slopes(of.centre)
    nominal, slopes = (of.subject.evaluated(of.centre[None], 1)[0], None) if told is None else told
    return bands(of.outputs, rows, nominal, slopes, list(of.spreads.values()))


def usual(held: ResolvedMachine) -> Tolerances:
    """The tolerances of a machine where none are given. Raises InputError where none can be assumed."""
    table = cast(Room, held.room).tolerances(held.machine)
    if not table:
        raise InputError(f"{held.source}: no tolerances can be assumed of it: --tolerances FILE must give them")
    return Tolerances.read({"tolerances": table}, f"{held.source}: usual tolerances")
