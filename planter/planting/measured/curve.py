"""A total of a device at measured angles as a function of chosen inputs, with exact derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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
    """The quantity at a measurement's angles, for values of the chosen inputs (n,) in SI."""

    def __init__(self, device: Device, chosen: Chosen, measured: Measurement, quantity: str = SUPPORT) -> None:
        self.device, self.chosen = device, chosen
        self.phi, self.values = measured.phi[measured.used], measured.values[measured.used]
        own = _paths(device)
        self._inputs = [i for i, name in enumerate(chosen.names) if name not in NUISANCE]
        self._places = [own.index(chosen.names[i]) for i in self._inputs]
        at = device.prologue(device.design)
        self._kernel, curves = _kernel(device, quantity, self._places)
        self._fixed = {"x": at.x, "curves": at.h[:curves]}
        self._last: tuple[bytes, tuple[Array, Array]] | None = None

    def own(self) -> Array:
        """The machine's own values, taken into the bounds; zero for what is no input of it."""
        found = np.zeros(len(self.chosen.names))
        found[self._inputs] = self.device.constants[self._places]
        return np.clip(found, self.chosen.lower, self.chosen.upper)

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


def _paths(device: Device) -> list[str]:
    return [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]


def _kernel(device: Device, quantity: str, places: list[int]) -> tuple[Kernel, int]:
    """(phi, x, c, curves) -> value, its slope in phi, its slopes in the inputs; and how many of h the curves are."""
    entries = device.sidecar["vectors"]["totals"]
    known = dict(zip(keys(entries), (entry["name"] for entry in entries), strict=True))
    if quantity not in known:
        raise InputError(f"--quantity = {quantity} is not allowed: it must be one of {', '.join(known)}")
    functions = device.functions
    (value,), inputs = functions.of_data([functions.total(known[quantity])])
    along = ca.densify(ca.jacobian(value, functions.c[places])).T if places else ca.SX(0, 1)
    outputs = ca.cse([value, ca.gradient(value, functions.phi), along])
    names = ["phi", "x", "c", "curves"]
    f = ca.Function("measured", inputs, outputs, names, ["value", "rate", "along"])
    return Kernel(f, lanes=["phi"]), inputs[-1].numel()
