"""Exact slopes of outputs in inputs at one point: of a device whose design, data and centre distances vary."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import casadi as ca
import numpy as np

from planter.files import units
from planter.kernels import Array, Kernel
from planter.optimise.spread import Weights
from planter.planting.model import Device
from planter.planting.swept.measures import Measure
from planter.planting.swept.mounting import Mounting
from planter.planting.swept.turning import Turning


@dataclass(frozen=True)
class Place:
    """Where an input stands: in the design, the data or the deviations, at an index; SI per shown unit."""

    vector: str
    index: int
    factor: float


class Varied(Protocol):
    """A device whose inputs vary, and what is measured of it."""

    device: Device
    mounting: Mounting
    turning: Turning
    measures: list[Measure]
    weights: Weights
    places: list[Place]

    def vectors(self, points: Array) -> tuple[Array, Array, Array]:
        """Designs, data and deviations in SI, of points in shown units."""


class Slopes:
    """Of a subject's outputs in its inputs; extremes stay at their samples."""

    def __init__(self, subject: Varied) -> None:
        self.subject = subject

    @cached_property
    def kernel(self) -> Kernel:
        """(phi, z) -> the rows of a lane and their Jacobian in z: design, data, deviations; all else follows them."""
        subject, turning = self.subject, self.subject.turning
        device = subject.device
        sizes = np.cumsum([0, device.size, len(device.constants), len(device.stages)]).tolist()
        phi, z = ca.MX.sym("phi"), ca.MX.sym("z", sizes[-1])
        x, c, d = ca.vertsplit(z, sizes)
        mounted = subject.mounting.function(x, d)
        rows = turning.stated(phi, mounted, c, device.functions.prologue_function(mounted, c))
        outputs = [rows, ca.densify(ca.jacobian(rows, z))]
        return Kernel(ca.Function("output_slopes", [phi, z], outputs, ["phi", "z"], ["rows", "slopes"]), lanes=["phi"])

    def __call__(self, point: Array) -> tuple[Array, Array]:
        """Outputs (k,) at a point (n,) and their slopes (k, n), all in shown units."""
        subject, turning = self.subject, self.subject.turning
        vectors = [vector[0] for vector in subject.vectors(point[None])]
        z = np.concatenate(vectors)
        found = self.kernel(phi=turning.phi, z=z)
        slopes = found["slopes"].reshape(len(turning.keys), len(turning.phi), len(z))[:, :, self._columns]
        values, gradients = [], []
        for measure in subject.measures:
            row, along = self._quantity(turning, found["rows"], slopes, turning.keys.index(measure.key))
            size = units.factor(measure.key)
            values.append(measure.value(row / size, subject.weights))
            gradients.append(measure.slope(row / size, subject.weights) @ (along / size))
        return np.array(values), np.array(gradients) * self._factors

    @staticmethod
    def _quantity(turning: Turning, rows: Array, slopes: Array, place: int) -> tuple[Array, Array]:
        """Samples (n,) of a quantity and their slopes (n, inputs), in SI."""
        if not turning.folded[place]:
            return rows[place], slopes[place]
        return turning.fold(rows[place]), turning.fold(slopes[place].T).T

    @property
    def _columns(self) -> list[int]:
        device = self.subject.device
        begins = {"design": 0, "data": device.size, "deviations": device.size + len(device.constants)}
        return [begins[place.vector] + place.index for place in self.subject.places]

    @property
    def _factors(self) -> Array:
        return np.array([place.factor for place in self.subject.places])
