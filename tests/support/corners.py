"""Corners of generated array code that no event of its module marks, by evaluating its text with
numbers that remember.

Every branch of array code is evaluated, so that its calls have one order, whatever the numbers are.
A corner is what vanishes where a function is not smooth: the difference of both sides of a
comparison, the argument of a root.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planter.kernels import Array

POSITIVE, NOT_NEGATIVE, UNKNOWN = 1, 0, -1
POINTS, NEAR = 4, 1e-5
"""Pairs of points at which corners are compared with events, and the distance of both points of a
pair [rad].
"""
SCANNED = 200
"""Steps of a turn in which the zeros of a corner are looked for."""
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Traced:
    """A number with what is certain of its sign: even powers are not negative, sums of what is
    certain are.

    `parts` are the numbers that the extremum `kind` was taken of: targets write one of many as one
    of two, and so on.
    """

    value: float
    sign: int = UNKNOWN
    kind: str = ""
    parts: tuple[Traced, ...] = ()

    def __add__(self, other: Any) -> Traced:
        other = _trace(other)
        both = self.sign, other.sign
        return Traced(self.value + other.value, max(both) if min(both) >= NOT_NEGATIVE else UNKNOWN)

    def __mul__(self, other: Any) -> Traced:
        other = _trace(other)
        return Traced(self.value * other.value, min(self.sign, other.sign))

    def __pow__(self, power: int) -> Traced:
        sign = NOT_NEGATIVE if power % 2 == 0 else UNKNOWN
        return Traced(self.value**power, max(sign, self.sign) if power > 0 else self.sign)

    def __truediv__(self, other: Any) -> Traced:
        other = _trace(other)
        return Traced(
            self.value / other.value if other.value else math.nan, min(self.sign, other.sign)
        )

    def __neg__(self) -> Traced:
        return Traced(-self.value)

    def __sub__(self, other: Any) -> Traced:
        return self + -_trace(other)

    def __radd__(self, other: float) -> Traced:
        return _trace(other) + self

    def __rsub__(self, other: float) -> Traced:
        return _trace(other) - self

    def __rmul__(self, other: float) -> Traced:
        return _trace(other) * self

    def __rtruediv__(self, other: float) -> Traced:
        return _trace(other) / self

    def __lt__(self, other: Any) -> Condition:
        return Condition(self.value < _trace(other).value, ((self - other).value,))

    def __le__(self, other: Any) -> Condition:
        return Condition(self.value <= _trace(other).value, ((self - other).value,))

    def __gt__(self, other: Any) -> Condition:
        return Condition(self.value > _trace(other).value, ((self - other).value,))

    def __ge__(self, other: Any) -> Condition:
        return Condition(self.value >= _trace(other).value, ((self - other).value,))

    def __eq__(self, other: object) -> Condition:  # type: ignore[override]
        return Condition(self.value == _trace(other).value, ((self - other).value,))

    def __ne__(self, other: object) -> Condition:  # type: ignore[override]
        return Condition(self.value != _trace(other).value, ((self - other).value,))


@dataclass(frozen=True)
class Condition:
    """Whether comparisons hold, and the differences of their sides."""

    holds: bool
    gaps: tuple[float, ...]


def _trace(number: Any) -> Traced:
    if isinstance(number, Traced):
        return number
    value = float(number)
    return Traced(value, POSITIVE if value > 0 else NOT_NEGATIVE if value == 0 else UNKNOWN)


@dataclass
class TracingNamespace:
    """Elementary functions under NumPy's names, which note the corners that they meet and a word
    for each.
    """

    corners: list[float] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)
    pi = math.pi

    def note(self, kind: str, argument: Traced) -> None:
        """Note a corner, unless the sign of its argument is certain."""
        self._add(kind, math.nan if argument.sign == POSITIVE else argument.value)

    def _add(self, kind: str, corner: float) -> None:
        self.corners.append(corner)
        self.kinds.append(kind)

    def sqrt(self, x: Any) -> Traced:
        x = _trace(x)
        self.note("sqrt", x)
        return Traced(
            math.sqrt(abs(x.value)), max(x.sign, NOT_NEGATIVE)
        )  # of any number, as places count

    def absolute(self, x: Any) -> Traced:
        x = _trace(x)
        self.note("abs", x)
        return Traced(abs(x.value), max(x.sign, NOT_NEGATIVE))

    def sign(self, x: Any) -> Traced:
        self.note("sign", x)
        return Traced(float(np.sign(x.value)))

    def log(self, x: Any) -> Traced:
        self.note("log", x)
        return Traced(math.log(abs(x.value) or 1.0))

    def floor(self, x: Any) -> Traced:
        x = _trace(x)
        self._add("floor", x.value)
        return Traced(float(np.floor(x.value)))

    def arccos(self, x: Any) -> Traced:
        x = _trace(x)
        self._add("acos", 1 - x.value**2)
        return Traced(math.acos(min(max(x.value, -1.0), 1.0)))

    def arcsin(self, x: Any) -> Traced:
        x = _trace(x)
        self._add("asin", 1 - x.value**2)
        return Traced(math.asin(min(max(x.value, -1.0), 1.0)))

    def arctan2(self, y: Any, x: Any) -> Traced:
        y, x = _trace(y), _trace(x)
        self._add("atan2", math.nan if POSITIVE in (x.sign, y.sign) else y.value)
        return Traced(math.atan2(y.value, x.value))

    def maximum(self, a: Any, b: Any) -> Traced:
        return self._select(max, a, b)

    def minimum(self, a: Any, b: Any) -> Traced:
        return self._select(min, a, b)

    def _select(self, function: Callable[..., Any], a: Any, b: Any) -> Traced:
        kind = function.__name__
        first, second = ((n.parts if n.kind == kind else (n,)) for n in map(_trace, (a, b)))
        for left in first:
            for right in second:
                gap = left - right
                self._add(
                    kind, math.nan if POSITIVE in (gap.sign, (right - left).sign) else gap.value
                )
        both = _trace(a), _trace(b)
        signs = [number.sign for number in both]
        return Traced(
            function(n.value for n in both),
            max(signs) if kind == "max" else min(signs),
            kind,
            first + second,
        )

    def where(self, condition: Any, then: Any, other: Any) -> Traced:
        condition = (
            condition if isinstance(condition, Condition) else Condition(bool(condition), ())
        )
        for gap in condition.gaps:
            self._add("where", gap)
        then, other = _trace(then), _trace(other)
        return Traced((then if condition.holds else other).value, min(then.sign, other.sign))

    def logical_or(self, a: Condition, b: Condition) -> Condition:
        return Condition(a.holds or b.holds, a.gaps + b.gaps)

    def logical_and(self, a: Condition, b: Condition) -> Condition:
        return Condition(a.holds and b.holds, a.gaps + b.gaps)

    def logical_not(self, a: Condition) -> Condition:
        return Condition(not a.holds, a.gaps)

    def polyval(self, coefficients: Sequence[Any], x: Any) -> Traced:
        value = _trace(0.0)
        for coefficient in coefficients:
            value = value * x + coefficient
        return Traced(value.value)

    def divide(self, a: Any, b: Any) -> Traced:
        return _trace(a) / b

    def exp(self, x: Any) -> Traced:
        return Traced(math.exp(min(_trace(x).value, 300.0)), POSITIVE)

    def __getattr__(self, name: str) -> Callable[[Any], Traced]:
        return lambda x: Traced(float(getattr(np, name)(_trace(x).value)))


Inputs = Callable[[float], Sequence[Any]]
"""Angle [rad] -> inputs of the lane after its namespace, the angle first; functions that it calls
are among them.
"""


def list_unmarked(
    lane: Callable[..., Any],
    events: Callable[..., Any] | None,
    inputs: Inputs,
    periods: Sequence[float | None],
    turn: float = 2 * math.pi,
    seed: int = 0,
) -> list[str]:
    """Return the corners of a lane that change along the angle and that no event marks, by function
    and number.

    An event marks a corner if both are proportional, but for whole periods, or if it happens where
    the corner vanishes. What is constant but for jumps, which have corners of their own, needs
    none.
    """

    def evaluate(angle: float) -> tuple[TracingNamespace, Array]:
        xp = TracingNamespace()
        arguments = inputs(angle)
        lane(xp, *arguments)
        passed = () if events is None else events(TracingNamespace(), *arguments)
        passed = passed if isinstance(passed, tuple | list) else (passed,)
        return xp, np.array([_trace(value).value for value in passed])

    draws = np.random.default_rng(seed).uniform(0, turn, POINTS)
    traces = [evaluate(angle) for base in draws for angle in (base, base + NEAR)]
    corners = np.array([xp.corners for xp, _ in traces]).reshape(len(traces), -1)
    happened = np.array([values for _, values in traces]).reshape(len(traces), -1)
    kinds = traces[0][0].kinds
    spacing = np.array([math.inf if period is None else period for period in periods])
    unmarked = [
        k
        for k, column in enumerate(corners.T)
        if not np.isnan(column).all()
        and np.abs(column[1::2] - column[::2]).max() > TOLERANCE**2 * np.abs(column).max()
        and not any(
            _matches(column, event, kinds[k], period)
            for event, period in zip(happened.T, spacing, strict=True)
        )
    ]
    return [
        f"{kinds[k]} {k}" for k in unmarked if not _happens_at_zeros(evaluate, k, spacing, turn)
    ]


def _matches(corner: Array, event: Array, kind: str, period: float) -> bool:
    """Return whether an event is proportional to a corner, but for periods passed; a floor has a
    corner at each 1.
    """
    rise, event_rise = corner[1::2] - corner[::2], event[1::2] - event[::2]
    finite = np.isfinite(rise) & np.isfinite(event_rise) & (np.abs(rise) > 0)
    if not finite.any():
        return False
    scales = event_rise[finite] / rise[finite]
    scale = float(np.median(scales))
    if scale == 0 or np.abs(scales - scale).max() > 1e-3 * abs(scale):
        return False
    turns = event / period if math.isfinite(period) else event / np.abs(event).max()
    missed = turns - corner * scale / (period if math.isfinite(period) else np.abs(event).max())
    periods_passed = np.round(missed) if math.isfinite(period) else 0.0
    is_as_dense = kind != "floor" or (
        math.isfinite(period) and abs(abs(scale) / period - 1) < TOLERANCE
    )
    return bool(np.nanmax(np.abs(missed - periods_passed)) < 1e-3) and is_as_dense


def _happens_at_zeros(
    evaluate: Callable[[float], tuple[TracingNamespace, Array]], k: int, spacing: Array, turn: float
) -> bool:
    """Return whether a corner has zeros in a turn, and an event happens at each of them."""
    grid = np.linspace(0, turn, SCANNED + 1) + 0.37 * turn / SCANNED
    values = np.array([evaluate(angle)[0].corners[k] for angle in grid])
    cells = np.flatnonzero((values[1:] > 0) != (values[:-1] > 0))
    for cell in cells:  # by bisection, whatever happens there
        low, high, sign = grid[cell], grid[cell + 1], values[cell] > 0
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (
                (middle, high) if (evaluate(middle)[0].corners[k] > 0) == sign else (low, middle)
            )
        before, after = evaluate(low - NEAR)[1], evaluate(high + NEAR)[1]
        periods_passed = np.where(np.isfinite(spacing), spacing, 1.0)
        passed = np.where(
            np.isfinite(spacing),
            np.floor(before / periods_passed) != np.floor(after / periods_passed),
            before * after <= 0,
        )
        if not passed.any():
            return False
    return len(cells) > 0
