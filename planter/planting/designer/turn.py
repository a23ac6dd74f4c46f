"""A design of a planting device over a turn: its rows, split where they are not smooth, with their extremes."""

from __future__ import annotations

from planter.engine.summary import Cycle
from planter.kernels import Array
from planter.planting.designer.quantities import DeviceRows
from planter.planting.model import Device


class DesignTurn(Cycle):
    """A design (p,) over a turn: its rows by name, each an angle and a value, in SI."""

    def __init__(self, device: Device, x: Array) -> None:
        machine = device.force.machine
        super().__init__(machine, DeviceRows(device, machine).build(), x)
        self.device, self.x, self.at = device, x, device.prologue(x)
