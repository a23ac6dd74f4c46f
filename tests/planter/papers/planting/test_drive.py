"""The planting device on a motor and a flywheel: energy, limits, and the models that it must agree
with.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from planter.engine.drive import Drive, DrivenMachine, Motor, SpeedHistory, drive_machine
from planter.errors import InputError
from planter.papers.planting.motor_drive import build_driven_machine
from tests.support import machines

SPEED = 40 * np.pi / 30
MOTOR = Motor(6.0, 1.05 * SPEED, 0.1)
PHI = np.radians(np.arange(0.0, 360.0, 3.0))


@cache
def driven(name: str = "wang2017", flywheel: float = 0.1) -> DrivenMachine:
    machine = build_driven_machine(machines.device(name))
    return DrivenMachine(machine, replace(MOTOR, flywheel=flywheel), ["F_support"])


def drive(motor: Motor = MOTOR, turns: int = 1, samples: int | None = None) -> Drive:
    return drive_machine(
        build_driven_machine(machines.device("wang2017")), motor, turns, samples=samples
    )


def imbalance(model: DrivenMachine, at: SpeedHistory, more: float = 0.0) -> float:
    """Power of the motor less the rate of all energies and what friction takes, over its own
    largest value.
    """
    residual = model.report(at)
    power = residual.torque * at.omega
    return float(
        np.abs(power - residual.stored - (1 + more) * residual.lost).max() / np.abs(power).max()
    )


@pytest.mark.parametrize("name", ["wang2017", "random 1", "random 3"])
def test_motor_work_is_stored_or_lost(name: str) -> None:
    model = driven(name)
    at = model.run(SPEED, 1, 120)
    assert np.ptp(at.omega) > 1e-2 * SPEED
    assert imbalance(model, at) < 1e-9
    assert imbalance(model, at, 1e-6) > 1e-9, "a millionth of the friction is noticed"
    wrong = replace(at, rate=at.rate * (1 + 1e-6))
    assert imbalance(model, wrong) > 1e-9, "a millionth of the acceleration is noticed"


def test_at_constant_speed_it_is_the_exact_model() -> None:
    device = machines.device("wang2017")
    report = driven().report_constant(PHI, device.machine.si("operation.speed_rpm"))
    assert report.values["F_support"] == pytest.approx(
        device.support(device.prologue(device.design), PHI), abs=1e-11
    )


def test_periodic_cycle_balances_motor_and_friction() -> None:
    driven = drive(turns=2, samples=720)
    turn, result = driven.turn, driven.result
    assert turn.omega[-1] == pytest.approx(turn.omega[0], rel=1e-9)
    assert result.motor_work_J == pytest.approx(result.friction_work_J, rel=1e-5)
    assert result.speed.min_rpm < result.speed.mean_rpm < result.speed.max_rpm
    half = len(turn.omega) // 2
    assert turn.omega[:half] == pytest.approx(turn.omega[half:-1], rel=1e-8), (
        "both sides do the same, half a turn apart"
    )


def test_invalid_motor_is_refused() -> None:
    with pytest.raises(InputError, match="--flywheel-kgm2 = -1: it must be greater than 0"):
        replace(MOTOR, flywheel=-1.0)
    with pytest.raises(InputError, match="drives the exact model"):
        build_driven_machine(machines.device("wang2017", "printed"))
