"""What `planter bench` returns, key by key."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from planter.errors import InputError
from planter.records import Record


@dataclass(frozen=True)
class DurationQuartiles(Record):
    """Quartiles of the durations, and the number of calls."""

    quartile1_us: float
    quartile3_us: float
    calls: int


@dataclass(frozen=True)
class ReachedObjectives(Record):
    """Smallest and largest objective that a method reached."""

    least: float
    largest: float


@dataclass(frozen=True)
class DrawnOutline(Record):
    """Vertices of both drawn gear outlines, and their largest deviation from the computed ones."""

    vertices: int
    deviation_um: float


@dataclass(frozen=True)
class WayTimes(Record):
    """Times of a way to do a task: median, ratio to the reference, how it was built, difference of
    its results.
    """

    way: str
    median_us: float
    ratio: float
    spread: DurationQuartiles
    built: str
    disagreement: float | None = None
    objectives: ReachedObjectives | None = None
    drawn: DrawnOutline | None = None


@dataclass(frozen=True)
class SkippedWay(Record):
    """A way that takes no part in a task, with the reason."""

    way: str
    reason: str


@dataclass(frozen=True)
class SkippedTask(Record):
    """A task that was not done, with the reason."""

    work: str
    reason: str


@dataclass(frozen=True)
class SeedTimes(Record):
    """Times, and starts, until IPOPT reached the objective of the genetic algorithm at a seed."""

    seed: int
    ga_objective: float
    ga_s: float
    ipopt_objective: float
    ipopt_s: float
    starts: int
    met: bool


@dataclass(frozen=True)
class BasinSearch(Record):
    """Searches for the best of several basins of a model."""

    model: str
    seeds: list[SeedTimes]


@dataclass(frozen=True)
class TaskTimes(Record):
    """A task with the times of its ways; `over` is the way that ratios refer to."""

    name: str
    unit: str
    over: str
    ways: list[WayTimes]
    variants: list[WayTimes]
    skipped: list[SkippedWay]
    exact: BasinSearch | None = None


@dataclass(frozen=True)
class ArithmeticRate(Record):
    """Arithmetic of a way, and its share of the peak."""

    work: str
    way: str
    operations: int
    operations_per_cycle: float
    share_of_peak: float


@dataclass(frozen=True)
class ArithmeticPeak(Record):
    """Peak of one core, and the shares that the ways reach."""

    clock_GHz: float
    peak_operations_per_cycle: float
    rates: list[ArithmeticRate]


@dataclass(frozen=True)
class BenchmarkMachine(Record):
    """Processor and system; `load_before` is null if the load before the benchmark is unknown."""

    processor: str
    architecture: str
    cores: int | None
    system: str
    load_before: float | None


@dataclass(frozen=True)
class Benchmark(Record):
    """All tasks of one run; `arithmetic` is null without a compiler."""

    work: list[TaskTimes]
    machine: BenchmarkMachine
    versions: dict[str, str]
    skipped: list[SkippedTask]
    vector_width: int | None
    arithmetic: ArithmeticPeak | None
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
"""Ways to evaluate a cycle; the tasks `optimise`, `gears`, `derive` and `cold start` have other
ways.
"""


@dataclass(frozen=True)
class BenchmarkSettings:
    """`rounds` of slots of `slot_s` seconds for a cycle; repetitions of the tasks that take
    longer.
    """

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
) -> BenchmarkSettings:
    """Return the settings of a benchmark. Raises InputError for an unknown task or way."""
    chosen = BenchmarkSettings()
    if quick:
        chosen = BenchmarkSettings(
            works=QUICK_WORKS, quick=True, rounds=12, slot_s=0.03, searches=3
        )
    if works:
        chosen = replace(chosen, works=_select_names("--work", works, WORKS))
    if ways:
        chosen = replace(chosen, ways=_select_names("--way", ways, WAYS))
    if rounds is not None:
        if rounds < 1:
            raise InputError.for_value("--rounds", rounds, "the number must be at least 1")
        chosen = replace(
            chosen,
            rounds=rounds,
            batches=rounds,
            searches=rounds,
            pairs=rounds,
            derivations=rounds,
            processes=rounds,
        )
    return chosen


def _select_names(option: str, names: Sequence[str], allowed: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if name not in allowed:
            raise InputError.for_value(option, name, f"choose one of {', '.join(allowed)}")
    return tuple(name for name in allowed if name in names)
