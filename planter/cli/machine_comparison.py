"""The comparison of machines of one kind, each over the same angles of a cycle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from string import ascii_uppercase
from typing import Any, cast

import numpy as np

from planter import paths, plugins
from planter.cli.results import (
    ComparedCurve,
    ComparedMachine,
    ComparedRequirement,
    ComparedResult,
    ComparedValue,
    MachineComparison,
)
from planter.engine.goal import (
    evaluate_measure,
    evaluate_measures,
    extend_span,
    find_display_unit,
    resolve_limit,
    resolve_measure,
)
from planter.engine.machine import load_machine
from planter.engine.measures import TIME, Kind, Limit, Measure, parse_limit
from planter.engine.response import open_response
from planter.engine.rows import MachineRows
from planter.engine.summary import ROUNDING, QuantityPeak
from planter.errors import InputError
from planter.files import units
from planter.files.document import Document
from planter.files.examples import find_kind
from planter.kernels import Array
from planter.mechanism.cycle import simulate_machine
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import MechanismCycle
from planter.mechanism.optimisation import evaluate_limits
from planter.report.subject import RequirementCheck, open_machine

SAMPLES = 360
"""Angles of a cycle at which curves are compared."""
LETTERS = ascii_uppercase
"""Names of the machines in tables and figures, in order."""
UNCOMPARED = ("name", "description", "origin", "folder")
"""Keys of files that say nothing about a machine."""
MARGIN = "margin of "
"""Beginning of the names of results that are margins of requirements."""
STATISTICS: tuple[Kind, ...] = ("max", "min", "mean", "rms")
LOAD_UNITS = ("N", "N m", "W")
"""Units of forces, torques and powers."""
MOST_CURVES = 4
"""Curves that are compared if neither an objective, nor limits, nor a motor say which."""


@dataclass(frozen=True)
class ComparisonOptions:
    """Numbers changed in all machines by name, the speed of their drives, their model, further
    limits and curves, and the end of their motions [s] if they move freely.
    """

    changes: Mapping[str, float]
    speed_rpm: float | None = None
    model: str = "exact"
    holds: Sequence[str] = ()
    quantities: Sequence[str] = ()
    until: float | None = None


class ComparedDesign:
    """A machine with its cycle or its motion, its results by the texts of their measures, and its
    requirements.
    """

    def __init__(self, source: str, options: ComparisonOptions) -> None:
        package = find_kind(source)
        choices: dict[str, Any] = {}
        if options.model != "exact":
            choices["model"] = options.model
        self.source, self.options = source, options
        machine = load_machine(source, options.changes, options.speed_rpm, **choices)
        self.kind = "" if package is None else plugins.name_package(package)
        if machine.motion is not None:
            document = cast(MechanismFile, machine.document)
            machine = machine.with_span(options.until or document.until)
            self.kind += " that moves freely"
        elif options.until is not None:
            raise InputError(f"--until does not apply to {source}: an angle drives it")
        self.machine = machine

    @cached_property
    def cycle(self) -> MechanismCycle:
        """The cycle with the designer's summary."""
        return simulate_machine(self.machine, SAMPLES)

    @cached_property
    def peaks(self) -> dict[str, QuantityPeak]:
        """True extremes and integrals by the names of quantities; empty where a quantity has a
        pole.
        """
        if self.machine.motion is not None:
            return self._measure_motion(self.machine.motion.span)
        summary = self.cycle.result.designer
        return {} if summary is None else {peak.name: peak for peak in summary.peaks}

    def _measure_motion(self, until: float) -> dict[str, QuantityPeak]:
        results = [quantity for quantity in self.machine.results if quantity.name != TIME]
        measures = [
            Measure(kind, quantity.name, span=(0.0, until))
            for quantity in results
            for kind in STATISTICS
        ]
        values = np.reshape(evaluate_measures(self.machine, measures), (-1, len(STATISTICS)))
        return {
            q.name: QuantityPeak(
                q.name, q.meaning, units.display_unit(q.key), high, np.nan, low, np.nan, mean, rms
            )
            for q, (high, low, mean, rms) in zip(results, values.tolist(), strict=True)
        }

    @property
    def suffix(self) -> str:
        """Span of the times that a measure of the whole motion has after it."""
        motion = self.machine.motion
        return "" if motion is None else f" over 0..{motion.span:g} s"

    @cached_property
    def places(self) -> Array:
        """Angles of the drive (n,) [deg], or times of a motion (n,) [s], at which curves are."""
        motion = self.machine.motion
        if motion is None:
            return self.cycle.angles_deg
        return np.linspace(0.0, motion.span, SAMPLES + 1)

    @cached_property
    def columns(self) -> dict[str, Array]:
        """Results (n,) there, by key, in the units of the keys."""
        if self.machine.motion is None:
            return dict(self.cycle.columns)
        keys = [quantity.key for quantity in self.machine.results if quantity.name != TIME]
        return dict(zip(keys, self.sample_motion(keys), strict=True))

    def sample_motion(self, keys: Sequence[str]) -> Array:
        """Return quantities of a motion (m, n) at `places`, in the units of their keys."""
        quantities = [self.machine.find_quantity(key) for key in keys]
        response = open_response(self.machine, [quantity.name for quantity in quantities])
        phi = np.linspace(0.0, self.machine.turn, len(self.places))
        values = response.values(response.at_data(self.machine.data), phi)
        return values / np.array([[quantity.factor] for quantity in quantities])

    @cached_property
    def checks(self) -> dict[str, RequirementCheck]:
        """Requirements that the machine's file states besides limits, by name."""
        if self.machine.motion is not None:
            return {}
        limits = {str(limit.measure) for limit in self.machine.limits}
        view = open_machine(self.source, self.options.changes)
        speed = self.machine.values[self.machine.speed].path
        numbers = self.machine.document.numbers()
        values = {control.path: control.value for control in view.controls}
        if speed in values:
            values[speed] = numbers[speed]
        checks = view.checks(values, view.models[0])
        return {check.name: check for check in checks if check.name not in limits}

    def evaluate(self, measure: Measure) -> float | None:
        """Return a measure in its display unit, None if the machine has no such quantity."""
        try:
            machine = extend_span(self.machine, [measure])
            return evaluate_measure(machine, resolve_measure(machine, measure))
        except InputError:
            return None

    def judge(self, limit: Limit) -> tuple[float | None, bool | None]:
        """Return the value of a limit's measure and whether it satisfies the limit, None without
        its quantity.
        """
        is_cyclic = self.machine.motion is None
        changing = self.cycle.result.not_repeating if is_cyclic else {}
        try:
            result = evaluate_limits(replace(self.machine, limits=(limit,)), changing)[0]
        except InputError:
            return None, None
        return result.value, result.met


@dataclass(frozen=True)
class DesignComparison:
    """Machines of one kind, and what is compared of them."""

    designs: tuple[ComparedDesign, ...]
    result: MachineComparison

    @property
    def letters(self) -> Sequence[str]:
        """Names of the machines in tables and figures."""
        return LETTERS[: len(self.designs)]

    @property
    def meanings(self) -> dict[str, str]:
        """Meanings of the quantities and vectors of the first machine by name."""
        first = self.designs[0]
        meanings = {quantity.name: quantity.meaning for quantity in first.machine.results}
        return meanings | {peak.name: peak.meaning for peak in first.peaks.values()}


def compare_machines(sources: Sequence[str], options: ComparisonOptions) -> DesignComparison:
    """Return the comparison of machines, files or built-in names, with the first one.

    Raises InputError for fewer than two machines, for machines of different kinds, and as
    `load_machine`; ComputationError if a machine has no cycle or motion.
    """
    if not 2 <= len(sources) <= len(LETTERS):
        raise InputError(
            f"MACHINE: {len(sources)} given: name between 2 and {len(LETTERS)} machines to compare"
        )
    designs = tuple(ComparedDesign(source, options) for source in sources)
    first = designs[0]
    for other in designs[1:]:
        if other.kind != first.kind:
            kinds = (
                f"{first.source} is of the kind {first.kind}, {other.source} of the kind "
                f"{other.kind}"
            )
            raise InputError(f"MACHINE: {kinds}: machines that are compared must be of one kind")
    limits = _collect_limits(designs, options.holds)
    judged = [*_compare_limits(designs, limits), *_compare_checks(designs)]
    result = MachineComparison(
        machines=[
            ComparedMachine(design.machine.name, design.source, design.kind) for design in designs
        ],
        values=list(_compare_values([design.machine.document for design in designs])),
        results=[
            *_compare_results(designs),
            *(_compare_margins(sign, row) for sign, row in judged),
        ],
        requirements=[row for _, row in judged],
        curves=list(_compare_curves(designs, limits)),
    )
    return DesignComparison(designs, result)


def _compare_values(documents: Sequence[Document]) -> Iterator[ComparedValue]:
    """Yield the values of files that differ, in the order of the files."""
    tables = [dict(_list_entries(document)) for document in documents]
    for path in dict.fromkeys(path for table in tables for path in table):
        values = [table.get(path) for table in tables]
        if any(value != values[0] for value in values[1:]):
            yield ComparedValue(path, units.display_unit(path), values)


def _list_entries(document: Document) -> Iterator[tuple[str, Any]]:
    table = {key: value for key, value in document.table().items() if key not in UNCOMPARED}
    for path, value in paths.walk_paths(table):
        if isinstance(value, bool | int | float | str):
            yield path, value


def _compare_results(designs: Sequence[ComparedDesign]) -> Iterator[ComparedResult]:
    """Yield the objective of the first machine that has one with its terms, then statistics of all
    quantities.
    """
    owner = find_objective_owner(designs).machine
    objective = owner.objective
    values = [[design.evaluate(term) for term in objective] for design in designs]
    if objective:
        yield _compare("objective", "", [_add_terms(objective, terms) for terms in values], -1)
    stated = set()
    for index, term in enumerate(objective):
        measure = replace(resolve_measure(owner, term), weight=1.0)
        unit = find_display_unit(owner, measure).text
        stated.add(str(measure))
        yield _compare(
            str(measure), unit, [terms[index] for terms in values], -1 if term.weight > 0 else 1
        )
    for name in dict.fromkeys(name for design in designs for name in design.peaks):
        peaks = [design.peaks.get(name) for design in designs]
        unit = next(peak.unit for peak in peaks if peak is not None)
        size = max(max(abs(peak.max), abs(peak.min)) for peak in peaks if peak is not None)
        for kind in STATISTICS:
            text = f"{kind} {name}{designs[0].suffix}"
            if text not in stated:
                numbers = [None if peak is None else getattr(peak, kind) for peak in peaks]
                yield _compare(text, unit, numbers, 0, size)


def find_objective_owner(designs: Sequence[ComparedDesign]) -> ComparedDesign:
    """Return the first machine with an objective, or the first of all."""
    return next((design for design in designs if design.machine.objective), designs[0])


def _add_terms(objective: Sequence[Measure], values: Sequence[float | None]) -> float | None:
    total = 0.0
    for term, value in zip(objective, values, strict=True):
        if value is None:
            return None
        total += term.weight * value
    return total


def _compare(
    name: str, unit: str, values: Sequence[float | None], direction: int, size: float | None = None
) -> ComparedResult:
    """Return a result with its differences; larger is better for a `direction` of 1, smaller for
    -1.

    Differences below rounding of `size`, by default that of the values, are zero.
    """
    numbers = [value for value in values if value is not None]
    largest = max(map(abs, numbers), default=0.0) if size is None else size
    rounding = ROUNDING * largest
    first, better = values[0], None
    differences = [
        None
        if first is None or value is None
        else value - first
        if abs(value - first) > rounding
        else 0.0
        for value in values[1:]
    ]
    if direction and len(numbers) == len(values):
        order = np.argsort([-direction * value for value in numbers], kind="stable")
        if abs(numbers[order[0]] - numbers[order[1]]) > rounding:
            better = int(order[0])
    return ComparedResult(name, unit, list(values), differences, better)


def _collect_limits(designs: Sequence[ComparedDesign], holds: Sequence[str]) -> list[Limit]:
    """Return the limits of all files and those of the call, each once, with whole paths of their
    curves.
    """
    limits = [
        replace(limit, measure=limit.measure.with_whole_paths(design.source))
        for design in designs
        for limit in design.machine.limits
    ]
    limits += map(parse_limit, holds)
    return list({str(limit): limit for limit in limits}.values())


Judged = tuple[int, ComparedRequirement]
"""A requirement with the sign of its limit: +1 if it is an upper one, -1 if it is a lower one."""


def _compare_limits(designs: Sequence[ComparedDesign], limits: Sequence[Limit]) -> Iterator[Judged]:
    """Yield every limit with its value in every machine.

    Raises InputError for a limit that no machine can have.
    """
    for limit in limits:
        judged = [design.judge(limit) for design in designs]
        owner = next(
            (d for d, (_, met) in zip(designs, judged, strict=True) if met is not None), designs[0]
        )
        unit = find_display_unit(owner.machine, resolve_measure(owner.machine, limit.measure)).text
        stated = resolve_limit(owner.machine, limit)
        values, met = [value for value, _ in judged], [met for _, met in judged]
        yield limit.sign, ComparedRequirement(str(stated), stated.number, unit, values, met)


def _compare_checks(designs: Sequence[ComparedDesign]) -> Iterator[Judged]:
    """Yield the requirements that files state besides limits, each limit once, with the value in
    every machine.
    """
    for name in dict.fromkeys(name for design in designs for name in design.checks):
        checks = [design.checks.get(name) for design in designs]
        unit = next(check.unit for check in checks if check is not None)
        values = [None if check is None else check.value for check in checks]
        for sign, word, side in ((-1, ">=", "lower"), (1, "<=", "upper")):
            limits = [getattr(check, side) for check in checks if check is not None]
            for limit in sorted({limit for limit in limits if limit is not None}):
                met = [
                    None if value is None else _satisfies(value, sign, limit) for value in values
                ]
                text = f"{name} {word} {limit:g} {'' if unit == '1' else unit}".rstrip()
                yield sign, ComparedRequirement(text, limit, unit, values, met)


def _satisfies(value: float, sign: int, limit: float) -> bool:
    """Return whether a value satisfies a limit to rounding."""
    return sign * (limit - value) >= -ROUNDING * max(abs(value), abs(limit))


def _compare_margins(sign: int, row: ComparedRequirement) -> ComparedResult:
    """Return the margins of a requirement, which are negative where it is violated."""
    margins = [None if value is None else sign * (row.limit - value) for value in row.values]
    sizes = [abs(row.limit), *(abs(value) for value in row.values if value is not None)]
    return _compare(f"{MARGIN}{row.limit_on}", row.unit, margins, 1, max(sizes))


def _compare_curves(
    designs: Sequence[ComparedDesign], limits: Sequence[Limit]
) -> Iterator[ComparedCurve]:
    """Yield the quantities of the call, of the objective, of limits and of motors, or else those
    that differ most.

    Raises InputError for a quantity that a machine does not have.
    """
    first = designs[0]
    for design in designs[1:]:
        if not np.isclose(design.machine.turn, first.machine.turn):
            return
    keys = [first.machine.find_quantity(name).key for name in first.options.quantities]
    names = [term.name for term in find_objective_owner(designs).machine.objective]
    names += [name for limit in limits for name in (limit.measure.name,)] + list(
        first.machine.motors
    )
    keys_by_name = {quantity.name: quantity.key for quantity in first.machine.results}
    keys_by_name |= {key: key for key in keys_by_name.values()}
    keys += [keys_by_name[name] for name in names if name in keys_by_name]
    keys = list(dict.fromkeys(keys)) or _find_differing(designs)
    for key in keys:
        columns = [_sample_quantity(design, key) for design in designs]
        quantity = first.machine.find_quantity(key)
        places, moves = first.places.tolist(), first.machine.motion is not None
        yield ComparedCurve(
            quantity.name,
            units.display_unit(key),
            None if moves else places,
            [c.tolist() for c in columns],
            places if moves else None,
        )


def _sample_quantity(design: ComparedDesign, key: str) -> Array:
    """Return a quantity (n,) over the samples of a design's cycle, in the unit of its key: of any
    that the machine has.

    Raises InputError for a quantity that it does not have.
    """
    quantity = design.machine.find_quantity(key)
    if key in design.columns:
        return design.columns[key]
    if design.machine.motion is not None:
        return np.asarray(design.sample_motion([key])[0])
    rows = MachineRows(
        design.machine, [quantity.name], len(design.cycle.angles_deg), compared=False
    )
    values: Array = rows.evaluate(design.machine.data[None], lambda block: block.samples[0])
    return np.resize(values[0], len(design.cycle.angles_deg)) / quantity.factor


def _find_differing(designs: Sequence[ComparedDesign]) -> list[str]:
    """Return the keys of the quantities whose curves differ most from those of the first machine,
    in their range.
    """
    first, *rest = (design.columns for design in designs)
    shared = [key for key in first if all(key in columns for columns in rest)]
    largest = {key: max(_share(first[key], columns[key]) for columns in rest) for key in shared}
    order = sorted(shared, key=lambda key: -largest[key])
    return [key for key in order if largest[key] > ROUNDING][:MOST_CURVES] or shared[:1]


def _share(first: Array, other: Array) -> float:
    """Return the largest difference of two curves, as a share of the larger of their sizes."""
    size = max(float(np.abs(first).max()), float(np.abs(other).max())) or 1.0
    return float(np.abs(other - first).max()) / size


def list_main_results(comparison: DesignComparison, count: int) -> list[ComparedResult]:
    """Return the objective with its terms, then `count` loads that change, those first whose change
    is largest against the largest load of their unit.
    """
    results = comparison.result.results
    stated = len(find_objective_owner(comparison.designs).machine.objective)
    first = results[: stated + 1] if stated else []
    loads = [
        row
        for row in results[len(first) :]
        if row.unit in LOAD_UNITS and not row.name.startswith(MARGIN)
    ]
    sizes = {unit: _find_largest([r for r in loads if r.unit == unit]) for unit in LOAD_UNITS}
    changed = [row for row in loads if any(row.difference)]
    changed.sort(key=lambda row: _find_change(row) / (sizes[row.unit] or 1.0), reverse=True)
    return [*first, *changed[:count]]


def _find_largest(rows: Sequence[ComparedResult]) -> float:
    """Return the largest size of the values of rows."""
    return max((abs(value) for row in rows for value in row.values if value is not None), default=0)


def _find_change(row: ComparedResult) -> float:
    """Return the size of the largest difference of a row."""
    return max(abs(difference or 0.0) for difference in row.difference)


def find_violations(comparison: DesignComparison) -> list[list[str]]:
    """Return the names of the requirements that each machine violates: of its own file's, which may
    limit a value on both sides, and of limits.
    """
    return [
        [name for name, is_met in verdicts.items() if is_met is False]
        for verdicts in list_verdicts(comparison)
    ]


def list_verdicts(comparison: DesignComparison) -> list[dict[str, bool | None]]:
    """Return whether each machine satisfies each requirement, by name, None if it does not apply.

    A requirement of files with limits on both sides is one, as in all results of one machine.
    """
    stated = list(dict.fromkeys(n for design in comparison.designs for n in design.checks))
    verdicts: list[dict[str, bool | None]] = [{} for _ in comparison.designs]
    for row in comparison.result.requirements:
        for k, is_met in enumerate(row.met):
            name = next((n for n in stated if row.limit_on.startswith(f"{n} ")), row.limit_on)
            verdicts[k][name] = _join_verdicts(verdicts[k].get(name, is_met), is_met)
    return verdicts


def _join_verdicts(first: bool | None, second: bool | None) -> bool | None:
    return None if first is None or second is None else first and second
