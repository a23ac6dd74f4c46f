"""What `planter drive` returns of any machine: the cycle that repeats itself, beside the same at constant speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.engine.drive import RPM, Course, Driven, Motor, State
from planter.engine.machine import Machine
from planter.files import units
from planter.kernels import Array
from planter.numerics.angles import TURN, turn_deg
from planter.numerics.extremes import first_extreme
from planter.records import Record


@dataclass(frozen=True)
class MotorGiven(Record):
    """A motor and what turns with it, as the drive has them."""

    stall_Nm: float
    idle_rpm: float
    flywheel_kgm2: float


@dataclass(frozen=True)
class Speed(Record):
    """The drive's speed over a turn that repeats itself; the fluctuation is the range over the mean."""

    mean_rpm: float
    max_rpm: float
    min_rpm: float
    fluctuation: float
    max_deg: float
    min_deg: float


@dataclass(frozen=True)
class DrivenQuantity(Record):
    """A quantity in `unit` over the turn that repeats itself, and at the turn's mean speed, held constant.

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
    """`planter drive`: a turn that repeats itself, and the same at its mean speed, held constant.

    `imbalance_W` is the most by which the motor's power misses the rate of all energies and the power of friction;
    `turns_rpm` are speeds at the starts of turns; `inertia_*_kgm2` are the machine's own, as the drive has it, without
    flywheel.
    """

    machine: str
    motor: MotorGiven
    samples: int
    speed: Speed
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
    """The motion from the start, the turn that repeats itself, what is reported in it and at constant speed."""

    machine: Machine
    started: Course
    turn: Course
    driven: State
    constant: State
    result: DriveResult

    def columns(self, names: dict[str, str] | None = None) -> dict[str, Array]:
        """Return the turn as a table: quantities by keys (all unless `names` has some), each in its unit."""
        chosen = names or {quantity.name: quantity.key for quantity in self.machine.results}
        own, other = ({key: self._shown(state, name) for name, key in chosen.items()} for state in self._states)
        return {
            "phi_deg": np.degrees(self.turn.phi[:-1]),
            "speed_rpm": self.turn.omega[:-1] * RPM,
            "acceleration_rad_s2": self.turn.rate[:-1],
            **own,
            **{f"constant_{key}": values for key, values in other.items()},
            "motor_Nm": self.driven.torque[:-1],
            "load_Nm": self.driven.load[:-1],
        }

    @property
    def _states(self) -> tuple[State, State]:
        return self.driven, self.constant

    def _shown(self, state: State, name: str) -> Array:
        values: Array = state.values[name][:-1] / self.machine.find_quantity(name).factor
        return values


def drive_machine(
    machine: Machine, motor: Motor, turns: int = 5, start: float | None = None, samples: int | None = None,
    names: tuple[str, ...] | None = None,
) -> Drive:  # fmt: skip
    """Return a machine at its own design, driven from a speed [rad/s] on, its own unless one is given.

    `names` are the quantities that are reported, all results without. Raises InputError as `Driven`,
    ComputationError where the motor stalls.
    """
    driven = Driven(machine, motor, names)
    first = float(machine.data[machine.speed]) if start is None else start
    count = machine.samples if samples is None else samples
    started = driven.run(first, turns, count)
    turn = driven.settle(float(started.omega[-1]), count)
    mean = TURN / turn.seconds
    own, constant = driven.report(turn), driven.report_constant(turn.phi, mean)
    gap = own.torque * turn.omega - own.stored - own.lost
    result = DriveResult(
        machine=machine.name,
        motor=MotorGiven(motor.stall, motor.idle * RPM, motor.flywheel),
        samples=count,
        speed=_speed(turn, mean),
        motor_work_J=_over_a_turn(own.torque),
        friction_work_J=_over_a_turn(own.lost / turn.omega),
        imbalance_W=float(np.abs(gap).max()),
        turns_rpm=(started.omega[::count] * RPM).tolist(),
        inertia_mean_kgm2=float(own.inertia[:-1].mean()),
        inertia_max_kgm2=float(own.inertia.max()),
        inertia_min_kgm2=float(own.inertia.min()),
        quantities={
            machine.find_quantity(name).key: _quantity(machine, name, turn, own, constant) for name in driven.names
        },
    )
    return Drive(machine, started, turn, own, constant, result)


def _quantity(machine: Machine, name: str, turn: Course, driven: State, constant: State) -> DrivenQuantity:
    quantity = machine.find_quantity(name)
    own, other = (state.values[name][:-1] / quantity.factor for state in (driven, constant))
    high, low = (turn_deg(float(turn.phi[first_extreme(turn.phi[:-1], own, sign)])) for sign in (1, -1))
    return DrivenQuantity(
        unit=units.unit(quantity.key),
        max=float(own.max()),
        min=float(own.min()),
        max_deg=high,
        min_deg=low,
        constant_max=float(other.max()),
        constant_min=float(other.min()),
        change=float(np.abs(own - other).max()),
    )


def _speed(turn: Course, mean: float) -> Speed:
    high, low = (turn_deg(float(turn.phi[first_extreme(turn.phi, turn.omega, sign)])) for sign in (1, -1))
    most, least = float(turn.omega.max()), float(turn.omega.min())
    return Speed(
        mean_rpm=mean * RPM,
        max_rpm=most * RPM,
        min_rpm=least * RPM,
        fluctuation=(most - least) / mean,
        max_deg=high,
        min_deg=low,
    )


def _over_a_turn(values: Array) -> float:
    return float(values[:-1].mean() * TURN)
