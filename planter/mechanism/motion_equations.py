"""Equations of motion as graphs of time, data and state, from the generated functions of a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from planter.kernels.formulas import Formulas


@dataclass(frozen=True)
class MotionGraphs:
    """Inertia (k, k), forces (k, 1), slopes (c, k), bends (c, 1), speeds (c, 1), gaps (g, 1).

    ``inertia accelerations = forces + slopes^T multipliers`` and ``slopes accelerations = bends``;
    gaps come first among the c constraints.
    """

    inertia: ca.SX
    forces: ca.SX
    slopes: ca.SX
    bends: ca.SX
    speeds: ca.SX
    gaps: ca.SX


class MotionEquations:
    """`time`, `data` (n,), `state` (2k,) and `sizes` (f,), and graphs of them; SI.

    The sizes [N or N m] are those of the normal forces that friction, or the flank on which rigid
    teeth bear, follows from.
    """

    def __init__(self, formulas: Formulas, data: ca.SX | None = None) -> None:
        """`data` (n,) is a graph of the values of the file, their symbols unless it is given."""
        self.formulas = formulas
        self._stages = formulas.sidecar["functions"]
        self.names = formulas.outputs("start")
        self.size = len(self.names) // 2
        self.data_names = formulas.entries("data")
        self.pressing = [
            entry["name"].removeprefix("size_")
            for entry in formulas.sidecar["vectors"].get("sizes", ())
        ]
        self.constraints = [name.removeprefix("speed_") for name in self.outputs("speeds")]
        self.gaps = [name for name in self.constraints if name in self.outputs("gaps")]
        self.actions = formulas.entries("actions") if "balances" in self._stages else []
        self.time = ca.SX.sym("time")
        self.data = ca.SX.sym("data", len(self.data_names)) if data is None else data
        self.state = ca.SX.sym("state", 2 * self.size)
        self.sizes = ca.SX.sym("sizes", len(self.pressing))

    def outputs(self, stage: str) -> list[str]:
        """Return the names of a stage's outputs; none if the motion has no such stage."""
        return self.formulas.outputs(stage) if stage in self._stages else []

    @cached_property
    def graphs(self) -> MotionGraphs:
        """The equations of motion."""
        coordinates, constraints = self.names[: self.size], self.constraints
        return MotionGraphs(
            inertia=self._arrange(
                "inertia", [[f"inertia_{a}_{b}" for b in coordinates] for a in coordinates]
            ),
            forces=self._arrange("forces", [[f"force_{a}"] for a in coordinates]),
            slopes=self._arrange(
                "slopes", [[f"slope_{c}_{a}" for a in coordinates] for c in constraints]
            ),
            bends=self._arrange("bends", [[f"bend_{c}"] for c in constraints]),
            speeds=self._arrange("speeds", [[f"speed_{c}"] for c in constraints]),
            gaps=self._arrange("gaps", [[c] for c in self.gaps]),
        )

    def balances(self, accelerations: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return slopes (r, u) of the balances of all bodies in the actions, and loads (r, 1)."""
        places = place_balances(self.outputs("balances"), self.actions)
        values = self.evaluate("balances", accelerations=accelerations)
        matrix = ca.SX(1 + max(row for row, _ in places), len(self.actions) + 1)
        for k, (row, column) in enumerate(places):
            matrix[row, column] = values[k]
        return matrix[:, :-1], matrix[:, -1]

    def evaluate(self, stage: str, **inputs: ca.SX) -> ca.SX:
        """Return the outputs of a stage, a column, of the symbols and of other inputs by name."""
        symbols = {"time": self.time, "data": self.data, "state": self.state, "sizes": self.sizes}
        symbols |= inputs
        arguments = [symbols[name] for name in self._stages[stage]["inputs"]]
        return self.formulas.function(stage)(*arguments)

    def _arrange(self, stage: str, names: Sequence[Sequence[str]]) -> ca.SX:
        """Return the outputs of a stage as a matrix in the arrangement of their names."""
        width = self.size if stage == "slopes" else len(names[0]) if names else 1
        matrix = ca.SX(len(names), width)
        if stage not in self._stages:
            return matrix
        places = {name: (i, j) for i, row in enumerate(names) for j, name in enumerate(row)}
        values = self.evaluate(stage)
        for k, name in enumerate(self.outputs(stage)):
            matrix[places[name]] = values[k]
        return matrix


def place_balances(outputs: Sequence[str], actions: Sequence[str]) -> list[tuple[int, int]]:
    """Return row and column of each output of the balances: of ``held_i_u`` row i in the column of
    action u, of the load ``pushed_i`` row i in the column after the actions.
    """
    columns = {name: j for j, name in enumerate(actions)}
    places = []
    for output in outputs:
        _, row, *action = output.split("_", 2)
        places.append((int(row), columns[action[0]] if action else len(columns)))
    return places
