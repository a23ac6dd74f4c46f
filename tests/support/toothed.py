"""Toothed pairs to try: circles, stages of any family, and what is measured of them without any
envelope.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import shapely

from planter.gears.geometry.cutting import ToothedPair, ToothOrder, cut_teeth
from planter.gears.geometry.flanks import Flanks, Rack
from planter.gears.geometry.gear import Gear
from planter.gears.geometry.pitch_curves import build_circle_pair, build_stage_pair
from planter.kernels import Array
from tests.support import pairs

FREE = ToothOrder(process="wire", allow_undercut=True)
"""Nothing is refused for how it would be cut."""
REFUSED = {
    ("sine", 5): "does not reach its tip, where the pitch curve is hollow",
    ("fourier", 4): "and the next no teeth touch for",
}
"""Curves drawn at random that have no teeth, and why."""


def circle(z: int, rack: Rack) -> Gear:
    """A gear on a circle."""
    curves = build_circle_pair(z * rack.module / 2, z * rack.module / 2)
    return Gear("gear", Flanks(curves.gear, rack, z, 0.0))


def circles(z: int, mate: int, order: ToothOrder) -> ToothedPair:
    """Two circular gears of module 2 mm."""
    return cut_teeth(
        build_circle_pair(1e-3 * z, 1e-3 * mate), replace(order, teeth=z), "pair", ("gear", "mate")
    )


@cache
def stage(family: str, seed: int, z: int, order: ToothOrder = FREE, sense: int = 1) -> ToothedPair:
    """A pair of a family at a size that is drawn at random."""
    curves = build_stage_pair(pairs.stage(family, seed), pairs.parameters(family, seed), sense)
    return cut_teeth(curves, replace(order, teeth=z), family, ("gear", "mate"))


def involute(angle: float) -> float:
    return math.tan(angle) - angle


def swept(gear: Gear, tooth: int, steps: int = 700, offset: float = 0.0) -> float:
    """Area in which a tooth space and what a rack leaves of it differ, in parts of the space's.

    The rack is a polygon, its round a fine one; it stands still on its pitch line while that rolls
    over the pitch curve step by step, `beside` [m] where it should be. No condition of an envelope
    is used.
    """
    p, sizes = gear.rack.pitch, gear.rack.sizes
    middle = gear.flanks.phase + p * (tooth + 0.5)
    outline = shapely.Polygon(gear.sampled(np.arange(150) / 150).points.reshape(2, -1).T)
    parameters = middle + np.linspace(-0.5, 0.5, 400) * p
    top, deep = (
        _count_offset(gear, parameters, sizes["tip"]),
        _count_offset(gear, parameters, -2 * sizes["root"]),
    )
    blank = shapely.Polygon(np.vstack([top, deep[::-1]]))
    profile = _profile(gear.rack) + np.array([middle + offset, 0.0])
    racks = []
    for s in middle + np.linspace(-3.5, 3.5, steps) * p:
        x, y, tx, ty = gear.curve.at(np.array([s]))[:4, 0]
        tangent, out = np.array([tx, ty]), np.array([ty, -tx])
        racks.append(
            shapely.Polygon(
                np.array([x, y]) + (profile[:, :1] - s) * tangent + profile[:, 1:] * out
            )
        )
    left, mate = blank.difference(shapely.union_all(racks)), blank.intersection(outline)
    return left.symmetric_difference(mate).area / (blank.area - mate.area)


def _count_offset(gear: Gear, s: Array, height: float) -> Array:
    x, y, tx, ty = gear.curve.at(s)[:4]
    return np.array([x + height * ty, y - height * tx]).T


def _profile(rack: Rack) -> Array:
    """One tooth of the rack: along its pitch line from its middle, and outwards; by tangent lines
    and circles.
    """
    alpha, root = rack.pressure_angle, rack.sizes["root"]
    half = rack.pitch / 2 - rack.sizes["half"]
    r = rack.sizes["round_"]
    top = 2 * rack.sizes["tip"]
    centre = np.array([half - (root - r) * math.tan(alpha) - r / math.cos(alpha), r - root])
    turn = np.linspace(-alpha, -np.pi / 2, 300)
    corner = centre + r * np.column_stack([np.cos(turn), np.sin(turn)])
    right = np.vstack([[half + top * math.tan(alpha), top], corner])
    return np.vstack([right, (right * np.array([-1, 1]))[::-1]])
