"""A design over a turn: the rows of `quantities`, split where they are not smooth, with their extremes."""

from __future__ import annotations

import math
from functools import cached_property, partial

import numpy as np

from planter.kernels import Array
from planter.numerics.extremes import Extreme
from planter.numerics.pieces import Pieces
from planter.planting import response
from planter.planting.designer.quantities import Quantities
from planter.planting.model import Device


class DesignTurn:
    """A design (p,) over a turn: its rows by name, each an angle and a value, in SI."""

    def __init__(self, device: Device, x: Array) -> None:
        self.device, self.x, self.at = device, x, device.prologue(x)
        self.quantities = Quantities(device)
        self.events = response.joints(device, x)
        angles = np.array([event.angle for event in self.events])
        self.pieces = Pieces(partial(self.quantities.values, self.at), angles)

    @cached_property
    def _extremes(self) -> dict[str, tuple[Extreme, Extreme]]:
        names = self.quantities.peaks
        rows = np.array([self.quantities.names.index(name) for name in names])
        return dict(zip(names, self.pieces.extremes(rows, partial(self.quantities.rates, self.at)), strict=True))

    def extreme(self, name: str, sign: int) -> Extreme:
        """The largest (+1) or least (-1) value of a row."""
        return self._extremes[name][sign > 0]

    def size(self, name: str, sign: int) -> Extreme:
        """The same of a row that is a square, of its root."""
        found = self.extreme(name, sign)
        return Extreme(found.place, math.sqrt(max(found.value, 0.0)))

    def largest(self, name: str) -> Extreme:
        """The value of a row that is largest in size, as that size."""
        found = max((self.extreme(name, sign) for sign in (1, -1)), key=lambda one: abs(one.value))
        return Extreme(found.place, abs(found.value))
