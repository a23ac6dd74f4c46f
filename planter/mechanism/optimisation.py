"""`planter optimise NAME --least ... --hold ...`: any measures of any quantities of a mechanism, within its bounds.

IPOPT from several starts on the smooth programme of `goal`; peaks between samples become samples, until none is left.
"""

from __future__ import annotations

import difflib
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from planter.engine.measures import AVERAGES, Measure, parse_limit, parse_sum
from planter.engine.response import Samples
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.kernels import Array
from planter.mechanism.file import MechanismFile
from planter.mechanism.goal import Goal, Limits
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.periodicity import require_repeating
from planter.mechanism.results import Held, Optimum, Proof
from planter.optimise.box import Box
from planter.optimise.constraints import KEPT
from planter.optimise.descent import Minimum, descend
from planter.optimise.problem import Problem
from planter.optimise.result import Certificate, certified
from planter.optimise.smooth import Smooth
from planter.optimise.starts import nearer
from planter.progress import Listener, Phase

STARTS = 8
MOST_ITERATIONS = 300
REACH = 1e3
"""Variables for extremes lie within so many spreads of where they start."""
SNAP = 1e-6
"""Share of the box within which an optimum is set onto a bound."""
FINE = 8
"""Points between two samples where a peak is looked for."""
PEAK = 1e-6
"""Share of a measure's spread by which a peak between samples may pass it."""
ROUNDS = 6


@dataclass(frozen=True)
class Found:
    """An optimum: the design (p,) in SI, the file with it in place, and what is told."""

    x: Array
    machine: MechanismFile
    result: Optimum


def optimise(
    file: MechanismFile,
    least: str,
    holds: Sequence[str] = (),
    starts: int = STARTS,
    seed: int = 0,
    listener: Listener | None = None,
) -> Found:
    """The design within the file's bounds that makes a sum of measures least under limits.

    Raises InputError for measures that cannot be meant, or a file without bounds; ComputationError where no start
    leads to a design that keeps the limits, and for the mean of what does not repeat after a turn.
    """
    begun = time.perf_counter()
    goal = _Stated(file, least, holds)
    if averaged := goal.averaged:
        require_repeating(Model(file), averaged, file.turn.samples)
    angles = 2 * np.pi * np.arange(file.turn.samples) / file.turn.samples
    programme = goal.over(angles)
    minima = _minima(programme, _starts(file, starts, seed), listener)
    good = [one for one in minima if one.violation <= KEPT]
    if not good:
        raise ComputationError(_hopeless(programme, minima))
    best = min(good, key=lambda one: one.rank)
    agreeing = certified(programme.problem, best.u, good)
    for _ in range(ROUNDS):
        x = programme.snapped(best.u)
        more = _peaks(programme, x)
        if not len(more):
            break
        programme = goal.over(angles := np.union1d(angles, more))
        best = descend(programme.problem, programme.point(x), MOST_ITERATIONS)
    return _found(file, least, programme, best, agreeing, time.perf_counter() - begun)


class _Stated:
    """What is asked, in the names of the file's own quantities."""

    def __init__(self, file: MechanismFile, least: str, holds: Sequence[str]) -> None:
        if not file.bounds:
            raise InputError(f"{file.source}: it has no [bounds], so there is nothing to search in")
        self.file = file
        self.least = tuple(self._known(one) for one in parse_sum(least))
        self.holds = tuple(replace(h, measure=self._known(h.measure)) for h in map(parse_limit, holds))
        spoken = (m.name for m in (*self.least, *(h.measure for h in self.holds)))
        self.names = list(dict.fromkeys(spoken))

    @property
    def averaged(self) -> list[str]:
        """Names of the quantities of which a mean, a root mean square or a variance is asked."""
        asked = (*self.least, *(h.measure for h in self.holds))
        return [measure.name for measure in asked if measure.kind in AVERAGES]

    def over(self, angles: Array) -> _Programme:
        return _Programme(
            Goal(Samples(build_machine(self.file), self.names, angles), self.names, self.least, self.holds)
        )

    def _known(self, measure: Measure) -> Measure:
        """The measure of an output by its own name. Raises InputError for a name that is none."""
        if measure.where or measure.during or measure.kind == "work":
            raise InputError(f"{measure} is not allowed: it must be of a whole turn, or at an angle")
        known = {entry["name"]: entry for entry in Model(self.file).outputs}
        keys = {units.key(name, entry["unit"]): name for name, entry in known.items()}
        if measure.name not in known and measure.name not in keys:
            near = difflib.get_close_matches(measure.name, [*known, *keys], 1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            raise InputError(f"{measure.name}: {self.file.name} has no such quantity; {hint}")
        return replace(measure, name=keys.get(measure.name, measure.name))


class _Programme:
    """A goal as a problem: searched in shares of the bounds, and in spreads of the measures from where they start."""

    def __init__(self, goal: Goal) -> None:
        self.goal, machine = goal, goal.samples.machine
        lower, upper = machine.lower, machine.upper
        start = goal.start(goal.samples.design)
        own = start[goal.size :]
        names = (*machine.design_names, *(f"{'most' if side > 0 else 'least'} {m}" for m, side in goal.variables))
        self.box = Box(
            names,
            np.concatenate([lower, own - REACH * goal.unit]),
            np.concatenate([upper, own + REACH * goal.unit]),
            start,
            np.concatenate([lower, own]),
            np.concatenate([upper - lower, goal.unit]),
        )
        limits = Limits(goal) if goal.variables or goal.holds else None
        objective = Smooth(goal, len(start), max(abs(goal.value(start)), float(goal.unit.sum()), np.finfo(float).tiny))
        self.problem = Problem(objective, self.box, limits)

    def point(self, x: Array) -> Array:
        """The point u of a design x (p,), the measures' variables as tight as they can be."""
        return self.box.inside((self.goal.start(x) - self.box.origin) / self.box.unit)

    def snapped(self, u: Array) -> Array:
        """The design (p,) at a point, on the bounds that it lies beside where nothing is lost by that."""
        for margin in (SNAP, 0.0):
            x = self.x(self.box.snapped(u, margin))
            tight = self.point(x)
            if self.problem.kept(tight):
                return x
        return self.x(u)

    def x(self, u: Array) -> Array:
        """The design (p,) at a point."""
        return self.problem.design(u)[: self.goal.size]


def _starts(file: MechanismFile, count: int, seed: int) -> list[Array]:
    """The file's own design, taken into the bounds, then a Latin hypercube in them."""
    factors = np.array([units.factor(key) for key in file.bounds])
    lower, upper = np.array(list(file.bounds.values())).T * factors
    own = np.clip([file.si(f"values.{key}") for key in file.bounds], lower, upper)
    cube = qmc.LatinHypercube(len(own), seed=np.random.default_rng(seed)).random(max(count - 1, 0))
    return [own, *(lower + cube * (upper - lower))]


def _minima(programme: _Programme, designs: Sequence[Array], listener: Listener | None) -> list[Minimum]:
    """Where the starts end whose loops close; raises ComputationError where none do."""
    phase, found, last = Phase("ipopt", "start", len(designs), listener), [], ""
    for count, x in enumerate(designs, 1):
        try:
            found.append(descend(programme.problem, nearer(programme.problem, programme.point(x)), MOST_ITERATIONS))
        except ComputationError as error:
            last = error.message
        phase.reached(count, best=programme.problem.least)
    if not found:
        raise ComputationError(f"no start leads anywhere: {last}")
    return found


def _hopeless(programme: _Programme, minima: Sequence[Minimum]) -> str:
    """Which limit the best of the points breaks most."""
    best, constraints = min(minima, key=lambda one: one.violation), programme.problem.constraints
    assert constraints is not None
    excess = constraints.excess(programme.problem.design(best.u))
    kind, goal = constraints.kinds[int(np.argmax(excess))], programme.goal
    hold = next((h for h in goal.holds if str(h) == kind.name), None)
    reached = "" if hold is None else f": the best design found reaches {goal.met(programme.x(best.u), hold):.6g}"
    return f"no design within the bounds keeps {kind.name}{reached}"


def _peaks(programme: _Programme, x: Array) -> Array:
    """Angles between samples where a measure's quantity passes its extremes at the samples."""
    goal = programme.goal
    angles = goal.samples.angles
    fine = 2 * np.pi * np.arange(FINE * len(angles)) / (FINE * len(angles))
    between = Samples(goal.samples.machine, goal.names, fine)(x).values
    at = goal.samples(x).values
    found: list[float] = []
    for measure in {m.name: m for m in (*(m for m, _ in goal.variables), *(h.measure for h in goal.holds))}.values():
        output = goal.output(measure)
        slack = PEAK * max(float(np.ptp(at[output])), np.finfo(float).tiny)
        top, bottom = int(np.argmax(between[output])), int(np.argmin(between[output]))
        if between[output, top] > at[output].max() + slack:
            found.append(float(fine[top]))
        if between[output, bottom] < at[output].min() - slack:
            found.append(float(fine[bottom]))
    return np.array(found)


def _found(
    file: MechanismFile, least: str, programme: _Programme, best: Minimum, first: Certificate, seconds: float
) -> Found:
    goal, x = programme.goal, programme.snapped(best.u)
    proof = certified(programme.problem, best.u, [best])
    design = {key: float(v / units.factor(key)) for key, v in zip(file.bounds, x, strict=True)}
    result = Optimum(
        machine=file.name,
        least=least,
        objective=goal.true(x),
        start_objective=goal.true(goal.samples.design),
        design=design,
        start_design={key: file.values[key] for key in file.bounds},
        holds=[
            Held(str(h), goal.met(x, h), h.limit, any(one.name == str(h) for one in proof.active_constraints))
            for h in goal.holds
        ],
        certificate=Proof(
            kkt_residual=proof.kkt_residual,
            active_bounds=[f"{one.name} {one.side}" for one in proof.active_bounds],
            starts=first.starts,
            agreeing_starts=first.agreeing_starts,
            spread=first.spread,
        ),
        samples=len(goal.samples.angles),
        seconds=seconds,
    )
    return Found(x, file.moved_to(design), result)
