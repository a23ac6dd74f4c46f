"""Carrier angles at which a planting device is not smooth, from the independent kinematics and by
sign changes.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from tests.support import kinematics, machines, model

Array = NDArray[np.float64]
TURN = 2 * np.pi


def roots(f: Callable[[Array], Array]) -> list[float]:
    """Angles within a turn at which a vectorised function changes sign.

    >>> [round(root, 6) for root in roots(lambda phi: np.cos(phi))]
    [1.570796, 4.712389]
    """
    grid = np.linspace(0, TURN, 721)
    values = f(grid)
    places = np.flatnonzero(values[:-1] * values[1:] < 0)
    return [
        brentq(lambda p: f(np.array([p]))[0], grid[i], grid[i + 1], xtol=1e-15, rtol=1e-15)
        for i in places
    ]


def gauss_points(edges: Array, count: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss-Legendre quadrature, so many between neighbouring edges."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    return (middle + half * nodes).ravel(), (half * weights).ravel()


def passages(machine: PlantingMachine) -> list[tuple[Callable[[kinematics.Side], Array], float]]:
    """Angles of the train, and values at which they meet a joint of a pitch curve or of a cam
    flank.
    """
    positions = (0.0, *kinematics.INNER_JOINTS.get(machine.cam.flank, ()), 1.0)
    ends = [[machine.si(f"{flank}_delta_deg[{i}]") for i in (0, 1)] for flank in ("rise", "fall")]
    flanks = [start + x * (end - start) for start, end in ends for x in positions]
    return [
        *((lambda side: side.t1.value, edge) for edge in (0.0, np.pi / machine.si("design.m31"))),
        *((lambda side: side.t2.value, edge) for edge in (0.0, np.pi / machine.si("design.m61"))),
        *((lambda side: -side.phi72.value, edge) for edge in flanks),
    ]


def of_side(machine: PlantingMachine) -> list[float]:
    """Where side 1 meets them within a turn of the carrier."""
    device = kinematics.Device(machine)
    angles = []
    for angle, edge in passages(machine):
        angles += roots(lambda phi: np.sin((angle(device.side(phi)) - edge) / 2))  # noqa: B023
    return angles


def of_teeth(device: Device) -> list[float]:
    """Where another flank of a tooth of side 1 begins to bear."""

    def find(name: str) -> list[float]:
        return roots(lambda phi: model.cycle(device, phi).side1[name])

    return [*find("M_P"), *find("M_Q")]


@cache
def of_both_sides(name: str) -> Array:
    """All of them in a turn, of side 1 and of side 2, sorted."""
    first = [*of_side(machines.machine(name)), *of_teeth(machines.device(name))]
    return np.unique([*first, *np.mod(np.add(first, np.pi), TURN)])


@cache
def panels(name: str) -> tuple[Array, Array]:
    """Nodes and weights of Gauss-Legendre quadrature over a turn, split at the joints and once
    between.
    """
    edges = np.unique([0, *of_both_sides(name), TURN])
    edges = np.sort(np.concatenate([edges, (edges[1:] + edges[:-1]) / 2]))
    return gauss_points(edges, 20)


def distance_from_breakpoints(device: Device, design: Array, phi: float, away: float) -> bool:
    """Whether anything of either side is not smooth within `away` of a carrier angle, at a
    design.
    """
    changed = zip(device.names, design / device.scale, strict=True)
    moved = device.machine.with_numbers({f"design.{name}": float(value) for name, value in changed})
    side = kinematics.Device(moved).side(np.array([phi, phi - np.pi]))
    gaps = [np.abs(np.sin((angle(side) - edge) / 2)) for angle, edge in passages(moved)]
    sides = device.cycle(device.prologue(design), phi + away * np.array([-1, 0, 1]))
    rows = [
        i
        for i, entry in enumerate(device.sidecar["vectors"]["side"])
        if entry["name"] in ("M_P", "M_Q")
    ]
    signs = np.sign([sides["side1"][rows], sides["side2"][rows]])
    return bool(np.min(gaps) < away or (signs != signs[..., :1]).any())
