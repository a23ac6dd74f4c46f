"""Elementary functions on mpmath scalars under NumPy's names: array code at the working precision
of `mpmath.mp`.
"""

from typing import Any

from mpmath import mp

Number = Any
cos, sin, tan, sqrt, exp, log, floor = mp.cos, mp.sin, mp.tan, mp.sqrt, mp.exp, mp.log, mp.floor
arcsin, arccos, arctan, arctan2 = mp.asin, mp.acos, mp.atan, mp.atan2
sign, maximum, minimum = mp.sign, max, min
absolute, polyval = abs, mp.polyval
pi = mp.pi


def where(condition: bool, yes: Number, no: Number) -> Number:
    """
    >>> where(mp.mpf(1) < 2, 3, 4)
    3
    """
    return yes if condition else no


def divide(numerator: Number, denominator: Number) -> Number:
    """At full precision, for two whole numbers too.

    >>> divide(1, 3) * 3 == mp.mpf(1)
    True
    """
    return mp.mpf(numerator) / denominator


def logical_or(a: bool, b: bool) -> bool:
    return bool(a or b)


def logical_and(a: bool, b: bool) -> bool:
    return bool(a and b)


def logical_not(a: bool) -> bool:
    return not a
