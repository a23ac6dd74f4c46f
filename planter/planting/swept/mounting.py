"""Gears at centre distances that are not those of their pitch curves.

A pair whose centres stand apart by a deviation rolls on pitch curves of the same shape, larger by what the distance is:
as with circular involute gears the ratio stays, the arms and the working curves grow. All lengths of a stage's
parameters take the same factor, 1 + deviation / distance.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca

from planter.kernels import Array, Kernel
from planter.planting.model import Device

DEVIATIONS = ("deviation.a1_mm", "deviation.a2_mm")
"""Deviations of the centre distances of stage 1 and 2, as inputs."""
MEANINGS = tuple(f"centre distance of stage {number} less that of its pitch curves" for number in (1, 2))
LENGTH = "m"


class Mounting:
    """Designs that work like those of a device at other centre distances."""

    def __init__(self, device: Device) -> None:
        self.device = device

    @cached_property
    def function(self) -> ca.Function:
        """(x, d) -> x: the design that works like x where its centre distances deviate by d (2,) [m]."""
        device = self.device
        x, d = ca.SX.sym("x", device.size), ca.SX.sym("d", len(device.stages))
        ends = [device.size - sum(len(stage.names) for stage in device.stages[k:]) for k in range(len(device.stages))]
        mounting, *parts = ca.vertsplit(x, [0, *ends, device.size])
        grown = []
        for number, (stage, part) in enumerate(zip(device.stages, parts, strict=True)):
            factor = 1 + d[number] / stage.prologue.function(part)[0]
            lengths = [entry["unit"] == LENGTH for entry in stage.sidecar["parameters"]]
            grown += [part[i] * factor if length else part[i] for i, length in enumerate(lengths)]
        return ca.Function("mounted", [x, d], [ca.vertcat(mounting, *grown)], ["x", "d"], ["mounted"])

    @cached_property
    def _kernel(self) -> Kernel:
        kernel = Kernel(self.function, lanes=["x", "d"])
        kernel.compile()
        return kernel

    def __call__(self, designs: Array, deviations: Array) -> Array:
        """Designs (m, p) at centre distances that deviate by (m, 2) [m]."""
        if not deviations.any():
            return designs
        return self._kernel(x=designs.T, d=deviations.T)["mounted"].T
