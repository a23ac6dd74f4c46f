"""Optima of machines: the engine's search for what their file, `--least` and `--hold` ask."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from planter.engine import search
from planter.engine.goal import CYCLE, Goal, find_display_unit, resolve_limit, resolve_measure
from planter.engine.machine import Machine
from planter.engine.measures import AVERAGES, Limit, Measure, format_sum, parse_limit, parse_sum
from planter.engine.search import GoalOptimum, SearchSpec, minimise
from planter.engine.summary import ROUNDING
from planter.errors import InputError
from planter.kernels import Array
from planter.mechanism.periodicity import require_repeating
from planter.mechanism.results import ActiveLimit, Evaluations, Held, Optimum, Proof
from planter.optimise.constraints import KEPT
from planter.optimise.range_and_spread import Sampling
from planter.optimise.starts import Descent
from planter.parallel.task import HERE, Means, Task
from planter.progress import Listener


@dataclass(frozen=True)
class Found:
    """An optimum: the design (p,) in SI, the machine with it in place, and its result."""

    x: Array
    machine: Machine
    result: Optimum


@dataclass(frozen=True)
class StatedGoal:
    """The sum and the limits of a machine's file and of a call, in the names of its quantities."""

    machine: Machine
    least: tuple[Measure, ...]
    limits: tuple[Limit, ...]

    @classmethod
    def read(cls, machine: Machine, least: str | None = None, holds: Sequence[str] = ()) -> StatedGoal:
        """Return the goal of a machine's file; `least` replaces its sum, `holds` are more limits.

        Raises InputError for what cannot be parsed, or is of another machine.
        """
        terms = machine.least if least is None else parse_sum(least)
        limits = (*machine.limits, *map(parse_limit, holds))
        return cls(
            machine,
            tuple(resolve_measure(machine, measure) for measure in terms),
            tuple(resolve_limit(machine, limit) for limit in limits),
        )

    def require_least(self) -> None:
        """Raise InputError if there is no sum, ComputationError for the mean of what does not repeat after a cycle."""
        if not self.least:
            raise InputError(f"{self.machine.source}: objective.least is missing: give a sum there, or by --least")
        self.require_averages()

    def require_jumps(self) -> None:
        """Raise InputError for a jump that is to be least and is zero already, since nothing is less."""
        for measure in self.least:
            if measure.kind != "jump":
                continue
            largest = Measure("max", measure.name, size=True)
            goal = Goal(self.machine, (replace(measure, weight=1.0), largest), (), with_events=False)
            jump, size = (goal.measure(self.machine.design, term) for term in goal.least)
            if jump <= ROUNDING * size:
                reason = f"{measure.name} does not jump at the machine's own design, and no jump is less than 0"
                raise InputError(f"{self.machine.source}: {measure}: {reason}; leave it out, or state it as a limit")

    def require_averages(self) -> None:
        """Raise ComputationError for the mean of what does not repeat after a cycle."""
        measures = (*self.least, *(limit.measure for limit in self.limits))
        require_repeating(self.machine, [measure.name for measure in measures if measure.kind in AVERAGES])


def vary(machine: Machine, ranges: Mapping[str, tuple[float, float]]) -> Machine:
    """Return a machine that is searched in other values than its file says, by path between ends in their units.

    Without ranges it is the machine itself. Raises InputError for what is no value, or an end that its file refuses.
    """
    for path, (low, high) in ranges.items():
        if not low < high:
            raise InputError(f"--vary {path}={low:g}:{high:g} is not allowed: LOW must be below HIGH")
        full = machine.values[machine.index_of(path)].path
        for end in (low, high):
            machine.document.with_numbers({full: end})
    return machine.with_moved(ranges) if ranges else machine


def optimise(
    machine: Machine,
    least: str | None = None,
    holds: Sequence[str] = (),
    spec: SearchSpec | None = None,
    listener: Listener | None = None,
    means: Means = HERE,
) -> Found:
    """Return the design within the file's bounds that minimises a sum of measures under limits.

    `least` replaces the file's sum, `holds` are limits beside the file's, `means` says what runs the descents, whose
    results do not depend on it. Raises InputError for measures that cannot be parsed, a file without bounds or sum,
    or a jump that is zero already; ComputationError if no start leads to a design that satisfies the limits, and for
    the mean of what does not repeat after a turn.
    """
    begun = time.perf_counter()
    goal = StatedGoal.read(machine, least, holds)
    goal.require_least()
    goal.require_jumps()
    spec = spec or SearchSpec(machine.sampling)
    stated = {"searched": machine.searched, "least": least, "holds": list(holds), "sampling": spec.sampling}
    task = Task(prepare_descents, {"build": partial(machine.build, machine.document), **stated})
    optimum = minimise(machine, goal.least, goal.limits, spec, listener, task, means)
    return _record(machine, least or format_sum(machine.least), spec, optimum, begun)


def prepare_descents(
    build: Callable[[], Machine], searched: Mapping[str, Any], least: str | None, holds: Sequence[str],
    sampling: Sampling,
) -> Callable[[Array], Descent]:  # fmt: skip
    """Return the function that descends from a point to what a sum and limits ask for, in a worker.

    `build` gives the machine as its file has it, `searched` are the fields that the search has set otherwise.
    """
    goal = StatedGoal.read(replace(build(), **searched), least, holds)
    return search.prepare_descents(goal.machine, goal.least, goal.limits, sampling)


def evaluate_limits(machine: Machine, changing: Collection[str] = ()) -> list[Held]:
    """Return what the limits of a machine's file are on at its own design, true extremes and integrals.

    `changing` are the keys of quantities that do not repeat after a turn, which has no averages of them. Raises
    InputError for limits on what the machine does not have, ComputationError where there is no cycle.
    """
    stated = StatedGoal.read(machine)
    goal, x = Goal(stated.machine, (), stated.limits), stated.machine.design
    goal, holds = goal.refined(x, 0.0) or goal, []
    for limit in goal.limits:
        hold, parts = _hold(goal, x, limit), stated.machine.list_parts(limit.measure.name)
        is_changing = any(stated.machine.find_quantity(part).key in changing for part in parts)
        averaged = limit.measure.kind in AVERAGES and is_changing
        holds.append(replace(hold, value=None, active=False, met=False) if averaged else hold)
    return holds


def _hold(goal: Goal, x: Array, limit: Limit, active: bool | None = None) -> Held:
    """Return a limit with what it is on; without a certificate it is active where it is reached to rounding."""
    value = goal.reached(x, limit)
    room = float("inf") if value is None else limit.sign * (limit.number - value) / goal.step(limit)
    return Held(
        limit_on=str(limit),
        value=value,
        limit=limit.number,
        active=abs(room) <= KEPT if active is None else active,
        met=room >= -KEPT,
    )


def _record(machine: Machine, least: str, spec: SearchSpec, optimum: GoalOptimum, begun: float) -> Found:
    goal, x, certificate = optimum.goal, optimum.x, optimum.certificate
    design = [float(f"{value:.15g}") for value in x / machine.scale]
    paths, stated = [machine.values[index].path for index in machine.moved], machine.document.numbers()
    prices = {one.name: one for one in certificate.active_constraints}
    holds = [_hold(goal, x, limit, str(limit) in prices) for limit in goal.limits]
    result = Optimum(
        machine=machine.name,
        method=spec.method,
        least=least,
        objective=goal.evaluate(x),
        start_objective=goal.evaluate(machine.design),
        design=dict(zip(machine.design_names, design, strict=True)),
        start_design={name: stated[path] for name, path in zip(machine.design_names, paths, strict=True)},
        holds=holds,
        met=all(hold.met for hold in holds),
        certificate=Proof(
            kkt_residual=certificate.kkt_residual,
            active_bounds=[f"{one.name} {one.side}" for one in certificate.active_bounds],
            active_limits=[
                ActiveLimit(str(limit), prices[str(limit)].multiplier, find_display_unit(machine, limit.measure).text)
                for limit in goal.limits
                if str(limit) in prices
            ],
            starts=certificate.starts,
            agreeing_starts=certificate.agreeing_starts,
            spread=certificate.spread,
        ),
        evaluations=Evaluations(**vars(optimum.evaluations)),
        samples=len(goal.nodes[CYCLE](x).weights) if CYCLE in goal.nodes else machine.samples,
        seconds=time.perf_counter() - begun,
    )
    document = machine.document.with_numbers(dict(zip(paths, design, strict=True)))
    return Found(x, replace(machine, document=document, data=machine.data_at(x)), result)
