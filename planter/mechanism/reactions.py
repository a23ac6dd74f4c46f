"""Actions of joints in free motion: from the balances of all bodies together, by least squares.

Where the mechanism holds nothing twice the balances determine them in every pose, those included where bars lie in
line: then the solution of least squares is the only one.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.linalg

from planter.errors import ComputationError
from planter.kernels import Array
from planter.kernels.formulas import Formulas

RANK = 1e-10
"""Singular values of the balances below this share of the largest leave something undetermined."""

KEPT = 1e-6
"""A balance is kept that is off by less than this share of the largest push."""


class Reactions:
    """The balances of a mechanism as generated: rows ``held_i_u`` and ``pushed_i``."""

    def __init__(self, formulas: Formulas) -> None:
        self.formulas = formulas
        self.names = [entry["name"] for entry in formulas.sidecar["vectors"]["actions"]]
        self._places = [name.split("_", 2) for name in formulas.outputs("balances")]

    def found(self, inputs: Mapping[str, object]) -> tuple[Array, tuple[str, ...]]:
        """Actions (u, n) of states in motion, and the names of those that some pose leaves undetermined.

        Raises ComputationError where no actions of the joints keep the motion.
        """
        matrix, right = self._rows(inputs)
        found, left = [], np.zeros(len(self.names), dtype=bool)
        for rows, pushes in zip(matrix, right, strict=True):
            actions, _, rank, _ = np.linalg.lstsq(rows, -pushes, rcond=RANK)
            self._check(rows @ actions + pushes, float(np.abs(pushes).max(initial=1.0)))
            found.append(actions)
            if rank < len(self.names):
                left |= np.linalg.norm(scipy.linalg.null_space(rows, RANK), axis=1) > np.sqrt(RANK)
        return np.array(found).T, tuple(name for name, free in zip(self.names, left, strict=True) if free)

    def _check(self, left: Array, size: float) -> None:
        worst = int(np.argmax(np.abs(left)))
        if abs(left[worst]) > KEPT * size:
            entry = next(e for e in self.formulas.sidecar["vectors"]["balances_outputs"]
                         if e["name"].split("_", 2)[1] == str(worst))  # fmt: skip
            raise ComputationError(
                f"{self.formulas.name}: the joints do not keep the motion of the coordinates: "
                f"{entry['meaning'].rpartition(', ')[0]} is off by {abs(left[worst]):.3g}; a joint or force is lacking"
            )

    def _rows(self, inputs: Mapping[str, object]) -> tuple[Array, Array]:
        """Slopes (n, rows, u) of the balances in the actions, and what else stands in them (n, rows)."""
        values = list(self.formulas("balances", **inputs).values())
        rows = 1 + max(int(place[1]) for place in self._places)
        columns = {name: j for j, name in enumerate(self.names)}
        matrix, right = np.zeros((len(values[0]), rows, len(columns))), np.zeros((len(values[0]), rows))
        for (kind, row, *action), value in zip(self._places, values, strict=True):
            if kind == "held":
                matrix[:, int(row), columns[action[0]]] = value
            else:
                right[:, int(row)] = value
        return matrix, right
