"""The fastest switching that forces and space allow: IPOPT from several starts, and a certificate of the optimum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import nnls

from planter.clutch.file import Clutch
from planter.clutch.switching import ASSUMES, VARIABLES, Switching, TravelTime
from planter.errors import ComputationError
from planter.files import units
from planter.kernels import Array
from planter.optimise import ipopt

STARTS = 8
ACTIVE = 1e-6
"""A margin or a distance from a bound below this share holds the optimum."""
AGREEING = 1e-6
"""Starts agree that end at the same time to this share."""
FEASIBLE = 1e-8
"""Share of a limit by which it may be passed."""
PEAK = 1e-6
"""Share of a limit by which a peak between stations may pass it."""
ROUNDS = 8
"""Most times that a peak between stations becomes a station."""


@dataclass(frozen=True)
class Certificate:
    """Karush, Kuhn and Tucker's conditions at a point of the box, with the multipliers that fit best.

    `residual` is the norm of the gradient's part that no multiplier explains, or the largest violation or product of
    multiplier and margin if that is larger; the travel time at the start is 1.
    `active` names what holds the optimum, each with its multiplier: share of the time lost per share of the limit.
    """

    residual: float
    active: list[dict[str, Any]]


def certificate(problem: Switching, u: Array, scale: float) -> Certificate:
    """Non-negative least squares over the constraints and bounds that are active."""
    found = problem.first(u=u)
    rows = zip(problem.names, found["margins"][:, 0], found["jacobian"], strict=True)
    eye, keys = np.eye(len(u)), list(VARIABLES)
    held = [
        *rows,
        *((f"{key} at its lower bound", u[i], eye[i]) for i, key in enumerate(keys)),
        *((f"{key} at its upper bound", 1 - u[i], -eye[i]) for i, key in enumerate(keys)),
    ]
    active = [row for row in held if row[1] < ACTIVE]
    gradient = found["gradient"][:, 0] / scale
    violation = max(0.0, -min(float(margin) for _, margin, _ in held))
    if not active:
        return Certificate(max(float(np.linalg.norm(gradient)), violation), [])
    multipliers, residual = nnls(np.array([row for _, _, row in active]).T, gradient)
    slack = np.array([margin for _, margin, _ in active])
    worst = max(float(residual), violation, float(np.abs(multipliers * slack).max()))
    named = [
        {"name": name, "multiplier": float(m)} for (name, _, _), m in zip(active, multipliers, strict=True) if m > 0
    ]
    return Certificate(worst, named)


def optimise(clutch: Clutch, seed: int = 0, starts: int = STARTS) -> dict[str, Any]:
    """Axial angle, gear ratio and linkage of the smallest travel time under the limits of the file.

    Raises InputError for bounds that hold linkages that do not close, ComputationError where no start ends at a point
    that satisfies every limit.
    """
    problem = Switching(clutch)
    own = problem.first(u=problem.start)
    scale = float(own["time"][0, 0])
    random = np.random.default_rng(seed).random((starts - 1, len(VARIABLES)))
    first: list[Array] = [problem.start, *random]
    for _ in range(ROUNDS):
        programme = TravelTime(problem, scale)
        ends = [ipopt.solve(programme, u) for u in first]
        good = [e.z for e in ends if e.converged and programme.g(e.z).min() > -FEASIBLE]
        if not good:
            raise ComputationError(_hopeless(problem, [e.z for e in ends]))
        times = np.array([programme.f(u) for u in good])
        u = np.clip(good[int(np.argmin(times))], 0, 1)
        peaks = {what: share for what, (margin, share) in problem.worst_along(u).items() if margin < -PEAK}
        if not peaks:
            break
        stations = {w: sorted({*at, *([peaks[w]] if w in peaks else [])}) for w, at in problem.stations.items()}
        problem, first = Switching(clutch, stations), good
    proof = certificate(problem, u, scale)
    return {
        "clutch": clutch.name,
        "travel_time_s": programme.f(u) * scale,
        "start_travel_time_s": scale,
        "start_violates": [problem.names[i] for i in np.flatnonzero(own["margins"][:, 0] < -FEASIBLE)],
        "design": _shown(problem, u),
        "start_design": _shown(problem, problem.start),
        "stations": {what: list(at) for what, at in problem.stations.items()},
        "least_margin_along": {what: margin for what, (margin, _) in problem.worst_along(u).items()},
        "bounds": {key: [low, high] for key, low, high in _bounds(problem)},
        "certificate": {
            "kkt_residual": proof.residual,
            "active": proof.active,
            "starts": starts,
            "agreeing_starts": int((times <= times.min() + AGREEING).sum()),
            "spread": float(np.ptp(times)),
        },
        "assumes": list(ASSUMES),
        "seed": seed,
    }


def _shown(problem: Switching, u: Array) -> dict[str, float]:
    design = problem.design(u)
    return {key: design[name] / units.factor(key) for key, (name, _) in VARIABLES.items()}


def _bounds(problem: Switching) -> list[tuple[str, float, float]]:
    pairs = zip(VARIABLES, problem.box_lower, problem.box_upper, strict=True)
    return [(key, float(low) / units.factor(key), float(high) / units.factor(key)) for key, low, high in pairs]


def _hopeless(problem: Switching, points: list[Array]) -> str:
    """Which limit the best of the points breaks most."""
    margins = [problem.first(u=np.clip(u, 0, 1))["margins"][:, 0] for u in points]
    best = max(margins, key=lambda m: float(m.min()))
    return (
        f"no design within the bounds keeps all limits: {problem.names[int(best.argmin())]} fails by "
        f"{-100 * best.min():.3g} % of its limit at the best point found"
    )
