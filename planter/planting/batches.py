"""Many designs: the objective over a turn of each, on all cores, in a stream.

from planter import evaluate_many

found = evaluate_many(device, designs)      # designs (m, p) in SI: an array, a memory map
best = designs[found.objective.argmin()]
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array, CallError
from planter.planting.model import Device
from planter.planting.turns import FIELDS, Turns
from planter.records import frames, html

if TYPE_CHECKING:
    from pandas import DataFrame
from planter.progress import Listener, Phase

CHUNK = 2_000
"""Designs that a thread takes at a time."""
AHEAD = 4
"""Chunks for each thread that are taken from the designs before the first of them is done."""


@dataclass(frozen=True)
class Batch:
    """The turn of each design, (m,) each: objective (31); range [N], variance [N2] and mean [N] of the force."""

    objective: Array
    range_N: Array
    variance_N2: Array
    mean_N: Array

    def to_frame(self) -> DataFrame:
        """A table of pandas, a row for each design; columns in the units [that their names end in].

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        return frames.of(vars(self))

    def _repr_html_(self) -> str:
        best = int(self.objective.argmin())
        rows = ((name, values.min(), values[best], values.max()) for name, values in vars(self).items())
        title = f"{len(self.objective)} designs, the best of them row {best}"
        return html.shown(title, ("", "least", "of the best", "largest"), rows)


def evaluate_many(
    device: Device,
    designs: Array,
    samples: int | None = None,
    progress: Listener | None = None,
    threads: int | None = None,
) -> Batch:
    """The objective over a turn of many designs (m, p) [SI]; `progress` is told how many are done.

    Beyond the result only some chunks are in memory, whatever m is. Raises CallError for designs of another shape,
    ComputationError, with the row, for one that is not finite or has no finite force. Ctrl-C ends it after the chunks
    in hand.
    """
    if np.ndim(designs) != 2 or np.shape(designs)[1] != len(device.design):
        raise CallError(f"designs have the shape (m, {len(device.design)}), and were given as {np.shape(designs)}")
    found = np.empty((len(FIELDS), len(designs)))
    count = threads or os.cpu_count() or 1
    turns = Turns(device, samples)

    def run(start: int) -> int:
        chunk = np.array(designs[start : start + CHUNK], dtype=float)
        found[:, start : start + len(chunk)] = _evaluated(turns, chunk, start).T
        return start + len(chunk)

    phase = Phase("evaluate", "design", len(designs), progress)
    with ThreadPoolExecutor(count) as pool:
        for future in _streamed(pool, run, range(0, len(designs), CHUNK), count * AHEAD):
            phase.reached(max(phase.done, future.result()))
    return Batch(*found)


def _streamed(pool: ThreadPoolExecutor, run: Callable[[int], int], starts: range, ahead: int) -> Iterator[Future[int]]:
    """Calls in order, never more than `ahead` of them waiting; on an error the rest is not begun."""
    waiting: list[Future[int]] = []
    try:
        for start in starts:
            waiting.append(pool.submit(run, start))
            if len(waiting) == ahead:
                yield waiting.pop(0)
        yield from waiting
    finally:
        for future in waiting:
            future.cancel()


def _evaluated(turns: Turns, designs: Array, start: int) -> Array:
    """Rows of `FIELDS`, (m, 4). Raises ComputationError with the number of the row that failed."""
    try:
        return turns.many(designs)
    except (ComputationError, CallError) as error:
        raise ComputationError(f"among the designs from row {start} on: {error}") from error
