"""Values of formulas, symbolic or at points: scalars with their dimension, vectors with their
frame, matrices.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from math import comb, prod
from typing import Any, TypeAlias

import numpy as np
import sympy as sp

from ...mechanics.frames import Frame
from ...quantity import NONE, Dimension, Quantity, of_unit, raise_dimension
from ..edits import ARRAY_FUNCTIONS

LARGEST_EXPONENT, MOST_BITS, MOST_EXPANDED = 100, 4096, 20_000
"""Limits of an exponent, of the binary digits of a number, and of the terms of an expanded
formula.
"""
HIGHEST_TOWER = 2
"""Exponentials within each other; of one more, the value has more digits than a memory holds."""


class OperandError(ValueError):
    """An operation that has no meaning for its operands, or whose result is too large."""


def check_power(base: Any, exponent: Any) -> None:
    """Raise OperandError for a power that SymPy would compute or expand without end."""
    if not (isinstance(base, sp.Basic) and isinstance(exponent, sp.Basic)):
        return
    if not exponent.is_Rational:
        check_tower(exponent)
        return
    if max(abs(exponent.p), exponent.q) > LARGEST_EXPONENT:
        text = (
            str(exponent)
            if exponent.p.bit_length() + exponent.q.bit_length() < 64
            else "many digits"
        )
        raise OperandError(
            f"a power of {text}: exponents up to {LARGEST_EXPONENT} are read, and parts of as many"
        )
    if (
        base.is_Rational
        and max(abs(base.p).bit_length(), base.q.bit_length()) * abs(exponent) > MOST_BITS
    ):
        raise OperandError(f"a number with more than {MOST_BITS} binary digits")


def check_tower(exponent: Any) -> None:
    """Raise OperandError for an exponent that is itself a power of powers, as in 2^{3^{4^x}}."""
    if isinstance(exponent, sp.Basic) and _count_tower(exponent) >= HIGHEST_TOWER:
        raise OperandError(
            f"more than {HIGHEST_TOWER} powers or exponentials stand within each other"
        )


def check_expanded(expr: Any) -> None:
    """Raise OperandError for a formula whose expansion would have too many terms."""
    if isinstance(expr, sp.Basic) and _count_terms(expr, {}) > MOST_EXPANDED:
        raise OperandError(
            f"expanded it would have more than {MOST_EXPANDED} terms: give parts of it a name"
        )


def _count_tower(expr: sp.Basic) -> int:
    """Return how many powers with unknown exponents and exponentials stand within each other at
    most.
    """
    inner = max((_count_tower(argument) for argument in expr.args), default=0)
    is_exponential = isinstance(expr, sp.exp) or (
        isinstance(expr, sp.Pow) and not expr.exp.is_Rational
    )
    return inner + is_exponential


def _count_terms(expr: sp.Basic, counted: dict[sp.Basic, int]) -> int:
    """Return how many terms the expansion of an expression has at most, and of its parts the
    most.
    """
    if expr in counted:
        return counted[expr]
    counts = [_count_terms(argument, counted) for argument in expr.args]
    if isinstance(expr, sp.Add):
        count = sum(counts)
    elif isinstance(expr, sp.Mul):
        count = prod(counts)
    elif isinstance(expr, sp.Pow) and expr.exp.is_Integer:
        # multisets of terms, as many as the exponent says
        count = comb(counts[0] + abs(int(expr.exp)) - 1, counts[0] - 1)
    else:
        count = 1 if max(counts, default=1) <= MOST_EXPANDED else max(counts)
    counted[expr] = count
    return count


@dataclass(frozen=True)
class Scalar:
    """A number with its dimension, None for a zero that fits everywhere.

    ``angular`` counts factors in radian, by which angles differ from other pure numbers. ``mixed``
    says that what does not fit was added or fed to a function.
    """

    value: Any
    dimension: Dimension | None = NONE
    angular: int = 0
    mixed: bool = False

    def __add__(self, other: Scalar) -> Scalar:
        dimension = self.dimension if self.dimension is not None else other.dimension
        clash = None not in (self.dimension, other.dimension) and self.dimension != other.dimension
        angular = max(self.angular, other.angular)
        return Scalar(
            self.value + other.value, dimension, angular, clash or self.mixed or other.mixed
        )

    def __neg__(self) -> Scalar:
        return Scalar(-self.value, self.dimension, self.angular, self.mixed)

    def __mul__(self, other: Scalar) -> Scalar:
        zero = self.dimension is None or other.dimension is None
        dimension = None if zero else _added(self.dimension or NONE, other.dimension or NONE)
        return Scalar(
            self.value * other.value,
            dimension,
            self.angular + other.angular,
            self.mixed or other.mixed,
        )

    def scaled(self, factor: Scalar) -> Scalar:
        """Return the product with a factor, as of vectors and matrices."""
        return factor * self

    def power(self, exponent: Scalar) -> Scalar:
        """Return a power, whose dimension is known if the exponent is a number or the base has
        none.
        """
        check_power(self.value, exponent.value)
        number = _as_fraction(exponent.value)
        mixed = self.mixed or exponent.mixed or exponent.dimension not in (None, NONE)
        if self.dimension in (None, NONE):
            return Scalar(
                self.value**exponent.value,
                self.dimension,
                0 if number != 1 else self.angular,
                mixed,
            )
        if number is None:
            return Scalar(self.value**exponent.value, NONE, 0, True)
        assert self.dimension is not None
        angular = self.angular * number.numerator if number.denominator == 1 else 0
        return Scalar(
            self.value**exponent.value, raise_dimension(self.dimension, number), angular, mixed
        )

    def inverse(self) -> Scalar:
        """Return one over the scalar."""
        dimension = (
            None
            if self.dimension is None
            else (-self.dimension[0], -self.dimension[1], -self.dimension[2])
        )
        return Scalar(1 / self.value, dimension, -self.angular, self.mixed)

    @property
    def kind(self) -> str:
        """Whether it is an ``angle``, another pure ``number``, or has a ``unit``."""
        if self.dimension not in (None, NONE):
            return "unit"
        return "angle" if self.angular else "number"


def _added(first: Dimension, second: Dimension) -> Dimension:
    return first[0] + second[0], first[1] + second[1], first[2] + second[2]


def _as_fraction(value: Any) -> Fraction | None:
    if isinstance(value, sp.Rational):
        return Fraction(value.p, value.q)
    if isinstance(value, int | Fraction):
        return Fraction(value)
    if isinstance(value, np.ndarray | float):
        numbers = np.unique(np.asarray(value, dtype=float))
        exact = Fraction(float(numbers[0])).limit_denominator(64) if len(numbers) == 1 else None
        return exact if exact is not None and float(exact) == float(numbers[0]) else None
    return None


def quantity_scalar(quantity: Quantity) -> Scalar:
    """Return the scalar of a quantity."""
    angular = 1 if quantity.unit.split("/")[0] == "rad" else 0
    return Scalar(quantity, of_unit(quantity.unit), angular)


@dataclass(frozen=True)
class VectorValue:
    """Components along the axes of a frame."""

    frame: Frame
    components: tuple[Scalar, Scalar, Scalar]

    def __neg__(self) -> VectorValue:
        x, y, z = self.components
        return VectorValue(self.frame, (-x, -y, -z))

    def scaled(self, factor: Scalar) -> VectorValue:
        """Return the vector times a scalar."""
        x, y, z = self.components
        return VectorValue(self.frame, (factor * x, factor * y, factor * z))

    def shared_unit(self) -> tuple[Scalar, bool]:
        """Return the component that has the dimension of all, and whether any mixes dimensions."""
        with_unit = (c for c in self.components if c.dimension is not None)
        return next(with_unit, self.components[0]), any(c.mixed for c in self.components)


@dataclass(frozen=True)
class MatrixValue:
    """A matrix of scalars, by rows."""

    rows: tuple[tuple[Scalar, ...], ...]

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.rows), len(self.rows[0])

    @property
    def entries(self) -> list[Scalar]:
        """All entries, row by row."""
        return [entry for row in self.rows for entry in row]

    def __neg__(self) -> MatrixValue:
        return MatrixValue(tuple(tuple(-entry for entry in row) for row in self.rows))

    def transposed(self) -> MatrixValue:
        """Return the transposed matrix."""
        return MatrixValue(tuple(zip(*self.rows, strict=True)))

    def added(self, other: MatrixValue) -> MatrixValue:
        """Return the sum. Raises OperandError for matrices of different shapes."""
        if self.shape != other.shape:
            raise OperandError(f"matrices of {self.shape} and {other.shape} are added")
        pairs = zip(self.rows, other.rows, strict=True)
        return MatrixValue(
            tuple(tuple(a + b for a, b in zip(*rows, strict=True)) for rows in pairs)
        )

    def times(self, other: MatrixValue) -> MatrixValue:
        """Return the product of matrices. Raises OperandError for shapes that do not fit."""
        if self.shape[1] != other.shape[0]:
            raise OperandError(f"matrices of {self.shape} and {other.shape} are multiplied")
        columns = list(zip(*other.rows, strict=True))
        return MatrixValue(
            tuple(
                tuple(
                    reduce(Scalar.__add__, (a * b for a, b in zip(row, c, strict=True)))
                    for c in columns
                )
                for row in self.rows
            )
        )

    def scaled(self, factor: Scalar) -> MatrixValue:
        """Return the matrix times a scalar."""
        return MatrixValue(tuple(tuple(factor * entry for entry in row) for row in self.rows))

    def determinant(self) -> Scalar:
        """Return the determinant by its first row.

        Raises OperandError for a matrix that is not square.
        """
        if self.shape[0] != self.shape[1]:
            raise OperandError("the determinant of a matrix that is not square")
        if self.shape == (1, 1):
            return self.rows[0][0]
        parts = []
        for index, entry in enumerate(self.rows[0]):
            minor = MatrixValue(
                tuple(row[:index] + row[index + 1 :] for row in self.rows[1:])
            ).determinant()
            parts.append(entry * minor if index % 2 == 0 else -(entry * minor))
        return reduce(Scalar.__add__, parts)

    def inverse(self) -> MatrixValue:
        """Return the inverse by cofactors.

        Raises OperandError for a matrix that is not square, or has none.
        """
        determinant = self.determinant()
        if isinstance(determinant.value, sp.Basic) and determinant.value.is_zero:
            raise OperandError("the inverse of a singular matrix")
        if self.shape == (1, 1):
            return MatrixValue(((determinant.inverse(),),))
        indices = range(self.shape[0])

        def cofactor(row: int, column: int) -> Scalar:
            lines = [
                line[:column] + line[column + 1 :] for k, line in enumerate(self.rows) if k != row
            ]
            minor = MatrixValue(tuple(lines)).determinant()
            return -minor if (row + column) % 2 else minor

        adjugate = MatrixValue(
            tuple(tuple(cofactor(row, column) for row in indices) for column in indices)
        )
        return adjugate.scaled(determinant.inverse())


Value: TypeAlias = Scalar | VectorValue | MatrixValue
Resolve: TypeAlias = Callable[[VectorValue, Frame], VectorValue]
"""Returns a vector along the axes of a frame."""


def add_values(first: Value, second: Value, resolve: Resolve) -> Value:
    """Return a sum; a zero may be added to anything. Raises OperandError for other kinds."""
    if isinstance(first, Scalar) and isinstance(second, Scalar):
        return first + second
    if isinstance(first, VectorValue) and isinstance(second, VectorValue):
        other = resolve(second, first.frame)
        x, y, z = (a + b for a, b in zip(first.components, other.components, strict=True))
        return VectorValue(first.frame, (x, y, z))
    if isinstance(first, MatrixValue) and isinstance(second, MatrixValue):
        return first.added(second)
    for zero, rest in ((first, second), (second, first)):
        if isinstance(zero, Scalar) and zero.dimension is None:
            return rest
    raise OperandError("a number, a vector and a matrix are added")


def multiply_values(first: Value, operator: str, second: Value, resolve: Resolve) -> Value:
    """Return a product; vectors need a dot or a cross as ``operator``, else it raises
    OperandError.
    """
    if isinstance(first, Scalar):
        return second.scaled(first)
    if isinstance(second, Scalar):
        return first.scaled(second)
    if isinstance(first, MatrixValue):
        if isinstance(second, VectorValue):
            return first.times(MatrixValue(tuple((c,) for c in second.components)))
        product = first.times(second)
        return product.rows[0][0] if product.shape == (1, 1) else product
    if isinstance(second, VectorValue):
        a, b = first.components, resolve(second, first.frame).components
        if operator == "\\cdot":
            return reduce(Scalar.__add__, (x * y for x, y in zip(a, b, strict=True)))
        if operator in ("\\times", "\\wedge"):
            cross = (
                a[1] * b[2] + -(a[2] * b[1]),
                a[2] * b[0] + -(a[0] * b[2]),
                a[0] * b[1] + -(a[1] * b[0]),
            )
            return VectorValue(first.frame, cross)
    raise OperandError("vectors are multiplied without a dot or cross")


@dataclass(frozen=True)
class Algebra:
    """Arithmetic that formulas are evaluated in: functions of values by name, numbers, cases and
    relations.
    """

    functions: Mapping[str, Any]
    number: Callable[[Fraction], Any]
    pi: Any
    relations: Mapping[str, Callable[[Any, Any], Any]]
    cases: Callable[[Sequence[tuple[Any, Any]], Any], Any]


def _cases_symbolic(pieces: Sequence[tuple[Any, Any]], default: Any) -> Any:
    last = [] if default is None else [(default, sp.true)]
    return sp.Piecewise(*pieces, *last)


def _cases_numeric(pieces: Sequence[tuple[Any, Any]], default: Any) -> Any:
    values, conditions = [v for v, _ in pieces], [np.asarray(c) for _, c in pieces]
    values = [np.broadcast_to(np.asarray(v, dtype=float), conditions[0].shape) for v in values]
    return np.select(conditions, values, np.nan if default is None else default)


_NAMESAKES = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc, sp.sinh, sp.cosh, sp.tanh, sp.exp)
_INVERSES = (sp.asin, sp.acos, sp.atan, sp.atan2)
SYMBOLIC = Algebra(
    {
        **{function.__name__: function for function in (*_NAMESAKES, *_INVERSES)},
        "ln": sp.log,
        "log": sp.log,
        "sgn": sp.sign,
        "min": sp.Min,
        "max": sp.Max,
        "abs": sp.Abs,
    },
    lambda number: sp.Rational(number.numerator, number.denominator),
    sp.pi,
    {"<": sp.Lt, "<=": sp.Le, ">": sp.Gt, ">=": sp.Ge, "=": sp.Eq},
    _cases_symbolic,
)
NUMERIC = Algebra(
    {name: ARRAY_FUNCTIONS[function] for name, function in SYMBOLIC.functions.items()},
    float,
    np.pi,
    {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "=": np.equal},
    _cases_numeric,
)
