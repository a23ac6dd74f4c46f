"""Equations of motion as graphs of time, data and state, from the generated functions of a file.

``inertia accelerations = forces + slopes^T multipliers`` and ``slopes accelerations = bends``; gaps
come first among the c constraints.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import casadi as ca

from planter.kernels.formulas import Formulas


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
        self.impacts = [
            name.removeprefix("restitution_")
            for name in self.outputs("impacts")
            if name.startswith("restitution_")
        ]
        self.actions = formulas.entries("actions") if "balances" in self._stages else []
        self.time = ca.SX.sym("time")
        self.data = ca.SX.sym("data", len(self.data_names)) if data is None else data
        self.state = ca.SX.sym("state", 2 * self.size)
        self.sizes = ca.SX.sym("sizes", len(self.pressing))

    def outputs(self, stage: str) -> list[str]:
        """Return the names of a stage's outputs; none if the motion has no such stage."""
        return self.formulas.outputs(stage) if stage in self._stages else []

    @cached_property
    def inertia(self) -> ca.SX:
        """Inertia (k, k): what the residual gains with the accelerations."""
        residual, symbols = self._residual
        inertia = ca.jacobian(residual, symbols)
        if self.formulas.sidecar.get("added_inertia"):
            return inertia
        return ca.tril2symm(ca.tril(inertia))

    @cached_property
    def forces(self) -> ca.SX:
        """Forces (k, 1): the residual without accelerations, the other way round."""
        residual, symbols = self._residual
        return -ca.substitute(residual, symbols, ca.SX.zeros(self.size))

    @cached_property
    def _residual(self) -> tuple[ca.SX, ca.SX]:
        """The residual (k, 1), and its accelerations (k,)."""
        symbols = ca.SX.sym("accelerations", self.size)
        return self.evaluate("residual", accelerations=symbols), symbols

    @cached_property
    def accelerations(self) -> ca.SX | None:
        """Accelerations (k, 1) where articulated inertias give them."""
        return self.evaluate("accelerations") if "accelerations" in self._stages else None

    @cached_property
    def slopes(self) -> ca.SX:
        """Slopes (c, k) of the constraints."""
        names = self.names[: self.size]
        return self._arrange(
            "slopes", [[f"slope_{c}_{a}" for a in names] for c in self.constraints]
        )

    @cached_property
    def bends(self) -> ca.SX:
        """Bends (c, 1) of the constraints."""
        return self._arrange("bends", [[f"bend_{c}"] for c in self.constraints])

    @cached_property
    def speeds(self) -> ca.SX:
        """Speeds (c, 1) that vanish, those of gaps first."""
        return self._arrange("speeds", [[f"speed_{c}"] for c in self.constraints])

    @cached_property
    def gap_values(self) -> ca.SX:
        """Gaps (g, 1) that vanish."""
        return self._arrange("gaps", [[c] for c in self.gaps])

    @cached_property
    def openings(self) -> ca.SX:
        """Rates (i, 1) [m/s] of the gaps of impacts."""
        return self._arrange("impacts", [[f"opening_{name}"] for name in self.impacts])

    @cached_property
    def opening_slopes(self) -> ca.SX:
        """Slopes (i, k) of these in the rates."""
        names = self.names[: self.size]
        return self._arrange(
            "impacts", [[f"opening_{name}_{a}" for a in names] for name in self.impacts]
        )

    @cached_property
    def restitutions(self) -> ca.SX:
        """Restitutions (i, 1) of impacts."""
        return self._arrange("impacts", [[f"restitution_{name}"] for name in self.impacts])

    @property
    def is_rubbing(self) -> bool:
        """Whether accelerations depend on the sizes: by friction, not by the flank on which rigid
        teeth bear.
        """
        return "sizes" in self._stages["residual"]["inputs"]

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
            if name in places:
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
