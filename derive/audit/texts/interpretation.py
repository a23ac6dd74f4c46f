"""What formulas mean once their names do: sides as values, where several readings are possible the
consistent one.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce

from ...mechanics.frames import Frame
from ...quantity import NONE
from .formula import (
    Bracket,
    Cases,
    Constant,
    Derivative,
    FormulaError,
    FunctionCall,
    Heading,
    Magnitude,
    Matrix,
    Name,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    RelationChain,
    Slash,
    Sum,
    Symbol,
    Transposed,
    read_formula,
)
from .values import (
    Algebra,
    MatrixValue,
    OperandError,
    Scalar,
    Value,
    VectorValue,
    add_values,
    check_expanded,
    check_tower,
    multiply_values,
)

MOST_READINGS = 32
"""Readings of a formula that are tried."""
_VECTOR_PRODUCTS = ("\\cdot", "\\times", "\\wedge")


class UnknownNameError(FormulaError):
    """A name without a meaning."""

    def __init__(self, symbol: Symbol) -> None:
        super().__init__(f"nothing says what {symbol.spell()} is")
        self.symbol = symbol


class Meanings(ABC):
    """Meanings of names, in an algebra; derivatives are known of exact ones alone."""

    algebra: Algebra

    @abstractmethod
    def look_up(self, symbol: Symbol) -> Value:
        """Return the meaning of a name. Raises UnknownNameError if it has none."""

    @abstractmethod
    def is_known(self, symbol: Symbol) -> bool:
        """Return whether a name has a meaning."""

    @abstractmethod
    def resolve(self, vector: VectorValue, frame: Frame) -> VectorValue:
        """Return a vector along the axes of another frame."""

    def find_derivative(self, key: str, build: Callable[[Meanings], Value]) -> Value | None:
        """Return a derivative that only exact meanings have, by a key of its formula; None where
        these are exact.
        """
        return None

    def rate(self, value: Value, seen_from: str = "") -> Value:
        """Return the time derivative of a value, of a vector as a frame sees it.

        Raises FormulaError if not known.
        """
        raise FormulaError("a derivative has no values at points")

    def partial(self, value: Scalar, symbol: Symbol) -> Value:
        """Return the partial derivative of a value to a name, a column of them to a name of a
        column.

        Raises FormulaError if the name is none of the variables.
        """
        return self.rate(value)

    def total(self, value: Value, symbol: Symbol) -> Value:
        """Return the derivative of a value to a name along the motion.

        Raises FormulaError where it may be partial.
        """
        return self.rate(value)


def look_up_spelling(names: Meanings, spelling: str) -> Value | None:
    """Return the meaning of a name in LaTeX, None if it has none."""
    node = read_formula(f"{spelling} = 0").sides[0]
    if not isinstance(node, Name) or not names.is_known(node.symbol):
        return None
    return names.look_up(node.symbol)


@dataclass(frozen=True)
class Read:
    """Meaning of a row: the values of its sides, the relations between them, and notes on choices
    of the reading.

    A heading, such as the sum sign before a name, has the value None.
    """

    sides: tuple[Value | None, ...]
    relations: tuple[str, ...]
    notes: tuple[str, ...] = ()

    def residuals(self, meanings: Meanings) -> list[tuple[int, str, Scalar, Scalar]]:
        """List index of the relation, relation, left and right of each pair of sides, vectors by
        their components.

        An approximation has none: it says nothing that values could contradict.
        """
        residuals = []
        pairs = zip(self.sides, self.relations, self.sides[1:], strict=False)
        for index, (left, relation, right) in enumerate(pairs):
            if left is not None and right is not None and relation != "~":
                residuals += [(index, relation, a, b) for a, b in _entries(left, right, meanings)]
        return residuals

    def is_consistent(self, meanings: Meanings) -> bool:
        """Return whether all that the row joins and compares has one dimension."""
        return not any((left + (-right)).mixed for _, _, left, right in self.residuals(meanings))


def _entries(left: Value, right: Value, meanings: Meanings) -> list[tuple[Scalar, Scalar]]:
    left, right = (
        v.rows[0][0] if isinstance(v, MatrixValue) and v.shape == (1, 1) else v
        for v in (left, right)
    )
    if isinstance(left, Scalar) and isinstance(right, Scalar):
        return [(left, right)]
    if isinstance(left, Scalar) and left.dimension is None:
        return [(left, entry) for entry in list_scalars(right)]
    if isinstance(right, Scalar) and right.dimension is None:
        return [(entry, right) for entry in list_scalars(left)]
    if isinstance(left, VectorValue) and isinstance(right, VectorValue):
        return list(
            zip(meanings.resolve(left, right.frame).components, right.components, strict=True)
        )
    if isinstance(left, VectorValue | MatrixValue) and isinstance(right, VectorValue | MatrixValue):
        first, second = list_scalars(left), list_scalars(right)
        shapes = {
            value.shape if isinstance(value, MatrixValue) else (3, 1) for value in (left, right)
        }
        if len(shapes) == 1:
            return list(zip(first, second, strict=True))
    raise OperandError("the sides are of different kinds: a number, a vector, a matrix")


def list_scalars(value: Value) -> list[Scalar]:
    """Return a number alone, the components of a vector, or the entries of a matrix."""
    if isinstance(value, Scalar):
        return [value]
    return list(value.components) if isinstance(value, VectorValue) else value.entries


def interpret_formula(chain: RelationChain, meanings: Meanings) -> Read:
    """Return what a formula says, by the reading that is dimensionally consistent if several are
    possible.

    If none is consistent, a reading counts only if all others multiply or add what cannot be.

    Raises UnknownNameError for a name without a meaning, FormulaError for an operation that has no
    meaning, and if readings that differ are equally consistent.
    """
    readings: list[Read] = []
    inconsistent: list[Read] = []
    failures: list[FormulaError] = []
    for reader in _list_readers(chain, meanings):
        try:
            read = reader.read(chain)
            for scalar in (
                scalar for side in read.sides if side is not None for scalar in list_scalars(side)
            ):
                check_expanded(scalar.value)
            consistent = read.is_consistent(meanings)
        except OperandError as error:
            failures.append(FormulaError(str(error)))
            continue
        except UnknownNameError:
            raise
        except FormulaError as error:
            failures.append(error)
            continue
        if consistent or not reader.options:
            readings.append(read)
        else:
            inconsistent.append(read)
    if not readings and len(inconsistent) == 1 and failures:
        return inconsistent[0]
    distinct: list[Read] = []
    for read in readings:
        if not any(_same(read, other, meanings) for other in distinct):
            distinct.append(read)
    if len(distinct) == 1:
        return distinct[0]
    if distinct:
        raise FormulaError("it can be read in several ways that all fit the units: add brackets")
    if failures and not inconsistent:
        raise failures[0]
    raise FormulaError("it can be read in several ways of which none fits the units: add brackets")


def _same(first: Read, second: Read, meanings: Meanings) -> bool:
    pairs = zip(first.residuals(meanings), second.residuals(meanings), strict=False)
    return len(first.residuals(meanings)) == len(second.residuals(meanings)) and all(
        a[2].value == b[2].value and a[3].value == b[3].value for a, b in pairs
    )


def _list_readers(chain: RelationChain, meanings: Meanings) -> Iterator[Interpreter]:
    """Yield an interpreter for each combination of answers to what is ambiguous."""
    answers: list[int] = []
    for _ in range(MOST_READINGS):
        reader = Interpreter(meanings, list(answers))
        yield reader
        options = reader.options
        answers = [*reader.answers, *[0] * (len(options) - len(reader.answers))][: len(options)]
        while answers and answers[-1] + 1 >= options[len(answers) - 1]:
            answers.pop()
        if not answers:
            return
        answers[-1] += 1
    raise FormulaError("it can be read in too many ways: add brackets")


@dataclass
class Interpreter:
    """Evaluates trees; ``answers`` choose among the readings of what is ambiguous, ``options``
    counts these.
    """

    meanings: Meanings
    answers: list[int]
    options: list[int] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def read(self, chain: RelationChain) -> Read:
        """Return the sides of a row as values."""
        sides = tuple(
            None if isinstance(side, Heading) else self.value(side) for side in chain.sides
        )
        return Read(sides, chain.relations, tuple(dict.fromkeys(self.notes)))

    def _choose(self, count: int) -> int:
        index = len(self.options)
        self.options.append(count)
        return self.answers[index] if index < len(self.answers) else 0

    def value(self, node: Node) -> Value:
        """Return the value of a tree. Raises FormulaError or OperandError."""
        method = getattr(self, f"_{type(node).__name__.lower()}")
        value: Value = method(node)
        return value

    def scalar(self, node: Node) -> Scalar:
        """Return the value of a tree that must be a number."""
        value = self.value(node)
        if isinstance(value, MatrixValue) and value.shape == (1, 1):
            return value.rows[0][0]
        if not isinstance(value, Scalar):
            raise OperandError("a vector or matrix stands where a number must")
        return value

    def _number(self, node: Number) -> Value:
        number = self.meanings.algebra.number(node.value)
        return Scalar(number, None if node.value == 0 else NONE)

    def _constant(self, node: Constant) -> Value:
        pi = self.meanings.algebra.pi
        return Scalar(pi / 180, NONE, 1) if node.name == "degree" else Scalar(pi, NONE, 1)

    def _name(self, node: Name) -> Value:
        return self.meanings.look_up(node.symbol)

    def _sum(self, node: Sum) -> Value:
        signs: list[Value] = []
        for sign, term in node.terms:
            value = self.value(term)
            if abs(sign) == 2:
                raise FormulaError("a plus-minus sign is not read: state the equation for one sign")
            signs.append(-value if sign < 0 else value)
        return reduce(self._added, signs)

    def _added(self, first: Value, second: Value) -> Value:
        return add_values(first, second, self.meanings.resolve)

    def _product(self, node: Product) -> Value:
        product: Value | None = None
        waiting: tuple[str, Value] | None = (
            None  # in r x m a, the cross and what is known of its second vector
        )
        index, factors = 0, node.factors
        while index < len(factors):
            operator, factor = factors[index]
            following = factors[index + 1] if index + 1 < len(factors) else None
            value = self._maybe_called(factor, following)
            if value is None:
                value = self.value(factor)
            else:
                index += 1
            index += 1
            if waiting is not None and product is not None:
                if not operator:
                    waiting = waiting[0], self._multiplied(waiting[1], "", value)
                    if isinstance(waiting[1], Scalar):
                        continue
                    product, waiting = self._multiplied(product, *waiting), None
                    continue
                product, waiting = self._multiplied(product, "", waiting[1]), None
            if (
                isinstance(product, VectorValue)
                and isinstance(value, Scalar)
                and operator in _VECTOR_PRODUCTS
            ):
                waiting = operator, value
                continue
            product = value if product is None else self._multiplied(product, operator, value)
        assert product is not None
        return product if waiting is None else self._multiplied(product, "", waiting[1])

    def _maybe_called(self, factor: Node, following: tuple[str, Node] | None) -> Value | None:
        """Return the value of a name that is followed by what it depends on, None if it is a
        product.

        A name before brackets with nothing but names in them, as in F(x), may be either, and units
        must decide; so may its power, as in M^{-1}(q).
        """
        named = factor.base if isinstance(factor, Power) else factor
        if not isinstance(named, Name) or following is None or following[0]:
            return None
        bracket = following[1]
        if not isinstance(bracket, Bracket) or not all(
            isinstance(part, Name) for part in bracket.parts
        ):
            return None
        if len(bracket.parts) == 1 and not self._choose(2):
            return None
        return self.value(factor)

    def _multiplied(self, first: Value, operator: str, second: Value) -> Value:
        return multiply_values(first, operator, second, self.meanings.resolve)

    def _slash(self, node: Slash) -> Value:
        above = self.value(node.above)
        below = self.scalar(node.below)
        if not node.rest:
            return self._multiplied(above, "", below.inverse())
        rest = Product(node.start, node.end, node.rest)
        decided = isinstance(node.below, Number | Bracket) or (
            isinstance(node.below, Power) and isinstance(node.below.base, Bracket)
        )
        if not decided and self._choose(2):
            return self._multiplied(above, "", (below * self.scalar(rest)).inverse())
        return self._multiplied(self._multiplied(above, "", below.inverse()), "", self.value(rest))

    def _quotient(self, node: Quotient) -> Value:
        return self._multiplied(self.value(node.above), "", self.scalar(node.below).inverse())

    def _power(self, node: Power) -> Value:
        base_symbol = node.base.symbol if isinstance(node.base, Name) else None
        if node.symbol is not None and self.meanings.is_known(node.symbol):
            return self.meanings.look_up(node.symbol)
        if base_symbol == Symbol("e") and not self.meanings.is_known(Symbol("e")):
            return self._apply("exp", [self.scalar(node.exponent)])
        base, exponent = self.value(node.base), self.scalar(node.exponent)
        if base_symbol == Symbol("e") and not isinstance(node.exponent, Number):
            raise FormulaError(
                "e is both a name here and, with this exponent, may be the base of exponentials"
            )
        if isinstance(base, VectorValue):
            if isinstance(node.exponent, Number) and node.exponent.value == 2:
                return self._multiplied(base, "\\cdot", base)
            raise OperandError("a power of a vector")
        if isinstance(base, MatrixValue):
            if exponent.value == -1:
                return base.inverse()
            raise OperandError("a power of a matrix")
        return base.power(exponent)

    def _transposed(self, node: Transposed) -> Value:
        if isinstance(node.base, Bracket) and len(node.base.parts) > 1:
            return MatrixValue(tuple((self.scalar(part),) for part in node.base.parts))
        base = self.value(node.base)
        if isinstance(base, VectorValue):
            return MatrixValue((base.components,))
        return base.transposed() if isinstance(base, MatrixValue) else base

    def _bracket(self, node: Bracket) -> Value:
        if len(node.parts) == 1:
            return self.value(node.parts[0])
        raise FormulaError("a list in brackets is not read")

    def _magnitude(self, node: Magnitude) -> Value:
        inner = self.value(node.inner)
        if isinstance(inner, VectorValue):
            square = self._multiplied(inner, "\\cdot", inner)
            assert isinstance(square, Scalar)
            return square.power(Scalar(self.meanings.algebra.number(Fraction(1, 2))))
        if isinstance(inner, MatrixValue):
            return inner.determinant()
        value = self.meanings.algebra.functions["abs"](inner.value)
        return Scalar(value, inner.dimension, inner.angular, inner.mixed)

    def _apply(self, function: str, arguments: list[Scalar]) -> Scalar:
        values = [argument.value for argument in arguments]
        mixed = any(argument.mixed for argument in arguments)
        dimensions = {a.dimension for a in arguments if a.dimension is not None}
        if function in ("exp", "sinh", "cosh", "tanh"):
            check_tower(values[0])
        result = self.meanings.algebra.functions[function](*values)
        if function in ("min", "max", "abs"):
            common = next(iter(dimensions), None)
            return Scalar(
                result, common, max(a.angular for a in arguments), mixed or len(dimensions) > 1
            )
        if function in ("atan2", "sgn"):
            return Scalar(result, NONE, int(function == "atan2"), mixed or len(dimensions) > 1)
        angular = 1 if function in ("asin", "acos", "atan") else 0
        return Scalar(result, NONE, angular, mixed or bool(dimensions - {NONE}))

    def _functioncall(self, node: FunctionCall) -> Value:
        counts = {"atan2": (2,), "min": range(1, 9), "max": range(1, 9), "atan": (1, 2)}
        outside: Value | None = None
        if node.arguments:
            arguments = [self.scalar(argument) for argument in node.arguments]
            function = "atan2" if node.function == "atan" and len(arguments) == 2 else node.function
            if len(arguments) not in counts.get(function, (1,)):
                raise FormulaError(f"{function} of {len(arguments)} arguments is not read")
        else:
            function = node.function
            inside, outside = self._split_factors(node)
            arguments = [inside]
        value = self._apply(function, arguments)
        if node.exponent is not None:
            value = value.power(self.scalar(node.exponent))
        return value if outside is None else self._multiplied(value, "", outside)

    def _split_factors(self, node: FunctionCall) -> tuple[Scalar, Value | None]:
        """Return the argument of a function without brackets, and the product of the factors after
        it.

        The argument ends with the first factor that makes it an angle, else with the last one that
        leaves it a pure number.
        """
        scalars: list[Scalar] = []
        for _, factor in node.factors:
            value = self.value(factor)
            if not isinstance(value, Scalar):
                break
            scalars.append(value)
        if not scalars:
            raise OperandError(f"{node.function} of a vector or matrix")
        products = [scalars[0]]
        for scalar in scalars[1:]:
            products.append(products[-1] * scalar)
        kinds = [product.kind for product in products]
        trigonometric = node.function in ("sin", "cos", "tan", "cot", "sec", "csc")
        if trigonometric and "angle" in kinds:
            size = kinds.index("angle") + 1
        elif (
            (pure := [k for k, kind in enumerate(kinds) if kind != "unit"]) and not trigonometric
        ) or pure:
            size = pure[-1] + 1
        else:
            size = 1
        if len(node.factors) > size and any(kind != "unit" for kind in kinds[size:]):
            name = node.function
            self.notes.append(f"the argument of {name} is read as its first {size} factors")
        inside = -products[size - 1] if node.negative else products[size - 1]
        rest = node.factors[size:]
        return inside, self.value(Product(node.start, node.end, rest)) if rest else None

    def _derivative(self, node: Derivative) -> Value:
        key = re.sub(r"start=\d+, end=\d+(, )?", "", repr(node))
        derivative = self.meanings.find_derivative(
            key, lambda exact: Interpreter(exact, []).value(node)
        )
        if derivative is not None:
            return derivative
        value = self.value(node.inner)
        if node.is_total and node.by is not None:
            if self.meanings.is_known(Symbol("d")):
                raise FormulaError(
                    "d is both a name here and, in this fraction, may be that of a derivative"
                )
            return self.meanings.total(value, node.by)
        for _ in range(node.order):
            if node.by is None:
                value = self.meanings.rate(value, node.seen_from)
            elif isinstance(value, Scalar):
                value = self.meanings.partial(value, node.by)
            else:
                raise OperandError("a partial derivative of a vector or matrix")
        return value

    def _matrix(self, node: Matrix) -> Value:
        grid = MatrixValue(tuple(tuple(self.scalar(entry) for entry in row) for row in node.rows))
        return grid.determinant() if node.kind == "det" else grid

    def _cases(self, node: Cases) -> Value:
        values = [self.scalar(value) for value, _ in node.pieces]
        algebra = self.meanings.algebra
        pieces, default = [], None
        for (_, condition), value in zip(node.pieces, values, strict=True):
            if condition is None:
                default = value.value
                continue
            sides = [self.scalar(side) for side in condition.sides]
            truths = [
                algebra.relations[relation](a.value, b.value)
                for a, relation, b in zip(sides, condition.relations, sides[1:], strict=False)
            ]
            if not truths:
                raise FormulaError("a case without a condition")
            pieces.append((value.value, reduce(lambda a, b: a & b, truths)))
        total = reduce(Scalar.__add__, values)
        return Scalar(algebra.cases(pieces, default), total.dimension, total.angular, total.mixed)
