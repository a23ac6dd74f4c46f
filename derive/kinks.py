"""Where steps along an angle have corners, roots and jumps: every one of them is an event of their
function.

Extremes and integrals are computed piece by piece between events, so that a corner which no event
marks falsifies them. A function has no event where the sign of its argument is certain by `Signs`,
the one rule that decides it, or where the argument does not change along the angle.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache

import sympy as sp
from sympy import Expr, S
from sympy.core.relational import Relational

from .functions import TabulatedFunction, Turns
from .quantity import NONE


@dataclass(frozen=True)
class Event:
    """A joint in a lane: where ``argument - target`` is a whole multiple of ``period`` (or zero,
    without one).

    ``order`` is the order of the first derivative in the lane's angle that jumps there in the
    forces. Where a law is chosen at run time, its choice decides that: ``position`` is the place in
    the law.
    """

    name: str
    argument: Expr
    target: Expr
    order: int
    period: Expr | None = None
    position: Expr | None = None


READABLE = 40
"""Characters of a condition that an event is still named by."""
CORNERS = (
    sp.Abs,
    sp.Max,
    sp.Min,
    sp.sign,
    sp.floor,
    sp.ceiling,
    sp.acos,
    sp.asin,
    sp.atan2,
    sp.log,
    sp.Pow,
    sp.Piecewise,
    Turns,
    TabulatedFunction,
)
"""Functions that are not smooth everywhere."""
POSITIVE, NOT_NEGATIVE, UNKNOWN = 1, 0, -1


class Signs:
    """Certain signs of expressions: POSITIVE, NOT_NEGATIVE or UNKNOWN.

    Sums and products of what is certain are certain; even powers and absolute values are not
    negative, exponentials are positive, and so are the symbols ``positive``. Symbols have the sign
    of their definitions.
    """

    def __init__(
        self, definitions: Mapping[sp.Symbol, Expr], positive: Iterable[sp.Symbol] = ()
    ) -> None:
        self._definitions = definitions
        self._signs: dict[Expr, int] = dict.fromkeys(positive, POSITIVE)

    def find(self, expr: Expr) -> int:
        """Return what is certain of the sign of an expression of real symbols."""
        if expr not in self._signs:
            self._signs[expr] = self._find(expr)
        return self._signs[expr]

    def _find(self, expr: Expr) -> int:
        if expr.is_number:
            return POSITIVE if expr.is_positive else NOT_NEGATIVE if expr.is_zero else UNKNOWN
        if expr.is_Symbol:
            return self.find(self._definitions[expr]) if expr in self._definitions else UNKNOWN
        if isinstance(expr, sp.exp | sp.cosh):
            return POSITIVE
        if isinstance(expr, sp.Abs):
            return max(NOT_NEGATIVE, self.find(expr.args[0]))
        if isinstance(expr, sp.Pow):
            return self._find_power(*expr.args)
        if isinstance(expr, sp.Piecewise):
            return min(self.find(value) for value, _ in expr.args)
        if not isinstance(expr, sp.Add | sp.Mul | sp.Max | sp.Min):
            return UNKNOWN
        signs = [self.find(part) for part in expr.args]
        is_greatest = isinstance(expr, sp.Max) or (
            isinstance(expr, sp.Add) and min(signs) >= NOT_NEGATIVE
        )
        return max(signs) if is_greatest else min(signs)

    def _find_power(self, base: Expr, exponent: Expr) -> int:
        sign = self.find(base)
        if sign == POSITIVE or not exponent.is_Rational:
            return sign
        is_even = exponent.p % 2 == 0 and exponent.q == 1
        if exponent.is_negative:
            return POSITIVE if is_even else UNKNOWN
        return NOT_NEGATIVE if is_even or exponent.q == 2 else sign


@dataclass(frozen=True)
class _Kink:
    """Where ``argument`` passes ``level``, or a multiple of ``period``, a function is not
    smooth.
    """

    argument: Expr
    order: int
    kind: str
    period: Expr | None = None
    level: Expr = S.Zero


class CornerSearch:
    """The places where expressions of symbols are not smooth.

    ``moving`` are the symbols that change along the angle, ``definitions`` the expressions of those
    that steps define; the symbols ``positive`` are so by their meaning.
    """

    def __init__(
        self,
        moving: frozenset[sp.Symbol],
        definitions: Mapping[sp.Symbol, Expr],
        positive: Iterable[sp.Symbol] = (),
    ) -> None:
        self.moving, self._signs = moving, Signs(definitions, positive)
        self._wraps = {symbol: expr for symbol, expr in definitions.items() if expr.has(Turns)}

    def list_events(
        self, expressions: Iterable[tuple[str, Iterable[Expr]]], stated: Iterable[Event] = ()
    ) -> tuple[Event, ...]:
        """Return the events that were stated, then those of expressions under a name, each place
        once.

        Of expressions with one place the least order counts.
        """
        events = {self._find_key(event): event for event in stated}
        stated_keys = set(events)
        for event in self._list_all(expressions):
            key = self._find_key(event)
            if key not in stated_keys and (key not in events or event.order < events[key].order):
                events[key] = event
        return tuple(events.values())

    def _list_all(self, expressions: Iterable[tuple[str, Iterable[Expr]]]) -> Iterator[Event]:
        """Yield the events of all expressions in their order, some repeatedly."""
        for name, parts in expressions:
            functions = {
                function for part in parts for function in sp.sympify(part).atoms(*CORNERS)
            }
            for function in sp.ordered(functions):
                for kink in self._list_places(function):
                    if (kink.argument - kink.level).free_symbols & self.moving:
                        yield self._build_event(name, kink)

    def _find_key(self, event: Event) -> Expr:
        """Return what two events of one place have in common."""
        gap = sp.expand(
            self._without_turns((event.argument - event.target) / (event.period or S.One))
        )
        return sp.Tuple(-gap if gap.could_extract_minus_sign() else gap, event.period is not None)

    def _without_turns(self, expr: Expr) -> Expr:
        """Return an expression in the first period of what is brought into a period."""
        plain = expr.xreplace(self._wraps)
        return plain.xreplace(dict.fromkeys(plain.atoms(Turns), S.Zero))

    def _build_event(self, name: str, kink: _Kink) -> Event:
        where = f": {kink.argument} = {kink.level}" if kink.period is None else ""
        label = f"{kink.kind} of {name}" + (where if len(where) < READABLE else "")
        argument, period = kink.argument - kink.level, kink.period
        plain = argument.xreplace(self._wraps)
        turns = plain.atoms(Turns)
        if period is None and len(turns) == 1:
            turn_count = sp.Dummy("turn_count")
            share = sp.expand(plain.xreplace({next(iter(turns)): turn_count})).coeff(turn_count)
            if share != 0 and not share.free_symbols & (self.moving | {turn_count}):
                argument, period = (
                    sp.expand(sp.cancel(self._without_turns(argument) / share)),
                    S.One,
                )
        return Event(label, argument, S.Zero, kink.order, period)

    def _list_places(self, function: Expr) -> Iterator[_Kink]:
        """Yield where a function is not smooth, with the order of the derivative that jumps
        there.
        """
        first = function.args[0]
        if isinstance(function, sp.Piecewise):
            relations = {
                relation
                for _, condition in function.args
                for relation in condition.atoms(Relational)
            }
            yield from (_Kink(r.lhs, 0, "another case", level=r.rhs) for r in sp.ordered(relations))
        elif isinstance(function, sp.Max | sp.Min):
            pairs = itertools.combinations(sp.ordered(function.args), 2)
            yield from (
                _Kink(a, 1, "corner", level=b) for a, b in pairs if not self._is_certain(a - b)
            )
        elif isinstance(function, Turns | sp.floor):
            yield _Kink(first, 0, "jump", S.One)
        elif isinstance(function, TabulatedFunction):
            yield _Kink(
                _build_index(function)(first),
                len(function.pieces[0][1]) - 1,
                "another piece",
                S.One,
            )
        elif isinstance(function, sp.acos | sp.asin):
            yield _Kink(1 - first**2, 1, "end")
        elif isinstance(function, sp.atan2):
            if POSITIVE not in map(self._signs.find, function.args):
                yield _Kink(first, 0, "jump")
        elif isinstance(function, sp.Pow):
            exponent = function.args[1]
            if not (exponent.is_integer or self._is_certain(first)):
                yield _Kink(
                    first, max(0, int(sp.ceiling(exponent))) if exponent.is_number else 0, "root"
                )
        elif not self._is_certain(first):
            yield _Kink(first, *((1, "corner") if isinstance(function, sp.Abs) else (0, "jump")))

    def _is_certain(self, argument: Expr) -> bool:
        """Return whether an argument has one sign, so that it does not vanish."""
        return POSITIVE in (self._signs.find(argument), self._signs.find(-argument))


def _build_index(table: TabulatedFunction) -> type[TabulatedFunction]:
    """Return a function that is whole where another piece of a table begins, and rises in
    between.
    """
    begins = tuple(begin for begin, _ in table.pieces)
    return _build_rising(begins, table.limits[1] if table.limits else 2 * begins[-1] - begins[-2])


@cache
def _build_rising(begins: tuple[float, ...], last: float) -> type[TabulatedFunction]:
    """Return the piecewise linear function that is k at the k-th of ``begins``; it is one for all
    tables of these.
    """
    widths = [following - begin for begin, following in itertools.pairwise((*begins, last))]
    pieces = tuple(
        (begin, (1 / width, float(k)))
        for k, (begin, width) in enumerate(zip(begins, widths, strict=True))
    )
    return type("piece", (TabulatedFunction,), {"exponents": NONE, "pieces": pieces})
