"""Pairs of gear families: the design box that all of them share, and the optimum of a pair under the requirements."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from planter.errors import ComputationError, InputError
from planter.gear_geometry import families
from planter.gear_geometry.families import SUFFIX, compute_family_parameters
from planter.gear_geometry.stage import list_design_names
from planter.kernels import Array
from planter.optimise import result
from planter.optimise.constraints import FEASIBILITY_TOLERANCE
from planter.optimise.feasibility import ViolationMinimum, minimise_violation, select_smallest_violation
from planter.optimise.local_search import (
    AGREEMENT_TOLERANCE,
    STATIONARITY_TOLERANCE,
    LocalMinimum,
    evaluate_minimum,
    sample_starts,
    search_locally,
)
from planter.optimise.problem import Problem
from planter.planting import file
from planter.planting.design_summary import summarise_design
from planter.planting.file import Machine
from planter.planting.model import Device
from planter.planting.objective import build_problem as task_of
from planter.planting.requirements import RequirementConstraints, build_infeasibility_error

REFERENCE = "wang2017-wide"
"""Built-in machine whose box for the mounting, and whose requirements, serve where the machine has none."""
NARROW = "wang2017"
"""Built-in machine with the paper's own bounds."""
SIZE_MM, SWING, DEFORMATION = (24.0, 36.0), (0.02, 0.5), (0.8, 1.8)
"""Mean radius, relative swing of the ratio and deformation coefficient of a stage: assumed."""
Pair = tuple[str, str]


def pairs() -> list[Pair]:
    """Every family of the registry on the sun with every one on gear 6."""
    return [(one, two) for one in families.list_families() for two in families.list_families()]


def required(own: Machine) -> Machine:
    """The machine with requirements: its own, else those of the reference, and a speed over ground with them."""
    if own.requirements is not None:
        return own
    table, reference = own.table(), file.load(REFERENCE).table()
    table["requirements"] = reference["requirements"]
    if not own.operation.forward_speed_m_s:
        table["operation"]["forward_speed_m_s"] = reference["operation"]["forward_speed_m_s"]
    return Machine.read(table, own.source)


def build_narrow_machine(own: Machine) -> Machine:
    """The machine in the paper's design and bounds, where those have its names; else in its own."""
    paper, wanted = file.load(NARROW), required(own)
    if set(paper.design) != set(own.design):
        return wanted
    table = wanted.table() | {"design": dict(paper.design), "bounds": dict(paper.bounds)}
    return Machine.read(table, own.source)


def described(own: Machine, pair: Pair) -> Machine:
    """The machine with a pair of families in the shared box, its design as near to the machine's own as that can be."""
    table = own.table()
    device = Device(own)
    wide = file.load(REFERENCE).bounds
    mounting = [entry["shown"] for entry in device.sidecar["vectors"]["mounting"]]
    bounds: dict[str, Any] = {name: _around(wide[name], own.design[name]) for name in mounting}
    design: dict[str, float] = {name: own.design[name] for name in mounting}
    for number, family in enumerate(pair, 1):
        box, start = _stage(device, number, family)
        bounds |= box
        design |= {name: float(np.clip(value, *box[name])) for name, value in start.items()}
        table[f"stage{number}"] = {"family": family + SUFFIX}
    origin = {name: text for name, text in table["origin"].items() if name.split(".")[0] in table}
    kept = {name: text for name, text in origin.items() if name.split(".")[0] not in ("design", "bounds")}
    table |= {"design": design, "bounds": bounds, "origin": {"default": "assumed", **kept}}
    return Machine.read(table, f"{own.source}, {pair[0]} and {pair[1]}")


def _around(bounds: tuple[float, float], value: float) -> tuple[float, float]:
    return min(bounds[0], value), max(bounds[1], value)


def _stage(device: Device, number: int, family: str) -> tuple[dict[str, tuple[float, float]], dict[str, float]]:
    """Box and start of a stage's description: that of the device's own curve."""
    vector = device.sidecar["vectors"][f"parameters{number}"]
    suffix, last = vector["suffix"], vector["known"]["-1"]["shown"]
    size, swing, m = curve(device, number - 1)
    shapes = families.load_sidecar(family)["shapes"]
    box = {f"size{suffix}_mm": SIZE_MM, f"swing{suffix}": SWING,
           **{f"{s['name']}{suffix}": (s["lower"], s["upper"]) for s in shapes}, last: DEFORMATION}  # fmt: skip
    start = dict(zip(box, (1e3 * size, swing, *(0.0 for _ in shapes), m), strict=True))
    return box, start


def curve(device: Device, stage: int) -> tuple[float, float, float]:
    """Mean radius [m], relative swing of the ratio and deformation coefficient of a device's own stage."""
    start = len(device.sidecar["vectors"]["mounting"]) + (len(device.stages[0].names) if stage else 0)
    gears = device.stages[stage]
    parameters = device.design[start : start + len(gears.names)]
    hoisted = gears.prologue(parameters=parameters)["hoisted"]
    ends = np.array([0.0, np.pi / parameters[-1]])
    high, low = gears.contact(t=ends, parameters=parameters, hoisted=hoisted)["ratio"][0]
    return float(hoisted[0, 0] / 2), float((high - low) / (high + low)), float(parameters[-1])


def parse_pairs(texts: list[str] | None) -> list[Pair] | None:
    """Pairs given as `family+family`; None where none are given. Raises InputError for what is not two families."""
    if not texts:
        return None
    found = [tuple(text.split("+")) for text in texts]
    for text, pair in zip(texts, found, strict=True):
        if len(pair) != 2 or not set(pair) <= set(families.list_families()):
            allowed = f"it must be two of {', '.join(families.list_families())} with + between them"
            raise InputError(f"--pair {text} is not allowed: {allowed}")
    return [(pair[0], pair[1]) for pair in found]


ITERATIONS = 60
"""Most iterations of a descent."""
MORE_STARTS, ABOUT = 6, 0.25
"""Starts about the best minimum, and how far: this share of the way from it to points anywhere in the """
CHECKS = 2
"""Starts about the best minimum that have to find nothing better, even where two agree."""
AT_LIMIT = 1e-4
"""A requirement binds whose row is this close to its bound, in steps."""


def prepare_pairs(own: Machine, required: Machine, starts: int, seed: int) -> Callable[[Pair | None], dict[str, Any]]:
    """Return the function that makes the entry of a pair in the comparison, as read from JSON; None is the narrow box.

    `own` is the machine, `required` the same with requirements.
    """

    def run(pair: Pair | None) -> dict[str, Any]:
        entry: dict[str, Any] = optimise_narrow(own) if pair is None else optimised(required, pair, starts, seed)
        content: dict[str, Any] = json.loads(json.dumps(entry, allow_nan=False))
        return content

    return run


def optimised(own: Machine, pair: Pair, starts: int, seed: int) -> dict[str, Any]:
    """The entry of a pair in the comparison; extremes and integrals are true ones, not sampled."""
    begun = time.perf_counter()
    device = Device(described(own, pair))
    required = RequirementConstraints(device)
    problem = task_of(device, "refined", required)
    ends, least = _searched(problem, required, starts, seed)
    entry: dict[str, Any] = {"stage1": pair[0], "stage2": pair[1], "feasible": bool(ends)}
    if ends:
        ends[0] = best = evaluate_minimum(
            problem, result.select_nearest_optimum(problem, ends[0].u), ends[0].iterations
        )
        entry |= _found(problem, required, best.u)
        entry |= {"objectives": [m.objective for m in ends], "kkt_residual": best.residual, "violations": [],
                  "agreeing_starts": len(_agreeing(problem, ends)), "lacks": _lacks(problem, ends)}  # fmt: skip
    else:
        nearest = select_smallest_violation(least)
        found = build_infeasibility_error(required, problem.design(nearest.u), nearest)
        entry |= _found(problem, required, nearest.u) | {"objectives": [], "kkt_residual": None, "agreeing_starts": 0}
        entry |= {"binding": [one.name for one in found.violations], "violations": found.partial["violations"],
                  "lacks": [] if nearest.stationary else ["a violation that is least to first order"]}  # fmt: skip
    return entry | {"settled": not entry["lacks"], "seconds": time.perf_counter() - begun}


def _searched(
    problem: Problem, required: RequirementConstraints, starts: int, seed: int
) -> tuple[list[LocalMinimum], list[ViolationMinimum]]:
    """From each start to where the requirements are kept, and from there down: where each of those ended, best first.

    Where more than one was asked for, more starts are taken about the best, until two agree and `CHECKS` of these have
    found nothing better.
    """
    ends: list[LocalMinimum] = []
    least: list[ViolationMinimum] = []
    first, *more = sample_starts(problem, starts + MORE_STARTS, seed)
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
        unbeaten = unbeaten + 1 if best.objective - ends[0].objective <= AGREEMENT_TOLERANCE * problem.scale else 0
    return ends, least


def _try(
    problem: Problem,
    required: RequirementConstraints,
    start: Array,
    ends: list[LocalMinimum],
    least: list[ViolationMinimum],
) -> None:
    """A start whose end goes to the others, in order; nothing where a path that can plant is left on the way."""
    try:
        least.append(minimise_violation(problem, required, start))
        found = search_locally(problem, least[-1].u, ITERATIONS)
    except ComputationError:
        return
    if found.violation <= FEASIBILITY_TOLERANCE:
        ends.append(found)
        ends.sort(key=lambda minimum: minimum.objective)


def _agreeing(problem: Problem, ends: list[LocalMinimum]) -> list[LocalMinimum]:
    """The minima whose objective is that of the first."""
    return [one for one in ends if abs(one.objective - ends[0].objective) <= AGREEMENT_TOLERANCE * problem.scale]


def _lacks(problem: Problem, ends: list[LocalMinimum]) -> list[str]:
    """What is missing until the best of the minima counts as settled."""
    best, *others = ends
    found = [] if best.stationary else [f"a KKT residual below {STATIONARITY_TOLERANCE:.0e} ({best.residual:.0e})"]
    if len(_agreeing(problem, ends)) < 2:
        told = f"the next ended at {others[0].objective:.6g}" if others else "no other kept the requirements"
        found.append(f"a second start that agrees ({told})")
    return found


def _found(problem: Problem, required: RequirementConstraints, u: Array) -> dict[str, Any]:
    measures, x = required.measures, problem.design(u)
    device, evaluation = measures.device, problem.evaluate(u)
    excess = required.limits.excess(measures.at(x).values)
    binding = [k.name for n, k in enumerate(measures.kinds) if excess[required.owner == n].max() > -AT_LIMIT]
    return {
        "objective": evaluation.objective, "range_N": evaluation.look.range, "variance_N2": evaluation.look.variance,
        "design": device.named(x) | own_design(device, x),
        "binding": binding, "requirements": [one.table() for one in required.record(x)],
        "designer": summarise_design(device, x).table(),
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


def optimise_narrow(own: Machine) -> dict[str, Any]:
    """The paper's pair within the paper's narrow bounds, no requirement kept, and what that makes of them."""
    device = Device(build_narrow_machine(own))
    problem = task_of(device, "refined")
    u = search_locally(problem, problem.start, ITERATIONS, 3).u
    entry = _found(problem, RequirementConstraints(device), u)
    broken = [one["name"] for one in entry["requirements"] if one["verdict"] != "pass"]
    keys = ("objective", "range_N", "variance_N2", "requirements")
    shown = device.named(problem.design(np.asarray(u)))
    return {key: entry[key] for key in keys} | {"design": shown, "feasible": not broken, "binding": broken}
