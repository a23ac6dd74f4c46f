"""`planter optimise --prove` for user-defined mechanisms: a bound on the objective of every design.

The bounded objective is that of the search: of true extremes and integrals, or of samples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from planter.engine.goal import Goal
from planter.engine.loops import TURN, KinematicLoops
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.engine.nodes import SCANNED
from planter.engine.proof import ProvableObjective, check_provable
from planter.engine.response import Switchings
from planter.engine.search import SearchSpec
from planter.errors import ComputationError
from planter.kernels import Array, generated
from planter.kernels.formulas import HOISTED, Formulas
from planter.kernels.generated import extract_outputs, find_periodic
from planter.mechanism.file import MechanismFile
from planter.mechanism.machines import build_machine
from planter.mechanism.optimisation import MechanismOptimum, StatedGoal
from planter.numerics.arrays import Integers
from planter.optimise.constraints import FEASIBILITY_TOLERANCE
from planter.optimise.proof.enclosures import JetNamespace
from planter.optimise.proof.intervals import Ball, Branches, Unbounded
from planter.optimise.proof.jets import ANYWHERE, CENTRE, Jet, Space
from planter.optimise.proof.panels import MovingKinks
from planter.optimise.proof.programs import RecordingNamespace, StraightLine, UnrecordedError
from planter.optimise.proof.roots import enclose_roots, has_rootless_lane, solve_linear_jets
from planter.optimise.proof.search import SECONDS, Incumbent, prove_bound, share_boxes
from planter.parallel.task import AUTO, Means
from planter.progress import Listener


def require_provable(goal: StatedGoal, option: str | None) -> None:
    """Raise InputError for an objective that cannot be bounded; `option` is that of the call, if it has one."""
    machine = goal.machine
    check_provable(machine, goal.objective, "--least" if option is not None else f"{machine.source}: objective.least")


def with_proof(
    file: MechanismFile, optimum: MechanismOptimum, goal: StatedGoal, spec: SearchSpec, seconds: float = SECONDS,
    listener: Listener | None = None, means: Means = AUTO,
) -> MechanismOptimum:  # fmt: skip
    """Return an optimum of a file with the bound on the objective of every design, within a time [s].

    `means` are the processes that bound the boxes: a proof that ends in time does not depend on them.
    """
    machine = goal.machine
    count = None if spec.sampling == "refined" else spec.sampling
    steps = Goal(machine, (), goal.limits, count or file.turn.samples, with_events=False)
    limits = [  # as the search takes them, to its tolerance
        replace(limit, number=limit.number + limit.sign * FEASIBILITY_TOLERANCE * steps.step(limit))
        for limit in goal.limits
    ]
    build = partial(build_objective, file, machine.searched, goal.objective, limits, count)
    bounding = build()
    design = {key: float(value) for key, value in zip(machine.design_names, optimum.x / machine.scale, strict=True)}
    incumbent = Incumbent(optimum.x, design, optimum.result.objective, count, _describe_scope(goal, bounding))
    box = (machine.lower, machine.upper)
    with share_boxes(bounding, build, means) as shared:
        proof = prove_bound(shared, box, incumbent, seconds, listener)
    return replace(optimum, result=replace(optimum.result, proof=proof))


def build_objective(
    file: MechanismFile, searched: Mapping[str, Any], terms: Sequence[Measure], limits: Sequence[Limit],
    count: int | None,
) -> ProvableObjective:  # fmt: skip
    """Return a sum of measures, over `count` samples or true, as a proof bounds it, in the values that are searched."""
    machine = replace(build_machine(file), **searched)
    switchings = Switchings(machine, max(machine.samples, SCANNED))

    def enclose(quantities: Sequence[tuple[str, bool]]) -> EnclosedMechanism:
        return EnclosedMechanism(machine, file.model, quantities)

    def find_kinks(x: Array) -> MovingKinks:
        return _find_kinks(switchings, x)

    return ProvableObjective(machine, terms, count, enclose, limits, find_kinks)


def _find_kinks(switchings: Switchings, x: Array) -> MovingKinks:
    """Return the switching points at a design (p,), none if its loops do not close; how they bend is not known."""
    none, point = MovingKinks.none(len(x)), switchings.response.at(x)
    try:
        angles, rows = switchings.find(point)
    except ComputationError:
        return none
    if not len(angles):
        return none
    slopes = switchings.response.slopes(point, angles)[1][rows, np.arange(len(rows))]
    return MovingKinks(angles, -slopes[:, 1:] / slopes[:, :1], np.zeros((len(angles), len(x), len(x))))


def _describe_scope(goal: StatedGoal, bounding: ProvableObjective) -> str:
    """Return in words for which designs the bound is."""
    conditions = ["closes its loops"] if goal.machine.loops else []
    if bounding.limits:
        conditions.append(f"satisfies the limits{'' if bounding.heeds_all else ' at fixed angles'}")
    return f"no design of the box that {' and '.join(conditions)}" if conditions else "no design of the box"


FARTHEST = 1e3
"""Largest size of a coordinate at which an assembly is looked for [m or rad]."""
WALKED = 72
"""Steps of a cycle between which coordinates of loops are found from near ones."""
MOST_TURNS = 1000
"""Largest number of turns of a cycle."""
MOST_NEWTON_STEPS = 9
"""Newton steps of generated code have numbers of one digit."""


class EnclosedMechanism:
    """Quantities of a mechanism by name, or their sizes, over boxes of designs x (p,). Implements `Enclosed`.

    Coordinates of loops are roots of the gaps, near those of the design at the centre of a box. They vanish there, and
    so do the Newton steps of the generated lane, whose derivatives those of the roots have already.
    """

    offsets = (Fraction(0),)

    def __init__(self, machine: Machine, formulas: Formulas, quantities: Sequence[tuple[str, bool]]) -> None:
        self.machine = machine
        self.period = Fraction(machine.turn / TURN).limit_denominator(MOST_TURNS)
        orders = [kind.get("order", 0) for kind in machine.event_kinds]
        units = {machine.find_quantity(name).unit for name, _ in quantities}
        self.is_continuous = bool(orders) and min(orders) > 0 and "rad" not in units  # an angle may lose a turn
        self.sizes = tuple(is_size for _, is_size in quantities)
        self._unclosed = set[bytes]()  # centres of the boxes that were enclosed last at which loops do not close
        self._module = module = generated.module(f"array.{formulas.name}", formulas.folder)
        names = formulas.outputs("lane")
        self._inputs: list[str] = formulas.sidecar["functions"]["lane"]["inputs"]
        self._prologue: dict[str, Any] = formulas.sidecar["functions"].get("prologue", {})
        loops = machine.loops.names if machine.loops else ()
        steps = {f"{name}_step{k}": 0 for name in loops for k in range(1, MOST_NEWTON_STEPS + 1)}
        outputs = [names.index(name) for name, _ in quantities]
        self.code, self._closure = StraightLine(self._evaluate), StraightLine(self._evaluate_closure)
        self._lane = extract_outputs(module, "lane", outputs, {**steps, "solved": _solve})

    def prepare(self, space: Space, phi: Jet) -> list[Jet]:
        """Return angles phi (lanes,) [rad], all values, and coordinates of loops over a box.

        Raises Unbounded where loops do not close at the centre of the box, or may not close within it.
        """
        return [phi, *self._data(space), *(replace(jet, space=space) for jet in self._enclose_loops(space, phi))]

    def _evaluate(self, xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        """Return the quantities from what `prepare` returns."""
        phi, *rest = inputs
        count = len(self.machine.data)
        values = {self._inputs[0]: phi, "data": rest[:count], "loops": rest[count:]}
        if HOISTED in self._inputs:
            values[HOISTED] = self._module.prologue(xp, *(values[name] for name in self._prologue["inputs"]))
        rows = self._lane(xp, *(values[name] for name in self._inputs))
        lifted = [xp.space.lift(row) for row in rows]
        return [xp.absolute(row) if is_size else row for row, is_size in zip(lifted, self.sizes, strict=True)]

    def _evaluate_closure(self, xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        """Return the gaps of loops and their Jacobian from an angle, all values and coordinates."""
        count = 1 + len(self.machine.data)
        return [xp.space.lift(row) for row in self._module.closure(xp, inputs[0], inputs[1:count], inputs[count:])]

    def _data(self, space: Space) -> list[Jet]:
        """Return all values (v,) over a box, those that do not move as constants."""
        data = [space.constant(Ball.exact([value])) for value in self.machine.data]
        for index, jet in zip(self.machine.moved, space.parameters()[: len(self.machine.moved)], strict=True):
            data[index] = jet
        return data

    def _enclose_loops(self, space: Space, phi: Jet) -> list[Jet]:
        """Return the coordinates of loops (c,) over a box, in lanes."""
        loops = self.machine.loops
        if loops is None:
            return []
        start = self._find_coordinates(loops, space, phi.value.mid[CENTRE])
        if np.isnan(start).all():
            raise Unbounded("loops do not close at the centre of a box")
        smooth = space.asking(Branches.none(1))  # `at_points` must not change the space of the caller
        angles, data = replace(phi, space=smooth), self._data(smooth)

        def residual(q: Sequence[Jet]) -> tuple[Sequence[Jet], Sequence[Sequence[Jet]]]:
            rows = self._closure.enclose_smooth(smooth, [angles, *data, *q])
            size = loops.size
            return rows[:size], [rows[k : k + size] for k in range(size, size + size * size, size)]

        return enclose_roots(smooth, start, residual)

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return whether loops close at no design of a box [lower, upper] (p,) at one of the angles phi (n,) [rad].

        It is checked only where they do not close at the centre, which `follow` has found before.
        Angles in sine and cosine alone are searched within a turn, other coordinates up to `FARTHEST`.
        """
        loops = self.machine.loops
        if loops is None or Space(lower, upper).centre.tobytes() not in self._unclosed:
            return False
        space, size = Space(lower, lower), loops.size
        data = [space.constant(Ball.exact([value])) for value in self.machine.data]
        for index, low, high in zip(self.machine.moved, lower, upper, strict=True):
            data[index] = space.constant(Ball.between(np.array([low]), np.array([high])))

        def enclose_gaps(q: Sequence[Ball], lanes: Integers) -> tuple[Sequence[Ball], Sequence[Sequence[Ball]]]:
            coordinates = [space.constant(ball) for ball in q]
            closure = self._module.closure(JetNamespace(space), space.constant(phi[lanes]), data, coordinates)
            rows = [space.lift(row).value[ANYWHERE] for row in closure]
            return rows[:size], [rows[k : k + size] for k in range(size, size + size * size, size)]

        periodic = find_periodic(self._module, "closure", "loops", size)
        limit = np.where(periodic, np.pi * (1 + 1e-9), FARTHEST)
        return has_rootless_lane(enclose_gaps, -limit, limit, len(phi.mid))

    def _find_coordinates(self, loops: KinematicLoops, space: Space, phi: Array) -> Array:
        """Return coordinates (c, lanes) at the centres of boxes, NaN where a walk from 0 on along closed loops ends."""
        designs = space.centre[: len(self.machine.moved)]
        centres, boxes = np.unique(designs.reshape(len(designs), -1), axis=1, return_inverse=True)
        d, boxes = (
            np.array([self.machine.build_data(x) for x in centres.T]).T,
            np.broadcast_to(boxes.ravel(), phi.shape),
        )
        phi = np.mod(phi, self.machine.turn)
        grid = np.linspace(0, self.machine.turn, WALKED + 1)
        walk = loops.walk(d, grid)
        _, returned = walk.gains()
        self._unclosed = {x.tobytes() for x in centres.T[~returned]}
        start = np.minimum((phi / grid[1]).astype(int), WALKED - 1)
        share = phi / grid[1] - start
        guess = (1 - share) * walk.places[:, start, boxes] + share * walk.places[:, start + 1, boxes]
        coordinates, determinant, closed = loops.close(phi, d[:, boxes], guess)
        _, sense, _ = loops.close(np.zeros(len(boxes)), d[:, boxes], walk.first[:, boxes])
        if (returned[boxes] & closed & (determinant * sense > 0)).all():
            return coordinates
        angles, places = np.unique(phi, return_inverse=True)
        walk = loops.walk(d, np.append(angles, self.machine.turn))
        reached = np.where(returned, np.inf, np.where(walk.assembled & ~walk.alive, walk.reached, -1.0))
        return np.where(phi <= reached[boxes], walk.places[:, places, boxes], np.nan)


def _solve(xp: JetNamespace, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> tuple[Any, ...]:
    """Return the unknowns of simultaneous equations, and None for the pivot, of which no result is made."""
    if isinstance(xp, RecordingNamespace):
        raise UnrecordedError("simultaneous equations are solved with the numbers of each lane")
    return (*solve_linear_jets(xp.space, matrix, right), None)
