"""Which numbers of a machine's programs its drawing shows: found by comparing both at designs that were drawn by lot.

A series of a scene, the corners of an outline, a place is one of the programs' rows or single numbers if it is that in
all of the designs, but for a constant; what is the same in all of them stands still.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array
from planter.view.portable import Portable
from planter.view.scene import Outline, Scene
from planter.view.subject import Values

SAME = 1e-9
"""Numbers that differ by less, in parts of the largest, are the same."""
Source = dict[str, Any]
"""A row: where it begins, how many numbers, how far ahead, sign and constant; a single number: where, and constant."""


@dataclass(frozen=True)
class Plan:
    """What of a drawing follows which numbers, ready for JSON.

    `channels` are places in a record with their sources; `outlines` are lines of the picture by their number, closed
    or not, with two rows or with two sources for each corner; `labels` are texts by theirs.
    """

    channels: list[tuple[list[str | int], Source]] = field(default_factory=list)
    outlines: list[dict[str, Any]] = field(default_factory=list)
    labels: list[tuple[int, Source | None, Source | None]] = field(default_factory=list)


class Recogniser:
    """A machine's programs at some designs, and the scenes there, all of the same shape."""

    def __init__(self, portable: Portable, designs: Sequence[Values], scenes: Sequence[Scene]) -> None:
        self.scenes = scenes
        program = portable.seen
        found = [portable.at(values, program) for values in designs]
        self.rows: list[tuple[int, Array]] = []
        for vector, count in portable.rows.items():
            values = np.array([one[vector].reshape(count, -1) for one in found])
            start, size = program.offsets[vector], values.shape[2]
            self.rows += [(start + k * size, values[:, k]) for k in range(count)]
        start = program.offsets["singles"]
        singles = np.array([one["singles"] for one in found]).T
        self.singles = [(start + k, values) for k, values in enumerate(singles)]

    def plan(self) -> Plan:
        """All that moves. Raises ComputationError for what follows none of the programs' numbers."""
        plan = Plan()
        for place, values in self._channels():
            source = self._source(values, str(place))
            if source is not None:
                plan.channels.append((place, source))
        lines = [outlines(scene) for scene in self.scenes]
        for number, alike in enumerate(zip(*lines, strict=True)):
            if (told := self._outline(number, alike)) is not None:
                plan.outlines.append(told)
        for number, labels in enumerate(zip(*(scene.labels for scene in self.scenes), strict=True)):
            x, y = (self._source([np.asarray(getattr(one, axis)) for one in labels], labels[0].text) for axis in "xy")
            plan.labels.append((number, x, y))
        return plan

    def _channels(self) -> Iterator[tuple[list[str | int], list[Array]]]:
        """Places in a record, and what stands there in each scene."""
        yield ["seconds"], [np.asarray(one.seconds) for one in self.scenes]
        yield ["places"], [one.places for one in self.scenes]
        if all(one.travel is not None for one in self.scenes):
            yield ["travel"], [np.asarray(one.travel) for one in self.scenes]
        parts = {
            "bodies": lambda scene: [(*body.at, body.turn) for body in scene.all_bodies()],
            "points": lambda scene: [(point.x, point.y) for point in scene.points],
            "forces": lambda scene: [(force.at.x, force.at.y, force.x, force.y) for force in scene.forces],
        }
        for key, part in parts.items():
            for k, alike in enumerate(zip(*map(part, self.scenes), strict=True)):
                for j, values in enumerate(zip(*alike, strict=True)):
                    yield [key, k, j], [np.asarray(value, dtype=float) for value in values]
        for k, curves in enumerate(zip(*(scene.curves for scene in self.scenes), strict=True)):
            yield ["curves", k, "values"], [one.values for one in curves]
            if curves[0].reference is not None:
                yield ["curves", k, "reference"], [np.asarray(one.reference, dtype=float) for one in curves]

    def _outline(self, number: int, alike: Sequence[Outline]) -> dict[str, Any] | None:
        points = np.array([one.points for one in alike])
        if not np.ptp(points, axis=0).any():
            return None
        told: dict[str, Any] = {"number": number, "closed": alike[0].closed}
        x, y = (self._row(points[:, :, axis]) for axis in (0, 1))
        if x is not None and y is not None:
            return told | {"rows": [x, y]}
        name = f"corner of the line {number}"
        corners = [[self._fixed(points[:, k, axis], name) for axis in (0, 1)] for k in range(points.shape[1])]
        return told | {"corners": corners}

    def _fixed(self, values: Array, name: str) -> Source:
        """A single number, also one that stands still."""
        found = self._source(list(values), name)
        return {"at": -1, "plus": float(values[0])} if found is None else found

    def _source(self, values: Sequence[Array], name: str) -> Source | None:
        """Of numbers in each of the designs; None where they stand still."""
        stacked = np.array(values)
        if np.ptp(stacked, axis=0).max() <= SAME * np.abs(stacked).max() and stacked.ndim == 1:
            return None
        found = self._row(stacked) if stacked.ndim == 2 else self._single(stacked)
        if found is None:
            raise ComputationError(f"{self.scenes[0].title}: a page without a server cannot follow its {name}")
        return found

    def _single(self, values: Array) -> Source | None:
        scale = SAME * max(1.0, float(np.abs(values).max()))
        for at, known in self.singles:
            if np.ptp(values - known) <= scale:
                return {"at": at, "plus": _constant(values - known, scale)}
        return None

    def _row(self, values: Array) -> Source | None:
        scale = SAME * max(1.0, float(np.abs(values).max()))
        size = values.shape[1]
        for at, known in self.rows:
            if known.shape != values.shape:
                continue
            for ahead in (0, size // 2):
                for sign in (1, -1):
                    apart = values - sign * np.roll(known, -ahead, axis=1)
                    if np.ptp(apart) <= scale:
                        told = {"at": at, "count": size, "ahead": ahead, "sign": sign}
                        return told | {"plus": _constant(apart, scale)}
        return None


def _constant(apart: Array, scale: float) -> float:
    mean = float(np.mean(apart))
    return mean if abs(mean) > scale else 0.0


def outlines(scene: Scene) -> list[Outline]:
    """The lines of a picture in their order: those of the ground, then those of the bodies."""
    return [*scene.ground, *(one for body in scene.all_bodies() for one in body.outlines)]
