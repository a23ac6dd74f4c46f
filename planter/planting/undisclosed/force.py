"""The support force of a device's own design as a function of inputs that are not disclosed, with exact derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel
from planter.optimise.samples import angles
from planter.planting.model import Device
from planter.planting.undisclosed.inputs import Inputs

CONTACT = "F_E"
FIGURES = ("max_N", "min_N", "variance_N2")


@dataclass(frozen=True)
class Curve:
    """Support force [N] (n,) over its period, cam's force on the roller [N] (m,) over a turn, Jacobians in z."""

    force: Array
    push: Array
    slopes: Array
    push_slopes: Array

    @property
    def range(self) -> float:
        return float(np.ptp(self.force))

    @property
    def variance(self) -> float:
        return float(self.force.var())

    @property
    def variance_slopes(self) -> Array:
        found: Array = 2 / len(self.force) * (self.force - self.force.mean()) @ self.slopes
        return found

    def figures(self) -> dict[str, float]:
        """Extremes and variance."""
        values = float(self.force.max()), float(self.force.min()), self.variance
        return dict(zip(FIGURES, values, strict=True))

    def figure_slopes(self) -> Array:
        """Their Jacobian in z, (3, n): an extreme's is that of its sample."""
        return np.array([self.slopes[self.force.argmax()], self.slopes[self.force.argmin()], self.variance_slopes])


class Force:
    """The force over a machine's own samples, at points z (n,) of the unit box of some inputs."""

    def __init__(self, device: Device, inputs: Inputs) -> None:
        self.device, self.inputs = device, inputs
        self._places = inputs.places(device)
        self._kernel = self._made()
        self._kernel.compile()
        offsets, curves = device.force.offsets, device.prologue(device.design).h[: self._curves]
        phi = angles(device.machine.objective.samples, device.force.period)
        self._count = len(offsets)
        self._fixed = {"phi": np.add.outer(offsets, phi).reshape(1, -1), "x": device.design, "curves": curves}

    def _made(self) -> Kernel:
        functions = self.device.functions
        side = [entry["name"] for entry in self.device.sidecar["vectors"]["side"]]
        d, q = ca.vertcat(functions.x, functions.c), ca.SX(0, 1)
        share = self.device.force.response.values_function(functions.phi, d, functions.h, q)
        outputs = [share, functions.side(functions.phi)[side.index(CONTACT)]]
        values, inputs = functions.of_data(outputs)
        self._curves = inputs[-1].numel()
        found = ca.vertcat(*values)
        along = ca.densify(ca.jacobian(found, functions.c[self._places]))
        names = ["phi", "x", "c", "curves"]
        return Kernel(ca.Function("inputs", inputs, ca.cse([found, ca.vec(along)]), names, ["found", "along"]), ["phi"])

    def __call__(self, z: Array) -> Curve:
        constants = self.device.constants.copy()
        constants[self._places] = self.inputs.values(z)
        found = self._kernel(c=constants, **self._fixed)
        along = found["along"].reshape(len(self._places), 2, -1).transpose(1, 2, 0) @ self.inputs.slopes(z)
        force = found["found"][0].reshape(self._count, -1).sum(axis=0)
        slopes = along[0].reshape(self._count, len(force), -1).sum(axis=0)
        return Curve(force, found["found"][1], slopes, along[1])

    @property
    def way(self) -> str:
        """How the force is evaluated."""
        return self._kernel.way

    def own(self) -> Array:
        """The machine's own values, taken into the bounds."""
        return self.inputs.point(self.device.constants[self._places[:-1]])
