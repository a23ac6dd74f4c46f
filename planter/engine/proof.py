"""A sum of measures of a machine over a cycle, or over samples of it, bounded over boxes of designs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from planter.engine.goal import SIDES
from planter.engine.machine import Machine
from planter.engine.measures import Kind, Limit, Measure
from planter.errors import InputError
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.proof.enclosures import (
    PI,
    EnclosedResponse,
    Maximum,
    ObjectiveBounds,
    bound_objective,
    enclose_moving,
    enclose_square,
    enclose_turns,
    list_angles,
    list_samples,
)
from planter.optimise.proof.intervals import Ball, Unbounded, intersect_balls
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space, join_lanes, join_parts
from planter.optimise.proof.panels import AnglePanels, MovingKinks

NONNEGATIVE = ("range", "variance", "std", "rms")
"""Measures that are never below zero, of whatever quantity."""

MOST_LANES = 768
"""Lanes of boxes and angles above which it saves no more time to bound several boxes at once."""

PANELS, PANELS_AT_POINT = 480, 2880
"""Least number of panels of a period over a box, and at a single design."""
PEAKS = 3
"""Angles at which the greatest value of a quantity is bounded from below."""
WIDE_CENTRE = 0.2
"""Share of the looseness of a smooth part that its value at the centre may have."""

Extreme = tuple[str, bool, int]
"""A quantity by name, or its size, and the side on which it is extreme, +1 or -1."""
FindKinks = Callable[[Array], MovingKinks]
"""Gives the kinks of quantities within their period at a design (p,)."""
Enclose = Callable[[Sequence[tuple[str, bool]]], EnclosedResponse]
"""Gives enclosures of quantities by name, or of their sizes."""


class ProvableObjective:
    """A sum of measures of a cycle, in display units, bounded over boxes [lower, upper] (p,).

    Extremes, means and works are those of `count` samples, or, if it is None, true extremes and integrals, for which
    `find_kinks` gives the angles in a period at which quantities have kinks; bounds hold whatever it gives.
    `batch` is the number of boxes that are best bounded at once.

    Designs count that satisfy the limits; a box in which one is certainly violated has no bound but infinity. Limits at
    angles that move are not heeded, which leaves bounds true. Angles at which quantities cannot be enclosed are left
    out: no greatest value, no least one made large, and no mean of squares is less than what the others make of it.
    """

    def __init__(
        self, machine: Machine, terms: Sequence[Measure], count: int | None, enclose: Enclose,
        limits: Sequence[Limit] = (), find_kinks: FindKinks | None = None,
    ) -> None:  # fmt: skip
        self.machine, self.terms, self.count = machine, tuple(terms), count
        self.limits = tuple(_resolve(limit) for limit in limits if is_fixed(machine, limit.measure))
        self.heeds_all = len(self.limits) == len(limits)
        measures = (*self.terms, *(limit.measure for limit in self.limits))
        self._quantities = list(dict.fromkeys((measure.name, measure.size) for measure in measures))
        self._extremes = list(dict.fromkeys(
            (measure.name, measure.size, side)
            for measure in measures if measure.kind in SIDES for side in SIDES[measure.kind]
        ))  # fmt: skip
        self._angles = list(dict.fromkeys(measure.angle for measure in measures if measure.angle is not None))
        self._fixed = [Fraction(angle % 360) / 360 for angle in self._angles]
        self._enclosed, self._find_kinks = enclose(self._quantities), find_kinks
        self._turns = [] if count is None else [*list_samples(self._enclosed, count), *self._fixed]
        many = self._turns and len(self._enclosed.offsets) == 1
        self.batch = max(1, MOST_LANES // len(self._turns)) if many else 1

    def __call__(self, lower: Array, upper: Array) -> ObjectiveBounds:
        """Return the bounds over a box. Raises Unbounded without bounds."""
        (result,) = self.bound_boxes([(lower, upper)])
        if isinstance(result, Unbounded):
            raise result
        return result

    def bound_boxes(self, boxes: Sequence[tuple[Array, Array]]) -> list[ObjectiveBounds | Unbounded]:
        """Return the bounds over each of some boxes, or the reason why it is unbounded."""
        batches = [boxes[k : k + self.batch] for k in range(0, len(boxes), self.batch)]
        with np.errstate(all="ignore"):
            return [result for batch in batches for result in self._bound_batch(batch)]

    def _bound_batch(self, boxes: Sequence[tuple[Array, Array]]) -> list[ObjectiveBounds | Unbounded]:
        try:
            cycles = [self._enclose_panels(*boxes[0])] if self.count is None else self._enclose_samples(boxes)
        except Unbounded as error:
            return [error] if len(boxes) == 1 else [result for box in boxes for result in self._bound_batch([box])]
        return [self._bound_cycle(*pair) for pair in zip(boxes, cycles, strict=True)]

    def _enclose_samples(self, boxes: Sequence[tuple[Array, Array]]) -> list[EnclosedCycle]:
        """Return the samples of cycles over boxes, each of which takes as many lanes as there are angles."""
        count = len(self._turns)
        ends = [np.repeat(np.array(side).T, count, axis=1) for side in zip(*boxes, strict=True)]
        space = Space(*(ends if len(boxes) > 1 else boxes[0]))
        jets = enclose_turns(self._enclosed, space, self._turns * len(boxes))
        cycles = []
        for k, box in enumerate(boxes):
            lanes, designs = slice(k * count, (k + 1) * count), Space(*box)
            designs.jumping = space.jumping[lanes]
            taken = self._convert([replace(jet.taken(lanes), space=designs) for jet in jets])
            samples = count - len(self._angles)
            shares = (designs.integer(1) / samples).repeated(samples)
            cycles.append(EnclosedCycle(self.machine, designs, taken, shares, self._angles, list_angles(self._turns)))
        return cycles

    def _enclose_panels(self, lower: Array, upper: Array) -> EnclosedCycle:
        """Return a cycle over a box in panels of angles, and a few angles at which each extreme nearly is."""
        assert self._find_kinks is not None
        designs, count = Space(lower, upper), PANELS if (upper > lower).any() else PANELS_AT_POINT
        kinks, fixed = self._find_kinks(designs.centre), list_angles(self._fixed)
        panels = AnglePanels.build(kinks, designs.half[:, 0], list_angles([self._enclosed.period]), count)
        space = Space(np.append(lower, -1.0), np.append(upper, 1.0))
        phi, shares = panels.angles(space)
        lanes = join_lanes([phi, space.constant(fixed)]) if self._fixed else phi
        jets = self._convert(enclose_moving(self._enclosed, space, lanes))
        points = self._enclose_peaks(
            designs, panels, {key: jet.taken(slice(0, phi.lanes)) for key, jet in jets.items()}
        )
        designs.jumping = space.jumping
        angles = Ball.exact(np.append(panels.places, fixed.mid))
        return EnclosedCycle(self.machine, designs, jets, shares, self._angles, angles, points)

    def _enclose_peaks(
        self, space: Space, panels: AnglePanels, jets: Mapping[tuple[str, bool], Jet]
    ) -> dict[Extreme, Jet]:
        """Return quantities, minus those whose least value is asked for, at angles where they nearly are extreme."""
        if not self._extremes:
            return {}
        signed = {(name, size, side): side * jets[name, size] for name, size, side in self._extremes}
        peaks = [panels.find_peaks(jet, len(space.lower), PEAKS) for jet in signed.values()]
        angles = space.linear(*(np.concatenate(part) for part in zip(*peaks, strict=True)))
        values = self._convert(enclose_moving(self._enclosed, space, angles))
        return {
            (name, size, side): side * values[name, size].taken(slice(k * PEAKS, (k + 1) * PEAKS))
            for k, (name, size, side) in enumerate(self._extremes)
        }

    def _bound_cycle(self, box: tuple[Array, Array], cycle: EnclosedCycle) -> ObjectiveBounds | Unbounded:
        """Return the bounds over a box from a cycle there, angles without bounds left out."""
        try:
            if not cycle.is_whole and self._enclosed.is_empty(*box, cycle.phi):
                return _exclude(cycle.space)
            if not len(cycle.places):
                raise Unbounded("a quantity may have no bound at any angle")
            return self._bound(cycle)
        except Unbounded as error:
            return error

    def _bound(self, cycle: EnclosedCycle) -> ObjectiveBounds:
        if any(_is_violated(limit, cycle.find_span(limit.measure, ANYWHERE)) for limit in self.limits):
            return _exclude(cycle.space)
        terms = [cycle.bound_term(measure) for measure in self.terms]
        extremes = [extreme for term in terms for extreme in term.extremes]
        result = bound_objective(self._narrow(cycle.space, _add_smooth(cycle.space, terms)), extremes)
        if not (np.isfinite(result.lower_bound) and np.isfinite(result.looseness).all()):
            raise Unbounded("a bound is not finite")
        is_whole = all(term.is_whole for term in terms)
        is_free = all(_is_satisfied(limit, cycle.find_span(limit.measure, ANYWHERE)) for limit in self.limits)
        is_met = all(_is_satisfied(limit, cycle.find_span(limit.measure, CENTRE)) for limit in self.limits)
        return replace(
            result,
            reached=result.reached if is_whole and is_met and self.heeds_all else np.inf,
            may_jump=result.may_jump or not is_whole or not is_free,  # no side of the box may stand for it
        )

    def _narrow(self, space: Space, smooth: Jet) -> Jet:
        """Return a smooth part whose value at the centre, if panels leave it too open, is that of more panels."""
        centre = smooth.value[CENTRE]
        room = WIDE_CENTRE * (centre.mid - smooth.lower_bound)
        if self.count is not None or not space.half.any() or not (centre.rad > room).all():
            return smooth
        cycle = self._enclose_panels(space.centre, space.centre)
        narrow = _add_smooth(cycle.space, [cycle.bound_term(measure) for measure in self.terms]).value[CENTRE]
        return smooth.holding(join_parts(intersect_balls(centre, narrow), smooth.value[ANYWHERE])).cut()

    @property
    def floor(self) -> float:
        """The largest known number below all objectives."""
        return 0.0 if all(map(_is_nonnegative, self.terms)) else -np.inf

    def _convert(self, jets: Sequence[Jet]) -> dict[tuple[str, bool], Jet]:
        """Return quantities in display units."""
        factors = [self.machine.find_quantity(name).factor for name, _ in self._quantities]
        converted = [jet if factor == 1 else jet / factor for jet, factor in zip(jets, factors, strict=True)]
        return dict(zip(self._quantities, converted, strict=True))


@dataclass(frozen=True)
class BoundedTerm:
    """A lower bound of a measure: a smooth part (one lane), if any, and greatest values; exact if it `is_whole`."""

    smooth: Jet | None
    extremes: tuple[Maximum, ...]
    is_whole: bool


@dataclass(frozen=True)
class EnclosedCycle:
    """Quantities, or their sizes, over a box, at samples or anywhere in panels of a cycle, in display units.

    Lanes of `jets` are those of the cycle, whose `shares` in it add up to one, then those of `angles` [deg].
    In panels, jets have a place after the parameters of the box, and `points` are values that extremes are not below.
    `phi` are angles of the lanes [rad].
    """

    machine: Machine
    space: Space
    jets: Mapping[tuple[str, bool], Jet]
    shares: Jet
    angles: Sequence[float]
    phi: Ball
    points: Mapping[Extreme, Jet] = field(default_factory=dict)

    @cached_property
    def places(self) -> Integers:
        """The lanes in which all quantities have bounds."""
        lanes: Integers = np.flatnonzero(np.all([jet.is_bounded for jet in self.jets.values()], axis=0))
        self.space.jumping = self.space.jumping[lanes]
        return lanes

    @property
    def is_whole(self) -> bool:
        """Whether all lanes have bounds."""
        return len(self.places) == self.shares.lanes + len(self.angles)

    def bound_term(self, measure: Measure) -> BoundedTerm:
        """Return a weighted measure, or what it is not below. Raises Unbounded for one that needs all angles."""
        lanes, is_whole = self._find_lanes(measure)
        if not is_whole and not _is_nonnegative(measure) and measure.kind not in SIDES:
            raise Unbounded(f"{measure} cannot be enclosed at every angle")
        if not len(lanes):
            return BoundedTerm(None, (), False)
        if measure.kind in SIDES:
            weight = abs(measure.weight)
            return BoundedTerm(
                None, tuple(self._find_maximum(measure, side, weight) for side in SIDES[measure.kind]), is_whole
            )
        try:
            return BoundedTerm(self._average(measure) * measure.weight, (), is_whole)
        except Unbounded:
            if not _is_nonnegative(measure):
                raise
            return BoundedTerm(None, (), False)

    def find_span(self, measure: Measure, part: int) -> tuple[float, float]:
        """Return between which values a measure is, anywhere in the box or at its centre."""
        lanes, is_whole = self._find_lanes(measure)
        if not len(lanes):
            return -np.inf, np.inf
        if measure.kind in SIDES:
            spans = [self._find_maximum(measure, side).find_span(part) for side in SIDES[measure.kind]]
            low, high = spans[0] if len(spans) == 1 else _add_down(*spans)
            high = high if is_whole else np.inf
            return (-high, -low) if measure.kind == "min" else (low, high)
        try:
            value = self._average(measure).value[part]
        except Unbounded:
            return -np.inf, np.inf
        if is_whole:
            return float(value.low[0]), float(value.high[0])
        return (float(value.low[0]) if measure.kind in NONNEGATIVE else -np.inf), np.inf

    def _find_lanes(self, measure: Measure) -> tuple[Integers, bool]:
        """Return the lanes of the angles that a measure takes, and whether they are all."""
        count = self.shares.lanes
        if measure.angle is None:
            lanes = self.places[self.places < count]
            return lanes, len(lanes) == count
        lanes = self.places[self.places == count + self.angles.index(measure.angle)]
        return lanes, len(lanes) == 1

    def _find_maximum(self, measure: Measure, side: int, weight: float = 1.0) -> Maximum:
        """Return the greatest value of a quantity, or of minus it, times a positive weight."""
        lanes, _ = self._find_lanes(measure)
        curve = self.jets[measure.name, measure.size].taken(lanes).hull(len(self.space.lower))
        panels = replace(curve, space=self.space) * (side * weight)
        points = self.points.get((measure.name, measure.size, side))
        if points is None or not points.is_bounded.any():
            return Maximum(panels, panels)
        return Maximum(points.taken(points.is_bounded) * weight, panels)

    def _average(self, measure: Measure) -> Jet:
        """Return a measure without corners; of squares, those that are missing count as zero."""
        lanes, is_whole = self._find_lanes(measure)
        jet = self.jets[measure.name, measure.size].taken(lanes)
        if measure.kind == "at":
            return replace(jet, space=self.space)
        shares = self.shares.taken(lanes)
        if measure.kind in ("mean", "work"):
            mean = replace(self._mean(jet, shares), space=self.space)
            return mean if measure.kind == "mean" else mean * self._length(measure)
        if measure.kind != "rms":
            mean = self._mean(jet, shares)
            jet = jet - (mean if is_whole else mean / shares.sum())
        square = replace(self._mean(enclose_square(jet), shares), space=self.space)
        return square if measure.kind == "variance" else square.sqrt()

    def _mean(self, jet: Jet, shares: Jet) -> Jet:
        return (jet.average(len(self.space.lower)) * shares).sum()

    def _length(self, measure: Measure) -> Jet:
        """Return how long a cycle is for the work of a quantity, in time or in angle."""
        space, index = self.space, self.machine.speed
        turn = space.constant(PI * Ball.exact([2.0]))
        if self.machine.find_quantity(measure.name).unit == "N m":
            return turn
        if index in self.machine.moved:
            speed = space.parameters()[self.machine.moved.index(index)]
            return turn / speed if space.centre[self.machine.moved.index(index)] > 0 else turn / -speed
        return turn / abs(float(self.machine.data[index]))


def _add_smooth(space: Space, terms: Sequence[BoundedTerm]) -> Jet:
    """Return the sum of the smooth parts of terms."""
    return sum((term.smooth for term in terms if term.smooth is not None), space.integer(0))


def _add_down(*spans: tuple[float, float]) -> tuple[float, float]:
    """Return between which values a sum is, from spans of two numbers."""
    total = Ball.exact(spans[0]) + Ball.exact(spans[1])
    return float(total.low[0]), float(total.high[1])


def _exclude(space: Space) -> ObjectiveBounds:
    """Return the bounds over a box in which no design counts."""
    nothing = np.zeros(len(space.lower))
    return ObjectiveBounds(np.inf, np.inf, Ball(nothing, nothing), nothing, may_jump=True)


def is_fixed(machine: Machine, measure: Measure) -> bool:
    """Return whether a measure is of a result at angles that do not move with the design."""
    return not measure.is_moving and machine.find_quantity(measure.name).role == "result"


def _is_nonnegative(measure: Measure) -> bool:
    """Return whether a term of a sum is nowhere below zero."""
    is_size = measure.kind in NONNEGATIVE or (measure.size and measure.kind in ("max", "at"))
    return is_size and measure.weight >= 0


def _resolve(limit: Limit) -> Limit:
    """Return a limit on a quantity everywhere as that on its greatest or least value."""
    kind: Kind = "max" if limit.sign > 0 else "min"
    return replace(limit, measure=replace(limit.measure, kind=kind)) if limit.measure.kind == "all" else limit


def _is_violated(limit: Limit, span: tuple[float, float]) -> bool:
    """Return whether no design of a box satisfies a limit, from the span of what it is on."""
    return span[0] > limit.number if limit.sign > 0 else span[1] < limit.number


def _is_satisfied(limit: Limit, span: tuple[float, float]) -> bool:
    return span[1] <= limit.number if limit.sign > 0 else span[0] >= limit.number


def check_provable(machine: Machine, terms: Sequence[Measure], label: str) -> None:
    """Raise InputError, which begins with `label`, for a sum of which no proof is known."""
    for measure in terms:
        if measure.is_moving:
            word = "jump" if measure.kind == "jump" else "while" if measure.during else "where"
            raise InputError(f"{label}: {measure}: a proof takes angles that are fixed, so leave out `{word}`")
        quantity = machine.find_quantity(measure.name)
        if quantity.role != "result":
            raise InputError(f"{label}: {measure}: a proof bounds results, and {quantity.name} is a {quantity.role}")
    if not machine.moved:
        raise InputError(f"{label}: {machine.source}: it has no [bounds], so there is no box to prove anything of")
