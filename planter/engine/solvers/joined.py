"""A sum of objectives as one objective: their smooth functions added up, their groups one after
another.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Protocol

import numpy as np

from planter.engine.solvers.insensitive import InsensitiveDirections, find_insensitive
from planter.engine.solvers.objective import (
    BreakpointHold,
    Conditions,
    Kinks,
    LocalModel,
    ObjectivePart,
    ObjectiveSummary,
)
from planter.kernels import Array, Flags


class CurvedPart(ObjectivePart, Protocol):
    """A part over a machine's cycle."""

    def columns(self, x: Array) -> Array:
        """Return gradients (n, p) of all curves at a design in shares of the bounds, each curve by
        its largest.
        """


class JoinedObjective:
    """The `Objective` that is the sum of parts over designs with names, lower and upper bounds
    (p,).

    Breakpoints are held in the first part that has kinks.
    """

    unit = None

    def __init__(
        self, parts: Sequence[CurvedPart], names: tuple[str, ...], widths: Array, design: Array
    ) -> None:
        self.parts, self.names, self.widths, self.design = tuple(parts), names, widths, design
        self.weights = np.concatenate([part.weights for part in self.parts])
        self.windows = any(part.windows for part in self.parts)
        self._kinked = next(
            (k for k, part in enumerate(self.parts) if part.kinks is not None), None
        )

    @property
    def kinks(self) -> Kinks | None:
        return None if self._kinked is None else self.parts[self._kinked].kinks

    @cached_property
    def units(self) -> Array:
        return np.concatenate([part.units for part in self.parts])

    def restart(self) -> None:
        """Forget all designs so far."""
        for part in self.parts:
            part.restart()

    @cached_property
    def sensitive(self) -> Flags:
        """Parameters on which the curves depend at their own design, (p,)."""
        return ~self._insensitive(self.design).zero

    def null_space(self, x: Array) -> Array:
        """Return the directions (k, p) to which the objective is insensitive at a design, to first
        order.
        """
        return self._insensitive(x).space * self.widths

    def _insensitive(self, x: Array) -> InsensitiveDirections:
        return find_insensitive(self.names, np.vstack([part.columns(x) for part in self.parts]))

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return join_summaries([part.summarise(x) for part in self.parts])

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> LocalModel:
        """Return the local model of the objective near a design x (p,)."""
        chosen = range(len(self.parts))
        models = [self.parts[k].local(x, holds if k == self._kinked else ()) for k in chosen]
        return (
            models[0]
            if len(models) == 1
            else JoinedModel(models, [len(part.weights) for part in self.parts])
        )

    def coarse(self, x: Array) -> LocalModel | None:
        """Return the local model over few samples, all of them rows; None if a part has none."""
        models = [model for part in self.parts if (model := part.coarse(x)) is not None]
        return (
            JoinedModel(models, [len(part.weights) for part in self.parts])
            if len(models) == len(self.parts)
            else None
        )

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        conditions = [part.conditions(x) for part in self.parts]
        firsts = _find_firsts([len(part.weights) for part in self.parts])
        return Conditions(
            rows=np.concatenate([each.rows for each in conditions]),
            groups=np.concatenate(
                [each.groups + first for each, first in zip(conditions, firsts, strict=True)]
            ),
            gradients=np.vstack([each.gradients for each in conditions]),
            smooth=np.sum([each.smooth for each in conditions], axis=0),
            kinks=np.vstack([each.kinks for each in conditions]),
        )


def join_summaries(summaries: Sequence[ObjectiveSummary]) -> ObjectiveSummary:
    """Return the summary of a sum of objectives."""
    smooth = float(sum(summary.smooth for summary in summaries))
    return ObjectiveSummary(smooth, np.concatenate([summary.tops for summary in summaries]))


def _find_firsts(counts: Sequence[int]) -> list[int]:
    """Return the places of the first of so many each."""
    return np.cumsum([0, *counts[:-1]]).tolist()


class JoinedModel:
    """The sum of local models with so many groups each. Implements `LocalModel`."""

    def __init__(self, models: Sequence[LocalModel], counts: Sequence[int]) -> None:
        self.models, self.counts = list(models), list(counts)
        firsts = _find_firsts(self.counts)
        self.groups = np.concatenate(
            [m.groups + first for m, first in zip(self.models, firsts, strict=True)]
        )
        self.bounds = np.hstack([model.bounds for model in self.models])
        sizes = [(1, len(model.groups), model.bounds.shape[1]) for model in self.models]
        kinds = np.tile(np.arange(3), len(sizes)).repeat(np.ravel(sizes))
        self._ends = np.cumsum([sum(size) for size in sizes])[:-1]
        self._smooth = kinds == 0
        self._rest = np.argsort(kinds, kind="stable")[len(sizes) :]  # rows, then holds

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return join_summaries([model.summarise(x) for model in self.models])

    def extended(self, x: Array, tops: Array) -> JoinedModel:
        """Return a copy which also has the rows that exceed the tops (g,) of their groups."""
        parts = np.split(tops, np.cumsum(self.counts)[:-1])
        models = [m.extended(x, part) for m, part in zip(self.models, parts, strict=True)]
        return JoinedModel(models, self.counts)

    def values(self, x: Array) -> Array:
        """Return the smooth value, the rows and the holds at a design x (p,)."""
        values = np.concatenate([model.values(x) for model in self.models])
        return np.append(values[self._smooth].sum(), values[self._rest])

    def slopes(self, x: Array) -> Array:
        """Return their gradients (n, p) at a design x (p,)."""
        slopes = np.vstack([model.slopes(x) for model in self.models])
        return np.vstack([slopes[self._smooth].sum(axis=0), slopes[self._rest]])

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the sum (p, p) of their Hessians with weights (n,)."""
        each = np.full(len(self._smooth), weights[0])
        each[self._rest] = weights[1:]
        parts = zip(self.models, np.split(each, self._ends), strict=True)
        total: Array = np.sum([model.curvature(x, part) for model, part in parts], axis=0)
        return total
