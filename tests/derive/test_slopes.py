"""Derivatives in one pass against those of SymPy, on every kind of expression that a mechanism may
hold.
"""

import pytest
import sympy as sp

from derive.functions import directional_derivative, partial_derivative, switch

x, y, z = sp.symbols("x y z", real=True)
EXPRESSIONS = [
    sp.Integer(3),
    z,
    x * y * z,
    (x + 2 * y) ** 3 / sp.sqrt(1 + x**2),
    sp.sin(x * y) * sp.cos(x - y) + sp.exp(x / 3),
    sp.atan2(y, 1 + x**2),
    x ** (1 + y**2),
    switch(x - y, x**2, sp.sin(y)),
    sp.Abs(x + y) * x,
    sp.log(2 + x**2) ** -2,
]


@pytest.mark.parametrize("expr", EXPRESSIONS, ids=str)
def test_rate_follows_the_chain_rule(expr: sp.Expr) -> None:
    at = {x: sp.Rational(7, 5), y: sp.Rational(3, 4), z: sp.Rational(1, 3)}
    rates = {x: y**2, y: sp.cos(x)}
    expected = sum(expr.diff(symbol) * rate for symbol, rate in rates.items())
    assert abs(sp.N((directional_derivative(expr, rates) - expected).subs(at), 20)) < 1e-15
    assert abs(sp.N((partial_derivative(expr, x) - expr.diff(x)).subs(at), 20)) < 1e-15
