"""Measures of a turn and limits on them as a smooth programme: what it minimises, and the rows that it keeps.

A largest or least value becomes a variable of its own, t, that all samples keep below or above it: the epigraph form.
The variables are those of the design (p,), then the t's; nothing here has a corner.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from planter.engine.measures import Limit, Measure
from planter.engine.response import Sampled, Samples
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.numerics.statistics import SMOOTH, Statistic
from planter.optimise.constraints import Constraints, Named

SPLIT = {"max": (1,), "min": (-1,), "range": (1, -1)}
"""Sides on which a measure needs a variable: +1 for the largest value, -1 for the least."""


@dataclass(frozen=True)
class Term:
    """A smooth measure of one output: its value, its slope in each sample (n,), how its slopes curve it."""

    value: float
    weights: Array
    extra: Array


def smooth(measure: Measure, values: Array, slopes: Array, sample: int) -> Term:
    """A measure without corners of samples (n,) with slopes (n, p); `sample` is that of its angle, if it has one."""
    count, size = slopes.shape
    if measure.kind in SMOOTH:
        statistic = Statistic(next(kind for kind in SMOOTH if kind == measure.kind), values)
        return Term(statistic.value, statistic.slope, statistic.curvature(slopes))
    weights = np.zeros(count)
    weights[sample] = 1.0
    return Term(float(values[sample]), weights, np.zeros((size, size)))


@dataclass
class Rows:
    """Rows factor (F_output at sample) + share t - level: indices and factors, each (r,), and their bounds in steps."""

    output: list[int] = field(default_factory=list)
    sample: list[int] = field(default_factory=list)
    factor: list[float] = field(default_factory=list)
    variable: list[int] = field(default_factory=list)
    share: list[float] = field(default_factory=list)
    lower: list[float] = field(default_factory=list)
    upper: list[float] = field(default_factory=list)
    owner: list[int] = field(default_factory=list)

    def add(self, output: int, samples: Sequence[int], factor: float, t: tuple[int, float], bounds: tuple[float, float],
            owner: int) -> None:  # fmt: skip
        count = len(samples)
        self.output += [output] * count
        self.sample += list(samples)
        self.factor += [factor] * count
        self.variable += [t[0]] * count
        self.share += [t[1]] * count
        self.lower += [bounds[0]] * count
        self.upper += [bounds[1]] * count
        self.owner += [owner] * count


class Goal:
    """A sum of measures to be made small under limits, over samples of a turn. Variables are (p + q,)."""

    def __init__(
        self, samples: Samples, names: Sequence[str], least: Sequence[Measure], holds: Sequence[Limit]
    ) -> None:
        self.samples, self.names, self.least, self.holds = samples, tuple(names), tuple(least), tuple(holds)
        self._index = {name: k for k, name in enumerate(names)}
        self.size = len(samples.design)
        self.variables = [(m, side) for m in self.least for side in SPLIT.get(m.kind, ())]
        self.variables += [(h.measure, 1) for h in self.holds if h.measure.kind == "range"]
        first = samples(samples.design)
        self.unit = np.array([self._spread(first, m) for m, _ in self.variables])
        self.rows = self._rows(first)

    def start(self, x: Array) -> Array:
        """A point with the variables as tight as they can be at a design x (p,)."""
        found = self.samples(x)
        return np.concatenate([x, [self._extreme(found, m, side) for m, side in self.variables]])

    def value(self, y: Array) -> float:
        found = self._at(y)
        return float(self._linear @ y[self.size :]) + sum(m.weight * t.value for m, t in self._terms(found))

    def gradient(self, y: Array) -> Array:
        found = self._at(y)
        total = np.zeros(self.size)
        for measure, term in self._terms(found):
            total += measure.weight * found.slopes[self.output(measure)].T @ term.weights
        return np.concatenate([total, self._linear])

    def hessian(self, y: Array) -> Array:
        found = self._at(y)
        weights, extra = np.zeros(found.values.shape), np.zeros((self.size, self.size))
        for measure, term in self._terms(found):
            weights[self.output(measure)] += measure.weight * term.weights
            extra += measure.weight * term.extra
        return self.padded(extra + found.curvature(weights))

    def true(self, x: Array) -> float:
        """The sum of the measures at a design, its variables as tight as they can be."""
        return self.value(self.start(x))

    def met(self, x: Array, hold: Limit) -> float:
        """What a limit holds at a design, in its shown unit: the largest or least value, or the measure."""
        found, measure = self.samples(x), hold.measure
        values = self._sized(found, measure)
        if measure.kind == "range":
            return float(np.ptp(values))
        if measure.kind in ("all", "max", "min"):
            return float(values.max() if hold.sign > 0 else values.min())
        return self.term(found, measure).value

    def padded(self, square: Array) -> Array:
        """A Hessian in the design as one in all variables."""
        count = self.size + len(self.variables)
        whole = np.zeros((count, count))
        whole[: self.size, : self.size] = square
        return whole

    def _at(self, y: Array) -> Sampled:
        return self.samples(y[: self.size])

    def _terms(self, found: Sampled) -> list[tuple[Measure, Term]]:
        return [(m, self.term(found, m)) for m in self.least if m.kind not in SPLIT]

    def term(self, found: Sampled, measure: Measure) -> Term:
        """A smooth measure at a design."""
        output = self.output(measure)
        return smooth(measure, found.values[output], found.slopes[output], self._sample(measure))

    def _sample(self, measure: Measure) -> int:
        angle = np.radians((measure.angle or 0.0) % 360)
        return int(np.argmin(np.abs(self.samples.angles - angle)))

    def output(self, measure: Measure) -> int:
        """The index of what a measure is of."""
        return self._index[measure.name]

    def _sized(self, found: Sampled, measure: Measure) -> Array:
        values: Array = found.values[self.output(measure)]
        return np.abs(values) if measure.size else values

    def _extreme(self, found: Sampled, measure: Measure, side: int) -> float:
        values = self._sized(found, measure)
        return float(values.max() if side > 0 else values.min())

    def _spread(self, found: Sampled, measure: Measure) -> float:
        values = self._sized(found, measure)
        return float(np.ptp(values)) or float(np.abs(values).max()) or 1.0

    @property
    def _linear(self) -> Array:
        """Weights of the variables in the objective, (q,)."""
        own = [side * m.weight for m in self.least for side in SPLIT.get(m.kind, ())]
        return np.array([*own, *[0.0] * (len(self.variables) - len(own))])

    def _rows(self, first: Sampled) -> Rows:
        rows, every = Rows(), range(len(self.samples.angles))
        for t, (measure, side) in enumerate(self.variables):
            for sign in (1, -1) if measure.size else (side,):
                bound = (-np.inf, 0.0) if measure.size or side > 0 else (0.0, np.inf)
                factor = (sign if measure.size else 1) / self.unit[t]
                rows.add(self.output(measure), every, factor, (t, -1 / self.unit[t]), bound, len(self.holds))
        spare = iter(
            range(len(self.variables) - sum(h.measure.kind == "range" for h in self.holds), len(self.variables))
        )
        for owner, hold in enumerate(self.holds):
            self._limit(rows, hold, owner, self.step(hold, first), spare)
        return rows

    def step(self, hold: Limit, first: Sampled | None = None) -> float:
        """What counts as one in the violation of a limit: the limit, or the spread of what it holds."""
        found = self.samples(self.samples.design) if first is None else first
        return abs(hold.limit) or self._spread(found, hold.measure)

    def _limit(self, rows: Rows, hold: Limit, owner: int, step: float, spare: Iterator[int]) -> None:
        measure, level, every = hold.measure, hold.limit / step, range(len(self.samples.angles))
        bounds = (-level if measure.size else -np.inf, level) if hold.sign > 0 else (level, np.inf)
        output = self.output(measure)
        if measure.kind == "range":
            rows.add(output, every, 1 / step, (next(spare), -1 / step), (-level, np.inf), owner)
        elif measure.kind == "at":
            rows.add(output, [self._sample(measure)], 1 / step, (0, 0.0), bounds, owner)
        elif measure.kind in ("all", "max", "min"):
            rows.add(output, every, 1 / step, (0, 0.0), bounds, owner)


class Limits(Constraints):
    """The rows of a goal: samples below its variables and within limits, then limits on means and the like."""

    def __init__(self, goal: Goal) -> None:
        self.goal, rows = goal, goal.rows
        self._output, self._sample = np.array(rows.output, dtype=int), np.array(rows.sample, dtype=int)
        self._factor, self._share = np.array(rows.factor), np.array(rows.share)
        self._variable = goal.size + np.array(rows.variable, dtype=int)
        self._means = [(k, h) for k, h in enumerate(goal.holds) if h.measure.kind in SMOOTH]
        self._steps = np.array([goal.step(h) for _, h in self._means])
        limits = np.array([h.limit / goal.step(h) for _, h in self._means])
        under = np.array([h.sign > 0 for _, h in self._means], dtype=bool)
        self.lower = np.concatenate([rows.lower, np.where(under, -np.inf, limits)])
        self.upper = np.concatenate([rows.upper, np.where(under, limits, np.inf)])
        self.owner: Integers = np.array([*rows.owner, *(k for k, _ in self._means)], dtype=np.int64)
        self.kinds = [*(_named(goal, hold) for hold in goal.holds), Named("extremes")]

    def values(self, y: Array) -> Array:
        found, rows = self._at(y), self._factor * 0
        if len(rows):
            rows = self._factor * found.values[self._output, self._sample]
            rows = rows + self._share * np.append(y, 0.0)[self._variable]
        means = [self.goal.term(found, h.measure).value for _, h in self._means]
        return np.concatenate([rows, np.array(means) / self._steps])

    def slopes(self, y: Array) -> Array:
        found, size = self._at(y), self.goal.size
        whole = np.zeros((self.count, len(y)))
        count = len(self._factor)
        whole[:count, :size] = self._factor[:, None] * found.slopes[self._output, self._sample]
        moving = np.flatnonzero(self._share)
        whole[moving, self._variable[moving]] = self._share[moving]
        for row, (_, hold) in enumerate(self._means):
            term = self.goal.term(found, hold.measure)
            gradient = found.slopes[self.goal.output(hold.measure)].T @ term.weights
            whole[count + row, :size] = gradient / self._steps[row]
        return whole

    def curvature(self, y: Array, weights: Array) -> Array:
        found, count = self._at(y), len(self._factor)
        each = np.zeros(found.values.shape)
        np.add.at(each, (self._output, self._sample), weights[:count] * self._factor)
        extra = np.zeros((self.goal.size, self.goal.size))
        for row, (_, hold) in enumerate(self._means):
            term, weight = self.goal.term(found, hold.measure), weights[count + row] / self._steps[row]
            each[self.goal.output(hold.measure)] += weight * term.weights
            extra += weight * term.extra
        return self.goal.padded(extra + found.curvature(each))

    def _at(self, y: Array) -> Sampled:
        return self.goal.samples(y[: self.goal.size])


def _named(goal: Goal, hold: Limit) -> Named:
    return Named(str(hold), ("max" if hold.sign > 0 else "min",), "1", goal.step(hold))
