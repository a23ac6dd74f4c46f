"""The starts of a hybrid run in a second process, while the genetic algorithm runs in the first.

The process is `python -m planter.optimise.second_process`: it is told, as JSON, which importable function makes the
problem and of what, and writes one line of JSON for each minimum as it is found, so nothing depends on what the main
module is, and nothing is lost when it is stopped. Numbers pass as text that reads back to the same bits; the minima are
those that the first process would find.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import IO, Any

import numpy as np

from planter.optimise.conditions import Look
from planter.optimise.descent import Minimum
from planter.optimise.objective import Evaluation
from planter.optimise.problem import Counts, Problem
from planter.optimise.starts import descents


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
        task = {**asdict(recipe), "seed": seed, "starts": starts}
        self._lines: IO[str] = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115 (closed by __exit__)
        paths = [path or os.getcwd() for path in sys.path]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "planter.optimise.second_process"], stdin=subprocess.PIPE, stdout=self._lines,
            stderr=subprocess.DEVNULL, text=True, start_new_session=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        )  # fmt: skip
        assert self._process.stdin is not None
        with self._process.stdin as channel:
            json.dump(task, channel)

    def __enter__(self) -> SecondProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        self._lines.close()

    def result(self) -> Report | None:
        """All minima, when the process has ended; None if it failed."""
        self._process.wait()
        report = self.so_far()
        return report if self._process.returncode == 0 and len(report.minima) == self.starts else None

    def so_far(self) -> Report:
        """The minima found until now."""
        self._lines.seek(0)
        lines = [json.loads(line) for line in self._lines if line.startswith("{") and line.endswith("\n")]
        minima = [_minimum(line) for line in lines]
        last: dict[str, Any] = lines[-1] if lines else {"counts": asdict(Counts()), "history": []}
        return Report(minima, Counts(**last["counts"]), [(int(n), float(value)) for n, value in last["history"]])


def _minimum(line: dict[str, Any]) -> Minimum:
    evaluation = Evaluation(line["evaluation"]["objective"], Look(**line["evaluation"]["look"]))
    told = {key: line[key] for key in ("residual", "iterations", "violation", "converged")}
    return Minimum(np.array(line["u"]), evaluation, **told)


def main() -> None:
    """Read the task, write the minima."""
    task = json.load(sys.stdin)
    problem = Recipe(task["function"], task["arguments"]).problem()
    for minimum in descents(problem, task["starts"], task["seed"]):
        line = {"u": minimum.u.tolist(), "evaluation": asdict(minimum.evaluation), "residual": minimum.residual,
                "iterations": minimum.iterations, "violation": minimum.violation, "converged": minimum.converged,
                "counts": asdict(problem.counts), "history": problem.history}  # fmt: skip
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
