"""Exact gradients of the support force against complex step through the array code (Squire and
Trapp, SIAM Rev. 1998).

An error counts by what it does to a design that moves through its box: |error_i| w_i, beside the
largest |g_j| w_j.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from tests.support import joints, machines, model, xp_complex

Array = NDArray[np.float64]
TOLERANCE = 1e-9
AWAY = 1e-3
"""Least distance of a carrier angle from anything that is not smooth [rad]."""
every_model = pytest.mark.parametrize("kind", MODELS)


def support(device: Device, z: Array) -> Array:
    """Vertical support force from (phi, x), by array code on complex numbers."""
    return model.ArrayModel.like(device)(xp_complex, z[0], z[1:], device.constants).totals[
        "F_support"
    ]


def widths(device: Device) -> Array:
    """Of the box of (phi, x); phi moves through a turn."""
    return np.concatenate([[2 * np.pi], device.upper - device.lower])


def smooth_point(device: Device, rng: np.random.Generator) -> tuple[float, Array]:
    """A random angle and design, away from joints and from changes of flank."""
    while True:
        phi, design = rng.uniform(0, 2 * np.pi), machines.design_near(device, rng)
        if not joints.distance_from_breakpoints(device, design, phi, AWAY):
            return phi, design


def errors(device: Device, phi: float, design: Array) -> tuple[Array, Array]:
    """Gradient in (phi, x) of the generated derivative and its error, both per width of the box."""
    force, slopes = device.support_slopes(device.prologue(design), np.array([phi]))
    z = np.concatenate([[phi], design])
    assert force[0] == pytest.approx(float(np.real(support(device, z.astype(complex)))), abs=1e-10)
    expected = xp_complex.slopes(lambda moved: support(device, moved), z)
    return slopes[0] * widths(device), (slopes[0] - expected) * widths(device)


@every_model
def test_a_gradient_at_a_neighbouring_angle_fails(kind: Model) -> None:
    device, rng = machines.device("wang2017", kind), np.random.default_rng(4)
    phi, design = smooth_point(device, rng)
    _, slopes = device.support_slopes(device.prologue(design), np.array([phi + 1e-6]))
    expected = xp_complex.slopes(
        lambda moved: support(device, moved), np.concatenate([[phi], design])
    )
    gap = np.abs(slopes[0] - expected) * widths(device)
    assert gap.max() > TOLERANCE * np.abs(expected[1:] * widths(device)[1:]).max()


@every_model
def test_a_missing_prologue_fails(kind: Model) -> None:
    """Without the way through centre distance and series the derivative is another one."""
    device, rng = machines.device("wang2017", kind), np.random.default_rng(4)
    phi, design = smooth_point(device, rng)
    at = device.prologue(design)
    _, gradient = device.support_slopes(at, np.array([phi]))
    _, part = device.support_slopes(replace(at, dh=0 * at.dh), np.array([phi]))
    assert np.abs((gradient - part) * widths(device)).max() > 1e-3
