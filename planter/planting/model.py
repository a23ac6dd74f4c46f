"""The planting device: a machine in one of its models, with its design vector and its kernels."""

from __future__ import annotations

import itertools
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.files import units
from planter.gearing import families, stage
from planter.gearing.stage import Candidate
from planter.kernels import Array, Kernel, generated
from planter.planting.file import Machine
from planter.planting.functions import Functions, Model, Prologue
from planter.planting.support_force import SupportForce


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
            stage.build(family, self._vectors[f"parameters{i}"], self._candidates(slice(ends[i - 1], ends[i])))
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
        return [mounting, *(stage.names(f, self._vectors[f"parameters{i}"]) for i, f in enumerate(families, 1))]

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
