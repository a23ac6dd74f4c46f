"""`planter drive`: the device on a motor and a flywheel, and beside it at the constant speed that has the same mean."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.numerics.angles import turn_deg
from planter.numerics.extremes import first_extreme
from planter.planting.cycle import statistics
from planter.planting.drive import run
from planter.planting.drive.model import Driven, Motor, State
from planter.planting.drive.run import Course
from planter.planting.model import Device
from planter.planting.results.driven import DriveFound, MotorGiven, Speed

RPM = 30 / np.pi


@dataclass(frozen=True)
class Drive:
    """The motion from the start, the turn that repeats itself, forces in it and at constant speed, and the result."""

    started: Course
    turn: Course
    driven: State
    constant: State
    result: DriveFound

    def columns(self) -> dict[str, Array]:
        """The turn as a table."""
        return {
            "phi_deg": np.degrees(self.turn.phi[:-1]),
            "speed_rpm": self.turn.omega[:-1] * RPM,
            "acceleration_rad_s2": self.turn.rate[:-1],
            "support_N": self.driven.support[:-1],
            "constant_support_N": self.constant.support[:-1],
            "motor_Nm": self.driven.torque[:-1],
            "load_Nm": self.driven.load[:-1],
        }


def drive(
    device: Device, motor: Motor, turns: int = 5, start: float | None = None, samples: int | None = None
) -> Drive:
    """The device at its own design, driven from a speed [rad/s] on, its machine's unless told.

    Raises InputError for the printed model, ComputationError where the motor stalls.
    """
    driven = Driven(device, motor)
    first = device.machine.si("operation.speed_rpm") if start is None else start
    count = device.machine.objective.samples if samples is None else samples
    started = run.course(driven, first, turns, count)
    turn = run.settled(driven, float(started.omega[-1]), count)
    mean = run.TURN / turn.seconds
    found, constant = run.told(driven, turn), run.at_constant_speed(driven, turn.phi, mean)
    own, other = found.support[:-1], constant.support[:-1]
    gap = found.torque * turn.omega - found.stored - found.lost
    result = DriveFound(
        machine=device.machine.name,
        motor=MotorGiven(motor.stall, motor.idle * RPM, motor.flywheel),
        samples=count,
        speed=_speed(turn, mean),
        support_force=statistics(own),
        constant_speed=statistics(other),
        change_N=float(np.abs(own - other).max()),
        motor_work_J=_over_a_turn(found.torque),
        friction_work_J=_over_a_turn(found.lost / turn.omega),
        imbalance_W=float(np.abs(gap).max()),
        turns_rpm=(started.omega[::count] * RPM).tolist(),
    )
    return Drive(started, turn, found, constant, result)


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
    return float(values[:-1].mean() * run.TURN)
