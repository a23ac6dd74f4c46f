"""Terms that a formula lacks: a number times names of its text, found from the values that it should have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from ..quantity import NONE, Dimension
from .formula import Name, read_formula
from .names import PointNames
from .values import Scalar

LARGEST = 24
"""Largest numerator and denominator of a number before a term."""
CLOSE = 1e-9
"""Relative difference of values that are equal."""
DIGITS = 6
"""Digits of logarithms by which pairs of factors are looked up; what is found is compared by `CLOSE`."""
POWERS = (1, 2)


@dataclass(frozen=True)
class NamedFactor:
    """A name with its power, or the sine or cosine of an angle, in LaTeX, with its values at the points."""

    latex: str
    values: Any
    dimension: Dimension
    symbol: str


class MonomialSearch:
    """The products of at most four factors, which are names of a text, that have given values at points."""

    def __init__(self, names: PointNames, vocabulary: Sequence[str]) -> None:
        self.factors = [factor for spelling in vocabulary for factor in _list_factors(names, spelling)]

    def find(self, values: Any, dimension: Dimension | None) -> Iterator[str]:
        """Yield the LaTeX of products with numbers that have values (points,) and a dimension, short ones first."""
        values = np.asarray(values, dtype=float)
        if not (np.all(np.isfinite(values)) and np.all(values != 0) and len(values) > 1):
            return
        target = _compare_logarithms(values)
        seen: set[tuple[str, ...]] = set()
        for size in range(5):
            for factors in self._of_size(size, target):
                key = tuple(sorted(factor.latex for factor in factors))
                if key in seen or _repeats(factors) or not _fits(factors, dimension):
                    continue
                seen.add(key)
                number = _find_number(values, factors)
                if number is not None:
                    yield " ".join(filter(None, (_format_number(number, bool(factors)), *key)))

    def _of_size(self, size: int, target: Any) -> Iterator[tuple[NamedFactor, ...]]:
        """Yield products of a number of factors whose logarithms change as the target's do from point to point."""
        if size < 2:
            yield from (some for some in self._by_change[size].get(_round(target), ()))
            return
        for first in self._tuples[size - 2]:
            rest = target - sum((_compare_logarithms(factor.values) for factor in first), np.zeros_like(target))
            yield from ((*first, *second) for second in self._by_change[2].get(_round(rest), ()))

    @cached_property
    def _tuples(self) -> list[list[tuple[NamedFactor, ...]]]:
        return [list(combinations_with_replacement(self.factors, size)) for size in range(3)]

    @cached_property
    def _by_change(self) -> list[dict[tuple[float, ...], list[tuple[NamedFactor, ...]]]]:
        """Tuples of none, one or two factors by the change of their logarithm from point to point."""
        tables: list[dict[tuple[float, ...], list[tuple[NamedFactor, ...]]]] = []
        for some in self._tuples:
            table: dict[tuple[float, ...], list[tuple[NamedFactor, ...]]] = {}
            for factors in some:
                values = np.prod([factor.values for factor in factors], axis=0) if factors else np.ones(self._points)
                table.setdefault(_round(_compare_logarithms(values)), []).append(factors)
            tables.append(table)
        return tables

    @property
    def _points(self) -> int:
        return len(self.factors[0].values) if self.factors else 2


def _list_factors(names: PointNames, spelling: str) -> Iterator[NamedFactor]:
    node = read_formula(f"{spelling} = 0").sides[0]
    value = names.look_up(node.symbol) if isinstance(node, Name) and names.is_known(node.symbol) else None
    if not isinstance(value, Scalar) or value.dimension is None:
        return
    values = np.asarray(value.value, dtype=float)
    if not (np.all(np.isfinite(values)) and np.all(values != 0)):
        return
    for power in POWERS:
        kg, m, s = (power * part for part in value.dimension)
        yield NamedFactor(f"{spelling}^{power}" if power > 1 else spelling, values**power, (kg, m, s), spelling)
    if value.angular and value.dimension == NONE:
        for function, shape in (("\\sin", np.sin), ("\\cos", np.cos)):
            yield NamedFactor(f"{function} {spelling}", shape(values), NONE, f"{function} {spelling}")


def _compare_logarithms(values: Any) -> Any:
    logarithms = np.log(np.abs(values))
    return logarithms[1:] - logarithms[0]


def _round(changes: Any) -> tuple[float, ...]:
    return tuple((np.round(changes, DIGITS) + 0.0).tolist())


def _repeats(factors: Sequence[NamedFactor]) -> bool:
    """Return whether a name stands twice, instead of with a power."""
    return len({factor.symbol for factor in factors}) < len(factors)


def _fits(factors: Sequence[NamedFactor], dimension: Dimension | None) -> bool:
    return dimension is None or tuple(sum(f.dimension[k] for f in factors) for k in range(3)) == tuple(dimension)


def _find_number(values: Any, factors: Sequence[NamedFactor]) -> Fraction | None:
    """Return the number that values are of a product at all points, None if it is no simple one."""
    product = np.prod([factor.values for factor in factors], axis=0) if factors else np.ones(len(values))
    ratios = values / product
    number = Fraction(float(ratios[0])).limit_denominator(LARGEST)
    if not 0 < abs(number.numerator) <= LARGEST or np.any(np.abs(ratios - float(number)) > CLOSE * np.abs(ratios)):
        return None
    return number


def _format_number(number: Fraction, is_factor: bool) -> str:
    size = abs(number)
    text = str(size.numerator) if size.denominator == 1 else rf"\frac{{{size.numerator}}}{{{size.denominator}}}"
    return ("- " if number < 0 else "") + ("" if is_factor and size == 1 else text)
