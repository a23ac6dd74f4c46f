"""What a result depends on: the steps and inputs that cannot change it, proved symbolically.

The result is differentiated backwards through the steps, side by side where a machine has equal
sides. A quantity whose derivative is identically zero, whatever the values of all that comes before
it, cannot change the result and is put to zero: what internal forces cancel is then never computed,
and an input that goes this way has no effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp
from mpmath import mpf
from sympy import Expr, S

from .evaluate import Point
from .functions import Polynomial, TabulatedFunction
from .model import Call, Lane, Let, Step, needed
from .quantity import Quantity

TESTED = 3
"""Points at which a derivative is evaluated before it is asked to vanish identically."""
SMALL = mpf(10) ** -40
LONG = 100
"""Operations of a slope above which it is no longer carried as an expression."""


class NotAdditive(ValueError):
    """A total is not a sum of what equal sides do."""


def side_share(lane: Lane, total: Quantity, name: Quantity) -> Let:
    """``name``, the share of one side in a total of equal sides: the total is that of side 1 plus
    that of side 2.

    Raises NotAdditive where it is not.
    """
    shared = lane.shared
    if shared is None:
        raise NotAdditive(f"{total}: the lane has no equal sides")
    total_expr = _substituted(shared.steps, total)
    zero_ours = dict.fromkeys(lane.outputs, S.Zero)
    zero_theirs = {shared.twin(s): S.Zero for s in lane.outputs}
    side_expr = sp.expand(
        total_expr.xreplace(zero_theirs) - total_expr.xreplace(zero_ours | zero_theirs) / 2
    )
    if (
        sp.expand(
            total_expr - side_expr - side_expr.xreplace({s: shared.twin(s) for s in lane.outputs})
        )
        != 0
    ):
        raise NotAdditive(f"{total} is not a sum of what each side does")
    return Let(name, side_expr, f"derived: share of a side in {total}")


def _substituted(steps: Sequence[Let], result: Quantity) -> Expr:
    expr: Expr = result
    for step in reversed(steps):
        expr = expr.xreplace({step.symbol: step.expr})
    return expr


@dataclass(frozen=True)
class Influence:
    """Derivatives of the sum of ``result`` over a lane's sides in all that goes before, the steps
    of both sides.
    """

    lane: Lane
    result: Let

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        return needed((*self.lane.steps, self.result), frozenset({self.result.symbol}))

    @cached_property
    def without(self) -> frozenset[sp.Symbol]:
        """Steps and inputs that cannot change the result."""
        seen = frozenset().union(*(step.needs for step in self.steps)) | {
            s for step in self.steps for s in step.defines
        }
        return frozenset(
            s for s in seen if s != self.lane.angle and s not in self._opaque and self._vanishes(s)
        )

    @cached_property
    def felt(self) -> dict[str, tuple[str, ...]]:
        """Return, for each function composed at run time, the outputs that can change the
        result.
        """
        outputs: dict[str, tuple[str, ...]] = {}
        for call in (step for step in self.steps if isinstance(step, Call)):
            pairs = zip(call.function.gives, call.outputs, strict=True)
            names = (
                name for name, symbol in pairs if symbol is not None and symbol not in self.without
            )
            outputs[call.function.name] = tuple(
                dict.fromkeys((*outputs.get(call.function.name, ()), *names))
            )
        return outputs

    def reduced(self) -> tuple[Step, ...]:
        """The steps of the result, those without effect put to zero."""
        zeros = dict.fromkeys(self.without, S.Zero)
        steps: list[Step] = []
        for step in self.steps:
            if isinstance(step, Let) and step.symbol not in zeros:
                steps.append(Let(step.symbol, step.expr.xreplace(zeros), step.source))
            elif isinstance(step, Call):
                outputs = tuple(None if symbol in zeros else symbol for symbol in step.outputs)
                steps.append(Call(outputs, step.function, step.argument, step.vectors, step.source))
        if any(isinstance(s, Let) and s.expr.has(sp.nan, sp.zoo) for s in steps):
            raise ValueError(f"{self.result.symbol}: what has no effect stands in a denominator")
        return needed(steps, frozenset({self.result.symbol}))

    @cached_property
    def _opaque(self) -> frozenset[sp.Symbol]:
        """Return the inputs of the functions composed at run time on whose outputs the result
        depends.
        """
        symbols: set[sp.Symbol] = set()
        for step in self.steps:
            if isinstance(step, Call) and not all(self._vanishes(s) for s in step.defines):
                symbols |= step.needs
        return frozenset(symbols)

    @cached_property
    def _slopes(self) -> dict[sp.Symbol, Expr]:
        """Derivative of the share of side 1 in each symbol of side 1."""
        slopes: dict[sp.Symbol, Expr] = {self.result.symbol: S.One}
        for step in reversed(self.steps):
            if isinstance(step, Let):
                slope = self._shorten(step.symbol, _simple(slopes.get(step.symbol, S.Zero)))
                slopes[step.symbol] = slope
                if slope != 0:
                    for symbol in step.needs:
                        slopes[symbol] = slopes.get(symbol, S.Zero) + slope * step.expr.diff(symbol)
        return {s: _simple(slope) for s, slope in slopes.items()}

    @staticmethod
    def _shorten(symbol: sp.Symbol, slope: Expr) -> Expr:
        """A long slope as a new symbol, of which nothing is known: what vanishes with it vanishes
        without.
        """
        if sp.count_ops(slope) <= LONG:
            return slope
        return Quantity(f"slope_{symbol}", "1", f"slope in {symbol}", "derived: influence")

    @cached_property
    def _vanishing(self) -> dict[sp.Symbol, bool]:
        return {}

    def _vanishes(self, symbol: sp.Symbol) -> bool:
        if symbol not in self._vanishing:
            self._vanishing[symbol] = self._cancels(symbol)
        return self._vanishing[symbol]

    def _cancels(self, symbol: sp.Symbol) -> bool:
        """Whether the derivative of the sum over both sides is identically zero."""
        slope = self._slopes.get(symbol, S.Zero)
        shared = self.lane.shared
        if slope == 0 or shared is None or symbol in self._defined:
            return bool(slope == 0)
        moving = self._defined | {s for s in slope.free_symbols if s.name.startswith("slope_")}
        twins = {s: shared.twin(s) for s in moving}
        other = slope.xreplace(twins | {self.lane.angle: self.lane.angle - sp.pi})
        return _simple(slope + other) == 0

    @cached_property
    def _defined(self) -> frozenset[sp.Symbol]:
        return frozenset(s for step in self.steps for s in step.defines if isinstance(s, Quantity))


def flatten_products(
    steps: Sequence[Step], result: Quantity, variables: frozenset[sp.Symbol]
) -> tuple[Step, ...]:
    """The steps of a result, which is written out as a sum of products in the ``variables``
    quantities.
    """
    lets = [step for step in steps if isinstance(step, Let)]
    source = next(step.source for step in lets if step.symbol == result)
    expr: Expr = result
    for step in reversed(lets):
        if step.symbol not in variables:
            expr = expr.xreplace({step.symbol: step.expr})
    rest = (step for step in steps if result not in step.defines)
    return needed((*rest, Let(result, _expanded(expr), source)), frozenset({result}))


def _expanded(expr: Expr) -> Expr:
    """Return an expression as a sum of products without squares of cosines."""
    expanded = sp.expand(expr)
    for cosine in sorted(expanded.atoms(sp.cos), key=str):
        expanded = sp.expand(expanded.subs(cosine**2, 1 - sp.sin(cosine.args[0]) ** 2))
    return expanded


def _simple(expr: Expr) -> Expr:
    """Zero if the expression is found to be identically zero; else as it is, or another form of it.

    Nothing is sought among branches and polynomials: what vanishes on each of them counts as an
    influence.
    """
    if expr == 0 or expr.has(sp.Piecewise, Polynomial, TabulatedFunction) or _differs(expr):
        return expr
    return _expanded(expr)


def _differs(expr: Expr) -> bool:
    """Whether an expression is not zero at some point."""
    symbols = sorted(expr.free_symbols, key=str)
    for k in range(TESTED):
        values = {
            s: sp.Rational(100 + 37 * ((i + 3) * (k + 2) % 29), 1000) for i, s in enumerate(symbols)
        }
        if abs(Point(values)(expr)) > SMALL:
            return True
    return False
