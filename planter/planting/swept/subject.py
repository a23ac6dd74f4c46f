"""A planting device whose inputs come in rows: design parameters, numbers of its file, centre distances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

import numpy as np

from planter.errors import InputError
from planter.files import units
from planter.kernels import Array
from planter.planting.file import Machine
from planter.planting.functions import Model
from planter.planting.model import Device
from planter.planting.objective import weights
from planter.planting.swept.measures import FOUND, Measure, key_of, known
from planter.planting.swept.mounting import DEVIATIONS, Mounting
from planter.planting.swept.slopes import Place, Slopes
from planter.planting.swept.turning import Turning

SLICE = 1_000
"""Rows that a thread takes at a time."""
Ends = Mapping[str, tuple[float, float]]


def places(device: Device) -> dict[str, Place]:
    """Every input of a device by its path."""
    data = device.sidecar["vectors"]["machine"]
    design = {f"design.{n}": Place("design", i, units.factor(n)) for i, n in enumerate(device.names)}
    numbers = {e["shown"]: Place("data", i, units.factor(e["shown"])) for i, e in enumerate(data)}
    return design | numbers | {n: Place("deviations", i, units.factor(n)) for i, n in enumerate(DEVIATIONS)}


class Planting:
    """Outputs of a device by name over rows of inputs by path, in the units [that the names end in]."""

    def __init__(self, machine: Machine, model: Model, inputs: Ends, outputs: Sequence[str]) -> None:
        self.machine, self.device = machine, Device(_between(machine, inputs), model)
        self.inputs, self.outputs = tuple(inputs), tuple(outputs)
        self.places = [places(self.device)[name] for name in inputs]
        self.mounting, self.weights = Mounting(self.device), weights(machine)
        self.measures: list[Measure] = [measures(self.device)[name] for name in outputs]
        keys = tuple(dict.fromkeys(measure.key for measure in self.measures))
        self.turning = Turning(self.device, keys, machine.objective.samples)

    def vectors(self, points: Array) -> tuple[Array, Array, Array]:
        """Designs (m, p), data (m, c) and deviations (m, 2) in SI, of points (m, n) in shown units."""
        own = {"design": self.own_design, "data": self.device.constants, "deviations": np.zeros(len(DEVIATIONS))}
        found = {name: np.tile(values, (len(points), 1)) for name, values in own.items()}
        for place, column in zip(self.places, np.asarray(points, dtype=float).T, strict=True):
            found[place.vector][:, place.index] = column * place.factor
        return found["design"], found["data"], found["deviations"]

    @property
    def own_design(self) -> Array:
        """The machine's own (p,) [SI]."""
        return self.device.scale * np.array([self.machine.design[name] for name in self.device.names])

    def evaluated(self, points: Array, threads: int) -> Array:
        """Outputs (m, k) at points (m, n): NaN in rows that have none."""
        if threads == 1:
            return self._slice(points)
        parts = [points[start : start + SLICE] for start in range(0, len(points), SLICE)]
        with ThreadPoolExecutor(threads) as pool:
            return np.vstack(list(pool.map(self._slice, parts)))

    def slopes(self, point: Array) -> tuple[Array, Array]:
        """Outputs (k,) at a point (n,) and their exact slopes (k, n) in the inputs; extremes stay at their samples."""
        return self._slopes(point)

    @cached_property
    def _slopes(self) -> Slopes:
        return Slopes(self)

    def curves(self, keys: Sequence[str], points: Array) -> dict[str, Array]:
        """Quantities over a turn, a row (m, n) for each point (m, inputs), in shown units; `phi_deg` (n,) beside them.

        Raises ComputationError where one is not finite.
        """
        turning = Turning(self.device, keys, self.machine.objective.samples)
        turning.kernel.compile()
        designs, data, deviations = self.vectors(points)
        turns = [turning.whole(x, c) for x, c in zip(self.mounting(designs, deviations), data, strict=True)]
        order = np.argsort(np.mod(turning.phi, 2 * np.pi), kind="stable")
        found = np.array(turns)[:, :, order]
        shown = {key: found[:, k] / units.factor(key) for k, key in enumerate(keys)}
        return shown | {"phi_deg": np.degrees(np.mod(turning.phi, 2 * np.pi)[order])}

    def _slice(self, points: Array) -> Array:
        designs, data, deviations = self.vectors(points)
        found = self.turning.many(self.mounting(designs, deviations), data)
        return np.column_stack([self.measured(measure, found) for measure in self.measures])

    def measured(self, measure: Measure, found: Array) -> Array:
        """An output (m,) from the statistics (m, k, 4) of the quantities, in its shown unit."""
        statistics = found[:, self.turning.keys.index(measure.key)].T
        size = units.factor(measure.key)
        powers = (size, size, size, size**2)
        shown = {name: row / power for name, row, power in zip(FOUND, statistics, powers, strict=True)}
        return measure.of(shown, self.weights)


def measures(device: Device) -> dict[str, Measure]:
    """All that can be asked of a device."""
    vectors = device.sidecar["vectors"]
    totals = sorted(vectors["totals"], key=lambda entry: key_of(entry) != "support_N")
    return known([*totals, *vectors["side"]])


def _between(machine: Machine, inputs: Ends) -> Machine:
    """The machine with the ends of the varied design parameters as their bounds, so that all corners have gears.

    Raises InputError where the file does not allow an end.
    """
    try:
        for end in (0, 1):
            allowed = {name: ends[end] for name, ends in inputs.items() if name not in DEVIATIONS}
            for name, value in allowed.items():
                machine.with_numbers({name: value})
    except InputError as error:
        raise InputError(f"an end of what is varied is not allowed: {error}") from None
    table = machine.table()
    for name, (low, high) in inputs.items():
        section, _, key = name.partition(".")
        if section == "design":
            table["design"][key] = low
            if low < high:
                table["bounds"][key] = [low, high]
    return Machine.read(table, machine.source)
