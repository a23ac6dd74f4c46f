"""A model of a machine as a page is told it: programs, the drawing as a template, what of it follows which numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import cached_property
from typing import Any

import numpy as np

from planter.errors import ComputationError, PlanterError
from planter.kernels.programs.program import Program
from planter.studio.static.recognised import Recogniser, outlines
from planter.view.channels import packed
from planter.view.picture import LONGEST, Frame, Picture
from planter.view.portable import Movable, Portable
from planter.view.scene import Scene
from planter.view.subject import Values

ALIKE, TRIES = 3, 24
"""Designs by lot at which numbers are recognised, and how many are tried."""


class Model:
    """A model of a machine."""

    def __init__(self, machine: Movable, name: str) -> None:
        self.machine, self.name = machine, name
        self.portable: Portable = machine.portable(name)

    def json(self) -> dict[str, Any]:
        """What the page's script takes."""
        designs, scenes = zip(*self._alike, strict=True)
        seen, first = self.portable.seen, scenes[0]
        picture = Picture(first)
        picture.frames = (self._frame, self._frame)
        plan = Recogniser(self.portable, designs, scenes).plan()
        return {
            "seen": {"name": seen.name, "inputs": self._inputs(seen)},
            "readings": self._readings(designs[0]),
            "picture": picture.text(),
            "template": {**packed(first), "events": [], "data": ""},
            "plan": {**asdict(plan), "again": first.again, "longest": LONGEST},
            "descent": self._descent(),
        }

    def _inputs(self, program: Program) -> list[dict[str, Any]]:
        paths = {one.path for one in self.machine.controls}
        return [{"path": one.path, "at": program.offsets[one.vector] + one.index, "factor": one.factor}
                for one in self.portable.inputs if one.path in paths]  # fmt: skip

    def _readings(self, values: Values) -> list[dict[str, Any]]:
        """Names and units, and where the numbers are; null for one that no program finds."""
        start, known = self.portable.seen.offsets["singles"], list(self.portable.singles)
        found = self.machine.readings(values, self.name)
        return [{"name": one.name, "unit": one.unit, "at": start + known.index(one.name) if one.name in known else None}
                for one in found]  # fmt: skip

    def _descent(self) -> dict[str, Any] | None:
        program = self.portable.gradient
        if program is None:
            return None
        factors = {one.path: one.factor for one in self.portable.inputs}
        return {
            "name": program.name, "inputs": self._inputs(program), "paths": list(self.portable.design),
            "factors": [factors[path] for path in self.portable.design],
            "objective": program.offsets["objective"], "gradient": program.offsets["gradient"],
        }  # fmt: skip

    # --- designs that are looked at -------------------------------------------------------------------

    @cached_property
    def _alike(self) -> list[tuple[Values, Scene]]:
        """Designs by lot whose drawings have the same lines as the first of them, with their scenes."""
        found: list[tuple[Values, Scene]] = []
        for values, scene in self._by_lot():
            if not found or _shape(scene) == _shape(found[0][1]):
                found.append((values, scene))
            if len(found) == ALIKE:
                return found
        raise ComputationError(f"{self.machine.name}: {TRIES} designs by lot have too few drawings that are alike")

    def _by_lot(self) -> Iterator[tuple[Values, Scene]]:
        rng = np.random.default_rng(1)
        for _ in range(TRIES):
            values = {one.path: float(rng.uniform(one.lower, one.upper)) for one in self.machine.controls}
            if (scene := self._scene(values)) is not None:
                yield values, scene

    def _scene(self, values: Values) -> Scene | None:
        try:
            return self.machine.scenes(values, self.name)[0]
        except PlanterError:
            return None

    @cached_property
    def _frame(self) -> Frame:
        """What the drawing shows: all that each number alone moves into sight, so that the frame can stay."""
        own = {one.path: one.value for one in self.machine.controls}
        moved = [own | {one.path: end} for one in self.machine.controls for end in (one.lower, one.upper)]
        scenes = [scene for values in moved if (scene := self._scene(values)) is not None]
        return _around([Picture(scene).frames[0] for scene in (*scenes, *(scene for _, scene in self._alike))])


def _around(frames: Sequence[Frame]) -> Frame:
    """The least frame around some."""
    left, bottom = min(one.left for one in frames), min(one.bottom for one in frames)
    right, top = max(one.left + one.width for one in frames), max(one.bottom + one.height for one in frames)
    return Frame(left, bottom, right - left, top - bottom)


def _shape(scene: Scene) -> list[int]:
    """What drawings that are alike have in common: how many points each line has, bodies, points, curves."""
    parts = list(scene.all_bodies()), scene.points, scene.chains, scene.forces, scene.curves, scene.labels
    return [*(len(one.points) for one in outlines(scene)), *map(len, parts)]
