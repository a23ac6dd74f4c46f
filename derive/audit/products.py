"""Products that have given values at points, found from factors by the values of their
logarithms.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations_with_replacement, islice
from typing import Any, Generic, TypeVar

import numpy as np

from ..quantity import Dimension

LARGEST = 24
"""Largest numerator and denominator of a number before a product."""
CLOSE = 1e-9
"""Relative difference of values that are equal."""
DIGITS = 6
"""Digits of logarithms by which pairs of factors are looked up; what is found is compared by
`CLOSE`.
"""
MOST_CANDIDATES = 100_000
"""Products that are compared, at most: where data are the same at all points, all products of data
are candidates.
"""
_MIXING = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
"""Odd numbers that mix the changes of a product from point to point to one number."""

Label = TypeVar("Label")


@dataclass(frozen=True)
class ProductFactor(Generic[Label]):
    """A factor by its label, with its values (points,) and dimension; ``base`` is what stands once
    in a product.
    """

    label: Label
    values: Any
    dimension: Dimension | None
    base: str


class ProductSearch(Generic[Label]):
    """The products of a few factors that have given values at points.

    Of values only the change of their logarithm from point to point counts at first: it adds up
    over the factors of a product, and numbers do not matter to it. ``max_factors`` is the number of
    factors at most, 4 or 5.
    """

    def __init__(self, factors: Sequence[ProductFactor[Label]], max_factors: int = 4) -> None:
        self.factors, self.max_factors = factors, max_factors

    def find(
        self, values: Any, dimension: Dimension | None
    ) -> Iterator[tuple[Fraction, list[ProductFactor[Label]]]]:
        """Yield numbers with the factors of products that have values (points,) and a dimension,
        short ones first.
        """
        values = np.asarray(values, dtype=float)
        if not (np.all(np.isfinite(values)) and np.all(values != 0) and len(values) > 1):
            return
        seen: set[frozenset[int]] = set()
        for places in islice(self._list_candidates(_compare_logarithms(values)), MOST_CANDIDATES):
            factors, key = [self.factors[place] for place in places], frozenset(places)
            if (
                key in seen
                or len({factor.base for factor in factors}) < len(factors)
                or not _fits(factors, dimension)
            ):
                continue
            seen.add(key)
            number = _find_number(values, factors)
            if number is not None:
                yield number, factors

    def _list_candidates(self, target: Any) -> Iterator[tuple[int, ...]]:
        """Yield the places of factors whose product changes from point to point as the target does
        (points - 1,).
        """
        if not np.any(_round_changes(target)):
            yield ()
        if not self.factors:
            return
        singles, pairs, places = self._tables
        yield from (
            (int(place),)
            for place in np.flatnonzero(_list_keys(singles) == _list_keys(target[None]))
        )
        yield from ((*places[row],) for row, _ in self._look_up(target[None]))
        yield from ((place, *places[row]) for row, place in self._look_up(target - singles))
        yield from ((*places[first], *places[row]) for row, first in self._look_up(target - pairs))
        for fifth, single in enumerate(singles if self.max_factors > 4 else ()):
            yield from (
                (fifth, *places[first], *places[row])
                for row, first in self._look_up(target - single - pairs)
            )

    def _look_up(self, changes: Any) -> Iterator[tuple[int, int]]:
        """Yield the rows of pairs with given changes (n, points - 1), each with the place of the
        changes.
        """
        keys, order = self._sorted_keys
        target_keys = _list_keys(changes)
        first, last = (
            np.searchsorted(keys, target_keys, "left"),
            np.searchsorted(keys, target_keys, "right"),
        )
        for place in np.flatnonzero(first < last):
            yield from ((int(row), int(place)) for row in order[first[place] : last[place]])

    @cached_property
    def _tables(self) -> tuple[Any, Any, list[tuple[int, int]]]:
        """Changes of single factors and of pairs, and the places of the pairs' factors."""
        singles = np.array([_compare_logarithms(factor.values) for factor in self.factors])
        places = list(combinations_with_replacement(range(len(singles)), 2))
        first, second = np.array(places).T
        return singles, singles[first] + singles[second], places

    @cached_property
    def _sorted_keys(self) -> tuple[Any, Any]:
        """Keys of the pairs in order, and the rows that they are those of."""
        keys = _list_keys(self._tables[1])
        order = np.argsort(keys, kind="stable")
        return keys[order], order


def _compare_logarithms(values: Any) -> Any:
    logarithms = np.log(np.abs(values))
    return logarithms[1:] - logarithms[0]


def _round_changes(changes: Any) -> Any:
    return np.round(changes * 10**DIGITS).astype(np.int64)


def _list_keys(changes: Any) -> Any:
    """Return what rows of changes (n, points - 1) are looked up by (n,)."""
    rounded = _round_changes(changes).astype(np.uint64)
    keys = np.zeros(len(rounded), dtype=np.uint64)
    for column in range(rounded.shape[1]):
        keys = (keys ^ rounded[:, column]) * _MIXING[column % len(_MIXING)]
    return keys


def _fits(factors: Sequence[ProductFactor[Any]], dimension: Dimension | None) -> bool:
    if dimension is None:
        return True
    parts = [factor.dimension for factor in factors if factor.dimension is not None]
    return tuple(sum(part[k] for part in parts) for k in range(3)) == tuple(dimension)


def _find_number(values: Any, factors: Sequence[ProductFactor[Any]]) -> Fraction | None:
    """Return the number that values are of a product at all points, None if it is no simple one."""
    product = (
        np.prod([factor.values for factor in factors], axis=0) if factors else np.ones(len(values))
    )
    ratios = values / product
    number = Fraction(float(ratios[0])).limit_denominator(LARGEST)
    if not 0 < abs(number.numerator) <= LARGEST or np.any(
        np.abs(ratios - float(number)) > CLOSE * np.abs(ratios)
    ):
        return None
    return number
