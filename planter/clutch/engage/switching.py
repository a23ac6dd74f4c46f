"""Engagement and cut-off of a clutch, and what is read from their motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from planter.clutch.engage import motion, start
from planter.clutch.engage.dynamics import TRAVEL, Array, Clutch
from planter.clutch.engage.inputs import Inputs
from planter.clutch.engage.motion import Run
from planter.clutch.results.engagement import ClutchLoads, Energy
from planter.errors import ComputationError

Mask = NDArray[np.bool_]

SETTLE_S, CALM_S = 0.02, 0.1
"""Time before the link first moves, and after everything should have happened [s]."""
SPARE = 1.2
"""Pitches of teeth or jaws that the input turns through after the link has come to rest, so that they meet."""
BAND = 0.02
"""Share of the input speed within which the output counts as engaged, or as at rest."""


@dataclass(frozen=True)
class Switching:
    """Engagement, then cut-off from where it ended."""

    engagement: Run
    cut_off: Run

    def energy(self) -> Energy:
        """Work put in, energy kept, work lost, what is missing of their balance [J], of both together."""
        return total([self.engagement.energy(), self.cut_off.energy()])

    def shown(self) -> ClutchLoads:
        first = self.engagement
        passed = slips(first)
        return ClutchLoads(
            N_max_N=first.peak(),
            N_single_max_N=float(first.seen["normal"][: first.clutch.carriers].max()),
            N_end_N=float(first.load[-1]),
            impacts=impacts(first),
            slips=len(passed),
            first_slip_s=float(passed[0]) if len(passed) else None,
            engaged_s=engaged(first),
            cut_off_s=at_rest(self.cut_off),
            cut_off_N_max_N=float(self.cut_off.load.max()),
            energy=self.energy(),
        )


def engage(clutch: Clutch, inputs: Inputs, phase: float, tolerance: float = motion.TOLERANCE) -> Run:
    """Engagement from the input at `phase` [rad], output at rest, until teeth or jaws must have met and come to rest.

    Raises ComputationError where the body finds no place, surfaces sink into each other or the integrator gives up.
    """
    begin = start.apart(clutch, inputs, phase, -SETTLE_S)
    duration = SETTLE_S + inputs.switching_s + SPARE * clutch.pitch / inputs.input_speed + CALM_S
    run = motion.integrate(clutch, inputs, begin, duration, tolerance=tolerance)
    depth, deepest = -float(run.seen["gaps"][: clutch.carriers].min()), min(inputs.fillet, inputs.edge)
    if depth > deepest:
        raise ComputationError(
            f"{clutch.name} clutch: surfaces go {depth * 1e3:.3g} mm deep into each other, which must be less than the "
            f"{deepest * 1e3:.3g} mm of their rounding: contact.stiffness_N_m15 = {inputs.stiffness:g} is too small"
        )
    return run


def switch(clutch: Clutch, inputs: Inputs, phase: float) -> Switching:
    """Engagement and cut-off. Raises ComputationError as `engage` does."""
    first = engage(clutch, inputs, phase)
    begin = start.again(first.states[:, -1])
    return Switching(first, motion.integrate(clutch, inputs.back(), begin, inputs.switching_s + CALM_S))


def impacts(run: Run) -> int:
    """How often the load rises from nothing once the link moves."""
    load = run.load[run.time >= 0]
    return int(np.count_nonzero((load[1:] > 0) & (load[:-1] == 0)))


def slips(run: Run) -> Array:
    """Times [s] at which teeth that should hold pass the corners of the shaft, or jaws the tips of those opposite.

    They should hold from the time on at which the sleeve has come as far as the clutch can carry anything.
    """
    reach = run.inputs.lock_travel if run.clutch.name == "reuleaux" else run.inputs.depth
    since = np.maximum.accumulate(run.states[TRAVEL] <= reach)
    passed = np.floor(run.ahead / run.clutch.pitch)
    return run.time[1:][(np.diff(passed) > 0) & since[1:]]


def engaged(run: Run) -> float | None:
    """Time after which the output keeps the speed of the input [s]; None where it does not."""
    speed = run.inputs.input_speed
    return _for_good(run, np.abs(run.speed - speed) <= BAND * speed)


def at_rest(run: Run) -> float | None:
    """Time after which the output is at rest [s]; None where it is not."""
    return _for_good(run, np.abs(run.speed) <= BAND * run.inputs.input_speed)


def _for_good(run: Run, holds: Mask) -> float | None:
    last = np.flatnonzero(~holds)
    if not len(last):
        return float(run.time[0])
    return float(run.time[last[-1] + 1]) if last[-1] + 1 < len(holds) else None


def total(parts: Sequence[Energy]) -> Energy:
    """Sums of energies, key by key."""
    return Energy(*(float(sum(values)) for values in zip(*map(astuple, parts), strict=True)))
