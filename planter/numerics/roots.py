"""Roots by Newton's method: of many bracketed functions at once, of many small systems, and crossings in a cycle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.numerics.arrays import Integers

FunctionWithSlope = Callable[[Array], tuple[Array, Array]]
SystemOfEquations = Callable[[Array], tuple[Array, Array]]
"""Unknowns (k, n) -> residuals (k, n), and their Jacobian (k, k, n) with one row for each equation."""
MAX_BRACKET_STEPS, MAX_SYSTEM_STEPS = 100, 40
STEP_TOLERANCE = 1e-9
"""Relative size of a Newton step after which the next step would be rounding."""
STALL_TOLERANCE = 1e-6
"""Relative size below which Newton steps that no longer shrink are rounding of the function."""


class UnsolvedSystemError(ComputationError):
    """Failure to solve one of many systems; `index` is the first such system."""

    name = "NotFoundError"

    def __init__(self, index: int) -> None:
        super().__init__(f"system of equations {index + 1} was not solved in {MAX_SYSTEM_STEPS} steps")
        self.index = index


def find_bracketed_roots(function: FunctionWithSlope, low: Array, high: Array, ends: tuple[Array, Array]) -> Array:
    """Return the roots (m,) of m functions, each in its bracket [low, high].

    `ends` are the values there, of opposite sign or zero. `function` returns values and derivatives, (m,) each, at m
    points. A Newton step that leaves its bracket is replaced by bisection. Raises ComputationError if a root is not
    determined to rounding, of the point or of the function.
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
        target = points - np.divide(value, slope, out=np.full_like(value, np.inf), where=slope != 0)
        inside = (low <= target) & (target <= high)
        following = np.where(inside, target, (low + high) / 2)
        following = np.where((value == 0) | ~open_, points, following)
        change = np.abs(following - points)
        points, bisected = following, ~inside & (change > 4 * np.finfo(float).eps * size)
        open_ &= bisected | ~(change <= np.where(change >= last, STALL_TOLERANCE, STEP_TOLERANCE) * size)
        last = change
        if not open_.any():
            return points
    raise ComputationError(f"a root was not found in {MAX_BRACKET_STEPS} steps, near {points[open_][0]:.6g}")


def solve_systems(system: SystemOfEquations, start: Array, largest: Array, rounding: float = 0.0) -> Array:
    """Return the unknowns (k, n) that solve n systems of k equations; no step is longer than `largest` (k,).

    A system with residuals up to `rounding` counts as solved, however badly it determines its unknowns. Raises
    UnsolvedSystemError for the first system that is not solved to rounding.
    """
    points, last, done = start.copy(), np.full(start.shape[1], np.inf), np.zeros(start.shape[1], dtype=bool)
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
    """Return the solutions (k, n) of n linear systems. Raises UnsolvedSystemError for the first singular one."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0].T)
    except np.linalg.LinAlgError:
        raise UnsolvedSystemError(int(np.argmin(np.abs(np.linalg.det(matrices))))) from None


def find_crossings(
    values: Callable[[Array], Array], derivatives: Callable[[Array], tuple[Array, Array]], periods: Array, count: int,
    cycle: float,
) -> tuple[Array, Integers]:  # fmt: skip
    """Return the sorted angles (s,) in [0, cycle) at which functions (m,) cross a level, and the rows of the functions.

    The levels are the multiples of `periods` (m,), or zero alone if the period is infinite. `values` (m, n) at angles
    (n,) are scanned in `count` steps of a cycle; `derivatives` returns them with their slopes. Two crossings of a
    function in one step are missed.
    """
    # Offset by half a step: functions often cross at whole steps, where rounding would decide between two steps.
    grid = cycle * (np.arange(count + 1) - 0.5) / count
    scanned, aperiodic = values(grid), np.isinf(periods)[:, None]
    multiples = np.where(aperiodic, np.where(scanned < 0, -1.0, 0.0), np.floor(scanned / periods[:, None]))
    rows, cells = np.nonzero(multiples[:, 1:] != multiples[:, :-1])
    if not len(rows):
        return np.empty(0), rows
    spacing = np.where(np.isinf(periods), 0.0, periods)[rows]
    levels = np.maximum(multiples[rows, cells], multiples[rows, cells + 1]) * spacing
    lanes = np.arange(len(rows))

    def function(phi: Array) -> tuple[Array, Array]:
        current, slopes = derivatives(phi)
        return current[rows, lanes] - levels, slopes[rows, lanes]

    ends = scanned[rows, cells] - levels, scanned[rows, cells + 1] - levels
    angles = np.mod(find_bracketed_roots(function, grid[cells], grid[cells + 1], ends), cycle)
    order = np.argsort(angles, kind="stable")
    return angles[order], rows[order]
