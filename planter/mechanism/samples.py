"""Quantities over a turn as functions of the design, with exact derivatives; loops closed at every sample.

The generated functions take the coordinates of loops as they were found and carry their derivatives themselves, so that
what is differentiated here never sees an iteration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.errors import ComputationError
from planter.files import units
from planter.kernels import Array, Kernel
from planter.mechanism.file import MechanismFile
from planter.mechanism.loops import Loops
from planter.mechanism.model import Model
from planter.numerics.latest import Latest

HOISTED = "hoisted"


@dataclass(frozen=True)
class Sampled:
    """Outputs (m, n) at a design in shown units, their Jacobians (m, n, p) in the design, and what curves them."""

    values: Array
    slopes: Array
    _inputs: dict[str, Array]
    _bent: Kernel

    def curvature(self, weights: Array) -> Array:
        """Weighted sum (p, p) of all Hessians, weights (m, n)."""
        size = self.slopes.shape[2]
        found: Array = self._bent(**self._inputs, weights=weights)["bent"].sum(axis=1).reshape(size, size)
        return found


class Samples:
    """Outputs by name at angles (n,) [rad] over designs x (p,): values of the file's bounded quantities, in SI."""

    def __init__(self, file: MechanismFile, names: Sequence[str], angles: Array) -> None:
        self.file, self.model, self.angles = file, Model(file), angles
        entries = {entry["name"]: entry for entry in self.model.outputs}
        keys = [units.key(name, entries[name]["unit"]) for name in names]
        self._picked = [list(entries).index(name) for name in names]
        self._shown = np.array([units.factor(key) for key in keys])
        moved = [entry["shown"].rpartition(".")[2] for entry in file.entries]
        self._design = [moved.index(key) for key in file.bounds]
        self._latest = Latest(self._sampled)
        self._nearby: Array | None = None

    @property
    def design(self) -> Array:
        """The file's own design, (p,)."""
        return self.model.data[self._design]

    def __call__(self, x: Array) -> Sampled:
        """Raises ComputationError where loops do not close."""
        return self._latest(x)

    def data(self, x: Array) -> Array:
        """All values in SI at a design."""
        data = self.model.data.copy()
        data[self._design] = x
        return data

    def _sampled(self, x: Array) -> Sampled:
        inputs = {self.model.angle: self.angles, "x": x, "loops": self._places(x)}
        inputs = {name: value for name, value in inputs.items() if name in self._slopes.names}
        found = self._slopes(**inputs)
        count, size = len(self._picked), len(x)
        slopes = found["slopes"].reshape(size, count, -1).transpose(1, 2, 0)
        if not (np.isfinite(found["values"]).all() and np.isfinite(slopes).all()):
            raise ComputationError(f"{self.file.name}: forces are not determined everywhere on the turn")
        return Sampled(found["values"], slopes, inputs, self._bent)

    def _places(self, x: Array) -> Array:
        """Coordinates of the loops (k, n); found near those of the design before, else by a walk along the turn."""
        if self.model.loops is None:
            return np.empty((0, len(self.angles)))
        loops = Loops(self.model.formulas, self.data(x))
        if self._nearby is not None and (found := loops.near(self.angles, self._nearby)) is not None:
            self._nearby = found
            return found
        self._nearby = loops.at(self.angles)
        return self._nearby

    @cached_property
    def _symbols(self) -> tuple[list[ca.SX], list[str], ca.SX, ca.SX]:
        """Inputs with names, the design, the outputs (m,) in shown units."""
        formulas = self.model.formulas
        lane = formulas.function("lane")
        given = {name: ca.SX.sym(name, lane.size1_in(name)) for name in lane.name_in() if name not in ("data", HOISTED)}
        x, data = ca.SX.sym("x", len(self._design)), ca.SX(self.model.data)
        for j, place in enumerate(self._design):
            data[place] = x[j]
        whole = given | {"data": data}
        if HOISTED in lane.name_in():
            prologue = formulas.function("prologue")
            whole[HOISTED] = prologue(*(whole[name] for name in prologue.name_in()))
        outputs = lane(*(whole[name] for name in lane.name_in()))
        return [*given.values(), x], [*given, "x"], x, outputs[self._picked] / self._shown

    @cached_property
    def _slopes(self) -> Kernel:
        inputs, names, x, outputs = self._symbols
        slopes = ca.densify(ca.vec(ca.jacobian(outputs, x)))
        function = ca.Function("slopes", inputs, [outputs, slopes], names, ["values", "slopes"])
        return Kernel(function, lanes=[name for name in names if name != "x"])

    @cached_property
    def _bent(self) -> Kernel:
        inputs, names, x, outputs = self._symbols
        weights = ca.SX.sym("weights", len(self._picked))
        bent = ca.densify(ca.vec(ca.hessian(ca.dot(weights, outputs), x)[0]))
        function = ca.Function("bent", [*inputs, weights], [bent], [*names, "weights"], ["bent"])
        return Kernel(function, lanes=[name for name in (*names, "weights") if name != "x"])
