"""The device in motion: the carrier's speed along its angle, from a start and once it repeats itself every turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize

from planter.errors import ComputationError
from planter.kernels import Array
from planter.planting.drive.model import Driven, State

TURN = 2 * np.pi
REPEATS = 1e-10
"""Share of the speed by which a settled turn may miss its own start."""


@dataclass(frozen=True)
class Course:
    """Angles (n,) [rad], speeds [rad/s] and accelerations [rad/s2] there, and the time that the motion takes [s]."""

    phi: Array
    omega: Array
    rate: Array
    seconds: float


def course(driven: Driven, start: float, turns: int, samples: int) -> Course:
    """The motion from a speed [rad/s] at the angle zero on, at `samples` equal steps a turn, its end included.

    Raises ComputationError, naming the angle, where the motor stalls.
    """
    at = TURN * np.arange(turns * samples + 1) / samples
    fixed = np.concatenate(list(driven.given.values()))
    omega, seconds = np.column_stack([[start, 0.0], driven.motion(at)(start=start, fixed=fixed)["states"]])
    if np.any(stalled := omega <= driven.slowest):
        place = np.degrees(at[int(np.argmax(stalled))])
        raise ComputationError(
            f"{driven.device.machine.name}: the motor stalls {place:.6g} deg after the start; it needs more torque at "
            "rest, or a larger flywheel"
        )
    return Course(at, omega, driven.acceleration(at % TURN, omega), float(seconds[-1]))


def settled(driven: Driven, near: float, samples: int) -> Course:
    """The turn that ends at the speed at which it begins, sought from a speed [rad/s] on.

    Raises ComputationError where there is none, and as `course` does.
    """

    def missed(speed: float) -> float:
        return float(course(driven, speed, 1, samples).omega[-1]) - speed

    found = scipy.optimize.root_scalar(missed, x0=near, x1=near + missed(near), xtol=REPEATS * near, rtol=REPEATS)
    if not found.converged:
        raise ComputationError(
            f"{driven.device.machine.name}: no turn repeats itself near {near * 30 / np.pi:.6g} r/min"
        )
    return course(driven, float(found.root), 1, samples)


def told(driven: Driven, at: Course) -> State:
    """Forces and powers along a motion."""
    return driven.state(at.phi % TURN, at.omega, at.rate)


def at_constant_speed(driven: Driven, phi: Array, speed: float) -> State:
    """Forces at angles (n,) at a constant speed [rad/s]."""
    return driven.state(phi % TURN, np.full_like(phi, speed), np.zeros_like(phi))
