"""Where the coordinates of closed loops are: Newton's method, from an assembly that is kept along the turn."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.kernels.formulas import Formulas

STEPS = 360
"""Steps of the walk along a turn; one that does not close is halved."""
LEAST = 1e-5
"""Least step of the walk [rad]."""
MOST = 50
CLOSED = 1e-13
"""A loop is closed where Newton's next step is below this share of the coordinates' size."""
SINGULAR = 1e-9
"""Below this share of its largest entries' product the Jacobian's determinant counts as zero."""


@dataclass(frozen=True)
class Loops:
    """The loops of a mechanism with values (n,) in SI."""

    model: Formulas
    data: Array

    @property
    def names(self) -> list[str]:
        return self.model.outputs("assembly")

    @cached_property
    def walk(self) -> tuple[Array, Array]:
        """Angles (m,) [rad] from 0 to a turn, and the coordinates there (k, m), one assembly all along.

        Raises ComputationError where a loop does not close, at a dead point, and where a turn does not lead back.
        """
        start = np.array(list(self.model.at("assembly", data=self.data).values()))
        first = self._closed(0.0, start)
        if isinstance(first, str):
            raise ComputationError(f"{self.model.name}: at 0 deg, from the start that is given, {first}")
        sense, angles, places = first[1], [0.0], [first[0]]
        step = 2 * np.pi / STEPS
        while angles[-1] < 2 * np.pi:
            target = min(angles[-1] + step, 2 * np.pi)
            slope = (places[-1] - places[-2]) / (angles[-1] - angles[-2]) if len(angles) > 1 else 0.0
            found = self._closed(target, places[-1] + slope * (target - angles[-1]))
            if isinstance(found, tuple) and np.sign(found[1]) == np.sign(sense):
                angles.append(target)
                places.append(found[0])
                step = min(2 * step, 2 * np.pi / STEPS)
            elif step > LEAST:
                step /= 2
            else:
                raise ComputationError(self._dead(angles[-1], found))
        self._check_return(places[0], places[-1])
        return np.array(angles), np.array(places).T

    def at(self, angles: Array) -> Array:
        """The coordinates (k, n) at angles (n,) [rad] of any turn."""
        known, places = self.walk
        within = np.mod(angles, 2 * np.pi)
        found = self.near(within, np.array([np.interp(within, known, row) for row in places]))
        if found is None:
            raise ComputationError(f"{self.model.name}: the loops do not close everywhere on the turn")
        return found + self._turns(angles, within)

    def near(self, angles: Array, places: Array) -> Array | None:
        """The coordinates (k, n) at angles (n,) in one turn near others; None where they lead to no common assembly."""
        found, before = places, None
        for _ in range(MOST):
            gaps, slopes = self._gaps(angles, found)
            signs = np.sign(np.linalg.det(slopes))
            if not np.isfinite(gaps).all() or np.any(signs == 0) or np.any(signs != signs[0]):
                return None
            before = signs[0] if before is None else before
            if signs[0] != before:
                return None
            found, closed = _newton(found, gaps, slopes)
            if closed:
                return found
        return None

    def _turns(self, angles: Array, within: Array) -> Array:
        """What coordinates gain by whole turns before an angle (k, n)."""
        _, places = self.walk
        return np.outer(places[:, -1] - places[:, 0], np.round((angles - within) / (2 * np.pi)))

    def _closed(self, angle: float, start: Array) -> tuple[Array, float] | str:
        """Coordinates (k,) that close the loops at an angle, and the determinant there; else what stays open."""
        at = start[:, None]
        for _ in range(MOST):
            gaps, slopes = self._gaps(np.array([angle]), at)
            determinant = float(np.linalg.det(slopes[0]))
            if abs(determinant) <= SINGULAR * np.prod(np.abs(slopes[0]).max(axis=0)):
                return "the bars lie in line"
            at, closed = _newton(at, gaps, slopes)
            if closed:
                return at[:, 0], determinant
        name = self.model.outputs("closure")[int(np.argmax(np.abs(gaps[0])))]
        return f"the loops do not close ({name} is {np.abs(gaps[0]).max():.3g} m)"

    def _gaps(self, angles: Array, places: Array) -> tuple[Array, Array]:
        """Gaps (n, k) and their Jacobians (n, k, k)."""
        found = np.array(list(self.model("closure", **{self._angle: angles}, data=self.data, loops=places).values()))
        count = len(places)
        return found[:count].T, found[count:].T.reshape(-1, count, count)

    @cached_property
    def _angle(self) -> str:
        name: str = self.model.sidecar["functions"]["lane"]["inputs"][0]
        return name

    def _dead(self, angle: float, found: tuple[Array, float] | str) -> str:
        """What ends a walk: beyond a dead point loops are open, or go on in the other assembly."""
        names = ", ".join(self.names)
        beyond = found if isinstance(found, str) else f"{names} go on in another assembly"
        return f"{self.model.name}: dead point near {np.degrees(angle):.6g} deg: beyond it {beyond}"

    def _check_return(self, first: Array, last: Array) -> None:
        """After a turn lengths are what they were, angles too but for whole turns."""
        for name, unit, gained in zip(self.names, self._units(), last - first, strict=True):
            whole = 2 * np.pi * round(gained / (2 * np.pi)) if unit == "rad" else 0.0
            if abs(gained - whole) > 1e-6:
                raise ComputationError(
                    f"{self.model.name}: after a turn {name} is not what it was (it gains {gained:.6g} {unit}): "
                    "the mechanism does not repeat after one turn, or its loops have come into another assembly"
                )

    def _units(self) -> list[str]:
        return [entry["unit"] for entry in self.model.sidecar["vectors"]["start"]]


def _newton(places: Array, gaps: Array, slopes: Array) -> tuple[Array, bool]:
    """Places (k, n) after a step of Newton's method, and whether it was too small to matter."""
    steps = -np.linalg.solve(slopes, gaps[..., None])[..., 0].T
    found = places + steps
    return found, bool(np.all(np.abs(steps) <= CLOSED * (1 + np.abs(found))))
