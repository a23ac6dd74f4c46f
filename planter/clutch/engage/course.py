"""Where the linkage wants the sleeve: link angle over time, and the crank slider behind it.

The crank gear rolls on the fixed rack, so against the link it turns r_D/r_A times as far as the link does, from the
start of mesh on; the rod then carries the pin along the guide.
"""

from __future__ import annotations

import casadi as ca

from planter.clutch.engage.inputs import Symbols


def link_angle(t: ca.SX, p: Symbols) -> ca.SX:
    """Inclination of the link [rad] at a time [s]: at a constant rate from start to end, at rest before and after."""
    span = ca.fabs(p.link_end - p.link_start)
    share = ca.fmin(ca.fmax(t * p.link_speed / span, 0), 1)
    return p.link_start + (p.link_end - p.link_start) * share


def sleeve(t: ca.SX, p: Symbols) -> ca.SX:
    """Travel to which the linkage has pushed the sleeve [m], 0 where the clutch is engaged."""
    turned = p.link_ratio * ca.fmax(link_angle(t, p) - p.mesh_angle, 0)
    start = ca.acos((p.distance**2 + p.crank**2 - p.rod**2) / (2 * p.distance * p.crank))
    angle = start - turned
    return p.crank * ca.cos(angle) + ca.sqrt(p.rod**2 - (p.crank * ca.sin(angle)) ** 2) - p.distance
