"""Objective of a sum over curves of a cycle, and its insensitive directions.

The weighted range and scatter of a force, equation (31) of Wang et al. (2017), is such a sum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import scipy

from planter.engine.solvers.continuous_cycle import ContinuousCycle
from planter.engine.solvers.curve_sum import CurveSum
from planter.engine.solvers.cycle_panels import PanelCache
from planter.engine.solvers.objective import (
    BreakpointHold,
    Conditions,
    LocalModel,
    ObjectiveSummary,
)
from planter.engine.solvers.response import CycleResponse
from planter.engine.solvers.sampled_cycle import SampledCycle, SampledRows, sample_angles
from planter.kernels import Array, Flags

RANK_TOLERANCE = 1e-10
"""Singular values below this share of the largest count as zero."""
WEIGHT_TOLERANCE = 1e-6
"""Smaller weights are omitted from a named direction."""


@dataclass(frozen=True)
class InsensitiveDirections:
    """Numerical rank of the Jacobian of a curve, and its null space.

    `effective_parameters` is the rank; `directions` spans the null space, each {name: weight} in
    parts of the box width with the largest weight 1; `zero` (p,) marks parameters that have no
    effect alone; `space` (k, p) spans the null space by orthonormal directions in shares of the
    box.
    """

    effective_parameters: int
    directions: list[dict[str, float]]
    zero: Flags
    space: Array

    @property
    def named(self) -> list[list[dict[str, float]]]:
        """The directions as lists of {name: weight}."""
        return [
            [{name: weight} for name, weight in direction.items()] for direction in self.directions
        ]


def scale_slopes(response: CycleResponse, x: Array, samples: int) -> Array:
    """Return the gradients (n, p) of curves at samples of a turn in shares of the bounds, each
    curve by its largest.
    """
    phi = response.turn * np.arange(samples) / samples
    slopes = response.curves.slopes(response.prologue(x), np.mod(phi, response.period))[1][:, :, 1:]
    size = np.abs(slopes).max(axis=(1, 2), keepdims=True)
    scaled: Array = np.concatenate(slopes / np.where(size > 0, size, 1.0)) * (
        response.upper - response.lower
    )
    return scaled


def find_insensitive(
    names: tuple[str, ...], columns: Array, rows: Array | None = None
) -> InsensitiveDirections:
    """Return rank and null space of scaled slopes (n, p) of curves in the named parameters.

    If equations with scaled gradients `rows` (k, p) constrain the parameters, the null space is
    restricted to them.
    """
    _, values, right = np.linalg.svd(columns, full_matrices=len(columns) < len(names))
    limit = RANK_TOLERANCE * values[0]
    rank = int((values > limit).sum())
    space = right[rank:]
    zero: Flags = np.linalg.norm(columns, axis=0) <= limit
    if rows is not None:
        rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        space = space.T @ scipy.linalg.null_space(rows @ space.T, RANK_TOLERANCE)
        space, zero = space.T, zero & (np.abs(rows).max(axis=0) <= RANK_TOLERANCE)
    return InsensitiveDirections(rank, _name_directions(names, space, zero), zero, space)


def _name_directions(names: tuple[str, ...], space: Array, zero: Flags) -> list[dict[str, float]]:
    """Return a sparse basis of the null space: single parameters first, then reduced
    combinations.
    """
    single: list[dict[str, float]] = [{names[j]: 1.0} for j in np.flatnonzero(zero)]
    mixed = _reduce_echelon(np.where(zero, 0.0, space), len(space) - len(single))
    return single + [
        {names[j]: float(row[j]) for j in np.flatnonzero(np.abs(row) > WEIGHT_TOLERANCE)}
        for row in mixed
    ]


def _reduce_echelon(space: Array, count: int) -> list[Array]:
    """Return the first `count` rows of the echelon form with complete pivoting, scaled to a largest
    weight of 1.
    """
    rows = space.copy()
    for i in range(count):
        pivot, column = (
            int(k) for k in np.unravel_index(np.abs(rows[i:]).argmax(), rows[i:].shape)
        )
        rows[[i, i + pivot]] = rows[[i + pivot, i]]
        rows[i] /= rows[i, column]
        is_other_row = np.arange(len(rows)) != i
        rows[is_other_row] -= np.outer(rows[is_other_row, column], rows[i])
    return [row / row[np.abs(row).argmax()] for row in rows[:count]]


Sampling = int | Literal["refined"]
DIRECTION_ANGLES = 360
"""Number of angles of a cycle at which insensitivity is determined for "refined"."""


COARSE = 72
"""Samples of a cycle over which a search glides."""


class CurveSumObjective:
    """The `Objective` of a sum over curves, by N samples of a cycle or, "refined", true extremes
    and integrals.
    """

    unit = None

    def __init__(
        self,
        response: CycleResponse,
        total: CurveSum,
        sampling: Sampling,
        panels: PanelCache | None = None,
    ) -> None:
        """`panels` are those of the response, if other sums share them."""
        self.response, self.total, self.sampling = response, total, sampling
        self.weights, self.windows = total.weights, sampling == "refined"
        self._panels = PanelCache(response) if panels is None else panels
        self._forget()

    def restart(self) -> None:
        """Discard the state of the designs evaluated so far."""
        self.response.restart()
        self._forget()

    def _forget(self) -> None:
        self._panels.restart()
        self.turn: ContinuousCycle | SampledCycle = (
            ContinuousCycle(self._panels, self.total)
            if self.sampling == "refined"
            else SampledCycle(self.response, self.total, int(self.sampling))
        )

    @property
    def kinks(self) -> SampledCycle | None:
        return self.turn if isinstance(self.turn, SampledCycle) else None

    @cached_property
    def units(self) -> Array:
        """Spread (g,) of the curve of each group at the initial design, else its size."""
        rows = {side.group: side.row for side in self.total.sides}
        rows |= {jump.group: jump.row for jump in self.total.jumps}
        return find_spreads(self.response)[[rows[group] for group in range(len(self.weights))]]

    @cached_property
    def sensitive(self) -> Flags:
        """Parameters on which the response depends at its own design, (p,)."""
        return ~find_insensitive(self.response.names, self.columns(self.response.design)).zero

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return self.turn.summarise(x)

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """Return the local model of the objective near a design x (p,)."""
        if isinstance(self.turn, SampledCycle):
            return self.turn.local(x).with_holds(tuple(holds))
        return self.turn.local(x)

    def coarse(self, x: Array) -> LocalModel | None:
        """Return the local model over few samples, all of them rows; None if parts of the cycle
        count, or samples.
        """
        conditions = [part.conditions for part in self.total.statistics] + [
            side.conditions for side in self.total.sides
        ]
        if self.total.jumps:  # which are rows of few places, none of them samples
            return self.local(x)
        if self.sampling != "refined" or any(conditions):
            return None
        cycle = SampledCycle(self.response, self.total, COARSE)
        return SampledRows(
            self.response,
            self.total,
            cycle.angles,
            np.ones((len(self.total.sides), len(cycle.angles)), dtype=bool),
        )

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        return self.turn.conditions(x)

    def null_space(self, x: Array) -> Array:
        """Return the directions (k, p) to which the objective is insensitive at a design, to first
        order.
        """
        response = self.response
        return find_insensitive(response.names, self.columns(x)).space * (
            response.upper - response.lower
        )

    def columns(self, x: Array) -> Array:
        """Return gradients (n, p) of all curves at a design in shares of the bounds, each curve by
        its largest.
        """
        return scale_slopes(self.response, x, count_angles(self.sampling))


def find_spreads(response: CycleResponse) -> Array:
    """Return by how much each curve varies at the initial design, else its size, (m,)."""
    angles = sample_angles(DIRECTION_ANGLES, response.period, response.turn)
    values = response.curves.values(response.prologue(response.design), angles)
    spread, size = np.ptp(values, axis=1), np.abs(values).max(axis=1)
    return np.where(spread > 0, spread, np.where(size > 0, size, 1.0))


def count_angles(sampling: Sampling) -> int:
    """Return the number of angles of a cycle at which insensitivity is determined."""
    return DIRECTION_ANGLES if sampling == "refined" else int(sampling)
