"""SymPy expressions as text of a language; common subexpressions, invariants of the angle, order of
steps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import count, islice

import sympy as sp
from sympy import Basic
from sympy.functions.elementary.piecewise import ExprCondPair
from sympy.logic.boolalg import BooleanTrue

from ..functions import Polynomial, TabulatedFunction, Turns
from ..model import COMMON, Event, Lane, Let, LinearSolve, Step, list_expressions, split_steps
from ..quantity import Quantity, Vector, exact_power

ATOM, POWER, FACTOR, PRODUCT, SUM, TEST = 5, 4, 3, 2, 1, 0


class UnsupportedNode(TypeError):
    """An expression holds a node that no emitter knows."""


PLAIN = (
    "cos",
    "sin",
    "tan",
    "acos",
    "asin",
    "atan",
    "atan2",
    "sqrt",
    "exp",
    "log",
    "floor",
    "sign",
    "polyval",
)
"""Functions of one name everywhere but in some targets."""


@dataclass(frozen=True)
class Dialect:
    """Names of the functions in the target, by the names used here.

    ``ratio`` and ``length`` are templates of a quotient of two whole numbers and of the length of a
    vector; ``first`` is what every function takes before its own arguments. ``solver`` is the text
    of a function ``solved`` of a matrix and a right-hand side, both lists, that gives the unknowns
    of simultaneous equations and their pivot. ``series`` is a function that sums a sine series,
    None where a target writes its sum out. ``power``, ``differs`` and ``true`` are the signs of the
    language, those of Python unless told.
    """

    functions: dict[str, str]
    ratio: str
    length: str
    first: tuple[str, ...] = ()
    solver: str = ""
    series: str | None = None
    power: str = "**"
    differs: str = "!="
    true: str = "True"

    def call(self, function: str, *arguments: str) -> str:
        """Return the text of a call of a function."""
        return f"{self.functions[function]}({', '.join(arguments)})"


Text = tuple[str, int]
Handler = Callable[["Printer", Basic], Text]


@dataclass(frozen=True)
class Printer:
    """Prints expressions in one dialect."""

    dialect: Dialect

    def __call__(self, expr: Basic) -> str:
        return self.text(expr, TEST)

    def text(self, expr: Basic, min_binding: int) -> str:
        """The expression as text, in brackets where it binds less than ``min_binding``."""
        text, binding = self._handler(expr)(self, expr)
        return f"({text})" if binding < min_binding else text

    @staticmethod
    def _handler(expr: Basic) -> Handler:
        for kind in type(expr).__mro__:
            if kind in TABLE:
                return TABLE[kind]
        # Its arguments may be symbols of common subexpressions, which no statement has.
        allowed = ", ".join(sorted({"Abs", "Max", "Min", "Piecewise", *PLAIN} - {"polyval"}))
        raise UnsupportedNode(
            f"{type(expr).__name__} cannot be written: state it by powers and {allowed}"
        )

    def call(self, function: str, *arguments: Basic) -> Text:
        """Return the text of a call of a function."""
        return self.dialect.call(function, *(self.text(a, TEST) for a in arguments)), ATOM


@cache
def _terms(expr: Basic) -> list[Basic]:
    """The terms of a sum in the order in which every target writes them."""
    return expr.as_ordered_terms()


def _add(p: Printer, expr: Basic) -> Text:
    text = ""
    for term in sp.Add.make_args(expr) if len(expr.args) < 2 else _terms(expr):
        negative = term.could_extract_minus_sign()
        part = p.text(-term if negative else term, PRODUCT)
        text += (" - " if negative else " + ") + part if text else ("-" if negative else "") + part
    return text, SUM


def _mul(p: Printer, expr: Basic) -> Text:
    if expr.could_extract_minus_sign():
        return f"-{p.text(-expr, PRODUCT)}", SUM
    numerator, denominator = [], []
    for factor in expr.as_ordered_factors():
        base, power = factor.as_base_exp()
        if isinstance(factor, sp.Rational) and not isinstance(factor, sp.Integer):
            numerator += [sp.Integer(factor.p)] if factor.p != 1 else []
            denominator.append(sp.Integer(factor.q))
        elif power.is_number and power.is_negative:
            denominator.append(base**-power)
        else:
            numerator.append(factor)
    top = " * ".join(p.text(f, FACTOR) for f in numerator) or "1"
    for factor in denominator:
        top += f" / {p.text(factor, POWER)}"
    return top, PRODUCT


def _pow(p: Printer, expr: Basic) -> Text:
    base, power = expr.args[0], exact_power(expr.args[1])
    if power == sp.S.Half:
        return p.call("sqrt", base)
    if power.is_number and power.is_negative:
        return f"1 / {p.text(base**-power, POWER)}", PRODUCT
    if isinstance(power, sp.Integer):
        return (p.text(base, POWER), POWER) if power == 1 else (_raise(p, base, power), POWER)
    if isinstance(power, sp.Rational) and power.q == 2:
        return _mul(p, sp.Mul(base ** ((power.p - 1) // 2), sp.sqrt(base), evaluate=False))
    return _raise(p, base, power), POWER


def _raise(p: Printer, base: Basic, power: Basic) -> str:
    return f"{p.text(base, ATOM)}{p.dialect.power}{p.text(power, ATOM)}"


def _integer(p: Printer, expr: Basic) -> Text:
    return str(expr), ATOM if expr >= 0 else SUM


def _rational(p: Printer, expr: Basic) -> Text:
    return p.dialect.ratio.format(expr.p, expr.q), PRODUCT if "(" not in p.dialect.ratio else ATOM


def _float(p: Printer, expr: Basic) -> Text:
    return repr(float(expr)), ATOM if expr >= 0 else SUM


def _piecewise(p: Printer, expr: Basic) -> Text:
    *cases, (text_of, condition) = expr.args
    if condition is not sp.true:
        raise UnsupportedNode(f"a list of cases without a last 'otherwise': {expr}")
    text = p.text(text_of, TEST)
    for value, condition in reversed(cases):
        text = p.dialect.call("select", p.text(condition, TEST), p.text(value, TEST), text)
    return text, ATOM


def _fold(function: str) -> Handler:
    def handler(p: Printer, expr: Basic) -> Text:
        first, *rest = sorted(expr.args, key=sp.default_sort_key)
        text = p.text(first, TEST)
        for argument in rest:
            text = p.dialect.call(function, text, p.text(argument, TEST))
        return text, ATOM

    return handler


def _relation(symbol: str) -> Handler:
    return lambda p, expr: (_compared(p, expr, symbol), TEST)


def _differs(p: Printer, expr: Basic) -> Text:
    return _compared(p, expr, p.dialect.differs), TEST


def _compared(p: Printer, expr: Basic, symbol: str) -> str:
    left, right = (p.text(a, SUM) for a in expr.args)
    return f"{left} {symbol} {right}"


def _polynomial(p: Printer, expr: Basic) -> Text:
    at, *coefficients = expr.args
    listed = ", ".join(p.text(a, TEST) for a in coefficients)
    return p.dialect.call("polyval", f"[{listed}]", p.text(at, TEST)), ATOM


def _tabulated(p: Printer, expr: Basic) -> Text:
    """Choose the piece by halves, so that hundreds of pieces are nested a few deep."""
    at = p.text(expr.args[0], SUM)

    def choose(pieces: Sequence[tuple[float, tuple[float, ...]]]) -> str:
        if len(pieces) == 1:
            start, coefficients = pieces[0]
            listed = ", ".join(map(repr, coefficients))
            distance = f"{at} + {-start!r}" if start < 0 else f"{at} - {start!r}"
            return p.dialect.call("polyval", f"[{listed}]", distance)
        half = len(pieces) // 2
        return p.dialect.call(
            "select", f"{at} < {pieces[half][0]!r}", choose(pieces[:half]), choose(pieces[half:])
        )

    text = choose(expr.pieces)
    if expr.limits is None:
        return text, ATOM
    lower, upper = expr.limits
    inside = p.dialect.call("and", f"{at} >= {lower!r}", f"{at} <= {upper!r}")
    return (
        f"{p.dialect.call('sqrt', p.dialect.call('select', inside, '1.0', '-1.0'))} * {text}",
        PRODUCT,
    )


def _function(name: str) -> Handler:
    return lambda p, expr: p.call(name, *expr.args)


TABLE: dict[type[Basic], Handler] = {
    sp.Symbol: lambda p, expr: (expr.name, ATOM),
    sp.Integer: _integer,
    sp.Rational: _rational,
    sp.Float: _float,
    type(sp.pi): lambda p, expr: (p.dialect.functions["pi"], ATOM),
    BooleanTrue: lambda p, expr: (p.dialect.true, ATOM),
    sp.Add: _add,
    sp.Mul: _mul,
    sp.Pow: _pow,
    sp.Piecewise: _piecewise,
    sp.Min: _fold("min"),
    sp.Max: _fold("max"),
    sp.And: _fold("and"),
    sp.Or: _fold("or"),
    sp.Not: _function("not"),
    sp.Ge: _relation(">="),
    sp.Gt: _relation(">"),
    sp.Le: _relation("<="),
    sp.Lt: _relation("<"),
    sp.Eq: _relation("=="),
    sp.Ne: _differs,
    sp.Abs: _function("abs"),
    Turns: _function("floor"),
    Polynomial: _polynomial,
    TabulatedFunction: _tabulated,
    **{getattr(sp, name): _function(name) for name in PLAIN if name not in ("sqrt", "polyval")},
}


def count_operations(expr: Basic) -> int:
    """Number of arithmetic operations, function calls, comparisons and selections in an
    expression.
    """
    if expr.is_Atom:
        return 0
    inner = sum(count_operations(a) for a in expr.args)
    if isinstance(expr, Polynomial):
        return inner + 2 * (len(expr.args) - 2)
    if isinstance(expr, TabulatedFunction):
        return inner + len(expr.pieces) * (2 * len(expr.pieces[0][1]) + 1)
    if isinstance(expr, sp.Add | sp.Mul | sp.Min | sp.Max | sp.And | sp.Or | sp.Piecewise):
        return inner + len(expr.args) - 1
    return inner if isinstance(expr, ExprCondPair) else inner + 1


@dataclass(frozen=True)
class Schedule:
    """The steps of the emitted functions of a lane."""

    lane: Lane
    prologue: tuple[Step, ...]
    hoisted: Vector
    moving: tuple[Step, ...]
    events: tuple[Let, ...]
    frame: tuple[Step, ...]


def schedule_steps(lane: Lane) -> Schedule:
    """Share common subexpressions, then move to the prologue what the angle does not change."""
    joints = tuple(_joint(i, event) for i, event in enumerate(lane.events))
    steps = share_subexpressions((*lane.steps, *joints), prefix="c")
    still, moving = split_steps(steps, frozenset({lane.angle}.union(*lane.along)))
    at_joints = frozenset(joint.symbol for joint in joints)
    events = tuple(s for s in moving if isinstance(s, Let) and s.symbol in at_joints)
    if len(events) < len(joints):
        raise ValueError(f"lane: an event does not depend on {lane.angle}, so it never happens")
    needed_later = frozenset(lane.outputs).union(*(step.needs for step in moving))
    hoisted = tuple(s for step in still for s in step.defines if s in needed_later)
    lane_steps = tuple(step for step in moving if step not in events)
    frame = share_subexpressions(lane.shared.steps, prefix="d") if lane.shared else ()
    return Schedule(lane, still, Vector("hoisted", hoisted), lane_steps, events, frame)


def _joint(index: int, event: Event) -> Let:
    """Return the step whose value is zero at an event, or a multiple of its period."""
    meaning = f"{event.name}: {event.argument} less {event.target}"
    symbol = Quantity(f"g{index}", "1", meaning, "derived: joint")
    return Let(symbol, event.argument - event.target, f"joint: {event.name}")


def share_subexpressions(steps: Sequence[Step], prefix: str) -> tuple[Step, ...]:
    """Return equivalent steps in which each common subexpression is a step before its first use."""
    taken = {symbol.name for step in steps for symbol in (*step.needs, *step.defines)}
    names = (sp.Symbol(name, real=True) for i in count(1) if (name := f"{prefix}{i}") not in taken)
    parts = [list_expressions(step) for step in steps]
    common, reduced = sp.cse(
        [part for some in parts for part in some], symbols=names, order="canonical"
    )
    pending, left = dict(common), iter(reduced)
    ordered: list[Step] = []

    def define(expr: sp.Expr) -> None:
        for symbol in sorted(
            expr.free_symbols & pending.keys(), key=lambda s: (len(s.name), s.name)
        ):
            if symbol in pending:
                inner = pending.pop(symbol)
                define(inner)
                ordered.append(Let(symbol, inner, COMMON))

    for step, some in zip(steps, parts, strict=True):
        step_exprs = tuple(islice(left, len(some)))
        for expr in step_exprs:
            define(expr)
        ordered.append(with_expressions(step, step_exprs))
    return tuple(ordered)


def with_expressions(step: Step, exprs: tuple[sp.Expr, ...]) -> Step:
    """Return a copy of a step that evaluates other expressions, in the order of
    `list_expressions`.
    """
    if isinstance(step, LinearSolve):
        return step.filled(exprs)
    return (
        replace(step, expr=exprs[0]) if isinstance(step, Let) else replace(step, argument=exprs[0])
    )


def count_step_operations(steps: Sequence[Step]) -> int:
    """Operations in the steps themselves; what a called function or an elimination does is not
    counted.
    """
    return sum(count_operations(expr) for step in steps for expr in list_expressions(step))
