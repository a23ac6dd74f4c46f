"""Adapters of machines for sweeps and tolerances: the object `ADAPTER` in the module `swept` of a
package of machines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from planter import paths
from planter.engine.goal import Goal, extend_span, resolve_limit, resolve_measure
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure, parse_distance, parse_limit, parse_sum
from planter.engine.outputs import (
    SampledOutputs,
    find_output,
    list_default_outputs,
    list_outputs,
    name_example,
)
from planter.errors import InputError
from planter.files.document import Document
from planter.files.examples import find_kind, load_part
from planter.rows.points import Spread
from planter.rows.robust import RobustGoal, Settings
from planter.text_files import hash_file

Ends = Mapping[str, tuple[float, float]]
"""Two ends of inputs, by path."""


class MachineAdapter:
    """Adapter of a kind of machines: inputs are their values, outputs measures of their quantities.

    The modules `file` and `machines` of the package load files and build machines. All values are
    in the display units that their keys name.
    """

    choices: Mapping[str, Sequence[str]] = {}
    """Inputs with texts as values, and their allowed values, the default first."""

    def __init__(self, package: str | None, load: str = "load") -> None:
        self._package, self._load = package, load

    def _import_module(self, name: str) -> ModuleType:
        return import_module(f"{self._package}.{name}")

    def load(self, source: str, changes: Mapping[str, float]) -> Document:
        """Load the file of a machine, with changed numbers."""
        document: Document = getattr(self._import_module("file"), self._load)(source, changes)
        return document

    def build(self, machine: Any) -> Machine:
        """Build the machine of a file."""
        built: Machine = self._import_module("machines").build_machine(machine)
        return built

    def frozen(self, machine: Any) -> dict[str, Any]:
        """Return a description of the file, fit for JSON, from which `thaw` restores it: its path,
        since it may name other files, its changed numbers, and its table, which must not change.
        """
        path, numbers = Path(machine.source), machine.numbers()
        return {
            "source": str(path.resolve()) if path.is_file() else machine.source,
            "changes": {name: numbers[name] for name in machine.changed if name in numbers},
            "table": machine.table(),
        }

    def thaw(self, frozen: Mapping[str, Any]) -> Document:
        """Return the file that `frozen` describes. Raises InputError if it has changed."""
        document = self.load(frozen["source"], frozen["changes"])
        if document.table() != frozen["table"]:
            raise InputError(
                f"{frozen['source']}: the file has changed since the command started; run the "
                f"command again"
            )
        return document

    def default_outputs(self, machine: Any) -> Sequence[str]:
        """Return the names of the outputs of a plan that names none: the objective of the
        machine's file, if it has one, and the loads of its motors.
        """
        return list_default_outputs(self.build(machine))

    def nominal(self, machine: Any) -> dict[str, float]:
        """Return the machine's values in the units of their paths, unrounded from the file where it
        has them.
        """
        built, numbers = self.build(machine), machine.numbers()
        return {
            value.path: numbers.get(value.path, float(number / value.factor))
            for value, number in zip(built.values, built.data, strict=True)
        }

    def tolerances(self, machine: Any) -> dict[str, dict[str, Any]]:
        """Return the default tolerances as the table of a file: none."""
        return {}

    def subject(
        self,
        frozen: Mapping[str, Any],
        choices: Mapping[str, str],
        inputs: Ends,
        outputs: Sequence[str],
    ) -> SampledOutputs:
        """Return the outputs of a machine whose `inputs` take values between two ends.

        Raises InputError if its file does not allow an end of an input.
        """
        document = self.thaw(frozen)
        stated = document.numbers()
        for end in (0, 1):
            for name, ends in inputs.items():
                if name in stated:
                    document.with_numbers({name: ends[end]})
        return SampledOutputs(self.build(document), tuple(inputs), outputs)

    def build_robust(
        self,
        machine: Any,
        choices: Mapping[str, str],
        spreads: Mapping[str, Spread],
        settings: Settings,
    ) -> RobustGoal | None:
        """Return a sum of measures over machines within tolerances; None without a sum or without
        design variables.

        The sum, its limits and the design variables are those of the file or of the settings.
        Raises InputError if the settings state a search without a sum or without design variables.
        """
        built = self.build(machine).with_ranges(settings.ranges)
        terms, limits, samples = self.read_goal(machine)
        if settings.sum_text is not None:
            terms = [resolve_measure(built, measure) for measure in parse_sum(settings.sum_text)]
        limits = [*limits, *(resolve_limit(built, parse_limit(text)) for text in settings.holds)]
        built = extend_span(built, [*terms, *(limit.measure for limit in limits)])
        if not terms or not built.moved:
            if not settings.is_stated:
                return None
            missing = (
                "values to search in: give --vary PATH=LOW:HIGH"
                if terms
                else "sum to minimise: give --least SUM"
            )
            raise InputError(f"{built.source}: the robust design has no {missing}")
        bounds = MeasureLimits(Goal(built, (), limits)) if limits else None
        return RobustGoal(
            replace(built, objective=tuple(terms)), spreads, settings, samples, bounds
        )

    def read_goal(self, machine: Any) -> tuple[Sequence[Measure], Sequence[Limit], int]:
        """Return the sum of measures that a file minimises, its limits, and samples.

        Raises InputError for measures of unknown quantities.
        """
        built = self.build(machine)
        return (
            [resolve_measure(built, measure) for measure in built.objective],
            [resolve_limit(built, limit) for limit in built.limits],
            built.objective_samples,
        )


class ResolvedMachine:
    """A machine with the adapter of its kind. Raises InputError if no adapter takes `source`."""

    def __init__(self, source: str, changes: Mapping[str, float] | None = None) -> None:
        module = load_part(source, "swept") if find_kind(source) else None
        if module is None:
            raise InputError(
                f"{source}: no such machine; name a machine file, or a built-in machine that can "
                f"be swept"
            )
        self.module, self.source = module.__name__, source
        self.adapter: Any = module.ADAPTER
        self.machine = self.adapter.load(source, changes or {})

    @cached_property
    def built(self) -> Machine:
        """The machine of the engine."""
        machine: Machine = self.adapter.build(self.machine)
        return machine

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        """Meanings of the inputs, by path."""
        return {value.path: value.meaning for value in self.built.values}

    @cached_property
    def outputs(self) -> Mapping[str, str]:
        """Meanings of the outputs, by name."""
        return {name: output.meaning for name, output in list_outputs(self.built).items()}

    def path(self, name: str, label: str) -> str:
        """Return the full path of an input.

        Raises InputError, which begins with `label`, if it does not exist.
        """
        return find_full_name(name, self.inputs, label, "inputs")

    def hash_curves(self, outputs: Sequence[str]) -> dict[str, Any]:
        """Return the hashes of files with curves that outputs are distances from, as arguments of a
        recipe: other curves give other rows.
        """
        hashes = {}
        for text in outputs:
            names = (name for term in find_output(self.built, text).terms for name in term.names)
            for curve in map(parse_distance, names):
                if curve is not None and curve.file:
                    path = curve.find_file(self.built.source)
                    hashes[str(path)] = hash_file(path)
        return {"curves": hashes} if hashes else {}

    def resolve_outputs(self, names: Sequence[str], label: str) -> list[str]:
        """Return full names of outputs, the default ones if `names` is empty.

        Raises InputError as `path`.
        """
        names = names or self.adapter.default_outputs(self.machine)
        if not names:
            raise InputError(
                f"{label} is missing: name at least one output, such as "
                f"{name_example(self.built)}; {_hint((), 'outputs')}"
            )
        return [self.describe_output(name, label)[0] for name in names]

    def describe_output(self, name: str, label: str) -> tuple[str, str]:
        """Return the full name and the meaning of an output, which may be an expression in the
        language of measures. Raises InputError as `path`.
        """
        if " " in name or self.built.motion is not None:
            output = find_output(self.built, name, label)
            return output.name, output.meaning
        full = find_full_name(name, self.outputs, f"{label}: {name}", "outputs")
        return full, self.outputs[full]


def find_full_name(name: str, meanings: Mapping[str, str], label: str, kind: str) -> str:
    """Return the key of `meanings` that is `name`, or the only one that ends in it.

    Raises InputError, which begins with `label` and names the `kind` of the names, unless there is
    exactly one.
    """
    candidates = paths.Names(list(meanings)).candidates(name)
    if len(candidates) == 1:
        return candidates[0]
    hint = (
        f"it fits several, name one of {', '.join(candidates)}"
        if candidates
        else _hint(paths.find_similar(name, meanings), kind)
    )
    raise InputError(f"{label}: {hint}")


def _hint(close: Sequence[str], kind: str) -> str:
    suggestion = f"did you mean {' or '.join(close)}? " if close else ""
    return f"{suggestion}`planter sweep --list MACHINE` lists all {kind}"


def resolve_source(source: str, folder: Path | None) -> str:
    """Return the path of a machine file that a plan names relative to its folder, else the source
    itself.
    """
    if folder is not None and not Path(source).is_absolute() and (folder / source).is_file():
        return str(folder / source)
    return source
