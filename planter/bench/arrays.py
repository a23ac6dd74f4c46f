"""The generator's array code put together as one function: the share of a side, or the force of both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from planter.kernels import generated
from planter.planting import flanks
from planter.planting.composition import FORCE
from planter.planting.model import Device

ContactFunction = Callable[..., Any]
Sides = tuple[Any, Any]


class ArrayCode:
    """Array code of a device: `module` has its dynamics, `contacts` the pitch curves of both stages."""

    def __init__(
        self, device: Device, module: ModuleType | None = None, contacts: Sequence[ContactFunction] = ()
    ) -> None:
        self.module = module or emitted_array(f"planting_{device.model}")
        self.contacts = contacts or [emitted_array(f"curve_{s.family}").contact for s in device.stages]
        self.flank = emitted_array(flanks.module_name(device.machine.cam.flank)).law
        sizes = [len(stage.names) for stage in device.stages]
        self._x = np.cumsum([0, device.size - sum(sizes), *sizes]).tolist()
        self._h = np.cumsum([0, *(1 + stage.terms for stage in device.stages)]).tolist()
        names = [entry["name"] for entry in device.sidecar["vectors"]["totals"]]
        self._force = names.index(FORCE)

    def side(self, xp: Any, phi: Any, x: Any, h: Any, c: Any) -> Any:
        """All quantities of a side at angles `phi`."""
        mounting, first, second = (x[a:b] for a, b in zip(self._x, self._x[1:], strict=False))
        curve1, curve2, hoisted = h[: self._h[1]], h[self._h[1] : self._h[2]], h[self._h[2] :]
        return self.module.lane(
            xp, phi, mounting, first, curve1, second, curve2, c, hoisted, *self.contacts, self.flank
        )

    def share(self, xp: Any, phi: Any, x: Any, h: Any, c: Any) -> Any:
        """Return the force of one side at `phi`, with half of the force that belongs to neither side."""
        side = self.side(xp, phi, x, h, c)
        nothing = [0.0] * len(side)
        return self._total(xp, (side, nothing), c) - self._total(xp, (nothing, nothing), c) / 2

    def force(self, xp: Any, phi: tuple[Any, Any], x: Any, h: Any, c: Any) -> Any:
        """The force of both sides, each at its own angles."""
        first, second = (self.side(xp, angles, x, h, c) for angles in phi)
        return self._total(xp, (first, second), c)

    def _total(self, xp: Any, sides: Sides, c: Any) -> Any:
        return self.module.frame(xp, *sides, c)[self._force]


def emitted_array(name: str) -> ModuleType:
    """A module of array code."""
    return generated.module(f"array.{name}")
