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

from planter import emitted, gears, units
from planter.gears import Candidate, Stage
from planter.kernels import Array, Kernel
from planter.machine import Machine

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
        self.sidecar = emitted.sidecar(f"planting_{model}")
        module = emitted.module(f"planting_{model}")
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

    def lane_inputs(self, phi: ca.SX) -> list[ca.SX]:
        mounting, *parameters = ca.vertsplit(self.x, self._split)
        sizes = [s.prologue.function.size1_out(0) for s in self._stages]
        *curves, dynamics = ca.vertsplit(self.h, np.cumsum([0, *sizes, self._dynamics.size1_out(0)]).tolist())
        packed = [v for pair in zip(parameters, curves, strict=True) for v in pair]
        return [phi, mounting, *packed, self.c, dynamics]

    @cached_property
    def both(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Side 1, side 2 (half a turn behind) and what both do to the frame."""
        one, two = (self._lane(*self.lane_inputs(phi)) for phi in (self.phi, self.phi - np.pi))
        return one, two, self._frame(one, two, self.c)

    @cached_property
    def events(self) -> ca.SX:
        return self._events(*self.lane_inputs(self.phi))

    @cached_property
    def inputs(self) -> list[ca.SX]:
        return [self.phi, self.x, self.c, self.h]

    def total(self, name: str) -> ca.SX:
        return self.both[2][[entry["name"] for entry in self.sidecar["vectors"]["totals"]].index(name)]


class Device:
    """A machine in one of its models. Designs `x` are (p,) arrays in SI; angles in rad, forces in N.

    Raises GeometryError where the machine's own design, or a corner of its bounds, has no gears.
    """

    def __init__(self, machine: Machine, model: Model = "exact") -> None:
        self.machine, self.model = machine, model
        self.compiled = False
        self.sidecar = emitted.sidecar(f"planting_{model}")
        families = [
            emitted.family(stage.family, f"{machine.source}: stage{i}.family")
            for i, stage in enumerate((machine.stage1, machine.stage2), 1)
        ]
        parts = self._parts(families)
        self.names: tuple[str, ...] = tuple(name for part in parts for name in part)
        machine.check_names(self.names)
        self.scale = np.array([units.factor(name) for name in self.names])
        self.design = self.scale * [machine.design[name] for name in self.names]
        self.lower, self.upper = self.scale * np.array([machine.bounds[name] for name in self.names]).T
        self.constants = np.array([machine.si(entry["shown"]) for entry in self._vectors["machine"]])
        ends = np.cumsum([len(part) for part in parts])
        first, second = (
            gears.build(family, self._vectors[f"parameters{i}"], self._candidates(slice(ends[i - 1], ends[i])))
            for i, family in enumerate(families, 1)
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
        """Run what an optimiser calls again and again in machine code, where there is a C compiler."""
        for kernel in (self._support, self._slopes, self._hessian_sum):
            kernel.compile()
        self.compiled = True

    @property
    def size(self) -> int:
        return len(self.names)

    @cached_property
    def _prologue(self) -> Kernel:
        f = self.functions.prologue_function
        x, c = f.mx_in()
        h = f(x, c)
        return Kernel(ca.Function("prologue", [x, c], [h, ca.jacobian(h, x)], ["x", "c"], ["h", "dh"]))

    @cached_property
    def _prologue_hessian(self) -> Kernel:
        f = self.functions.prologue_function
        x, c = f.mx_in()
        weights = ca.MX.sym("weights", f.size1_out(0))
        hessian, _ = ca.hessian(ca.dot(weights, f(x, c)), x)
        return Kernel(ca.Function("prologue_hessian", [x, c, weights], [hessian], ["x", "c", "weights"], ["hessian"]))

    def prologue(self, x: Array) -> Prologue:
        found = self._prologue(x=x, c=self.constants)
        return Prologue(np.asarray(x, dtype=float), found["h"][:, 0], found["dh"])

    def _lane_kernel(self, name: str, outputs: dict[str, ca.SX]) -> Kernel:
        names = ["phi", "x", "c", "h"]
        f = ca.Function(name, self.functions.inputs, list(outputs.values()), names, list(outputs))
        return Kernel(f, lanes=["phi"])

    @cached_property
    def _cycle(self) -> Kernel:
        return self._lane_kernel("cycle", dict(zip(("side1", "side2", "totals"), self.functions.both, strict=True)))

    @cached_property
    def _support(self) -> Kernel:
        return self._lane_kernel("support", {"force": self.functions.total("F_support")})

    @cached_property
    def _slopes(self) -> Kernel:
        force = self.functions.total("F_support")
        phi, x, _, h = self.functions.inputs
        return self._lane_kernel("slopes", {"force": force, "g": ca.gradient(force, ca.vertcat(phi, x, h))})

    def _hessian_kernel(self, summed: bool) -> Kernel:
        """Weighted Hessian in (phi, x) along the prologue's tangent, and the weighted slope in h."""
        phi, x, c, h = self.functions.inputs
        support = ca.Function("force", [phi, x, c, h], [self.functions.total("F_support")])
        step, weight = ca.SX.sym("step", self.size), ca.SX.sym("weight")
        dh = ca.SX.sym("dh", h.numel(), self.size)
        tangent = ca.project(dh, self.functions.prologue_function.jac_sparsity(0, 0))
        force = weight * support(phi, x + step, c, h + tangent @ step)
        z = ca.vertcat(phi, step)
        hessian, _ = ca.hessian(force, z)
        slope = weight * ca.gradient(support(phi, x, c, h), h)
        at_zero = ca.Function("hessian", [phi, weight, x, c, h, dh, step], [ca.vec(ca.densify(hessian)), slope])
        outputs = at_zero(phi, weight, x, c, h, dh, ca.SX.zeros(self.size))
        f = ca.Function("hessian", [phi, weight, x, c, h, dh], list(outputs),
                        ["phi", "weight", "x", "c", "h", "dh"], ["hessian", "slope"])  # fmt: skip
        return Kernel(f, lanes=["phi", "weight"], summed=summed)

    @cached_property
    def _hessian_sum(self) -> Kernel:
        return self._hessian_kernel(summed=True)

    @cached_property
    def _hessian_rows(self) -> Kernel:
        return self._hessian_kernel(summed=False)

    def _at(self, at: Prologue) -> dict[str, Array]:
        return {"x": at.x, "c": self.constants, "h": at.h}

    def cycle(self, at: Prologue, phi: Array) -> dict[str, Array]:
        """`side1`, `side2` and `totals` at carrier angles; a row for each quantity of the sidecar."""
        return self._cycle(phi=phi, **self._at(at))

    def support(self, at: Prologue, phi: Array) -> Array:
        """Vertical support force [N], (n,)."""
        return self._support(phi=phi, **self._at(at))["force"][0]

    def support_slopes(self, at: Prologue, phi: Array) -> tuple[Array, Array]:
        """Vertical support force (n,) and its Jacobian in (phi, x), (n, 1 + p)."""
        found = self._slopes(phi=phi, **self._at(at))
        g = found["g"].T
        along_phi, along_x, along_h = np.split(g, [1, 1 + self.size], axis=1)
        return found["force"][0], np.hstack([along_phi, along_x + along_h @ at.dh])

    def support_hessian(self, at: Prologue, phi: Array, weights: Array) -> Array:
        """Weighted sum over the angles of the Hessian of the support force in (phi, x), (1 + p, 1 + p)."""
        found = self._hessian_sum(phi=phi, weight=weights, dh=at.dh, **self._at(at))
        return self._with_prologue(at, found["hessian"][:, 0], found["slope"][:, 0])

    def support_hessians(self, at: Prologue, phi: Array) -> Array:
        """Hessian of the support force in (phi, x) at each angle, (n, 1 + p, 1 + p)."""
        found = self._hessian_rows(phi=phi, weight=np.ones(len(phi)), dh=at.dh, **self._at(at))
        columns = zip(found["hessian"].T, found["slope"].T, strict=True)
        return np.array([self._with_prologue(at, hessian, slope) for hessian, slope in columns])

    def _with_prologue(self, at: Prologue, hessian: Array, slope: Array) -> Array:
        curved = self._prologue_hessian(x=at.x, c=self.constants, weights=slope)["hessian"]
        full = hessian.reshape(1 + self.size, 1 + self.size).copy()
        full[1:, 1:] += curved
        return full
