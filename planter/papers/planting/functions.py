"""CasADi functions of a planting device, and the laws of its cam's flanks.

A device composes the dynamics of a model with two gear stages and a flank law. The design vector x
holds SI values and radians. `h` holds the invariants of the carrier angle (the prologue);
derivatives take h as an input, so that no evaluation at an angle differentiates the coefficients of
a series.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal

import casadi as ca
import numpy as np

from planter.gears.geometry.stage import Stage
from planter.kernels import Kernel, generated

Model = Literal["exact", "printed"]
MODELS: tuple[Model, ...] = ("exact", "printed")


class Functions:
    """CasADi functions of a device: a model's dynamics, composed with two gear stages and a law of
    the cam's flanks.
    """

    def __init__(self, model: Model, stages: tuple[Stage, Stage], flank: ca.Function) -> None:
        self.sidecar = generated.sidecar(f"planting_{model}")
        self._module = generated.module(f"planting_{model}")
        contacts = [stage.contact.function for stage in stages]
        self._stages, self._laws = stages, (*contacts, flank)
        self._split = np.cumsum(
            [0, self._size("mounting"), *(len(s.names) for s in stages)]
        ).tolist()
        self._dynamics = self._module.prologue(*contacts)
        self._lane = self._module.lane(*self._laws)
        self.x = ca.SX.sym("x", self._split[-1])
        self.c = ca.SX.sym("c", self._size("machine"))
        self.phi = ca.SX.sym("phi")
        self.h = ca.SX.sym("h", self.prologue_function.size1_out(0))

    @property
    def _hoisted_split(self) -> list[int]:
        """Where the invariants of each stage and of the dynamics begin and end in h."""
        sizes = [stage.prologue.function.size1_out(0) for stage in self._stages]
        ends: list[int] = np.cumsum([0, *sizes, self._dynamics.size1_out(0)]).tolist()
        return ends

    @property
    def stage_titles(self) -> list[str]:
        """Names of the families of both stages."""
        return [stage.sidecar["title"] for stage in self._stages]

    @cached_property
    def frame(self) -> ca.Function:
        return self._module.frame()

    def _size(self, vector: str) -> int:
        return len(self.sidecar["vectors"][vector])

    @cached_property
    def prologue_function(self) -> ca.Function:
        """(x, c) -> h: centre distances and series of both stages, and what the dynamics hoists."""
        x, c = ca.MX.sym("x", self._split[-1]), ca.MX.sym("c", self._size("machine"))
        mounting, *parameters = ca.vertsplit(x, self._split)
        curves = [s.prologue.function(p) for s, p in zip(self._stages, parameters, strict=True)]
        dynamics = self._dynamics(mounting, *_interleave(parameters, curves), c)
        return ca.Function("prologue", [x, c], [ca.vertcat(*curves, dynamics)], ["x", "c"], ["h"])

    @cached_property
    def tangent_function(self) -> ca.Function:
        """(x, c) -> h, dh: the prologue and its sparse Jacobian in the design, stage by stage."""
        x, c = ca.MX.sym("x", self._split[-1]), ca.MX.sym("c", self._size("machine"))
        mounting, *parameters = ca.vertsplit(x, self._split)
        curves = [s.prologue.function(p) for s, p in zip(self._stages, parameters, strict=True)]
        tangents = [
            s.tangent.function(p, h)
            for s, p, h in zip(self._stages, parameters, curves, strict=True)
        ]
        dynamics, *parts = self._dynamics_tangent(mounting, *_interleave(parameters, curves), c)
        rows = ca.diagcat(ca.MX(0, mounting.numel()), *tangents)
        for stage, curve in enumerate(tangents):
            parts[1 + stage] = parts[1 + stage] + parts[3 + stage] @ curve
        dh = ca.vertcat(rows, ca.horzcat(*parts[:3]))
        return ca.Function(
            "prologue", [x, c], [ca.vertcat(*curves, dynamics), dh], ["x", "c"], ["h", "dh"]
        )

    @cached_property
    def _dynamics_tangent(self) -> ca.Function:
        """Return the invariants of the dynamics and their Jacobians in mounting, stages' parameters
        and series.
        """
        inputs = self._dynamics.sx_in()
        mounting, parameters1, series1, parameters2, series2, _ = inputs
        hoisted = self._dynamics(*inputs)
        jacobians = [
            ca.jacobian(hoisted, v) for v in (mounting, parameters1, parameters2, series1, series2)
        ]
        return ca.Function("dynamics_tangent", inputs, [hoisted, *jacobians])

    @cached_property
    def data_tangent_function(self) -> ca.Function:
        """(x, c, h) -> the sparse Jacobian of the prologue h in the data c, which the stages do not
        depend on.
        """
        inputs = self._dynamics.sx_in()
        data_jacobian = ca.Function(
            "along_data", inputs, [ca.jacobian(self._dynamics(*inputs), inputs[-1])]
        )
        x, c, h = (
            ca.MX.sym(n, v.numel()) for n, v in zip("xch", (self.x, self.c, self.h), strict=True)
        )
        mounting, *parameters = ca.vertsplit(x, self._split)
        *curves, dynamics = ca.vertsplit(h, self._hoisted_split)
        changes = data_jacobian(mounting, *_interleave(parameters, curves), c)
        rows = ca.vertcat(ca.MX(h.numel() - dynamics.numel(), c.numel()), changes)
        return ca.Function("data_tangent", [x, c, h], [rows], ["x", "c", "h"], ["dh"])

    def lane_inputs(self, phi: ca.SX) -> list[ca.SX]:
        """Return the inputs of the lane function at a carrier angle."""
        mounting, *parameters = ca.vertsplit(self.x, self._split)
        *curves, dynamics = ca.vertsplit(self.h, self._hoisted_split)
        return [phi, mounting, *_interleave(parameters, curves), self.c, dynamics]

    def side(self, phi: ca.SX) -> ca.SX:
        """Return the quantities that the sidecar lists of a side, at its carrier angle."""
        return self._lane(*self.lane_inputs(phi))

    @cached_property
    def both(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Side 1, side 2 (half a turn behind) and what both do to the frame."""
        first, second = self.side(self.phi), self.side(self.phi - np.pi)
        return first, second, self.frame(first, second, self.c)

    @cached_property
    def events(self) -> ca.SX:
        return self._module.events(*self._laws)(*self.lane_inputs(self.phi))

    @cached_property
    def inputs(self) -> list[ca.SX]:
        return [self.phi, self.x, self.c, self.h]


def _interleave(parameters: Sequence[Any], curves: Sequence[Any]) -> list[Any]:
    """Return the parameters of each stage followed by its invariants."""
    return [part for pair in zip(parameters, curves, strict=True) for part in pair]


_FLANK_PREFIX = "flank_"
_BESIDE = 1e-7
"""How far beside a position the derivatives of a law are taken."""
_JUMP = 1e-2
"""A derivative that differs by less on both sides of a position is continuous there; those of a law
are from 1 up.
"""
SECOND = 2
"""Forces follow the second derivative of a law."""


@cache
def _flank_modules() -> dict[str, str]:
    return {generated.sidecar(name)["title"]: name for name in generated.names(_FLANK_PREFIX)}


def list_flank_laws() -> tuple[str, ...]:
    """Names of the laws."""
    return tuple(_flank_modules())


def find_flank_module(name: str) -> str:
    """The generated module of a law."""
    return _flank_modules()[name]


@cache
def build_flank_function(name: str) -> ca.Function:
    """x -> p, dp, ddp: share of the rise at a position x in [0, 1] of the flank, and its slopes."""
    law = generated.module(find_flank_module(name)).law()
    x = ca.SX.sym("x")
    return ca.Function("flank", [x], ca.vertsplit(law(x)), ["x"], ["p", "dp", "ddp"])


@dataclass(frozen=True)
class FlankBreakpoint:
    """A position in a flank, and the order of the first derivative of the forces in the angle that
    jumps there.
    """

    position: float
    order: int


@cache
def find_flank_breakpoints(name: str, positions: tuple[float, ...]) -> tuple[FlankBreakpoint, ...]:
    """Return the positions in [0, 1] at which a law, at rest before and after, is not smooth: jumps
    up to order 2.
    """
    x = ca.SX.sym("x")
    derivatives = [build_flank_function(name)(x)[SECOND]]
    for _ in range(2):
        derivatives.append(ca.jacobian(derivatives[-1], x))
    values = Kernel(
        ca.Function("derivatives", [x], [ca.densify(ca.vertcat(*derivatives))], ["x"], ["jets"]),
        lanes=["x"],
    )
    neighbours = np.add.outer(np.array(positions), [-_BESIDE, _BESIDE])
    jets = values(x=np.clip(neighbours, 0, 1).ravel())["jets"].reshape(
        len(derivatives), *neighbours.shape
    )
    jets = np.where((neighbours < 0) | (neighbours > 1), 0.0, jets)
    jumps = np.abs(jets[..., 1] - jets[..., 0]) > _JUMP
    return tuple(
        FlankBreakpoint(x, int(order.argmax()))
        for x, order in zip(positions, jumps.T, strict=True)
        if order.any()
    )
