"""The curve along points that move with the design: a sample stands still, a peak or a joint does not.

With the angle psi(x) of a point, f(x) = F(psi(x), x) has

    f_x  = F_x + F_phi psi_x
    f_xx = F_xx + F_xphi psi_x + psi_x' F_phix + F_phiphi psi_x' psi_x + F_phi psi_xx.

At a smooth peak F_phi = 0 and psi_x = -F_phix / F_phiphi, which leaves the envelope theorem, f_x = F_x, and
f_xx = F_xx - F_xphi F_phix / F_phiphi. On a joint both sides of F give the same f_x and f_xx, since F is continuous.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array


@dataclass(frozen=True)
class PointMotion:
    """How m points move: `velocity` (m, p) and `acceleration` (m, p, p), derivatives of their angles in the design."""

    velocity: Array
    acceleration: Array


def gradients(slopes: Array, velocity: Array) -> Array:
    """Gradients (m, p) along moving points from Jacobians (m, 1 + p) in (phi, x)."""
    total: Array = slopes[:, 1:] + slopes[:, :1] * velocity
    return total


def hessians(slopes: Array, second: Array, motion: PointMotion) -> Array:
    """Hessians (m, p, p) along moving points from Jacobians (m, 1 + p) and Hessians (m, 1 + p, 1 + p) in (phi, x)."""
    mixed = second[:, 1:, :1] * motion.velocity[:, None, :]
    squared = motion.velocity[:, :, None] * motion.velocity[:, None, :]
    total: Array = second[:, 1:, 1:] + mixed + mixed.transpose(0, 2, 1) + second[:, :1, :1] * squared
    return total + slopes[:, :1, None] * motion.acceleration


def peak_velocity(second: Array) -> Array:
    """Velocity (m, p) of smooth peaks from Hessians (m, 1 + p, 1 + p): -F_phix / F_phiphi."""
    velocity: Array = -second[:, 0, 1:] / second[:, :1, 0]
    return velocity


def still(count: int, size: int) -> PointMotion:
    """Points that stand still."""
    return PointMotion(np.zeros((count, size)), np.zeros((count, size, size)))
