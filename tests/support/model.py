"""A generated model's outputs by name: through its array code over any module of elementary
functions, or a device.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np

from planter.papers.planting import functions
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device

Number = Any
Named = dict[str, Number]


@dataclass(frozen=True)
class Outputs:
    """Of both sides, and of what they share."""

    side1: Named
    side2: Named
    totals: Named

    @property
    def sides(self) -> tuple[Named, Named]:
        return self.side1, self.side2


def _named(device: Device, **vectors: Sequence[Number]) -> Outputs:
    def by_name(vector: str, values: Sequence[Number]) -> Named:
        return dict(
            zip((entry["name"] for entry in device.sidecar["vectors"][vector]), values, strict=True)
        )

    side = partial(by_name, "side")
    return Outputs(
        side(vectors["side1"]), side(vectors["side2"]), by_name("totals", vectors["totals"])
    )


def cycle(device: Device, phi: Number) -> Outputs:
    """Of a device at its own design."""
    return _named(device, **device.cycle(device.prologue(device.design), np.atleast_1d(phi)))


def array_module(name: str) -> ModuleType:
    return importlib.import_module(f"generated.array.{name}")


@dataclass(frozen=True)
class ArrayModel:
    """The array code of a device, put together as its CasADi functions are; `terms` is the length
    of both series.
    """

    device: Device
    terms: tuple[int, int]

    @classmethod
    def like(cls, device: Device) -> ArrayModel:
        return cls(device, (device.stages[0].terms, device.stages[1].terms))

    def __call__(
        self, xp: ModuleType, phi: Number, design: Sequence[Number], constants: Sequence[Number]
    ) -> Outputs:
        code = array_module(_code(self.device.model))
        curves = [array_module(f"curve_{stage.family}") for stage in self.device.stages]
        mounting, *parameters = self._parts(design)
        packed = [mounting]
        for curve, curve_parameters, terms in zip(curves, parameters, self.terms, strict=True):
            packed += [curve_parameters, curve.prologue(xp, curve_parameters, terms)]
        stages = [curve.contact for curve in curves]
        hoisted = code.prologue(xp, *packed, constants, *stages)
        flank = array_module(functions.find_flank_module(self.device.machine.cam.flank)).law
        lanes = [
            code.lane(xp, angle, *packed, constants, hoisted, *stages, flank)
            for angle in (phi, phi - xp.pi)
        ]
        totals = code.frame(xp, *lanes, constants)
        return _named(self.device, side1=lanes[0], side2=lanes[1], totals=totals)

    def _parts(self, design: Sequence[Number]) -> list[Sequence[Number]]:
        first = len(self.device.sidecar["vectors"]["mounting"])
        second = first + len(self.device.stages[0].names)
        return [design[:first], design[first:second], design[second:]]


def _code(model: Model) -> str:
    return f"planting_{model}"
