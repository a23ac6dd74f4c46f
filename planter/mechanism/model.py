"""What the generated functions of a mechanism make of its file: results along the turn, loops closed."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from planter.engine.loops import Course
from planter.engine.machine import LEAST_PIVOT
from planter.errors import ComputationError, NotFiniteError
from planter.kernels import Array
from planter.kernels.formulas import Formulas
from planter.mechanism.file import MechanismFile
from planter.mechanism.machines import build_machine

LAW, PIVOTS, STATES = "law_", "pivot_", "states_"
"""Beginnings of names that say how sound results are: laws kept, pivots of elimination, states that friction has."""


def component_axes(formulas: Formulas) -> dict[str, str]:
    """Frames by whose axes components of joints' actions are told, by the components' names; others are the world's."""
    axes: dict[str, str] = formulas.sidecar.get("axes", {})
    return axes


class Model:
    """A mechanism with the values of its file, or with others; SI units and radians.

    >>> Model(load("slider_crank"))(np.radians([0.0, 90.0]))["M_in"]      # doctest: +SKIP
    array([-0.27,  1.9])
    """

    def __init__(self, file: MechanismFile, data: Array | None = None) -> None:
        self.file, self.formulas, self.machine = file, file.model, build_machine(file)
        self.data = self.machine.data if data is None else data

    @property
    def outputs(self) -> list[dict[str, Any]]:
        """Name, unit, meaning and source of every result."""
        found: list[dict[str, Any]] = self.formulas.sidecar["vectors"]["outputs"]
        return found

    @property
    def angle(self) -> str:
        """Name of the angle that the mechanism moves along."""
        name: str = self.formulas.sidecar["functions"]["lane"]["inputs"][0]
        return name

    @property
    def speed(self) -> float:
        """That of the angle [rad/s]."""
        return float(self.data[self.machine.speed])

    @property
    def pushing(self) -> list[str]:
        """Names of forces of contacts that cannot pull."""
        found: list[str] = self.formulas.sidecar.get("pushing", [])
        return found

    @cached_property
    def course(self) -> Course | None:
        """The coordinates of its closed loops over a turn, if it has any.

        Raises ComputationError where they do not close, or do not come back.
        """
        loops = self.machine.loops
        return loops.course(self.file.name, self.data) if loops else None

    def __call__(self, angles: Array) -> dict[str, Array]:
        """Results (n,) by name at angles (n,) [rad].

        Raises ComputationError where loops do not close, or where forces are not determined.
        """
        angles = np.asarray(angles, dtype=float)
        try:
            found = self.formulas("lane", **self._inputs(angles))
        except NotFiniteError as error:
            entry, angle = self.outputs[error.row], np.degrees(angles[error.lane])
            told = f"{entry['name']} ({entry['meaning']}) is not finite at {angle:.6g} deg"
            raise ComputationError(f"{self.file.name}: {told}") from None
        self._check(angles, found)
        return found

    def results(self, angles: Array) -> dict[str, Array]:
        """Return the results (n,) at angles (n,) [rad] by key, each in the unit that its key ends in.

        Raises ComputationError as a call does.
        """
        values = self(angles)
        return {q.key: values[q.name] / q.factor for q in self.machine.results}

    def places(self, angles: Array) -> dict[str, Array]:
        """Where the points of all bodies are (n,) [m] at angles (n,) [rad], by name, for a drawing."""
        return self.evaluate("places", angles)

    def evaluate(self, name: str, angles: Array) -> dict[str, Array]:
        """Return the outputs (n,) of a generated function at angles (n,) [rad], in SI; none where it is not there."""
        if name not in self.formulas.sidecar["functions"]:
            return {}
        return self.formulas(name, **self._inputs(angles))

    def _inputs(self, angles: Array) -> dict[str, object]:
        """What the functions along the angle take."""
        loops = {} if self.course is None else {"loops": self.course.at(angles)}
        return {self.angle: angles, "data": self.data, **loops}

    def _check(self, angles: Array, found: dict[str, Array]) -> None:
        for entry in self.outputs:
            name = entry["name"]
            if name.startswith(STATES) and not np.all(found[name]):
                angle = np.degrees(angles[int(np.argmin(found[name]))])
                raise ComputationError(f"{self.file.name}: friction holds it fast at {angle:.6g} deg; less of it moves")
            if name.startswith(PIVOTS) and (least := float(found[name].min())) < LEAST_PIVOT:
                angle = np.degrees(angles[int(np.argmin(found[name]))])
                raise ComputationError(f"{self.file.name}: {entry['meaning']}: {least:.1e} at {angle:.6g} deg")
