"""A quantity of a machine over a turn, as optimisation takes it: a closed curve with its joints."""

from __future__ import annotations

import copy
from functools import cached_property

import numpy as np

from planter.engine.loops import TURN
from planter.engine.machine import Machine
from planter.engine.response import DesignPoint, Response
from planter.kernels import Array
from planter.optimise.response import Compiled, Event


class Curve:
    """A quantity F(phi, x) of a machine, in SI, with the machine's events as joints: an `optimise.response.Response`.

    The order of a joint is that of the machine's forces: a quantity may be smoother there. The curve of a side has
    joints of the first side alone, and repeats after a turn.
    """

    def __init__(self, machine: Machine, name: str) -> None:
        """Raises InputError if the machine has no quantity of that name."""
        self.machine, self.quantity = machine, machine.find_quantity(name)
        self.response, self.is_compiled = Response(machine, [name]), False
        self.events = tuple(
            Event(str(kind["name"]), int(kind["order"]), kind["period"]) for kind in machine.event_kinds
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the design x."""
        return self.machine.design_names

    @property
    def lower(self) -> Array:
        """Lower bounds (p,)."""
        return self.machine.lower

    @property
    def upper(self) -> Array:
        """Upper bounds (p,)."""
        return self.machine.upper

    @property
    def design(self) -> Array:
        """The machine's own design (p,)."""
        return self.machine.design

    @property
    def period(self) -> float:
        """The angle after which the curve repeats [rad]."""
        return self.machine.period if self.quantity.total else TURN

    @property
    def offsets(self) -> tuple[float, ...]:
        """Angles [rad] of the lanes that add up to the curve."""
        return self.response.offsets

    def with_machine(self, machine: Machine) -> Curve:
        """Return the curve of a machine that differs from this one's in numbers alone: all functions are shared."""
        curve = copy.copy(self)
        curve.machine = machine
        return curve

    def prologue(self, x: Array) -> DesignPoint:
        """Return the point of a design x (p,), for all angles."""
        return self.response.at_data(self.machine.data_at(x))

    def restart(self) -> None:
        """Forget all designs so far, as `Response.restart`."""
        self.response.restart()
        self._joints.restart()

    def value(self, at: DesignPoint, phi: Array) -> Array:
        """Return F, (n,). Raises ComputationError if loops do not close or a value is not finite, as all do."""
        return self.response.values(at, phi)[0]

    def rate(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return F and its derivative in phi, (n,) each."""
        values, first = self.response.derivatives(at, phi)
        return values[0], first[0]

    def rates(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return the first and second derivative of F in phi, (n,) each."""
        first, second = self.response.rates(at, phi)
        return first[0], second[0]

    def slopes(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return F, (n,), and its Jacobian in (phi, x), (n, 1 + p)."""
        values, slopes = self.response.slopes(at, phi)
        return values[0], slopes[0]

    def hessian(self, at: DesignPoint, phi: Array, weights: Array) -> Array:
        """Return the weighted sum over the angles of the Hessian of F in (phi, x), (1 + p, 1 + p)."""
        return self.response.curvature(at, phi, weights[None])

    def hessians(self, at: DesignPoint, phi: Array) -> Array:
        """Return the Hessian of F in (phi, x) at each angle, (n, 1 + p, 1 + p)."""
        return self.response.curvatures(at, phi, np.ones((1, len(phi))))

    @cached_property
    def _joints(self) -> Response:
        joints = Response(self.machine, (), with_events=True)
        joints.is_compiled = self.is_compiled
        return joints

    def event_values(self, at: DesignPoint, phi: Array) -> tuple[Array, Array]:
        """Return g of every event and its derivative in phi, (k, n) each."""
        return self._joints.derivatives(at, phi)

    def event_slopes(self, at: DesignPoint, phi: Array) -> Array:
        """Return the Jacobian of g in (phi, x), (k, n, 1 + p)."""
        return self._joints.slopes(at, phi)[1]

    def event_hessian(self, at: DesignPoint, phi: float, event: int) -> Array:
        """Return the Hessian of one event's g in (phi, x), (1 + p, 1 + p)."""
        weights = np.eye(len(self.events))[:, event : event + 1]
        return self._joints.curvature(at, np.array([phi]), weights)

    def compile(self, refined: bool = False) -> None:
        """Compile what a search calls again and again, over samples or, `refined`, over true extremes and integrals.

        The Hessian takes longest: it is compiled in the background, and not for the few times that a search over true
        extremes needs it. What joints need is compiled at its first use.
        """
        response = self.response
        if not refined:
            response.hessian_kernel.compile(wait=False)
            response.prologue_hessian_kernel.compile()
        response.compile()
        if refined:
            response.derivatives_kernel.compile()
            response.rates_kernel.compile()
        self.is_compiled = True
        vars(self).pop("_joints", None)

    def compiled(self, angles: int) -> Compiled | None:
        """Return prologue and lanes in machine code; None if one is not compiled, or if loops must be closed."""
        response = self.response
        if self.machine.loops is not None:
            return None
        response.hessian_kernel.settle()
        prologue, curvature = response.prologue_kernel.compiled, response.prologue_hessian_kernel.compiled
        kernels = (response.values_kernel, response.slopes_kernel, response.hessian_kernel)
        value, slopes, bending = (kernel.interface(angles * len(self.offsets)) for kernel in kernels)
        if prologue is None or curvature is None or value is None or slopes is None or bending is None:
            return None
        machine = self.machine
        return Compiled(machine.data, machine.moved, self.offsets, prologue, curvature, value, slopes, bending)
