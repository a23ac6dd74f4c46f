"""Which modules are tried with faults in them, how many of each room, which tests are concerned,
what is equivalent.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from tests.mutants.forks import ROOT, Job
from tests.mutants.mutator import Mutant, mutants, mutated

SEED = 17
HERE = Path(__file__).parent


@dataclass(frozen=True)
class Trial:
    """A module with a fault in it."""

    path: Path
    mutant: Mutant

    @property
    def name(self) -> str:
        return f"{self.path.stem}: {self.mutant.name}"


@dataclass(frozen=True)
class Room:
    """Modules by patterns, the size of the sample, and tests, those first that most likely fail.

    `seconds` of the processor are more than twice what the tests need on sound modules. `writes`
    says that the modules write programmes, so that faults are planted in that text, too.
    """

    modules: tuple[str, ...]
    size: int
    tests: tuple[str, ...]
    seconds: int
    writes: bool = False

    @cached_property
    def paths(self) -> list[Path]:
        paths = (path for pattern in self.modules for path in ROOT.glob(pattern))
        return sorted(path for path in paths if path.stem != "__init__")

    @cached_property
    def list_trials(self) -> list[Trial]:
        return [
            Trial(path, m)
            for path in self.paths
            for m in mutants(path.read_text("utf-8"), self.writes)
        ]

    @property
    def sample(self) -> list[Trial]:
        """The mutants that come first in a seeded order of all."""
        return sorted(self.list_trials, key=lambda trial: trial.mutant.rank(SEED))[: self.size]

    def job(self, trial: Trial) -> Job:
        """The tests of a module with a fault in it."""
        return self._job(
            trial.path, mutated(trial.path.read_text("utf-8"), trial.mutant, self.writes)
        )

    def sound(self, path: Path) -> Job:
        """The tests of a module as it is."""
        return self._job(path, path.read_text("utf-8"))

    def _job(self, path: Path, text: str) -> Job:
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        return Job(module, text, tuple(self.tests), self.seconds)


def rooms() -> dict[str, Room]:
    return {
        name: Room(**fields)
        for name, fields in tomllib.loads((HERE / "rooms.toml").read_text("utf-8")).items()
    }


def equivalent() -> dict[str, str]:
    """Mutants that do the same as the module they are of, with the reason."""
    content = tomllib.loads((HERE / "equivalent.toml").read_text("utf-8"))
    return {entry["mutant"]: entry["reason"] for entry in content["equivalent"]}
