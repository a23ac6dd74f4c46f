"""The support force of a built-in planting device in both of its models: over a turn, at its optimum, where it is felt.

Every result carries the inputs that its paper does not disclose.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from planter.audit.registry import Inputs, formula
from planter.files.units import factor
from planter.kernels import Array
from planter.planting import cycle, optimisation
from planter.planting.file import Machine, load
from planter.planting.functions import MODELS, Model
from planter.planting.model import Device
from planter.planting.objective import build_problem
from planter.planting.optimisation import DeviceOptimum

_IDLE = ("design", "bounds", "genetic_algorithm", "operation.forward_speed_m_s", "nozzle.tip_distance_mm")
"""What of a machine does not bear on the force of its own design, or is no input of it."""


@dataclass(frozen=True)
class Both:
    """A machine in both of its models."""

    machine: Machine

    @cached_property
    def devices(self) -> dict[Model, Device]:
        return {model: Device(self.machine, model) for model in MODELS}

    @cached_property
    def angles(self) -> Array:
        """Carrier angles of the machine's own samples [rad], (n,)."""
        return cycle.sample_angles(self.machine.objective.samples)

    @cached_property
    def turns(self) -> dict[Model, cycle.DeviceCycleTable]:
        """A turn of the machine's own design in each model."""
        return {model: cycle.evaluate_cycle(d, d.prologue(d.design), self.angles) for model, d in self.devices.items()}

    @cached_property
    def optima(self) -> dict[Model, DeviceOptimum]:
        """The optimum of each model, by IPOPT from the machine's own design."""
        return {model: optimisation.search_optimum(device, "ipopt", starts=1) for model, device in self.devices.items()}

    def headlines(self, model: Model) -> dict[str, float]:
        """True extremes, range, mean, variance and objective of the machine's own design."""
        device = self.devices[model]
        found = build_problem(device).score(device.design)
        look = found.look
        return {"max_N": look.high, "min_N": look.low, "range_N": look.range, "mean_N": look.mean,
                "variance_N2": look.variance, "objective": found.objective}  # fmt: skip

    def score(self, model: Model, x: Array) -> float:
        """Objective of a design x (p,) in a model."""
        return build_problem(self.devices[model]).score(x).objective

    def support_with(self, model: Model, values: Mapping[str, float]) -> Array:
        """Support force [N] of the machine's own design with other values of some of its inputs, in shown units."""
        device = Device(self.machine, model)
        shown = [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]
        for path, value in values.items():
            device.constants[shown.index(path)] = value * factor(path)
        return cycle.evaluate_cycle(device, device.prologue(device.design), self.angles).support

    @property
    def assumptions(self) -> list[str]:
        """Numbers of the machine that its paper does not give, and that bear on the force."""
        numbers = self.machine.numbers()
        return [
            f"{path} = {numbers[path]:g}"
            for path, origin in self.machine.number_origins().items()
            if not path.startswith(_IDLE) and not origin.startswith("paper")
        ]


@cache
def both(name: str) -> Both:
    """A built-in machine in both of its models."""
    return Both(load(name))


def felt(name: str, model: Model, paths: Sequence[str], share: float) -> float:
    """Largest change of the support force [N] when some inputs of a machine grow by a share, all at once."""
    machine = both(name)
    numbers = machine.machine.numbers()
    changed = machine.support_with(model, {path: numbers[path] * (1 + share) for path in paths})
    return float(abs(changed - machine.turns[model].support).max())


@formula("support force")
def support_force(inputs: Inputs) -> float:
    """True extreme or variance of the support force in the printed model of a built-in machine."""
    return _assuming(inputs).headlines("printed")[inputs["part"]]


@formula("optimum")
def optimum(inputs: Inputs) -> float:
    """A design parameter at the optimum of the printed model, in the unit that it is shown in."""
    machine = _assuming(inputs)
    device = machine.devices["printed"]
    shown = device.named(machine.optima["printed"].design)
    return shown[inputs["parameter"]]


def _assuming(inputs: Inputs) -> Both:
    machine = both(inputs["machine"])
    for text in machine.assumptions:
        inputs.assume(text)
    return machine


def work(turn: cycle.DeviceCycleTable) -> float:
    """Work of the motor over a turn [J], from equally spaced samples."""
    return float(turn.totals["M_L_Nm"].mean() * 2 * np.pi)
