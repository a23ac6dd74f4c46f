"""Terms that a formula lacks, found from the values that they should have: a number times names of
its text, in a sum of vectors times a vector, or a product of vectors.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations, permutations, product
from typing import Any

import numpy as np

from ...quantity import NONE, Dimension, raise_dimension
from ..products import CLOSE, ProductFactor, ProductSearch
from .formula import RelationChain
from .interpretation import interpret_formula, look_up_spelling
from .names import PointNames
from .values import Scalar, VectorValue

POWERS = (1, 2)
_FUNCTION = re.compile(r"\\(?:sin|cos)\b")
"""Factors that stand after names, as in print."""
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
            labels = (factor.label for factor in factors)
            spellings = sorted(labels, key=lambda label: (bool(_FUNCTION.match(label)), label))
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
    return ("-" if number < 0 else "") + ("" if is_factor and size == 1 else text)


MOST_VECTORS = 24
"""Vectors of a text of which products are tried, those of a row first."""


def list_vector_terms(
    chain: RelationChain,
    index: int,
    names: PointNames,
    words: Sequence[str],
    search: MonomialSearch,
) -> Iterator[tuple[int, str]]:
    """Yield ends of the sides of a row of vectors, each with a term in LaTeX, with its sign, that
    the side may lack.
    """
    sides = interpret_formula(chain, names).sides
    count = 0
    for place, (left, relation, right) in enumerate(
        zip(sides, chain.relations, sides[1:], strict=False)
    ):
        if relation == "~":
            continue
        if not isinstance(left, VectorValue) or not isinstance(right, VectorValue):
            return
        count += 3
        if index < count:
            gap = _components(left, names) - _components(right, names)
            vectors = dict(_list_vectors(names, words))
            for side, lacking in ((place + 1, gap), (place, -gap)):
                for term in _list_terms(lacking, vectors, search):
                    yield chain.sides[side].end, term
            return


def _components(value: VectorValue, names: PointNames) -> Any:
    """Return the components (points, 3) of a vector along the axes of the world."""
    components = names.resolve(value, names.world).components
    return np.stack(
        [np.broadcast_to(c.value, len(names.points)).astype(float) for c in components], axis=1
    )


def _list_vectors(names: PointNames, words: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield vectors among names in LaTeX, with their components (points, 3)."""
    for word in words:
        value = look_up_spelling(names, word)
        if isinstance(value, VectorValue) and np.all(
            np.isfinite(components := _components(value, names))
        ):
            yield f"{{}}{word}" if word.startswith("^") else word, components


def _list_terms(lacking: Any, vectors: dict[str, Any], search: MonomialSearch) -> Iterator[str]:
    """Yield terms equal to a vector (points, 3): of one vector, of two, or of one twice as in w x
    (w x r).
    """
    for word, vector in vectors.items():
        factor = _find_factor(lacking, vector)
        for scalar in search.find(factor, None) if factor is not None else ():
            sign, size = ("-", scalar[1:].strip()) if scalar.startswith("-") else ("+", scalar)
            yield f" {sign} {word}" if size == "1" else f" {sign} {size} {word}"
    terms: dict[int, list[str]] = {1: [], -1: []}
    for first, second in permutations(list(vectors)[:MOST_VECTORS], 2):
        once: Any = np.cross(vectors[first], vectors[second])
        twice: Any = np.cross(vectors[first], once)
        products = (
            (rf"{first} \times {second}", once),
            (rf"{first} \times ({first} \times {second})", twice),
        )
        for (word, vector), sign in product(products, (1, -1)):
            factor = _find_factor(sign * lacking, vector)
            if factor is not None and np.all(np.abs(factor - 1) <= CLOSE):
                terms[sign].append(f" {'+' if sign == 1 else '-'} {word}")
    yield from (*terms[1], *terms[-1])


def _find_factor(lacking: Any, vector: Any) -> Any:
    """Return the values (points,) by which a vector (points, 3) times them is another, None if it
    is not along it.
    """
    squares = np.sum(vector**2, axis=1)
    if not np.all(squares > 0):
        return None
    factor = np.sum(lacking * vector, axis=1) / squares
    gaps = np.linalg.norm(lacking - factor[:, None] * vector, axis=1)
    return (
        factor
        if np.all(gaps <= CLOSE * np.linalg.norm(lacking, axis=1)) and np.any(factor)
        else None
    )
