"""Robust designs: the mean plus k standard deviations of the objective over machines as their tolerances make them.

The machines are drawn once, so that the sum is a function of the design alone. Of objectives J_i with gradients G_i,

    f = mean J + k s,   f' = mean G + k / (n s) sum (J_i - mean J) G_i,   s^2 = 1/n sum (J_i - mean J)^2,

where an extreme stays at its sample, as in every gradient of a sampled objective.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel
from planter.numerics.latest import Latest
from planter.optimise.spread import Variance
from planter.planting.file import Machine
from planter.planting.functions import Model
from planter.planting.swept.subject import Planting
from planter.planting.turns import Turns
from planter.sweeps.points import SobolSequence
from planter.tolerance.results import Scored
from planter.tolerance.room import Settings
from planter.tolerance.spread import Spread

DESIGN = "design."
SLICES = 4
"""Parts of the machines that are found beside one another."""
ROUNDING = 1e-12
"""Share of the mean below which machines differ by rounding alone: their deviation has no slope then."""


@dataclass(frozen=True)
class Value:
    """Mean and standard deviation of the objective over the machines, and their gradients (p,) in the design [1/SI]."""

    mean: float
    std: float
    mean_slope: Array
    std_slope: Array


class Robust:
    """The objective over machines that are drawn once, as a function of the design x (p,) [SI]."""

    def __init__(self, machine: Machine, model: Model, spreads: Mapping[str, Spread], settings: Settings) -> None:
        # A design's deviations leave the file's bounds by little; those are what its gears are checked on.
        others = {name: one for name, one in spreads.items() if not name.startswith(DESIGN)}
        ends = {name: (one.low, one.high) for name, one in others.items()}
        self.subject = Planting(machine, model, ends, [])
        self.device, self.turns = self.subject.device, Turns(self.subject.device)
        drawn = _drawn(spreads, settings)
        values = np.column_stack([np.empty((settings.machines, 0)), *(drawn[name] for name in others)])
        _, self.data, self.deviations = self.subject.vectors(values)
        self.moved = self._moved({name: drawn[name] - one.centre for name, one in spreads.items()})
        self.at = Latest(self._value)

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

    def _value(self, x: Array) -> Value:
        designs = x + self.moved
        found = self._mounted(x=designs.T, d=self.deviations.T)
        chain = found["slopes"].reshape(len(x), len(designs), len(x)).transpose(1, 0, 2)
        values, gradients = self._found(found["mounted"].T)
        slopes = np.einsum("mk,mkj->mj", gradients, chain)
        variance = Variance(values)
        std = float(np.sqrt(variance.value))
        felt = std > ROUNDING * abs(variance.mean)
        std_slope = variance.gradient(slopes) / (2 * std) if felt else np.zeros(len(x))
        return Value(variance.mean, std, slopes.mean(axis=0), std_slope)

    def _found(self, designs: Array) -> tuple[Array, Array]:
        parts = np.array_split(np.arange(len(designs)), SLICES)
        with ThreadPoolExecutor(SLICES) as pool:
            found = list(pool.map(lambda rows: self.turns.gradients(designs[rows], self.data[rows]),
                                  [rows for rows in parts if len(rows)]))  # fmt: skip
        values, gradients = zip(*found, strict=True)
        return np.concatenate(values), np.vstack(gradients)

    def value(self, x: Array, sigmas: float) -> tuple[float, Array]:
        """Mean plus so many standard deviations at x, and the gradient (p,) [1/SI]."""
        found = self.at(x)
        return found.mean + sigmas * found.std, found.mean_slope + sigmas * found.std_slope

    def scored(self, x: Array, sigmas: float) -> Scored:
        """A design as results show it."""
        found = self.at(x)
        return Scored(self.device.named(x), self.turns.value(x), found.mean, found.std, found.mean + sigmas * found.std)


def _drawn(spreads: Mapping[str, Spread], settings: Settings) -> dict[str, Array]:
    """Values (m,) of each input: points of a Sobol' sequence, spread out."""
    if not spreads:
        return {}
    cube = SobolSequence(len(spreads), settings.seed)(0, settings.machines)
    return {name: one.at(shares) for (name, one), shares in zip(spreads.items(), cube.T, strict=True)}
