"""The device at a speed and an acceleration of its carrier: forces, balance of the shaft, energies; SI and radians."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import ComputationError, InputError
from planter.kernels import Array, Kernel, generated
from planter.planting import flanks
from planter.planting.model import Device

NAME = "planting_drive"
LOSS = "F_E_loss"
STEPS = 4
"""Newton steps to an acceleration: the balance is a line on each side of the places where a tooth flank changes."""
SOLVED = 1e-12
"""Share of an acceleration below which a step is rounding."""
STALLED = 1e-2
"""Share of the speed without load below which a motor counts as stalled."""
INTEGRATOR: dict[str, Any] = {
    "reltol": 1e-11, "abstol": 1e-12, "max_step_size": np.pi / 180, "max_num_steps": 1_000_000,
    "linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional",
}  # fmt: skip


@dataclass(frozen=True)
class Motor:
    """A motor at the carrier: torque at rest [N m], speed without load [rad/s], inertia of all that turns [kg m2]."""

    stall: float
    idle: float
    flywheel: float

    def __post_init__(self) -> None:
        for name, value in (
            ("--stall-Nm", self.stall),
            ("--idle-rpm", self.idle * 30 / np.pi),
            ("--flywheel-kgm2", self.flywheel),
        ):
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value:g} is not allowed: it must be greater than 0")

    @property
    def values(self) -> Array:
        """As the generated functions take it."""
        return np.array([self.stall, self.idle, self.flywheel])


@dataclass(frozen=True)
class State:
    """What is told along a motion, (n,) each: support force [N], torques of motor and device [N m], powers [W].

    `stored` is the rate of all energies, `lost` the power of friction; what the motor gives is both.
    """

    support: Array
    torque: Array
    load: Array
    stored: Array
    lost: Array


class Driven:
    """A device of the exact model, at its own design, with a motor."""

    def __init__(self, device: Device, motor: Motor) -> None:
        if device.model != "exact":
            raise InputError("a motor drives the exact model: the printed one holds at constant speed alone")
        self.device, self.motor = device, motor
        self._at = device.prologue(device.design)
        self._vectors = generated.sidecar(NAME)["vectors"]

    @cached_property
    def _inputs(self) -> dict[str, ca.SX]:
        functions = self.device.functions
        phi, x, c, h = functions.inputs
        own = {name: ca.SX.sym(name) for name in ("omega", "speed_rate")}
        return {"phi": phi, **own, "x": x, "c": c, "h": h, "motor": ca.SX.sym("motor", len(self.motor.values))}

    @cached_property
    def _graph(self) -> dict[str, ca.SX]:
        """Everything as functions of the inputs: the carrier's speed stands for that of the machine's constants."""
        functions, module, given = self.device.functions, generated.module(NAME), self._inputs
        contacts = [stage.contact.function for stage in self.device.stages]
        lane = module.lane(*contacts, flanks.function(self.device.machine.cam.flank))
        prologue, rate = module.prologue(*contacts), given["speed_rate"]
        c = ca.SX(given["c"])
        c[self._names("machine").index("omega")] = given["omega"]
        sides = []
        for angle in (given["phi"], given["phi"] - np.pi):
            _, *vectors, _, _ = functions.lane_inputs(angle)
            sides.append(lane(angle, *vectors, c, rate, prologue(*vectors, c, rate)))
        one, two = (dict(zip(self._names("side"), ca.vertsplit(side), strict=True)) for side in sides)
        totals = dict(zip(self._names("totals"), ca.vertsplit(module.frame()(*sides, c)), strict=True))
        shaft = module.shaft()(given["omega"], rate, totals["M_L"], given["motor"])
        at_shaft = dict(zip(self._names("shaft_outputs"), ca.vertsplit(shaft), strict=True))
        energy = sum((side[name] for side in (one, two) for name in ("T_side", "V_side")), at_shaft["T_w"])
        stored = ca.jtimes(energy, ca.vertcat(given["phi"], given["omega"]), ca.vertcat(given["omega"], rate))
        return {**totals, **at_shaft, "stored": stored, "lost": one[LOSS] + two[LOSS]}

    def _names(self, vector: str) -> list[str]:
        return [entry["name"] for entry in self._vectors[vector]]

    def _kernel(self, name: str, outputs: dict[str, ca.SX]) -> Kernel:
        given = self._inputs
        f = ca.Function(name, list(given.values()), ca.cse(list(outputs.values())), list(given), list(outputs))
        return Kernel(f, lanes=["phi", "omega", "speed_rate"])

    @cached_property
    def _accelerating(self) -> Kernel:
        """Acceleration after some of Newton's steps from none, and the last of them."""
        given = self._inputs
        surplus = self._graph["surplus"]
        parts = ca.cse([surplus, ca.gradient(surplus, given["speed_rate"])])
        balance = ca.Function("balance", list(given.values()), parts, list(given), ["surplus", "slope"])
        rate, step = ca.SX(0), ca.SX(0)
        for _ in range(STEPS):
            now = balance(**given | {"speed_rate": rate})
            step = now["surplus"] / now["slope"]
            rate = rate - step
        rest = {name: symbol for name, symbol in given.items() if name != "speed_rate"}
        outputs = ca.cse([rate, step])
        f = ca.Function("accelerating", list(rest.values()), outputs, list(rest), ["speed_rate", "step"])
        return Kernel(f, lanes=["phi", "omega"])

    @property
    def given(self) -> dict[str, Array]:
        """What does not change along a motion."""
        return {"x": self._at.x, "c": self.device.constants, "h": self._at.h, "motor": self.motor.values}

    @cached_property
    def _told(self) -> Kernel:
        names = {"support": "F_support", "torque": "M_motor", "load": "M_L", "stored": "stored", "lost": "lost"}
        return self._kernel("told", {name: ca.densify(self._graph[symbol]) for name, symbol in names.items()})

    def acceleration(self, phi: Array, omega: Array) -> Array:
        """That of the carrier [rad/s2], (n,), at angles and speeds (n,): the torques on its shaft balance.

        Raises ComputationError where none is found.
        """
        now = {name: row[0] for name, row in self._accelerating(phi=phi, omega=omega, **self.given).items()}
        if np.all(np.abs(now["step"]) <= SOLVED * (1 + np.abs(now["speed_rate"]))):
            return now["speed_rate"]
        worst = np.degrees(phi[int(np.argmax(np.abs(now["step"])))]) % 360
        raise ComputationError(f"{self.device.machine.name}: no acceleration balances the shaft at {worst:.6g} deg")

    def motion(self, at: Array) -> Kernel:
        """From a speed at the first of some angles: speed and time at the others, as CVODES integrates them.

        Below a share of the speed without load the motor has stalled, and what follows means nothing.
        """
        state, given = ca.SX.sym("state", 2), self._inputs
        omega = ca.fmax(state[0], self.slowest)
        packed = {name: given[name] for name in self.given}
        rate = self._accelerating.function(phi=given["phi"], omega=omega, **packed)["speed_rate"]
        p = ca.vertcat(*packed.values())
        dae = {"t": given["phi"], "x": state, "p": p, "ode": ca.vertcat(rate / omega, 1 / omega)}
        solver = ca.integrator("motion", "cvodes", dae, float(at[0]), at[1:].tolist(), INTEGRATOR)
        start, fixed = ca.MX.sym("start"), ca.MX.sym("fixed", p.numel())
        ran = solver(x0=ca.vertcat(start, 0), p=fixed)["xf"]
        return Kernel(ca.Function("motion", [start, fixed], [ran], ["start", "fixed"], ["states"]))

    @property
    def slowest(self) -> float:
        """The speed below which the motor counts as stalled [rad/s]."""
        return STALLED * self.motor.idle

    def state(self, phi: Array, omega: Array, rate: Array) -> State:
        """What is told at angles, speeds and accelerations (n,)."""
        found = self._told(phi=phi, omega=omega, speed_rate=rate, **self.given)
        return State(**{name: row[0] for name, row in found.items()})
