"""`planter optimise --prove`: a bound on how much better any design within the bounds can be than the best known one.

The support force is enclosed over boxes of designs by generated array code. The enclosed objective is that of the
search: of true extremes and integrals, or of samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import chain, pairwise
from types import ModuleType
from typing import Any

import numpy as np

from planter.engine.proof import ProvableObjective
from planter.gear_geometry.stage import Stage
from planter.kernels import Array, generated
from planter.optimise.proof.enclosures import JetNamespace
from planter.optimise.proof.intervals import Ball
from planter.optimise.proof.jets import Jet, Space
from planter.optimise.proof.panels import MovingKinks
from planter.optimise.proof.programs import StraightLine
from planter.optimise.proof.roots import enclose_roots
from planter.optimise.proof.search import SECONDS, Incumbent, prove_bound, share_boxes
from planter.optimise.response import find_breakpoints
from planter.parallel.task import AUTO, Means
from planter.planting.file import PlantingMachine
from planter.planting.functions import Model
from planter.planting.model import Device, build_measures
from planter.planting.optimisation import Optimisation
from planter.progress import Listener

FLANK = "4-5-6-7 polynomial"
"""The law that the support force alone was derived with."""
REMEMBERED = 64
"""Boxes of a stage's parameters for which what it hoists is kept."""


class EnclosedForce:
    """The vertical force on the support over boxes of designs, from generated array code. Implements `Enclosed`."""

    offsets = (Fraction(0), Fraction(-1, 2))
    period = Fraction(1, 2)
    is_continuous = True

    def __init__(self, device: Device) -> None:
        if device.machine.cam.flank != FLANK:
            raise device.machine.input_error("cam.flank", f"a proof is for {FLANK} flanks alone")
        name = f"planting_support_{device.model}"
        self.device, self.sidecar = device, generated.sidecar(name)
        self._module = generated.module(f"array.{name}")
        effects = self.sidecar["effects"]
        self._insensitive = set(effects["without"])
        self._gears = [StageEnclosure(*pair) for pair in zip(device.stages, effects["felt"].values(), strict=True)]
        self.code, self._prologue = StraightLine(self._evaluate), StraightLine(self._evaluate_prologue)
        self._sizes: list[int] = []
        counts = [len(stage.names) for stage in device.stages]
        self._parts = np.cumsum([0, device.size - sum(counts), *counts]).tolist()

    def prepare(self, space: Space, phi: Jet) -> list[Jet]:
        """Return angles phi (lanes,) [rad], then what the code of a lane takes besides, over a box."""
        x = space.parameters()[: self.device.size]
        mounting, *parameters = (x[a:b] for a, b in pairwise(self._parts))
        constants = [space.constant(Ball.exact([value])) for value in self.device.constants]
        groups: list[Sequence[Jet]] = [mounting, constants]
        for gear, jets in zip(self._gears, parameters, strict=True):
            curve = gear.enclose(space, jets)
            groups += [jets, curve.outputs, curve.parameters, curve.hoisted]
        self._sizes = [len(group) for group in groups]
        fixed = [jet for group in groups for jet in group]
        return [phi, *fixed, *self._prologue.enclose_smooth(space, fixed)]

    def _split(self, inputs: Sequence[Any]) -> tuple[list[Any], list[Any], Sequence[Any]]:
        """Return the arguments of the generated code before the invariants, the stages, and the invariants."""
        ends = np.cumsum([0, *self._sizes]).tolist()
        mounting, constants, *curves = (inputs[a:b] for a, b in pairwise(ends))
        packed = [part for k in range(0, len(curves), 4) for part in curves[k : k + 2]]
        contacts = [partial(_touch, gear.module, *curves[4 * k + 2 : 4 * k + 4]) for k, gear in enumerate(self._gears)]
        return [mounting, *packed, constants], contacts, inputs[ends[-1] :]

    def _evaluate_prologue(self, xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        """Return what no angle changes."""
        arguments, contacts, _ = self._split(inputs)
        hoisted: Sequence[Any] = self._module.prologue(xp, *arguments, *contacts)
        return [xp.space.lift(value) for value in hoisted]

    def _evaluate(self, xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        """Return the force of a side from what `prepare` returns."""
        arguments, contacts, hoisted = self._split(inputs[1:])
        force: Sequence[Any] = self._module.lane(xp, inputs[0], *arguments, hoisted, *contacts)
        return force

    def find_kinks(self, x: Array) -> MovingKinks:
        """Return the kinks of the force at a design (p,)."""
        force = self.device.force
        points = find_breakpoints(force, force.prologue(x))
        return MovingKinks(points.folded, points.velocity, points.acceleration(np.arange(len(points.angles))))

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return False: every design of a box counts."""
        return False

    @property
    def without(self) -> tuple[str, ...]:
        """Design parameters that cannot change the force, as was proved when its code was generated.

        A stage does not depend on its length if it has a single length and similar curves give the same results.
        """
        vectors = self.device.sidecar["vectors"]
        mounting = [entry["shown"] for entry in vectors["mounting"] if entry["name"] in self._insensitive]
        distances = [vectors[f"hoisted{i}"]["known"]["0"]["name"] for i in (1, 2)]
        pairs = zip(self._gears, distances, strict=True)
        stages = (gear.without for gear, distance in pairs if distance in self._insensitive)
        return (*mounting, *chain.from_iterable(stages))


class StageEnclosure:
    """A stage over boxes of its parameters; what it hoists is remembered for some of them.

    If similar curves give the same results, the curve of unit size is enclosed: its first length is 1.
    """

    def __init__(self, stage: Stage, felt: Sequence[str]) -> None:
        self.stage, similar = stage, stage.sidecar["similar"]
        self.module: ModuleType = generated.module(f"array.curve_{stage.family}")
        order = [entry["name"] for entry in stage.sidecar["parameters"]]
        unchanged = set(felt) <= set(similar["unchanged"])
        self._lengths = [order.index(name) for name in similar["lengths"]] if unchanged else []
        self._known: dict[Any, list[Jet]] = {}
        module, terms = self.module, stage.terms
        self._distance = StraightLine(lambda xp, parameters: [module.prologue(xp, parameters, 0)[0]])
        self._radii = StraightLine(lambda xp, parameters: module.radii(xp, parameters, terms)[1])
        self._closure = StraightLine(lambda _, inputs: module.closure(inputs[0], inputs[1:])[1:])
        self._series = StraightLine(self._evaluate_series)

    @property
    def without(self) -> tuple[str, ...]:
        """The length of a curve that has no effect on the results."""
        return (self.stage.names[self._lengths[0]],) if len(self._lengths) == 1 else ()

    def enclose(self, space: Space, jets: Sequence[Jet]) -> PitchCurveEnclosure:
        """Return the stage with parameters `jets` in a box."""
        size, parameters = space.integer(1), list(jets)
        if self._lengths:
            size = jets[self._lengths[0]]
            for place in self._lengths:
                parameters[place] = space.integer(1) if place == self._lengths[0] else jets[place] / size
        distance, *series = self._find_invariants(space, jets, parameters)
        return PitchCurveEnclosure(parameters, [distance, *series], [distance * size, *series])

    def _find_invariants(self, space: Space, moved: Sequence[Jet], parameters: Sequence[Jet]) -> list[Jet]:
        """Centre distance and series of a curve with these parameters, which `moved` change."""
        box = tuple(float(part) for jet in moved for part in (*jet.value.mid[:, 0], *jet.value.rad[:, 0]))
        if box not in self._known:
            if len(self._known) == REMEMBERED:
                del self._known[next(iter(self._known))]
            self._known[box] = self._compute_invariants(space, parameters)
        return [replace(jet, space=space) for jet in self._known[box]]

    def _compute_invariants(self, space: Space, parameters: Sequence[Jet]) -> list[Jet]:
        if not self.stage.sidecar["series"]:
            return self._distance.enclose_smooth(space, parameters)
        radii = self._radii.enclose_smooth(space, parameters)
        middle = np.array([jet.value.mid[0, 0] for jet in parameters])
        start = self.stage.prologue(parameters=middle)["hoisted"][:1, :1]

        def residual(a: Sequence[Jet]) -> tuple[Sequence[Jet], Sequence[Sequence[Jet]]]:
            excess, slope = self._closure.enclose_smooth(space, [a[0], *radii])
            return [excess], [[slope]]

        (distance,) = enclose_roots(space, start, residual)
        return [distance, *self._series.enclose_smooth(space, [distance, *parameters])]

    def _evaluate_series(self, xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        distance, *parameters = inputs
        nodes, radii = self.module.radii(xp, parameters, self.stage.terms)
        ratios, _, _ = self.module.closure(distance, radii)
        series: Sequence[Any] = self.module.series(xp, ratios, nodes)
        return series


@dataclass(frozen=True)
class PitchCurveEnclosure:
    """A pitch curve with its conjugate over a box: parameters and invariants of its generated code, and its outputs."""

    parameters: Sequence[Jet]
    hoisted: Sequence[Jet]
    outputs: Sequence[Jet]


def _touch(module: ModuleType, parameters: Sequence[Any], hoisted: Sequence[Any], xp: Any, t: Any, *_: Any) -> Any:
    """Return the contact of a stage at an angle t, with derivatives."""
    options = {"sine_series": _sine_series} if len(hoisted) > 1 else {}
    return module.contact(xp, t, parameters, hoisted, **options)


def _sine_series(_xp: JetNamespace, u: Jet, b: Sequence[Jet]) -> Jet:
    """Sum over k of b[k] sin(k u) / k, term by term: enclosures would grow with each step of a recurrence."""
    terms = [b[k] / k * (u * k).sin() for k in range(1, len(b))]
    return sum(terms[1:], terms[0])


def add_proof(
    optimisation: Optimisation, seconds: float = SECONDS, progress: Listener | None = None, means: Means = AUTO
) -> Optimisation:
    """Return an optimum with the bound on the objective of every design, within a time [s].

    `means` says what bounds the boxes: a proof that ends before its time is up does not depend on it.
    """
    device, optimum = optimisation.devices[optimisation.result.model], optimisation.optimum
    count = None if optimum.sampling == "refined" else optimum.sampling
    build = partial(build_objective_enclosure, device.machine, device.model, count)
    bounding = build()
    scope = "no design of the box, requirements kept or not," if optimum.requirements else "no design of the box"
    design = device.named(optimum.design)
    incumbent = Incumbent(optimum.design, design, optimum.objective, count, scope)
    box = bounding.searched(optimum.design)
    with share_boxes(bounding, build, means) as shared:
        proof = prove_bound(shared, box, incumbent, seconds, progress)
    return replace(optimisation, result=replace(optimisation.result, proof=proof))


def build_objective_enclosure(machine: PlantingMachine, model: Model, count: int | None) -> ObjectiveEnclosure:
    """Return the objective of a machine over `count` samples, or the true one, as a proof bounds it."""
    return ObjectiveEnclosure(Device(machine, model), count)


class ObjectiveEnclosure(ProvableObjective):
    """Objective (31) of a device, bounded over boxes of designs [lower, upper] (p,)."""

    def __init__(self, device: Device, count: int | None) -> None:
        self.device, self.force = device, EnclosedForce(device)
        super().__init__(
            device.force.machine, build_measures(device.machine), count, lambda _: self.force,
            find_kinks=self.force.find_kinks,
        )  # fmt: skip

    def searched(self, design: Array) -> tuple[Array, Array]:
        """The device's box, parameters without effect held at their value in `design` (p,)."""
        insensitive = np.isin(self.device.names, self.force.without)
        return np.where(insensitive, design, self.device.lower), np.where(insensitive, design, self.device.upper)
