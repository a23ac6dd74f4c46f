"""Pairs of gear families: the design box that all of them share, and the optimum of a pair under
the requirements.
"""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from planter.engine.problem import DesignProblem
from planter.engine.solvers import result
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.feasibility import (
    ViolationMinimum,
    minimise_violation,
    select_smallest_violation,
)
from planter.engine.solvers.local_search import (
    AGREEMENT_TOLERANCE,
    STATIONARITY_TOLERANCE,
    LocalMinimum,
    evaluate_minimum,
    sample_starts,
    search_locally,
)
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.gears.geometry import families
from planter.gears.geometry.families import SUFFIX, compute_family_parameters
from planter.gears.geometry.stage import list_design_names
from planter.kernels import Array
from planter.papers.planting import file
from planter.papers.planting.design_summary import summarise_design
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.objective import build_problem, evaluate_true_extremes
from planter.papers.planting.requirements import (
    RequirementConstraints,
    build_infeasibility_error,
    measure_excess,
)

REFERENCE = "wang2017-wide"
"""Built-in machine whose box for the mounting, and whose requirements, serve where the machine has
none.
"""
NARROW = "wang2017"
"""Built-in machine with the paper's own bounds."""
SIZE_MM, SWING, DEFORMATION = (24.0, 36.0), (0.02, 0.5), (0.8, 1.8)
"""Mean radius, relative swing of the ratio and deformation coefficient of a stage: assumed."""
Pair = tuple[str, str]


def list_pairs() -> list[Pair]:
    """Return every family on the sun with every family on gear 6."""
    return list(itertools.product(families.list_families(), families.list_families()))


def add_requirements(machine: PlantingMachine) -> PlantingMachine:
    """Return the machine; without requirements, with those of the reference and its speed over
    ground.
    """
    if machine.requirements is not None:
        return machine
    table, reference = machine.table(), file.load(REFERENCE).table()
    table["requirements"] = reference["requirements"]
    if not machine.operation.forward_speed_m_s:
        table["operation"]["forward_speed_m_s"] = reference["operation"]["forward_speed_m_s"]
    return PlantingMachine.read(table, machine.source)


def build_narrow_machine(machine: PlantingMachine) -> PlantingMachine:
    """Return the machine with the paper's design and bounds if its parameters are the same, else
    with its own.
    """
    paper, constrained = file.load(NARROW), add_requirements(machine)
    if set(paper.design) != set(machine.design):
        return constrained
    table = constrained.table() | {"design": dict(paper.design), "bounds": dict(paper.bounds)}
    return PlantingMachine.read(table, machine.source)


def build_pair_machine(machine: PlantingMachine, pair: Pair) -> PlantingMachine:
    """Return the machine with a pair of families in the shared bounds, its design close to that of
    the machine.
    """
    table = machine.table()
    device = Device(machine)
    wide = file.load(REFERENCE).bounds
    mounting = [entry["shown"] for entry in device.sidecar["vectors"]["mounting"]]
    bounds: dict[str, Any] = {name: _widen(wide[name], machine.design[name]) for name in mounting}
    design: dict[str, float] = {name: machine.design[name] for name in mounting}
    for number, family in enumerate(pair, 1):
        box, start = _describe_stage(device, number, family)
        bounds |= box
        design |= {name: float(np.clip(value, *box[name])) for name, value in start.items()}
        table[f"stage{number}"] = {"family": family + SUFFIX}
    stated = set(table) - {"design", "bounds"}
    origin = {name: text for name, text in table["origin"].items() if name.split(".")[0] in stated}
    table |= {"design": design, "bounds": bounds, "origin": {"default": "assumed", **origin}}
    return PlantingMachine.read(table, f"{machine.source}, {pair[0]} and {pair[1]}")


def _widen(bounds: tuple[float, float], value: float) -> tuple[float, float]:
    return min(bounds[0], value), max(bounds[1], value)


def _describe_stage(
    device: Device, number: int, family: str
) -> tuple[dict[str, tuple[float, float]], dict[str, float]]:
    """Return the bounds of a stage's parameters, and the start: that of the device's curve."""
    vector = device.sidecar["vectors"][f"parameters{number}"]
    suffix, last = vector["suffix"], vector["known"]["-1"]["shown"]
    size, swing, m = measure_curve(device, number - 1)
    shapes = families.load_sidecar(family)["shapes"]
    box = {
        f"size{suffix}_mm": SIZE_MM,
        f"swing{suffix}": SWING,
        **{f"{s['name']}{suffix}": (s["lower"], s["upper"]) for s in shapes},
        last: DEFORMATION,
    }
    start = dict(zip(box, (1e3 * size, swing, *(0.0 for _ in shapes), m), strict=True))
    return box, start


def measure_curve(device: Device, stage: int) -> tuple[float, float, float]:
    """Return mean radius [m], relative swing of the ratio and deformation coefficient of a device's
    stage.
    """
    gears, parameters = device.stages[stage], device.of_stage(stage, device.design)
    hoisted = gears.prologue(parameters=parameters)["hoisted"]
    ends = np.array([0.0, np.pi / parameters[-1]])
    high, low = gears.contact(t=ends, parameters=parameters, hoisted=hoisted)["ratio"][0]
    return float(hoisted[0, 0] / 2), float((high - low) / (high + low)), float(parameters[-1])


def parse_pairs(texts: list[str] | None) -> list[Pair] | None:
    """Return the pairs of texts `family+family`, None without texts.

    Raises InputError if one is not two families.
    """
    if not texts:
        return None
    split = [tuple(text.split("+")) for text in texts]
    for text, pair in zip(texts, split, strict=True):
        if len(pair) != 2 or not set(pair) <= set(families.list_families()):
            allowed = f"it must be two of {', '.join(families.list_families())} with + between them"
            raise InputError(f"--pair {text}: {allowed}")
    return [(pair[0], pair[1]) for pair in split]


ITERATIONS = 60
"""Most iterations of a descent."""
MORE_STARTS, ABOUT = 6, 0.25
"""Starts about the best minimum, and how far: this share of the way from it to points anywhere in
the
"""
CHECKS = 2
"""Starts about the best minimum that have to find nothing better, even where two agree."""
AT_LIMIT = 1e-4
"""A requirement binds whose row is this close to its bound, in steps."""


def prepare_pairs(
    machine: PlantingMachine, constrained: PlantingMachine, starts: int, seed: int
) -> Callable[[Pair | None], dict[str, Any]]:
    """Return the function that makes the entry of a pair in the comparison, as read from JSON; None
    is the narrow box.

    `constrained` is the machine with requirements.
    """

    def run(pair: Pair | None) -> dict[str, Any]:
        entry: dict[str, Any] = (
            optimise_narrow(machine)
            if pair is None
            else optimise_pair(constrained, pair, starts, seed)
        )
        content: dict[str, Any] = json.loads(json.dumps(entry, allow_nan=False))
        return content

    return run


def optimise_pair(machine: PlantingMachine, pair: Pair, starts: int, seed: int) -> dict[str, Any]:
    """Return the entry of a pair in the comparison; extremes and integrals are true ones, not
    sampled.
    """
    begin = time.perf_counter()
    device = Device(build_pair_machine(machine, pair))
    required = RequirementConstraints(device)
    problem = build_problem(device, "refined", required)
    ends, violations = _search(problem, required, starts, seed)
    entry: dict[str, Any] = {"stage1": pair[0], "stage2": pair[1], "feasible": bool(ends)}
    if ends:
        u = result.select_nearest_optimum(problem, ends[0].u)
        ends[0] = best = evaluate_minimum(problem, u, ends[0].iterations)
        entry |= _describe_design(problem, required, best.u)
        entry |= {
            "objectives": [m.objective for m in ends],
            "kkt_residual": best.residual,
            "violations": [],
            "agreeing_starts": len(_agreeing(problem, ends)),
            "lacks": _list_missing_evidence(problem, ends),
        }
    else:
        nearest = select_smallest_violation(violations)
        error = build_infeasibility_error(required, problem, nearest, len(violations))
        entry |= _describe_design(problem, required, nearest.u) | {
            "objectives": [],
            "kkt_residual": None,
            "agreeing_starts": 0,
        }
        entry |= {
            "binding": [violated.name for violated in error.violations],
            "violations": error.partial["violations"],
            "lacks": [] if nearest.stationary else ["a violation that is least to first order"],
        }
    return entry | {"settled": not entry["lacks"], "seconds": time.perf_counter() - begin}


def _search(
    problem: DesignProblem, required: RequirementConstraints, starts: int, seed: int
) -> tuple[list[LocalMinimum], list[ViolationMinimum]]:
    """Return the ends of searches from feasible points, best first, and the smallest violations of
    all starts.

    With more than one start, further starts about the best follow until two agree and `CHECKS` of
    them found nothing better.
    """
    ends: list[LocalMinimum] = []
    violations: list[ViolationMinimum] = []
    first, *more = sample_starts(problem, starts + MORE_STARTS, seed)
    for start in (first, *more[: starts - 1]):
        _try_start(problem, required, start, ends, violations)
    if not violations:
        raise ComputationError("no start of this pair of families has a path that can plant")
    unbeaten = 0
    for aim in more[starts - 1 :]:
        if starts < 2 or not ends or not ends[0].stationary:
            break
        if unbeaten >= CHECKS and len(_agreeing(problem, ends)) > 1:
            break
        best = ends[0]
        _try_start(problem, required, best.u + ABOUT * (aim - best.u), ends, violations)
        unbeaten = (
            unbeaten + 1
            if best.objective - ends[0].objective <= AGREEMENT_TOLERANCE * problem.scale
            else 0
        )
    return ends, violations


def _try_start(
    problem: DesignProblem,
    required: RequirementConstraints,
    start: Array,
    ends: list[LocalMinimum],
    violations: list[ViolationMinimum],
) -> None:
    """Add the violation and the end of a start; neither if the search meets a path that cannot
    plant.
    """
    try:
        violations.append(minimise_violation(problem, required, start))
        minimum = search_locally(problem, violations[-1].u, ITERATIONS)
    except ComputationError:
        return
    if minimum.violation <= FEASIBILITY_TOLERANCE:
        ends.append(minimum)
        ends.sort(key=lambda end: end.objective)


def _agreeing(problem: DesignProblem, ends: list[LocalMinimum]) -> list[LocalMinimum]:
    """Return the minima whose objective is that of the first."""
    return [
        end
        for end in ends
        if abs(end.objective - ends[0].objective) <= AGREEMENT_TOLERANCE * problem.scale
    ]


def _list_missing_evidence(problem: DesignProblem, ends: list[LocalMinimum]) -> list[str]:
    """Return what is missing for the best of the minima to count as settled."""
    best, *further = ends
    missing = (
        []
        if best.stationary
        else [f"a KKT residual below {STATIONARITY_TOLERANCE:.0e} ({best.residual:.0e})"]
    )
    if len(_agreeing(problem, ends)) < 2:
        reason = (
            f"the next ended at {further[0].objective:.6g}"
            if further
            else "no other kept the requirements"
        )
        missing.append(f"a second start that agrees ({reason})")
    return missing


def _describe_design(
    problem: DesignProblem, required: RequirementConstraints, u: Array
) -> dict[str, Any]:
    measures, x = required.measures, problem.design(u)
    device = measures.device
    score = evaluate_true_extremes(device, x)
    excess = measure_excess(measures, x)
    binding = [
        k.name
        for n, k in enumerate(measures.kinds)
        if excess[required.owner == n].max() > -AT_LIMIT
    ]
    return {
        "objective": score.objective,
        "range_N": score.range_N,
        "variance_N2": score.variance_N2,
        "design": device.named(x) | list_family_parameters(device, x),
        "binding": binding,
        "requirements": [result.table() for result in required.record(x)],
        "designer": summarise_design(device, x).table(),
    }


def list_family_parameters(device: Device, x: Array) -> dict[str, float]:
    """Return the parameters of the families at a design of the shared bounds, by their own
    names.
    """
    design: dict[str, float] = {}
    for number, stage in enumerate(device.stages, 1):
        family = families.find_family(stage.family) or stage.family
        values = compute_family_parameters(family, device.of_stage(number - 1, x))
        names = list_design_names(family, device.sidecar["vectors"][f"parameters{number}"])
        design |= {
            name: float(value / units.unit_factor(name))
            for name, value in zip(names, values, strict=True)
        }
    return design


def optimise_narrow(machine: PlantingMachine) -> dict[str, Any]:
    """Return the entry of the paper's narrow bounds, optimised without the requirements, which it
    may violate.
    """
    device = Device(build_narrow_machine(machine))
    problem = build_problem(device, "refined")
    u = search_locally(problem, problem.start, ITERATIONS, 3).u
    entry = _describe_design(problem, RequirementConstraints(device), u)
    violated = [row["name"] for row in entry["requirements"] if row["verdict"] != "pass"]
    keys = ("objective", "range_N", "variance_N2", "requirements")
    design = device.named(problem.design(np.asarray(u)))
    return {key: entry[key] for key in keys} | {
        "design": design,
        "feasible": not violated,
        "binding": violated,
    }
