"""Which whole teeth are best: from those nearest to a free optimum on to better neighbours while there are any."""

from __future__ import annotations

import math
from collections.abc import Iterator

from planter.errors import ComputationError
from planter.kernels import Array
from planter.optimise.descent import STATIONARY
from planter.optimise.range_and_spread import Sampling
from planter.optimise.starts import AGREEING
from planter.planting.optimisation import build_constrained_problem, search_from_design
from planter.planting.requirements.constraints import Required
from planter.planting.whole.extent import Extent, extents
from planter.planting.whole.lengths import Lengths
from planter.planting.whole.results import TriedTeeth
from planter.planting.whole.wanted import Wanted
from planter.progress import Listener, ProgressPhase

Numbers = tuple[int, ...]
"""Teeth of each stage that has whole ones."""


class Choice:
    """Teeth tried beside a free optimum (p,), each by one descent from there; `lengths` are of any teeth."""

    def __init__(self, lengths: Lengths, free: Array, sampling: Sampling, progress: Listener | None = None) -> None:
        self.lengths, self.free, self.sampling, self.progress = lengths, free, sampling, progress
        self.required = Required.of(lengths.device)
        self.tried: dict[Numbers, TriedTeeth] = {}

    def run(self) -> Wanted:
        """The best teeth: none of their permitted neighbours on one stage is better. The bounds permit some."""
        within = extents(self.lengths)
        here = tuple(one.nearest(length) for one, length in zip(within, self.lengths.measured(self.free), strict=True))
        while True:
            around = [here, *neighbours(here, within)]
            self._try([teeth for teeth in around if teeth not in self.tried])
            best = min(around, key=self._rank)
            if not self._better(best, here):
                return self.lengths.wanted.of(here)
            here = best

    def _try(self, several: list[Numbers]) -> None:
        phase = ProgressPhase("teeth", "choice", len(several), self.progress)
        for teeth in several:
            self.tried[teeth] = self._found(teeth)
            phase.advance(",".join(map(str, teeth)))

    def _found(self, teeth: Numbers) -> TriedTeeth:
        lengths = self.lengths.of(self.lengths.wanted.of(teeth))
        task = build_constrained_problem(lengths.device, self.sampling, self.required, lengths)
        try:
            found = search_from_design(task, self.free)
        except ComputationError:
            return TriedTeeth(list(teeth), None, None, settled=False)
        kept = task.kept(found.u)
        objective = found.objective if kept else None
        return TriedTeeth(list(teeth), objective, found.residual, settled=kept and found.residual < STATIONARY)

    def _rank(self, teeth: Numbers) -> tuple[bool, float]:
        one = self.tried[teeth]
        return not one.settled, math.inf if one.objective is None else one.objective

    def _better(self, teeth: Numbers, here: Numbers) -> bool:
        """Whether teeth are better by more than starts may differ."""
        (unsettled, objective), (was_unsettled, own) = self._rank(teeth), self._rank(here)
        return (unsettled, objective + AGREEING * abs(objective)) < (was_unsettled, own)


def neighbours(teeth: Numbers, within: list[Extent]) -> Iterator[Numbers]:
    """The permitted teeth that differ by one on one stage."""
    for k, extent in enumerate(within):
        for z in (teeth[k] - 1, teeth[k] + 1):
            if z in extent.teeth:
                yield (*teeth[:k], z, *teeth[k + 1 :])
