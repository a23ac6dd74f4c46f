"""A sum of measures of a machine over samples of a cycle, bounded over boxes of designs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np

from planter.engine.machine import Machine
from planter.engine.measures import Measure
from planter.errors import InputError
from planter.kernels import Array
from planter.optimise.proof.arithmetic import PI
from planter.optimise.proof.balls import Ball, Unbounded
from planter.optimise.proof.curve import Enclosed, enclose_at
from planter.optimise.proof.jets import Jet, Space
from planter.optimise.proof.objective import Bounds, Extreme, bounds, variance

NONNEGATIVE = ("range", "variance", "std", "rms")
"""Measures that are never below zero, of whatever quantity."""

Enclose = Callable[[Sequence[tuple[str, bool]]], Enclosed]
"""Gives enclosures of quantities by name, or of their sizes."""


class ProvableObjective:
    """A sum of measures over `count` samples of a cycle, in display units, bounded over boxes [lower, upper] (p,)."""

    def __init__(self, machine: Machine, least: Sequence[Measure], count: int, enclose: Enclose) -> None:
        self.machine, self.least, self.count = machine, tuple(least), count
        self._quantities = list(dict.fromkeys((measure.name, measure.size) for measure in least))
        self._angles = list(dict.fromkeys(measure.angle for measure in least if measure.angle is not None))
        self._enclosed = enclose(self._quantities)
        cycle = [Fraction(i, count) for i in range(count)]
        self._turns = [*cycle, *(Fraction(angle % 360) / 360 for angle in self._angles)]

    def __call__(self, lower: Array, upper: Array) -> Bounds:
        """Return the bounds over a box. Raises Unbounded where there are none."""
        space = Space(lower, upper)
        with np.errstate(all="ignore"):
            jets = enclose_at(self._enclosed, space, self._turns)
            smooth, extremes = space.whole(0), list[Extreme]()
            for measure in self.least:
                factor = 1 / self.machine.find_quantity(measure.name).factor
                jet = jets[self._quantities.index((measure.name, measure.size))] * factor
                cycle = jet.taken(slice(0, self.count))
                if measure.kind in ("max", "range"):
                    extremes.append(Extreme(cycle * measure.weight))
                if measure.kind in ("min", "range"):  # a sum counts a least value negatively, as `Goal` does
                    extremes.append(Extreme(cycle * -measure.weight))
                if measure.kind not in ("max", "min", "range"):
                    smooth = smooth + self._average(measure, jet, cycle) * measure.weight
            result = bounds(smooth, extremes)
        if not (np.isfinite(result.least) and np.isfinite(result.looseness).all()):
            raise Unbounded("a bound is not finite")
        return result

    @property
    def floor(self) -> float:
        """What no objective is below."""
        nonnegative = (m.kind in NONNEGATIVE or (m.size and m.kind in ("max", "at")) for m in self.least)
        return 0.0 if all(nonnegative) else -np.inf

    def _average(self, measure: Measure, jet: Jet, cycle: Jet) -> Jet:
        """Return a measure without corners."""
        if measure.kind == "at":
            assert measure.angle is not None
            return jet.taken([self.count + self._angles.index(measure.angle)])
        if measure.kind == "mean":
            return cycle.mean()
        if measure.kind == "rms":
            return (cycle**2).mean().sqrt()
        if measure.kind == "work":
            return cycle.mean() * self._length(measure, cycle.space)
        square = variance(cycle)
        return square if measure.kind == "variance" else square.sqrt()

    def _length(self, measure: Measure, space: Space) -> Jet:
        """Return how long a cycle is for the work of a quantity, in time or in angle."""
        turn = space.constant(PI * Ball.exact([2.0]))
        if self.machine.find_quantity(measure.name).unit == "N m":
            return turn
        index = self.machine.speed
        if index in self.machine.moved:
            speed = space.parameters()[self.machine.moved.index(index)]
            return turn / speed if space.centre[self.machine.moved.index(index)] > 0 else turn / -speed
        return turn / abs(float(self.machine.data[index]))


def check_provable(machine: Machine, least: Sequence[Measure], label: str) -> None:
    """Raise InputError, which begins with `label`, for a sum of which no proof is known."""
    for measure in least:
        if measure.where is not None or measure.during:
            clause = "where" if measure.where is not None else "while"
            raise InputError(f"{label}: {measure}: a proof takes angles that are fixed, so leave out `{clause}`")
        quantity = machine.find_quantity(measure.name)
        if quantity.role != "result":
            raise InputError(f"{label}: {measure}: a proof bounds results, and {quantity.name} is a {quantity.role}")
    if not machine.moved:
        raise InputError(f"{label}: {machine.source}: it has no [bounds], so there is no box to prove anything of")
