"""Definitions: nothing derives them, but what a paper prints of their symbols may test them."""

from __future__ import annotations

from decimal import Decimal

import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..dimensions import is_consistent
from ..equations import Equation, Witness
from ..evaluate import Point
from ..quantity import Quantity
from .judgement import Judgement


def defined(printed: Equation) -> Judgement:
    """The verdict on a definition: whether it gives what else the paper says of its symbols, and untested without."""
    mixed = "" if is_consistent(printed.residual) else "; not dimensionally consistent"
    against = [witness for witness in printed.witnesses if not agrees(printed, witness)]
    if against:
        return Judgement("contradicted", "; ".join(map(_told, against)) + mixed)
    if printed.witnesses:
        return Judgement("definition", f"agrees with {', '.join(w.where for w in printed.witnesses)}{mixed}")
    return Judgement("untested", f"nothing to derive, and nothing else in the paper tests it{mixed}")


def agrees(printed: Equation, witness: Witness) -> bool:
    """Whether a definition gives the printed value, to the last digit that is printed, of what it defines."""
    values = {symbol: mpf(digits) for symbol, digits in witness.values}
    missing = printed.residual.free_symbols - values.keys()
    if bounded := [bounds for bounds in witness.between if missing == {bounds[0]}]:
        return _agrees_within(printed, witness, *bounded[0])
    if missing:
        raise ValueError(f"{printed.source}: {witness.where} prints nothing of {', '.join(sorted(map(str, missing)))}")
    judged = next((digits for symbol, digits in witness.values if symbol == _judged(printed, witness)), "0")
    last = mpf(10) ** int(Decimal(judged).as_tuple().exponent)
    return bool(abs(Point(values)(printed.residual)) <= last / 2)


def _agrees_within(printed: Equation, witness: Witness, symbol: Quantity, low: Expr, high: Expr) -> bool:
    """Whether a definition holds for some value between the bounds of the one symbol without a printed value."""
    values = {other: sp.Rational(digits) for other, digits in witness.values}
    roots = sp.solve(printed.residual.xreplace(values), symbol)
    least, largest = (bound.xreplace(values) for bound in (low, high))
    return any(root.is_real and least <= root <= largest for root in roots)


def _judged(printed: Equation, witness: Witness) -> Quantity:
    """The symbol whose printed digits decide: the defined one, or else the first."""
    return printed.defines or witness.values[0][0]


def _told(witness: Witness) -> str:
    values = ", ".join(f"{symbol} = {digits}" for symbol, digits in witness.values)
    return f"against {witness.where}: {values}"
