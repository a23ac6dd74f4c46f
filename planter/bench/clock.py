"""Agreement first, then the clock: all ways in turn, a new design at every call, medians and quartiles."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planter.bench.case import Call, Contender
from planter.bench.results import Spread
from planter.errors import ComputationError
from planter.kernels import Array

MOST_CALLS = 200
"""Calls of a way before the next one has its turn."""


class Disagreement(ComputationError):
    """A way disagrees with the others, so that its time would mean nothing."""


@dataclass
class Times:
    """Durations of single calls [s]."""

    seconds: list[float] = field(default_factory=list)

    @property
    def median_us(self) -> float:
        return float(np.median(self.seconds)) * 1e6

    def spread(self) -> Spread:
        """Quartiles [us] and the number of calls."""
        low, high = np.percentile(self.seconds, (25, 75)) * 1e6
        return Spread(float(low), float(high), len(self.seconds))


def agree(work: str, contenders: Mapping[str, Contender], inputs: Sequence[Array]) -> dict[str, float]:
    """The largest relative difference of each way from the first one over the inputs.

    Raises Disagreement, naming work and way, where one is off by more than it may be.
    """
    reference, *_ = contenders
    worst = dict.fromkeys(contenders, 0.0)
    for x in inputs:
        expected = _parts(contenders[reference].call(x))
        for name, contender in contenders.items():
            parts = _parts(contender.call(x))
            if len(parts) != len(expected):
                raise Disagreement(f"{work}: {name} gives {len(parts)} results, and {reference} {len(expected)}")
            for part, target, tolerance in zip(parts, expected, contender.tolerances, strict=False):
                off = difference(part, target)
                worst[name] = max(worst[name], off)
                if not off <= tolerance:
                    raise Disagreement(f"{work}: {name} is off {reference} by {off:.2g}; {tolerance:g} is allowed")
    return worst


def difference(values: Array, target: Array) -> float:
    """Largest difference relative to the largest entry; infinite for other shapes and for what is not finite."""
    if values.shape != target.shape or not np.isfinite(values).all():
        return float("inf")
    return float(np.abs(values - target).max() / np.abs(target).max())


def _parts(result: Any) -> list[Array]:
    return [
        np.atleast_1d(np.asarray(part, dtype=float)) for part in (result if isinstance(result, tuple) else (result,))
    ]


def race(calls: Mapping[str, Call], inputs: Iterator[Any], rounds: int, slot_s: float) -> dict[str, Times]:
    """Times of each call on inputs that are new every time.

    In a round every way has its slot of about `slot_s` seconds (0: one call); who begins changes from round to
    round. The first call of a slot of many is not timed: it fetches a way's code and data into the caches again.
    """
    counts = {name: _calls(call, inputs, slot_s) for name, call in calls.items()}
    times = {name: Times() for name in calls}
    names = list(calls)
    with _undisturbed():
        for turn in range(rounds):
            for name in (*names[turn % len(names) :], *names[: turn % len(names)]):
                warm = counts[name] > 1
                _slot(calls[name], [next(inputs) for _ in range(counts[name] + warm)], warm, times[name])
    return times


def _slot(call: Call, inputs: Sequence[Any], warm: bool, times: Times) -> None:
    if warm:
        call(inputs[0])
    for x in inputs[warm:]:
        times.seconds.append(timed(lambda x=x: call(x)))  # type: ignore[misc]


def _calls(call: Call, inputs: Iterator[Any], slot_s: float) -> int:
    """Return the number of calls that fill a slot; 1, without a trial, for a slot of length 0."""
    if slot_s == 0:
        return 1
    taken = min(timed(lambda: call(next(inputs))) for _ in range(2))
    return max(1, min(MOST_CALLS, int(slot_s / taken)))


def timed(call: Callable[[], Any]) -> float:
    """Duration of a call [s]."""
    begun = time.perf_counter()
    call()
    return time.perf_counter() - begun


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Without the garbage collector's pauses."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
