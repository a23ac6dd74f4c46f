"""Extrema of a function of one variable over an interval or a closed cycle.

The function is sampled first: an extremum between two neighbouring samples can be missed. Without
derivatives, `find_minimum` and `find_maximum` refine the best samples between their neighbours by
Brent's bounded method: the value is exact to rounding if the function is smooth, and to 1e-8 of its
change between samples at a kink. With derivatives, `find_stationary_points` finds every sign change
of the slope to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers
from planter.numerics.roots import FunctionWithSlope, find_bracketed_roots

ArrayFunction = Callable[[Array], Array]

MAX_CANDIDATES = 3
"""Number of local extrema among the samples that are refined, the best first."""
TIE_TOLERANCE = 1e-9
"""Values tie if they differ by less than this share of the largest magnitude: rounding could decide
between them.
"""
ANGLE_TOLERANCE = 1e-3
"""Angles closer than this belong to one extremum [rad]."""
PLACE_TOLERANCE = 1e-9
"""Tolerance of Brent's method as a share of the spacing of the samples."""


@dataclass(frozen=True)
class ExtremePoint:
    """ExtremePoint of a function: its argument and value."""

    place: float
    value: float


def find_minimum(function: ArrayFunction, places: Array, closed: bool = False) -> ExtremePoint:
    """Return the minimum over the interval which ordered arguments (n,) sample, n at least 2.

    `function` returns values (n,) at arguments (n,). With `closed` the arguments cover one period
    evenly, without its end; the minimum may then lie one step before the first. Raises
    ComputationError if a value is not finite.
    """
    values = _evaluate_finite(function, places)
    candidates = (
        _refine_minimum(function, places, values, k, closed)
        for k in _find_candidates(values, closed)
    )
    return min(candidates, key=lambda extremum: extremum.value)


def find_maximum(function: ArrayFunction, places: Array, closed: bool = False) -> ExtremePoint:
    """Return the maximum, with the arguments and errors of `find_minimum`."""
    minimum = find_minimum(lambda x: -function(x), places, closed)
    return ExtremePoint(minimum.place, -minimum.value)


def index_first_extremum(angles: Array, values: Array, sign: int) -> int:
    """Return the index of the largest (+1) or smallest (-1) of values (n,) at angles (n,) [rad] of
    a cycle.

    Of tied extrema the one at the smallest angle in [0, 2 pi) is selected, so that rounding does
    not decide.
    """
    signed = sign * values
    tied = np.flatnonzero(signed >= signed.max() - TIE_TOLERANCE * np.abs(values).max())
    folded = np.mod(angles[tied] + ANGLE_TOLERANCE, 2 * np.pi) - ANGLE_TOLERANCE
    if len(tied) == len(values):
        return int(tied[folded.argmin()])
    first = tied[folded <= folded.min() + ANGLE_TOLERANCE]
    return int(first[signed[first].argmax()])


def vectorise(function: Callable[[float], float]) -> ArrayFunction:
    """Return a function of an array which evaluates a scalar function at every element."""
    return lambda places: np.array([function(float(place)) for place in places])


def find_stationary_points(
    rates: FunctionWithSlope, places: Array, slopes: Array, joined: Flags | None = None
) -> tuple[Array, Flags]:
    """Return where slopes (n,) at ordered arguments (n,) change sign between neighbours, and which
    are maxima.

    `rates` returns first and second derivatives. `joined` (n - 1,) marks the neighbours between
    which the function is smooth, all if None. Raises ComputationError as `find_bracketed_roots`.
    """
    changes = (slopes[1:] > 0) != (slopes[:-1] > 0)
    cells = np.flatnonzero(changes if joined is None else changes & joined)
    if not len(cells):
        return np.empty(0), np.empty(0, dtype=bool)
    ends = slopes[cells], slopes[cells + 1]
    return find_bracketed_roots(rates, places[cells], places[cells + 1], ends), ends[0] > ends[1]


def _evaluate_finite(function: ArrayFunction, places: Array) -> Array:
    values = np.asarray(function(places), dtype=float)
    invalid = np.flatnonzero(~np.isfinite(values))
    if len(invalid):
        value, place = values[invalid[0]], places[invalid[0]]
        raise ComputationError(
            f"the extremes of a function were not found: it is {value} at {place:.6g}"
        )
    return values


def _find_candidates(values: Array, closed: bool) -> Integers:
    """Return the samples which do not exceed their neighbours, the lowest first."""
    padded = np.pad(values, 1, mode="wrap") if closed else np.pad(values, 1, constant_values=np.inf)
    lowest = np.flatnonzero((values <= padded[:-2]) & (values <= padded[2:]))
    return lowest[np.argsort(values[lowest], kind="stable")][:MAX_CANDIDATES]


def _refine_minimum(
    function: ArrayFunction, places: Array, values: Array, k: int, closed: bool
) -> ExtremePoint:
    """Return sample k, or a smaller value between its neighbours."""
    step, place, value = float(places[1] - places[0]), float(places[k]), float(values[k])
    low = -step if closed else float(places[max(k - 1, 0)]) - place
    high = step if closed else float(places[min(k + 1, len(places) - 1)]) - place
    result = scipy.optimize.minimize_scalar(
        lambda offset: float(function(np.array([place + offset]))[0]),
        bounds=(low, high),
        method="bounded",
        options={"xatol": PLACE_TOLERANCE * (high - low)},
    )
    if result.fun < value:
        place, value = place + float(result.x), float(result.fun)
    return ExtremePoint(place, value)
