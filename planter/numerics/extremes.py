"""Extremes of a function of one variable over an interval or a closed course.

Both ways look at samples first: a hill or hollow that lies between two neighbouring samples is missed. Where there is
no derivative, `least` and `largest` refine the best samples between their neighbours, by Brent's bounded method: the
value is right to rounding where the function is smooth, and to 1e-8 of its change between samples where it has a kink.
Where there is one, `stationary` finds all places where it changes sign, to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics import roots
from planter.numerics.arrays import Flags, Integers

Function = Callable[[Array], Array]

TRIED = 3
"""Local extremes among the samples that are refined, the best first."""
TIE_TOLERANCE = 1e-9
"""Values tie that differ by less than this share of the largest size: rounding alone may decide between them."""
SAME_ANGLE = 1e-3
"""Places closer than this belong to one extreme [rad]."""
CLOSE = 1e-9
"""How close an extreme is looked for, as a share of the samples' spacing."""


@dataclass(frozen=True)
class Extreme:
    """Where a function has its extreme, and its value there."""

    place: float
    value: float


def least(function: Function, places: Array, closed: bool = False) -> Extreme:
    """The least value over the interval that ordered places (n,) sample, n at least 2.

    `function` gives values (n,) at places (n,). With `closed` the places go once round a period, evenly and without
    its end; the extreme may then lie a step before the first of them. Raises ComputationError, naming the place, for
    a value that is not finite.
    """
    values = _finite(function, places)
    found = [_refined(function, places, values, k, closed) for k in _hollows(values, closed)]
    return min(found, key=lambda extreme: extreme.value)


def largest(function: Function, places: Array, closed: bool = False) -> Extreme:
    """The largest value, as `least` has the least."""
    found = least(lambda x: -function(x), places, closed)
    return Extreme(found.place, -found.value)


def first_extreme(angles: Array, values: Array, sign: int) -> int:
    """Return the index of the largest (+1) or least (-1) of values (n,) at angles (n,) [rad] of a cycle.

    Of extremes that tie the one at the smallest angle in [0, 2 pi) counts, so that it does not hang on rounding.
    """
    signed = sign * values
    tied = np.flatnonzero(signed >= signed.max() - TIE_TOLERANCE * np.abs(values).max())
    folded = np.mod(angles[tied] + SAME_ANGLE, 2 * np.pi) - SAME_ANGLE
    if len(tied) == len(values):
        return int(tied[folded.argmin()])
    near = tied[folded <= folded.min() + SAME_ANGLE]
    return int(near[signed[near].argmax()])


def each(function: Callable[[float], float]) -> Function:
    """A function of one place as one of many."""
    return lambda places: np.array([function(float(place)) for place in places])


def stationary(rates: roots.Rates, places: Array, slopes: Array, joined: Flags | None = None) -> tuple[Array, Flags]:
    """Where slopes (n,) at ordered places (n,) change sign between neighbours, and which of these are maxima.

    `rates` gives first and second derivatives at places. `joined` (n - 1,) tells which neighbours a smooth piece of
    the function lies between: all of them, if it is None. Raises ComputationError as `roots.newton` does.
    """
    changes = (slopes[1:] > 0) != (slopes[:-1] > 0)
    cells = np.flatnonzero(changes if joined is None else changes & joined)
    if not len(cells):
        return np.empty(0), np.empty(0, dtype=bool)
    ends = slopes[cells], slopes[cells + 1]
    return roots.newton(rates, places[cells], places[cells + 1], ends), ends[0] > ends[1]


def _finite(function: Function, places: Array) -> Array:
    values = np.asarray(function(places), dtype=float)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        where = f"it is {values[bad[0]]} at {places[bad[0]]:.6g}"
        raise ComputationError(f"the extremes of a function were not found: {where}")
    return values


def _hollows(values: Array, closed: bool) -> Integers:
    """Samples that are no higher than their neighbours, the deepest first."""
    around = np.pad(values, 1, mode="wrap") if closed else np.pad(values, 1, constant_values=np.inf)
    hollow = np.flatnonzero((values <= around[:-2]) & (values <= around[2:]))
    return hollow[np.argsort(values[hollow], kind="stable")][:TRIED]


def _refined(function: Function, places: Array, values: Array, k: int, closed: bool) -> Extreme:
    """The sample k, or what is less between its neighbours."""
    from scipy.optimize import minimize_scalar

    step, place = float(places[1] - places[0]), float(places[k])
    low = -step if closed else float(places[max(k - 1, 0)]) - place
    high = step if closed else float(places[min(k + 1, len(places) - 1)]) - place
    found = minimize_scalar(
        lambda aside: float(function(np.array([place + aside]))[0]), bounds=(low, high), method="bounded",
        options={"xatol": CLOSE * (high - low)},
    )  # fmt: skip
    own = float(values[k])
    return Extreme(place + float(found.x), float(found.fun)) if found.fun < own else Extreme(place, own)
