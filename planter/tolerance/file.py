"""Files of tolerances (TOML), and the distributions of inputs that they define."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, ValidationError

from planter.errors import InputError
from planter.files.fields import Positive, Problems, Real, Section, check, describe_problems, invalid_value_problem
from planter.files.paths import last_part
from planter.files.text import read_toml
from planter.sweeps.adapter import ResolvedMachine
from planter.tolerance.job import Kind, Spread


class Tolerance(Section):
    """Tolerance of an input about its nominal value: `plus_minus` in its unit, `percent` of it, or `from` ... `to`.

    The default distribution is normal with its ends at three standard deviations, or uniform for `from` ... `to`.
    """

    plus_minus: Positive | None = None
    percent: Positive | None = None
    low: Annotated[Real | None, Field(alias="from")] = None
    high: Annotated[Real | None, Field(alias="to")] = None
    distribution: Kind | None = None

    @check
    def _check_range(self) -> Problems:
        table = self.model_dump(by_alias=True, exclude_none=True)
        is_range = self.low is not None and self.high is not None
        if sum([self.plus_minus is not None, self.percent is not None, is_range]) != 1 or (self.low is None) != (
            self.high is None
        ):
            yield invalid_value_problem("", table, "it must have either plus_minus, or percent, or from and to")
        elif self.low is not None and self.high is not None and not self.low < self.high:
            yield invalid_value_problem("", table, "it must have from less than to")

    def spread(self, nominal: float) -> Spread:
        """Return the distribution about a nominal value, or between the ends."""
        if self.low is not None and self.high is not None:
            return Spread(self.distribution or "uniform", self.low, self.high)
        half = self.plus_minus if self.plus_minus is not None else abs(nominal) * (self.percent or 0) / 100
        return Spread(self.distribution or "normal", nominal - half, nominal + half)


class Tolerances(Section):
    """Tolerances by input: a name as in `--set`, or a pattern such as "mass.*" for all inputs that match it."""

    tolerances: Annotated[dict[str, Tolerance], Field(min_length=1)]

    @classmethod
    def load(cls, path: Path) -> Self:
        """Load tolerances from a file. Raises InputError, which names file, key, value and the allowed values."""
        return cls.read(read_toml(path), str(path))

    @classmethod
    def read(cls, table: Mapping[str, Any], source: str) -> Self:
        """Build tolerances from a table. Raises InputError as `load`."""
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise describe_problems(error, source, cls) from None

    def spreads(self, resolved: ResolvedMachine, source: str) -> dict[str, Spread]:
        """Return the distributions of the inputs with a tolerance; of several entries that match, the last counts.

        Raises InputError if an entry matches no input, or has no width.
        """
        nominal, spreads = resolved.adapter.nominal(resolved.machine), dict[str, Spread]()
        for name, tolerance in self.tolerances.items():
            for path in self._matches(name, resolved, source):
                spreads[path] = tolerance.spread(nominal[path])
                if not spreads[path].low < spreads[path].high:
                    raise InputError(f"{source}: tolerances.{name}: {path} is 0; use plus_minus")
        return {path: spreads[path] for path in resolved.inputs if path in spreads}

    @staticmethod
    def _matches(name: str, resolved: ResolvedMachine, source: str) -> list[str]:
        """Return the inputs that a name or a pattern matches, by full paths, else by the last parts of paths."""
        is_pattern = "*" in name or "?" in name
        matches = [path for path in resolved.inputs if is_pattern and fnmatchcase(path, name)]
        matches = matches or [path for path in resolved.inputs if is_pattern and fnmatchcase(last_part(path), name)]
        return matches or [resolved.path(name, f"{source}: tolerances.{name}")]
