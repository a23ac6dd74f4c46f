"""A quantity of a machine at measured angles as a function of chosen inputs, with exact derivatives."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.response import Response
from planter.errors import ComputationError, InputError
from planter.files import paths, units
from planter.kernels import Array
from planter.measured.reading import Measurement

OFFSET, PHASE = "offset_N", "phase_deg"
"""What may be fitted beside the machine's inputs: the zero of the gauge, with any unit, and of the angle."""
SAMPLES = 720
"""Angles of a revolution at which a curve is sampled; the first 6 whole numbers, and more, divide it."""
SAME = 1e-9
"""Share of its largest value by which a curve that repeats may differ from itself."""


@dataclass(frozen=True)
class Chosen:
    """Inputs that are fitted, by their paths in the machine file, an offset or a phase, with bounds (n,).

    Bounds are in SI, those of an offset in the unit of the quantity that was measured.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array

    @classmethod
    def of(cls, machine: Machine, bounds: Mapping[str, tuple[float, float]]) -> Chosen:
        """Return inputs with their bounds in display units. Raises InputError for a name or bounds that cannot be."""
        known = [value.path for value in machine.values]
        named: dict[str, tuple[float, float]] = {}
        for name, (low, high) in bounds.items():
            found = [name] if is_nuisance(name) else paths.Names(known).candidates(name)
            if len(found) != 1:
                near = paths.close(name, [*known, OFFSET, PHASE])
                hint = f"did you mean {' or '.join(near)}?" if near else f"it must be one of {', '.join(known)}"
                raise InputError(f"--fit {name} is not allowed: it must be one input of the machine, {hint}")
            if not low < high:
                raise InputError(
                    f"--fit {name}={low:g}:{high:g} is not allowed: the lower bound must be below the upper"
                )
            named[found[0]] = (low, high)
        factors = np.array([factor_of(name) for name in named])
        ends = np.array(list(named.values())) * factors[:, None]
        return cls(tuple(named), ends[:, 0], ends[:, 1])

    def shown(self, values: Array) -> dict[str, float]:
        """Return values (n,) by name, in display units."""
        return {name: float(value / factor_of(name)) for name, value in zip(self.names, values, strict=True)}


class MeasuredCurve:
    """The quantity at a measurement's angles, for values of the chosen inputs (n,), in its display unit.

    Measured at phi is computed at phi + phase. A phase whose bounds span the period or more is cyclic: it has none.
    """

    def __init__(self, machine: Machine, chosen: Chosen, measured: Measurement, quantity: str) -> None:
        self.machine, self.chosen = machine, chosen
        self.phi, self.values = measured.phi[measured.used], measured.values[measured.used]
        self._inputs = [i for i, name in enumerate(chosen.names) if not is_nuisance(name)]
        inputs = [chosen.names[i] for i in self._inputs]
        self._offset = next((i for i, name in enumerate(chosen.names) if is_offset(name)), None)
        measured_one = find_measured(machine, quantity)
        self.quantity, self.unit, self._factor = quantity, units.unit(measured_one.key), measured_one.factor
        moved = machine.with_moved(dict.fromkeys(inputs, (0.0, 1.0)))
        self._response = Response(moved, [measured_one.name])
        self._own = moved.design
        self._last: tuple[bytes, tuple[Array, Array]] | None = None

    def own(self) -> Array:
        """Return the machine's own values, taken into the bounds; zero for what is no input of it."""
        found = np.zeros(len(self.chosen.names))
        found[self._inputs] = self._own
        return np.clip(found, self.chosen.lower, self.chosen.upper)

    def thinned(self, most: int) -> MeasuredCurve:
        """The same with so many of its points at most, evenly chosen."""
        chosen = np.unique(np.linspace(0, len(self.phi) - 1, min(most, len(self.phi))).astype(int))
        thin = copy(self)
        thin.phi, thin.values, thin._last = self.phi[chosen], self.values[chosen], None
        return thin

    def restart(self) -> None:
        """Forget earlier values, near which loops are closed: what follows has the same digits in every process."""
        self.bounds(self.own())  # closes loops at the first call, for the period
        self._response.restart()
        self._last = None

    @property
    def phase_index(self) -> int | None:
        """Index of the phase among the chosen inputs, if it is one."""
        return self.chosen.names.index(PHASE) if PHASE in self.chosen.names else None

    @cached_property
    def period(self) -> float:
        """Angle [rad] after which the curve repeats, whatever the inputs: a revolution, or a part of it."""
        curves = []
        for z in (self.own(), (self.chosen.lower + self.chosen.upper) / 2):
            with suppress(ComputationError):  # of inputs whose loops do not close
                curves.append(self.sample(z)[0])
        for parts in (12, 10, 9, 8, 6, 5, 4, 3, 2):
            if curves and all(_repeats(curve, parts) for curve in curves):
                return 2 * np.pi / parts
        return 2 * np.pi

    @property
    def is_cyclic(self) -> bool:
        """Whether any phase is allowed."""
        i = self.phase_index
        return i is not None and bool(self.chosen.upper[i] - self.chosen.lower[i] >= self.period * (1 - SAME))

    def bounds(self, z: Array) -> tuple[Array, Array]:
        """Bounds (n,) of the chosen inputs; those of a cyclic phase lie half a period on each side of its value."""
        lower, upper, i = self.chosen.lower.copy(), self.chosen.upper.copy(), self.phase_index
        if i is not None and self.is_cyclic:
            lower[i], upper[i] = z[i] - self.period / 2, z[i] + self.period / 2
        return lower, upper

    def sample(self, z: Array) -> tuple[Array, Array]:
        """The quantity (SAMPLES,) without phase over a revolution, and its Jacobian (SAMPLES, n)."""
        at_zero = z.copy()
        if self.phase_index is not None:
            at_zero[self.phase_index] = 0.0
        return self(at_zero, np.linspace(0, 2 * np.pi, SAMPLES, endpoint=False))

    def __call__(self, z: Array, phi: Array | None = None) -> tuple[Array, Array]:
        """The quantity (m,) and its Jacobian (m, n) in the inputs, at the measured angles or at others [rad].

        What was found last is remembered: a search asks for values and Jacobian one after the other.
        """
        asked = z.tobytes() if phi is None else b""
        if asked and self._last is not None and self._last[0] == asked:
            return self._last[1]
        found = self._found(z, self.phi if phi is None else phi)
        if asked:
            self._last = asked, found
        return found

    def _found(self, z: Array, phi: Array) -> tuple[Array, Array]:
        places = phi + (0.0 if self.phase_index is None else z[self.phase_index])
        point = self._response.at(z[self._inputs])
        values, along = (rows[0] / self._factor for rows in self._response.slopes(point, np.mod(places, 2 * np.pi)))
        slopes = np.zeros((len(places), len(z)))
        slopes[:, self._inputs] = along[:, 1:]
        if self._offset is not None:
            slopes[:, self._offset] = 1.0
            values = values + z[self._offset]
        if self.phase_index is not None:
            slopes[:, self.phase_index] = along[:, 0]
        return values, slopes


def is_nuisance(name: str) -> bool:
    """Return whether what is fitted is no input of the machine."""
    return name == PHASE or is_offset(name)


def factor_of(name: str) -> float:
    """Return the unit in which a fitted value is computed, per display unit: SI, but for an offset."""
    return 1.0 if is_offset(name) else units.factor(name)


def _repeats(curve: Array, parts: int) -> bool:
    """Whether a sampled curve that varies repeats so many times in a revolution."""
    allowed = SAME * float(np.abs(curve).max())
    return bool(np.ptp(curve) > allowed and np.abs(curve - np.roll(curve, len(curve) // parts)).max() <= allowed)


def find_measured(machine: Machine, quantity: str) -> Quantity:
    """Return the quantity that was measured, by its key or name. Raises InputError if the machine has no such one."""
    known = {one.key: one for one in machine.results}
    found = known.get(quantity) or next((one for one in machine.results if one.name == quantity), None)
    if found is None:
        near = paths.close(quantity, list(known))
        hint = f"did you mean {' or '.join(near)}?" if near else f"it must be one of {', '.join(known)}"
        raise InputError(f"--quantity = {quantity} is not allowed: {machine.name} has none of that name, {hint}")
    return found


def is_offset(name: str) -> bool:
    """Return whether a name is that of the zero of the gauge, in the unit of what was measured."""
    return re.fullmatch(r"offset(_\w+)?", name) is not None
