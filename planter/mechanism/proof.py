"""`planter optimise --prove` for user-defined mechanisms: a bound on the objective of every design.

The bounded objective is that of the search: of true extremes and integrals, or of samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from planter.engine.curves import QuantityCurves
from planter.engine.goal import Goal
from planter.engine.loops import TURN
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.engine.proof.certificate_file import (
    ProvedMachine,
    find_changes,
    write_certificate,
)
from planter.engine.proof.continuation import AssemblyStart
from planter.engine.proof.enclosures import Kinks, ResponseProgram, ResponseRecorder
from planter.engine.proof.objective import (
    ProvableObjective,
    ProvedQuantity,
    build_bare_objective,
    build_provable_objective,
    check_provable,
    is_fixed,
)
from planter.engine.proof.search import SECONDS, Incumbent
from planter.engine.search import SearchSpec
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.response import find_breakpoints
from planter.errors import ComputationError, InputError
from planter.kernels import Array, generated
from planter.kernels.formulas import HOISTED, Formulas
from planter.kernels.generated import extract_outputs, find_periodic
from planter.mechanism.file import MechanismFile, load
from planter.mechanism.machines import build_machine
from planter.mechanism.optimisation import MechanismOptimum, StatedGoal
from planter.progress import Listener
from planter.task import AUTO, Means


def require_provable(goal: StatedGoal, option: str | None) -> None:
    """Raise InputError for an objective that cannot be bounded; `option` is that of the call, if it
    has one.
    """
    machine = goal.machine
    label = f"{machine.source}: objective.least" if option is None else "--least"
    check_provable(machine, goal.objective, label)


def with_proof(
    file: MechanismFile,
    optimum: MechanismOptimum,
    goal: StatedGoal,
    spec: SearchSpec,
    seconds: float = SECONDS,
    listener: Listener | None = None,
    means: Means = AUTO,
    earlier: Path | None = None,
    keep: Callable[[str], None] | None = None,
) -> MechanismOptimum:
    """Return an optimum of a file with the bound on the objective of every design, within a CPU
    time [s].

    `means` are the processes that bound the boxes: a proof that ends in time does not depend on
    them. A proof of the same in the file `earlier` is continued; the text of an interrupted one is
    handed to `keep`.
    """
    machine = goal.machine
    count = None if spec.sampling == "refined" else spec.sampling
    steps = Goal(machine, (), goal.limits)
    limits = [  # as the search takes them, to its tolerance
        replace(limit, number=limit.number + limit.sign * FEASIBILITY_TOLERANCE * steps.step(limit))
        for limit in goal.limits
    ]
    searched = machine.searched
    build = partial(build_objective, file, searched, goal.objective, limits, count, optimum.x)
    pairs = zip(machine.design_names, optimum.x / machine.scale, strict=True)
    design = {key: float(value) for key, value in pairs}
    incumbent = Incumbent(optimum.x, design, optimum.result.objective, count, _describe_scope(goal))
    box, proved = (machine.lower, machine.upper), describe_machine(file, machine)
    proof, text = write_certificate(
        build, box, incumbent, proved, seconds, listener, means, earlier, keep
    )
    return replace(optimum, result=replace(optimum.result, proof=proof.result), certificate=text)


def describe_machine(file: MechanismFile, machine: Machine) -> ProvedMachine:
    """Return what a proof of a mechanism states of it."""
    numbers = {path: x for path, x in file.numbers().items() if path.startswith("values.")}
    sources = EnclosedMechanism(machine, file.model).list_sources()
    scales, changes = machine.scale.tolist(), find_changes(numbers, file.source, load)
    inputs = {"data": [float(x).hex() for x in machine.data], "moved": list(machine.moved)}
    return ProvedMachine(machine.design_names, scales, sources, file.source, changes, inputs=inputs)


def rebuild_objective(source: str, document: Mapping[str, Any]) -> ProvableObjective:
    """Return the objective of a mechanism for the parameters and quantities of a proof, without
    terms. Raises InputError if the file has others.
    """
    stated = document["machine"]
    file = load(source, stated["changes"])
    machine = build_machine(file)
    keys = replace(machine, moved=tuple(range(len(machine.values)))).design_names
    if unknown := set(document["parameters"]) - set(keys):
        raise InputError(f"{source}: it has no {', '.join(sorted(unknown))}")
    moved = tuple(keys.index(name) for name in document["parameters"])
    lower, upper = (np.array([float.fromhex(x) for x in side]) for side in document["box"])
    machine = replace(machine, moved=moved, lower=lower, upper=upper)
    quantities = list(map(ProvedQuantity.from_document, stated["quantities"]))
    return build_bare_objective(
        machine, EnclosedMechanism(machine, file.model), quantities, document
    )


def build_objective(
    file: MechanismFile,
    searched: Mapping[str, Any],
    terms: Sequence[Measure],
    limits: Sequence[Limit],
    count: int | None,
    origin: Array | None = None,
) -> ProvableObjective:
    """Return a sum of measures, over `count` samples or true, as a proof bounds it, in the values
    that are searched, with the assembly of the design `origin`.
    """
    machine = replace(build_machine(file), **searched)
    enclosed = EnclosedMechanism(machine, file.model)
    return build_provable_objective(machine, terms, count, enclosed, limits, origin)


def _describe_scope(goal: StatedGoal) -> str:
    """Return in words for which designs the bound is."""
    conditions = ["closes its loops"] if goal.machine.loops else []
    heeded = [is_fixed(goal.machine, limit.measure) for limit in goal.limits]
    if any(heeded):
        conditions.append(f"satisfies the limits{'' if all(heeded) else ' at fixed angles'}")
    return f"no design of the box{' that ' * bool(conditions)}{' and '.join(conditions)}"


FARTHEST = 1e3
"""Largest size of a coordinate at which an assembly is looked for [m or rad]."""
MOST_TURNS = 1000
"""Largest number of turns of a cycle."""
MOST_NEWTON_STEPS = 9
"""Newton steps of generated code have numbers of one digit."""


class EnclosedMechanism:
    """Quantities of a mechanism, from generated array code, over boxes of designs x (p,).

    Coordinates of loops are roots of the gaps, near those of the design at the centre of a box.
    They vanish there, and so do the Newton steps of the generated lane, whose derivatives those of
    the roots have already.
    """

    def __init__(self, machine: Machine, formulas: Formulas) -> None:
        self.machine, self._formulas = machine, formulas
        self._module = generated.module(f"array.{formulas.name}", formulas.folder)

    def record(self, quantities: Sequence[ProvedQuantity]) -> ResponseProgram:
        """Return the code of quantities, with all values but those of the design as numbers."""
        machine, module, functions = self.machine, self._module, self._formulas.sidecar["functions"]
        recorder, size = ResponseRecorder(len(machine.design)), len(machine.moved)
        x, loops, hoisted = list(range(size)), list[int](), list[int]()

        def fill(values: Sequence[Any]) -> list[Any]:
            """Return all values of the machine, from those of the design."""
            data: list[Any] = [float(value) for value in machine.data]
            for index, value in zip(machine.moved, values, strict=True):
                data[index] = value
            return data

        if machine.loops:
            count = machine.loops.size
            periodic = find_periodic(module, "closure", "loops", count)
            limits = np.where(periodic, np.pi * (1 + 1e-9), FARTHEST)

            def close(xp: Any, q: Sequence[Any]) -> Sequence[Any]:
                closure: Sequence[Any] = module.closure(
                    xp, q[count], fill(q[count + 1 :]), q[:count]
                )
                return closure

            loops = recorder.call(close, [recorder.phi, *x], limits.tolist())
        if HOISTED in functions["lane"]["inputs"]:
            names = functions["prologue"]["inputs"]

            def evaluate_prologue(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
                values: Sequence[Any] = module.prologue(
                    xp, *({"data": fill(inputs)}[name] for name in names)
                )
                return values

            hoisted = recorder.call(evaluate_prologue, x)
        phi_name, *_ = functions["lane"]["inputs"]
        steps = {
            f"{name}_step{k}": 0
            for name in (machine.loops.names if machine.loops else ())
            for k in range(1, MOST_NEWTON_STEPS + 1)
        }
        outputs = self._formulas.outputs("lane")
        lane = extract_outputs(
            module,
            "lane",
            [outputs.index(quantity.name) for quantity in quantities],
            {**steps, "solved": _solve},
        )

        def evaluate(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
            design, rest = inputs[1 : size + 1], inputs[size + 1 :]
            values = {
                phi_name: inputs[0],
                "data": fill(design),
                "loops": rest[: len(loops)],
                HOISTED: rest[len(loops) :],
            }
            rows = lane(xp, *(values[name] for name in functions["lane"]["inputs"]))
            return [
                q.convert(machine, xp, row, design) for q, row in zip(quantities, rows, strict=True)
            ]

        recorder.call(evaluate, [recorder.phi, *x, *loops, *hoisted])
        period = Fraction(machine.turn / TURN).limit_denominator(MOST_TURNS)
        orders = [kind.get("order", 0) for kind in machine.event_kinds]
        units = {machine.find_quantity(quantity.name).unit for quantity in quantities}
        is_continuous = (
            bool(orders) and min(orders) > 0 and "rad" not in units
        )  # an angle may lose a turn
        return ResponseProgram(
            recorder.parameters, tuple(recorder.stages), (Fraction(0),), period, is_continuous
        )

    def list_sources(self) -> dict[str, str]:
        """Return the hash of the generated module by its name."""
        return generated.hash_modules([self._module])

    def find_assembly(self, x: Array) -> AssemblyStart:
        """Return the coordinates of loops at a design (p,), as a walk begins with them."""
        loops = self.machine.loops
        if loops is None:
            return AssemblyStart(x)
        data = np.array([self.machine.build_data(x[: len(self.machine.moved)])]).T
        return AssemblyStart(x, [loops.walk(data, np.empty(0)).first[:, 0].tolist()])

    def find_kinks(self, x: Array) -> Kinks:
        """Return the breakpoints of the first side at a design (p,), none if its loops do not
        close; how they bend is not known.
        """
        curves, size = self._curves, len(x)
        try:
            points = find_breakpoints(curves, curves.prologue(x))
        except ComputationError:
            return np.empty(0), np.empty((0, size)), np.empty((0, size, size))
        chosen = ~points.is_touch & (points.sides == 0)
        angles, velocity = points.angles[chosen], points.velocity[chosen]
        return angles, velocity, np.zeros((len(angles), size, size))

    @cached_property
    def _curves(self) -> QuantityCurves:
        return QuantityCurves(self.machine, ())


def _solve(xp: Any, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> tuple[Any, ...]:
    """Return the unknowns of simultaneous equations, and None for the pivot, of which no result is
    made.
    """
    return (*xp.solve(matrix, right), None)
