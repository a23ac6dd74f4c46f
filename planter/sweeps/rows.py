"""The rows of a sweep as they were found: inputs and outputs by name, a chunk at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from planter.kernels import Array
from planter.sweeps.axes import Axis
from planter.sweeps.points import Points
from planter.sweeps.results import Extent
from planter.sweeps.store import Store


class Rows:
    """Inputs by path, outputs by name, in the units [that the names end in]; texts as their places in their lists."""

    def __init__(self, inputs: Mapping[str, Axis], points: Points, outputs: list[str], store: Store) -> None:
        self.inputs, self.points, self.outputs, self._store = inputs, points, outputs, store

    @property
    def columns(self) -> list[str]:
        return [*self.inputs, *self.outputs]

    def blocks(self) -> Iterator[tuple[Array, Array]]:
        """Points (m, n) and outputs (m, k) of each chunk, NaN in rows without a result."""
        start = 0
        for found in self._store.blocks():
            yield self.points.block(start, start + len(found)), found
            start += len(found)

    def whole(self) -> tuple[Array, Array]:
        """Points and outputs of all rows."""
        points, outputs = zip(*self.blocks(), strict=True)
        return np.vstack(points), np.vstack(outputs)

    def tables(self) -> Iterator[dict[str, Array | list[str]]]:
        """Columns of each chunk by name: texts as texts, NaN where a row has no result."""
        for points, outputs in self.blocks():
            inputs = (_input_column(axis, column) for axis, column in zip(self.inputs.values(), points.T, strict=True))
            yield dict(zip(self.columns, [*inputs, *outputs.T], strict=True))

    def inputs_of(self, point: Array) -> dict[str, float | str]:
        """A point (n,) by names."""
        found: dict[str, float | str] = {}
        for (name, axis), value in zip(self.inputs.items(), point, strict=True):
            texts = axis.texts
            found[name] = float(value) if texts is None else texts[int(value)]
        return found

    def envelope(self) -> dict[str, Extent]:
        """What every output reaches."""
        tallies = [_Tally() for _ in self.outputs]
        for points, outputs in self.blocks():
            for tally, column in zip(tallies, outputs.T, strict=True):
                tally.add(points, column)
        return {name: tally.extent(self) for name, tally in zip(self.outputs, tallies, strict=True)}


def _input_column(axis: Axis, column: Array) -> Array | list[str]:
    texts = axis.texts
    return column if texts is None else [texts[int(index)] for index in column]


class _Tally:
    """Extremes and mean of a column that comes in blocks."""

    def __init__(self) -> None:
        self.low, self.high, self.total, self.count, self.missing = np.inf, -np.inf, 0.0, 0, 0
        self.low_at: Array | None = None
        self.high_at: Array | None = None

    def add(self, points: Array, column: Array) -> None:
        there = np.flatnonzero(~np.isnan(column))
        self.missing += len(column) - len(there)
        self.count += len(there)
        if not len(there):
            return
        self.total += float(column[there].sum())
        low, high = there[column[there].argmin()], there[column[there].argmax()]
        if column[low] < self.low:
            self.low, self.low_at = float(column[low]), points[low]
        if column[high] > self.high:
            self.high, self.high_at = float(column[high]), points[high]

    def extent(self, rows: Rows) -> Extent:
        if self.low_at is None or self.high_at is None:
            return Extent(None, None, None, self.missing, None, None)
        mean = self.total / self.count
        return Extent(
            self.low, self.high, mean, self.missing, rows.inputs_of(self.low_at), rows.inputs_of(self.high_at)
        )
