"""The turn as N samples at phi = 2 pi i / N.

F_i(x) is smooth but where a joint passes sample i: there its gradient jumps by a multiple of the joint's velocity (order 1;
at joints of order 2 only its second derivative jumps, which Newton's method bears). `Conditions` carry both one-sided
gradients of a sample that sits on a joint, so that the certificate is Clarke's. To solve on such a kink, a sample is
pinned: it is taken at the joint, F(psi(x), x), which is smooth, and psi(x) = phi_i becomes an equality.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.optimise import joints, moving
from planter.optimise.conditions import Conditions, Look, Slopes, Values
from planter.optimise.joints import ASIDE, IntArray, Joints
from planter.optimise.latest import Latest
from planter.optimise.response import Response

ON = 1e-8
"""A joint closer than this to a sample sits on it [rad]."""
SHARE = 0.25
"""Samples within this share of the range from an extreme are in the first working set."""


@dataclass(frozen=True)
class Pin:
    """A sample that a joint of an event is held on."""

    sample: int
    event: int


def angles(samples: int, period: float) -> Array:
    """The samples' angles that differ modulo the period [rad], (n,): half of them where N is even and the period pi."""
    turns = round(2 * np.pi / period)
    count = samples // turns if samples % turns == 0 else samples
    return 2 * np.pi * np.arange(count) / samples


class Samples:
    """A turn of the force as N samples. Implements `Turn`."""

    def __init__(self, response: Response, samples: int) -> None:
        self.response = response
        self.angles = angles(samples, response.period)

    def look(self, x: Array) -> Look:
        return Look.at(self.response.support(self.response.prologue(x), self.angles))

    def local(self, x: Array) -> SampledRows:
        """All samples near an extreme; nothing pinned."""
        force = self.response.support(self.response.prologue(x), self.angles)
        margin = SHARE * np.ptp(force)
        return SampledRows(self.response, self.angles, np.flatnonzero(force >= force.max() - margin),
                           np.flatnonzero(force <= force.min() + margin))  # fmt: skip

    def near(self, x: Array, width: float) -> list[tuple[Pin, float]]:
        """Joints of order 1 within `width` [rad] of a sample, nearest first, with the signed distance psi - phi_i."""
        found = joints.find(self.response, self.response.prologue(x))
        folded = found.folded
        gaps = _wrapped(folded[:, None] - self.angles, self.response.period)
        nearest = np.abs(gaps).argmin(axis=1)
        distance = gaps[np.arange(len(folded)), nearest]
        pins = [
            (Pin(int(nearest[j]), int(found.events[j])), float(distance[j]))
            for j in np.argsort(np.abs(distance), kind="stable")
            if found.orders[j] == 1 and abs(distance[j]) <= width
        ]
        return pins

    def conditions(self, x: Array) -> Conditions:
        at = self.response.prologue(x)
        force, slopes = self.response.support_slopes(at, self.angles)
        gradients = slopes[:, 1:]
        samples = np.array([pin.sample for pin, _ in self.near(x, ON)], dtype=int)
        before, after = (self._aside(at, samples, side) for side in (-1, 1))
        gradients[samples] = before
        weights = 2 * (force - force.mean()) / len(force)
        rows, both = np.append(force, force[samples]), np.vstack([gradients, after])
        kinks = weights[samples, None] * (after - before)
        return Conditions(rows, both, rows, both, weights @ gradients, kinks)

    def _aside(self, at: Any, samples: Array, side: int) -> Array:
        """Gradients (k, p) of samples on joints with the joint moved to one side."""
        if not len(samples):
            return np.empty((0, len(self.response.names)))
        return self.response.support_slopes(at, self.angles[samples] + side * 2 * ON)[1][:, 1:]


class SampledRows:
    """Samples `upper` and `lower` as rows, samples in `pins` taken at their joints. Implements `Local`."""

    def __init__(self, response: Response, phi: Array, upper: Array, lower: Array, pins: tuple[Pin, ...] = ()) -> None:
        self.response, self.angles = response, phi
        self.upper, self.lower, self.pins = upper, lower, pins
        self._state = Latest(lambda x: _State(self, x))

    def grown(self, upper: Array, lower: Array) -> SampledRows:
        """With more samples as rows."""
        more = np.union1d(self.upper, upper), np.union1d(self.lower, lower)
        return SampledRows(self.response, self.angles, *more, self.pins)

    def pinned(self, pins: tuple[Pin, ...]) -> SampledRows:
        return SampledRows(self.response, self.angles, self.upper, self.lower, pins)

    def beyond(self, x: Array, high: float, low: float) -> tuple[Array, Array]:
        """Samples with a force above `high`, and below `low` [N]."""
        force = self._state(x).force
        return np.flatnonzero(force > high), np.flatnonzero(force < low)

    def look(self, x: Array) -> Look:
        return Look.at(self._state(x).force)

    def values(self, x: Array) -> Values:
        state = self._state(x)
        force = state.force
        return Values(float(force.var()), force[self.upper], force[self.lower], state.gaps)

    def slopes(self, x: Array) -> Slopes:
        state = self._state(x)
        gradients, n = state.gradients, len(state.force)
        variance = 2 / n * (state.force - state.force.mean()) @ gradients
        return Slopes(variance, gradients[self.upper], gradients[self.lower], state.velocity)

    def curvature(self, x: Array, weights: Values) -> Array:
        state = self._state(x)
        n, centred = len(state.force), state.gradients - state.gradients.mean(axis=0)
        each = 2 / n * weights.variance * (state.force - state.force.mean())
        np.add.at(each, self.upper, weights.upper)
        np.add.at(each, self.lower, weights.lower)
        squared = 2 / n * weights.variance * (centred.T @ centred)
        return squared + state.hessian(each, weights.pins)


class _State:
    """Samples at one design; pinned ones moved onto their joints."""

    def __init__(self, rows: SampledRows, x: Array) -> None:
        self.response, self.at = rows.response, rows.response.prologue(x)
        self.picked = np.array([pin.sample for pin in rows.pins], dtype=int)
        self.phi = rows.angles.copy()
        self.gaps, self.velocity = np.empty(0), np.empty((0, len(x)))
        if rows.pins:
            self.joints = joints.find(self.response, self.at)
            self.chosen, self.gaps = _chosen(self.joints, rows)
            self.velocity = self.joints.velocity[self.chosen]
            self.phi[self.picked] += self.gaps + ASIDE
        self.force, self.jacobian = self.response.support_slopes(self.at, self.phi)
        self.gradients = self.jacobian[:, 1:].copy()
        self.gradients[self.picked] = moving.gradients(self.jacobian[self.picked], self.velocity)

    @cached_property
    def motion(self) -> moving.Motion:
        return moving.Motion(self.velocity, self.joints.acceleration(self.chosen))

    def hessian(self, weights: Array, pins: Array) -> Array:
        """Weighted sum of the samples' Hessians and the pins'."""
        if not len(self.picked):
            return self.response.support_hessian(self.at, self.phi, weights)[1:, 1:]
        standing = weights.copy()
        standing[self.picked] = 0
        second = self.response.support_hessians(self.at, self.phi[self.picked])
        moved = moving.hessians(self.jacobian[self.picked], second, self.motion)
        total: Array = self.response.support_hessian(self.at, self.phi, standing)[1:, 1:]
        return total + np.tensordot(weights[self.picked], moved, 1) + np.tensordot(pins, self.motion.acceleration, 1)


def _chosen(found: Joints, rows: SampledRows) -> tuple[IntArray, Array]:
    """The joint of each pin, nearest to its sample, and the distance psi - phi_i."""
    chosen, gaps = [], []
    for pin in rows.pins:
        gap = _wrapped(found.folded - rows.angles[pin.sample], found.response.period)
        gap[found.events != pin.event] = np.inf
        chosen.append(int(np.abs(gap).argmin()))
        gaps.append(gap[chosen[-1]])
    return np.array(chosen), np.array(gaps)


def _wrapped(gap: Array, period: float) -> Array:
    wrapped: Array = np.mod(gap + period / 2, period) - period / 2
    return wrapped
