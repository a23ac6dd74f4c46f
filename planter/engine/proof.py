"""A sum of measures of a machine over samples of a cycle, bounded over boxes of designs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from planter.engine.goal import SHARES, SIDES
from planter.engine.machine import Machine
from planter.engine.measures import Kind, Limit, Measure
from planter.errors import InputError
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers
from planter.optimise.proof.enclosures import (
    PI,
    EnclosedResponse,
    ExtremumTerm,
    ObjectiveBounds,
    bound_objective,
    enclose_at,
    enclose_mean_square,
    enclose_variance,
    list_angles,
    list_samples,
)
from planter.optimise.proof.intervals import Ball, Unbounded
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space

NONNEGATIVE = ("range", "variance", "std", "rms")
"""Measures that are never below zero, of whatever quantity."""

MOST_LANES = 768
"""Lanes of boxes and angles above which it saves no more time to bound several boxes at once."""

Enclose = Callable[[Sequence[tuple[str, bool]]], EnclosedResponse]
"""Gives enclosures of quantities by name, or of their sizes."""


class ProvableObjective:
    """A sum of measures over samples of a cycle, in display units, bounded over boxes [lower, upper] (p,).

    `count` is the number of samples that differ, and `batch` that of boxes which are best bounded at once.

    Designs count that satisfy the limits; a box in which one is certainly violated has no bound but infinity. Limits at
    angles that move are not heeded, which leaves bounds true. Angles at which quantities cannot be enclosed are left
    out: no greatest value, no least one made large, and no mean of squares is less than what the others make of it.
    """

    def __init__(
        self, machine: Machine, terms: Sequence[Measure], count: int, enclose: Enclose, limits: Sequence[Limit] = ()
    ) -> None:
        self.machine, self.terms = machine, tuple(terms)
        self.limits = tuple(_resolve(limit) for limit in limits if is_fixed(machine, limit.measure))
        self.heeds_all = len(self.limits) == len(limits)
        measures = (*self.terms, *(limit.measure for limit in self.limits))
        self._quantities = list(dict.fromkeys((measure.name, measure.size) for measure in measures))
        self._angles = list(dict.fromkeys(measure.angle for measure in measures if measure.angle is not None))
        self._enclosed = enclose(self._quantities)
        cycle = list_samples(self._enclosed, count)
        self.count = len(cycle)
        self._turns = [*cycle, *(Fraction(angle % 360) / 360 for angle in self._angles)]
        self.batch = max(1, MOST_LANES // len(self._turns)) if len(self._enclosed.offsets) == 1 else 1

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
        """Return the bounds over boxes, each of which takes as many lanes as there are angles."""
        count = len(self._turns)
        ends = [np.repeat(np.array(side).T, count, axis=1) for side in zip(*boxes, strict=True)]
        space = Space(*(ends if len(boxes) > 1 else boxes[0]))
        try:
            jets = enclose_at(self._enclosed, space, self._turns * len(boxes))
        except Unbounded as error:
            return [error] if len(boxes) == 1 else [result for box in boxes for result in self._bound_batch([box])]
        return [
            self._bound_lanes(box, jets, space.jumping, slice(k * count, (k + 1) * count))
            for k, box in enumerate(boxes)
        ]

    def _bound_lanes(
        self, box: tuple[Array, Array], jets: Sequence[Jet], jumping: Flags, lanes: slice
    ) -> ObjectiveBounds | Unbounded:
        """Return the bounds over a box from some lanes of jets, those without bounds left out."""
        space = Space(*box)
        jets = [replace(jet.taken(lanes), space=space) for jet in jets]
        places = np.flatnonzero(np.all([jet.is_bounded for jet in jets], axis=0))
        space.jumping = jumping[lanes][places]
        jets = [jet.taken(places) for jet in jets]
        try:
            if len(places) < len(self._turns) and self._enclosed.is_empty(*box, list_angles(self._turns)):
                return _exclude(space)
            if not len(places):
                raise Unbounded("a quantity may have no bound at any angle")
            return self._bound(
                space, EnclosedSamples(self.machine, self.count, self._angles, places, self._convert(jets), space)
            )
        except Unbounded as error:
            return error

    def _bound(self, space: Space, samples: EnclosedSamples) -> ObjectiveBounds:
        if any(_is_violated(limit, samples.find_span(limit.measure, ANYWHERE)) for limit in self.limits):
            return _exclude(space)
        terms = [samples.bound_term(measure) for measure in self.terms]
        smooth = [term.smooth for term in terms if term.smooth is not None]
        extremes = [extreme for term in terms for extreme in term.extremes]
        result = bound_objective(sum(smooth[1:], smooth[0]) if smooth else space.integer(0), extremes)
        if not (np.isfinite(result.lower_bound) and np.isfinite(result.looseness).all()):
            raise Unbounded("a bound is not finite")
        is_whole = all(term.is_whole for term in terms)
        is_free = all(_is_satisfied(limit, samples.find_span(limit.measure, ANYWHERE)) for limit in self.limits)
        is_met = all(_is_satisfied(limit, samples.find_span(limit.measure, CENTRE)) for limit in self.limits)
        return replace(
            result,
            reached=result.reached if is_whole and is_met and self.heeds_all else np.inf,
            may_jump=result.may_jump or not is_whole or not is_free,  # no side of the box may stand for it
        )

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
    """A lower bound of a measure: a smooth part (one lane), if any, and extremes; it is exact if it `is_whole`."""

    smooth: Jet | None
    extremes: tuple[ExtremumTerm, ...]
    is_whole: bool


@dataclass(frozen=True)
class EnclosedSamples:
    """Quantities, or their sizes, over a box at those angles that could be enclosed, in display units.

    `places` are the places of the lanes among all angles: `count` samples of the cycle, then `angles` [deg].
    """

    machine: Machine
    count: int
    angles: Sequence[float]
    places: Integers
    jets: Mapping[tuple[str, bool], Jet]
    space: Space

    def bound_term(self, measure: Measure) -> BoundedTerm:
        """Return a weighted measure, or what it is not below. Raises Unbounded for one that needs all angles."""
        lanes, is_whole = self._find_lanes(measure)
        if not is_whole and not _is_nonnegative(measure) and measure.kind not in SIDES:
            raise Unbounded(f"{measure} cannot be enclosed at every angle")
        if not len(lanes):
            return BoundedTerm(None, (), False)
        jet = self.jets[measure.name, measure.size].taken(lanes)
        if measure.kind in SIDES:  # minus a least value is the greatest of minus the values
            ends = tuple(ExtremumTerm(jet * (share * measure.weight)) for share in SHARES[measure.kind])
            return BoundedTerm(None, ends, is_whole)
        try:
            return BoundedTerm(self._average(measure, jet) * measure.weight, (), is_whole)
        except Unbounded:
            if not _is_nonnegative(measure):
                raise
            return BoundedTerm(None, (), False)

    def find_span(self, measure: Measure, part: int) -> tuple[float, float]:
        """Return between which values a measure is, anywhere in the box or at its centre."""
        lanes, is_whole = self._find_lanes(measure)
        if not len(lanes):
            return -np.inf, np.inf
        jet = self.jets[measure.name, measure.size].taken(lanes)
        if measure.kind in SIDES:
            low, high = jet.value[part].low, jet.value[part].high
            minimum = float(low.min()) if is_whole else -np.inf, float(high.min())
            maximum = float(low.max()), float(high.max()) if is_whole else np.inf
            if measure.kind == "range":
                extent = Ball.exact(maximum) - Ball.exact(minimum[::-1])
                return float(extent.low[0]), float(extent.high[1])
            return maximum if measure.kind == "max" else minimum
        try:
            value = self._average(measure, jet).value[part]
        except Unbounded:
            return -np.inf, np.inf
        if is_whole:
            return float(value.low[0]), float(value.high[0])
        return (float(value.low[0]) if measure.kind in NONNEGATIVE else -np.inf), np.inf

    def _find_lanes(self, measure: Measure) -> tuple[Integers, bool]:
        """Return the lanes of the angles that a measure takes, and whether they are all."""
        if measure.angle is None:
            lanes = np.flatnonzero(self.places < self.count)
            return lanes, len(lanes) == self.count
        lanes = np.flatnonzero(self.places == self.count + self.angles.index(measure.angle))
        return lanes, len(lanes) == 1

    def _average(self, measure: Measure, jet: Jet) -> Jet:
        """Return a measure without corners; of squares, those that are missing count as zero."""
        if measure.kind == "at":
            return jet
        if measure.kind == "mean":
            return jet.mean()
        if measure.kind == "work":
            return jet.mean() * self._length(measure)
        square = enclose_mean_square(jet) if measure.kind == "rms" else enclose_variance(jet)
        if jet.lanes < self.count:
            square = square * (self.space.integer(jet.lanes) / self.space.integer(self.count))
        return square if measure.kind == "variance" else square.sqrt()

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
