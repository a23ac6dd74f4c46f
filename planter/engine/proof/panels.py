"""Panels of a cycle: between angles that move with the design, on which a quantity is a function of
its place, too.

Ends of panels are linear in the design, so that each is the same function for both panels that meet
there; the last end is the first one a period later. Nothing else is needed for panels to cover a
cycle. Where ends follow the angles at which a quantity has a kink, at some distance, kinks stay
within narrow panels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.proof.intervals import Ball, Unbounded
from planter.engine.proof.jets import ANYWHERE, CENTRE, Jet, Space
from planter.kernels import Array

LEAST_GUARD = 1e-6
"""Least distance of the end of a panel from a kink [rad]."""


@dataclass(frozen=True)
class MovingKinks:
    """Angles [rad] of kinks (k,) at a design, with their slopes (k, p) in it and `bends` (k, p,
    p).
    """

    angles: Array
    slopes: Array
    bends: Array

    @classmethod
    def none(cls, size: int) -> MovingKinks:
        """Return no kinks of designs with `size` values."""
        return cls(np.empty(0), np.empty((0, size)), np.empty((0, size, size)))


@dataclass(frozen=True)
class AnglePanels:
    """Panels over a period: `parts` (k,) equal ones from each of the `knots` (k,) [rad] to the
    next, or to its end.

    Knots are those at the centre of a box, with `rates` (k, p) in the design. The space of panels
    has the place in a panel, from -1 to 1, as the parameter after those of the design.
    """

    knots: Array
    rates: Array
    parts: tuple[int, ...]
    period: Ball

    @classmethod
    def build(cls, kinks: MovingKinks, half: Array, period: Ball, count: int) -> AnglePanels:
        """Return at least `count` panels over designs of a box with half widths (p,), narrow ones
        about the kinks.
        """
        turn = float(period.mid[0])
        guard = np.einsum("kij,i,j->k", np.abs(kinks.bends), half, half) + LEAST_GUARD
        ends = sorted(
            zip(
                np.concatenate([kinks.angles - guard, kinks.angles + guard]),
                [*kinks.slopes, *kinks.slopes],
                strict=True,
            ),
            key=lambda end: end[0],
        )
        knots: list[tuple[float, Array]] = []
        for place, slope in ends:
            if not knots or place - knots[-1][0] > np.abs(slope - knots[-1][1]) @ half:
                knots.append((place, slope))
        while (
            len(knots) > 1
            and knots[0][0] + turn - knots[-1][0] <= np.abs(knots[0][1] - knots[-1][1]) @ half
        ):
            knots.pop()
        knots = knots or [(0.0, np.zeros_like(half))]
        places = np.array([place for place, _ in knots])
        widths = np.diff(places, append=places[0] + turn)
        parts = tuple(max(1, int(np.ceil(width / turn * count))) for width in widths)
        return cls(places, np.array([rate for _, rate in knots]), parts, period)

    @cached_property
    def places(self) -> Array:
        """Return the angles [rad] at which panels begin at the centre of a box (m,)."""
        return self._divide(self.knots, self.knots[:1] + self.period.mid[0])

    @cached_property
    def slopes(self) -> Array:
        """Slopes (m, p) of the places in the design."""
        return self._divide(self.rates, self.rates[:1])

    def _divide(self, values: Array, end: Array) -> Array:
        """Return values at all places from those (k, ...) at the knots and at the end of the
        period.
        """
        steps = np.diff(values, axis=0, append=end)
        shares = [np.arange(count) / count for count in self.parts]
        return np.concatenate(
            [
                value + np.multiply.outer(share, step)
                for value, share, step in zip(values, shares, steps, strict=True)
            ]
        )

    def angles(self, space: Space) -> tuple[Jet, Jet]:
        """Return the angles in the panels [rad], and the shares of the panels in the period, over a
        box.

        Raises Unbounded if a panel may have no width.
        """
        low = space.linear(self.places, self.slopes)
        next_, count = np.roll(np.arange(len(self.places)), -1), len(self.places)
        is_last = np.arange(count) == count - 1
        turn = Ball(
            np.where(is_last, self.period.mid, 0.0), np.where(is_last, self.period.rad, 0.0)
        )
        high = low.taken(next_) + space.constant(turn)
        width = high - low
        if not (width.value[ANYWHERE].low > 0).all():
            raise Unbounded("panels of angles overlap")
        place = space.parameters()[-1]
        return (low + high) / 2 + width * place / 2, width / space.constant(self.period)

    def find_peaks(self, jet: Jet, k: int, count: int) -> tuple[Array, Array]:
        """Return `count` angles [rad] where a quantity, with its place k, is nearly greatest, and
        their slopes (n, p).

        They are those of the greatest values of parabolas at the centre of the box, and move as
        panels do.
        """
        full = jet.over(tuple(sorted({*jet.support, k})))
        at = full.support.index(k)
        value, slope = full.value.mid[CENTRE], full.gradient.mid[CENTRE][at]
        bend = np.minimum(full.hessian.mid[at * (at + 3) // 2], 0.0)
        place = np.where(
            bend < 0, np.clip(-slope / np.where(bend < 0, bend, -1.0), -1, 1), np.sign(slope)
        )
        best = np.argsort(-(value + slope * place + bend * place**2 / 2), kind="stable")[:count]
        share = (1 + place[best]) / 2
        widths = np.diff(self.places, append=self.places[0] + self.period.mid[0])[best]
        further = np.roll(self.slopes, -1, axis=0)[best] - self.slopes[best]
        return self.places[best] + share * widths, self.slopes[best] + share[:, None] * further
