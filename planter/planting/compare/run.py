"""The comparison: all pairs on all cores, each saved as soon as it is done, ranked in the end."""

from __future__ import annotations

import hashlib
import itertools
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from planter.errors import ComputationError, InputError
from planter.files.text import read_json
from planter.parallel.jobs import Jobs
from planter.parallel.task import Means, Task
from planter.planting.compare import box, pair
from planter.planting.compare.proposal import proposal
from planter.planting.file import Machine
from planter.planting.results import ComparedPair, ComparisonFound, NarrowBox
from planter.progress import Listener, ProgressPhase
from planter.report import files
from planter.report.folder import keep
from planter.version import __version__

LAYOUT = 3
"""Of the files of finished devices: those of another are not gone on from."""
Work = tuple[str, str] | None
"""A pair of families; None for the machine's own box."""


def compare(
    own: Machine,
    starts: int = 3,
    seed: int = 0,
    out: Path | None = None,
    resume: bool = False,
    pairs: Sequence[box.Pair] | None = None,
    progress: Listener | None = None,
    cores: int | None = None,
    cluster: str | None = None,
) -> ComparisonFound:
    """Devices of all pairs, feasible ones first, best first; and the machine's own narrow box beside them.

    Those that are settled come before those that are not, and only they have a `rank`.

    With `out` each finished device is a file in `out/devices`; with `resume` those that a run of the same machine,
    starts, seed and version left there are not done again. The pairs are optimised by `cores` processes, one a core if
    that is None, or by the Dask cluster at an address. Raises InputError for `resume` without `out` and for a cluster
    that does not answer, ComputationError where a pair cannot be optimised.
    """
    if resume and out is None:
        raise InputError("--resume is not allowed without --out: it must be told which folder to go on in")
    begun, machine = time.perf_counter(), box.required(own)
    chosen = list(box.pairs() if pairs is None else pairs)
    store = Store(None if out is None else files.output_folder(out / "devices"), own, starts, seed)
    tasks: list[Work] = [None, *chosen]
    done = {task: store.load(task) for task in tasks} if resume else dict.fromkeys(tasks)
    todo = [task for task in tasks if done[task] is None]
    kept = len(tasks) - len(todo)
    phase = ProgressPhase("compare", "device", len(tasks), progress, kept)
    if kept:
        phase.report(kept, "done before")

    optimised = Task(pair.prepare_pairs, {"own": own, "required": machine, "starts": starts, "seed": seed})
    with Jobs(optimised, todo, Means(cores, cluster)) as jobs:
        for answer in jobs:
            task = todo[answer.job]
            if answer.is_error:
                raise ComputationError(f"{_name(task)}: {answer.content.message}")
            store.save(task, answer.content)
            done[task] = answer.content
            phase.advance(f"{_name(task)} {_said(answer.content)}")
    ranked = _ranked([entry for task in chosen if (entry := done[task]) is not None])
    return ComparisonFound(
        machine=own.name,
        samples="refined",
        starts=starts,
        seed=seed,
        settled=sum(one.settled for one in ranked),
        devices=ranked,
        narrow=NarrowBox.read(done[None] or {}),
        proposal=proposal(machine, ranked),
        seconds=time.perf_counter() - begun,
    )


class Store:
    """Finished devices in a folder, each with a hash of its question and of its pair; nothing without a folder."""

    def __init__(self, folder: Path | None, own: Machine, starts: int, seed: int) -> None:
        self.folder = folder
        question = [LAYOUT, own.table(), box.required(own).table(), starts, seed, __version__]
        self._question = json.dumps(question, sort_keys=True)

    def _hash(self, task: Work) -> str:
        return hashlib.sha256(f"{_name(task)} {self._question}".encode()).hexdigest()

    def _is_earlier(self, task: Work, kept: dict[str, Any]) -> bool:
        """Return whether a file of the layout whose hash left the pair out answers the question for this pair."""
        stages = (kept["found"].get("stage1"), kept["found"].get("stage2"))
        asked = hashlib.sha256(self._question.encode()).hexdigest()
        return kept.get("asked") == asked and stages == (task or (None, None))

    def save(self, task: Work, found: dict[str, Any]) -> None:
        if self.folder is not None:
            files.write_summary(self.folder / f"{_name(task)}.json", {"asked": self._hash(task), "found": found})

    def load(self, task: Work) -> dict[str, Any] | None:
        """What was found of a task by the same question; None where there is none, or not whole."""
        if self.folder is None:
            return None
        try:
            kept = read_json(self.folder / f"{_name(task)}.json")
        except InputError:
            return None
        found: dict[str, Any] | None = kept.get("found")
        if found is None or not (kept.get("asked") == self._hash(task) or self._is_earlier(task, kept)):
            return None
        keep(self.folder / f"{_name(task)}.json")
        return found


def _name(task: Work) -> str:
    return "narrow" if task is None else "+".join(task)


def _said(found: dict[str, Any]) -> str:
    if found["feasible"]:
        return f"objective {found['objective']:.6g}"
    return "does not keep " + ", ".join(found["binding"])


def _ranked(devices: Sequence[dict[str, Any]]) -> list[ComparedPair]:
    places = itertools.count(1)
    found = sorted((ComparedPair.read({"rank": None, **one}) for one in devices), key=_order)
    return [replace(one, rank=next(places)) if one.settled else one for one in found]


def _order(entry: ComparedPair) -> tuple[bool, bool, int, float]:
    """Feasible ones by objective, then the others by how many requirements they break, and by how much of the first."""
    size = entry.violations[0].amount if entry.violations else entry.objective
    return not entry.feasible, not entry.settled, len(entry.violations), size
