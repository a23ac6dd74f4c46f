"""Adapters of machines for tolerances: those of `planter.sweeps.adapter` with slopes, curves and
robust designs.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

from planter.errors import InputError
from planter.files.document import Document
from planter.files.text import hash_file
from planter.sweeps import adapter

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.engine.measures import Limit, Measure
    from planter.engine.outputs import SampledOutputs
    from planter.kernels import Array
    from planter.progress import Listener
    from planter.tolerance.job import Spread
    from planter.tolerance.results import RobustFound
    from planter.tolerance.robust import RobustGoal, Settings


class ToleranceSubject(adapter.SweepSubject, Protocol):
    """A machine that evaluates rows of inputs, and slopes at one point."""

    def slopes(self, point: Array) -> tuple[Array, Array] | None:
        """Return outputs (k,) at a point (n,) and their exact slopes (k, n), in display units; None
        without slopes.
        """

    def curves(self, keys: Sequence[str], points: Array) -> Mapping[str, Array]:
        """Return quantities over a cycle, (m, angles) each, at points (m, n), and their angles
        `phi_deg`.
        """


class ToleranceAdapter(adapter.SweepAdapter, Protocol):
    """Adapter of a kind of machines."""

    banded: Sequence[str]
    """Default outputs."""
    curves: Sequence[str]
    """Quantities with figures over a cycle."""
    paths: Sequence[tuple[str, str]]
    """Pairs of quantities with figures of a path."""

    def nominal(self, machine: Any) -> Mapping[str, float]:
        """Return the values of the inputs in the file, in display units."""

    def tolerances(self, machine: Any) -> Mapping[str, Mapping[str, Any]]:
        """Return the default tolerances as the table of a file, empty if the kind has no
        defaults.
        """

    def robust(
        self,
        machine: Any,
        choices: Mapping[str, str],
        spreads: Mapping[str, Spread],
        settings: Settings,
        progress: Listener | None,
    ) -> RobustFound | None:
        """Return the design with the smallest mean plus `sigmas` standard deviations of the
        objective.

        None if the machine has no objective or no design variables.
        """


class MachineAdapter(ABC):
    """Adapter of machines of the engine: inputs are their values, outputs measures of their
    quantities.

    The modules `file` and `machines` of the package load files and build machines.
    """

    choices: Mapping[str, Sequence[str]] = {}
    banded: Sequence[str] = ()
    curves: Sequence[str] = ()
    paths: Sequence[tuple[str, str]] = ()

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

    @abstractmethod
    def frozen(self, machine: Any) -> dict[str, Any]:
        """Return a description of the file, fit for JSON, from which `thaw` restores it."""

    @abstractmethod
    def thaw(self, frozen: Mapping[str, Any]) -> Document:
        """Return the file that `frozen` describes."""

    def inputs(self, machine: Any) -> dict[str, str]:
        """Return the meanings of the machine's values, by path."""
        return {value.path: value.meaning for value in self.build(machine).values}

    def outputs(self, machine: Any) -> dict[str, str]:
        """Return the meanings of the measures of the machine's quantities over a cycle."""
        from planter.engine.outputs import list_outputs

        return {name: output.meaning for name, output in list_outputs(self.build(machine)).items()}

    def describe_measure(self, machine: Any, text: str, label: str) -> tuple[str, str]:
        """Return the name and the meaning of an output that is an expression in the language of
        measures.
        """
        from planter.engine.outputs import find_output

        output = find_output(self.build(machine), text, label)
        return output.name, output.meaning

    def default_outputs(self, machine: Any) -> Sequence[str]:
        """Return the objective of the machine's file, if it has one, and the loads of its
        motors.
        """
        from planter.engine.outputs import list_default_outputs

        return list_default_outputs(self.build(machine))

    def hash_curves(self, machine: Any, outputs: Sequence[str]) -> dict[str, str]:
        """Return the hashes of the files with curves that outputs are distances from, by their
        paths.
        """
        from planter.engine.measures import parse_distance
        from planter.engine.outputs import find_output

        built = self.build(machine)
        names = [
            name
            for text in outputs
            for term in find_output(built, text).terms
            for name in term.names
        ]
        paths = [
            curve.find_file(built.source)
            for curve in map(parse_distance, names)
            if curve is not None and curve.file
        ]
        return {str(path): hash_file(path) for path in paths}

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
        """Return no default tolerances."""
        return {}

    def robust(
        self,
        machine: Any,
        choices: Mapping[str, str],
        spreads: Mapping[str, Spread],
        settings: Settings,
        progress: Listener | None,
    ) -> RobustFound | None:
        """Return the design with the smallest mean plus `sigmas` standard deviations of a sum of
        measures.

        None without a sum or without design variables. Raises ComputationError if the file's design
        has no cycle.
        """
        from planter.tolerance.robust import find_robust

        robust = self.build_robust(machine, choices, spreads, settings)
        return None if robust is None else find_robust(robust, settings, progress)

    def build_robust(
        self,
        machine: Any,
        choices: Mapping[str, str],
        spreads: Mapping[str, Spread],
        settings: Settings,
    ) -> RobustGoal | None:
        """Return a sum of measures over machines within tolerances; None as `robust`.

        The sum, its limits and the design variables are those of the file or of the settings.
        Raises InputError if the settings state a search without a sum or without design variables.
        """
        from planter.engine.goal import Goal, resolve_limit, resolve_measure
        from planter.engine.limits import MeasureLimits
        from planter.engine.measures import parse_limit, parse_sum
        from planter.tolerance.robust import RobustGoal

        built = self.build(machine).with_ranges(settings.ranges)
        terms, limits, samples = self.read_goal(machine)
        if settings.sum_text is not None:
            terms = [resolve_measure(built, measure) for measure in parse_sum(settings.sum_text)]
        limits = [*limits, *(resolve_limit(built, parse_limit(text)) for text in settings.holds)]
        if settings.is_stated and not (terms and built.moved):
            missing = (
                "values to search in: give --vary PATH=LOW:HIGH"
                if terms
                else "sum to minimise: give --least SUM"
            )
            raise InputError(f"{built.source}: the robust design has no {missing}")
        if not terms or not built.moved:
            return None
        bounds = MeasureLimits(Goal(built, (), limits)) if limits else None
        return RobustGoal(
            replace(built, objective=tuple(terms)), spreads, settings, samples, bounds
        )

    def read_goal(self, machine: Any) -> tuple[Sequence[Measure], Sequence[Limit], int]:
        """Return the sum of measures that a file minimises, its limits, and samples.

        Raises InputError for measures of unknown quantities.
        """
        from planter.engine.goal import resolve_limit, resolve_measure

        built = self.build(machine)
        terms = tuple(resolve_measure(built, measure) for measure in built.objective)
        return (
            terms,
            tuple(resolve_limit(built, limit) for limit in built.limits),
            built.objective_samples,
        )

    def subject(
        self,
        frozen: Mapping[str, Any],
        choices: Mapping[str, str],
        inputs: Mapping[str, tuple[float, float]],
        outputs: Sequence[str],
    ) -> SampledOutputs:
        """Return the outputs of a machine.

        Raises InputError if its file does not allow an end of an input.
        """
        from planter.engine.outputs import SampledOutputs

        document = self.thaw(frozen)
        stated = document.numbers()
        for end in (0, 1):
            for name, ends in inputs.items():
                if name in stated:
                    document.with_numbers({name: ends[end]})
        return SampledOutputs(self.build(document), tuple(inputs), outputs)


class FileAdapter(MachineAdapter):
    """Adapter of machines whose files other processes read again, since they may name other files
    or be built in.
    """

    def frozen(self, machine: Any) -> dict[str, Any]:
        """Return the path of the file, its changed numbers, and its table, which must not
        change.
        """
        path = Path(machine.source)
        numbers = machine.numbers()
        return {
            "source": str(path.resolve()) if path.is_file() else machine.source,
            "changes": {name: numbers[name] for name in machine.changed if name in numbers},
            "table": machine.table(),
        }

    def thaw(self, frozen: Mapping[str, Any]) -> Document:
        """Load the file again. Raises InputError if it has changed."""
        document = self.load(frozen["source"], frozen["changes"])
        if document.table() != frozen["table"]:
            raise InputError(
                f"{frozen['source']}: the file has changed since the command started; run the "
                f"command again"
            )
        return document
