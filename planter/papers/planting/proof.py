"""`planter optimise --prove`: a bound on how much better any design within the bounds can be than
the best known one.

The support force is enclosed over boxes of designs by generated array code. The enclosed objective
is that of the search: of true extremes and integrals, or of samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import chain, pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

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
)
from planter.engine.proof.search import SECONDS, Incumbent
from planter.engine.solvers.response import find_breakpoints
from planter.errors import InputError
from planter.gears.geometry.stage import Stage
from planter.kernels import Array, generated
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device, build_measures
from planter.papers.planting.optimisation import Optimisation
from planter.progress import Listener
from planter.task import AUTO, Means

FLANK = "4-5-6-7 polynomial"
"""The law that the support force alone was derived with."""


class EnclosedForce:
    """The vertical force on the support of a device over boxes of designs, from generated array
    code.
    """

    def __init__(self, device: Device) -> None:
        if device.machine.cam.flank != FLANK:
            raise device.machine.input_error("cam.flank", f"a proof is for {FLANK} flanks alone")
        name = f"planting_support_{device.model}"
        self.device, self.sidecar = device, generated.sidecar(name)
        self._module = generated.module(f"array.{name}")
        effects = self.sidecar["effects"]
        self._insensitive = set(effects["without"])
        self._gears = [
            GearCode.of_stage(*pair)
            for pair in zip(device.stages, effects["felt"].values(), strict=True)
        ]
        counts = [len(stage.names) for stage in device.stages]
        self._ends = np.cumsum([0, device.size - sum(counts), *counts]).tolist()

    def record(self, quantities: Sequence[ProvedQuantity]) -> ResponseProgram:
        """Return the code of the force, as each of some quantities of both sides."""
        recorder = ResponseRecorder(self.device.size)
        mounting, *parameters = (range(a, b) for a, b in pairwise(self._ends))
        groups: list[Sequence[int]] = [mounting]
        for gear, places in zip(self._gears, parameters, strict=True):
            groups += gear.record(recorder, list(places))
        fixed, ends = list(chain(*groups)), np.cumsum([0, *map(len, groups)]).tolist()

        def split(inputs: Sequence[Any]) -> tuple[list[Any], list[Any]]:
            """Return the arguments of the generated code before the invariants, and the stages."""
            first, *curves = (inputs[a:b] for a, b in pairwise(ends))
            packed = [part for k in range(0, len(curves), 4) for part in curves[k : k + 2]]
            contacts = [
                partial(_touch, gear.module, *curves[4 * k + 2 : 4 * k + 4])
                for k, gear in enumerate(self._gears)
            ]
            return [first, *packed, [float(value) for value in self.device.constants]], contacts

        def evaluate_prologue(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
            arguments, contacts = split(inputs)
            hoisted: Sequence[Any] = self._module.prologue(xp, *arguments, *contacts)
            return hoisted

        def evaluate(xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
            arguments, contacts = split(inputs[1:])
            (force,) = self._module.lane(
                xp, inputs[0], *arguments, inputs[1 + len(fixed) :], *contacts
            )
            machine = self.device.force.machine
            return [quantity.convert(machine, xp, force, ()) for quantity in quantities]

        hoisted = recorder.call(evaluate_prologue, fixed)
        recorder.call(evaluate, [recorder.phi, *fixed, *hoisted])
        offsets = (Fraction(0), Fraction(-1, 2))
        return ResponseProgram(
            self.device.size, tuple(recorder.stages), offsets, Fraction(1, 2), is_continuous=True
        )

    def list_sources(self) -> dict[str, str]:
        """Return the hashes of the generated modules by name."""
        return generated.hash_modules([self._module, *(gear.module for gear in self._gears)])

    def find_assembly(self, x: Array) -> AssemblyStart:
        """Return the centre distances of gear stages without closed form at a design (p,)."""
        _, *parameters = (x[a:b] for a, b in pairwise(self._ends))
        pairs = zip(self._gears, parameters, strict=True)
        distances = [gear.find_distance(part) for gear, part in pairs if gear.has_series]
        return AssemblyStart(x, [distance.ravel().tolist() for distance in distances])

    def find_kinks(self, x: Array) -> Kinks:
        """Return the kinks of the force at a design (p,)."""
        force = self.device.force
        points = find_breakpoints(force, force.prologue(x))
        bends = points.acceleration(np.arange(len(points.angles)))
        return points.folded, points.velocity, bends

    @property
    def without(self) -> tuple[str, ...]:
        """Design parameters that cannot change the force, as was proved when its code was
        generated.

        A stage does not depend on its length if it has a single length and similar curves give the
        same results.
        """
        vectors = self.device.sidecar["vectors"]
        mounting = [
            entry["shown"] for entry in vectors["mounting"] if entry["name"] in self._insensitive
        ]
        distances = [vectors[f"hoisted{i}"]["known"]["0"]["name"] for i in (1, 2)]
        pairs = zip(self._gears, distances, strict=True)
        stages = (gear.without for gear, distance in pairs if distance in self._insensitive)
        return (*mounting, *chain.from_iterable(stages))


@dataclass(frozen=True)
class GearCode:
    """Generated code of a gear stage; with `lengths`, places of parameters, that of the curve whose
    first is 1.

    Similar curves then give the same results.
    """

    stage: Stage
    module: ModuleType
    lengths: tuple[int, ...]

    @classmethod
    def of_stage(cls, stage: Stage, felt: Sequence[str]) -> GearCode:
        """Return the code of a stage of which results `felt` matter."""
        similar, order = (
            stage.sidecar["similar"],
            [entry["name"] for entry in stage.sidecar["parameters"]],
        )
        is_unchanged = set(felt) <= set(similar["unchanged"])
        lengths = tuple(order.index(name) for name in similar["lengths"]) if is_unchanged else ()
        return cls(stage, generated.module(f"array.curve_{stage.family}"), lengths)

    @property
    def has_series(self) -> bool:
        """Whether the centre distance has no closed form."""
        return bool(self.stage.sidecar["series"])

    @property
    def without(self) -> tuple[str, ...]:
        """The length of a curve that has no effect on the results."""
        return (self.stage.names[self.lengths[0]],) if len(self.lengths) == 1 else ()

    def _resize(self, parameters: Sequence[Any]) -> list[Any]:
        """Return the parameters of the curve of unit size."""
        resized = list(parameters)
        for place in self.lengths:
            resized[place] = (
                1.0 if place == self.lengths[0] else parameters[place] / parameters[self.lengths[0]]
            )
        return resized

    def find_distance(self, parameters: Array) -> Array:
        """Return the centre distance (1, 1) of a curve of unit size."""
        resized = np.array(self._resize(parameters.tolist()))
        distance: Array = self.stage.prologue(parameters=resized)["hoisted"][:1, :1]
        return distance

    def record(self, recorder: ResponseRecorder, places: Sequence[int]) -> list[list[int]]:
        """Return indices of parameters, of results, and of the parameters and invariants of the
        curve of unit size.
        """
        module, terms = self.module, self.stage.terms
        unit = recorder.call(lambda _, p: self._resize(p), places) if self.lengths else list(places)
        series: list[int] = []
        if self.has_series:
            radii = recorder.call(lambda xp, p: module.radii(xp, p, terms)[1], unit)
            (distance,) = recorder.call(
                lambda _, a: module.closure(a[0], a[1:])[1:], radii, [np.inf]
            )
            series = recorder.call(self._evaluate_series, [distance, *unit])
        else:
            (distance,) = recorder.call(lambda xp, p: [module.prologue(xp, p, 0)[0]], unit)
        scaled = [distance]
        if self.lengths:
            scaled = recorder.call(lambda _, a: [a[0] * a[1]], [distance, places[self.lengths[0]]])
        return [list(places), [*scaled, *series], unit, [distance, *series]]

    def _evaluate_series(self, xp: Any, inputs: Sequence[Any]) -> Sequence[Any]:
        distance, *parameters = inputs
        nodes, radii = self.module.radii(xp, parameters, self.stage.terms)
        ratios, _, _ = self.module.closure(distance, radii)
        series: Sequence[Any] = self.module.series(xp, ratios, nodes)
        return series


def _touch(
    module: ModuleType, parameters: Sequence[Any], hoisted: Sequence[Any], xp: Any, t: Any, *_: Any
) -> Any:
    """Return the contact of a stage at an angle t, with derivatives."""
    options = {"sine_series": _sine_series} if len(hoisted) > 1 else {}
    return module.contact(xp, t, parameters, hoisted, **options)


def _sine_series(xp: Any, u: Any, b: Sequence[Any]) -> Any:
    """Sum over k of b[k] sin(k u) / k, term by term: enclosures would grow with each step of a
    recurrence.
    """
    terms = [b[k] / k * xp.sin(u * k) for k in range(1, len(b))]
    return sum(terms[1:], terms[0])


def add_proof(
    optimisation: Optimisation,
    seconds: float = SECONDS,
    progress: Listener | None = None,
    means: Means = AUTO,
    earlier: Path | None = None,
    keep: Callable[[str], None] | None = None,
) -> Optimisation:
    """Return an optimum with the bound on the objective of every design, within a CPU time [s].

    `means` says what bounds the boxes: a proof that ends before its time is up does not depend on
    it. A proof of the same in the file `earlier` is continued; the text of an interrupted one is
    handed to `keep`.
    """
    device, optimum = optimisation.devices[optimisation.result.model], optimisation.optimum
    count = None if optimum.sampling == "refined" else optimum.sampling
    build = partial(build_objective_enclosure, device.machine, device.model, count, optimum.design)
    extra = ", requirements kept or not," if optimum.requirements else ""
    design, scope = optimum.design, f"no design of the box{extra}"
    incumbent = Incumbent(design, device.named(design), optimum.objective, count, scope)
    box, proved = (device.lower, device.upper), describe_device(device)
    proof, text = write_certificate(
        build, box, incumbent, proved, seconds, progress, means, earlier, keep
    )
    return replace(
        optimisation, result=replace(optimisation.result, proof=proof.result), certificate=text
    )


def build_objective_enclosure(
    machine: PlantingMachine, model: Model, count: int | None, origin: Array | None = None
) -> ProvableObjective:
    """Return objective (31) of a machine over `count` samples, or the true one, as a proof bounds
    it, with the gear stages meant at the design `origin`, else at its own.
    """
    device = Device(machine, model)
    start = device.design if origin is None else origin
    return build_provable_objective(
        device.force.machine, build_measures(machine), count, EnclosedForce(device), (), start
    )


SEARCHED = ("design.", "bounds.")
"""Beginnings of the paths of numbers that a proof states as its box."""


def describe_device(device: Device) -> ProvedMachine:
    """Return what a proof of a device states of it."""
    machine = device.machine
    numbers = machine.numbers().items()
    fixed = {path: x for path, x in numbers if not path.startswith(SEARCHED)}
    sources, changes = (
        EnclosedForce(device).list_sources(),
        find_changes(fixed, machine.source, load),
    )
    inputs = {
        "machine": [float(x).hex() for x in device.constants],
        "mounting": device.size - sum(len(stage.names) for stage in device.stages),
        "stages": [
            [f"curve_{stage.family}", len(stage.names), stage.terms] for stage in device.stages
        ],
    }
    scales = device.scale.tolist()
    return ProvedMachine(
        device.names, scales, sources, machine.source, changes, device.model, inputs
    )


def rebuild_objective(source: str, document: Mapping[str, Any]) -> ProvableObjective:
    """Return the objective of a device for the quantities of a proof, without terms.

    Raises InputError if the device has other parameters.
    """
    stated = document["machine"]
    device = Device(load(source, stated["changes"]), stated["model"])
    if list(device.names) != document["parameters"]:
        raise InputError(f"{source}: its parameters are {', '.join(device.names)}")
    quantities = list(map(ProvedQuantity.from_document, stated["quantities"]))
    return build_bare_objective(device.force.machine, EnclosedForce(device), quantities, document)
