"""A total of a device at measured angles as a function of chosen inputs, with exact derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.errors import InputError
from planter.files import paths, units
from planter.kernels import Array, Kernel
from planter.planting.measured.reading import Measurement
from planter.planting.model import Device
from planter.planting.quantities import keys

OFFSET, PHASE = "offset_N", "phase_deg"
NUISANCE = (OFFSET, PHASE)
"""What may be fitted beside the machine's inputs: the zero of the gauge, and of the angle."""
SUPPORT = "support_N"
SAMPLES = 720
"""Angles of a revolution at which a curve is sampled; the first 6 whole numbers, and more, divide it."""
SAME = 1e-9
"""Share of its largest value by which a curve that repeats may differ from itself."""


@dataclass(frozen=True)
class Chosen:
    """Inputs that are fitted, by their paths in the machine file or as `NUISANCE` has them, with bounds (n,) in SI."""

    names: tuple[str, ...]
    lower: Array
    upper: Array

    @classmethod
    def of(cls, device: Device, bounds: Mapping[str, tuple[float, float]]) -> Chosen:
        """Inputs with their bounds in shown units. Raises InputError for a name or bounds that cannot be."""
        known = _paths(device)
        named: dict[str, tuple[float, float]] = {}
        for name, (low, high) in bounds.items():
            found = [name] if name in NUISANCE else paths.Names(known).candidates(name)
            if len(found) != 1:
                near = paths.close(name, [*known, *NUISANCE])
                hint = f"did you mean {' or '.join(near)}?" if near else f"it must be one of {', '.join(known)}"
                raise InputError(f"--fit {name} is not allowed: it must be one input of the machine, {hint}")
            if not low < high:
                raise InputError(
                    f"--fit {name}={low:g}:{high:g} is not allowed: the lower bound must be below the upper"
                )
            named[found[0]] = (low, high)
        factors = np.array([units.factor(name) for name in named])
        ends = np.array(list(named.values())) * factors[:, None]
        return cls(tuple(named), ends[:, 0], ends[:, 1])

    def shown(self, values: Array) -> dict[str, float]:
        """Values (n,) in SI by name, in shown units."""
        return {name: float(value / units.factor(name)) for name, value in zip(self.names, values, strict=True)}


class MeasuredCurve:
    """The quantity at a measurement's angles, for values of the chosen inputs (n,) in SI.

    Measured at phi is computed at phi + phase. A phase whose bounds span the period or more is cyclic: it has none.
    """

    def __init__(self, device: Device, chosen: Chosen, measured: Measurement, quantity: str = SUPPORT) -> None:
        self.device, self.chosen = device, chosen
        self.phi, self.values = measured.phi[measured.used], measured.values[measured.used]
        own = _paths(device)
        self._inputs = [i for i, name in enumerate(chosen.names) if name not in NUISANCE]
        self._places = [own.index(chosen.names[i]) for i in self._inputs]
        at = device.prologue(device.design)
        self.quantity, self.unit = quantity, quantity_unit(device, quantity)
        self._kernel, curves = _kernel(device, quantity, self._places)
        self._fixed = {"x": at.x, "curves": at.h[:curves]}
        self._last: tuple[bytes, tuple[Array, Array]] | None = None

    def own(self) -> Array:
        """The machine's own values, taken into the bounds; zero for what is no input of it."""
        found = np.zeros(len(self.chosen.names))
        found[self._inputs] = self.device.constants[self._places]
        return np.clip(found, self.chosen.lower, self.chosen.upper)

    def thinned(self, most: int) -> MeasuredCurve:
        """The same with so many of its points at most, evenly chosen."""
        chosen = np.unique(np.linspace(0, len(self.phi) - 1, min(most, len(self.phi))).astype(int))
        thin = copy(self)
        thin.phi, thin.values, thin._last = self.phi[chosen], self.values[chosen], None
        return thin

    @property
    def phase_index(self) -> int | None:
        """Index of the phase among the chosen inputs, if it is one."""
        return self.chosen.names.index(PHASE) if PHASE in self.chosen.names else None

    @cached_property
    def period(self) -> float:
        """Angle [rad] after which the curve repeats, whatever the inputs: a revolution, or a part of it."""
        middle = (self.chosen.lower + self.chosen.upper) / 2
        curves = [self.sample(z)[0] for z in (self.own(), middle)]
        for parts in (12, 10, 9, 8, 6, 5, 4, 3, 2):
            if all(_repeats(curve, parts) for curve in curves):
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
        extra = dict(zip(self.chosen.names, z, strict=True))
        constants = self.device.constants.copy()
        constants[self._places] = z[self._inputs]
        places = phi + extra.get(PHASE, 0.0)
        found = self._kernel(phi=np.mod(places, 2 * np.pi), c=constants, **self._fixed)
        slopes = np.zeros((len(places), len(z)))
        slopes[:, self._inputs] = found["along"].T
        for name, column in ((OFFSET, 1.0), (PHASE, found["rate"][0])):
            if name in extra:
                slopes[:, self.chosen.names.index(name)] = column
        return found["value"][0] + extra.get(OFFSET, 0.0), slopes


def _repeats(curve: Array, parts: int) -> bool:
    """Whether a sampled curve that varies repeats so many times in a revolution."""
    allowed = SAME * float(np.abs(curve).max())
    return bool(np.ptp(curve) > allowed and np.abs(curve - np.roll(curve, len(curve) // parts)).max() <= allowed)


def _paths(device: Device) -> list[str]:
    return [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]


def quantity_unit(device: Device, quantity: str) -> str:
    """The unit of a total. Raises InputError if the device has no such total."""
    return _total(device, quantity)["unit"]


def _total(device: Device, quantity: str) -> Mapping[str, str]:
    entries: Sequence[Mapping[str, str]] = device.sidecar["vectors"]["totals"]
    known = dict(zip(keys(entries), entries, strict=True))
    if quantity not in known:
        raise InputError(f"--quantity = {quantity} is not allowed: it must be one of {', '.join(known)}")
    return known[quantity]


def _kernel(device: Device, quantity: str, places: list[int]) -> tuple[Kernel, int]:
    """(phi, x, c, curves) -> value, its slope in phi, its slopes in the inputs; and how many of h the curves are."""
    functions = device.functions
    (value,), inputs = functions.of_data([functions.total(_total(device, quantity)["name"])])
    along = ca.densify(ca.jacobian(value, functions.c[places])).T if places else ca.SX(0, 1)
    outputs = ca.cse([value, ca.gradient(value, functions.phi), along])
    names = ["phi", "x", "c", "curves"]
    f = ca.Function("measured", inputs, outputs, names, ["value", "rate", "along"])
    return Kernel(f, lanes=["phi"]), inputs[-1].numel()
