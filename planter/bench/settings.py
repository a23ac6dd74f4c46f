"""How much a benchmark does, and the names of its works and ways."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from planter.errors import InputError

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


def settings(
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
            raise InputError(f"--rounds = {rounds}: the number must be at least 1")
        chosen = replace(
            chosen, rounds=rounds, batches=rounds, searches=rounds, pairs=rounds, derivations=rounds, processes=rounds
        )
    return chosen


def _select_names(option: str, names: Sequence[str], allowed: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if name not in allowed:
            raise InputError(f"{option} = {name}: choose one of {', '.join(allowed)}")
    return tuple(name for name in allowed if name in names)
