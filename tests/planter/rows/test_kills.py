"""Drivers and workers killed by signal 9 at random moments: the answer is that of an undisturbed
run.
"""

import os
import random
import sqlite3
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from planter.rows.job import CHUNK, Recipe

pytestmark = pytest.mark.fault
ROOT = Path(__file__).parents[3]
ROWS = 12 * CHUNK
FOUND = """\
import json, sys
from pathlib import Path
from planter.task import Means
from planter.rows import job
recipe = job.Recipe(**json.load(sys.stdin))
with job.Store(Path(sys.argv[1]), recipe.question, int(sys.argv[2]), int(sys.argv[3])) as kept:
    done = job.run_job(recipe, kept, Means(2))
    print(kept.digest(), done.resumed)
"""
"""A job in a process of its own, kept in the file that it is told."""


class Killed:
    """Runs of one job, each kept in a file of its own, disturbed or not."""

    def __init__(self, folder: Path, recipe: Recipe, width: int) -> None:
        self.folder, self.recipe, self.width = folder, recipe, width
        self.complete, _ = self.ended(self.started("whole"))

    def started(self, name: str) -> psutil.Popen:
        command = [sys.executable, "-c", FOUND, name, str(ROWS), str(self.width)]
        process = psutil.Popen(
            command,
            cwd=self.folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
        process.stdin.write(self.recipe.text)
        process.stdin.close()
        return process

    @staticmethod
    def ended(process: psutil.Popen) -> tuple[str, int]:
        """Hash of all rows, and how many chunks were there before."""
        output = process.stdout.read()
        assert process.wait() == 0
        digest, resumed = output.split()
        return digest, int(resumed)

    def chunks(self, name: str) -> int:
        with suppress(sqlite3.Error):
            place = f"file:{self.folder / name}?mode=ro"
            return int(
                sqlite3.connect(place, uri=True)
                .execute("SELECT count(*) FROM chunks")
                .fetchone()[0]
            )
        return 0

    def driver(self, name: str, rng: random.Random) -> None:
        """The first process killed by signal 9 at a random moment: its workers end, what it had
        found is there.
        """
        process = self.started(name)
        workers = self.disturbed(process, name, rng)
        process.kill()
        process.wait()
        assert not psutil.wait_procs(workers, timeout=10)[1]
        finished = self.chunks(name)
        digest, resumed = self.ended(self.started(name))
        assert (digest, resumed) == (self.complete, finished)

    def worker(self, name: str, rng: random.Random) -> None:
        """A worker killed by signal 9 at a random moment: another takes its chunk."""
        process = self.started(name)
        for victim in self.disturbed(process, name, rng)[:1]:
            with suppress(psutil.NoSuchProcess):
                victim.kill()
        assert self.ended(process)[0] == self.complete

    def disturbed(
        self, process: psutil.Popen, name: str, rng: random.Random
    ) -> list[psutil.Process]:
        """The workers of a process at a random moment of its work."""
        chunks = rng.randrange(1, 10)
        while self.chunks(name) < chunks and process.poll() is None:
            time.sleep(0.005)
        time.sleep(rng.uniform(0, 0.05))
        return process.children()


@pytest.fixture(scope="module")
def counted(tmp_path_factory: pytest.TempPathFactory) -> Killed:
    """Of a job that takes no time but what it waits."""
    recipe = Recipe("tests.planter.rows.toys:Squares", {"rows": ROWS, "wait": 0.02})
    return Killed(tmp_path_factory.mktemp("counted"), recipe, width=2)


@pytest.mark.parametrize("victim", ["driver", "worker"])
def test_killed_sweep_resumes_to_same_rows(counted: Killed, victim: str) -> None:
    getattr(counted, victim)(f"{victim}.sqlite", random.Random(1))
