"""An objective over a cycle, or over samples of it, bounded over boxes of designs.

The objective is a sum of measures of the quantities of a response; limits on such measures may
exclude designs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Literal

import numpy as np

from planter.engine.proof.enclosures import (
    EnclosedResponse,
    Evidence,
    Maximum,
    ObjectiveBounds,
    bound_objective,
    enclose_moving,
    enclose_square,
    enclose_turns,
    list_angles,
    list_samples,
)
from planter.engine.proof.intervals import Ball, Unbounded, intersect_balls
from planter.engine.proof.jets import ANYWHERE, CENTRE, Jet, Space, join_lanes, join_parts
from planter.engine.proof.panels import AnglePanels, MovingKinks
from planter.kernels import Array, Integers

MeasureKind = Literal["max", "min", "range", "mean", "variance", "std", "rms", "at"]
SIDES: dict[str, tuple[int, ...]] = {"max": (1,), "min": (-1,), "range": (1, -1)}
"""Sides on which a quantity is extreme, for each measure of extremes."""
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

FindKinks = Callable[[Array], MovingKinks]
"""Gives the kinks of quantities within their period at a design (p,)."""


@dataclass(frozen=True)
class BoundedMeasure:
    """A measure of a quantity, by its index, times a weight; the weight of a least value, "min", is
    not positive.

    Of kind "at", it is the value at an `angle` [deg]. Quantities that are sizes are nowhere below
    zero.
    """

    kind: MeasureKind
    quantity: int
    size: bool = False
    weight: float = 1.0
    angle: float | None = None

    @property
    def is_nonnegative(self) -> bool:
        """Whether a term of a sum is nowhere below zero."""
        is_size = self.kind in NONNEGATIVE or (self.size and self.kind in ("max", "at"))
        return is_size and self.weight >= 0


@dataclass(frozen=True)
class BoundedLimit:
    """A measure with its limit: at most it (`sign` +1), or at least."""

    measure: BoundedMeasure
    sign: int
    number: float

    def is_violated(self, span: tuple[float, float]) -> bool:
        """Return whether no design of a box satisfies the limit, from the span of what it is on."""
        return span[0] > self.number if self.sign > 0 else span[1] < self.number

    def is_satisfied(self, span: tuple[float, float]) -> bool:
        """Return whether all designs of a box satisfy the limit, from the span of what it is on."""
        return span[1] <= self.number if self.sign > 0 else span[0] >= self.number


Box = tuple[Array, Array]
"""Designs between two others (p,)."""


class ProvableObjective:
    """A sum of measures of the quantities of a response, bounded over boxes of designs.

    Extremes and means are those of `count` samples, or, if it is None, true extremes and integrals,
    for which `find_kinks` gives the angles in a period at which quantities have kinks; bounds hold
    whatever it gives. `batch` is the number of boxes that are best bounded at once.

    Designs count that satisfy the limits, which are all there are if it `heeds_all`; a box in which
    one is certainly violated has no bound but infinity. Angles at which quantities cannot be
    enclosed are left out: no greatest value, no least one made large, and no mean of squares is
    less than what the others make of it. `labels` are names of the quantities, for people.
    """

    def __init__(
        self,
        response: EnclosedResponse,
        terms: Sequence[BoundedMeasure],
        limits: Sequence[BoundedLimit] = (),
        count: int | None = None,
        find_kinks: FindKinks | None = None,
        heeds_all: bool = True,
        labels: Sequence[str] = (),
    ) -> None:
        self.response, self.terms, self.limits = response, tuple(terms), tuple(limits)
        self.count, self.heeds_all, self._find_kinks = count, heeds_all, find_kinks
        self._labels = tuple(labels)
        measures = (*self.terms, *(limit.measure for limit in self.limits))
        self._extremes = list(
            dict.fromkeys(
                (measure.quantity, side)
                for measure in measures
                for side in SIDES.get(measure.kind, ())
            )
        )
        self._angles = list(
            dict.fromkeys(measure.angle for measure in measures if measure.angle is not None)
        )
        self._fixed = [Fraction(angle % 360) / 360 for angle in self._angles]
        program = response.program
        self._turns = [] if count is None else [*list_samples(program, count), *self._fixed]
        many = self._turns and len(program.offsets) == 1
        self.batch = max(1, MOST_LANES // len(self._turns)) if many else 1

    def list_labels(self) -> list[str]:
        """Return the names of all quantities, with their units if they are known."""
        count = len(self.response.program.stages[-1].program.outputs)
        return list(self._labels) or [f"result {k}" for k in range(count)]

    def __call__(
        self, lower: Array, upper: Array, evidence: Evidence | None = None
    ) -> ObjectiveBounds:
        """Return the bounds over a box, from choices that are given or made.

        Raises Unbounded without bounds.
        """
        with np.errstate(all="ignore"):
            (result,) = self._bound_batch([(lower, upper)], evidence)
        if isinstance(result, Unbounded):
            raise result
        return result

    def bound_boxes(self, boxes: Sequence[Box]) -> list[ObjectiveBounds | Unbounded]:
        """Return the bounds over each of some boxes, or the reason why it is unbounded."""
        batches = [boxes[k : k + self.batch] for k in range(0, len(boxes), self.batch)]
        with np.errstate(all="ignore"):
            return [result for batch in batches for result in self._bound_batch(batch)]

    def _bound_batch(
        self, boxes: Sequence[Box], evidence: Evidence | None = None
    ) -> list[ObjectiveBounds | Unbounded]:
        try:
            if self.count is None:
                cycles = [self._enclose_panels(*boxes[0], evidence)]
            else:
                cycles = self._enclose_samples(boxes, evidence)
        except Unbounded as error:
            return (
                [error]
                if len(boxes) == 1
                else [result for box in boxes for result in self._bound_batch([box])]
            )
        return [self._bound_cycle(*pair) for pair in zip(boxes, cycles, strict=True)]

    def _enclose_samples(
        self, boxes: Sequence[Box], evidence: Evidence | None
    ) -> list[EnclosedCycle]:
        """Return the samples of cycles over boxes, each of which takes as many lanes as there are
        angles.
        """
        count = len(self._turns)
        ends = [np.repeat(np.array(side).T, count, axis=1) for side in zip(*boxes, strict=True)]
        space = Space(*(ends if len(boxes) > 1 else boxes[0]))
        spaces = [Space(*box) for box in boxes]
        starts = (
            [self.response.find_starts(box.centre) for box in spaces]
            if evidence is None
            else [evidence.starts]
        )
        jets = enclose_turns(self.response, space, self._turns * len(boxes), starts)
        cycles = []
        for k, designs in enumerate(spaces):
            lanes = slice(k * count, (k + 1) * count)
            designs.jumping = space.jumping[lanes]
            taken = [replace(jet.taken(lanes), space=designs) for jet in jets]
            samples = count - len(self._angles)
            shares = (designs.integer(1) / samples).repeated(samples)
            cycles.append(
                EnclosedCycle(
                    designs,
                    taken,
                    shares,
                    self._angles,
                    list_angles(self._turns),
                    Evidence(starts[k]),
                )
            )
        return cycles

    def _enclose_panels(
        self, lower: Array, upper: Array, evidence: Evidence | None
    ) -> EnclosedCycle:
        """Return a cycle over a box in panels of angles, and a few angles at which each extreme
        nearly is.
        """
        designs, fixed = Space(lower, upper), list_angles(self._fixed)
        evidence = evidence or self._choose(designs)
        panels = evidence.panels
        if panels is None:
            raise Unbounded("the evidence has no panels of angles")
        space = Space(np.append(lower, -1.0), np.append(upper, 1.0))
        phi, shares = panels.angles(space)
        lanes = join_lanes([phi, space.constant(fixed)]) if self._fixed else phi
        jets = enclose_moving(self.response, space, lanes, [evidence.starts])
        evidence = self._choose_peaks(
            evidence, [jet.taken(slice(0, phi.lanes)) for jet in jets], designs
        )
        points = self._enclose_peaks(designs, evidence)
        designs.jumping = space.jumping
        angles = Ball.exact(np.append(panels.places, fixed.mid))
        return EnclosedCycle(designs, jets, shares, self._angles, angles, evidence, points)

    def _choose(self, designs: Space) -> Evidence:
        """Return where roots are looked for over a box, and its panels."""
        assert self._find_kinks is not None
        period = list_angles([self.response.program.period])
        kinks, count = (
            self._find_kinks(designs.centre),
            PANELS if designs.half.any() else PANELS_AT_POINT,
        )
        panels = AnglePanels.build(kinks, designs.half[:, 0], period, count)
        return Evidence(self.response.find_starts(designs.centre), panels)

    def _choose_peaks(self, evidence: Evidence, jets: Sequence[Jet], designs: Space) -> Evidence:
        """Return evidence with angles near extremes, chosen from quantities in panels if there are
        none yet.
        """
        if evidence.peaks is not None or not self._extremes:
            return evidence
        assert evidence.panels is not None
        size = len(designs.lower)
        peaks = [
            evidence.panels.find_peaks(side * jets[index], size, PEAKS)
            for index, side in self._extremes
        ]
        places, rates = (np.concatenate(part) for part in zip(*peaks, strict=True))
        return replace(evidence, peaks=places, rates=rates)

    def _enclose_peaks(self, space: Space, evidence: Evidence) -> dict[tuple[int, int], Jet]:
        """Return quantities, minus those whose least value is asked for, at angles where they
        nearly are extreme.
        """
        if evidence.peaks is None or evidence.rates is None:
            return {}
        angles = space.linear(evidence.peaks, evidence.rates)
        values, count = (
            enclose_moving(self.response, space, angles, [evidence.starts]),
            angles.lanes,
        )
        share = count // len(self._extremes)
        return {
            (index, side): side
            * values[index].repeated(count).taken(slice(k * share, (k + 1) * share))
            for k, (index, side) in enumerate(self._extremes)
        }

    def _bound_cycle(self, box: Box, cycle: EnclosedCycle) -> ObjectiveBounds | Unbounded:
        """Return the bounds over a box from a cycle there, angles without bounds left out."""
        try:
            if (
                not cycle.is_whole
                and cycle.may_be_empty
                and self.response.is_empty(*box, cycle.phi)
            ):
                return _exclude(cycle)
            if not len(cycle.places):
                raise Unbounded("a quantity may have no bound at any angle")
            return self._bound(cycle)
        except Unbounded as error:
            return error

    def _bound(self, cycle: EnclosedCycle) -> ObjectiveBounds:
        if any(
            limit.is_violated(cycle.find_span(limit.measure, ANYWHERE)) for limit in self.limits
        ):
            return _exclude(cycle)
        terms = [cycle.bound_term(measure) for measure in self.terms]
        extremes = [extreme for term in terms for extreme in term.extremes]
        smooth, evidence = self._narrow(cycle, _add_smooth(cycle.space, terms))
        result = bound_objective(smooth, extremes)
        if not (np.isfinite(result.lower_bound) and np.isfinite(result.looseness).all()):
            raise Unbounded("a bound is not finite")
        is_whole = all(term.is_whole for term in terms)
        is_free = all(
            limit.is_satisfied(cycle.find_span(limit.measure, ANYWHERE)) for limit in self.limits
        )
        is_met = all(
            limit.is_satisfied(cycle.find_span(limit.measure, CENTRE)) for limit in self.limits
        )
        return replace(
            result,
            reached=result.reached if is_whole and is_met and self.heeds_all else np.inf,
            may_jump=result.may_jump
            or not is_whole
            or not is_free,  # no side of the box may stand for it
            evidence=evidence,
        )

    def _narrow(self, cycle: EnclosedCycle, smooth: Jet) -> tuple[Jet, Evidence]:
        """Return a smooth part whose value at the centre, if panels leave it too open, is that of
        more panels.
        """
        space, centre, evidence = cycle.space, smooth.value[CENTRE], cycle.evidence
        room = WIDE_CENTRE * (centre.mid - smooth.lower_bound)
        is_open = self.count is None and space.half.any() and (centre.rad > room).all()
        if not is_open or (
            evidence.narrow is None and self._find_kinks is None
        ):  # a proof that did without it
            return smooth, evidence
        finer = None if evidence.narrow is None else Evidence(evidence.starts, evidence.narrow)
        point = self._enclose_panels(space.centre, space.centre, finer)
        narrow = _add_smooth(
            point.space, [point.bound_term(measure) for measure in self.terms]
        ).value[CENTRE]
        value = join_parts(intersect_balls(centre, narrow), smooth.value[ANYWHERE])
        return smooth.holding(value).cut(), replace(evidence, narrow=point.evidence.panels)

    @property
    def floor(self) -> float:
        """The largest known number below all objectives."""
        return 0.0 if all(term.is_nonnegative for term in self.terms) else -np.inf


@dataclass(frozen=True)
class BoundedTerm:
    """A lower bound of a measure: a smooth part (one lane), if any, and greatest values; exact if
    it `is_whole`.
    """

    smooth: Jet | None
    extremes: tuple[Maximum, ...]
    is_whole: bool


@dataclass(frozen=True)
class EnclosedCycle:
    """Quantities over a box, at samples or anywhere in panels of a cycle.

    Lanes of `jets` are those of the cycle, whose `shares` in it add up to one, then those of
    `angles` [deg]. In panels, jets have a place after the parameters of the box, and `points` are
    values that extremes, by quantity and side, are not below. `phi` are angles of the lanes [rad].
    """

    space: Space
    jets: Sequence[Jet]
    shares: Jet
    angles: Sequence[float]
    phi: Ball
    evidence: Evidence
    points: Mapping[tuple[int, int], Jet] = field(default_factory=dict)

    @cached_property
    def places(self) -> Integers:
        """The lanes in which all quantities have bounds."""
        lanes: Integers = np.flatnonzero(np.all([jet.is_bounded for jet in self.jets], axis=0))
        self.space.jumping = self.space.jumping[lanes]
        return lanes

    @property
    def is_whole(self) -> bool:
        """Whether all lanes have bounds."""
        return len(self.places) == self.shares.lanes + len(self.angles)

    @property
    def may_be_empty(self) -> bool:
        """Whether roots are unknown at the centre of the box at some angle."""
        return any(np.isnan(start.values).any() for start in self.evidence.starts)

    def bound_term(self, measure: BoundedMeasure) -> BoundedTerm:
        """Return a weighted measure, or what it is not below.

        Raises Unbounded for one that needs all angles.
        """
        lanes, is_whole = self._find_lanes(measure)
        sides = SIDES.get(measure.kind, ())
        if not is_whole and not measure.is_nonnegative and not sides:
            raise Unbounded(f"a term, {measure.kind}, cannot be enclosed at every angle")
        if not len(lanes):
            return BoundedTerm(None, (), False)
        if sides:
            weight = abs(measure.weight)
            return BoundedTerm(
                None, tuple(self._find_maximum(measure, side, weight) for side in sides), is_whole
            )
        try:
            return BoundedTerm(self._average(measure) * measure.weight, (), is_whole)
        except Unbounded:
            if not measure.is_nonnegative:
                raise
            return BoundedTerm(None, (), False)

    def find_span(self, measure: BoundedMeasure, part: int) -> tuple[float, float]:
        """Return between which values a measure is, anywhere in the box or at its centre."""
        lanes, is_whole = self._find_lanes(measure)
        if not len(lanes):
            return -np.inf, np.inf
        if measure.kind in SIDES:
            spans = [
                self._find_maximum(measure, side).find_span(part) for side in SIDES[measure.kind]
            ]
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

    def _find_lanes(self, measure: BoundedMeasure) -> tuple[Integers, bool]:
        """Return the lanes of the angles that a measure takes, and whether they are all."""
        count = self.shares.lanes
        if measure.angle is None:
            lanes = self.places[self.places < count]
            return lanes, len(lanes) == count
        lanes = self.places[self.places == count + self.angles.index(measure.angle)]
        return lanes, len(lanes) == 1

    def _find_maximum(self, measure: BoundedMeasure, side: int, weight: float = 1.0) -> Maximum:
        """Return the greatest value of a quantity, or of minus it, times a positive weight."""
        lanes, _ = self._find_lanes(measure)
        curve = self.jets[measure.quantity].taken(lanes).hull(len(self.space.lower))
        panels = replace(curve, space=self.space) * (side * weight)
        points = self.points.get((measure.quantity, side))
        if points is None or not points.is_bounded.any():
            return Maximum(panels, panels)
        return Maximum(points.taken(points.is_bounded) * weight, panels)

    def _average(self, measure: BoundedMeasure) -> Jet:
        """Return a measure without corners; of squares, those that are missing count as zero."""
        lanes, is_whole = self._find_lanes(measure)
        jet = self.jets[measure.quantity].taken(lanes)
        if measure.kind == "at":
            return replace(jet, space=self.space)
        shares = self.shares.taken(lanes)
        if measure.kind == "mean":
            return replace(self._mean(jet, shares), space=self.space)
        if measure.kind != "rms":
            mean = self._mean(jet, shares)
            jet = jet - (mean if is_whole else mean / shares.sum())
        square = replace(self._mean(enclose_square(jet), shares), space=self.space)
        return square if measure.kind == "variance" else square.sqrt()

    def _mean(self, jet: Jet, shares: Jet) -> Jet:
        return (jet.average(len(self.space.lower)) * shares).sum()


def _add_smooth(space: Space, terms: Sequence[BoundedTerm]) -> Jet:
    """Return the sum of the smooth parts of terms."""
    return sum((term.smooth for term in terms if term.smooth is not None), space.integer(0))


def _add_down(*spans: tuple[float, float]) -> tuple[float, float]:
    """Return between which values a sum is, from spans of two numbers."""
    total = Ball.exact(spans[0]) + Ball.exact(spans[1])
    return float(total.low[0]), float(total.high[1])


def _exclude(cycle: EnclosedCycle) -> ObjectiveBounds:
    """Return the bounds over a box in which no design counts."""
    nothing = np.zeros(len(cycle.space.lower))
    return ObjectiveBounds(
        np.inf, np.inf, Ball(nothing, nothing), nothing, may_jump=True, evidence=cycle.evidence
    )
