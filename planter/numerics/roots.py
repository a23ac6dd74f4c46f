"""Roots by Newton's method: of many bracketed functions at once, of many small systems, and
crossings in a cycle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from planter.errors import ComputationError
from planter.kernels import Array, Flags, Integers

FunctionWithSlope = Callable[[Array], tuple[Array, Array]]
SystemOfEquations = Callable[[Array], tuple[Array, Array]]
"""Unknowns (k, n) -> residuals (k, n), and their Jacobian (k, k, n) with one row for each
equation.
"""
MAX_BRACKET_STEPS, MAX_SYSTEM_STEPS = 100, 40
STEP_TOLERANCE = 1e-9
"""Relative size of a Newton step after which the next step would be rounding."""
STALL_TOLERANCE = 1e-6
"""Relative size below which Newton steps that no longer shrink are rounding of the function."""
TOUCHING, ROUNDING = 1e-3, 1e-13
"""Shares of the size of a function within which it touches a level where it turns round, and
exactly so.
"""
SAME_ANGLE = 1e-12
"""Share of a cycle by which the root of a function at both of its ends may differ."""
MAX_LEVELS = 1000
"""Levels that a function crosses within a step of a scan."""


MOST_CROSSED = 0.25
"""Largest share of the steps of a scan in which a function crosses zero; noise does in half of
them.
"""


class UnsolvedSystemError(ComputationError):
    """Failure to solve one of many systems; `index` is the first such system."""

    name = "NotFoundError"

    def __init__(self, index: int) -> None:
        super().__init__(
            f"system of equations {index + 1} was not solved in {MAX_SYSTEM_STEPS} steps"
        )
        self.index = index


def find_bracketed_roots(
    function: FunctionWithSlope, low: Array, high: Array, ends: tuple[Array, Array]
) -> Array:
    """Return the roots (m,) of m functions, each in its bracket [low, high].

    `ends` are the values there, of opposite sign or zero. `function` returns values and
    derivatives, (m,) each, at m points. A Newton step that leaves its bracket is replaced by
    bisection. Raises ComputationError if a root is not determined to rounding, of the point or of
    the function.
    """
    low, high, rising = low.copy(), high.copy(), ends[0] < ends[1]
    size = np.maximum(np.abs(low), np.abs(high))
    rise = ends[1] - ends[0]
    share = np.divide(-ends[0], rise, out=np.zeros_like(rise), where=rise != 0)
    points = np.clip(low + share * (high - low), low, high)
    last, open_ = np.full(len(points), np.inf), np.ones(len(points), dtype=bool)
    for _ in range(MAX_BRACKET_STEPS):
        value, slope = function(points)
        below = (value < 0) == rising
        low, high = np.where(below, points, low), np.where(below, high, points)
        with np.errstate(invalid="ignore"):  # beside a pole, where bisection goes on
            target = points - np.divide(
                value, slope, out=np.full_like(value, np.inf), where=slope != 0
            )
        inside = (low <= target) & (target <= high)
        following = np.where(inside, target, (low + high) / 2)
        following = np.where((value == 0) | ~open_, points, following)
        change = np.abs(following - points)
        points, bisected = following, ~inside & (change > 4 * np.finfo(float).eps * size)
        open_ &= bisected | ~(
            change <= np.where(change >= last, STALL_TOLERANCE, STEP_TOLERANCE) * size
        )
        last = change
        if not open_.any():
            return points
    raise ComputationError(
        f"a root was not found in {MAX_BRACKET_STEPS} steps, near {points[open_][0]:.6g}"
    )


def solve_systems(
    system: SystemOfEquations, start: Array, largest: Array, rounding: float = 0.0
) -> Array:
    """Return the unknowns (k, n) that solve n systems of k equations; no step is longer than
    `largest` (k,).

    A system with residuals up to `rounding` counts as solved, however badly it determines its
    unknowns. Raises UnsolvedSystemError for the first system that is not solved to rounding.
    """
    count = start.shape[1]
    points, last, done = start.copy(), np.full(count, np.inf), np.zeros(count, dtype=bool)
    for _ in range(MAX_SYSTEM_STEPS):
        value, slopes = system(points)
        done |= (np.abs(value) <= rounding).all(axis=0)
        step = -_solve_linear(slopes.transpose(2, 0, 1), value.T)
        size = (np.abs(step) / largest[:, None]).max(axis=0)
        points = np.where(done, points, points + step / np.maximum(size, 1.0))
        done |= (last < STEP_TOLERANCE) | ((size >= last) & (size < STALL_TOLERANCE))
        if done.all():
            return points
        last = size
    raise UnsolvedSystemError(int(np.argmin(done)))


def _solve_linear(matrices: Array, right: Array) -> Array:
    """Return the solutions (k, n) of n linear systems.

    Raises UnsolvedSystemError for the first singular one.
    """
    try:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0].T)
    except np.linalg.LinAlgError:
        raise UnsolvedSystemError(int(np.argmin(np.abs(np.linalg.det(matrices))))) from None


@dataclass(frozen=True)
class Crossings:
    """Sorted angles (s,) in [0, cycle) at which functions cross a level, and the rows (s,) of the
    functions.

    `touches` (t,) are angles at which functions, `touch_rows` (t,), come close to a level and turn
    round.
    """

    angles: Array
    rows: Integers
    touches: Array
    touch_rows: Integers


@dataclass(frozen=True)
class _Cells:
    """Intervals (c,) of a scan in which the functions `rows` cross levels: their ends, low and
    high, and the values there, (4, c).
    """

    rows: Integers
    ends: Array

    def select(self, index: Integers | Flags) -> _Cells:
        return _Cells(self.rows[index], self.ends[:, index])

    def split(self, places: Array, values: Array) -> _Cells:
        """Return both parts of each interval, which end at a place."""
        low, high, first, last = self.ends
        below, above = [low, places, first, values], [places, high, values, last]
        return _Cells(np.tile(self.rows, 2), np.concatenate([below, above], axis=1))


def find_crossings(
    values: FunctionWithSlope,
    periods: Array,
    count: int,
    cycle: float,
    rates: FunctionWithSlope | None = None,
) -> Crossings:
    """Return where functions (m,) cross a level between the angles 0 and `cycle`, which count as
    one.

    The levels are the multiples of `periods` (m,), or zero alone if the period is infinite.
    `values` returns functions and slopes, `rates` slopes and second derivatives, (m, n) each at
    angles (n,). They are scanned in `count` steps of a cycle; steps at whose ends a function is not
    finite are left out. With `rates` a function that turns round towards a level within a step is
    followed to where it does: it crosses the level twice there, or touches it. Further crossings of
    a function in one step are missed.
    """
    # Offset by half a step: functions often cross at whole steps, where rounding would decide
    # between two steps.
    grid = cycle * (np.arange(count + 2) - 0.5) / count
    turning = None if rates is None else partial(OwnFunctions, rates)
    return locate_crossings(
        grid, *values(grid), periods, cycle, partial(OwnFunctions, values), turning
    )


def locate_crossings(
    grid: Array,
    scanned: Array,
    slopes: Array,
    periods: Array,
    cycle: float,
    values: Callable[[Integers], FunctionWithSlope],
    rates: Callable[[Integers], FunctionWithSlope] | None,
) -> Crossings:
    """Return the crossings of functions that were scanned, (m, n) with their slopes, at angles (n,)
    of a cycle.

    Of some functions, by their indices (s,), `values` returns functions of their points (s,),
    `rates` their slopes.
    """
    crossed = _find_crossed(scanned, periods)
    turning = np.zeros_like(crossed)
    if rates is not None:
        turning[_find_turning(scanned, slopes, np.diff(grid), periods)] = True
    is_met = crossed | turning
    # A function that is zero but for rounding has either sign, step by step, and no crossings.
    is_met[np.isinf(periods) & (is_met.sum(axis=1) > MOST_CROSSED * is_met.shape[1])] = False
    turning &= is_met
    rows, index = np.nonzero(is_met)
    scan = [grid[index], grid[index + 1], scanned[rows, index], scanned[rows, index + 1]]
    cells = _Cells(rows, np.array(scan))
    touches, touch_rows = np.empty(0), np.empty(0, dtype=np.int64)
    if rates is not None and turning.any():
        turned = turning[rows, index]
        turns = cells.select(turned)
        ends = slopes[turns.rows, index[turned]], slopes[turns.rows, index[turned] + 1]
        places = find_bracketed_roots(rates(turns.rows), turns.ends[0], turns.ends[1], ends)
        reached = values(turns.rows)(places)[0]
        distance = np.abs(reached - _round_to_level(reached, periods[turns.rows]))
        largest = np.abs(np.nan_to_num(scanned)).max(axis=1)
        sizes = np.where(np.isinf(periods), largest, periods)[turns.rows]
        is_touch = distance <= TOUCHING * sizes
        touches, touch_rows = places[is_touch], turns.rows[is_touch]
        passed = distance > ROUNDING * sizes  # else rounding would decide whether it crosses twice
        halves = turns.select(passed).split(places[passed], reached[passed])
        is_split = turned.copy()
        is_split[turned] = passed
        uncut = cells.select(~is_split)
        cells = _Cells(
            np.append(uncut.rows, halves.rows), np.append(uncut.ends, halves.ends, axis=1)
        )
    cells, levels = _list_brackets(cells, periods)
    functions = values(cells.rows)

    def shifted(phi: Array) -> tuple[Array, Array]:
        current, slope = functions(phi)
        return current - levels, slope

    low, high, first, last = cells.ends
    roots = find_bracketed_roots(shifted, low, high, (first - levels, last - levels))
    return Crossings(*_fold(roots, cells.rows, cycle), *_fold(touches, touch_rows, cycle))


def _find_crossed(values: Array, periods: Array) -> Flags:
    """Return between which neighbouring samples (m, n) functions cross a level, (m, n - 1)."""
    is_negative = values < 0
    crossed: Flags = is_negative[:, 1:] != is_negative[:, :-1]
    periodic = np.flatnonzero(np.isfinite(periods))
    levels = _count_levels(values[periodic], periods[periodic, None])
    crossed[periodic] = levels[:, 1:] != levels[:, :-1]
    return crossed


def _find_turning(
    values: Array, slopes: Array, steps: Array, periods: Array
) -> tuple[Integers, Integers]:
    """Return functions and intervals (t,) in which these turn round towards a level that is near.

    A power of the distance from where a function touches a level is less than its slope times a
    step, near there.
    """
    rising = slopes > 0
    rows, index = np.nonzero(rising[:, 1:] != rising[:, :-1])
    places = np.stack([index, index + 1])
    ends, rates = values[rows, places], slopes[rows, places]
    gaps = ends - _round_to_level(ends, periods[rows])
    falls = gaps * rates
    is_turning = (falls[0] <= 0) & (falls[1] >= 0)
    is_turning &= np.abs(gaps).min(axis=0) <= steps[index] * np.abs(rates).max(axis=0)
    return rows[is_turning], index[is_turning]


def _round_to_level(values: Array, periods: Array) -> Array:
    """Return the level nearest to values."""
    spacing = np.where(np.isinf(periods), 1.0, periods)
    return np.where(np.isinf(periods), 0.0, spacing * np.round(values / spacing))


def _count_levels(values: Array, periods: Array) -> Array:
    """Return the levels from zero up to values, negative below it; one more without a period, where
    there is one.
    """
    spacing = np.where(np.isinf(periods), 1.0, periods)
    return np.where(np.isinf(periods), np.where(values < 0, -1.0, 0.0), np.floor(values / spacing))


def _list_brackets(cells: _Cells, periods: Array) -> tuple[_Cells, Array]:
    """Return the intervals in which a level is crossed, each as often as levels are, and these."""
    cells = cells.select(np.flatnonzero(np.isfinite(cells.ends[2:]).all(axis=0)))
    cell_periods = periods[cells.rows]
    first, last = _count_levels(cells.ends[2:], cell_periods)
    counts = np.minimum(np.abs(last - first), MAX_LEVELS).astype(np.int64)
    index = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
    multiples = np.minimum(first, last)[index] + 1 + number
    spacing = np.where(np.isinf(cell_periods[index]), 0.0, cell_periods[index])
    return cells.select(index), spacing * multiples


class OwnFunctions:
    """Functions (m, n) with slopes, of which each point (s,) takes one; results of unmoved points
    are reused.
    """

    def __init__(self, functions: FunctionWithSlope, rows: Integers) -> None:
        self._functions, self._rows = functions, rows
        self._points = np.full(len(rows), np.nan)
        self._results = np.empty((2, len(rows)))

    def __call__(self, points: Array) -> tuple[Array, Array]:
        moved = np.flatnonzero(points != self._points)
        if len(moved):
            each = self._rows[moved], np.arange(len(moved))
            self._results[:, moved] = [results[each] for results in self._functions(points[moved])]
        self._points = points.copy()
        first, second = self._results
        return first.copy(), second.copy()


def _fold(angles: Array, rows: Integers, cycle: float) -> tuple[Array, Integers]:
    """Return angles in a cycle in their order, those of one function at both of its ends once, with
    their functions.
    """
    outside = SAME_ANGLE * cycle
    angles = np.where(np.abs(angles - cycle) <= outside, 0.0, angles)
    is_inside = (angles >= -outside) & (angles < cycle)
    angles, rows = np.maximum(angles[is_inside], 0.0), rows[is_inside]
    order = np.lexsort([angles, rows])
    angles, rows = angles[order], rows[order]
    new = (np.diff(angles, prepend=-np.inf) > outside) | (np.diff(rows, prepend=-1) != 0)
    order = np.argsort(angles[new], kind="stable")
    return angles[new][order], rows[new][order]


def bracket_sign_changes(
    value: Callable[[float], float], times: Array, values: Array, sign: float, tolerance: float
) -> Iterator[tuple[float, float, bool]]:
    """Yield ends of intervals in which a value changes its sign, and whether it rises.

    `sign` is the sign before the first time, zero if unknown; a value within the tolerance has none.
    A value that is back at the next time counts, too.
    """
    outside = np.flatnonzero(np.abs(values) > tolerance)
    start = times[0]
    for part in outside:
        if sign * values[part] < 0:
            yield start, times[part], bool(values[part] > 0)
        sign, start = np.sign(values[part]), times[part]
    sizes, is_positive = np.abs(values), values > 0
    for at in 1 + np.flatnonzero((sizes[1:-1] < sizes[:-2]) & (sizes[1:-1] < sizes[2:])):
        if is_positive[at - 1] == is_positive[at] == is_positive[at + 1]:
            side = 1 if is_positive[at] else -1
            dip = scipy.optimize.minimize_scalar(
                lambda time, side=side: side * value(time),
                bounds=(times[at - 1], times[at + 1]),
                method="bounded",
            )
            if dip.fun < -tolerance:
                yield times[at - 1], float(dip.x), side < 0
