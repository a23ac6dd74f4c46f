"""Kinematics of the planting device: angles by quadrature, rates by differences.

Closure and rolling of its gear pairs are laws of their families, in test_families.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from mpmath import mp
from numpy.typing import NDArray

from tests.support import joints, kinematics, machines, model
from tests.support.arithmetic import MPMATH
from tests.support.jets import Jet

Array = NDArray[np.float64]
TURN = 2 * np.pi
every_machine = pytest.mark.parametrize("name", machines.sampled(1, 3))


@every_machine
def test_stages_turn_once_a_turn(name: str) -> None:
    phi = np.random.default_rng(1).uniform(0, TURN, 50)
    now, later = (model.cycle(machines.device(name), angle).side1 for angle in (phi, phi + TURN))
    assert later["phi52"] - now["phi52"] == pytest.approx(TURN, abs=1e-12)
    assert later["phi72"] - now["phi72"] == pytest.approx(-TURN, abs=1e-12)


# --- angles by quadrature
# ------------------------------------------------------------------------------


def turned(gear: kinematics.Gear, start: mp.mpf, end: mp.mpf) -> mp.mpf:
    """Integral of the ratio between two polar angles of the inner gear, split at its joints."""
    edges = [k * 2 * mp.pi + joint for k in range(-2, 4) for joint in (mp.zero, mp.pi / gear.m)]
    inner = [edge for edge in edges if min(start, end) < edge < max(start, end)]
    points = [start, *sorted(inner), end]
    return mp.quad(
        lambda t: gear.contact(Jet(MPMATH.xp, t))[2].value, points, method="gauss-legendre"
    )


def quadrature_gap(name: str, phase: float = 0.0) -> float:
    """Largest difference of both stages' angles to quadrature; `phase` shifts the sun."""
    phi = np.random.default_rng(2).uniform(0, TURN, 3)
    side, gaps = model.cycle(machines.device(name), phi).side1, []
    with mp.workdps(17):
        device = kinematics.Device(machines.machine(name), MPMATH)
        start1, start2 = device["design.alpha3_deg"] + phase, device["design.beta6_deg"]
        for i, angle in enumerate(phi):
            phi52 = turned(device.sun, start1, start1 + mp.mpf(float(angle)))
            phi72 = -turned(device.gear6, start2, start2 + phi52)
            gaps += [abs(side["phi52"][i] - phi52), abs(side["phi72"][i] - phi72)]
    return float(max(gaps))


@every_machine
def test_angles_agree_with_quadrature(name: str) -> None:
    assert quadrature_gap(name) < 1e-10


def test_quadrature_shows_a_phase_off_by_a_millionth() -> None:
    assert quadrature_gap("wang2017", phase=1e-6) > 1e-8


# --- rates by differences, on both sides of every joint
# ------------------------------------------------

STEP, POINTS = 0.008, 9


def one_sided(values: Array, step: float, order: int) -> float:
    """Derivative at the first of equally spaced samples.

    >>> x = 1 + 0.01 * np.arange(9)
    >>> bool(abs(one_sided(np.exp(x), 0.01, 1) - np.e) < 1e-10)
    True
    """
    vandermonde = np.vander(np.arange(len(values)), increasing=True).T.astype(float)
    expected = np.zeros(len(values))
    expected[order] = 1 if order == 1 else 2
    return float(np.linalg.solve(vandermonde, expected) @ values) / step**order


def samples(start: float, step: float) -> Array:
    """Equally spaced angles to one side of a joint, the first just beside it."""
    return start + np.sign(step) * 1e-9 + step * np.arange(POINTS)


def beside_joints(name: str) -> Iterator[tuple[Array, float]]:
    """Samples before and after every joint of side 1 that reach no other one, and their step."""
    breakpoints = np.sort(joints.of_side(machines.machine(name)))
    for joint in breakpoints:
        for side in (1, -1):
            away = np.mod(side * (breakpoints - joint), TURN)
            step = side * min(STEP, away[away > 0].min() / POINTS)
            yield samples(joint, step), step


def rates_gap(name: str, speed: float) -> float:
    """Largest difference of the planet's rate and acceleration to differences, at a carrier
    speed.
    """
    gaps = []
    for phi, step in beside_joints(name):
        side = model.cycle(machines.device(name), phi).side1
        gaps.append(one_sided(side["phi72"], step, 1) * speed + speed - side["Omega"][0])
        gaps.append(one_sided(side["Omega"], step, 1) * speed - side["Omega_dot"][0])
    return float(np.abs(gaps).max())


@every_machine
def test_train_rates_agree_with_differences_off_breakpoints(name: str) -> None:
    speed = machines.machine(name).si("speed_rpm")
    assert rates_gap(name, speed) < 1e-7
    assert rates_gap(name, speed * (1 + 1e-6)) > 1e-6


@every_machine
def test_swing_agrees_with_differences_off_breakpoints(name: str) -> None:
    """Angles are the model's; its rates are inside it, so they are the independent ones that its
    forces agree with.
    """
    device, machine = machines.device(name), machines.machine(name)
    for phi, step in beside_joints(name):
        swing = model.cycle(device, phi).side1["theta1"]
        motion = kinematics.Device(machine).side(phi[:1]).theta1
        for order in (1, 2):
            slope = one_sided(swing, step, order) * machine.si("speed_rpm") ** order
            assert slope == pytest.approx(motion.parts[order].item(), abs=1e-3), (
                f"order {order} at {phi[0]}"
            )


def test_curvature_jumps_at_a_joint() -> None:
    """What differences across a joint would miss."""
    device = machines.device("wang2017")
    stage, parameters = device.stages[0], device.of_stage(0, device.design)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]
    left, right = (
        stage.contact(t=samples(0.0, step)[:1], parameters=parameters, hoisted=hoisted)["ddr"]
        for step in (-STEP, STEP)
    )
    assert abs(left - right) > 1e-3
