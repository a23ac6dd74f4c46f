"""A plan as a job: each row is evaluated by the machine and the model which its texts name."""

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
from planter.sweeps.room import ResolvedMachine, Room, Subject, find_full_name, resolve_source

MACHINE = "machine"
"""Name of the input that selects one of several machines."""


class Sweep:
    """A plan with its machines loaded. Raises InputError if a machine, an input or an output does not exist."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.machines = [ResolvedMachine(resolve_source(source, plan.folder)) for source in plan.machine]
        first = self.machines[0]
        if any(resolved.module != first.module for resolved in self.machines):
            raise InputError(f"{plan.source}: machine is not allowed: all machines must be of the same kind")
        self.outputs = self._outputs()
        self.inputs = {self._path(name): axis for name, axis in plan.axes.items()}
        if len(self.inputs) < len(plan.axes):
            raise InputError(f"{plan.source}: inputs names an input twice; keep one of the two")
        for name, axis in self.inputs.items():
            self._check(name, axis.texts)

    def _outputs(self) -> list[str]:
        """Return the full names of the outputs, which every machine must have."""
        names = [
            resolved.resolve_outputs(self.plan.outputs, f"{self.plan.source}: outputs") for resolved in self.machines
        ]
        return list(dict.fromkeys(names[0]))

    def _path(self, name: str) -> str:
        if name == MACHINE or name in self.machines[0].choices:
            return name
        label = f"{self.plan.source}: inputs.{name}"
        (path,) = {resolved.path(name, label) for resolved in self.machines}
        return path

    def _check(self, name: str, texts: Sequence[str] | None) -> None:
        allowed = self.machines[0].choices.get(name, () if name != MACHINE else self.plan.machine)
        if texts is None and not allowed:
            return
        invalid = [text for text in texts or ("a number",) if text not in allowed]
        if invalid:
            hint = f"it must be of {', '.join(allowed)}" if allowed else "it must be numbers"
            raise InputError(f"{self.plan.source}: inputs.{name} = {invalid[0]} is not allowed: {hint}")

    @property
    def rows(self) -> int:
        """Number of points."""
        return self.plan.sample_points.rows

    @property
    def recipe(self) -> Recipe:
        """Recipe of the job."""
        return Recipe(f"{__name__}:{PlanJob.__name__}", {
            "module": self.machines[0].module,
            "machines": [resolved.room.frozen(resolved.machine) for resolved in self.machines],
            "plan": self.plan.model_dump(mode="json", by_alias=True, exclude_none=True),
            "inputs": list(self.inputs), "outputs": self.outputs, **self.machines[0].hash_curves(self.outputs),
        })  # fmt: skip

    def find_column(self, name: str) -> str:
        """Return the name of the column of a name of the plan. Raises InputError if there is none."""
        meanings = dict.fromkeys([*self.inputs, *self.outputs], "")
        return find_full_name(name, meanings, f"{self.plan.source}: map: {name}", "inputs and outputs")


class PlanJob:
    """Job of a plan: `outputs` of machines of one kind at the points of the plan."""

    def __init__(
        self, module: str, machines: Sequence[Mapping[str, Any]], plan: dict[str, Any], inputs: Sequence[str],
        outputs: Sequence[str], curves: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        """Prepare the job; `curves`, hashes of files that outputs need, distinguish it from jobs with other files."""
        self._room: Room = import_module(module).ROOM
        self._machines, self._outputs = machines, outputs
        spec = Plan.read(plan, plan.get("name", "plan"))
        self.points, self._axes = spec.sample_points, dict(zip(inputs, spec.axes.values(), strict=True))
        self._texts = [index for index, axis in enumerate(self._axes.values()) if axis.texts is not None]
        self._numbers = [index for index in range(len(inputs)) if index not in self._texts]
        self.rows, self.width = self.points.rows, len(outputs)
        self._subjects: dict[tuple[int, ...], Subject] = {}

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Return the outputs of the points from `start` to `stop`, (stop - start, width)."""
        block = self.points.block(start, stop)
        outputs = np.empty((len(block), self.width))
        kinds, kind_numbers = np.unique(block[:, self._texts].astype(int), axis=0, return_inverse=True)
        for number, kind in enumerate(kinds):
            rows = kind_numbers.ravel() == number
            subject = self._subject(tuple(map(int, kind)))
            outputs[rows] = subject.evaluated(block[rows][:, self._numbers], threads)
        return outputs

    def _subject(self, kind: tuple[int, ...]) -> Subject:
        """Return the machine that the texts of a row select, by their indices."""
        if kind not in self._subjects:
            chosen = {}
            for index, text_index in zip(self._texts, kind, strict=True):
                name = self._names[index]
                texts = self._axes[name].texts
                assert texts is not None
                chosen[name] = text_index if name == MACHINE else texts[text_index]
            machine = self._machines[int(chosen.pop(MACHINE, 0))]
            ends = {self._names[i]: self._axes[self._names[i]].ends for i in self._numbers}
            choices = {name: str(text) for name, text in chosen.items()}
            self._subjects[kind] = self._room.subject(machine, choices, ends, self._outputs)
        return self._subjects[kind]

    @cached_property
    def _names(self) -> list[str]:
        return list(self._axes)
