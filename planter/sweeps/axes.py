"""Values of an input of a sweep: numbers in a range, or the entries of a list."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from planter.files.fields import Problems, Real, Section, Whole, check, refused
from planter.kernels import Array

MOST_STEPS = 1_000_000


def _choice(value: Any) -> Any:
    """Return a list as a tuple. Raises ValueError unless it has only numbers or only texts, each once."""
    if not isinstance(value, list | tuple):
        return value
    texts = [isinstance(item, str) for item in value]
    numbers = [isinstance(item, int | float) and not isinstance(item, bool) for item in value]
    if value and not all(texts) and not all(numbers):
        raise refused("", value, "it must be a list of numbers, or a list of texts")
    if len(set(value)) < len(value):
        raise refused("", value, "it must have no value twice")
    return tuple(value)


class Axis(Section):
    """An input: a list of `values`, or a range `from` ... `to`, which a grid divides into `steps` values."""

    values: Annotated[tuple[Real | str, ...] | None, BeforeValidator(_choice), Field(min_length=1)] = None
    low: Annotated[Real | None, Field(alias="from")] = None
    high: Annotated[Real | None, Field(alias="to")] = None
    steps: Annotated[Whole, Field(ge=2, le=MOST_STEPS)] | None = None

    @check
    def _list_or_range(self) -> Problems:
        ends = (self.low, self.high)
        if (self.values is None) == (ends == (None, None)) or (self.values is not None and self.steps is not None):
            yield refused("", self.table, "it must be a list of values, or { from = ..., to = ..., steps = ... }")
        elif self.values is None and (self.low is None or self.high is None or not self.low < self.high):
            yield refused("", self.table, "it must have from less than to")

    @property
    def table(self) -> dict[str, Any]:
        """The table of the file."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    @property
    def texts(self) -> tuple[str, ...] | None:
        """The values, if they are texts."""
        return tuple(value for value in self.values or () if isinstance(value, str)) or None

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest number."""
        numbers = self._numbers
        return float(numbers.min()), float(numbers.max())

    @property
    def _numbers(self) -> Array:
        """The values: of texts their indices in the list, of a range its steps or its two ends."""
        if self.texts is not None:
            return np.arange(float(len(self.texts)))
        if self.values is not None:
            return np.array(self.values, dtype=float)
        assert self.low is not None
        assert self.high is not None
        return np.linspace(self.low, self.high, self.steps or 2)

    @property
    def count(self) -> int:
        """Number of values on a grid."""
        return len(self._numbers)

    def on_grid(self, indices: Any) -> Array:
        """Return the numbers at indices (n,) of the grid."""
        numbers: Array = self._numbers[indices]
        return numbers

    def from_unit(self, shares: Array) -> Array:
        """Return the numbers at shares (n,) in [0, 1) of the range or of the list."""
        if self.values is None:
            low, high = self.ends
            return low + shares * (high - low)
        return self.on_grid((shares * self.count).astype(np.int64))


def to_axis_table(entry: Any) -> Any:
    """Return the table of an axis for an entry of a file, where a list stands for its values.

    Raises ValueError if the entry is neither a list nor a table.

    >>> to_axis_table([1, 2])
    {'values': [1, 2]}
    """
    if isinstance(entry, Axis | Mapping):
        return entry
    if isinstance(entry, list | tuple):
        return {"values": list(entry)}
    raise refused("", entry, "it must be a list of values, or { from = ..., to = ..., steps = ... }")
