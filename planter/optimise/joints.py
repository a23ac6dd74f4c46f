"""Joints of the force curve: the angles where its derivatives jump, and how they move with the design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.optimise import roots
from planter.optimise.response import Response

GRID = 96
"""Angles of a turn between which joints are looked for; two joints of one event closer than this are missed."""
ASIDE = 1e-9
"""How far beside a joint one-sided derivatives are taken [rad]."""


@dataclass(frozen=True)
class Joints:
    """Joints of side 1 at one design, by angle.

    `angles` (m,) in [0, 2 pi); `events` (m,) index of the event; `velocity` (m, p) derivative of the angles in x.
    """

    angles: Array
    events: Array
    velocity: Array
    names: tuple[str, ...]
    orders: Array

    def folded(self, period: float) -> Array:
        """The angles taken into the first period of the force, (m,)."""
        return np.mod(self.angles, period)


def find(response: Response, at: Any) -> Joints:
    """All joints of a design."""
    events, low, high, level = _brackets(response, at)
    names = tuple(response.events[k].name for k in events)
    orders = np.array([response.events[k].order for k in events], dtype=int)
    if not len(events):
        return Joints(np.empty(0), events, np.empty((0, len(response.names))), names, orders)
    angles = follow(response, at, events, low, high, level)
    order = np.argsort(angles, kind="stable")
    angles, events = angles[order], events[order]
    return Joints(angles, events, velocities(response, at, events, angles), tuple(names[i] for i in order), orders[order])


def _brackets(response: Response, at: Any) -> tuple[Array, Array, Array, Array]:
    """Event, bracket and level of every joint: g passes the level once between two neighbours of a grid."""
    grid = np.linspace(0, 2 * np.pi, GRID + 1)
    g, _ = response.event_values(at, grid)
    periods = np.array([event.period or np.inf for event in response.events])[:, None]
    turns = np.where(np.isinf(periods), np.where(g < 0, -1.0, 0.0), np.floor(g / periods))
    events, cells = np.nonzero(turns[:, 1:] != turns[:, :-1])
    passed = np.maximum(turns[events, cells], turns[events, cells + 1])
    level = np.where(passed == 0, 0.0, passed * np.where(np.isinf(periods), 0.0, periods)[events, 0])
    return events, grid[cells], grid[cells + 1], level


def follow(response: Response, at: Any, events: Array, low: Array, high: Array, level: Array) -> Array:
    """Angles (m,) in [low, high] where the m given events have the given levels."""
    pick = np.arange(len(events))

    def above(phi: Array) -> tuple[Array, Array]:
        g, along = response.event_values(at, phi)
        return g[events, pick] - level, along[events, pick]

    return np.mod(roots.newton(above, low, high, (low + high) / 2), 2 * np.pi)


def velocities(response: Response, at: Any, events: Array, angles: Array) -> Array:
    """Derivative of joint angles in the design, (m, p): -g_x / g_phi."""
    slopes = response.event_slopes(at, angles)[events, np.arange(len(events))]
    velocity: Array = -slopes[:, 1:] / slopes[:, :1]
    return velocity


def accelerations(response: Response, at: Any, events: Array, angles: Array, velocity: Array) -> Array:
    """Second derivative of joint angles in the design, (m, p, p)."""
    slopes = response.event_slopes(at, angles)[events, np.arange(len(events))]
    found = np.empty((len(events), velocity.shape[1], velocity.shape[1]))
    for j, (event, angle) in enumerate(zip(events, angles, strict=True)):
        path = np.vstack([velocity[j], np.eye(velocity.shape[1])])
        found[j] = -(path.T @ response.event_hessian(at, float(angle), int(event)) @ path) / slopes[j, 0]
    return found
