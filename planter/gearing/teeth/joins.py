"""How a flank goes over into its fillet: at the end of the rack's straight flank, or where lines of the rack cross.

A flank that turns back, or a fillet that does, leaves a loop that lies in what the rack takes away. The outline follows
a line down to where it first crosses what comes out of the loop: the fillet, or the flank itself farther down.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.flanks import Flanks, smooth_parts
from planter.gearing.teeth.rack import Cut
from planter.kernels import Array
from planter.numerics import simultaneous
from planter.numerics.arrays import Integers

_TRIED = 65
"""Places on each smooth part of a line where it is looked whether it turns back."""
_GRADED = np.append(np.linspace(1, 0.5, 81)[:-1], np.geomspace(0.5, 1e-9, 160))
"""Where lines are tried for where they cross, as shares of their lengths from where they turn back: the smaller a loop,
the nearer to there it is crossed."""
_ROUNDING = 8 * np.finfo(float).eps
"""Share of a point to which it is met: where a line turns back it stands still, and its arc length says less."""


@dataclass(frozen=True)
class Line:
    """A part of a flank, of its fillet or of half its root, by the arc lengths at which upper and lower end are cut."""

    kind: Literal["flank", "fillet", "root"]
    upper: float
    lower: float


def paths(flanks: Flanks) -> list[list[Line]]:
    """The lines of the outline from the tip to the middle of the root beside each of the flanks (2 z).

    Raises GeometryError for a tooth whose flank meets no fillet.
    """
    ends = np.array([flanks.tips[0], flanks.straight_ends, flanks.middle, flanks.spaces]).T.tolist()
    found = [
        [Line("flank", tip, end), Line("fillet", end, middle), Line("root", middle, space)]
        for tip, end, middle, space in ends
    ]
    for one in _looped(flanks):
        found[one] = _walked(flanks, int(one))
    return found


def _looped(flanks: Flanks) -> Integers:
    """Flanks that turn back, and those whose fillets do."""
    every = np.arange(2 * flanks.z)
    low, high = np.sort([flanks.middle, flanks.straight_ends], axis=0)
    which, starts, ends = smooth_parts(flanks.curve, low, high)
    grid = starts[:, None] + np.outer(ends - starts, np.linspace(0, 1, _TRIED))
    towards = np.repeat((starts + ends) / 2, _TRIED)
    rate = flanks.fillet(grid.ravel(), np.repeat(which, _TRIED), towards).rate.reshape(grid.shape)
    back = np.bincount(which, (rate >= 0).any(axis=1), len(every)) > 0
    return np.flatnonzero((flanks.whole.value < 0) | back)


def _walked(flanks: Flanks, one: int) -> list[Line]:
    """The outline along a flank with loops: what goes forward, and from there on what it crosses first."""
    lines, found = list(_forward(flanks, one)), []
    current, at = 0, lines[0].upper
    while current < len(lines) - 1:
        line, later = lines[current], lines[current + 1 :]
        smooth = line.lower == later[0].upper
        crossed = _crossed(flanks, one, Line(line.kind, at, line.lower), later[smooth:])
        if crossed is None and not smooth:
            raise GeometryError(
                f"a flank of tooth {flanks.tooth[one]} meets no fillet: it is cut away, or the round on the tips of "
                f"the rack is too small for a hollow place"
            )
        number, end, start = crossed or (0, line.lower, later[0].upper)
        found.append(Line(line.kind, at, end))
        current, at = current + 1 + number + (smooth and crossed is not None), start
    return [*found, Line("root", at, lines[-1].lower)]


def _forward(flanks: Flanks, one: int) -> Iterator[Line]:
    """The parts of a flank and of its fillet that do not turn back, from the tip down, and its half of the root."""
    xi, tip, straight, middle, space = (
        float(s[one]) for s in (flanks.xi, flanks.tips[0], flanks.straight_ends, flanks.middle, flanks.spaces)
    )
    which = np.array([one])
    turns = list(_turns(flanks, xi, straight,
                        lambda s, towards: -flanks.regular(s, np.repeat(which, len(s)), towards)[0]))  # fmt: skip
    back = list(_turns(flanks, straight, middle,
                       lambda s, towards: flanks.fillet(s, np.repeat(which, len(s)), towards).rate))  # fmt: skip
    yield from (Line("flank", a, b) for a, b in list(pairwise([tip, *turns, straight]))[::2])
    yield from (Line("fillet", a, b) for a, b in list(pairwise([straight, *back, middle]))[::2])
    yield Line("root", middle, space)


def _turns(flanks: Flanks, start: float, end: float, bad: Callable[[Array, Array], Array]) -> Iterator[float]:
    """Arc lengths, from a start to an end, at which a function of them and of the side of a joint changes its sign."""
    from scipy.optimize import brentq

    low, high = sorted((start, end))
    _, lows, highs = smooth_parts(flanks.curve, np.array([low]), np.array([high]))
    parts = np.array([lows, highs]).T
    before = False
    for a, b in parts if start < end else parts[::-1, ::-1]:
        grid, towards = np.linspace(a, b, _TRIED), np.full(_TRIED, (a + b) / 2)
        now = bad(grid, towards) > 0
        if now[0] != before:
            yield float(a)
        for k in np.flatnonzero(now[1:] != now[:-1]):
            yield brentq(lambda s: bad(np.array([s]), towards[:1])[0], grid[k], grid[k + 1], xtol=1e-15)  # noqa: B023
        before = bool(now[-1])


def _crossed(flanks: Flanks, one: int, line: Line, others: Sequence[Line]) -> tuple[int, float, float] | None:
    """Which of other lines a line first crosses on its way down, and the arc lengths of both there."""
    which = np.repeat(np.array([one]), len(_GRADED))
    here = line.lower + (line.upper - line.lower) * _GRADED
    found = []
    for number, other in enumerate(others):
        there = other.upper + (other.lower - other.upper) * _GRADED
        chords = _chords(_cutting(flanks, line)(here, which).points, _cutting(flanks, other)(there, which).points)
        if chords is not None:
            k, i = chords
            found.append((k, number, np.array([here[k : k + 2].mean(), there[i : i + 2].mean()])))
    if not found:
        return None
    _, number, start = min(found, key=lambda candidate: candidate[:2])

    def gap(at: Array) -> tuple[Array, Array]:
        a = _cutting(flanks, line)(at[0], which[:1])
        b = _cutting(flanks, others[number])(at[1], which[:1])
        return a.points - b.points, np.stack([a.rate * a.tangents, -b.rate * b.tangents], axis=1)

    rounding = _ROUNDING * np.abs(_cutting(flanks, line)(start[:1], which[:1]).points).max()
    at = simultaneous.newton(gap, start[:, None], np.full(2, flanks.rack.module / 20), rounding)
    return number, float(at[0, 0]), float(at[1, 0])


def _cutting(flanks: Flanks, line: Line) -> Callable[[Array, Integers], Cut]:
    return {"flank": flanks.flank, "fillet": flanks.fillet, "root": flanks.root}[line.kind]


def _chords(one: Array, other: Array) -> tuple[int, int] | None:
    """Numbers of the first chord of a line (2, n) that crosses another line, and of the first there that it crosses."""
    a, b = one[:, :-1, None], one[:, 1:, None]
    c, d = other[:, None, :-1], other[:, None, 1:]
    across = (_turn(a, b, c) * _turn(a, b, d) < 0) & (_turn(c, d, a) * _turn(c, d, b) < 0)
    if not across.any():
        return None
    first = int(np.argmax(across.any(axis=1)))
    return first, int(np.argmax(across[first]))


def _turn(a: Array, b: Array, c: Array) -> Array:
    """Twice the area of the triangle from a over b to c."""
    found: Array = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return found
