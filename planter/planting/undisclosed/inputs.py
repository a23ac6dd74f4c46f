"""Inputs that a paper does not disclose, with bounds: paths in the machine file, and points of the unit box."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib.resources import files
from typing import Any

import numpy as np

from planter.files import units
from planter.files.text import parse_toml
from planter.kernels import Array
from planter.planting import cycle
from planter.planting.model import Device

START, END = "cam.{}_delta_deg[0]", "cam.{}_delta_deg[1]"
MASS, CENTROID = "mass.planet_kg", ("centroid.planet_xy_mm[0]", "centroid.planet_xy_mm[1]")
INERTIA = "inertia.J7_about_B1_kg_m2"
DEG = units.factor("_deg")


@cache
def data() -> dict[str, Any]:
    """The project's bounds, the events that the paper gives, and its figures."""
    name = "calibration.toml"
    return parse_toml(files("planter.planting").joinpath(name).read_text(encoding="utf-8"), name)


@dataclass(frozen=True)
class Inputs:
    """Paths in the machine file, with bounds (n,) in SI.

    The bounds of a path that comes `after` another one are those of its distance from that. The planet body's moment of
    inertia about its pin follows its mass and centroid, its centroidal one, `own` [kg m2], staying: a body must remain.
    """

    paths: tuple[str, ...]
    lower: Array
    upper: Array
    own: float
    after: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def wide(cls, device: Device) -> Inputs:
        """Bounds from common sense alone."""
        bounds = data()["bounds"]
        factors = np.array([units.factor(path) for path in bounds])
        low, high = np.array(list(bounds.values()), dtype=float).T
        si = device.machine.si
        own = si(INERTIA) - si(MASS) * sum(si(path) ** 2 for path in CENTROID)
        return cls(tuple(bounds), low * factors, high * factors, own)

    @classmethod
    def with_events(cls, device: Device) -> Inputs:
        """The same, with the cam's flanks where the paper sees the nozzles open and close."""
        found, events = cls.wide(device), data()["events"]
        low, high = found.lower.copy(), found.upper.copy()
        for flank, seen in own_angles(device).items():
            ends = cam_angles(device, seen + events["within_deg"] * DEG * np.array([-1.0, 1.0]))
            start, end = (found.paths.index(path.format(flank)) for path in (START, END))
            low[start], high[start] = ends
            low[end], high[end] = np.multiply(events["flank_deg"], DEG)
        return replace(found, lower=low, upper=high, after={END.format(f): START.format(f) for f in ("rise", "fall")})

    def __len__(self) -> int:
        return len(self.paths)

    def places(self, device: Device) -> list[int]:
        """Where the inputs, and what follows from them, stand among a device's constants, (n + 1,)."""
        shown = [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]
        return [shown.index(path) for path in (*self.paths, INERTIA)]

    def values(self, z: Array) -> Array:
        """Values in SI of a point in the unit box, (n + 1,): the inputs, and the moment of inertia that follows."""
        own = self._inputs(z)
        mass, x, y = own[self._body]
        return np.append(own, self.own + mass * (x**2 + y**2))

    def slopes(self, z: Array) -> Array:
        """Derivatives of the values in the point, (n + 1, n)."""
        mass, x, y = self._inputs(z)[self._body]
        follows = np.array([x**2 + y**2, 2 * mass * x, 2 * mass * y])
        along = self._summed * (self.upper - self.lower)
        return np.vstack([along, follows @ along[self._body]])

    def _inputs(self, z: Array) -> Array:
        found: Array = self._summed @ (self.lower + z * (self.upper - self.lower))
        return found

    @cached_property
    def _body(self) -> list[int]:
        return [self.paths.index(path) for path in (MASS, *CENTROID)]

    def point(self, values: Array) -> Array:
        """The point of values of the inputs in SI, taken into the unit box, (n,)."""
        own = np.linalg.solve(self._summed, values)
        return np.clip((own - self.lower) / (self.upper - self.lower), 0, 1)

    def table(self, z: Array) -> list[dict[str, Any]]:
        """Values with their bounds, in shown units; what follows from others has no room."""
        values = self.values(z)
        starts = (self._summed - np.eye(len(self))) @ values[:-1]
        ends = (np.append(starts + bound, values[-1]) for bound in (self.lower, self.upper))
        rows = zip((*self.paths, INERTIA), values, *ends, strict=True)
        return [
            {"name": path, "value": float(value / units.factor(path)), "unit": units.unit(path) or "1",
             "lower": float(low / units.factor(path)), "upper": float(high / units.factor(path)),
             "origin": "calibrated"}
            for path, value, low, high in rows
        ]  # fmt: skip

    @cached_property
    def _summed(self) -> Array:
        """Values from values and distances: the path that another one comes after is added to it."""
        found = np.eye(len(self.paths))
        for path, before in self.after.items():
            found[self.paths.index(path), self.paths.index(before)] = 1.0
        return found


def own_angles(device: Device) -> dict[str, float]:
    """Carrier angle, counted as side 1 counts it, at which each flank begins by the events that the paper sees [rad].

    Side 2 is half a turn behind. The nozzle that is higher at the carrier angle zero is the upper one. Raises
    ValueError where the events of the two sides are not half a turn apart.
    """
    columns = cycle.evaluate_cycle(device, device.prologue(device.design), np.zeros(1)).sides
    upper = int(columns[1]["tip_y_mm"][0] > columns[0]["tip_y_mm"][0])
    found: dict[str, set[float]] = defaultdict(set)
    for event in data()["events"]["seen"]:
        side = upper if event["nozzle"] == "upper" else 1 - upper
        found[event["flank"]].add((event["carrier_deg"] - 180 * side) % 360)
    if any(len(angles) > 1 for angles in found.values()):
        raise ValueError("the events of the two nozzles are not half a turn apart")
    return {flank: angles.pop() * DEG for flank, angles in found.items()}


def cam_angles(device: Device, phi: Array) -> Array:
    """The cam's angle delta at carrier angles of side 1 [rad], in [0, 2 pi)."""
    turned = cycle.evaluate_cycle(device, device.prologue(device.design), phi).sides[0]["phi72_deg"]
    found: Array = np.mod(-turned * DEG, 2 * np.pi)
    return found
