"""A model of a machine for a static page: its programs, and its drawing as a template."""

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
"""Number of random designs at which numbers are recognised, and maximum number of attempts."""


class StaticPageModel:
    """A model of a machine for a static page."""

    def __init__(self, machine: Movable, name: str) -> None:
        self.machine, self.name = machine, name
        self.portable: Portable = machine.portable(name)

    def json(self) -> dict[str, Any]:
        """Return the JSON object for the script of the page."""
        designs, scenes = zip(*self._designs, strict=True)
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
        paths = {control.path for control in self.machine.controls}
        return [{"path": entry.path, "at": program.offsets[entry.vector] + entry.index, "factor": entry.factor}
                for entry in self.portable.inputs if entry.path in paths]  # fmt: skip

    def _readings(self, values: Values) -> list[dict[str, Any]]:
        """Return names, units and indices of the readings; the index is null if no program computes the reading."""
        start = self.portable.seen.offsets["singles"]
        indices = {name: start + index for index, name in enumerate(self.portable.singles)}
        readings = self.machine.readings(values, self.name)
        return [{"name": entry.name, "unit": entry.unit, "at": indices.get(entry.name)} for entry in readings]

    def _descent(self) -> dict[str, Any] | None:
        program = self.portable.gradient
        if program is None:
            return None
        factors = {entry.path: entry.factor for entry in self.portable.inputs}
        return {
            "name": program.name, "inputs": self._inputs(program), "paths": list(self.portable.design),
            "factors": [factors[path] for path in self.portable.design],
            "objective": program.offsets["objective"], "gradient": program.offsets["gradient"],
        }  # fmt: skip

    @cached_property
    def _designs(self) -> list[tuple[Values, Scene]]:
        """Random designs whose drawings have the same lines as that of the first, with their scenes."""
        designs: list[tuple[Values, Scene]] = []
        for values, scene in self._random_designs():
            if not designs or _shape(scene) == _shape(designs[0][1]):
                designs.append((values, scene))
            if len(designs) == ALIKE:
                return designs
        raise ComputationError(
            f"{self.machine.name}: fewer than {ALIKE} of {TRIES} random designs have similar drawings"
        )

    def _random_designs(self) -> Iterator[tuple[Values, Scene]]:
        rng, controls = np.random.default_rng(1), self.machine.controls
        for _ in range(TRIES):
            values = {control.path: float(rng.uniform(control.lower, control.upper)) for control in controls}
            if (scene := self._scene(values)) is not None:
                yield values, scene

    def _scene(self, values: Values) -> Scene | None:
        try:
            return self.machine.scenes(values, self.name)[0]
        except PlanterError:
            return None

    @cached_property
    def _frame(self) -> Frame:
        """A fixed frame of the drawing, which encloses the scenes at the bounds of every single number."""
        controls = self.machine.controls
        initial = {control.path: control.value for control in controls}
        moved = [initial | {control.path: end} for control in controls for end in (control.lower, control.upper)]
        scenes = [scene for values in moved if (scene := self._scene(values)) is not None]
        return _join([Picture(scene).frames[0] for scene in (*scenes, *(scene for _, scene in self._designs))])


def _join(frames: Sequence[Frame]) -> Frame:
    """Return the smallest frame that encloses all frames."""
    left, bottom = min(frame.left for frame in frames), min(frame.bottom for frame in frames)
    right, top = max(frame.left + frame.width for frame in frames), max(frame.bottom + frame.height for frame in frames)
    return Frame(left, bottom, right - left, top - bottom)


def _shape(scene: Scene) -> list[int]:
    """Return the numbers of points of each line, and of bodies, points, chains, forces, curves and labels."""
    parts = list(scene.all_bodies()), scene.points, scene.chains, scene.forces, scene.curves, scene.labels
    return [*(len(outline.points) for outline in outlines(scene)), *map(len, parts)]
