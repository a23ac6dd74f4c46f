"""The basic rack, the flanks and fillets that it cuts on a pitch curve, and the lines of the
outline along them.

A flank or fillet that turns back leaves a loop in the removed material. The outline follows a line
to its first intersection with the line that leaves the loop: the fillet, or the flank itself
farther down.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
import scipy

from planter.errors import GeometryError
from planter.gears.geometry.pitch_curves import KAPPA, POLAR, RACK, PitchCurve
from planter.kernels import Array, Integers, formulas
from planter.numerics import roots
from planter.numerics.arrays import double_area


@dataclass(frozen=True)
class Cut:
    """Curve cut by a rack: points (2, n) [m], unit tangents (2, n), rate and turning (n,) of
    `rack_teeth`.
    """

    points: Array
    tangents: Array
    rate: Array
    turning: Array

    @classmethod
    def from_columns(cls, columns: Mapping[str, Array]) -> Cut:
        """Return the cut of the columns that a function of `rack_teeth` returns."""
        px, py, ex, ey, rate, turning = columns.values()
        return cls(np.array([px, py]), np.array([ex, ey]), rate, turning)


@dataclass(frozen=True)
class Rack:
    """Module [m], pressure angle [rad], heights and profile shift in modules, backlash of a pair
    [m].

    The tip radius is the largest with which the straight flanks end at the addendum, but at most
    `tip_radius` modules; a smaller one lets them reach deeper.
    """

    module: float
    pressure_angle: float = np.pi / 9
    addendum: float = 1.0
    clearance: float = 0.25
    shift: float = 0.0
    play: float = 0.0
    tip_radius: float = 1.0

    @cached_property
    def sizes(self) -> dict[str, float]:
        """Sizes of the rack [m] by the names of the derivation."""
        heights = self.addendum, self.clearance, self.shift
        parameters = [self.module, *heights, self.pressure_angle, self.play, self.tip_radius]
        return RACK.at("sizes", rack=parameters)

    @property
    def pitch(self) -> float:
        return self.sizes["pitch_"]

    def mate(self) -> Rack:
        """Return the rack of the conjugate gear, with the opposite profile shift."""
        return replace(self, shift=0.0 - self.shift)

    def run(self, depth: float) -> float:
        """Return the length of the pitch curve [m] on which a straight flank is cut down to a depth
        [m].
        """
        return RACK.at("reach", kappa=0.0, height=depth, alpha=self.pressure_angle)["reach"]


TEETH = formulas.load("gear_teeth")
"""Functions of teeth at the curvatures of two pitch curves; `teeth`: module, addenda in modules,
pressure angle.
"""


_CELLS = 16
"""Cells of each smooth part in the search for extremes of a flank's rate."""
EMPTY_SHARE = 1e-12
"""Share of a curve's length below which a part is empty."""


@dataclass(frozen=True)
class Flanks:
    """Both flanks of z teeth that a rack cuts on a curve, (2 z,) each: all that begin a tooth, then
    all that end one.

    Tooth 0 is centred at arc length `phase` [m]; `d` is the length of the pitch curve from a
    flank's crossing to where a point of it is cut, towards its root.
    """

    curve: PitchCurve
    rack: Rack
    z: int
    phase: float

    @cached_property
    def tooth(self) -> Integers:
        return np.tile(np.arange(self.z), 2)

    @cached_property
    def side(self) -> Array:
        return np.repeat([-1.0, 1.0], self.z)

    @cached_property
    def centre(self) -> Array:
        """Arc lengths of the teeth's centres."""
        return self.phase + self.rack.pitch * self.tooth.astype(float)

    @cached_property
    def xi(self) -> Array:
        """Arc lengths at which the flanks cross the pitch curve."""
        return self.centre + self.side * self.rack.sizes["half"]

    @cached_property
    def middle(self) -> Array:
        """Arc lengths of the centres of the rack's tip radius next to each flank, at which its
        fillet ends.
        """
        return self.centre + self.side * self.rack.sizes["beside"]

    @cached_property
    def spaces(self) -> Array:
        """Arc lengths of the middle of the tooth space next to each flank."""
        return self.centre + self.side * self.rack.pitch / 2

    def line(self, s: Array, xi: Array, side: Array, towards: Array | None = None) -> Cut:
        """Return the cuts at arc lengths s (n,) of straight rack flanks that cross the pitch line
        at xi (n,) [m].
        """
        place = self.curve.at(s, towards)[:POLAR]
        return Cut.from_columns(
            RACK("flank", place=place, s=s, xi=xi, side=side, alpha=self.rack.pressure_angle)
        )

    def flank(self, s: Array, index: Integers, towards: Array | None = None) -> Cut:
        """Return flanks (n,) by their numbers at arc lengths (n,) [m]."""
        return self.line(s, self.xi[index], self.side[index], towards)

    def fillet(self, s: Array, index: Integers, towards: Array | None = None) -> Cut:
        """Return fillets (n,) by their numbers at arc lengths (n,) [m]."""
        place, sizes = self.curve.at(s, towards)[:POLAR], self.rack.sizes
        return Cut.from_columns(
            RACK(
                "fillet",
                place=place,
                s=s,
                middle=self.middle[index],
                depth=sizes["sunk"],
                rho=sizes["round_"],
            )
        )

    def cut(self, kind: str, s: Array, index: Integers, towards: Array | None = None) -> Cut:
        """Return pieces (n,) of a kind, by the numbers of their flanks, at arc lengths (n,) [m];
        tip and root are the same for all flanks.
        """
        if kind in ("tip", "root"):
            height = self.rack.sizes[kind] * (1 if kind == "tip" else -1)
            return self.equidistant(s, height, towards)
        return (self.flank if kind == "flank" else self.fillet)(s, index, towards)

    def equidistant(self, s: Array, height: float, towards: Array | None = None) -> Cut:
        """Return the line at a height [m] over the pitch curve."""
        return Cut.from_columns(
            RACK("equidistant", place=self.curve.at(s, towards)[:POLAR], height=height)
        )

    @cached_property
    def tips(self) -> tuple[Array, Array]:
        """Arc lengths (2 z,) of flank and tip line in their intersection."""
        height, index = self.rack.sizes["tip"], np.arange(2 * self.z)
        # on a concave curve the reach of the rack itself is the better start
        kappa = np.maximum(self.curve.at(self.xi)[KAPPA], 0.0)
        reach = RACK("reach", kappa=kappa, height=height, alpha=self.rack.pressure_angle)["reach"]

        def gap(at: Array) -> tuple[Array, Array]:
            cut, line = self.flank(at[0], index), self.equidistant(at[1], height)
            slopes = np.stack([cut.rate * cut.tangents, -line.rate * line.tangents], axis=1)
            return cut.points - line.points, slopes

        start = np.array([self.xi - self.side * reach, self.xi])
        try:
            flank, tip = roots.solve_systems(gap, start, np.full(2, self.rack.module))
        except roots.UnsolvedSystemError as error:
            raise GeometryError(
                f"a flank of tooth {self.tooth[error.index]} does not reach its tip on a concave "
                f"pitch curve: "
                f"reduce the addendum"
            ) from error
        return flank, tip

    @cached_property
    def straight_ends(self) -> Array:
        """Arc lengths where the rack's straight flank ends."""
        return self.xi + self.side * self.rack.run(self.rack.sizes["straight"])

    @cached_property
    def margins(self) -> Array:
        """Smallest rate of each flank from its crossing down to the rack's addendum, 1 on a rack;
        undercut below 0.
        """
        ends = self.xi + self.side * self.rack.run(self.rack.sizes["form"])
        return self._find_minima(self.xi, ends)

    @cached_property
    def upper_margins(self) -> Array:
        """Smallest rate of each flank from its crossing up to its tip, which concave curves
        reduce.
        """
        return self._find_minima(self.tips[0], self.xi)

    @cached_property
    def rate_minima(self) -> Array:
        """Minima of the rate of each flank down to the end of the rack's straight flank."""
        return self._find_minima(self.xi, self.straight_ends)

    def _find_minima(self, start: Array, end: Array) -> Array:
        """Return the minima of each flank's rate, relative to a rack, between two arc lengths (2
        z,) [m].
        """
        index, low, high = split_at_breakpoints(
            self.curve, np.minimum(start, end), np.maximum(start, end)
        )
        grid = low[:, None] + np.outer(high - low, np.linspace(0, 1, _CELLS + 1))
        middle = np.broadcast_to((low + high)[:, None] / 2, grid.shape).ravel()
        owner, places = np.repeat(index, _CELLS + 1), grid.ravel()
        slopes = self.compute_rates(places, owner, middle)[1].reshape(grid.shape)
        part, cell = np.nonzero((slopes[:, :-1] < 0) & (slopes[:, 1:] > 0))
        if len(part):
            ends = slopes[part, cell], slopes[part, cell + 1]
            inside = roots.find_bracketed_roots(
                lambda s: self.compute_rates(s, index[part])[1:],
                grid[part, cell],
                grid[part, cell + 1],
                ends,
            )
            owner, places = np.append(owner, index[part]), np.append(places, inside)
            middle = np.append(middle, inside)
        rates = self.compute_rates(places, owner, middle)[0]
        # ends, breakpoints and stationary points together: the least of an owner comes first
        order = np.lexsort((rates, owner))
        return rates[order[np.searchsorted(owner[order], np.arange(2 * self.z))]]

    def compute_rates(
        self, s: Array, index: Integers, towards: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return the rate of flanks relative to a rack, and its first two derivatives by arc
        length.
        """
        bends, alpha = self.curve.bends(s, towards), self.rack.pressure_angle
        columns = RACK(
            "regularity", bends=bends, s=s, xi=self.xi[index], side=self.side[index], alpha=alpha
        )
        value, first, second = columns.values()
        return value, first, second


def split_at_breakpoints(
    curve: PitchCurve, low: Array, high: Array
) -> tuple[Integers, Array, Array]:
    """Return intervals (n,) of arc length split at the breakpoints of a curve: interval number,
    start and end [m].
    """
    index, cuts = np.arange(len(low)), [(np.arange(len(low)), low)]
    for joint in curve.joints:
        # a breakpoint at an end of an interval splits nothing
        ahead = np.mod(joint - low, curve.length)
        # a tolerance, since ends often are breakpoints but for rounding
        inside = np.flatnonzero(
            (ahead > EMPTY_SHARE * curve.length) & (ahead < high - low - EMPTY_SHARE * curve.length)
        )
        cuts.append((inside, low[inside] + ahead[inside]))
    index, starts = (np.concatenate(parts) for parts in zip(*cuts, strict=True))
    order = np.lexsort((starts, index))
    index, starts = index[order], starts[order]
    last = np.append(index[1:] != index[:-1], True)
    ends = np.where(last, high[index], np.append(starts[1:], 0.0))
    return index, starts, ends


_SAMPLES = 65
"""Points of each smooth part of a line at which a reversal is checked."""
_GRADED_SHARES = np.append(np.linspace(1, 0.5, 81)[:-1], np.geomspace(0.5, 1e-9, 160))
"""Trial points for intersections, as shares of the lengths from the reversal: smaller loops
intersect nearer to it.
"""
_ROUNDING = 8 * np.finfo(float).eps
"""Relative accuracy of an intersection: at a reversal the arc length determines the point less
accurately.
"""


@dataclass(frozen=True)
class FlankLine:
    """A part of a flank, of its fillet or of half its root, by the arc lengths at which upper and
    lower end are cut.
    """

    kind: str
    upper: float
    lower: float


def build_flank_lines(flanks: Flanks) -> list[list[FlankLine]]:
    """Return the lines of the outline along each flank (2 z), from the tip to the middle of the
    adjacent root.

    Raises GeometryError for a tooth whose flank meets no fillet.
    """
    ends = np.array([flanks.tips[0], flanks.straight_ends, flanks.middle, flanks.spaces]).T.tolist()
    lines = [
        [
            FlankLine("flank", tip, end),
            FlankLine("fillet", end, middle),
            FlankLine("root", middle, space),
        ]
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
    return np.flatnonzero((flanks.rate_minima < 0) | back)


def _follow_outline(flanks: Flanks, flank: int) -> list[FlankLine]:
    """Return the outline along a flank with loops: its forward parts, each up to the first
    intersection.
    """
    lines, outline = list(_list_forward_parts(flanks, flank)), []
    current, at = 0, lines[0].upper
    while current < len(lines) - 1:
        line, later = lines[current], lines[current + 1 :]
        smooth = line.lower == later[0].upper
        crossed = _find_crossing(
            flanks, flank, FlankLine(line.kind, at, line.lower), later[smooth:]
        )
        if crossed is None and not smooth:
            raise GeometryError(
                f"a flank of tooth {flanks.tooth[flank]} meets no fillet: it is cut away, or the "
                f"round on the tips of "
                f"the rack is too small for a hollow place"
            )
        number, end, start = crossed or (0, line.lower, later[0].upper)
        outline.append(FlankLine(line.kind, at, end))
        current, at = current + 1 + number + (smooth and crossed is not None), start
    return [*outline, FlankLine("root", at, lines[-1].lower)]


def _list_forward_parts(flanks: Flanks, flank: int) -> Iterator[FlankLine]:
    """Yield the parts of a flank and its fillet that do not turn back, from the tip down, and half
    of the root.
    """
    xi, tip, straight, middle, space = (
        float(s[flank])
        for s in (flanks.xi, flanks.tips[0], flanks.straight_ends, flanks.middle, flanks.spaces)
    )
    index = np.array([flank])

    def turns_back(kind: str, s: Array, towards: Array) -> Array:
        number = np.repeat(index, len(s))
        if kind == "flank":
            return -flanks.compute_rates(s, number, towards)[0]
        return flanks.fillet(s, number, towards).rate

    parts = {"flank": (tip, xi, straight), "fillet": (straight, straight, middle)}
    for kind, (begin, start, end) in parts.items():
        turns = _find_turns(flanks, start, end, partial(turns_back, kind))
        for upper, lower in list(pairwise([begin, *turns, end]))[::2]:
            yield FlankLine(kind, upper, lower)
    yield FlankLine("root", middle, space)


def _find_turns(
    flanks: Flanks, start: float, end: float, bad: Callable[[Array, Array], Array]
) -> Iterator[float]:
    """Yield arc lengths [m] from `start` to `end` at which a function of arc length and side
    changes its sign.
    """
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
            inside = towards[:1]
            yield scipy.optimize.brentq(
                lambda s, inside=inside: bad(np.array([s]), inside)[0],
                grid[k],
                grid[k + 1],
                xtol=1e-15,
            )
        before = bool(signs[-1])


def _find_crossing(
    flanks: Flanks, flank: int, line: FlankLine, candidates_below: Sequence[FlankLine]
) -> tuple[int, float, float] | None:
    """Return the number of the line that a line intersects first on its way down, and both arc
    lengths [m].
    """
    index = np.repeat(np.array([flank]), len(_GRADED_SHARES))
    arcs = line.lower + (line.upper - line.lower) * _GRADED_SHARES
    candidates = []
    for number, lower_line in enumerate(candidates_below):
        other_arcs = lower_line.upper + (lower_line.lower - lower_line.upper) * _GRADED_SHARES
        chords = _find_chords(
            flanks.cut(line.kind, arcs, index).points,
            flanks.cut(lower_line.kind, other_arcs, index).points,
        )
        if chords is not None:
            k, i = chords
            candidates.append(
                (k, number, np.array([arcs[k : k + 2].mean(), other_arcs[i : i + 2].mean()]))
            )
    if not candidates:
        return None
    # the first crossing on the way down is where the outline leaves the line
    _, number, start = min(candidates, key=lambda candidate: candidate[:2])

    def gap(at: Array) -> tuple[Array, Array]:
        a = flanks.cut(line.kind, at[0], index[:1])
        b = flanks.cut(candidates_below[number].kind, at[1], index[:1])
        return a.points - b.points, np.stack([a.rate * a.tangents, -b.rate * b.tangents], axis=1)

    # at a reversal both lines are parallel, and Newton's method stalls before a fixed tolerance
    rounding = _ROUNDING * np.abs(flanks.cut(line.kind, start[:1], index[:1]).points).max()
    at = roots.solve_systems(gap, start[:, None], np.full(2, flanks.rack.module / 20), rounding)
    return number, float(at[0, 0]), float(at[1, 0])


def _find_chords(line: Array, other: Array) -> tuple[int, int] | None:
    """Return the first chord of a line (2, n) that intersects another line, and the first chord
    there; else None.
    """
    a, b = line[:, :-1, None], line[:, 1:, None]
    c, d = other[:, None, :-1], other[:, None, 1:]
    across = (double_area(a, b, c) * double_area(a, b, d) < 0) & (
        double_area(c, d, a) * double_area(c, d, b) < 0
    )
    if not across.any():
        return None
    first = int(np.argmax(across.any(axis=1)))
    return first, int(np.argmax(across[first]))
