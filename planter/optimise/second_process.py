"""The starts of a hybrid run in a second process, while the genetic algorithm runs in the first.

The process is told, as JSON, which importable function makes the problem and of what, and writes one line of JSON for
each minimum as it is found, so nothing depends on what the main module is, and nothing is lost when it is stopped.
Numbers pass as text that reads back to the same bits; the minima are those that the first process would find.
"""

from __future__ import annotations

import importlib
import json
import subprocess
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from planter import workers
from planter.optimise.conditions import Look
from planter.optimise.descent import Minimum
from planter.optimise.objective import Evaluation
from planter.optimise.problem import Counts, Problem
from planter.optimise.starts import descents
from planter.progress import Phase

POLL = 0.2
"""Seconds between looks at what the second process has found."""


@dataclass(frozen=True)
class Recipe:
    """How another process makes a problem: a function, as "package.module:name", and its arguments, fit for JSON."""

    function: str
    arguments: Mapping[str, Any]

    def problem(self) -> Problem:
        module, name = self.function.split(":")
        made: Problem = getattr(importlib.import_module(module), name)(**self.arguments)
        return made


@dataclass(frozen=True)
class Report:
    """What the second process has found: minima, and after the last of them its counts and history."""

    minima: list[Minimum]
    counts: Counts
    history: list[tuple[int, float]]


class SecondProcess:
    """Descents in a second process. Use as a context: leaving it ends the process."""

    def __init__(self, recipe: Recipe, seed: int, starts: int) -> None:
        self.starts = starts
        self._folder = tempfile.TemporaryDirectory()
        self._lines = Path(self._folder.name) / "minima"
        with self._lines.open("w") as written:
            self._process = workers.start_worker(__name__, written)
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.write(json.dumps({**asdict(recipe), "seed": seed, "starts": starts}) + "\n")
            self._process.stdin.flush()

    def __enter__(self) -> SecondProcess:
        return self

    def __exit__(self, *_: object) -> None:
        workers.end_worker(self._process)
        self._folder.cleanup()

    def result(self, phase: Phase) -> Report | None:
        """All minima, when the process has ended; None if it failed. The phase is told of each minimum found."""
        ended = False
        while not ended:
            ended = self._ends_within(POLL)
            found = self.so_far()
            best = found.history[-1][1] if found.history else None
            if len(found.minima) > phase.done:
                phase.reached(len(found.minima), best=best)
            phase.under_way(best)
        return found if self._process.returncode == 0 and len(found.minima) == self.starts else None

    def _ends_within(self, seconds: float) -> bool:
        try:
            self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            return False
        return True

    def so_far(self) -> Report:
        """The minima found until now."""
        text = self._lines.read_text(encoding="utf-8")
        lines = [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]
        minima = [_minimum(line) for line in lines]
        last: dict[str, Any] = lines[-1] if lines else {"counts": asdict(Counts()), "history": []}
        return Report(minima, Counts(**last["counts"]), [(int(n), float(value)) for n, value in last["history"]])


def _minimum(line: dict[str, Any]) -> Minimum:
    evaluation = Evaluation(line["evaluation"]["objective"], Look(**line["evaluation"]["look"]))
    told = {key: line[key] for key in ("residual", "iterations", "violation", "converged")}
    return Minimum(np.array(line["u"]), evaluation, **told)


def main() -> None:
    """Read the task, write the minima."""
    task = json.loads(next(workers.read_lines()))
    problem = Recipe(task["function"], task["arguments"]).problem()
    for minimum in descents(problem, task["starts"], task["seed"]):
        line = {"u": minimum.u.tolist(), "evaluation": asdict(minimum.evaluation), "residual": minimum.residual,
                "iterations": minimum.iterations, "violation": minimum.violation, "converged": minimum.converged,
                "counts": asdict(problem.counts), "history": problem.history}  # fmt: skip
        print(json.dumps(line), flush=True)
