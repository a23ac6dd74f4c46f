"""`planter optimise --prove`: a bound on how much better any design within the bounds can be than the best known one.

The support force is enclosed over boxes of designs by generated array code. The enclosed objective is that of the
search: of true extremes and integrals, or of samples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from planter.numerics.arrays import Integers
from planter.optimise.proof.enclosures import JetNamespace
from planter.optimise.proof.intervals import Ball
from planter.optimise.proof.jets import Jet, Space
from planter.optimise.proof.panels import MovingKinks
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
        counts = [len(stage.names) for stage in device.stages]
        self._parts = np.cumsum([0, device.size - sum(counts), *counts]).tolist()

    def follow(self, space: Space, phi: Jet) -> Callable[[JetNamespace, Integers], Sequence[Jet]]:
        """Return the shares over a box as a function of lanes, of angles phi (lanes,) [rad]."""
        size = self.device.size
        return lambda xp, lanes: self._shares(
            xp, xp.space.parameters()[:size], replace(phi.taken(lanes), space=xp.space)
        )

    def find_kinks(self, x: Array) -> MovingKinks:
        """Return the kinks of the force at a design (p,)."""
        force = self.device.force
        points = find_breakpoints(force, force.prologue(x))
        return MovingKinks(points.folded, points.velocity, points.acceleration(np.arange(len(points.angles))))

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return False: every design of a box counts."""
        return False

    def _shares(self, xp: JetNamespace, x: Sequence[Jet], phi: Jet) -> Sequence[Jet]:
        mounting, *parameters = (x[a:b] for a, b in pairwise(self._parts))
        stages = [gear.meshing(xp, jets) for gear, jets in zip(self._gears, parameters, strict=True)]
        packed = [part for jets, stage in zip(parameters, stages, strict=True) for part in (jets, stage.outputs)]
        constants = [xp.space.constant(Ball.exact([value])) for value in self.device.constants]
        contacts = [stage.contact for stage in stages]
        hoisted = self._module.prologue(xp, mounting, *packed, constants, *contacts)
        force: Sequence[Jet] = self._module.lane(xp, phi, mounting, *packed, constants, hoisted, *contacts)
        return force

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
        self._module: ModuleType = generated.module(f"array.curve_{stage.family}")
        order = [entry["name"] for entry in stage.sidecar["parameters"]]
        unchanged = set(felt) <= set(similar["unchanged"])
        self._lengths = [order.index(name) for name in similar["lengths"]] if unchanged else []
        self._known: dict[Any, list[Jet]] = {}

    @property
    def without(self) -> tuple[str, ...]:
        """The length of a curve that has no effect on the results."""
        return (self.stage.names[self._lengths[0]],) if len(self._lengths) == 1 else ()

    def meshing(self, xp: JetNamespace, jets: Sequence[Jet]) -> PitchCurveEnclosure:
        """The stage with parameters `jets`, in the box of `xp`."""
        size, parameters = xp.space.integer(1), list(jets)
        if self._lengths:
            size = jets[self._lengths[0]]
            for place in self._lengths:
                parameters[place] = xp.space.integer(1) if place == self._lengths[0] else jets[place] / size
        distance, *series = self._hoisted(xp, jets, parameters)
        return PitchCurveEnclosure(self._module, parameters, [distance, *series], [distance * size, *series])

    def _hoisted(self, xp: JetNamespace, moved: Sequence[Jet], parameters: Sequence[Jet]) -> list[Jet]:
        """Centre distance and series of a curve with these parameters, which `moved` change."""
        box = tuple(float(part) for jet in moved for part in (*jet.value.mid[:, 0], *jet.value.rad[:, 0]))
        if box not in self._known:
            if len(self._known) == REMEMBERED:
                del self._known[next(iter(self._known))]
            self._known[box] = self._compute_invariants(xp, parameters)
        return [replace(jet, space=xp.space) for jet in self._known[box]]

    def _compute_invariants(self, xp: JetNamespace, parameters: Sequence[Jet]) -> list[Jet]:
        if not self.stage.sidecar["series"]:
            return [self._module.prologue(xp, parameters, 0)[0]]
        nodes, radii = self._module.radii(xp, parameters, self.stage.terms)
        middle = np.array([jet.value.mid[0, 0] for jet in parameters])
        start = self.stage.prologue(parameters=middle)["hoisted"][:1, :1]

        def residual(a: Sequence[Jet]) -> tuple[Sequence[Jet], Sequence[Sequence[Jet]]]:
            _, excess, slope = self._module.closure(a[0], radii)
            return [excess], [[slope]]

        (distance,) = enclose_roots(xp.space, start, residual)
        ratios, _, _ = self._module.closure(distance, radii)
        return [distance, *self._module.series(xp, ratios, nodes)]


@dataclass(frozen=True)
class PitchCurveEnclosure:
    """A pitch curve with its conjugate over a box: the invariants of its generated code, and the inputs of a lane."""

    module: ModuleType
    parameters: Sequence[Jet]
    hoisted: Sequence[Jet]
    outputs: Sequence[Jet]

    def contact(self, xp: JetNamespace, t: Jet, _parameters: Any, _outputs: Any) -> tuple[Jet, ...]:
        """Return the contact of the stage at an angle t, with derivatives."""
        options = {"sine_series": _sine_series} if len(self.hoisted) > 1 else {}
        contact: tuple[Jet, ...] = self.module.contact(xp, t, self.parameters, self.hoisted, **options)
        return contact


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
