"""Joints of a curve: the angles where its derivatives jump, and how they move with the design."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import TURN, Integers
from planter.numerics.roots import find_crossings
from planter.optimise.response import Response

GRID = 72
"""Angles of a turn between which joints are looked for; two joints of one event closer than this are missed."""
ASIDE = 1e-9
"""How far beside a joint one-sided derivatives are taken [rad]."""


@dataclass(frozen=True)
class Joints:
    """Joints of side 1 at one design, by angle: `angles` (m,) in [0, 2 pi), `events` (m,) index of the event."""

    response: Response
    at: Any
    angles: Array
    events: Integers

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.response.events[k].name for k in self.events)

    @property
    def orders(self) -> Integers:
        """Order of the first derivative of F in phi that jumps, (m,)."""
        return np.array([self.response.events[k].order for k in self.events], dtype=np.int64)

    @property
    def folded(self) -> Array:
        """The angles taken into the first period of the curve, (m,)."""
        return np.mod(self.angles, self.response.period)

    @cached_property
    def _slopes(self) -> Array:
        if not len(self.angles):
            return np.empty((0, 1 + len(self.response.names)))
        return self.response.event_slopes(self.at, self.angles)[self.events, np.arange(len(self.events))]

    @cached_property
    def velocity(self) -> Array:
        """Derivative of the angles in the design, (m, p): -g_x / g_phi."""
        slopes = self._slopes
        velocity: Array = -slopes[:, 1:] / slopes[:, :1]
        return velocity

    def acceleration(self, picked: Integers) -> Array:
        """Second derivative of the angles of the picked joints in the design, (k, p, p)."""
        size = self.velocity.shape[1]
        found = np.empty((len(picked), size, size))
        for i, j in enumerate(picked):
            path = np.vstack([self.velocity[j], np.eye(size)])
            bent = self.response.event_hessian(self.at, float(self.angles[j]), int(self.events[j]))
            found[i] = -(path.T @ bent @ path) / self._slopes[j, 0]
        return found


def find(response: Response, at: Any) -> Joints:
    """Return all joints of a design."""
    periods = np.array([event.period or np.inf for event in response.events])
    angles, events = find_crossings(
        lambda phi: response.event_values(at, phi)[0], lambda phi: response.event_values(at, phi), periods, GRID, TURN
    )
    return Joints(response, at, angles, events)


@dataclass(frozen=True)
class Place:
    """A joint of one side: its angle in [0, 2 pi) and the angle's derivative in the design, (p,)."""

    name: str
    side: int
    order: int
    angle: float
    velocity: Array


def places(response: Response, at: Any) -> list[Place]:
    """Joints of all sides over a turn, by angle: side 1, and the others each one period of the curve later."""
    found = find(response, at)
    sides = round(TURN / response.period)
    every = [
        Place(name, side, int(order), float(np.mod(angle + (side - 1) * response.period, TURN)), velocity)
        for side in range(1, sides + 1)
        for name, order, angle, velocity in zip(found.names, found.orders, found.angles, found.velocity, strict=True)
    ]
    return sorted(every, key=lambda place: place.angle)
