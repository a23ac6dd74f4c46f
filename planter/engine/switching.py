"""Angles of a cycle at which a law of a machine changes: zeros of its events, or whole numbers of their periods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.engine.machine import Machine
from planter.engine.response import DesignPoint, Response
from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.numerics.crossings import find_crossings


@dataclass(frozen=True)
class Switching:
    """An event of a side, the first of which is 1, at an angle of the first cycle [rad]."""

    name: str
    side: int
    angle: float


class Switchings:
    """The events of a machine over designs; two of one event that lie within a step of the scan are missed."""

    def __init__(self, machine: Machine, count: int) -> None:
        """Scan `count` steps of a cycle."""
        self.machine, self.response = machine, Response(machine, (), with_events=True)
        size = len(self.response.quantities)
        self.kinds = machine.event_kinds or tuple({"name": f"event {i + 1}"} for i in range(size))
        self.periods = np.array([kind.get("period") or np.inf for kind in self.kinds])
        self.count = count

    def find(self, point: DesignPoint) -> tuple[Array, Integers]:
        """Return the angles (s,) at which events of the first side happen, in order, and the rows of these."""
        if not len(self.periods):
            return np.empty(0), np.empty(0, dtype=np.int64)
        response = self.response
        return find_crossings(
            lambda phi: response.values(point, phi), lambda phi: response.derivatives(point, phi), self.periods,
            self.count, self.machine.turn,
        )  # fmt: skip

    def find_all(self, point: DesignPoint) -> list[Switching]:
        """Return the events of all sides, by their angles."""
        angles, rows = self.find(point)
        switchings = [
            Switching(str(self.kinds[row]["name"]), side, float(np.mod(angle - offset, self.machine.turn)))
            for side, offset in enumerate(self.machine.offsets, 1)
            for angle, row in zip(angles, rows, strict=True)
        ]
        return sorted(switchings, key=lambda switching: switching.angle)
