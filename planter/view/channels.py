"""The motion of a scene, packed for the drawing: constants as numbers, series as float32 in one base64 text."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from planter.kernels import Array
from planter.view.scene import Scene

Record = Mapping[str, Any]
EVEN = 1e-9
"""Deviation of a linear series from its line, relative to its range; it is below the resolution of float32."""


class Channels:
    """Series (n,) in one block of float32, each referred to by its number.

    A constant series is replaced by its value, and a linear one by its first value and its step.
    """

    def __init__(self, moments: int) -> None:
        self.moments = moments
        self._series: list[bytes] = []
        self._numbers: dict[bytes, int] = {}

    def add(self, values: float | Array) -> float | dict[str, float]:
        """Add a series, and return its value, its first value and step, or the number of its series and its lead.

        A series that equals an earlier one shifted by half a cycle refers to that one.
        """
        exact = np.broadcast_to(np.asarray(values, dtype=float), (self.moments,))
        series = exact.astype("<f4")
        if np.ptp(series) == 0:
            return float(series[0])
        if np.ptp(exact - np.linspace(exact[0], exact[-1], self.moments)) < EVEN * np.ptp(exact):
            return {"from": float(exact[0]), "step": float(exact[-1] - exact[0]) / (self.moments - 1)}
        for ahead in (0, self.moments // 2):
            number = self._numbers.get(np.roll(series, ahead).tobytes())
            if number is not None:
                return {"series": number, "ahead": ahead}
        self._numbers[series.tobytes()] = len(self._series)
        self._series.append(series.tobytes())
        return {"series": len(self._series) - 1, "ahead": 0}

    def text(self) -> str:
        """Return all series, one after another, in base64."""
        return base64.b64encode(b"".join(self._series)).decode("ascii")


def course(scene: Scene) -> Record:
    """Return the curves of a scene in the format of `packed`."""
    series = Channels(scene.moments)
    curves = _curves(scene, series)
    return {"moments": scene.moments, "curves": curves, "data": series.text()}


def _curves(scene: Scene, series: Channels) -> list[dict[str, Any]]:
    return [{"name": curve.name, "unit": curve.unit, "values": series.add(curve.values), "reference": curve.reference}
            for curve in scene.curves]  # fmt: skip


def packed(scene: Scene) -> Record:
    """Return the JSON record that animates the picture of a scene; bodies are in the order of the picture."""
    series = Channels(scene.moments)
    return {
        "moments": scene.moments,
        "seconds": scene.seconds,
        "place": scene.place,
        "unit": scene.unit,
        "places": series.add(scene.places),
        "shares": series.add(scene.times),
        "travel": series.add(scene.travel) if scene.travel is not None and scene.travels else 0.0,
        "bodies": [[series.add(v) for v in (*body.at, body.turn)] for body in scene.all_bodies()],
        "points": [[series.add(v) for v in (point.x, point.y)] for point in scene.points],
        "chains": [{"points": list(chain.points), "closed": chain.closed} for chain in scene.chains],
        "forces": [[series.add(v) for v in (f.at.x, f.at.y, f.x, f.y)] for f in scene.forces],
        "largest_N": scene.largest_force,
        "curves": _curves(scene, series),
        "events": [[event.name, event.place] for event in sorted(scene.events, key=lambda e: e.place)],
        "data": series.text(),
    }
