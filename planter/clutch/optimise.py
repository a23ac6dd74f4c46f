"""The fastest switching that forces and space allow: IPOPT from several starts, and a certificate of the optimum."""

from __future__ import annotations

import numpy as np

from planter.clutch.file import Clutch
from planter.clutch.results.shape import Choice, FastestSwitching, Held, Proof
from planter.clutch.switching import ASSUMES, VARIABLES, Switching
from planter.errors import ComputationError
from planter.files import units
from planter.kernels import Array
from planter.optimise.descent import Minimum
from planter.optimise.problem import Problem
from planter.optimise.result import Certificate, certified
from planter.optimise.starts import descents_from

STARTS = 8
MOST_ITERATIONS = 100
BROKEN = 1e-8
"""Share of a limit by which the file's own clutch may pass it."""
PEAK = 1e-6
"""Share of a limit by which a peak between stations may pass it."""
ROUNDS = 8
"""Most times that a peak between stations becomes a station."""


def optimise(clutch: Clutch, seed: int = 0, starts: int = STARTS) -> FastestSwitching:
    """Axial angle, gear ratio and linkage of the smallest travel time under the limits of the file.

    Raises InputError for bounds that hold linkages that do not close, ComputationError where no start ends at a point
    that satisfies every limit.
    """
    switching = Switching(clutch)
    problem, own = switching.problem, switching.box.design
    violated = [switching.names[i] for i in np.flatnonzero(switching.margins.values(own) < -BROKEN)]
    first = [problem.start, *np.random.default_rng(seed).random((starts - 1, len(VARIABLES)))]
    for _ in range(ROUNDS):
        minima = descents_from(problem, first, MOST_ITERATIONS)
        good = [minimum for minimum in minima if minimum.settled]
        if not good:
            raise ComputationError(_hopeless(switching, problem, minima))
        best = min(good, key=lambda minimum: minimum.objective)
        x = problem.design(best.u)
        along = switching.worst_along(x)
        peaks = {what: share for what, (margin, share) in along.items() if margin < -PEAK}
        if not peaks:
            break
        stations = {w: sorted({*at, *([peaks[w]] if w in peaks else [])}) for w, at in switching.stations.items()}
        switching, first = Switching(clutch, stations), [minimum.u for minimum in good]
        problem = switching.problem
    return FastestSwitching(
        clutch=clutch.name,
        travel_time_s=best.objective,
        start_travel_time_s=problem.reference.objective,
        start_violates=violated,
        design=Choice(**_shown(x)),
        start_design=Choice(**_shown(own)),
        stations={what: list(at) for what, at in switching.stations.items()},
        least_margin_along={what: margin for what, (margin, _) in along.items()},
        bounds=_bounds(switching),
        certificate=_told(certified(problem, best.u, good), problem.scale, starts),
        assumes=list(ASSUMES),
        seed=seed,
    )


def _told(proof: Certificate, scale: float, starts: int) -> Proof:
    """The certificate; a multiplier is the share of the file's own time that a share of the limit is worth."""
    held = [(one.name, one.multiplier) for one in proof.active_constraints]
    held += [(f"{one.name} at its {one.side} bound", one.multiplier) for one in proof.active_bounds]
    return Proof(
        kkt_residual=proof.kkt_residual,
        active=[Held(name, multiplier / scale) for name, multiplier in held],
        agreeing_starts=proof.agreeing_starts,
        spread=proof.spread / scale,
        starts=starts,
    )


def _shown(x: Array) -> dict[str, float]:
    return {key: float(value) / units.factor(key) for key, value in zip(VARIABLES, x, strict=True)}


def _bounds(switching: Switching) -> dict[str, tuple[float, float]]:
    lower, upper = _shown(switching.box.lower), _shown(switching.box.upper)
    return {key: (lower[key], upper[key]) for key in VARIABLES}


def _hopeless(switching: Switching, problem: Problem, minima: list[Minimum]) -> str:
    """Which limit the best of the points breaks most."""
    margins = [switching.margins.values(problem.design(minimum.u)) for minimum in minima]
    best = max(margins, key=lambda m: float(m.min()))
    return (
        f"no design within the bounds keeps all limits: {switching.names[int(best.argmin())]} fails by "
        f"{-100 * best.min():.3g} % of its limit at the best point found"
    )
