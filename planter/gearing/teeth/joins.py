"""Transitions from flanks to fillets: at the end of the rack's straight flank, or where lines of the rack intersect.

A flank or fillet that turns back leaves a loop in the removed material. The outline follows a line to its first
intersection with the line that leaves the loop: the fillet, or the flank itself farther down.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.flanks import Flanks, split_at_breakpoints
from planter.gearing.teeth.rack import Cut
from planter.kernels import Array
from planter.numerics import simultaneous
from planter.numerics.arrays import Integers

_SAMPLES = 65
"""Points of each smooth part of a line at which a reversal is checked."""
_GRADED_SHARES = np.append(np.linspace(1, 0.5, 81)[:-1], np.geomspace(0.5, 1e-9, 160))
"""Trial points for intersections, as shares of the lengths from the reversal: smaller loops intersect nearer to it."""
_ROUNDING = 8 * np.finfo(float).eps
"""Relative accuracy of an intersection: at a reversal the arc length determines the point less accurately."""


@dataclass(frozen=True)
class FlankLine:
    """A part of a flank, of its fillet or of half its root, by the arc lengths at which upper and lower end are cut."""

    kind: Literal["flank", "fillet", "root"]
    upper: float
    lower: float


def build_flank_lines(flanks: Flanks) -> list[list[FlankLine]]:
    """Return the lines of the outline along each flank (2 z), from the tip to the middle of the adjacent root.

    Raises GeometryError for a tooth whose flank meets no fillet.
    """
    ends = np.array([flanks.tips[0], flanks.straight_ends, flanks.middle, flanks.spaces]).T.tolist()
    lines = [
        [FlankLine("flank", tip, end), FlankLine("fillet", end, middle), FlankLine("root", middle, space)]
        for tip, end, middle, space in ends
    ]
    for flank in _find_loops(flanks):
        lines[flank] = _follow_outline(flanks, int(flank))
    return lines


def _find_loops(flanks: Flanks) -> Integers:
    """Return the flanks that turn back, and those whose fillets do."""
    indices = np.arange(2 * flanks.z)
    low, high = np.sort([flanks.middle, flanks.straight_ends], axis=0)
    index, starts, ends = split_at_breakpoints(flanks.curve, low, high)
    grid = starts[:, None] + np.outer(ends - starts, np.linspace(0, 1, _SAMPLES))
    towards = np.repeat((starts + ends) / 2, _SAMPLES)
    rate = flanks.fillet(grid.ravel(), np.repeat(index, _SAMPLES), towards).rate.reshape(grid.shape)
    back = np.bincount(index, (rate >= 0).any(axis=1), len(indices)) > 0
    return np.flatnonzero((flanks.rate_minima.value < 0) | back)


def _follow_outline(flanks: Flanks, flank: int) -> list[FlankLine]:
    """Return the outline along a flank with loops: its forward parts, each up to the first intersection."""
    lines, outline = list(_list_forward_parts(flanks, flank)), []
    current, at = 0, lines[0].upper
    while current < len(lines) - 1:
        line, later = lines[current], lines[current + 1 :]
        smooth = line.lower == later[0].upper
        crossed = _find_crossing(flanks, flank, FlankLine(line.kind, at, line.lower), later[smooth:])
        if crossed is None and not smooth:
            raise GeometryError(
                f"a flank of tooth {flanks.tooth[flank]} meets no fillet: it is cut away, or the round on the tips of "
                f"the rack is too small for a hollow place"
            )
        number, end, start = crossed or (0, line.lower, later[0].upper)
        outline.append(FlankLine(line.kind, at, end))
        current, at = current + 1 + number + (smooth and crossed is not None), start
    return [*outline, FlankLine("root", at, lines[-1].lower)]


def _list_forward_parts(flanks: Flanks, flank: int) -> Iterator[FlankLine]:
    """Yield the parts of a flank and its fillet that do not turn back, from the tip down, and half of the root."""
    xi, tip, straight, middle, space = (
        float(s[flank]) for s in (flanks.xi, flanks.tips[0], flanks.straight_ends, flanks.middle, flanks.spaces)
    )
    index = np.array([flank])
    turns = list(_find_turns(flanks, xi, straight,
                        lambda s, towards: -flanks.compute_rates(s, np.repeat(index, len(s)), towards)[0]))  # fmt: skip
    back = list(_find_turns(flanks, straight, middle,
                       lambda s, towards: flanks.fillet(s, np.repeat(index, len(s)), towards).rate))  # fmt: skip
    yield from (FlankLine("flank", a, b) for a, b in list(pairwise([tip, *turns, straight]))[::2])
    yield from (FlankLine("fillet", a, b) for a, b in list(pairwise([straight, *back, middle]))[::2])
    yield FlankLine("root", middle, space)


def _find_turns(flanks: Flanks, start: float, end: float, bad: Callable[[Array, Array], Array]) -> Iterator[float]:
    """Yield arc lengths [m] from `start` to `end` at which a function of arc length and side changes its sign."""
    from scipy.optimize import brentq

    low, high = sorted((start, end))
    _, lows, highs = split_at_breakpoints(flanks.curve, np.array([low]), np.array([high]))
    parts = np.array([lows, highs]).T
    before = False
    for a, b in parts if start < end else parts[::-1, ::-1]:
        grid, towards = np.linspace(a, b, _SAMPLES), np.full(_SAMPLES, (a + b) / 2)
        signs = bad(grid, towards) > 0
        if signs[0] != before:
            yield float(a)
        for k in np.flatnonzero(signs[1:] != signs[:-1]):
            yield brentq(lambda s: bad(np.array([s]), towards[:1])[0], grid[k], grid[k + 1], xtol=1e-15)  # noqa: B023
        before = bool(signs[-1])


def _find_crossing(
    flanks: Flanks, flank: int, line: FlankLine, candidates_below: Sequence[FlankLine]
) -> tuple[int, float, float] | None:
    """Return the number of the line that a line intersects first on its way down, and both arc lengths [m]."""
    index = np.repeat(np.array([flank]), len(_GRADED_SHARES))
    arcs = line.lower + (line.upper - line.lower) * _GRADED_SHARES
    candidates = []
    for number, lower_line in enumerate(candidates_below):
        other_arcs = lower_line.upper + (lower_line.lower - lower_line.upper) * _GRADED_SHARES
        chords = _find_chords(
            _select_cut(flanks, line)(arcs, index).points, _select_cut(flanks, lower_line)(other_arcs, index).points
        )
        if chords is not None:
            k, i = chords
            candidates.append((k, number, np.array([arcs[k : k + 2].mean(), other_arcs[i : i + 2].mean()])))
    if not candidates:
        return None
    _, number, start = min(candidates, key=lambda candidate: candidate[:2])

    def gap(at: Array) -> tuple[Array, Array]:
        a = _select_cut(flanks, line)(at[0], index[:1])
        b = _select_cut(flanks, candidates_below[number])(at[1], index[:1])
        return a.points - b.points, np.stack([a.rate * a.tangents, -b.rate * b.tangents], axis=1)

    rounding = _ROUNDING * np.abs(_select_cut(flanks, line)(start[:1], index[:1]).points).max()
    at = simultaneous.newton(gap, start[:, None], np.full(2, flanks.rack.module / 20), rounding)
    return number, float(at[0, 0]), float(at[1, 0])


def _select_cut(flanks: Flanks, line: FlankLine) -> Callable[[Array, Integers], Cut]:
    return {"flank": flanks.flank, "fillet": flanks.fillet, "root": flanks.root}[line.kind]


def _find_chords(line: Array, other: Array) -> tuple[int, int] | None:
    """Return the first chord of a line (2, n) that intersects another line, and the first chord there; else None."""
    a, b = line[:, :-1, None], line[:, 1:, None]
    c, d = other[:, None, :-1], other[:, None, 1:]
    across = (_double_area(a, b, c) * _double_area(a, b, d) < 0) & (_double_area(c, d, a) * _double_area(c, d, b) < 0)
    if not across.any():
        return None
    first = int(np.argmax(across.any(axis=1)))
    return first, int(np.argmax(across[first]))


def _double_area(a: Array, b: Array, c: Array) -> Array:
    """Return twice the area of the triangle a, b, c."""
    area: Array = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return area
