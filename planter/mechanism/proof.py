"""`planter optimise --prove` for mechanisms of one's own: how much better than the optimum any design can be at most.

The objective that is bounded is that of samples. A search over true extremes ends at another design: the incumbent of
the proof is then the best design over the file's samples, which is searched from that optimum and other starts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from planter.engine.goal import Goal
from planter.engine.measures import Limit, Measure
from planter.engine.problem import build_problem
from planter.engine.proof import ProvableObjective, check_provable
from planter.engine.search import SearchSpec, minimise
from planter.kernels import Array
from planter.mechanism.enclosed import EnclosedMechanism
from planter.mechanism.file import MechanismFile
from planter.mechanism.machines import build_machine
from planter.mechanism.optimisation import Found, StatedGoal
from planter.optimise.constraints import KEPT
from planter.optimise.proof.bound import SECONDS, Incumbent, prove_bound
from planter.optimise.proof.shared import share_boxes
from planter.parallel.task import HERE, Means
from planter.progress import Listener


def require_provable(goal: StatedGoal, least: str | None) -> None:
    """Raise InputError for a goal of which no proof is known; `least` is the sum of the call, if it gives one."""
    machine = goal.machine
    check_provable(machine, goal.least, "--least" if least is not None else f"{machine.source}: objective.least")


def with_proof(
    file: MechanismFile, found: Found, goal: StatedGoal, spec: SearchSpec, seconds: float = SECONDS,
    listener: Listener | None = None, means: Means = HERE,
) -> Found:  # fmt: skip
    """Return an optimum of a file with the proof of the best design over samples, in so many seconds.

    `means` says what bounds the boxes: a proof that ends before its time is up does not depend on it.
    """
    machine = goal.machine
    count = file.turn.samples if spec.sampling == "refined" else spec.sampling
    sampled = Goal(machine, goal.least, goal.limits, count, with_events=False)
    x, objective = _find_incumbent(found, sampled, spec, replace(spec, sampling=count), listener)
    limits = [  # as the search takes them, to its tolerance
        replace(limit, number=limit.number + limit.sign * KEPT * sampled.step(limit)) for limit in goal.limits
    ]
    build = partial(build_objective, file, machine.searched, goal.least, limits, count)
    bounding = build()
    design = {key: float(value) for key, value in zip(machine.design_names, x / machine.scale, strict=True)}
    incumbent = Incumbent(x, design, objective, count, _describe_scope(goal, bounding))
    box = (machine.lower, machine.upper)
    with share_boxes(bounding, build, means) as shared:
        proof = prove_bound(shared, box, incumbent, seconds, listener)
    return replace(found, result=replace(found.result, proof=proof))


def build_objective(
    file: MechanismFile, searched: Mapping[str, Any], least: Sequence[Measure], limits: Sequence[Limit], count: int
) -> ProvableObjective:  # fmt: skip
    """Return a sum of measures over `count` samples as a proof bounds it, in the values that are searched."""
    machine = replace(build_machine(file), **searched)

    def enclose(quantities: Sequence[tuple[str, bool]]) -> EnclosedMechanism:
        return EnclosedMechanism(machine, file.model, quantities)

    return ProvableObjective(machine, least, count, enclose, limits)


def _describe_scope(goal: StatedGoal, bounding: ProvableObjective) -> str:
    """Return in words for which designs the bound is."""
    conditions = ["closes its loops"] if goal.machine.loops else []
    if bounding.limits:
        conditions.append(f"satisfies the limits{'' if bounding.heeds_all else ' at fixed angles'}")
    return f"no design of the box that {' and '.join(conditions)}" if conditions else "no design of the box"


def _find_incumbent(
    found: Found, goal: Goal, spec: SearchSpec, sampled: SearchSpec, listener: Listener | None
) -> tuple[Array, float]:
    """Return the optimum over the samples of a goal (p,) and its objective: the one found, or one searched from there.

    `spec` is how it was found, `sampled` how it is searched over samples.
    """
    if spec == sampled:
        return found.x, found.result.objective
    start = goal.machine.with_data(goal.machine.data_at(found.x))
    optimum = minimise(build_problem(start, goal.least, goal.limits, sampled.sampling), sampled, listener)
    return optimum.x, goal.evaluate(optimum.x)
