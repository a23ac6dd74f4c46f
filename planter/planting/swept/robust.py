"""The objective of a planting device over machines as their tolerances make them."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel
from planter.planting.file import Machine
from planter.planting.functions import Model
from planter.planting.requirements.constraints import Required
from planter.planting.swept.subject import Planting
from planter.planting.turns import Turns
from planter.tolerance.robust import RobustObjective, draw_inputs
from planter.tolerance.room import Settings
from planter.tolerance.spread import Spread

DESIGN = "design."
SLICES = 4
"""Parts of the machines that are found beside one another."""


class Robust(RobustObjective):
    """The objective over machines that are drawn once, as a function of the design x (p,) [SI]."""

    def __init__(self, machine: Machine, model: Model, spreads: Mapping[str, Spread], settings: Settings) -> None:
        super().__init__()
        # A design's deviations leave the file's bounds by little; those are what its gears are checked on.
        others = {name: one for name, one in spreads.items() if not name.startswith(DESIGN)}
        ends = {name: (one.low, one.high) for name, one in others.items()}
        self.subject = Planting(machine, model, ends, [])
        self.device = device = self.subject.device
        self.turns = Turns(device)
        self.design, self.lower, self.upper = device.design, device.lower, device.upper
        self.samples, self.limits = self.turns.samples, Required.of(device)
        drawn = draw_inputs(spreads, settings)
        values = np.column_stack([np.empty((settings.machines, 0)), *(drawn[name] for name in others)])
        _, self.data, self.deviations = self.subject.vectors(values)
        self.moved = self._moved({name: drawn[name] - one.centre for name, one in spreads.items()})

    def _moved(self, apart: Mapping[str, Array]) -> Array:
        """What the machines' designs have beyond the one that was meant, (m, p) [SI]."""
        found = np.zeros((len(self.data), self.device.size))
        for j, (name, scale) in enumerate(zip(self.device.names, self.device.scale, strict=True)):
            found[:, j] = apart.get(f"{DESIGN}{name}", 0.0) * scale
        return found

    @cached_property
    def _mounted(self) -> Kernel:
        """(x, d) -> the mounted design and its Jacobian in x."""
        function = self.subject.mounting.function
        x, d = function.sx_in()
        mounted = function(x, d)
        outputs = [mounted, ca.densify(ca.jacobian(mounted, x))]
        return Kernel(
            ca.Function("mounted_slopes", [x, d], outputs, ["x", "d"], ["mounted", "slopes"]), lanes=["x", "d"]
        )

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Return the objective (m,) of each machine, and its gradients (m, p)."""
        designs = x + self.moved
        found = self._mounted(x=designs.T, d=self.deviations.T)
        chain = found["slopes"].reshape(len(x), len(designs), len(x)).transpose(1, 0, 2)
        values, gradients = self._found(found["mounted"].T)
        return values, np.einsum("mk,mkj->mj", gradients, chain)

    def nominal(self, x: Array) -> tuple[float, Array]:
        """Return the objective without tolerances, and its gradient (p,)."""
        return self.turns.gradient(x)

    def named(self, x: Array) -> dict[str, float]:
        """Return a design by the names of the file, in its units."""
        return self.device.named(x)

    def _found(self, designs: Array) -> tuple[Array, Array]:
        parts = np.array_split(np.arange(len(designs)), SLICES)
        with ThreadPoolExecutor(SLICES) as pool:
            found = list(pool.map(lambda rows: self.turns.gradients(designs[rows], self.data[rows]),
                                  [rows for rows in parts if len(rows)]))  # fmt: skip
        values, gradients = zip(*found, strict=True)
        return np.concatenate(values), np.vstack(gradients)
