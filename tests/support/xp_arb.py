"""Elementary functions on arb balls under NumPy's names: an interval library of its own, at
`flint.ctx.prec` bits.
"""

from typing import Any

from flint import arb

Number = Any


def __getattr__(name: str) -> Number:
    """pi, at the working precision."""
    if name == "pi":
        return arb.pi()
    raise AttributeError(name)


def cos(x: Number) -> Number:
    return arb(x).cos()


def sin(x: Number) -> Number:
    return arb(x).sin()


def tan(x: Number) -> Number:
    return arb(x).tan()


def sqrt(x: Number) -> Number:
    return arb(x).sqrt()


def arctan(x: Number) -> Number:
    return arb(x).atan()


def floor(x: Number) -> Number:
    """Of a ball without a whole number in it."""
    return arb(x).floor()


def where(condition: bool, yes: Number, no: Number) -> Number:
    return yes if condition else no


def logical_or(a: bool, b: bool) -> bool:
    return bool(a or b)


def maximum(a: Number, b: Number) -> Number:
    """
    >>> maximum(arb(1), arb(2)) == 2
    True
    """
    return arb(a).max(b)


def polyval(coefficients: list[int], x: Number) -> Number:
    """
    >>> polyval([2, 0, 1], arb(3)) == 19
    True
    """
    value = arb(0)
    for a in coefficients:
        value = value * x + a
    return value


def arctan2(y: Number, x: Number) -> Number:
    return arb.atan2(arb(y), arb(x))


def arcsin(x: Number) -> Number:
    return arb(x).asin()


def arccos(x: Number) -> Number:
    return arb(x).acos()


def exp(x: Number) -> Number:
    return arb(x).exp()


def log(x: Number) -> Number:
    return arb(x).log()
