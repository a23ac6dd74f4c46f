"""Values of a file that change over time: inputs by a table of a CSV file."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import casadi as ca
import numpy as np

from planter.errors import InputError
from planter.files import units
from planter.files.csv_rows import read_table
from planter.kernels import Array
from planter.mechanism.file import MechanismFile
from planter.text_files import read_text

TIME = "t_s"


@dataclass(frozen=True)
class InputHistory:
    """Values (n,) [SI] at rising times (n,) [s], by their place among the data of a file.

    Between two times values are interpolated linearly; before the first and after the last they are
    those there.
    """

    times: Array = field(default_factory=lambda: np.zeros(1))
    values: Mapping[int, Array] = field(default_factory=dict)

    @cached_property
    def symbols(self) -> ca.SX:
        """Symbols (m,) of the values."""
        return ca.SX.sym("inputs", len(self.values))

    def place(self, data: Array) -> ca.SX:
        """Return data (d,) with symbols for the values that change."""
        placed = ca.SX(ca.DM(data))
        placed[list(self.values)] = self.symbols
        return placed

    def with_data(self, data: Array) -> InputHistory:
        """Return a history of the same symbols whose values are those of data (d,) at all times."""
        same = copy.copy(self)
        vars(same).update(times=np.zeros(1), values={i: data[i : i + 1] for i in self.values})
        return same

    def at(self, time: float) -> Array:
        """Return the values (m,) at a time."""
        if len(self.times) == 1:
            return np.array([row[0] for row in self.values.values()])
        return np.array([np.interp(time, self.times, row) for row in self.values.values()])

    def evaluate(self, data: Array, times: Array | float) -> Array:
        """Return data (d, n) at times (n,); (d,) if nothing changes, or at a single time."""
        if not self.values:
            return data
        moved = np.array(np.broadcast_to(data, (*np.shape(times), len(data))).T)
        for index, row in self.values.items():
            moved[index] = np.interp(times, self.times, row)
        return moved


def read_history(path: str | Path, file: MechanismFile) -> InputHistory:
    """Return the history of a CSV file with the columns t_s and names of values, as F_N.

    Raises InputError for a column that is no value of the file, and for times that do not rise.
    """
    table = read_table(read_text(path), str(path))
    if TIME not in table.header:
        raise InputError(f"{path}: there is no column {TIME}: the time [s] of each row")
    times = np.array(table.numbers(TIME))
    if (back := np.flatnonzero(np.diff(times) <= 0)).size:
        place = table.place(int(back[0]) + 1, TIME)
        raise InputError(f"{place}: {times[back[0] + 1]:g}: the time must rise from row to row")
    keys = [entry["shown"].rpartition(".")[2] for entry in file.entries]
    values = {}
    for key in table.header:
        if key == TIME:
            continue
        if key not in keys:
            raise InputError(
                f"{path}: column {key}: it is no value of {file.name}: {', '.join(keys)} are"
            )
        values[keys.index(key)] = np.array(table.numbers(key)) * units.unit_factor(key)
    return InputHistory(times, values)
