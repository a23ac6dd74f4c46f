"""A plan as a job: points in rows, each handed to the machine, in the model, that it names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from importlib import import_module
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.sweeps.job import Recipe
from planter.sweeps.plan import Plan
from planter.sweeps.room import Held, Room, Subject, beside, named

MACHINE = "machine"
"""The input that names a machine, where there are several."""


class Sweep:
    """What a plan asks for, of machines that are there. Raises InputError where they lack what it names."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.machines = [Held(beside(source, plan.folder)) for source in plan.machine]
        first = self.machines[0]
        if any(held.module != first.module for held in self.machines):
            raise InputError(f"{plan.source}: machine is not allowed: all must be of one kind")
        self.outputs = self._outputs()
        self.inputs = {self._path(name): axis for name, axis in plan.axes.items()}
        if len(self.inputs) < len(plan.axes):
            raise InputError(f"{plan.source}: inputs is not allowed: it must name no input twice")
        for name, axis in self.inputs.items():
            self._check(name, axis.texts)

    def _outputs(self) -> list[str]:
        """Full names, known to every machine."""
        names = [held.asked(self.plan.outputs, f"{self.plan.source}: outputs") for held in self.machines]
        return list(dict.fromkeys(names[0]))

    def _path(self, name: str) -> str:
        if name == MACHINE or name in self.machines[0].choices:
            return name
        of = f"{self.plan.source}: inputs.{name}"
        (path,) = {held.path(name, of) for held in self.machines}
        return path

    def _check(self, name: str, texts: Sequence[str] | None) -> None:
        allowed = self.machines[0].choices.get(name, () if name != MACHINE else self.plan.machine)
        if texts is None and not allowed:
            return
        wrong = [text for text in texts or ("a number",) if text not in allowed]
        if wrong:
            wanted = f"it must be of {', '.join(allowed)}" if allowed else "it must be numbers"
            raise InputError(f"{self.plan.source}: inputs.{name} = {wrong[0]} is not allowed: {wanted}")

    @property
    def rows(self) -> int:
        """How many points."""
        return self.plan.drawn.rows

    @property
    def recipe(self) -> Recipe:
        """How any process makes the job."""
        return Recipe(f"{__name__}:{PlanJob.__name__}", {
            "module": self.machines[0].module,
            "machines": [held.room.frozen(held.machine) for held in self.machines],
            "plan": self.plan.model_dump(mode="json", by_alias=True, exclude_none=True),
            "inputs": list(self.inputs), "outputs": self.outputs, **self.machines[0].hash_curves(self.outputs),
        })  # fmt: skip

    def shown(self, name: str) -> str:
        """A name of the plan as its column is called."""
        known = dict.fromkeys([*self.inputs, *self.outputs], "")
        return named(name, known, f"{self.plan.source}: map: {name}", "inputs and outputs")


class PlanJob:
    """The rows of a plan: `outputs` of machines of a room, each where its inputs say."""

    def __init__(
        self, module: str, machines: Sequence[Mapping[str, Any]], plan: dict[str, Any], inputs: Sequence[str],
        outputs: Sequence[str], curves: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        """`curves` are hashes of files that outputs need, which tell this job from that with other files."""
        self._room: Room = import_module(module).ROOM
        self._machines, self._outputs = machines, outputs
        asked = Plan.read(plan, plan.get("name", "plan"))
        self.points, self._axes = asked.drawn, dict(zip(inputs, asked.axes.values(), strict=True))
        self._texts = [index for index, axis in enumerate(self._axes.values()) if axis.texts is not None]
        self._numbers = [index for index in range(len(inputs)) if index not in self._texts]
        self.rows, self.width = self.points.rows, len(outputs)
        self._subjects: dict[tuple[int, ...], Subject] = {}

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Outputs of the points from `start` to `stop`."""
        block = self.points.block(start, stop)
        found = np.empty((len(block), self.width))
        kinds, of = np.unique(block[:, self._texts].astype(int), axis=0, return_inverse=True)
        for number, kind in enumerate(kinds):
            rows = of.ravel() == number
            subject = self._subject(tuple(map(int, kind)))
            found[rows] = subject.evaluated(block[rows][:, self._numbers], threads)
        return found

    def _subject(self, kind: tuple[int, ...]) -> Subject:
        """The machine that the texts of a row name, by their places."""
        if kind not in self._subjects:
            chosen = {}
            for index, place in zip(self._texts, kind, strict=True):
                name = self._names[index]
                texts = self._axes[name].texts
                assert texts is not None
                chosen[name] = place if name == MACHINE else texts[place]
            machine = self._machines[int(chosen.pop(MACHINE, 0))]
            ends = {self._names[i]: self._axes[self._names[i]].ends for i in self._numbers}
            choices = {name: str(text) for name, text in chosen.items()}
            self._subjects[kind] = self._room.subject(machine, choices, ends, self._outputs)
        return self._subjects[kind]

    @cached_property
    def _names(self) -> list[str]:
        return list(self._axes)
