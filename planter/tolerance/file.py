"""Tolerances: TOML in, a distribution for each input that has one out."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, ValidationError

from planter.errors import InputError
from planter.files.complaints import explain, refused
from planter.files.fields import Positive, Problems, Real, Section, check
from planter.files.paths import last_part
from planter.files.text import read_toml
from planter.sweeps.room import ResolvedMachine
from planter.tolerance.spread import Kind, Spread


class Tolerance(Section):
    """How far an input may be from its nominal value: `plus_minus` in its unit, `percent` of it, or `from` ... `to`.

    The distribution is normal with its ends at three standard deviations, or uniform from ... to, if it says nothing.
    """

    plus_minus: Positive | None = None
    percent: Positive | None = None
    low: Annotated[Real | None, Field(alias="from")] = None
    high: Annotated[Real | None, Field(alias="to")] = None
    distribution: Kind | None = None

    @check
    def _one_way_of_saying(self) -> Problems:
        said = self.model_dump(by_alias=True, exclude_none=True)
        ranged = self.low is not None and self.high is not None
        ways = [self.plus_minus is not None, self.percent is not None, ranged]
        if sum(ways) != 1 or (self.low is None) != (self.high is None):
            yield refused("", said, "it must have either plus_minus, or percent, or from and to")
        elif self.low is not None and self.high is not None and not self.low < self.high:
            yield refused("", said, "it must have from less than to")

    def spread(self, nominal: float) -> Spread:
        """The distribution about a nominal value, or between the ends."""
        if self.low is not None and self.high is not None:
            return Spread(self.distribution or "uniform", self.low, self.high)
        half = self.plus_minus if self.plus_minus is not None else abs(nominal) * (self.percent or 0) / 100
        return Spread(self.distribution or "normal", nominal - half, nominal + half)


class Tolerances(Section):
    """Tolerances by input: a name as `--set` takes it, or a pattern such as "mass.*" for all that it fits."""

    tolerances: Annotated[dict[str, Tolerance], Field(min_length=1)]

    @classmethod
    def load(cls, path: Path) -> Self:
        """Those in a file. Raises InputError, one sentence that names file, key, value and what is allowed."""
        return cls.read(read_toml(path), str(path))

    @classmethod
    def read(cls, table: Mapping[str, Any], source: str) -> Self:
        """Those of a table. Raises InputError as `load`."""
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise explain(error, source, cls) from None

    def spreads(self, held: ResolvedMachine, source: str) -> dict[str, Spread]:
        """The distribution of each input of a machine that has one; of several entries that fit the last counts.

        Raises InputError for an entry that fits no input, or leaves one no room.
        """
        nominal, found = held.room.nominal(held.machine), dict[str, Spread]()
        for name, tolerance in self.tolerances.items():
            for path in self._fitting(name, held, source):
                found[path] = tolerance.spread(nominal[path])
                if not found[path].low < found[path].high:
                    raise InputError(f"{source}: tolerances.{name} is not allowed: {path} is 0, it must be given "
                                     "plus_minus")  # fmt: skip
        return {path: found[path] for path in held.inputs if path in found}

    @staticmethod
    def _fitting(name: str, held: ResolvedMachine, source: str) -> list[str]:
        """Return the inputs that a name or a pattern means: full paths, or last parts if it fits no path."""
        is_pattern = "*" in name or "?" in name
        found = [path for path in held.inputs if is_pattern and fnmatchcase(path, name)]
        found = found or [path for path in held.inputs if is_pattern and fnmatchcase(last_part(path), name)]
        return found or [held.path(name, f"{source}: tolerances.{name}")]
