"""Terms that a formula lacks: a number times names of its text, found from the values that it should have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations, combinations_with_replacement
from typing import Any

import numpy as np

from ..quantity import NONE, Dimension, raise_dimension
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
MOST_ANGLES = 4
"""Angles of which functions of two are tried."""
MOST_NAMES = 60
"""Names of a text that are tried, those of a row first."""


@dataclass(frozen=True)
class NamedFactor:
    """A name with its power, or the sine or cosine of an angle, in LaTeX, with its values at the points."""

    latex: str
    values: Any
    dimension: Dimension
    symbol: str


class MonomialSearch:
    """The products of at most four factors, which are names of a text, that have given values at points.

    Of values only the change of their logarithm from point to point counts at first: it adds up over the factors of a
    product, and numbers do not matter to it.
    """

    def __init__(self, names: PointNames, vocabulary: Sequence[str]) -> None:
        words = vocabulary[:MOST_NAMES]
        self.factors = [factor for spelling in words for factor in _list_factors(names, spelling)]
        self.factors += _list_functions_of_two(names, words)

    def find(self, values: Any, dimension: Dimension | None) -> Iterator[str]:
        """Yield the LaTeX of products with numbers that have values (points,) and a dimension, short ones first."""
        values = np.asarray(values, dtype=float)
        if not (np.all(np.isfinite(values)) and np.all(values != 0) and len(values) > 1):
            return
        seen: set[tuple[str, ...]] = set()
        for places in self._list_candidates(_compare_logarithms(values)):
            factors = [self.factors[place] for place in places]
            key = tuple(sorted(factor.latex for factor in factors))
            if key in seen or _repeats(factors) or not _fits(factors, dimension):
                continue
            seen.add(key)
            number = _find_number(values, factors)
            if number is not None:
                yield " ".join(filter(None, (_format_number(number, bool(factors)), *key)))

    def _list_candidates(self, target: Any) -> Iterator[tuple[int, ...]]:
        """Yield the places of factors whose product changes from point to point as the target does (points - 1,)."""
        if not np.any(_round_changes(target)):
            yield ()
        if not self.factors:
            return
        singles, pairs, table = self._tables
        (key,) = _list_keys(target[None])
        yield from ((place,) for place, other in enumerate(_list_keys(singles)) if other == key)
        yield from table.get(key, ())
        for place, rest in enumerate(_list_keys(target - singles)):
            yield from ((place, *pair) for pair in table.get(rest, ()))
        firsts = list(combinations_with_replacement(range(len(self.factors)), 2))
        for first, rest in zip(firsts, _list_keys(target - pairs), strict=True):
            yield from ((*first, *pair) for pair in table.get(rest, ()))

    @cached_property
    def _tables(self) -> tuple[Any, Any, dict[bytes, list[tuple[int, int]]]]:
        """Changes of single factors and of pairs, and the pairs by their change."""
        singles = np.array([_compare_logarithms(factor.values) for factor in self.factors])
        places = list(combinations_with_replacement(range(len(singles)), 2))
        first, second = np.array(places).T
        pairs = singles[first] + singles[second]
        table: dict[bytes, list[tuple[int, int]]] = {}
        for pair, key in zip(places, _list_keys(pairs), strict=True):
            table.setdefault(key, []).append(pair)
        return singles, pairs, table


def _find_scalar(names: PointNames, spelling: str) -> Scalar | None:
    """Return the values of a name without zeros among them, None if it has none."""
    node = read_formula(f"{spelling} = 0").sides[0]
    value = names.look_up(node.symbol) if isinstance(node, Name) and names.is_known(node.symbol) else None
    if not isinstance(value, Scalar) or value.dimension is None:
        return None
    values = np.asarray(value.value, dtype=float)
    return value if np.all(np.isfinite(values)) and np.all(values != 0) else None


def _list_factors(names: PointNames, spelling: str) -> Iterator[NamedFactor]:
    value = _find_scalar(names, spelling)
    if value is None or value.dimension is None:
        return
    values = np.asarray(value.value, dtype=float)
    for power in POWERS:
        dimension = raise_dimension(value.dimension, power)
        yield NamedFactor(f"{spelling}^{power}" if power > 1 else spelling, values**power, dimension, spelling)
    if value.angular and value.dimension == NONE:
        for function, shape in (("\\sin", np.sin), ("\\cos", np.cos)):
            yield NamedFactor(f"{function} {spelling}", shape(values), NONE, f"{function} {spelling}")


def _list_functions_of_two(names: PointNames, words: Sequence[str]) -> Iterator[NamedFactor]:
    """Yield the sines and cosines of differences and sums of two of the first angles."""
    pairs = ((word, _find_scalar(names, word)) for word in words)
    scalars = {word: value for word, value in pairs if value is not None}
    angles = [word for word, value in scalars.items() if value.angular and value.dimension == NONE]
    for first, second in combinations(angles[:MOST_ANGLES], 2):
        a, b = (np.asarray(scalars[word].value, dtype=float) for word in (first, second))
        for sign, values in (("-", a - b), ("+", a + b)):
            for function, shape in (("\\sin", np.sin), ("\\cos", np.cos)):
                latex = f"{function}({first} {sign} {second})"
                if np.all(shape(values) != 0):
                    yield NamedFactor(latex, shape(values), NONE, latex)


def _compare_logarithms(values: Any) -> Any:
    logarithms = np.log(np.abs(values))
    return logarithms[1:] - logarithms[0]


def _round_changes(changes: Any) -> Any:
    return np.round(changes * 10**DIGITS).astype(np.int64)


def _list_keys(changes: Any) -> list[bytes]:
    """Return what rows of changes (n, points - 1) are looked up by."""
    return [row.tobytes() for row in _round_changes(changes)]


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
