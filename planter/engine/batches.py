"""Many designs of any machine: outputs over a turn of each, and their exact gradients, on all cores."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planter.engine.machine import Machine
from planter.engine.outputs import SampledOutputs, find_output, list_outputs
from planter.errors import InputError
from planter.kernels import Array, CallError
from planter.progress import Listener, ProgressPhase
from planter.records import frames

if TYPE_CHECKING:
    from pandas import DataFrame

CHUNK = 10_000
"""Designs between two reports of progress."""


@dataclass(frozen=True)
class OutputBatch:
    """Outputs by name of many designs, (m, k), each in the unit that its name ends in; NaN without a cycle.

    `gradient` (m, k, p) has the derivatives of each output in the design [1/SI], None if they were not asked for.
    """

    names: tuple[str, ...]
    values: Array
    gradient: Array | None = None

    def __getitem__(self, name: str) -> Array:
        """Return an output (m,) by its name."""
        return np.asarray(self.values[:, self.names.index(name)])

    def to_frame(self) -> DataFrame:
        """Return a table of pandas, a row for each design. Raises InputError if pandas is missing."""
        return frames.of(dict(zip(self.names, self.values.T, strict=True)))


def evaluate_outputs(
    machine: Machine, designs: Array, outputs: Sequence[str], samples: int | None = None,
    progress: Listener | None = None, threads: int | None = None, gradients: bool = False,
) -> OutputBatch:  # fmt: skip
    """Return outputs of a machine at designs (m, p) of its moved values [SI].

    Raises InputError for an output that the machine does not have, or a machine without moved values; CallError for
    designs of another shape.
    """
    if not machine.moved:
        hint = 'give it [bounds], or choose some by machine.with_moved({"values.r_mm": (40, 60)})'
        raise InputError(f"{machine.source}: no values are to be varied; {hint}")
    if np.ndim(designs) != 2 or np.shape(designs)[1] != len(machine.moved):
        raise CallError(f"designs have the shape (m, {len(machine.moved)}), and were given as {np.shape(designs)}")
    check_outputs(machine, outputs)
    inputs = [machine.values[index].path for index in machine.moved]
    sampled, count = SampledOutputs(machine, inputs, outputs, samples), threads or os.cpu_count() or 1
    values = np.empty((len(designs), len(outputs)))
    slopes = np.empty((*values.shape, len(inputs))) if gradients else None
    phase = ProgressPhase("evaluate", "design", len(designs), progress)
    for start in range(0, len(designs), CHUNK):
        part = slice(start, start + CHUNK)
        points = np.array(designs[part], dtype=float) / machine.scale
        if slopes is None:
            values[part] = sampled.evaluated(points, count)
        else:
            values[part], chunk = sampled.gradients(points, count)
            slopes[part] = chunk / machine.scale
        phase.report(start + len(points))
    return OutputBatch(tuple(outputs), values, slopes)


def check_outputs(machine: Machine, names: Sequence[str]) -> None:
    """Raise InputError for a name that is no output of a machine, with names that are close, and for no names."""
    if not names:
        known = next(iter(list_outputs(machine)))
        raise InputError(f"{machine.source}: outputs is empty: name at least one, such as {known}")
    for name in names:
        find_output(machine, name, f"{machine.source}: output")
