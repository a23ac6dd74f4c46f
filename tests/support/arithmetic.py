"""Number systems for independent kinematics: elementary functions, a quadrature, and how to take in
a float.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from mpmath import mp

from tests.support import xp_mpmath

Number = Any
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class Arithmetic:
    """`integral(f, end)` is the integral of a smooth f from 0 to `end`."""

    xp: ModuleType
    number: Callable[[float], Number]
    integral: Callable[[Callable[[Number], Number], Number], Number]


def _gauss(f: Callable[[Number], Number], end: Number) -> Number:
    """
    >>> bool(abs(_gauss(np.cos, np.pi / 2) - 1) < 1e-15)
    True
    """
    half = np.asarray(end, dtype=float)[..., None] / 2
    return (f(half * (_NODES + 1)) * half) @ _WEIGHTS


def _adaptive(f: Callable[[Number], Number], end: Number) -> Number:
    return mp.quad(f, [0, end], method="gauss-legendre") if end else mp.zero


FLOATS = Arithmetic(np, float, _gauss)
MPMATH = Arithmetic(xp_mpmath, mp.mpf, _adaptive)
