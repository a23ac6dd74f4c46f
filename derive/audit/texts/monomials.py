"""Terms that a formula lacks: a number times names of its text, found from the values that it
should have.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np

from ...quantity import NONE, Dimension, raise_dimension
from ..products import ProductFactor, ProductSearch
from .interpretation import look_up_spelling
from .names import PointNames
from .values import Scalar

POWERS = (1, 2)
MOST_ANGLES = 4
"""Angles of which functions of two are tried."""
MOST_NAMES = 60
"""Names of a text that are tried, those of a row first."""


class MonomialSearch:
    """The products of at most four factors, which are names of a text, that have given values at
    points.
    """

    def __init__(self, names: PointNames, vocabulary: Sequence[str]) -> None:
        words = vocabulary[:MOST_NAMES]
        factors = [factor for spelling in words for factor in _list_factors(names, spelling)]
        self._search = ProductSearch([*factors, *_list_functions_of_two(names, words)])

    def find(self, values: Any, dimension: Dimension | None) -> Iterator[str]:
        """Yield the LaTeX of products with numbers that have values (points,) and a dimension,
        short ones first.
        """
        for number, factors in self._search.find(values, dimension):
            spellings = sorted(factor.label for factor in factors)
            yield " ".join(filter(None, (_format_number(number, bool(factors)), *spellings)))


def _find_scalar(names: PointNames, spelling: str) -> Scalar | None:
    """Return the values of a name without zeros among them, None if it has none."""
    value = look_up_spelling(names, spelling)
    if not isinstance(value, Scalar) or value.dimension is None:
        return None
    values = np.asarray(value.value, dtype=float)
    return value if np.all(np.isfinite(values)) and np.all(values != 0) else None


def _list_factors(names: PointNames, spelling: str) -> Iterator[ProductFactor[str]]:
    value = _find_scalar(names, spelling)
    if value is None or value.dimension is None:
        return
    values = np.asarray(value.value, dtype=float)
    for power in POWERS:
        dimension = raise_dimension(value.dimension, power)
        yield ProductFactor(
            f"{spelling}^{power}" if power > 1 else spelling, values**power, dimension, spelling
        )
    if value.angular and value.dimension == NONE:
        for function, shape in (("\\sin", np.sin), ("\\cos", np.cos)):
            yield ProductFactor(
                f"{function} {spelling}", shape(values), NONE, f"{function} {spelling}"
            )


def _list_functions_of_two(names: PointNames, words: Sequence[str]) -> Iterator[ProductFactor[str]]:
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
                    yield ProductFactor(latex, shape(values), NONE, latex)


def _format_number(number: Fraction, is_factor: bool) -> str:
    size = abs(number)
    text = (
        str(size.numerator)
        if size.denominator == 1
        else rf"\frac{{{size.numerator}}}{{{size.denominator}}}"
    )
    return ("- " if number < 0 else "") + ("" if is_factor and size == 1 else text)
