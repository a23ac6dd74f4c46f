"""The planting device as composed functions: gear stages and dynamics joined, with exact derivatives.

The design vector x holds SI values and radians. `h` is what the carrier angle does not change (the prologue);
derivatives cross that cut as inputs, so no lane is differentiated by the coefficients of a series.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import casadi as ca
import numpy as np

from planter.files import units
from planter.gearing import families
from planter.gearing import stage as gears
from planter.gearing.stage import Candidate, Stage
from planter.kernels import Array, Kernel, generated
from planter.planting.file import Machine
from planter.planting.support_force import SupportForce

Model = Literal["exact", "printed"]
MODELS: tuple[Model, ...] = ("exact", "printed")


@dataclass(frozen=True)
class Prologue:
    """What a design fixes: h, and its Jacobian in the design."""

    x: Array
    h: Array
    dh: Array


class Functions:
    """CasADi functions of a device: a model's dynamics composed with two gear stages."""

    def __init__(self, model: Model, stages: tuple[Stage, Stage]) -> None:
        self.sidecar = generated.sidecar(f"planting_{model}")
        module = generated.module(f"planting_{model}")
        contacts = [stage.contact.function for stage in stages]
        self._stages = stages
        self._split = np.cumsum([0, self._size("mounting"), *(len(s.names) for s in stages)]).tolist()
        self._dynamics = module.prologue(*contacts)
        self._lane, self._events, self._frame = module.lane(*contacts), module.events(*contacts), module.frame()
        self.x = ca.SX.sym("x", self._split[-1])
        self.c = ca.SX.sym("c", self._size("machine"))
        self.phi = ca.SX.sym("phi")
        self.h = ca.SX.sym("h", self.prologue_function.size1_out(0))

    def _size(self, vector: str) -> int:
        return len(self.sidecar["vectors"][vector])

    @cached_property
    def prologue_function(self) -> ca.Function:
        """(x, c) -> h: centre distances and series of both stages, and what the dynamics hoists."""
        x, c = ca.MX.sym("x", self._split[-1]), ca.MX.sym("c", self._size("machine"))
        mounting, *parameters = ca.vertsplit(x, self._split)
        curves = [s.prologue.function(p) for s, p in zip(self._stages, parameters, strict=True)]
        packed = [v for pair in zip(parameters, curves, strict=True) for v in pair]
        dynamics = self._dynamics(mounting, *packed, c)
        return ca.Function("prologue", [x, c], [ca.vertcat(*curves, dynamics)], ["x", "c"], ["h"])

    @cached_property
    def tangent_function(self) -> ca.Function:
        """(x, c) -> h, dh: the prologue and its sparse Jacobian in the design, stage by stage."""
        x, c = ca.MX.sym("x", self._split[-1]), ca.MX.sym("c", self._size("machine"))
        mounting, *parameters = ca.vertsplit(x, self._split)
        curves = [s.prologue.function(p) for s, p in zip(self._stages, parameters, strict=True)]
        along = [s.tangent.function(p, h) for s, p, h in zip(self._stages, parameters, curves, strict=True)]
        packed = [v for pair in zip(parameters, curves, strict=True) for v in pair]
        dynamics, *parts = self._dynamics_tangent(mounting, *packed, c)
        rows = ca.diagcat(ca.MX(0, mounting.numel()), *along)
        for place, curve in enumerate(along):
            parts[1 + place] = parts[1 + place] + parts[3 + place] @ curve
        dh = ca.vertcat(rows, ca.horzcat(*parts[:3]))
        return ca.Function("prologue", [x, c], [ca.vertcat(*curves, dynamics), dh], ["x", "c"], ["h", "dh"])

    @cached_property
    def _dynamics_tangent(self) -> ca.Function:
        """What the dynamics hoist, and its Jacobians in the mounting, in both stages' parameters and their series."""
        inputs = self._dynamics.sx_in()
        mounting, one, first, two, second, _ = inputs
        hoisted = self._dynamics(*inputs)
        along = [ca.jacobian(hoisted, v) for v in (mounting, one, two, first, second)]
        return ca.Function("dynamics_tangent", inputs, [hoisted, *along])

    def lane_inputs(self, phi: ca.SX) -> list[ca.SX]:
        mounting, *parameters = ca.vertsplit(self.x, self._split)
        sizes = [s.prologue.function.size1_out(0) for s in self._stages]
        *curves, dynamics = ca.vertsplit(self.h, np.cumsum([0, *sizes, self._dynamics.size1_out(0)]).tolist())
        packed = [v for pair in zip(parameters, curves, strict=True) for v in pair]
        return [phi, mounting, *packed, self.c, dynamics]

    def side(self, phi: ca.SX) -> ca.SX:
        """What the sidecar lists of a side, at its carrier angle."""
        return self._lane(*self.lane_inputs(phi))

    @cached_property
    def both(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Side 1, side 2 (half a turn behind) and what both do to the frame."""
        one, two = self.side(self.phi), self.side(self.phi - np.pi)
        return one, two, self._frame(one, two, self.c)

    @cached_property
    def events(self) -> ca.SX:
        return self._events(*self.lane_inputs(self.phi))

    @cached_property
    def inputs(self) -> list[ca.SX]:
        return [self.phi, self.x, self.c, self.h]

    def total(self, name: str) -> ca.SX:
        return self.both[2][self._index(name)]

    def frame_total(self, name: str) -> ca.Function:
        """(one, two, c) -> force: one of the totals, from both sides."""
        one, two = (ca.SX.sym(side, self.side(self.phi).numel()) for side in ("one", "two"))
        force = self._frame(one, two, self.c)[self._index(name)]
        return ca.Function("frame_total", [one, two, self.c], [force], ["one", "two", "c"], ["force"])

    def _index(self, name: str) -> int:
        return [entry["name"] for entry in self.sidecar["vectors"]["totals"]].index(name)


class Device:
    """A machine in one of its models. Designs `x` are (p,) arrays in SI; angles in rad, forces in N.

    `kernels` are those that others make of it, once each, by name and by whether it was compiled then.

    Raises GeometryError where the machine's own design, or a corner of its bounds, has no gears.
    """

    def __init__(self, machine: Machine, model: Model = "exact") -> None:
        self.machine, self.model = machine, model
        self.compiled = False
        self.kernels: dict[tuple[str, bool], Kernel] = {}
        self.sidecar = generated.sidecar(f"planting_{model}")
        pair = [
            families.checked(stage.family, f"{machine.source}: stage{i}.family")
            for i, stage in enumerate((machine.stage1, machine.stage2), 1)
        ]
        parts = self._parts(pair)
        self.names: tuple[str, ...] = tuple(name for part in parts for name in part)
        machine.check_names(self.names)
        self.scale = np.array([units.factor(name) for name in self.names])
        self.design = self.scale * [machine.design[name] for name in self.names]
        self.lower, self.upper = self.scale * np.array([machine.bounds[name] for name in self.names]).T
        self.constants = np.array([machine.si(entry["shown"]) for entry in self._vectors["machine"]])
        ends = np.cumsum([len(part) for part in parts])
        first, second = (
            gears.build(family, self._vectors[f"parameters{i}"], self._candidates(slice(ends[i - 1], ends[i])))
            for i, family in enumerate(pair, 1)
        )
        self.stages = first, second
        self.functions = Functions(model, self.stages)

    @property
    def _vectors(self) -> dict[str, Any]:
        vectors: dict[str, Any] = self.sidecar["vectors"]
        return vectors

    def _parts(self, families: list[str]) -> list[tuple[str, ...]]:
        """Names of the design parameters: those of the mounting, then those of each stage."""
        mounting = tuple(entry["shown"] for entry in self._vectors["mounting"])
        return [mounting, *(gears.names(f, self._vectors[f"parameters{i}"]) for i, f in enumerate(families, 1))]

    def _candidates(self, part: slice) -> list[Candidate]:
        """The machine's design, then the corners of its box: what a stage must be able to build."""
        source = self.machine.source
        sides = list(zip(self.lower[part], self.upper[part], strict=True))
        corners = [np.array(corner) for corner in itertools.product(*sides)]
        return [Candidate(self.design[part], lambda name: f"{source}: design.{name}"),
                *(Candidate(corner, lambda name: f"{source}: bounds.{name}") for corner in corners)]  # fmt: skip

    def compile(self) -> None:
        """Run what an optimiser calls again and again in the fastest way that there is here."""
        for kernel in (self.prologue_kernel, self.prologue_hessian_kernel):
            kernel.compile()
        self.force.compile()
        self.compiled = True

    @cached_property
    def force(self) -> SupportForce:
        """The vertical force on the support, with derivatives."""
        return SupportForce(self)

    @property
    def size(self) -> int:
        return len(self.names)

    @cached_property
    def hoisting_kernel(self) -> Kernel:
        """The prologue without derivatives."""
        f = self.functions.prologue_function
        return Kernel(ca.Function("hoisting", f.mx_in(), [f(*f.mx_in())], ["x", "c"], ["h"]))

    @cached_property
    def prologue_kernel(self) -> Kernel:
        return Kernel(self.functions.tangent_function)

    @cached_property
    def prologue_hessian_kernel(self) -> Kernel:
        f = self.functions.prologue_function
        x, c = f.mx_in()
        weights = ca.MX.sym("weights", f.size1_out(0))
        hessian, _ = ca.hessian(ca.dot(weights, f(x, c)), x)
        return Kernel(ca.Function("prologue_hessian", [x, c, weights], [hessian], ["x", "c", "weights"], ["hessian"]))

    def prologue(self, x: Array) -> Prologue:
        found = self.prologue_kernel(x=x, c=self.constants)
        return Prologue(np.asarray(x, dtype=float), found["h"][:, 0], found["dh"])

    @cached_property
    def _cycle(self) -> Kernel:
        names, outputs = ["phi", "x", "c", "h"], ["side1", "side2", "totals"]
        f = ca.Function("cycle", self.functions.inputs, list(self.functions.both), names, outputs)
        return Kernel(f, lanes=["phi"])

    def cycle(self, at: Prologue, phi: Array) -> dict[str, Array]:
        """`side1`, `side2` and `totals` at carrier angles; a row for each quantity of the sidecar."""
        return self._cycle(phi=phi, x=at.x, c=self.constants, h=at.h)

    def prologue_curvature(self, x: Array, weights: Array) -> Array:
        """Hessian (p, p) of weights . h in the design."""
        return self.prologue_hessian_kernel(x=x, c=self.constants, weights=weights)["hessian"]

    def support(self, at: Prologue, phi: Array) -> Array:
        """Vertical support force [N], (n,)."""
        return self.force.value(at, phi)

    def support_slopes(self, at: Prologue, phi: Array) -> tuple[Array, Array]:
        """Vertical support force (n,) and its Jacobian in (phi, x), (n, 1 + p)."""
        return self.force.slopes(at, phi)
