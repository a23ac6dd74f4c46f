"""The support force of a planting device as a response over a turn, and what the design means to it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel
from planter.optimise import directions
from planter.optimise import joints as joints_of_response
from planter.optimise.directions import Insensitive
from planter.optimise.joints import Place
from planter.optimise.response import Compiled, Event
from planter.planting import flanks
from planter.planting.model import Device


class Planting:
    """A planting device as a `Response`: period pi, since side 2 is side 1 half a turn later."""

    period = float(np.pi)

    def __init__(self, device: Device) -> None:
        self.device = device
        self.names, self.lower, self.upper = device.names, device.lower, device.upper
        self.design = device.design
        self._kept, self.events = _events(device)
        self.prologue = device.prologue
        force = device.force
        self.support, self.support_slopes = force.value, force.slopes
        self.support_rate, self.support_rates = force.rate, force.rates
        self.support_hessian, self.support_hessians = force.hessian, force.hessians

    def _kernel(self, name: str, outputs: Callable[[], dict[str, ca.SX]]) -> Kernel:
        """Outputs at many angles; in machine code if the device is. Each is made once for a device."""
        known, key = self.device.kernels, (name, self.device.compiled)
        if key not in known:
            built = outputs()
            values = [ca.densify(value) for value in built.values()]
            f = ca.Function(name, self.device.functions.inputs, values, ["phi", "x", "c", "h"], list(built))
            known[key] = Kernel(f, lanes=["phi"])
            if self.device.compiled:
                known[key].compile()
        return known[key]

    @cached_property
    def _events(self) -> Kernel:
        functions = self.device.functions
        return self._kernel(
            "events", lambda: {"g": functions.events, "along_phi": ca.jacobian(functions.events, functions.phi)}
        )

    @cached_property
    def _event_slopes(self) -> Kernel:
        functions = self.device.functions
        z = ca.vertcat(functions.phi, functions.x, functions.h)
        return self._kernel("event_slopes", lambda: {"g": ca.jacobian(functions.events, z)})

    @cached_property
    def _event_hessian(self) -> Kernel:
        """Hessian in (phi, x) of the weighted events, the prologue included."""
        functions = self.device.functions
        events = ca.Function("events", functions.inputs, [functions.events])
        phi, x, c = ca.MX.sym("phi"), ca.MX.sym("x", functions.x.numel()), ca.MX.sym("c", functions.c.numel())
        weights = ca.MX.sym("weights", functions.events.numel())
        g = ca.dot(weights, events(phi, x, c, functions.prologue_function(x, c)))
        hessian, _ = ca.hessian(g, ca.vertcat(phi, x))
        names = ["phi", "x", "c", "weights"]
        return Kernel(ca.Function("event_hessian", [phi, x, c, weights], [ca.densify(hessian)], names, ["hessian"]))

    def _inputs(self, at: Any, phi: Array) -> dict[str, Any]:
        return {"phi": phi, "x": at.x, "c": self.device.constants, "h": at.h}

    def event_values(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """g of every event of side 1 and its derivative in phi, (k, n) each."""
        found = self._events(**self._inputs(at, phi))
        return found["g"][self._kept], found["along_phi"][self._kept]

    def event_slopes(self, at: Any, phi: Array) -> Array:
        """Jacobian of g in (phi, x), (k, n, 1 + p)."""
        every = self._event_slopes(**self._inputs(at, phi))["g"]
        found = every.reshape(self.device.functions.events.numel(), len(phi), -1)[self._kept]
        size = 1 + len(self.names)
        slopes: Array = found[:, :, :size].copy()
        slopes[:, :, 1:] += found[:, :, size:] @ at.dh
        return slopes

    def event_hessian(self, at: Any, phi: float, event: int) -> Array:
        """Hessian of one event's g in (phi, x), (1 + p, 1 + p)."""
        weights = np.eye(self.device.functions.events.numel())[self._kept[event]]
        return self._event_hessian(phi=phi, x=at.x, c=self.device.constants, weights=weights)["hessian"]

    def compiled(self, angles: int) -> Compiled | None:
        """Prologue and lanes in machine code; None where any of them is not compiled."""
        device, force = self.device, self.device.force
        offsets = force.shares.offsets
        force.hessian_kernel.settle()
        prologue, curvature = device.prologue_kernel.compiled, device.prologue_hessian_kernel.compiled
        kernels = (force.value_kernel, force.slopes_kernel, force.hessian_kernel)
        value, slopes, bending = (kernel.interface(angles * len(offsets)) for kernel in kernels)
        if prologue is None or curvature is None or value is None or slopes is None or bending is None:
            return None
        return Compiled(device.constants, offsets, prologue, curvature, value, slopes, bending)


def _events(device: Device) -> tuple[list[int], tuple[Event, ...]]:
    """The events of a device, and their places among those that were generated: of a law's, only its own joints."""
    entries = device.sidecar["events"]
    positions = sorted({e["position"] for e in entries if "position" in e})
    orders = {joint.position: joint.order for joint in flanks.joints(device.machine.cam.flank, tuple(positions))}
    kept = [i for i, e in enumerate(entries) if "position" not in e or e["position"] in orders]
    chosen = [entries[i] for i in kept]
    found = [Event(e["name"], orders.get(e.get("position"), e["order"]), e["period"]) for e in chosen]
    return kept, tuple(found)


def sensitivity(device: Device, x: Array, samples: int, held: Array | None = None) -> Insensitive:
    """What the support-force curve feels of the design at x (p,); `held` (k, p) as in `directions.sensitivity`."""
    return directions.sensitivity(Planting(device), x, samples, held)


def joints(device: Device, x: Array) -> list[Place]:
    """Joints of both sides over a turn at design x (p,), by angle in [0, 2 pi)."""
    response = Planting(device)
    return joints_of_response.places(response, response.prologue(x))
