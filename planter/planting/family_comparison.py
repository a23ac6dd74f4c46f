"""`planter compare`: all pairs of gear families, optimised in parallel and saved one by one, ranked and as tables."""

from __future__ import annotations

import hashlib
import itertools
import json
import textwrap
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from planter.errors import ComputationError, InputError
from planter.files.text import read_json
from planter.parallel.jobs import Jobs
from planter.parallel.task import Means, Task
from planter.planting import family_pairs as box
from planter.planting.design_results import COMPARED, list_largest_loads
from planter.planting.file import Machine
from planter.planting.model import Device
from planter.planting.requirements import RequirementConstraints
from planter.planting.results import ComparedPair, ComparisonFound, NarrowBox, Proposal
from planter.progress import Listener, ProgressPhase
from planter.report import files
from planter.report.folder import keep
from planter.terminal.console import Console
from planter.version import __version__

LAYOUT = 3
"""Of the files of finished devices: those of another are not gone on from."""
Work = tuple[str, str] | None
"""A pair of families; None for the machine's own box."""


def compare_families(
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
    store = ComparisonStore(None if out is None else files.output_folder(out / "devices"), own, starts, seed)
    tasks: list[Work] = [None, *chosen]
    done = {task: store.load(task) for task in tasks} if resume else dict.fromkeys(tasks)
    todo = [task for task in tasks if done[task] is None]
    kept = len(tasks) - len(todo)
    phase = ProgressPhase("compare", "device", len(tasks), progress, kept)
    if kept:
        phase.report(kept, "done before")

    optimised = Task(box.prepare_pairs, {"own": own, "required": machine, "starts": starts, "seed": seed})
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


class ComparisonStore:
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


def proposal(machine: Machine, ranked: Sequence[ComparedPair]) -> Proposal | None:
    """None where a device is feasible; else the requirements that every device breaks, and relaxed limits.

    The limits are those that the nearest device keeps; `violation` is what is left of that device's, in steps,
    under them.
    """
    if not ranked or ranked[0].feasible:
        return None
    nearest = ranked[0]
    limits = {one.key: one.relaxed for one in nearest.violations}
    everywhere = set.intersection(*({one.name for one in entry.violations} for entry in ranked))
    return Proposal(
        conflicting=sorted(everywhere),
        limits=limits,
        stage1=nearest.stage1,
        stage2=nearest.stage2,
        violation=left(machine, nearest, limits),
    )


def left(machine: Machine, entry: ComparedPair, limits: dict[str, float]) -> float:
    """The largest violation [steps] of an entry's design once limits are set anew."""
    changed = machine.with_numbers({f"requirements.{key}": value for key, value in limits.items()})
    device = Device(box.described(changed, (entry.stage1, entry.stage2)))
    x = device.scale * np.array([entry.design[name] for name in device.names])
    return RequirementConstraints(device).violation(x)


WIDTH = 80
HEADER = ("", "sun, gear 6", "objective", "range / N", "var. / N2", "KKT")


def show_comparison(console: Console, result: ComparisonFound) -> None:
    """Devices by rank, those that are not settled apart, the narrow box, and what conflicts."""
    devices = result.devices
    settled, others = ([one for one in devices if one.settled is is_settled] for is_settled in (True, False))
    _say(describe_comparison(result))
    narrow = result.narrow
    own = ("-", "the paper's narrow box", *_numbers(narrow))
    rows = [(str(one.rank), pair_name(one), *_numbers(one)) for one in settled]
    console.table(f"{result.machine}: settled pairs, true extremes and integrals", HEADER, [*rows, own])
    if others:
        console.table("Not settled, the best points that were reached", HEADER,
                      [("?", pair_name(one), *_numbers(one)) for one in others])  # fmt: skip
    borne = [(str(one.rank or "?"), pair_name(one), *list_largest_loads(one.designer)) for one in devices]
    console.table("What each has to bear, largest over a turn", ("", "sun, gear 6", *COMPARED), borne)
    for one in devices:
        _say(f"{pair_name(one)}: {'; '.join(describe_pair(one))}")
    _say("")
    found = result.proposal
    if found is not None:
        told_of = ", ".join(found.conflicting) or "no single one"
        limits = ", ".join(f"{key} = {value:.6g}" for key, value in found.limits.items())
        _say(f"No pair keeps all requirements; every pair breaks: {told_of}.")
        _say(f"{found.stage1} with {found.stage2} keeps them with {limits}.")
    _say(f"{result.seconds:.3g} s")


def describe_comparison(result: ComparisonFound) -> str:
    """How many pairs are settled, and what that means."""
    return (
        f"{result.settled} of {len(result.devices)} pairs are settled: a KKT residual below 1e-6 and a second "
        "start that agrees, or a violation that is least to first order. The others are only the best points reached."
    )


def pair_name(entry: ComparedPair) -> str:
    return f"{entry.stage1}, {entry.stage2}".replace("_", " ")


def describe_pair(entry: ComparedPair) -> Iterator[str]:
    """What holds an entry or is broken by it, and what it lacks to be settled."""
    amounts = [f"{one.name} by {one.amount:.3g} {one.unit}" for one in entry.violations]
    names = ", ".join(amounts or entry.binding)
    yield f"{'held by' if entry.feasible else 'breaks'} {names}" if names else "all kept"
    if entry.lacks:
        yield f"lacks {' and '.join(entry.lacks)}"


def _numbers(entry: ComparedPair | NarrowBox) -> tuple[str, str, str, str]:
    residual = getattr(entry, "kkt_residual", None)
    numbers = (f"{value:.5g}" for value in (entry.objective, entry.range_N, entry.variance_N2))
    objective, span, variance = numbers
    return objective, span, variance, "-" if residual is None else f"{residual:.0e}"


def _say(text: str) -> None:
    print(textwrap.fill(text, WIDTH, subsequent_indent="    "))
