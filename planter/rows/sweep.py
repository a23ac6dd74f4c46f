"""A plan as a job, each row evaluated by the machine and model that its texts name, and its rows:
ranges and files.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from planter import safe_text
from planter.engine.outputs import SampledOutputs
from planter.errors import InputError
from planter.kernels import Array
from planter.progress import Listener, ProgressPhase
from planter.report import folder
from planter.rows.adapter import (
    MachineAdapter,
    ResolvedMachine,
    find_full_name,
    resolve_source,
)
from planter.rows.job import Recipe, Store
from planter.rows.points import Axis, Plan, Points
from planter.rows.results import SweepExtent

PARQUET_HINT = (
    "rows.parquet is not written, rows.csv has the same rows; for Parquet: pip install "
    "'planter[parquet]'"
)


class Rows:
    """Inputs by path, outputs by name, in display units [which the names end in]; a text is its
    index in its list.
    """

    def __init__(
        self, inputs: Mapping[str, Axis], points: Points, outputs: list[str], store: Store
    ) -> None:
        self.inputs, self.points, self.outputs, self._store = inputs, points, outputs, store

    @property
    def columns(self) -> list[str]:
        """Names of all columns, inputs first."""
        return [*self.inputs, *self.outputs]

    def blocks(self) -> Iterator[tuple[Array, Array]]:
        """Yield the points (m, n) and outputs (m, k) of each chunk; rows without a result are
        NaN.
        """
        start = 0
        for outputs in self._store.blocks():
            yield self.points.block(start, start + len(outputs)), outputs
            start += len(outputs)

    def load_all(self) -> tuple[Array, Array]:
        """Return the points and the outputs of all rows."""
        points, outputs = zip(*self.blocks(), strict=True)
        return np.vstack(points), np.vstack(outputs)

    def tables(self) -> Iterator[dict[str, list[Any]]]:
        """Yield the columns of each chunk by name; a text is itself, a row without a result has
        None.
        """
        for points, outputs in self.blocks():
            columns = [
                axis.list_values(column)
                for axis, column in zip(self.inputs.values(), points.T, strict=True)
            ]
            columns += map(_list_cells, outputs.T)
            yield dict(zip(self.columns, columns, strict=True))

    def describe_point(self, point: Array) -> dict[str, float | str]:
        """Return the inputs of a point (n,) by name."""
        return {
            name: axis.list_values(point[k : k + 1])[0]
            for k, (name, axis) in enumerate(self.inputs.items())
        }

    def envelope(self) -> dict[str, SweepExtent]:
        """Return the range of each output over all rows."""
        size, columns = len(self.outputs), np.arange(len(self.outputs))
        total, count, rows = np.zeros(size), np.zeros(size, dtype=int), 0
        # of the values and of the negative ones: the least, and the points where they stand
        smallest, places = np.full((2, size), np.inf), np.empty((2, size, len(self.inputs)))
        for points, outputs in self.blocks():
            total += np.nansum(outputs, axis=0)
            count += (~np.isnan(outputs)).sum(axis=0)
            rows += len(outputs)
            for side, sign in enumerate((1, -1)):
                values = np.where(np.isnan(outputs), np.inf, sign * outputs)
                first = values.argmin(axis=0)
                is_less = values[first, columns] < smallest[side]
                smallest[side, is_less] = values[first, columns][is_less]
                places[side, is_less] = points[first[is_less]]
        extents = {}
        for k, name in enumerate(self.outputs):
            missing = rows - int(count[k])
            if not count[k]:
                extents[name] = SweepExtent(None, None, None, missing, None, None)
                continue
            low_at, high_at = (self.describe_point(places[side, k]) for side in (0, 1))
            low, high, mean = (
                float(smallest[0, k]),
                -float(smallest[1, k]),
                float(total[k] / count[k]),
            )
            extents[name] = SweepExtent(low, high, mean, missing, low_at, high_at)
        return extents


def has_parquet() -> bool:
    """Return whether the extra `parquet` is installed."""
    return find_spec("pyarrow") is not None


def write_rows(
    out: Path, rows: Rows, comments: Iterable[str], progress: Listener | None = None
) -> None:
    """Write rows.csv, and rows.parquet if the extra `parquet` is installed; a failure leaves no
    partial file.

    Raises InputError if a file cannot be written.
    """
    _write_csv(out / "rows.csv", rows, comments, progress)
    if has_parquet():
        _write_parquet(out / "rows.parquet", rows)


def _write_csv(path: Path, rows: Rows, comments: Iterable[str], progress: Listener | None) -> None:
    phase = ProgressPhase("writing", "row", rows.points.rows, progress)
    with folder.replace_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {safe_text.sanitise_line(comment)}\n" for comment in comments)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(rows.columns)
        for table in rows.tables():
            lines = list(zip(*table.values(), strict=True))
            writer.writerows(lines)
            phase.report(phase.done + len(lines))


def _list_cells(column: Array) -> list[float | None]:
    """Return numbers (m,) as cells, None for NaN."""
    cells: list[float | None] = column.tolist()
    for index in np.flatnonzero(np.isnan(column)):
        cells[index] = None
    return cells


def _write_parquet(path: Path, rows: Rows) -> None:
    import pyarrow as pa
    from pyarrow.parquet import ParquetWriter

    texts = {name for name, axis in rows.inputs.items() if axis.texts is not None}
    schema = pa.schema(
        [(name, pa.string() if name in texts else pa.float64()) for name in rows.columns]
    )
    with (
        folder.replace_file(path) as part,
        ParquetWriter(part, schema, compression="zstd") as writer,
    ):
        for table in rows.tables():
            writer.write_batch(pa.RecordBatch.from_pydict(table, schema=schema))


MACHINE = "machine"
"""Name of the input that selects one of several machines."""


class Sweep:
    """A plan with its machines loaded.

    Raises InputError if a machine, an input or an output does not exist.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.machines = [
            ResolvedMachine(resolve_source(source, plan.folder)) for source in plan.machine
        ]
        first = self.machines[0]
        if any(resolved.module != first.module for resolved in self.machines):
            raise InputError(f"{plan.source}: machine: all machines must be of the same kind")
        self._choices: Mapping[str, Sequence[str]] = first.adapter.choices
        names = [
            resolved.resolve_outputs(plan.outputs, f"{plan.source}: outputs")
            for resolved in self.machines
        ]
        self.outputs = list(dict.fromkeys(names[0]))
        self.inputs = {self._path(name): axis for name, axis in plan.axes.items()}
        if len(self.inputs) < len(plan.axes):
            raise InputError(f"{plan.source}: inputs names an input twice; keep one of the two")
        for name, axis in self.inputs.items():
            self._check(name, axis.texts)

    def _path(self, name: str) -> str:
        if name == MACHINE or name in self._choices:
            return name
        label = f"{self.plan.source}: inputs.{name}"
        (path,) = {resolved.path(name, label) for resolved in self.machines}
        return path

    def _check(self, name: str, texts: Sequence[str] | None) -> None:
        allowed = self._choices.get(name, () if name != MACHINE else self.plan.machine)
        if texts is None and not allowed:
            return
        invalid = [text for text in texts or ("a number",) if text not in allowed]
        if invalid:
            hint = f"it must be of {', '.join(allowed)}" if allowed else "it must be numbers"
            raise InputError.for_value(f"inputs.{name}", invalid[0], hint, self.plan.source)

    @property
    def rows(self) -> int:
        """Number of points."""
        return self.plan.sample_points.rows

    @property
    def recipe(self) -> Recipe:
        """Recipe of the job."""
        return Recipe(
            f"{__name__}:{PlanJob.__name__}",
            {
                "module": self.machines[0].module,
                "machines": [
                    resolved.adapter.frozen(resolved.machine) for resolved in self.machines
                ],
                "plan": self.plan.model_dump(mode="json", by_alias=True, exclude_none=True),
                "inputs": list(self.inputs),
                "outputs": self.outputs,
                **self.machines[0].hash_curves(self.outputs),
            },
        )

    def find_column(self, name: str) -> str:
        """Return the name of the column of a name of the plan.

        Raises InputError if it does not exist.
        """
        meanings = dict.fromkeys([*self.inputs, *self.outputs], "")
        return find_full_name(
            name, meanings, f"{self.plan.source}: map: {name}", "inputs and outputs"
        )


class PlanJob:
    """Job of a plan: `outputs` of machines of one kind at the points of the plan."""

    def __init__(
        self,
        module: str,
        machines: Sequence[Mapping[str, Any]],
        plan: dict[str, Any],
        inputs: Sequence[str],
        outputs: Sequence[str],
        curves: Mapping[str, str] | None = None,
    ) -> None:
        """Prepare the job; `curves`, hashes of files that outputs need, distinguish it from jobs
        with other files.
        """
        self._adapter: MachineAdapter = import_module(module).ADAPTER
        self._machines, self._outputs = machines, outputs
        spec = Plan.read(plan, plan.get("name", "plan"))
        self.points, axes = spec.sample_points, list(spec.axes.values())
        self._texts = {
            index: (name, axis.texts)
            for index, (name, axis) in enumerate(zip(inputs, axes, strict=True))
            if axis.texts is not None
        }
        self._numbers = [index for index in range(len(inputs)) if index not in self._texts]
        self._ends = {inputs[index]: axes[index].ends for index in self._numbers}
        self.rows, self.width = self.points.rows, len(outputs)
        self._subjects: dict[tuple[int, ...], SampledOutputs] = {}

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Return the outputs of the points from `start` to `stop`, (stop - start, width)."""
        block = self.points.block(start, stop)
        outputs = np.empty((len(block), self.width))
        kinds, kind_numbers = np.unique(
            block[:, list(self._texts)].astype(int), axis=0, return_inverse=True
        )
        for number, kind in enumerate(kinds):
            rows = kind_numbers.ravel() == number
            subject = self._subject(tuple(map(int, kind)))
            outputs[rows] = subject.evaluated(block[rows][:, self._numbers], threads)
        return outputs

    def _subject(self, kind: tuple[int, ...]) -> SampledOutputs:
        """Return the machine that the texts of a row select, by their indices."""
        if kind not in self._subjects:
            machine, choices = self._machines[0], {}
            for (name, texts), text_index in zip(self._texts.values(), kind, strict=True):
                if name == MACHINE:
                    machine = self._machines[text_index]
                else:
                    choices[name] = texts[text_index]
            self._subjects[kind] = self._adapter.subject(
                machine, choices, self._ends, self._outputs
            )
        return self._subjects[kind]
