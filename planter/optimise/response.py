"""What the optimisers need of a machine: its support force over a turn, with exact derivatives.

The optimisers are written against the protocol `Response`, so any closed curve F(phi, x) can stand in for a device.
`Planting` makes one of a `planter.planting.model.Device`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import casadi as ca
import numpy as np

from planter.kernels import Array, Kernel
from planter.planting.model import Device


@dataclass(frozen=True)
class Event:
    """A kind of joint: the force is smooth in (phi, x) but where g(phi, x) is a whole multiple of `period`.

    `period` None: where g = 0. `order` is the order of the first derivative of F in phi that jumps there, 1 or 2.
    """

    name: str
    order: int
    period: float | None


class Response(Protocol):
    """A force F(phi, x) [N], continuous, periodic in phi with `period` [rad]; designs x are (p,), angles (n,).

    `prologue` does once for a design what no angle changes; its result is handed to all the rest as `at`.
    Joints of the k-th event lie at angles in [0, 2 pi), and again at every `period` of F from there.
    """

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def lower(self) -> Array: ...
    @property
    def upper(self) -> Array: ...
    @property
    def design(self) -> Array: ...
    @property
    def period(self) -> float: ...
    @property
    def events(self) -> tuple[Event, ...]: ...

    def prologue(self, x: Array) -> Any: ...

    def support(self, at: Any, phi: Array) -> Array:
        """F, (n,)."""

    def support_rate(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """F and its derivative in phi, (n,) each."""

    def support_rates(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """First and second derivative of F in phi, (n,) each."""

    def support_slopes(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """F, (n,), and its Jacobian in (phi, x), (n, 1 + p)."""

    def support_hessian(self, at: Any, phi: Array, weights: Array) -> Array:
        """Weighted sum over the angles of the Hessian of F in (phi, x), (1 + p, 1 + p)."""

    def support_hessians(self, at: Any, phi: Array) -> Array:
        """Hessian of F in (phi, x) at each angle, (n, 1 + p, 1 + p)."""

    def event_values(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """g of every event and its derivative in phi, (k, n) each."""

    def event_slopes(self, at: Any, phi: Array) -> Array:
        """Jacobian of g in (phi, x), (k, n, 1 + p)."""

    def event_hessian(self, at: Any, phi: float, event: int) -> Array:
        """Hessian of one event's g in (phi, x), (1 + p, 1 + p)."""


class Planting:
    """A planting device as a `Response`: period pi, since side 2 is side 1 half a turn later."""

    period = float(np.pi)

    def __init__(self, device: Device) -> None:
        self.device = device
        self.names, self.lower, self.upper = device.names, device.lower, device.upper
        self.design = device.design
        self.events = tuple(Event(**entry) for entry in device.sidecar["events"])
        self.prologue = device.prologue
        force = device.force
        self.support, self.support_slopes = force.value, force.slopes
        self.support_hessian, self.support_hessians = force.hessian, force.hessians

    def _kernel(self, name: str, outputs: dict[str, ca.SX]) -> Kernel:
        """Outputs at many angles; in machine code if the device is. Each is made once for a device."""
        known, key = self.device.kernels, (name, self.device.compiled)
        if key not in known:
            values = [ca.densify(value) for value in outputs.values()]
            f = ca.Function(name, self.device.functions.inputs, values, ["phi", "x", "c", "h"], list(outputs))
            known[key] = Kernel(f, lanes=["phi"])
            if self.device.compiled:
                known[key].compile()
        return known[key]

    @cached_property
    def _events(self) -> Kernel:
        functions = self.device.functions
        return self._kernel(
            "events", {"g": functions.events, "along_phi": ca.jacobian(functions.events, functions.phi)}
        )

    @cached_property
    def _event_slopes(self) -> Kernel:
        functions = self.device.functions
        z = ca.vertcat(functions.phi, functions.x, functions.h)
        return self._kernel("event_slopes", {"g": ca.jacobian(functions.events, z)})

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

    def support_rate(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """F [N] and dF/dphi at angles, (n,) each."""
        force, first, _ = self.device.force.rates(at, phi)
        return force, first

    def support_rates(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """dF/dphi and d2F/dphi2 at angles, (n,) each."""
        return self.device.force.rates(at, phi)[1:]

    def event_values(self, at: Any, phi: Array) -> tuple[Array, Array]:
        """g of every event of side 1 and its derivative in phi, (k, n) each."""
        found = self._events(**self._inputs(at, phi))
        return found["g"], found["along_phi"]

    def event_slopes(self, at: Any, phi: Array) -> Array:
        """Jacobian of g in (phi, x), (k, n, 1 + p)."""
        found = self._event_slopes(**self._inputs(at, phi))["g"].reshape(len(self.events), len(phi), -1)
        size = 1 + len(self.names)
        slopes: Array = found[:, :, :size].copy()
        slopes[:, :, 1:] += found[:, :, size:] @ at.dh
        return slopes

    def event_hessian(self, at: Any, phi: float, event: int) -> Array:
        """Hessian of one event's g in (phi, x), (1 + p, 1 + p)."""
        weights = np.eye(len(self.events))[event]
        return self._event_hessian(phi=phi, x=at.x, c=self.device.constants, weights=weights)["hessian"]
