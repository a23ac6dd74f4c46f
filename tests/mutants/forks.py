"""Tests run with a module exchanged, each time in a fork of a process that has the large libraries
loaded.

A fork starts neither Python nor SymPy nor CasADi again, and loads the project's own modules anew,
so that the module that stands in for another is in force before any that imports it.
`python -m tests.mutants.forks` reads jobs as JSON and writes an answer to each, a line each: what
catches the fault, and how long it took.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_loader
from pathlib import Path
from types import CodeType

import pytest

ROOT = Path(__file__).parents[2]
LIBRARIES = (
    "casadi",
    "hypothesis",
    "matplotlib",
    "mpmath",
    "numpy",
    "pydantic",
    "scipy.optimize",
    "sympy",
    "typer",
)
OPTIONS = ("-x", "-q", "-o", "addopts=", "--import-mode=importlib", "-m", "not long and not fault")
"""The project's own without those of plugins, none of which is loaded: it would take as long as the
tests.
"""
BYTES = 4 * 2**30


@dataclass(frozen=True)
class Job:
    """Tests to run, in this order until one fails, with another text in the place of a module's.

    What takes more than `seconds` of the processor, or asks for more memory than `BYTES`, counts as
    caught.
    """

    module: str
    text: str
    tests: tuple[str, ...]
    seconds: int = 30

    @property
    def path(self) -> Path:
        return ROOT / f"{self.module.replace('.', '/')}.py"


@dataclass(frozen=True)
class Answer:
    """The first test that fails, or the limit that is passed; nothing where all pass.

    Seconds of the processor.
    """

    by: str
    seconds: float


def answers(jobs: Sequence[Job]) -> Iterator[Answer]:
    """An answer to each job, in their order, as soon as it is there."""
    command = [sys.executable, "-m", "tests.mutants.forks"]
    with subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        with process.stdin as requests:
            json.dump([asdict(job) for job in jobs], requests)
        yield from (Answer(**json.loads(line)) for line in process.stdout)


class _Instead(SourceFileLoader, MetaPathFinder):
    """Finds a module under its name and loads another text than its file's."""

    def __init__(self, job: Job) -> None:
        super().__init__(job.module, str(job.path))
        self.text = job.text

    def find_spec(self, fullname: str, path: object, target: object = None) -> ModuleSpec | None:
        return spec_from_loader(fullname, self) if fullname == self.name else None

    def get_code(self, fullname: str) -> CodeType:
        return compile(self.text, self.path, "exec", dont_inherit=True)


class _First:
    """Remembers the first test that fails."""

    name = "collection"

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.name = report.nodeid


def _answered(job: Job) -> Answer:
    with tempfile.TemporaryFile("w+") as output:
        child = os.fork()
        if not child:
            _run(job, output.fileno())
        _, status, used = os.wait4(child, 0)
        output.seek(0)
        by = output.read() if os.WIFEXITED(status) else signal.Signals(os.WTERMSIG(status)).name
        return Answer(by, round(used.ru_utime + used.ru_stime, 2))


def _run(job: Job, answer: int) -> None:
    """The child: it ends here, whatever happens."""
    resource.setrlimit(resource.RLIMIT_CPU, (job.seconds, job.seconds + 1))
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    sys.meta_path.insert(0, _Instead(job))
    first = _First()
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    code = pytest.main([*OPTIONS, *job.tests], plugins=[first])
    if code in (pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED):
        first.name = f"no tests: {' '.join(job.tests)}"
    os.write(answer, b"" if code == pytest.ExitCode.OK else first.name.encode())
    os._exit(0)


def main(jobs: Iterable[dict[str, object]]) -> None:
    for name in LIBRARIES:
        import_module(name)
    for job in jobs:
        print(json.dumps(asdict(_answered(Job(**job)))), flush=True)


if __name__ == "__main__":
    main(json.load(sys.stdin))
