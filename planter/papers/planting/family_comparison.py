"""`optimise --all-pairs`: pairs of gear families, optimised in parallel and saved one by one, and
ranked.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from planter.engine.sections import HOLD
from planter.errors import ComputationError, InputError
from planter.jobs import Jobs
from planter.papers.planting.family_pairs import (
    Pair,
    add_requirements,
    build_pair_machine,
    list_pairs,
    prepare_pairs,
)
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.requirements import RequirementConstraints
from planter.papers.planting.results import ComparedPair, ComparisonFound, NarrowBox, Proposal
from planter.progress import Listener, ProgressPhase
from planter.report import files
from planter.report.folder import keep_file
from planter.task import Means, Task
from planter.text_files import read_json
from planter.version import __version__

LAYOUT = 3
"""Of the files of finished devices: those of another are not gone on from."""
PairTask = tuple[str, str] | None
"""A pair of families; None for the machine's own box."""


def compare_families(
    own: PlantingMachine,
    starts: int = 3,
    seed: int = 0,
    out: Path | None = None,
    resume: bool = False,
    pairs: Sequence[Pair] | None = None,
    progress: Listener | None = None,
    cores: int | None = None,
    cluster: str | None = None,
) -> ComparisonFound:
    """Return the devices of all pairs, feasible ones first, best first, and that of the machine's
    narrow bounds.

    Settled devices precede the others, and only they have a `rank`.

    With `out` each finished device is a file in `out/devices`; with `resume` those that a run of
    the same machine, starts, seed and version left there are not done again. The pairs are
    optimised by `cores` processes, one a core if that is None, or by the Dask cluster at an
    address. Raises InputError for `resume` without `out` and for a cluster that does not answer,
    ComputationError where a pair cannot be optimised.
    """
    if resume and out is None:
        raise InputError("--resume needs --out DIR, the folder of the results to continue")
    if own.measure_limits:
        reason = (
            "the comparison of families has no limits on measures; optimise the machines of "
            "pairs one by one"
        )
        raise InputError(f"{own.source}: {HOLD}: {reason}")
    begun, machine = time.perf_counter(), add_requirements(own)
    chosen = list(list_pairs() if pairs is None else pairs)
    store = ComparisonStore(
        None if out is None else files.output_folder(out / "devices"), own, starts, seed
    )
    tasks: list[PairTask] = [None, *chosen]
    done = {task: store.load(task) for task in tasks} if resume else dict.fromkeys(tasks)
    todo = [task for task in tasks if done[task] is None]
    finished = len(tasks) - len(todo)
    phase = ProgressPhase("compare", "device", len(tasks), progress, finished)
    if finished:
        phase.report(finished, "done before")

    optimised = Task(
        prepare_pairs, {"machine": own, "constrained": machine, "starts": starts, "seed": seed}
    )
    with Jobs(optimised, todo, Means(cores, cluster)) as jobs:
        for answer in jobs:
            task = todo[answer.job]
            if answer.is_error:
                raise ComputationError(f"{_name(task)}: {answer.content.message}")
            store.save(task, answer.content)
            done[task] = answer.content
            phase.advance(f"{_name(task)} {_describe_outcome(answer.content)}")
    ranked = _ranked([entry for task in chosen if (entry := done[task]) is not None])
    return ComparisonFound(
        machine=own.name,
        samples="refined",
        starts=starts,
        seed=seed,
        settled=sum(pair.settled for pair in ranked),
        devices=ranked,
        narrow=NarrowBox.read(done[None] or {}),
        proposal=build_proposal(machine, ranked),
        seconds=time.perf_counter() - begun,
    )


class ComparisonStore:
    """Finished devices in a folder, each with a hash of its question and of its pair; nothing
    without a folder.
    """

    def __init__(
        self, folder: Path | None, machine: PlantingMachine, starts: int, seed: int
    ) -> None:
        self.folder = folder
        question = [
            LAYOUT,
            machine.table(),
            add_requirements(machine).table(),
            starts,
            seed,
            __version__,
        ]
        self._question = json.dumps(question, sort_keys=True)

    def _hash(self, task: PairTask) -> str:
        return hashlib.sha256(f"{_name(task)} {self._question}".encode()).hexdigest()

    def save(self, task: PairTask, entry: dict[str, Any]) -> None:
        """Write the entry of a task."""
        if self.folder is not None:
            files.write_summary(
                self.folder / f"{_name(task)}.json", {"asked": self._hash(task), "found": entry}
            )

    def load(self, task: PairTask) -> dict[str, Any] | None:
        """Return the entry of a task for the same question, or None if it is missing or its file is
        damaged.
        """
        if self.folder is None:
            return None
        try:
            saved = read_json(self.folder / f"{_name(task)}.json")
        except InputError:
            return None
        entry: dict[str, Any] | None = saved.get("found")
        if entry is None or saved.get("asked") != self._hash(task):
            return None
        keep_file(self.folder / f"{_name(task)}.json")
        return entry


def _name(task: PairTask) -> str:
    return "narrow" if task is None else "+".join(task)


def _describe_outcome(entry: dict[str, Any]) -> str:
    if entry["feasible"]:
        return f"objective {entry['objective']:.6g}"
    return "violates " + ", ".join(entry["binding"])


def _ranked(devices: Sequence[dict[str, Any]]) -> list[ComparedPair]:
    ranks = itertools.count(1)
    pairs = sorted((ComparedPair.read({"rank": None, **device}) for device in devices), key=_order)
    return [replace(pair, rank=next(ranks)) if pair.settled else pair for pair in pairs]


def _order(entry: ComparedPair) -> tuple[bool, bool, int, float]:
    """Return the key by which feasible pairs precede, by objective, the others, by number and size
    of violations.
    """
    size = entry.violations[0].amount if entry.violations else entry.objective
    return not entry.feasible, not entry.settled, len(entry.violations), size


def build_proposal(machine: PlantingMachine, ranked: Sequence[ComparedPair]) -> Proposal | None:
    """Return the requirements that every device violates, and relaxed limits; None if a device is
    feasible.

    The limits are those that the closest device satisfies; `violation` is that device's remaining
    one under them, in steps.
    """
    if not ranked or ranked[0].feasible:
        return None
    nearest = ranked[0]
    limits = {violation.key: violation.relaxed for violation in nearest.violations}
    conflicting = set.intersection(
        *({violation.name for violation in entry.violations} for entry in ranked)
    )
    return Proposal(
        conflicting=sorted(conflicting),
        limits=limits,
        stage1=nearest.stage1,
        stage2=nearest.stage2,
        violation=compute_remaining_violation(machine, nearest, limits),
    )


def compute_remaining_violation(
    machine: PlantingMachine, entry: ComparedPair, limits: dict[str, float]
) -> float:
    """Return the largest violation [steps] of an entry's design under other limits."""
    changed = machine.with_numbers({f"requirements.{key}": value for key, value in limits.items()})
    device = Device(build_pair_machine(changed, (entry.stage1, entry.stage2)))
    x = device.scale * np.array([entry.design[name] for name in device.names])
    return RequirementConstraints(device).violation(x)
