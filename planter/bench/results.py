"""What `planter bench` returns, key by key."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from planter.errors import InputError
from planter.records import Record


@dataclass(frozen=True)
class Spread(Record):
    """Quartiles of the durations, and how many there are."""

    quartile1_us: float
    quartile3_us: float
    calls: int


@dataclass(frozen=True)
class Reached(Record):
    """The objectives that a method reached."""

    least: float
    largest: float


@dataclass(frozen=True)
class Drawn(Record):
    """What a way to make gears draws: vertices of both outlines, and how far they are from what it computed."""

    vertices: int
    deviation_um: float


@dataclass(frozen=True)
class Way(Record):
    """A way to do a work: its median, that over the reference's, how it was built, how far its results are off."""

    way: str
    median_us: float
    ratio: float
    spread: Spread
    built: str
    disagreement: float | None = None
    objectives: Reached | None = None
    drawn: Drawn | None = None


@dataclass(frozen=True)
class Skipped(Record):
    """A way that takes no part in a work, with the reason."""

    way: str
    reason: str


@dataclass(frozen=True)
class LeftOut(Record):
    """A work that was not done, with the reason."""

    work: str
    reason: str


@dataclass(frozen=True)
class Seed(Record):
    """What it took IPOPT to meet the genetic algorithm at a seed."""

    seed: int
    ga_objective: float
    ga_s: float
    ipopt_objective: float
    ipopt_s: float
    starts: int
    met: bool


@dataclass(frozen=True)
class Basins(Record):
    """A model with several basins."""

    model: str
    seeds: list[Seed]


@dataclass(frozen=True)
class Work(Record):
    """A work: times of its ways; `over` is the way that ratios are counted from."""

    name: str
    unit: str
    over: str
    ways: list[Way]
    variants: list[Way]
    skipped: list[Skipped]
    exact: Basins | None = None


@dataclass(frozen=True)
class Rate(Record):
    """How much of the peak a way makes of its arithmetic."""

    work: str
    way: str
    operations: int
    operations_per_cycle: float
    share_of_peak: float


@dataclass(frozen=True)
class Arithmetic(Record):
    """The peak of one core, and what the ways make of it."""

    clock_GHz: float
    peak_operations_per_cycle: float
    rates: list[Rate]


@dataclass(frozen=True)
class Surroundings(Record):
    """Where it ran; the load that stood before it is null where it cannot be told."""

    processor: str
    architecture: str
    cores: int | None
    system: str
    load_before: float | None


@dataclass(frozen=True)
class Benchmark(Record):
    """All works in one run; without a compiler there is no arithmetic."""

    work: list[Work]
    machine: Surroundings
    versions: dict[str, str]
    skipped: list[LeftOut]
    vector_width: int | None
    arithmetic: Arithmetic | None
    device: str
    samples: int
    seconds: float


COMMANDS = {"bench": Benchmark}
"""What the package's command returns."""


WORKS = (
    "cycle",
    "cycle+gradient",
    "hessian",
    "batch",
    "optimise",
    "slider-crank",
    "four-bar",
    "gears",
    "derive",
    "cold start",
)
QUICK_WORKS = ("cycle", "cycle+gradient", "optimise")
WAYS = ("numpy", "lambdify", "jax", "casadi-vm", "casadi-c", "lanes")
"""Ways to evaluate a turn; the works `optimise`, `gears`, `derive` and `cold start` have other ways."""


@dataclass(frozen=True)
class Settings:
    """`rounds` of slots of `slot_s` seconds for a turn; repetitions of the works that take longer."""

    works: tuple[str, ...] = WORKS
    ways: tuple[str, ...] = WAYS
    quick: bool = False
    rounds: int = 40
    slot_s: float = 0.05
    batches: int = 3
    designs: int = 10_000
    searches: int = 5
    pairs: int = 3
    derivations: int = 2
    processes: int = 7


def choose_settings(
    quick: bool = False,
    works: Sequence[str] | None = None,
    ways: Sequence[str] | None = None,
    rounds: int | None = None,
) -> Settings:
    """Return the settings of a benchmark. Raises InputError for an unknown work or way."""
    chosen = Settings(works=QUICK_WORKS, quick=True, rounds=12, slot_s=0.03, searches=3) if quick else Settings()
    if works:
        chosen = replace(chosen, works=_select_names("--work", works, WORKS))
    if ways:
        chosen = replace(chosen, ways=_select_names("--way", ways, WAYS))
    if rounds is not None:
        if rounds < 1:
            raise InputError.for_value("--rounds", rounds, "the number must be at least 1")
        chosen = replace(
            chosen, rounds=rounds, batches=rounds, searches=rounds, pairs=rounds, derivations=rounds, processes=rounds
        )
    return chosen


def _select_names(option: str, names: Sequence[str], allowed: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if name not in allowed:
            raise InputError.for_value(option, name, f"choose one of {', '.join(allowed)}")
    return tuple(name for name in allowed if name in names)
