"""Pitch curves in mesh: they touch, share a tangent, roll on each other, and turn as the mechanism
does.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.toothed import Gearing, PlottedPitchCurve, locate_pitch_curves

ANGLES = (0.0, 37.0, 100.0, 200.0, 333.0)
MACHINES = ("wang2017", "compact")
PAIRS = ((0, 1), (2, 3))


@cache
def device(name: str) -> Device:
    return Device(load(name))


@cache
def at(name: str, phi_deg: float) -> Gearing:
    return locate_pitch_curves(device(name), device(name).design, phi_deg, samples=4000)


def side(name: str, phi_deg: float, quantity: str) -> float:
    """A quantity of side 1 from the equations of motion, in SI."""
    pair = device(name)
    names = [entry["name"] for entry in pair.sidecar["vectors"]["side"]]
    lanes = pair.cycle(pair.prologue(pair.design), np.array([np.radians(phi_deg)]))["side1"]
    return float(lanes[names.index(quantity), 0])


def polar(curve: PlottedPitchCurve, turned: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Polar angle, less a rotation, and radius of a curve about its centre, sorted by angle."""
    x, y = curve.points[:, :-1] - curve.centre[:, None]
    angle = np.mod(np.arctan2(y, x) - turned, 2 * np.pi)
    order = np.argsort(angle)
    return angle[order], np.hypot(x, y)[order]


def difference(first: PlottedPitchCurve, other: PlottedPitchCurve, turned: float) -> float:
    """Largest difference in radius between a curve and another that was turned since [mm]."""
    angle, radius = polar(first)
    radii = np.interp(angle, *polar(other, turned), period=2 * np.pi)
    return float(np.abs(radii - radius).max())


def tangent(curve: PlottedPitchCurve) -> float:
    """Direction of the curve at its first point, in [0, pi)."""
    x, y = curve.points[:, 1] - curve.points[:, -2]
    return float(np.arctan2(y, x) % np.pi)


def overlap(inner: PlottedPitchCurve, outer: PlottedPitchCurve) -> float:
    """How deep points of one curve lie inside the other [mm]."""
    angle, radius = polar(inner)
    x, y = outer.points - inner.centre[:, None]
    return float(
        (np.interp(np.arctan2(y, x), angle, radius, period=2 * np.pi) - np.hypot(x, y)).max()
    )


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("phi", ANGLES)
def test_pairs_touch_on_the_centre_line(name: str, phi: float) -> None:
    curves = at(name, phi)
    for pair, contact in zip(PAIRS, "PQ", strict=True):
        inner, outer = (curves.curves[i] for i in pair)
        for curve in (inner, outer):
            assert np.abs(curve.points[:, 0] - curves.contacts[contact]).max() < 1e-9
            assert np.abs(curve.points[:, -1] - curve.points[:, 0]).max() < 1e-9
        tangential = (curves.contacts[contact] - inner.centre) / np.hypot(
            *(outer.centre - inner.centre)
        )
        line = (outer.centre - inner.centre) / np.hypot(*(outer.centre - inner.centre))
        assert abs(tangential[0] * line[1] - tangential[1] * line[0]) < 1e-12
        assert 0 < tangential @ line < 1


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("phi", ANGLES)
def test_pairs_have_a_common_tangent_and_do_not_cross(name: str, phi: float) -> None:
    curves = at(name, phi)
    for inner, outer in ((curves.curves[i], curves.curves[j]) for i, j in PAIRS):
        difference = abs(tangent(inner) - tangent(outer))
        assert min(difference, np.pi - difference) < 1e-5
        assert overlap(inner, outer) < 1e-4


@pytest.mark.parametrize("phi", ANGLES)
def test_slightly_turned_partner_is_detected(phi: float) -> None:
    inner, outer = at("wang2017", phi).curves[:2]
    c, s = np.cos(0.02), np.sin(0.02)
    points = (
        np.array([[c, -s], [s, c]]) @ (outer.points - outer.centre[:, None]) + outer.centre[:, None]
    )
    turned = replace(outer, points=points)
    difference = abs(tangent(inner) - tangent(turned))
    assert min(difference, np.pi - difference) > 1e-3 or overlap(inner, turned) > 1e-3


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("phi", ANGLES[1:])
def test_gears_turn_as_the_mechanism_does(name: str, phi: float) -> None:
    start, now = at(name, 0.0), at(name, phi)
    middle = np.radians(phi) + side(name, phi, "phi52")
    planet = np.radians(phi) + side(name, phi, "phi72")
    for index, turned in ((0, 0.0), (1, middle), (2, middle), (3, planet)):
        assert difference(start.curves[index], now.curves[index], turned) < 1e-4
        assert difference(start.curves[index], now.curves[index], turned + 0.05) > 5e-3
