"""What the names of a text mean: quantities, frames and points of a mechanism, by a table and by
their spelling.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

import mpmath
import numpy as np
import sympy as sp
from sympy import Expr

from ...evaluate import Point
from ...formulas import Formulas
from ...generated_folder import OwnError
from ...mechanics.bodies import Body, kinetic_energy, potential_energy
from ...mechanics.frames import Frame, Vec, displacement, unit
from ...mechanics.frames import Point as Place
from ...mechanics.mechanism import TIME, Mechanism
from ...quantity import DimensionError, Quantity, dimension
from .formula import FormulaError, Reader, Symbol, tokenize_formula
from .interpretation import Meanings, UnknownNameError, list_scalars
from .values import (
    NUMERIC,
    SYMBOLIC,
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
    quantity_scalar,
)

AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
STEMS = {
    "varphi": "phi",
    "vartheta": "theta",
    "varepsilon": "epsilon",
    "varrho": "rho",
    "lambda": "lam",
    "ell": "l",
}
"""Names of print that are spelled otherwise in a mechanism."""
LONGEST_MEANING = 10_000
"""Characters of the meaning of a name."""
Stated = Mechanism | Formulas
T = TypeVar("T", Frame, Place)


def find_stated(module: ModuleType) -> Stated:
    """Return the mechanism or the formulas that a module states.

    Raises OwnError unless there is one.
    """
    matches = {
        id(part): part for part in vars(module).values() if isinstance(part, Mechanism | Formulas)
    }
    if len(matches) != 1:
        names = ", ".join(part.name for part in matches.values()) or "none"
        raise OwnError(
            f"{module.__file__}: --against needs a file that states one Mechanism or Formulas, "
            f"not {names}"
        )
    return next(iter(matches.values()))


def to_scalar(expr: Expr) -> Scalar:
    """Return an expression of quantities as a scalar."""
    if isinstance(expr, Quantity):
        return quantity_scalar(expr)
    expr = sp.sympify(expr)
    turning = any(
        isinstance(s, Quantity) and s.unit.split("/")[0] == "rad" for s in expr.free_symbols
    )
    try:
        of_expr, mixed = dimension(expr), False
    except DimensionError:
        of_expr, mixed = None, True
    return Scalar(expr, of_expr, int(turning and not expr.is_Function), mixed)


@dataclass
class NameTable:
    """The entries of a names file: meanings by spelling, texts as they were written, and what it
    says of rows.

    A ``#`` in a spelling stands for letters and digits that are put for the ``#`` of its meaning.
    """

    meanings: dict[str, str] = field(default_factory=dict)
    rows: dict[str, dict[str, Any]] = field(default_factory=dict)
    macros: dict[str, tuple[int, str]] = field(default_factory=dict)
    until_s: float | None = None
    file: str = ""

    def find(self, spelling: str) -> str | None:
        """Return the text of the meaning of a spelling, None if there is no entry, empty if there
        is no meaning.
        """
        if spelling in self.meanings:
            return self.meanings[spelling]
        for pattern, meaning in self.meanings.items():
            if "#" in pattern:
                parts = [re.escape(part) for part in pattern.split("#")]
                match = re.fullmatch("([A-Za-z0-9]+)".join(parts), spelling)
                if match and len(set(match.groups())) == 1:
                    return meaning.replace("#", match.group(1))
        return None


def spell_name(latex: str, macros: Mapping[str, tuple[int, str]] | None = None) -> str:
    """Return the one spelling of a printed name. Raises FormulaError if it is no name."""
    pattern = latex.replace("#", r"\mathrm{HASH}")
    reader = Reader(pattern, tokenize_formula(pattern, macros))
    framed = reader.peek() == "^" or (reader.peek() == "{" and reader.peek(1) == "}")
    symbol = None if framed else reader.try_symbol()
    if symbol is None or reader.peek() == "^":
        reader.at = 0
        symbol = getattr(reader.factor(), "symbol", None)
    if symbol is None or reader.peek():
        raise FormulaError(f"{latex} is no name")
    spelled: str = symbol.spell()
    return spelled.replace("HASH", "#")


def read_name_table(path: Path) -> NameTable:
    """Read a names file.

    Raises OwnError, which names the file and the key, for what it must not hold.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise OwnError(f"{path}: {reason}") from None
    for key in content:
        if key not in ("names", "rows", "until_s", "macros"):
            raise OwnError(
                f"{path}: {key}: no such key; it may hold [names], [rows], [macros] and until_s"
            )
    table = NameTable(file=str(path))
    for name, body in _section(content, "macros", path).items():
        if not re.fullmatch(r"\\[A-Za-z]+", name) or not isinstance(body, str):
            raise OwnError(f"{path}: macros.{name}: write '\\name' = \"what it stands for\"")
        table.macros[name] = max(map(int, re.findall(r"#(\d)", body)), default=0), body
    table.meanings = _read_meanings(
        _section(content, "names", path), f"{path}: names", table.macros
    )
    for number, entry in _section(content, "rows", path).items():
        if not isinstance(entry, dict) or not entry.keys() <= {"skip", "claims", "names"}:
            raise OwnError(f"{path}: rows.{number}: it may hold skip (a reason), claims and names")
        if not all(isinstance(entry.get(key, ""), str) for key in ("skip", "claims")):
            raise OwnError(f"{path}: rows.{number}: skip and claims must be text in quotes")
        meanings = _read_meanings(
            _section(entry, "names", path), f"{path}: rows.{number}.names", table.macros
        )
        table.rows[number] = {**entry, "names": meanings}
    until = content.get("until_s")
    if until is not None and (
        isinstance(until, bool) or not isinstance(until, int | float) or not until > 0
    ):
        raise OwnError(f"{path}: until_s = {until!r}: it must be a positive number of seconds")
    table.until_s = until
    return table


def _read_meanings(
    entries: Mapping[str, Any], place: str, macros: Mapping[str, tuple[int, str]]
) -> dict[str, str]:
    """Return the meanings of names by spelling. Raises OwnError, which begins with the place."""
    meanings: dict[str, str] = {}
    for name, meaning in entries.items():
        if not isinstance(meaning, str):
            raise OwnError(f"{place}.{name} = {meaning!r}: the meaning must be text in quotes")
        try:
            spelling = spell_name(name, macros)
        except FormulaError as error:
            raise OwnError(f"{place}.{name}: {error}") from None
        if meanings.setdefault(spelling, meaning) != meaning:
            raise OwnError(f"{place}.{name}: the name stands twice, also as {meanings[spelling]!r}")
    return meanings


def _section(content: Mapping[str, Any], name: str, path: Path) -> dict[str, Any]:
    section = content.get(name, {})
    if not isinstance(section, dict):
        raise OwnError(f"{path}: {name}: it must be a table [{name}]")
    return section


@dataclass
class StatedNames(Meanings):
    """Names of a text as expressions of a mechanism's quantities, or of formulas.

    ``abbreviations`` are abbreviations that the text itself defines, by their spelling.
    """

    stated: Stated
    quantities: Mapping[str, Quantity]
    table: NameTable
    module: ModuleType | None = None
    abbreviations: dict[str, Value] = field(default_factory=dict)
    algebra: Algebra = SYMBOLIC
    _meanings: dict[str, Value | None] = field(default_factory=dict)

    @cached_property
    def frames(self) -> dict[str, Frame]:
        """Frames of the mechanism by name: those that its file names, and the world."""
        world = {"world": self.stated.world} if isinstance(self.stated, Mechanism) else {}
        return self._list_parts(Frame) | world

    @cached_property
    def places(self) -> dict[str, Place]:
        """Points of the mechanism by name."""
        origin = {"O": self.stated.O} if isinstance(self.stated, Mechanism) else {}
        return self._list_parts(Place) | origin

    def _list_parts(self, kind: type[T]) -> dict[str, T]:
        """Return the frames or points that the file has, by its names and by their own."""
        variables = vars(self.module) if self.module else {}
        parts = {name: part for name, part in variables.items() if isinstance(part, kind)}
        return parts | {str(getattr(part, "name", "")): part for part in parts.values()}

    def with_meanings(self, meanings: Mapping[str, str]) -> StatedNames:
        """Return the names of a row in which some have other meanings than elsewhere in the
        text.
        """
        table = replace(self.table, meanings={**self.table.meanings, **meanings})
        return replace(self, table=table, _meanings={}) if meanings else self

    def is_known(self, symbol: Symbol) -> bool:
        """Return whether a name has a meaning."""
        return self._find(symbol) is not None

    def is_computed(self, symbol: Symbol) -> bool:
        """Return whether mechanics, not the names file alone, says what a name is: a rate, or a
        function of bodies.
        """
        text = self.table.find(symbol.spell())
        if text is None:
            return bool(symbol.dots) and self.guess(symbol) is None
        return any(re.search(rf"\b{function}\s*\(", text) for function in ("rate", *GEOMETRY))

    def look_up(self, symbol: Symbol) -> Value:
        """Return the meaning of a name. Raises UnknownNameError if it has none."""
        value = self._find(symbol)
        if value is None:
            raise UnknownNameError(symbol)
        return value

    def _find(self, symbol: Symbol) -> Value | None:
        spelling = symbol.spell()
        if spelling in self.abbreviations and not self.table.meanings.get(spelling):
            return self.abbreviations[spelling]
        if self._meanings.get(spelling) is None:  # the text may define what was unknown before
            self._meanings[spelling] = self._fresh(symbol)
        return self._meanings[spelling]

    def _fresh(self, symbol: Symbol) -> Value | None:
        text = self.table.find(symbol.spell())
        if text is not None:
            try:
                return self.evaluate(text, symbol.spell()) if text.strip() else None
            except OwnError:  # a pattern does not apply to what its meaning would not exist for
                if symbol.spell() in self.table.meanings:
                    raise
                return None
        quantity = self.guess(symbol)
        if symbol.dots and (quantity is None or self.table.find(symbol.base.spell())):
            return self._dotted(symbol)
        return None if quantity is None else to_scalar(quantity)

    def _dotted(self, symbol: Symbol) -> Value | None:
        """Return the rate of a name without its dots, None if that has no meaning or no rate."""
        value = self._find(symbol.base)
        try:
            for _ in range(symbol.dots if value is not None else 0):
                assert value is not None
                value = self.rate(value)
        except FormulaError:
            return None
        return value

    def guess(self, symbol: Symbol) -> Quantity | None:
        """Return the one quantity whose name a printed name spells, None if there is none or
        several.
        """
        if symbol == Symbol("t"):
            return (
                TIME if isinstance(self.stated, Mechanism) and self.stated.angle is None else None
            )
        if symbol.accents or symbol.primes or symbol.before or symbol.after:
            return None
        stem = symbol.stem.removeprefix("\\")
        rate = {0: "", 1: "_dot", 2: "_ddot", 3: "_dddot"}.get(symbol.dots)
        if rate is None:
            return None
        below = re.sub(r"[^A-Za-z0-9]", "", symbol.subscript)
        parts = re.sub(r"[^A-Za-z0-9]+", "_", symbol.subscript).strip("_")
        stems = dict.fromkeys((stem, STEMS.get(stem, stem), f"{stem}_"))
        names = [
            f"{form}{middle}{rate}"
            for form in stems
            for middle in dict.fromkeys((f"_{below}", f"_{parts}", below) if below else ("",))
        ]
        matches = {self.quantities[name] for name in names if name in self.quantities}
        return matches.pop() if len(matches) == 1 else None

    def resolve(self, vector: VectorValue, frame: Frame) -> VectorValue:
        """Return a vector along the axes of another frame."""
        if vector.frame == frame:
            return vector
        components = (
            Vec(vector.frame, _triple([c.value for c in vector.components]))
            .resolved(frame)
            .components
        )
        shared, mixed = vector.shared_unit()
        x, y, z = (
            Scalar(sp.sympify(c), None if c == 0 else shared.dimension, shared.angular, mixed)
            for c in components
        )
        return VectorValue(frame, (x, y, z))

    def rate(self, value: Value, seen_from: str | Frame = "") -> Value:
        """Return the time derivative, of a vector as seen from the world, or from a frame or the
        frame of a name.
        """
        if not isinstance(self.stated, Mechanism):
            raise FormulaError("formulas without bodies have no time derivatives")
        if isinstance(value, VectorValue):
            vector = Vec(value.frame, _triple([self._explicit(c.value) for c in value.components]))
            if isinstance(seen_from, str) and seen_from and seen_from not in self.frames:
                raise FormulaError(f"nothing says what the frame {seen_from} is")
            observer = (
                self.frames[seen_from or "world"] if isinstance(seen_from, str) else seen_from
            )
            return to_vector(self.stated.motion.relative_derivative(vector, observer))
        if isinstance(value, MatrixValue):
            return MatrixValue(
                tuple(tuple(self._scalar_rate(entry) for entry in row) for row in value.rows)
            )
        return self._scalar_rate(value)

    def _scalar_rate(self, value: Scalar) -> Scalar:
        assert isinstance(self.stated, Mechanism)
        rate = to_scalar(self.stated.motion.rate(self._explicit(value.value)))
        return Scalar(rate.value, rate.dimension, value.angular, rate.mixed)

    def _explicit(self, expr: Expr) -> Expr:
        """Return an expression in coordinates and rates.

        Raises FormulaError if it depends on forces.
        """
        expr = self._without_named(expr)
        assert isinstance(self.stated, Mechanism)
        if expr.free_symbols & set(self.stated.assembly.unknowns):
            raise FormulaError("the time derivative of what depends on forces is not known")
        return expr

    def _without_named(self, expr: Expr) -> Expr:
        """Return an expression in which what the mechanism names or reports stands with its
        expression.
        """
        assert isinstance(self.stated, Mechanism)
        lets = {let.symbol: let.expr for let in (*self.stated.named, *self.stated.reports)}
        expr = sp.sympify(expr)
        for _ in lets:
            present = {symbol: lets[symbol] for symbol in expr.free_symbols & lets.keys()}
            if not present:
                break
            expr = sp.sympify(expr.xreplace(present))
        return expr

    def partial(self, value: Scalar, symbol: Symbol) -> Value:
        """Return the partial derivative to a name of a single quantity, the column of them to a
        name of a column.
        """
        variable = self.look_up(symbol)
        if isinstance(variable, MatrixValue) and variable.shape[1] == 1:
            return MatrixValue(
                tuple((self._scalar_partial(value, entry, symbol),) for entry in variable.entries)
            )
        return self._scalar_partial(value, variable, symbol)

    def total(self, value: Value, symbol: Symbol) -> Value:
        """Return the derivative to a name along the motion, as dy/dx = y_dot/x_dot, of a number.

        Raises FormulaError for a function of the name and of what else moves: it may be meant at
        rest of the others.
        """
        variable = self.look_up(symbol)
        if not isinstance(value, Scalar) or not isinstance(variable, Scalar):
            raise FormulaError("a vector or matrix is derived to time t only")
        pace, change = self.rate(variable), self.rate(value)
        assert isinstance(pace, Scalar)
        assert isinstance(change, Scalar)
        if pace.value == 0:
            raise FormulaError(f"{symbol.spell()} does not move, so that nothing is derived by it")
        moving = {
            s
            for s in self._explicit(value.value).free_symbols
            if self._scalar_rate(to_scalar(s)).value != 0
        }
        if variable.value in moving and len(moving) > 1:
            raise FormulaError(
                f"the derivative by {symbol.spell()} of what depends on more: write a partial one"
            )
        return change * pace.inverse()

    def _scalar_partial(self, value: Scalar, variable: Value, symbol: Symbol) -> Scalar:
        if not isinstance(variable, Scalar) or not isinstance(variable.value, sp.Symbol):
            raise FormulaError(
                f"{symbol.spell()} is no single quantity, so that nothing is derived by it"
            )
        inner = sp.sympify(value.value)
        if isinstance(self.stated, Mechanism):
            lets = {let.symbol for let in (*self.stated.named, *self.stated.reports)}
            if variable.value in lets - inner.free_symbols:
                raise FormulaError(
                    f"{symbol.spell()} depends on other quantities, so that nothing is derived by "
                    f"it"
                )
            unnamed = sp.Dummy()
            inner = self._without_named(inner.xreplace({variable.value: unnamed})).xreplace(
                {unnamed: variable.value}
            )
        return to_scalar(inner.diff(variable.value))

    def evaluate(self, text: str, name: str = "") -> Value:
        """Return what the text of a meaning says.

        Raises OwnError, which names file and key, if it says nothing.
        """
        place = (
            f"{self.table.file}: names.{name} = {text!r}"
            if self.table.file
            else f"{name} = {text!r}"
        )
        if len(text) > LONGEST_MEANING:
            place = f"{self.table.file}: names.{name}" if self.table.file else name
            raise OwnError(
                f"{place}: {len(text)} characters; a meaning has at most {LONGEST_MEANING}"
            )
        try:
            value = self._evaluated(ast.parse(text.strip(), mode="eval").body)
            if isinstance(value, Scalar | VectorValue | MatrixValue):
                for scalar in list_scalars(value):
                    check_expanded(scalar.value)
            return value
        except (
            OperandError,
            FormulaError,
            ValueError,
            TypeError,
            ArithmeticError,
        ) as error:
            raise OwnError(f"{place}: {error}") from None
        except (SyntaxError, RecursionError, MemoryError):
            raise OwnError(
                f"{place}: write names, numbers, + - * / **, functions and brackets"
            ) from None

    def _evaluated(self, node: ast.AST) -> Any:
        if (
            isinstance(node, ast.Constant)
            and isinstance(node.value, int | float)
            and not isinstance(node.value, bool)
        ):
            number = sp.Rational(str(node.value))
            return Scalar(number, None if number == 0 else to_scalar(number).dimension)
        if isinstance(node, ast.Name):
            return self._named(node.id)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
            inner = self._evaluated(node.operand)
            return -inner if isinstance(node.op, ast.USub) else inner
        if isinstance(node, ast.BinOp):
            return self._operate(node.op, self._evaluated(node.left), self._evaluated(node.right))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            return self._called(node.func.id, [self._evaluated(argument) for argument in node.args])
        raise ValueError("write names, numbers, + - * / **, functions and brackets")

    def _operate(self, kind: ast.operator, left: Any, right: Any) -> Value:
        if isinstance(left, Value) and isinstance(right, Value):
            if isinstance(kind, ast.Add | ast.Sub):
                return add_values(
                    left, right if isinstance(kind, ast.Add) else -right, self.resolve
                )
            if isinstance(kind, ast.Mult):
                return multiply_values(left, "", right, self.resolve)
            if isinstance(kind, ast.Div) and isinstance(right, Scalar):
                return multiply_values(left, "", right.inverse(), self.resolve)
            if isinstance(kind, ast.Pow) and isinstance(left, Scalar) and isinstance(right, Scalar):
                return left.power(right)
        raise ValueError("an operation between things that it is not defined for")

    def _named(self, name: str) -> Any:
        if name in self.quantities:
            return to_scalar(self.quantities[name])
        if name == "pi":
            return Scalar(sp.pi, to_scalar(sp.pi).dimension, 1)
        for some in (self.frames, self.places):
            if name in some:
                return some[name]
        from difflib import get_close_matches

        close = get_close_matches(name, [*self.quantities, *self.frames, *self.places], 3)
        hint = f"; near it: {', '.join(close)}" if close else ""
        raise ValueError(f"{self.stated.name} has nothing called {name}{hint}")

    def _called(self, function: str, arguments: list[Any]) -> Any:
        if function in SYMBOLIC.functions or function == "sqrt":
            if not all(isinstance(argument, Scalar) for argument in arguments):
                raise ValueError(f"{function} needs numbers")
            if function == "sqrt":
                return arguments[0].power(Scalar(sp.Rational(1, 2)))
            if function in ("exp", "sinh", "cosh", "tanh"):
                check_tower(arguments[0].value)
            return to_scalar(
                SYMBOLIC.functions[function](*(argument.value for argument in arguments))
            )
        if function == "rate" and (
            len(arguments) == 1 or (len(arguments) == 2 and isinstance(arguments[1], Frame))
        ):
            return self.rate(*arguments)
        if function == "matrix":
            return _build_matrix(arguments)
        if function in GEOMETRY and isinstance(self.stated, Mechanism):
            operation, needed, further = GEOMETRY[function]
            kinds = (*needed, *further)[: max(len(arguments), len(needed))]
            if len(kinds) != len(arguments) or not all(map(isinstance, arguments, kinds)):
                words = ", ".join(KINDS[kind] for kind in needed)
                raise ValueError(f"it needs {words} in brackets")
            return operation(self.stated, *arguments)
        functions = ", ".join((*SYMBOLIC.functions, "sqrt", "rate", "matrix", *GEOMETRY))
        raise ValueError(f"{function} is not known; known are {functions}")


def _build_matrix(arguments: list[Any]) -> MatrixValue:
    """Return the matrix of a number of rows and the entries row by row, a column if it has as many
    rows as entries.
    """
    if len(arguments) < 2 or not all(isinstance(argument, Scalar) for argument in arguments):
        raise ValueError("matrix needs the number of its rows and its entries, row by row")
    rows, *entries = arguments
    if not (rows.value.is_Integer and rows.value > 0) or len(entries) % rows.value:
        raise ValueError(f"{len(entries)} entries do not fill {rows.value} rows")
    width = len(entries) // int(rows.value)
    return MatrixValue(
        tuple(tuple(entries[at : at + width]) for at in range(0, len(entries), width))
    )


def _triple(some: Iterable[Any]) -> tuple[Any, Any, Any]:
    x, y, z = some
    return x, y, z


def to_vector(vec: Vec) -> VectorValue:
    """Return a vector of mechanics as a value."""
    return VectorValue(vec.frame, _triple(to_scalar(c) for c in vec.components))


Operation = Callable[..., Value]


def _axis(_: Mechanism, frame: Frame, number: Scalar) -> VectorValue:
    return to_vector(unit(frame, AXES[_index(number, "an axis")]))


def _index(number: Scalar, subject: str) -> int:
    if number.value not in (1, 2, 3):
        raise ValueError(f"{subject} is 1, 2 or 3")
    return int(number.value) - 1


def _spin(stated: Mechanism, frame: Frame, seen_from: Frame | None = None) -> VectorValue:
    return to_vector(stated.motion.spin(frame, seen_from))


def _spin_rate(stated: Mechanism, frame: Frame, seen_from: Frame | None = None) -> VectorValue:
    observer = seen_from or stated.world
    spin = stated.motion.spin(frame, None if observer == stated.world else observer)
    return to_vector(stated.motion.relative_derivative(spin, observer))


def _position(stated: Mechanism, end: Place, start: Place | None = None) -> VectorValue:
    return to_vector(displacement(start or stated.O, end, stated.world))


def _velocity(stated: Mechanism, place: Place) -> VectorValue:
    return to_vector(stated.velocity(place))


def _acceleration(stated: Mechanism, place: Place) -> VectorValue:
    return to_vector(stated.motion.derivative(stated.velocity(place)))


def _rotation(_: Mechanism, first: Frame, second: Frame) -> MatrixValue:
    """Return the matrix that carries components along the first frame into those along the
    second.
    """
    columns = [unit(first, axis).resolved(second).components for axis in AXES]
    return MatrixValue(tuple(tuple(to_scalar(c[row]) for c in columns) for row in range(3)))


def _vector(_: Mechanism, frame: Frame, *components: Scalar) -> VectorValue:
    return VectorValue(frame, _triple(components))


def _cross(stated: Mechanism, *vectors: VectorValue) -> VectorValue:
    first, second = (
        Vec(v.frame, _triple(c.value for c in v.components)).resolved(stated.world) for v in vectors
    )
    return to_vector(first.cross(second))


def _component(_: Mechanism, vector: VectorValue, number: Scalar) -> Scalar:
    return vector.components[_index(number, "a component")]


def _kinetic(stated: Mechanism) -> Scalar:
    return to_scalar(kinetic_energy(stated.motion, _list_moving(stated), stated.world))


def _potential(stated: Mechanism) -> Scalar:
    lifted = potential_energy(stated.assembly, _list_moving(stated), stated.O, stated.world)
    return to_scalar(sp.Add(*stated.potentials) + lifted)


def _list_moving(stated: Mechanism) -> list[Body]:
    return [body for body in stated.assembly.bodies if body != stated.ground]


GEOMETRY: dict[str, tuple[Operation, tuple[type, ...], tuple[type, ...]]] = {
    "axis": (_axis, (Frame, Scalar), ()),
    "spin": (_spin, (Frame,), (Frame,)),
    "spin_rate": (_spin_rate, (Frame,), (Frame,)),
    "position": (_position, (Place,), (Place,)),
    "velocity": (_velocity, (Place,), ()),
    "acceleration": (_acceleration, (Place,), ()),
    "rotation": (_rotation, (Frame, Frame), ()),
    "vector": (_vector, (Frame, Scalar, Scalar, Scalar), ()),
    "cross": (_cross, (VectorValue, VectorValue), ()),
    "component": (_component, (VectorValue, Scalar), ()),
    "kinetic": (_kinetic, (), ()),
    "potential": (_potential, (), ()),
}
"""Functions of frames and points that the meaning of a name may use, with the kinds of their
arguments and of those that may follow.
"""
KINDS = {Frame: "a frame", Place: "a point", Scalar: "a number", VectorValue: "a vector"}


class PointNames(Meanings):
    """The meanings of names at points, as arrays (points,); names without a value there are
    unknown.
    """

    algebra = NUMERIC

    def __init__(self, names: StatedNames, points: Iterable[Point]) -> None:
        self.names, self.points = names, list(points)
        self._meanings: dict[str, Value] = {}
        self._derivatives: dict[str, Value] = {}
        self._turns: dict[Frame, list[list[Any]]] = {}

    def is_known(self, symbol: Symbol) -> bool:
        """Return whether a name has a meaning."""
        return self.names.is_known(symbol)

    def look_up(self, symbol: Symbol) -> Value:
        """Return the values of a name at the points. Raises UnknownNameError if it has none."""
        spelling = symbol.spell()
        if spelling not in self._meanings:
            self._meanings[spelling] = self._at_points(self.names.look_up(symbol))
        return self._meanings[spelling]

    def find_derivative(self, key: str, build: Callable[[Meanings], Value]) -> Value | None:
        """Return the values of a derivative, which its exact meaning has, by a key of its
        formula.
        """
        if key not in self._derivatives:
            self._derivatives[key] = self._at_points(build(self.names))
        return self._derivatives[key]

    def _at_points(self, value: Value) -> Value:
        if isinstance(value, VectorValue):
            vector = VectorValue(value.frame, _triple(map(self._scalar, value.components)))
            return self.resolve(vector, self.world)
        if isinstance(value, MatrixValue):
            return MatrixValue(tuple(tuple(map(self._scalar, row)) for row in value.rows))
        return self._scalar(value)

    def _scalar(self, value: Scalar) -> Scalar:
        return Scalar(self.array(value.value), value.dimension, value.angular, value.mixed)

    def array(self, expr: Expr) -> Any:
        """Return the values of an expression at the points, NaN where it has none."""
        values = []
        for point in self.points:
            try:
                values.append(float(point(sp.sympify(expr))))
            except (ValueError, ZeroDivisionError, TypeError, mpmath.libmp.ComplexResult):
                values.append(float("nan"))
        return np.array(values)

    @property
    def world(self) -> Frame:
        """The frame along whose axes vectors at points are compared."""
        assert isinstance(self.names.stated, Mechanism)
        return self.names.stated.world

    def resolve(self, vector: VectorValue, frame: Frame) -> VectorValue:
        """Return a vector along the axes of the world, where all vectors at points are compared."""
        if vector.frame == self.world:
            return vector
        if vector.frame not in self._turns:
            axes = [unit(vector.frame, axis).resolved(self.world).components for axis in AXES]
            self._turns[vector.frame] = [[self.array(c) for c in axis] for axis in axes]
        axes_at = self._turns[vector.frame]
        shared, mixed = vector.shared_unit()
        components = [
            sum(
                component.value * axis[k]
                for component, axis in zip(vector.components, axes_at, strict=True)
            )
            for k in range(3)
        ]
        return VectorValue(
            self.world,
            _triple(Scalar(c, shared.dimension, shared.angular, mixed) for c in components),
        )
