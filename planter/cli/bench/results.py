"""What `planter bench` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record

WORKS = ("cycle", "cycle+gradient", "hessian", "batch", "optimise", "derive", "cold start")
QUICK_WORKS = ("cycle", "cycle+gradient", "optimise")


@dataclass(frozen=True)
class WayTimes(Record):
    """Median duration of a way to do a task, and its ratio to that of the reference."""

    way: str
    median_us: float
    ratio: float
    calls: int


@dataclass(frozen=True)
class TaskTimes(Record):
    """A task with the times of its ways; `skipped` has the reasons why others take no part."""

    name: str
    unit: str
    ways: list[WayTimes]
    skipped: dict[str, str]


@dataclass(frozen=True)
class Benchmark(Record):
    """All tasks of one run; `skipped` has the reasons why tasks were not done."""

    work: list[TaskTimes]
    machine: dict[str, str | int | None]
    versions: dict[str, str]
    skipped: dict[str, str]


COMMANDS = {"bench": Benchmark}
"""What the package's command returns."""
