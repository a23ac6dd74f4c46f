"""Lengths of pitch curves as equations of an optimisation: pi m z of each stage that has whole teeth."""

from __future__ import annotations

import copy
import itertools

import numpy as np

from planter.gear_geometry.stage import PitchLength, StageCandidate
from planter.kernels import Array
from planter.numerics.arrays import Flags, Integers
from planter.optimise.constraints import Constraints, Named
from planter.planting.model import Device
from planter.planting.whole.wanted import Wanted

STEP = 1e-3
"""What a miss of a length counts one step for [m]."""


class Lengths(Constraints):
    """A row for each stage that has whole teeth: the length of its pitch curve; designs x are (p,) in SI.

    They do not give way: what cannot be kept beside them is told instead.
    """

    def __init__(self, device: Device, wanted: Wanted) -> None:
        self.device = device
        self.places = [places(device, k) for k in wanted.stages]
        self.lengths = [pitch_length(device, k) for k in wanted.stages]
        self.kinds = [Named(name(k), ("min", "max"), "mm", STEP * 1e3) for k in wanted.stages]
        self.owner: Integers = np.arange(len(self.kinds))
        self._want(wanted)

    def _want(self, wanted: Wanted) -> None:
        self.wanted = wanted
        self.lower = self.upper = np.array([wanted.length(k) for k in wanted.stages]) / STEP

    def of(self, wanted: Wanted) -> Lengths:
        """Those of other teeth on the same stages."""
        found = copy.copy(self)
        found._want(wanted)
        return found

    @property
    def giving(self) -> Flags:
        return np.zeros(len(self.kinds), dtype=bool)

    @property
    def equations(self) -> Lengths:
        return self

    def measured(self, x: Array) -> list[float]:
        """The lengths at a design (p,) [m]."""
        return [length.at(x[at]).value for length, at in zip(self.lengths, self.places, strict=True)]

    def values(self, x: Array) -> Array:
        return np.array(self.measured(x)) / STEP

    def slopes(self, x: Array) -> Array:
        rows = np.zeros((len(self.lengths), len(x)))
        for row, length, at in zip(rows, self.lengths, self.places, strict=True):
            row[at] = length.at(x[at]).gradient / STEP
        return rows

    def curvature(self, x: Array, weights: Array) -> Array:
        total = np.zeros((len(x), len(x)))
        for weight, length, at in zip(weights, self.lengths, self.places, strict=True):
            total[np.ix_(at, at)] += weight / STEP * length.at(x[at]).hessian
        return total


def name(stage: int) -> str:
    """Of the equation of a stage, as results show it."""
    return f"pitch_length_{stage + 1}"


def places(device: Device, stage: int) -> Integers:
    """Places of a stage's parameters in the design vector."""
    return device.of_stage(stage, np.arange(device.size, dtype=float)).astype(np.int64)


def pitch_length(device: Device, stage: int) -> PitchLength:
    """The length of a stage's pitch curve, right to rounding at the device's design and at the corners of its box."""
    at, source = places(device, stage), device.machine.source
    corners = itertools.product(*zip(device.lower[at], device.upper[at], strict=True))
    own = StageCandidate(device.design[at], lambda key: f"{source}: design.{key}")
    every = [own, *(StageCandidate(np.array(corner), lambda key: f"{source}: bounds.{key}") for corner in corners)]
    found = PitchLength(device.stages[stage], every)
    if device.compiled:
        found.compile()
    return found
