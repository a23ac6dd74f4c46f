"""Terms told in the differences that a balance holds them by: multiplied out, one of them is many."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import sympy as sp
from sympy import Expr


def folded(terms: Iterable[Expr], folds: Mapping[sp.Symbol, Expr]) -> tuple[Expr, ...]:
    """The same sum in fewer terms, where a symbol less what ``folds`` take from it makes them fewer."""
    whole, back = sp.Add(*terms), dict[sp.Symbol, Expr]()
    for symbol, base in folds.items():
        if symbol in whole.free_symbols:
            difference = sp.Dummy(str(symbol), real=True)
            trial = sp.expand(whole.xreplace({symbol: base + difference}), trig=False)
            if len(sp.Add.make_args(trial)) < len(sp.Add.make_args(whole)):
                whole, back = trial, back | {difference: symbol - base}
    return tuple(term.xreplace(back) for term in sp.Add.make_args(whole) if term != 0)
