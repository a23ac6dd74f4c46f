"""One pair of families: optimised under the requirements, or told why none of its designs keeps them."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from planter.errors import ComputationError
from planter.gearing.families import own_parameters
from planter.gearing.stage import names
from planter.kernels import Array
from planter.optimise import certificate
from planter.optimise.constraints import Constraints
from planter.optimise.descent import Minimum, descend
from planter.optimise.elastic import Least, least_violation
from planter.optimise.feasible import verdict
from planter.optimise.objective import Objective
from planter.optimise.problem import Problem
from planter.optimise.response import Planting
from planter.optimise.starts import points
from planter.planting import cycle
from planter.planting.compare import box
from planter.planting.file import Machine
from planter.planting.model import Device
from planter.planting.requirements.record import record

ITERATIONS, POLISH = 30, 60
"""Most iterations of a descent from each start, and of another from the best of them."""
AT_LIMIT = 1e-4
"""A requirement binds whose row is this close to its bound, in steps."""


def optimised(own: Machine, pair: box.Pair, starts: int, seed: int) -> dict[str, Any]:
    """The entry of a pair in the comparison; extremes and integrals are true ones, not sampled."""
    begun = time.perf_counter()
    device = Device(box.described(own, pair))
    constraints = Constraints.of(device)
    assert constraints is not None
    problem = Problem(Planting(device), Objective.of(device.machine), "refined", constraints)
    minima, least = _searched(problem, constraints, starts, seed)
    kept = [minimum for minimum in minima if problem.kept(minimum.u)]
    entry: dict[str, Any] = {"stage1": pair[0], "stage2": pair[1], "feasible": bool(kept)}
    if kept:
        best = min(kept, key=lambda minimum: minimum.objective)
        polished = descend(problem, best.u, POLISH, 1)
        best = min((best, polished), key=lambda minimum: (not problem.kept(minimum.u), minimum.objective))
        entry |= _found(problem, constraints, best.u)
        entry |= {"objectives": [m.objective for m in kept], "kkt_residual": best.residual, "violations": []}
    else:
        found = verdict(problem, constraints, least)
        u = (found.design - problem.response.lower) / problem.width
        entry |= _found(problem, constraints, u) | {"objectives": [], "kkt_residual": None}
        entry |= {"binding": [one.name for one in found.violations], "violations": found.partial["violations"]}
    return entry | {"seconds": time.perf_counter() - begun}


def _searched(problem: Problem, constraints: Constraints, starts: int, seed: int) -> tuple[list[Minimum], list[Least]]:
    """From each start to where the requirements are kept, and from there to a minimum."""
    minima, least = [], []
    for start in points(problem, starts, seed):
        try:
            least.append(least_violation(problem, constraints, start))
            if least[-1].kept:
                minima += [descend(problem, least[-1].u, ITERATIONS, 1), _here(problem, least[-1].u)]
        except ComputationError:
            continue
    if not least:
        raise ComputationError("no start of this pair of families has a path that can plant")
    return minima, least


def _here(problem: Problem, u: Array) -> Minimum:
    """A point as it is, for where a descent that was cut short left the requirements."""
    return Minimum(u, problem.evaluate(u), certificate.kkt_residual(problem, u), 0)


def _found(problem: Problem, constraints: Constraints, u: Array) -> dict[str, Any]:
    device, x = constraints.measures.device, problem.design(u)
    evaluation = problem.evaluate(u)
    measures = constraints.measures
    excess = constraints.limits.excess(measures.at(x).values)
    binding = [k.name for n, k in enumerate(measures.kinds) if excess[constraints.owner == n].max() > -AT_LIMIT]
    return {
        "objective": evaluation.objective, "range_N": evaluation.range_N, "variance_N2": evaluation.variance_N2,
        "design": cycle.shown_design(device, x) | own_design(device, x),
        "binding": binding, "requirements": record(measures, x),
    }  # fmt: skip


def own_design(device: Device, x: Array) -> dict[str, float]:
    """The families' own parameters of a described design, under their own names."""
    from planter.files import units
    from planter.gearing import relative

    start = len(device.sidecar["vectors"]["mounting"])
    found: dict[str, float] = {}
    for number, stage in enumerate(device.stages, 1):
        family = relative.of(stage.family) or stage.family
        values = own_parameters(family, x[start : start + len(stage.names)])
        shown = names(family, device.sidecar["vectors"][f"parameters{number}"])
        found |= {name: float(value / units.factor(name)) for name, value in zip(shown, values, strict=True)}
        start += len(stage.names)
    return found


def narrow(own: Machine) -> dict[str, Any]:
    """The paper's pair within the paper's narrow bounds, no requirement kept, and what that makes of them."""
    device = Device(box.narrow(own))
    constraints = Constraints.of(device)
    assert constraints is not None
    problem = Problem(Planting(device), Objective.of(own), "refined")
    u = descend(problem, problem.start, POLISH, 3).u
    entry = _found(problem, constraints, u)
    broken = [one["name"] for one in entry["requirements"] if one["verdict"] != "pass"]
    keys = ("objective", "range_N", "variance_N2", "requirements")
    shown = cycle.shown_design(device, problem.design(np.asarray(u)))
    return {key: entry[key] for key in keys} | {"design": shown, "feasible": not broken, "binding": broken}
