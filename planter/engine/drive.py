"""A machine on a motor whose torque falls with the speed along a line, with a flywheel: how its
speed fluctuates.

The drive's acceleration is a value of the machine. At every angle the torques on the shaft balance,
M_motor(omega) = M_drive(phi, omega, acceleration) + J acceleration, which gives the acceleration;
omega over the angle follows by d omega / d phi = acceleration / omega, with coordinates of loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
import scipy

from planter.engine.loops import split_gaps
from planter.engine.machine import Machine
from planter.engine.response import MachineResponse
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.files.record import Record
from planter.kernels import Array, Kernel
from planter.kernels.elimination import solve_system
from planter.numerics.arrays import TURN, to_degrees
from planter.numerics.extrema import index_first_extremum

STEPS = 4
"""Newton steps to an acceleration: the balance is a line on each side of the places where friction
or flanks change.
"""
SOLVED = 1e-12
"""Share of an acceleration below which a step is rounding."""
STALLED = 1e-2
"""Share of the speed without load below which a motor counts as stalled."""
REPEATS = 1e-10
"""Share of the speed by which a settled cycle may miss its own start."""
TURNS_ALIKE = 1e-8
"""Share of its largest power by which a motor's power may miss torque times speed of the drive."""
RPM = 30 / np.pi
INTEGRATOR: dict[str, Any] = {
    "reltol": 1e-11,
    "abstol": 1e-12,
    "max_step_size": np.pi / 180,
    "max_num_steps": 1_000_000,
    "linear_multistep_method": "adams",
    "nonlinear_solver_iteration": "functional",
}


@dataclass(frozen=True)
class Motor:
    """A motor at the drive: torque at rest [N m], speed without load [rad/s], inertia of all that
    turns [kg m2].
    """

    stall: float
    idle: float
    flywheel: float

    def __post_init__(self) -> None:
        for name, value in (
            ("--stall-Nm", self.stall),
            ("--idle-rpm", self.idle * RPM),
            ("--flywheel-kgm2", self.flywheel),
        ):
            if not (np.isfinite(value) and value > 0):
                raise InputError.for_value(name, f"{value:g}", "it must be greater than 0")

    def torque(self, omega: Any) -> Any:
        """Return the torque [N m] at a speed [rad/s], a number, an array or a symbol."""
        return self.stall * (1 - omega / self.idle)


@dataclass(frozen=True)
class SpeedHistory:
    """Angles (n,) [rad], speeds [rad/s] and accelerations [rad/s2] there, and the time that the
    motion takes [s].
    """

    phi: Array
    omega: Array
    rate: Array
    seconds: float


@dataclass(frozen=True)
class DriveState:
    """Results along a motion, (n,) each: quantities by name in SI, torques [N m], powers [W],
    inertia [kg m2].

    `load` is the torque that the machine takes, `stored` the rate of all energies, `lost` the power
    of friction. `inertia` is the machine's own, as the drive has it: the slope of `load` in the
    acceleration.
    """

    values: dict[str, Array]
    torque: Array
    load: Array
    stored: Array
    lost: Array
    inertia: Array


class DrivenMachine:
    """A machine at its own design with a motor.

    Raises InputError for a machine without an acceleration among its values, without a single motor
    at its drive, or that turns backwards.
    """

    def __init__(self, machine: Machine, motor: Motor, names: Sequence[str] | None = None) -> None:
        self.machine, self.motor = machine, motor
        self.names = (
            tuple(quantity.name for quantity in machine.results) if names is None else tuple(names)
        )
        if not machine.motors:
            raise InputError(
                f"{machine.source}: {machine.name} has no torque of a motor, which a motor line "
                f"could give"
            )
        if machine.acceleration is None:
            raise InputError(
                f"{machine.source}: {machine.name} holds at a constant speed of its drive; state "
                f"your own mechanism "
                "as `Mechanism(..., acceleration=q.eps)`, with `eps | rad/s2 | acceleration of "
                "the drive | 0` in its "
                "table, and derive it again"
            )
        self._response = MachineResponse(machine, [*machine.motors, *self._powers])
        self._point = self._response.at(machine.design)
        if self._point.d[machine.speed] <= 0:
            value, speed = machine.values[machine.speed], self._point.d[machine.speed]
            text = f"{machine.source}: {value.path} = {speed / value.factor:g}"
            raise InputError(
                f"{text}: it must be greater than 0, since a motor turns the drive forwards"
            )
        self.shaft = self._find_shaft()
        self._motions: dict[tuple[int, int], Kernel] = {}

    @property
    def _powers(self) -> list[str]:
        names = {quantity.name for quantity in self.machine.quantities}
        return [f"P_{name}" for name in self.machine.motors if f"P_{name}" in names]

    def _find_shaft(self) -> str:
        """Return the torque of the motor that turns the drive: its power is the torque times the
        drive's speed.
        """
        machine, speed = self.machine, float(self._point.d[self.machine.speed])
        rows = self._response.values(self._point, TURN * (np.arange(24) + 0.5) / 24)
        values = dict(zip((*machine.motors, *self._powers), rows, strict=True))
        shafts = [
            name
            for name in machine.motors
            if f"P_{name}" not in values
            or np.abs(values[f"P_{name}"] - values[name] * speed).max()
            <= TURNS_ALIKE * max(float(np.abs(values[f"P_{name}"]).max()), np.finfo(float).tiny)
        ]
        if len(shafts) == 1 == len(machine.motors):
            return shafts[0]
        names = ", ".join(machine.motors) or "none"
        raise InputError(
            f"{machine.source}: a motor line needs one motor, which turns the drive itself; "
            f"{machine.name} has {names}"
        )

    # --- the graph
    # ----------------------------------------------------------------------------------

    @cached_property
    def _symbols(self) -> dict[str, ca.SX]:
        phi, d, h, q = self.machine.symbols
        return {
            "phi": phi,
            "omega": ca.SX.sym("omega"),
            "rate": ca.SX.sym("rate"),
            "q": q,
            "d": d,
            "h": h,
        }

    @cached_property
    def _graph(self) -> dict[str, ca.SX]:
        """The graphs of all results, in angle, speed and acceleration."""
        machine, symbols = self.machine, self._symbols
        assert machine.acceleration is not None
        d = ca.SX(symbols["d"])
        d[machine.speed], d[machine.acceleration] = symbols["omega"], symbols["rate"]
        inlined = machine.prologue.is_a("SXFunction")
        h = machine.prologue(d) if inlined else symbols["h"]
        names = [*self.names, self.shaft, *machine.energies, *machine.losses, *self._power_law]
        graphs = ca.substitute(
            [machine.graph(name) for name in names], [symbols["d"], symbols["h"]], [d, h]
        )
        rows = dict(zip(names, graphs, strict=True))
        load = rows[self.shaft]
        torque = self.motor.torque(symbols["omega"])
        energy = self.motor.flywheel * symbols["omega"] ** 2 / 2 + sum(
            (rows[name] for name in machine.energies), ca.SX(0)
        )
        state, rates = (
            ca.vertcat(symbols["phi"], symbols["omega"]),
            ca.vertcat(symbols["omega"], symbols["rate"]),
        )
        lost = sum((rows[name] for name in machine.losses), ca.SX(0))
        stored = ca.jtimes(energy, state, rates)
        if not machine.energies:
            stored = (
                stored
                + load * symbols["omega"]
                - lost
                - sum((rows[name] for name in self._power_law), ca.SX(0))
            )
        return {name: rows[name] for name in self.names} | {
            "load": load,
            "torque": torque,
            "surplus": torque - load - self.motor.flywheel * symbols["rate"],
            "stored": stored,
            "lost": lost,
            "inertia": ca.gradient(load, symbols["rate"]),
        }

    @property
    def _power_law(self) -> list[str]:
        """The law that the power of all forces and of inertia vanishes, of a machine that reports
        no energies.
        """
        names = {quantity.name for quantity in self.machine.quantities}
        return ["law_power"] if not self.machine.energies and "law_power" in names else []

    def _kernel(self, name: str, outputs: dict[str, ca.SX], inputs: Sequence[str]) -> Kernel:
        symbols = {key: self._symbols[key] for key in inputs}
        values = ca.cse([ca.densify(ca.SX(value)) for value in outputs.values()])
        function = ca.Function(name, list(symbols.values()), values, list(symbols), list(outputs))
        return Kernel(function, lanes=[key for key in inputs if key not in ("d", "h")])

    @cached_property
    def _accelerating(self) -> Kernel:
        """Acceleration after some of Newton's steps from none, and the last of them."""
        surplus, symbol = self._graph["surplus"], self._symbols["rate"]
        parts = ca.cse([surplus, ca.gradient(surplus, symbol)])
        rest = {name: value for name, value in self._symbols.items() if name != "rate"}
        balance = ca.Function("balance", [symbol, *rest.values()], parts)
        rate, step = ca.SX(0), ca.SX(0)
        for _ in range(STEPS):
            now, slope = balance(rate, *rest.values())
            step = now / slope
            rate = rate - step
        return self._kernel("accelerating", {"rate": rate, "step": step}, list(rest))

    @cached_property
    def _reporting(self) -> Kernel:
        return self._kernel("reporting", self._graph, list(self._symbols))

    @property
    def _fixed(self) -> dict[str, Array]:
        return {"d": self._point.d, "h": self._point.h}

    def _coordinates(self, phi: Array) -> Array:
        return self._response.coordinates(self._point.d, phi % TURN)

    # --- the motion
    # ---------------------------------------------------------------------------------

    def acceleration(self, phi: Array, omega: Array) -> Array:
        """Return that of the drive [rad/s2], (n,), at angles and speeds (n,): the torques on its
        shaft balance.

        Raises ComputationError if it does not exist.
        """
        solution = self._accelerating(phi=phi, omega=omega, q=self._coordinates(phi), **self._fixed)
        rate, step = solution["rate"][0], solution["step"][0]
        if np.all(np.abs(step) <= SOLVED * (1 + np.abs(rate))):
            return rate
        worst = np.degrees(phi[int(np.argmax(np.abs(step)))]) % 360
        raise ComputationError(
            f"{self.machine.name}: no acceleration balances the shaft at {worst:.6g} deg"
        )

    def motion(self, at: Array) -> Kernel:
        """Return the function from a speed at the first of some angles to speed and time at the
        others, by CVODES.

        Below a share of the speed without load the motor has stalled, and what follows means
        nothing.
        """
        symbols, size = self._symbols, self._symbols["q"].numel()
        state = ca.SX.sym("state", 2 + size)
        omega = ca.fmax(state[0], self.slowest)
        drive = self._accelerating.function(
            phi=symbols["phi"], omega=omega, q=state[2:], d=symbols["d"], h=symbols["h"]
        )
        slopes = [drive["rate"] / omega, 1 / omega]
        if self.machine.loops is not None:
            gaps, jacobian = split_gaps(
                self.machine.loops.gaps(symbols["phi"], symbols["d"], state[2:]), size
            )
            slopes.append(solve_system(jacobian, -ca.jacobian(gaps, symbols["phi"])).solution)
        p = ca.vertcat(symbols["d"], symbols["h"])
        dae = {"t": symbols["phi"], "x": state, "p": p, "ode": ca.vertcat(*slopes)}
        solver = ca.integrator("motion", "cvodes", dae, float(at[0]), at[1:].tolist(), INTEGRATOR)
        start, q, fixed = ca.MX.sym("start"), ca.MX.sym("q", size), ca.MX.sym("fixed", p.numel())
        ran = solver(x0=ca.vertcat(start, 0, q), p=fixed)["xf"][:2, :]
        return Kernel(
            ca.Function("motion", [start, q, fixed], [ran], ["start", "q", "fixed"], ["states"])
        )

    @property
    def slowest(self) -> float:
        """The speed below which the motor counts as stalled [rad/s]."""
        return STALLED * self.motor.idle

    def run(self, start: float, turns: int, samples: int) -> SpeedHistory:
        """Return the motion from a speed [rad/s] at the angle zero on, at `samples` equal steps a
        turn, with its end.

        Raises ComputationError, naming the angle, where the motor stalls.
        """
        at = TURN * np.arange(turns * samples + 1) / samples
        fixed = np.concatenate([self._point.d, self._point.h])
        if (turns, samples) not in self._motions:
            self._motions[turns, samples] = self.motion(at)
        ran = self._motions[turns, samples](
            start=start, q=self._coordinates(at[:1])[:, 0], fixed=fixed
        )["states"]
        omega, seconds = np.column_stack([[start, 0.0], ran])
        if np.any(stalled := omega <= self.slowest):
            angle = np.degrees(at[int(np.argmax(stalled))])
            raise ComputationError(
                f"{self.machine.name}: the motor stalls {angle:.6g} deg after the start; it needs "
                f"more torque at "
                "rest, or a larger flywheel"
            )
        return SpeedHistory(at, omega, self.acceleration(at % TURN, omega), float(seconds[-1]))

    def settle(self, start: float, samples: int) -> SpeedHistory:
        """Return the turn that ends at the speed at which it begins, sought from a speed [rad/s]
        on.

        Raises ComputationError if it does not exist, and as `run` does.
        """

        def missed(speed: float) -> float:
            return float(self.run(speed, 1, samples).omega[-1]) - speed

        root = scipy.optimize.root_scalar(
            missed, x0=start, x1=start + missed(start), xtol=REPEATS * start, rtol=REPEATS
        )
        if not root.converged:
            raise ComputationError(
                f"{self.machine.name}: no turn repeats itself near {start * RPM:.6g} r/min"
            )
        return self.run(float(root.root), 1, samples)

    def report(self, at: SpeedHistory) -> DriveState:
        """Return forces and powers along a motion."""
        return self.state(at.phi, at.omega, at.rate)

    def report_constant(self, phi: Array, speed: float) -> DriveState:
        """Return forces at angles (n,) at a constant speed [rad/s]."""
        return self.state(phi, np.full_like(phi, speed), np.zeros_like(phi))

    def state(self, phi: Array, omega: Array, rate: Array) -> DriveState:
        """Return what is reported at angles, speeds and accelerations (n,)."""
        folded = phi % TURN
        reported = self._reporting(
            phi=folded, omega=omega, rate=rate, q=self._coordinates(folded), **self._fixed
        )
        rows = {name: row[0] for name, row in reported.items()}
        values = {name: rows[name] for name in self.names}
        parts = {name: rows[name] for name in ("torque", "load", "stored", "lost", "inertia")}
        return DriveState(values, **parts)


@dataclass(frozen=True)
class MotorSettings(Record):
    """A motor and what turns with it, as the drive has them."""

    stall_Nm: float
    idle_rpm: float
    flywheel_kgm2: float


@dataclass(frozen=True)
class DriveSpeed(Record):
    """The drive's speed over a turn that repeats itself; the fluctuation is the range over the
    mean.
    """

    mean_rpm: float
    max_rpm: float
    min_rpm: float
    fluctuation: float
    max_deg: float
    min_deg: float


@dataclass(frozen=True)
class DrivenQuantity(Record):
    """A quantity in `unit` over the turn that repeats itself, and at the turn's mean speed, held
    constant.

    `change` is the most by which both differ at an angle.
    """

    unit: str
    max: float
    min: float
    max_deg: float
    min_deg: float
    constant_max: float
    constant_min: float
    change: float


@dataclass(frozen=True)
class DriveResult(Record):
    """`simulate --motor`: a turn that repeats itself, and that at its mean speed, held constant.

    `imbalance_W` is the most by which the motor's power misses the rate of all energies and the
    power of friction; `turns_rpm` are speeds at the starts of turns; `inertia_*_kgm2` are the
    machine's own, as the drive has it, without flywheel.
    """

    machine: str
    motor: MotorSettings
    samples: int
    speed: DriveSpeed
    motor_work_J: float
    friction_work_J: float
    imbalance_W: float
    turns_rpm: list[float]
    inertia_mean_kgm2: float
    inertia_max_kgm2: float
    inertia_min_kgm2: float
    quantities: dict[str, DrivenQuantity]


@dataclass(frozen=True)
class Drive:
    """The motion from the start, the turn that repeats itself, what is reported in it and at
    constant speed.
    """

    machine: Machine
    started: SpeedHistory
    turn: SpeedHistory
    driven: DriveState
    constant: DriveState
    result: DriveResult

    def columns(self) -> dict[str, Array]:
        """Return the turn as a table: quantities by keys, each in its unit."""
        chosen = {quantity.name: quantity.key for quantity in self.machine.results}
        driven, constant = (
            {key: self._evaluate_column(state, name) for name, key in chosen.items()}
            for state in (self.driven, self.constant)
        )
        return {
            "phi_deg": np.degrees(self.turn.phi[:-1]),
            "speed_rpm": self.turn.omega[:-1] * RPM,
            "acceleration_rad_s2": self.turn.rate[:-1],
            **driven,
            **{f"constant_{key}": values for key, values in constant.items()},
            "motor_Nm": self.driven.torque[:-1],
            "load_Nm": self.driven.load[:-1],
        }

    def _evaluate_column(self, state: DriveState, name: str) -> Array:
        values: Array = state.values[name][:-1] / self.machine.find_quantity(name).factor
        return values


def drive_machine(
    machine: Machine,
    motor: Motor,
    turns: int = 5,
    start: float | None = None,
    samples: int | None = None,
) -> Drive:
    """Return a machine at its own design, driven from a speed [rad/s] on, its own unless one is
    given.

    Raises InputError as `DrivenMachine`, ComputationError where the motor stalls.
    """
    driven = DrivenMachine(machine, motor)
    first = float(machine.data[machine.speed]) if start is None else start
    count = machine.samples if samples is None else samples
    started = driven.run(first, turns, count)
    turn = driven.settle(float(started.omega[-1]), count)
    mean = TURN / turn.seconds
    state, constant = driven.report(turn), driven.report_constant(turn.phi, mean)
    gap = state.torque * turn.omega - state.stored - state.lost
    result = DriveResult(
        machine=machine.name,
        motor=MotorSettings(motor.stall, motor.idle * RPM, motor.flywheel),
        samples=count,
        speed=_speed(turn, mean),
        motor_work_J=_integrate(state.torque),
        friction_work_J=_integrate(state.lost / turn.omega),
        imbalance_W=float(np.abs(gap).max()),
        turns_rpm=(started.omega[::count] * RPM).tolist(),
        inertia_mean_kgm2=float(state.inertia[:-1].mean()),
        inertia_max_kgm2=float(state.inertia.max()),
        inertia_min_kgm2=float(state.inertia.min()),
        quantities={
            machine.find_quantity(name).key: _quantity(machine, name, turn, state, constant)
            for name in driven.names
        },
    )
    return Drive(machine, started, turn, state, constant, result)


def _quantity(
    machine: Machine, name: str, turn: SpeedHistory, driven: DriveState, constant: DriveState
) -> DrivenQuantity:
    quantity = machine.find_quantity(name)
    changing, steady = (state.values[name][:-1] / quantity.factor for state in (driven, constant))
    high, low = (
        to_degrees(float(turn.phi[index_first_extremum(turn.phi[:-1], changing, sign)]))
        for sign in (1, -1)
    )
    return DrivenQuantity(
        unit=units.display_unit(quantity.key),
        max=float(changing.max()),
        min=float(changing.min()),
        max_deg=high,
        min_deg=low,
        constant_max=float(steady.max()),
        constant_min=float(steady.min()),
        change=float(np.abs(changing - steady).max()),
    )


def _speed(turn: SpeedHistory, mean: float) -> DriveSpeed:
    high, low = (
        to_degrees(float(turn.phi[index_first_extremum(turn.phi, turn.omega, sign)]))
        for sign in (1, -1)
    )
    fastest, slowest = float(turn.omega.max()), float(turn.omega.min())
    return DriveSpeed(
        mean_rpm=mean * RPM,
        max_rpm=fastest * RPM,
        min_rpm=slowest * RPM,
        fluctuation=(fastest - slowest) / mean,
        max_deg=high,
        min_deg=low,
    )


def _integrate(values: Array) -> float:
    return float(values[:-1].mean() * TURN)
