"""Outputs of a machine by name: measures of its quantities over the samples of a cycle, for rows of its values.

An output is called after its quantity, its measure and its unit, such as `M_in_rms_Nm`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.measures import AVERAGES, Kind
from planter.engine.response import Response
from planter.engine.rows import Block, Rows
from planter.errors import ComputationError
from planter.files import units
from planter.kernels import Array
from planter.numerics import statistics

MEASURED: tuple[Kind, ...] = ("max", "min", "range", "mean", "std", "rms")
"""Measures that every quantity has an output of."""
COMPILED = 64
"""Rows from which on it pays to compile their slopes."""
SIDES = {"max": (1.0, 0.0), "min": (0.0, 1.0), "range": (1.0, -1.0)}
"""Shares of the largest and of the least sample in a measure."""


@dataclass(frozen=True)
class Output:
    """A measure of a quantity over the samples of a cycle, in the unit of its key."""

    name: str
    quantity: Quantity
    kind: Kind

    @property
    def meaning(self) -> str:
        """The meaning of the quantity, and the measure."""
        return f"{self.quantity.meaning}: {self.kind} over a turn"


def list_outputs(machine: Machine) -> dict[str, Output]:
    """Return every output of a machine by its name."""
    outputs: dict[str, Output] = {}
    for quantity in machine.quantities:
        suffix = units.suffix(quantity.key)
        for kind in MEASURED:
            name = f"{quantity.key.removesuffix(suffix)}_{kind}{suffix}"
            outputs[name] = Output(name, quantity, kind)
    return outputs


@dataclass(frozen=True)
class SampleWeights:
    """Derivatives of outputs (k, lanes) in the samples: constant + slope * sample, and those of extremes.

    `high` and `low` are the angles of the largest and of the least sample, `sides` (k, 2) their derivatives.
    """

    constant: Array
    slope: Array
    high: Array
    low: Array
    sides: Array

    def at(self, samples: Array) -> Array:
        """Return the derivatives (k, angles, lanes) in samples (k, angles, lanes)."""
        angles = np.arange(samples.shape[1])[:, None]
        weights = self.constant[:, None] + self.slope[:, None] * samples
        for column, extreme in enumerate((self.high, self.low)):
            weights += self.sides[:, column, None, None] * (extreme[:, None] == angles)
        return np.asarray(weights)


class SampledOutputs:
    """Outputs by name over rows of values by path, in the units that the names end in.

    A row has no output where the machine has no cycle, and no average of what does not repeat after a turn.
    """

    def __init__(
        self, machine: Machine, inputs: Sequence[str], names: Sequence[str], samples: int | None = None
    ) -> None:
        self.machine = machine.with_moved(dict.fromkeys(inputs, (0.0, 0.0)))
        known = list_outputs(machine)
        self.outputs = [known[name] for name in names]
        self.quantities = list(dict.fromkeys(output.quantity.name for output in self.outputs))
        compared = any(output.kind in AVERAGES for output in self.outputs)
        self.rows = Rows(self.machine, self.quantities, samples, compared)
        self._factors = np.array([output.quantity.factor for output in self.outputs])

    @cached_property
    def _places(self) -> list[int]:
        """Where the quantity of each output stands among those of the rows."""
        return [self.quantities.index(output.quantity.name) for output in self.outputs]

    def data(self, points: Array) -> Array:
        """Return all values (m, v) in SI at points (m, n)."""
        data = np.repeat(self.machine.data[None], len(points), axis=0)
        data[:, list(self.machine.moved)] = np.asarray(points, dtype=float) * self.machine.scale
        return data

    def evaluated(self, points: Array, threads: int) -> Array:
        """Return outputs (m, k) at points (m, n), NaN where there are none."""
        return self.rows.evaluate(
            self.data(points), lambda block: self._reduced(block) / self._factors[:, None], threads
        )

    def gradients(self, points: Array, threads: int) -> tuple[Array, Array]:
        """Return outputs (m, k) at points (m, n) and their exact slopes (m, k, n); extremes stay at their samples."""
        size = len(points[0]) if len(points) else 0

        def reduce(block: Block) -> Array:
            values = self._reduced(block)
            weights = self._weights(block, values)
            slopes = self.rows.gradients(block, self._places, weights.at(block.samples[self._places]))
            slopes *= self.machine.scale[:, None]
            slopes[np.isnan(values)[:, None].repeat(size, axis=1)] = np.nan
            rows = np.concatenate([values[:, None], slopes], axis=1) / self._factors[:, None, None]
            return rows.reshape(-1, values.shape[1])

        if len(points) >= COMPILED:
            self.rows.compile_slopes(self._places)
        rows = self.rows.evaluate(self.data(points), reduce, threads).reshape(-1, len(self.outputs), 1 + size)
        return rows[:, :, 0], rows[:, :, 1:]

    def slopes(self, point: Array) -> tuple[Array, Array]:
        """Return outputs (k,) at a point (n,) and their exact slopes (k, n). Raises ComputationError without them."""
        values, slopes = self.gradients(np.asarray(point, dtype=float)[None], 1)
        if np.isnan(values).any():
            raise ComputationError(self.find_reason(point))
        return values[0], slopes[0]

    def find_reason(self, point: Array) -> str:
        """Return why a point (n,) has no outputs: what the walk of the machine alone says."""
        response = Response(self.machine)
        try:
            at = response.at_data(self.data(np.asarray(point, dtype=float)[None])[0])
            response.check(response.values(at, self.rows.angles), self.rows.angles)
        except ComputationError as error:
            return error.message
        averages = [output.name for output in self.outputs if output.kind in AVERAGES]
        return f"{self.machine.name}: a turn does not end in the state in which it began: it has no {averages[0]}"

    def curves(self, keys: Sequence[str], points: Array) -> Mapping[str, Array]:
        """Return quantities by key over a turn, (m, n) each, at points (m, inputs), and the angles `phi_deg` (n,)."""
        quantities = [self.machine.find_quantity(key) for key in keys]
        rows = Rows(self.machine, [quantity.name for quantity in quantities], len(self.rows.angles), compared=False)
        samples = rows.evaluate(self.data(points), lambda block: block.samples.reshape(-1, block.samples.shape[2]))
        failed = np.isnan(samples).any(axis=1)
        if failed.any():
            raise ComputationError(self.find_reason(points[np.flatnonzero(failed)[0]]))
        samples = samples.reshape(len(points), len(quantities), -1).transpose(1, 0, 2)
        samples = np.tile(samples, len(rows.angles) // samples.shape[2])
        shown = {key: row / quantity.factor for key, row, quantity in zip(keys, samples, quantities, strict=True)}
        return shown | {"phi_deg": np.degrees(rows.angles)}

    def _reduced(self, block: Block) -> Array:
        """Return outputs (k, lanes) in SI."""
        reduced = np.empty((len(self.outputs), block.samples.shape[2]))
        for row, output, place in zip(reduced, self.outputs, self._places, strict=True):
            row[:] = statistics.reduce(output.kind, block.samples[place])
            if output.kind in AVERAGES:
                row[~block.repeats[place]] = np.nan
        return reduced

    def _weights(self, block: Block, values: Array) -> SampleWeights:
        """Return the derivatives of outputs (k, lanes) in the samples of their quantities."""
        constant, slope = np.zeros_like(values), np.zeros_like(values)
        count = block.samples.shape[1]
        for k, (output, place) in enumerate(zip(self.outputs, self._places, strict=True)):
            if output.kind == "mean":
                constant[k] = 1 / count
            elif output.kind in ("std", "rms"):
                size = count * values[k]
                slope[k] = np.divide(1, size, out=np.zeros_like(size), where=size > 0)
                if output.kind == "std":
                    constant[k] = -slope[k] * block.samples[place].mean(axis=0)
        samples = block.samples[self._places]
        sides = np.array([SIDES.get(output.kind, (0.0, 0.0)) for output in self.outputs])
        return SampleWeights(constant, slope, samples.argmax(axis=1), samples.argmin(axis=1), sides)
