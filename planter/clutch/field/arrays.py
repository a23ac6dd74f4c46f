"""Orthogonal arrays of strength two, built from finite fields and a difference scheme.

Hedayat, Sloane and Stufken, Orthogonal Arrays (Springer 1999): chapter 3 (linear arrays), chapter 6 (difference
schemes); the order of columns is Taguchi's.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planter.errors import InputError

Codes = NDArray[np.intp]

LINEAR = {"L4": (2, 2), "L8": (2, 3), "L9": (3, 2), "L25": (5, 2), "L27": (3, 3)}
"""Arrays with p^k runs over the integers modulo a prime p: name, p, k."""
NAMES = ("L4", "L8", "L9", "L18", "L25", "L27")

# Differences modulo 3 of any two columns hold 0, 1 and 2 twice each.
_SCHEME = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [0, 0, 1, 1, 2, 2],
        [0, 1, 0, 2, 1, 2],
        [0, 2, 2, 1, 1, 0],
        [0, 1, 2, 0, 2, 1],
        [0, 2, 1, 2, 0, 1],
    ]
)


@dataclass(frozen=True)
class OrthogonalArray:
    """Codes (runs, columns) that count from 0, and the columns in the order in which factors take them."""

    name: str
    codes: Codes
    order: tuple[int, ...]

    @property
    def levels(self) -> tuple[int, ...]:
        """Number of levels of each column."""
        return tuple(int(column.max()) + 1 for column in self.codes.T)


def array(name: str) -> OrthogonalArray:
    """The orthogonal array of a name, `L9` for one. Raises InputError for an unknown one."""
    if name.upper() not in NAMES:
        raise InputError(f"{name}: there is no plan of that name, it must be one of {', '.join(NAMES)}")
    return _mixed() if name.upper() == "L18" else _linear(name.upper(), *LINEAR[name.upper()])


def _linear(name: str, p: int, k: int) -> OrthogonalArray:
    """One column for each point of the projective space over the field.

    Factors take the basis first, then the columns that mix most of it: their main effects are then free of two-factor
    interactions for as many factors as can be (all in L27 for 4, in L8 for 4).
    """
    runs = np.array(list(itertools.product(range(p), repeat=k)))
    vectors = [v[::-1] for v in itertools.product(range(p), repeat=k) if _leads_with_one(v)]
    vectors.sort(key=lambda v: (max(i for i, x in enumerate(v) if x), v[::-1]))
    weights = [sum(x != 0 for x in v) for v in vectors]
    order = sorted(range(len(vectors)), key=lambda i: (weights[i] != 1, -weights[i]))
    return OrthogonalArray(name, runs @ np.array(vectors).T % p, tuple(order))


def _leads_with_one(vector: tuple[int, ...]) -> bool:
    return next((x for x in vector if x), 0) == 1


def _mixed() -> OrthogonalArray:
    """L18: a column of two levels and seven of three."""
    rows = [
        (half, third, *((x + shift) % 3 for x in scheme))
        for (half, third), scheme in zip(itertools.product(range(2), range(3)), _SCHEME, strict=True)
        for shift in range(3)
    ]
    return OrthogonalArray("L18", np.array(rows), tuple(range(8)))
