"""Elementary functions on complex NumPy arrays for derivatives by complex step: f(x + ih) = f(x) +
ih f'(x) + O(h^2).

Branches follow the real part. Analytic functions are NumPy's own; the others are continued along
the real line.
"""

from collections.abc import Callable

import numpy as np
from numpy import (
    arccos,
    arcsin,
    arctan,
    cos,
    exp,
    log,
    logical_and,
    logical_not,
    logical_or,
    pi,
    sin,
    sqrt,
    tan,
    where,
)
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "absolute",
    "arccos",
    "arcsin",
    "arctan",
    "arctan2",
    "cos",
    "divide",
    "exp",
    "floor",
    "log",
    "logical_and",
    "logical_not",
    "logical_or",
    "maximum",
    "minimum",
    "pi",
    "sign",
    "sin",
    "slopes",
    "sqrt",
    "tan",
    "where",
]

STEP = 1e-30
Complex = NDArray[np.complex128]


def arctan2(y: ArrayLike, x: ArrayLike) -> Complex:
    """
    >>> float(arctan2(1 + 0j, 1 + STEP * 1j).imag / STEP)
    -0.5
    """
    y, x = np.asarray(y, dtype=complex), np.asarray(x, dtype=complex)
    turn = (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
    return np.arctan2(y.real, x.real) + 1j * turn


def floor(x: ArrayLike) -> NDArray[np.float64]:
    return np.floor(np.real(x))


def sign(x: ArrayLike) -> NDArray[np.float64]:
    return np.sign(np.real(x))


def absolute(x: ArrayLike) -> Complex:
    return np.asarray(where(np.real(x) < 0, np.negative(x), x))


def maximum(a: ArrayLike, b: ArrayLike) -> Complex:
    return np.asarray(where(np.real(a) >= np.real(b), a, b))


def minimum(a: ArrayLike, b: ArrayLike) -> Complex:
    return np.asarray(where(np.real(a) <= np.real(b), a, b))


def divide(numerator: ArrayLike, denominator: ArrayLike) -> Complex:
    return np.asarray(np.divide(numerator, denominator))


def slopes(f: Callable[[Complex], Complex], x: ArrayLike) -> NDArray[np.float64]:
    """Derivatives of `f` in each entry of the vector x, in a last axis of their own; f sees a
    column for each.

    >>> slopes(lambda x: x[0] * x[1] ** 2, [2.0, 3.0]).tolist()
    [9.0, 12.0]
    """
    start = np.asarray(x, dtype=complex)
    return np.imag(f(start[:, None] + 1j * STEP * np.eye(start.size))) / STEP
