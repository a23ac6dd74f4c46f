"""Many designs: the objective over a turn of each, on all cores, in a stream.

from planter import evaluate_many, load_mechanism

found = evaluate_many(device, designs)      # designs (m, p) in SI: an array, a memory map
best = designs[found.objective.argmin()]

own = load_mechanism("own/slider_crank.toml")
rows = evaluate_many(own, designs, gradients=True, outputs=["M_in_rms_Nm"])
rows["M_in_rms_Nm"], rows.gradient          # (m,), (m, 1, p)
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, overload

import numpy as np

from planter.engine.machine import Machine
from planter.engine.outputs import CHUNK, OutputBatch, evaluate_outputs
from planter.errors import ComputationError
from planter.kernels import Array, CallError
from planter.planting.model import Device
from planter.planting.turns import FIELDS, Turns
from planter.records.record import build_frame, format_table

if TYPE_CHECKING:
    from pandas import DataFrame
from planter.progress import Listener, ProgressPhase


@dataclass(frozen=True)
class Batch:
    """The turn of each design, (m,) each: objective (31); range [N], variance [N2] and mean [N] of the force.

    `gradient` (m, p) is that of the objective [1/SI], None if it was not asked for.
    """

    objective: Array
    range_N: Array
    variance_N2: Array
    mean_N: Array
    gradient: Array | None = None

    @property
    def _columns(self) -> dict[str, Array]:
        """What each design has, by name: all but the gradient."""
        return {name: getattr(self, name) for name in FIELDS}

    def to_frame(self) -> DataFrame:
        """A table of pandas, a row for each design; columns in the units [that their names end in].

        Raises InputError where pandas is missing (`planter[notebook]` brings it).
        """
        return build_frame(self._columns)

    def _repr_html_(self) -> str:
        best = int(self.objective.argmin())
        rows = ((name, values.min(), values[best], values.max()) for name, values in self._columns.items())
        title = f"{len(self.objective)} designs, the best of them row {best}"
        return format_table(title, ("", "least", "of the best", "largest"), rows)


@overload
def evaluate_many(
    device: Device, designs: Array, samples: int | None = None, progress: Listener | None = None,
    threads: int | None = None, *, gradients: bool = False,
) -> Batch: ...  # fmt: skip


@overload
def evaluate_many(
    device: Machine, designs: Array, samples: int | None = None, progress: Listener | None = None,
    threads: int | None = None, *, gradients: bool = False, outputs: Sequence[str],
) -> OutputBatch: ...  # fmt: skip


def evaluate_many(
    device: Device | Machine,
    designs: Array,
    samples: int | None = None,
    progress: Listener | None = None,
    threads: int | None = None,
    *,
    gradients: bool = False,
    outputs: Sequence[str] = (),
) -> Batch | OutputBatch:
    """The objective over a turn of many designs (m, p) [SI], with its `gradients` if they are asked for.

    Of any other machine, as `load_mechanism` returns it, `outputs` by name, which are those of `planter sweep`; the
    designs are then those of its moved values. `progress` is told how many are done. Beyond the result only some chunks
    are in memory, whatever m is. Raises CallError for designs of another shape, ComputationError, with the row, for one
    that is not finite or has no finite force; other machines have no numbers there. Ctrl-C ends it after the chunks in
    hand.
    """
    if isinstance(device, Machine):
        return evaluate_outputs(device, designs, outputs, samples, progress, threads, gradients)
    if np.ndim(designs) != 2 or np.shape(designs)[1] != len(device.design):
        raise CallError(f"designs have the shape (m, {len(device.design)}), and were given as {np.shape(designs)}")
    values = np.empty((len(designs), len(FIELDS)))
    slopes = np.empty(np.shape(designs)) if gradients else None
    turns, count = Turns(device, samples), threads or os.cpu_count() or 1
    phase = ProgressPhase("evaluate", "design", len(designs), progress)
    for start in range(0, len(designs), CHUNK):
        part = slice(start, start + CHUNK)
        chunk = np.array(designs[part], dtype=float)
        try:
            if slopes is None:
                values[part] = turns.many(chunk, count)
            else:
                values[part], slopes[part] = turns.many_gradients(chunk, count)
        except (ComputationError, CallError) as error:
            raise ComputationError(f"among the designs from row {start} on: {error}") from error
        phase.report(start + len(chunk))
    return Batch(**dict(zip(FIELDS, values.T, strict=True)), gradient=slopes)
