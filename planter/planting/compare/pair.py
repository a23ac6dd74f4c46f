"""One pair of families: optimised under the requirements, or told why none of its designs keeps them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from planter.errors import ComputationError
from planter.gear_geometry.families import compute_family_parameters
from planter.gear_geometry.stage import list_design_names
from planter.kernels import Array
from planter.optimise import flat
from planter.optimise.constraints import KEPT
from planter.optimise.descent import STATIONARY, Minimum, at, descend
from planter.optimise.elastic import Least, least_violation
from planter.optimise.feasible import least_of
from planter.optimise.problem import Problem
from planter.optimise.starts import AGREEING, points
from planter.planting.compare import box
from planter.planting.designer import summary as designer
from planter.planting.file import Machine
from planter.planting.model import Device
from planter.planting.objective import build_problem as task_of
from planter.planting.requirements.constraints import Required
from planter.planting.requirements.verdict import infeasible

ITERATIONS = 60
"""Most iterations of a descent."""
MORE_STARTS, ABOUT = 6, 0.25
"""Starts about the best minimum, and how far: this share of the way from it to points anywhere in the box."""
CHECKS = 2
"""Starts about the best minimum that have to find nothing better, even where two agree."""
AT_LIMIT = 1e-4
"""A requirement binds whose row is this close to its bound, in steps."""


def prepare_pairs(
    own: Machine, required: Machine, starts: int, seed: int
) -> Callable[[box.Pair | None], dict[str, Any]]:
    """Return the function that makes the entry of a pair in the comparison, as read from JSON; None is the narrow box.

    `own` is the machine, `required` the same with requirements.
    """

    def run(pair: box.Pair | None) -> dict[str, Any]:
        entry: dict[str, Any] = narrow(own) if pair is None else optimised(required, pair, starts, seed)
        content: dict[str, Any] = json.loads(json.dumps(entry, allow_nan=False))
        return content

    return run


def optimised(own: Machine, pair: box.Pair, starts: int, seed: int) -> dict[str, Any]:
    """The entry of a pair in the comparison; extremes and integrals are true ones, not sampled."""
    begun = time.perf_counter()
    device = Device(box.described(own, pair))
    required = Required(device)
    problem = task_of(device, "refined", required)
    ends, least = _searched(problem, required, starts, seed)
    entry: dict[str, Any] = {"stage1": pair[0], "stage2": pair[1], "feasible": bool(ends)}
    if ends:
        ends[0] = best = at(problem, flat.nearest(problem, ends[0].u), ends[0].iterations)
        entry |= _found(problem, required, best.u)
        entry |= {"objectives": [m.objective for m in ends], "kkt_residual": best.residual, "violations": [],
                  "agreeing_starts": len(_agreeing(problem, ends)), "lacks": _lacks(problem, ends)}  # fmt: skip
    else:
        nearest = least_of(least)
        found = infeasible(required, problem.design(nearest.u), nearest)
        entry |= _found(problem, required, nearest.u) | {"objectives": [], "kkt_residual": None, "agreeing_starts": 0}
        entry |= {"binding": [one.name for one in found.violations], "violations": found.partial["violations"],
                  "lacks": [] if nearest.stationary else ["a violation that is least to first order"]}  # fmt: skip
    return entry | {"settled": not entry["lacks"], "seconds": time.perf_counter() - begun}


def _searched(problem: Problem, required: Required, starts: int, seed: int) -> tuple[list[Minimum], list[Least]]:
    """From each start to where the requirements are kept, and from there down: where each of those ended, best first.

    Where more than one was asked for, more starts are taken about the best, until two agree and `CHECKS` of these have
    found nothing better.
    """
    ends: list[Minimum] = []
    least: list[Least] = []
    first, *more = points(problem, starts + MORE_STARTS, seed)
    for start in (first, *more[: starts - 1]):
        _try(problem, required, start, ends, least)
    if not least:
        raise ComputationError("no start of this pair of families has a path that can plant")
    unbeaten = 0
    for aim in more[starts - 1 :]:
        if starts < 2 or not ends or not ends[0].stationary:
            break
        if unbeaten >= CHECKS and len(_agreeing(problem, ends)) > 1:
            break
        best = ends[0]
        _try(problem, required, best.u + ABOUT * (aim - best.u), ends, least)
        unbeaten = unbeaten + 1 if best.objective - ends[0].objective <= AGREEING * problem.scale else 0
    return ends, least


def _try(problem: Problem, required: Required, start: Array, ends: list[Minimum], least: list[Least]) -> None:
    """A start whose end goes to the others, in order; nothing where a path that can plant is left on the way."""
    try:
        least.append(least_violation(problem, required, start))
        found = descend(problem, least[-1].u, ITERATIONS)
    except ComputationError:
        return
    if found.violation <= KEPT:
        ends.append(found)
        ends.sort(key=lambda minimum: minimum.objective)


def _agreeing(problem: Problem, ends: list[Minimum]) -> list[Minimum]:
    """The minima whose objective is that of the first."""
    return [one for one in ends if abs(one.objective - ends[0].objective) <= AGREEING * problem.scale]


def _lacks(problem: Problem, ends: list[Minimum]) -> list[str]:
    """What is missing until the best of the minima counts as settled."""
    best, *others = ends
    found = [] if best.stationary else [f"a KKT residual below {STATIONARY:.0e} ({best.residual:.0e})"]
    if len(_agreeing(problem, ends)) < 2:
        told = f"the next ended at {others[0].objective:.6g}" if others else "no other kept the requirements"
        found.append(f"a second start that agrees ({told})")
    return found


def _found(problem: Problem, required: Required, u: Array) -> dict[str, Any]:
    measures, x = required.measures, problem.design(u)
    device, evaluation = measures.device, problem.evaluate(u)
    excess = required.limits.excess(measures.at(x).values)
    binding = [k.name for n, k in enumerate(measures.kinds) if excess[required.owner == n].max() > -AT_LIMIT]
    return {
        "objective": evaluation.objective, "range_N": evaluation.look.range, "variance_N2": evaluation.look.variance,
        "design": device.named(x) | own_design(device, x),
        "binding": binding, "requirements": [one.table() for one in required.record(x)],
        "designer": designer.of(device, x).table(),
    }  # fmt: skip


def own_design(device: Device, x: Array) -> dict[str, float]:
    """The families' own parameters of a described design, under their own names."""
    from planter.files import units
    from planter.gear_geometry import families

    start = len(device.sidecar["vectors"]["mounting"])
    found: dict[str, float] = {}
    for number, stage in enumerate(device.stages, 1):
        family = families.find_family(stage.family) or stage.family
        values = compute_family_parameters(family, x[start : start + len(stage.names)])
        shown = list_design_names(family, device.sidecar["vectors"][f"parameters{number}"])
        found |= {name: float(value / units.factor(name)) for name, value in zip(shown, values, strict=True)}
        start += len(stage.names)
    return found


def narrow(own: Machine) -> dict[str, Any]:
    """The paper's pair within the paper's narrow bounds, no requirement kept, and what that makes of them."""
    device = Device(box.narrow(own))
    problem = task_of(device, "refined")
    u = descend(problem, problem.start, ITERATIONS, 3).u
    entry = _found(problem, Required(device), u)
    broken = [one["name"] for one in entry["requirements"] if one["verdict"] != "pass"]
    keys = ("objective", "range_N", "variance_N2", "requirements")
    shown = device.named(problem.design(np.asarray(u)))
    return {key: entry[key] for key in keys} | {"design": shown, "feasible": not broken, "binding": broken}
