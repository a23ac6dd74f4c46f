"""Outputs of a machine by name: measures of its quantities over a cycle, for rows of its values.

An output is called after its quantity, its measure and its unit, such as `M_in_rms_Nm`; `objective`
is the sum that the machine's file minimises. Every other measure is an output by its own text and
unit, such as `jump F_Ox [N]`. What moves freely has no cycle: its outputs are the objective and
measures of times, such as `max x over 0..2 s [mm]`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from planter import paths
from planter.engine.cycles import Cycles, CycleTerm, Memory, build_cycles
from planter.engine.goal import (
    Goal,
    bound_measure,
    extend_span,
    find_display_unit,
    resolve_limit,
    resolve_measure,
)
from planter.engine.machine import HasMachine, Machine, Quantity, to_machine
from planter.engine.measures import AVERAGES, TIME, Kind, Measure, parse_measure
from planter.engine.response import open_response
from planter.engine.rows import MachineRows, SampleBlock
from planter.engine.solvers.objective import find_hessian
from planter.engine.solvers.sampled_cycle import sample_angles
from planter.engine.true_rows import KINDS, TrueRows
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.files.record import build_frame, format_table
from planter.kernels import Array, CallError
from planter.progress import Listener, ProgressPhase

if TYPE_CHECKING:
    from pandas import DataFrame

MEASURED: dict[Kind, str] = {
    "max": "largest value",
    "min": "least value",
    "range": "largest less least value",
    "mean": "mean",
    "rms": "root mean square",
    "std": "standard deviation",
}
"""Measures that every quantity has an output of, and what they mean."""
MOTOR: tuple[Kind, ...] = ("max", "rms")
"""Measures of a motor's torque that its choice depends on."""
VARIANCE: Kind = "variance"
OBJECTIVE = "objective"
SQUARES = {"": "", "_N": "_N2"}
"""Endings of keys for the square of a unit."""
SAME_SAMPLE = 1e-9
"""Share of a step by which the angle of a measure may miss a sample and is still its."""
COMPILED = 64
"""Rows from which on it pays to compile their slopes."""


@dataclass(frozen=True)
class Output:
    """A sum of measures over a cycle, each in the unit of its quantity's key."""

    name: str
    meaning: str
    terms: tuple[Measure, ...]


def list_outputs(machine: Machine) -> dict[str, Output]:
    """Return every output of a machine by its name.

    Quantities that the objective is made of have a variance, too, if the square of their unit has a
    name. What moves freely has what its file speaks of, the objective and what limits are on, and
    measures of times, of which there are more.
    """
    outputs: list[Output] = []
    if machine.objective:
        terms = tuple(resolve_measure(machine, measure) for measure in machine.objective)
        outputs.append(Output(OBJECTIVE, "objective of the machine's file", terms))
        cyclic = () if machine.motion is not None else terms
        for name in dict.fromkeys(measure.name for measure in cyclic):
            quantity = machine.find_quantity(name)
            if units.unit_suffix(quantity.key) in SQUARES:
                outputs.append(_build_output(quantity, VARIANCE, "population variance"))
    for quantity in machine.quantities if machine.motion is None else ():
        outputs += [_build_output(quantity, kind, meaning) for kind, meaning in MEASURED.items()]
    if machine.motion is not None:
        results = [quantity for quantity in machine.results if quantity.name != TIME]
        measures = [*_list_limited(machine), *(m for q in results for m in _time(q))]
        outputs += [_state_output(machine, measure) for measure in measures]
    return {output.name: output for output in outputs}


def list_default_outputs(machine: Machine) -> list[str]:
    """Return the names of the outputs that stand for a machine: its objective, and the torques of
    its motors; of what moves freely its objective, and what limits are on.
    """
    if machine.motion is not None:
        limited = [_state_output(machine, measure).name for measure in _list_limited(machine)]
        return [*([OBJECTIVE] if machine.objective else []), *limited]
    torques = [
        _build_output(machine.find_quantity(name), kind, "")
        for name in machine.motors
        for kind in MOTOR
    ]
    return [*([OBJECTIVE] if machine.objective else []), *(output.name for output in torques)]


def _list_limited(machine: Machine) -> list[Measure]:
    """Return the measures that the limits of a machine's file are on."""
    return [bound_measure(resolve_limit(machine, limit)) for limit in machine.limits]


def _time(quantity: Quantity) -> tuple[Measure, Measure]:
    """Return measures of a quantity over a time, and at one."""
    name = quantity.name
    return Measure("max", name, span=(0.0, 1.0)), Measure("at", name, angle=1.0, in_time=True)


def _build_output(quantity: Quantity, kind: Kind, meaning: str) -> Output:
    suffix = units.unit_suffix(quantity.key)
    unit = SQUARES[suffix] if kind == VARIANCE else suffix
    name = f"{quantity.key.removesuffix(suffix)}_{kind}{unit}"
    return Output(
        name, f"{quantity.meaning}: {meaning} over a turn", (Measure(kind, quantity.name),)
    )


def find_output(machine: Machine, name: str, label: str = "output") -> Output:
    """Return an output by its name, or the measure that a text is, with or without its unit.

    Raises InputError, which begins with `label`, for what is neither.
    """
    outputs = list_outputs(machine)
    if name in outputs:
        return outputs[name]
    if " " not in name:
        close = paths.find_similar(name, outputs)
        hint = (
            f"did you mean {' or '.join(close)}?"
            if close
            else f"an output is called such as {name_example(machine)}"
        )
        raise InputError(f"{machine.source}: {machine.name} has no output {name}: {hint}")
    text, _, unit = name[:-1].rpartition(" [") if name.endswith("]") else (name, "", "")
    measure = resolve_measure(machine, parse_measure(text, label))
    display = find_display_unit(machine, measure).text
    if unit not in ("", display):
        raise InputError(f"{label} {name!r}: it is in {display or 'no unit'}")
    return _state_output(machine, measure)


def _state_output(machine: Machine, measure: Measure) -> Output:
    """Return the output that is called after a measure and its unit."""
    display = find_display_unit(machine, measure).text
    name = f"{measure} [{display}]" if display else str(measure)
    return Output(name, machine.find_quantity(measure.name).meaning, (measure,))


def name_example(machine: Machine) -> str:
    """Return how an output of a machine is called."""
    if machine.motion is None:
        return next(iter(list_outputs(machine)))
    return " or ".join(f'"{measure}"' for measure in _time(machine.results[0]))


class SampledOutputs:
    """Outputs by name over rows of values by path, in the units that the names end in.

    They are true extremes and integrals, or, with `samples`, those of that many. A row has no
    output where the machine has no cycle, and no average of what does not repeat after a turn.
    What moves freely does so for as long as the outputs ask, and has true ones only.
    """

    def __init__(
        self,
        machine: Machine,
        inputs: Sequence[str],
        names: Sequence[str],
        samples: int | None = None,
    ) -> None:
        self.outputs = [find_output(machine, name) for name in names]
        machine = machine.with_moved(dict.fromkeys(inputs, (0.0, 0.0)))
        measures = [term for output in self.outputs for term in output.terms]
        self.machine = extend_span(machine, measures)
        samples = samples if machine.motion is None else None
        terms = [(k, term) for k, output in enumerate(self.outputs) for term in output.terms]
        self.quantities = list(dict.fromkeys(term.name for _, term in terms))
        compared = any(term.kind in AVERAGES for _, term in terms)
        self.rows = MachineRows(self.machine, self.quantities, samples, compared)
        self._cycles: dict[int, Cycles | None] = {}
        self._terms = [self._build_term(k, term) for k, term in terms]
        self._true = TrueRows(self.rows) if samples is None else None

    def _build_term(self, output: int, measure: Measure) -> CycleTerm:
        """Return a measure as a term; work is a mean times the length of a turn."""
        quantity, machine = self.machine.find_quantity(measure.name), self.machine
        scale = measure.weight / (
            quantity.factor**2 if measure.kind == VARIANCE else quantity.factor
        )
        if measure.kind == "work":
            speed = 1.0 if quantity.unit == "N m" else abs(float(machine.data[machine.speed]))
            scale = measure.weight * machine.turn / speed
        kind: Kind = "mean" if measure.kind == "work" else measure.kind
        sample = 0 if measure.angle is None else round(self._find_sample(measure))
        return CycleTerm(
            output, self.quantities.index(measure.name), kind, scale, measure.size, sample
        )

    def _find_sample(self, measure: Measure) -> float:
        """Return which sample the angle of a measure is, NaN without an angle."""
        return (
            np.nan
            if measure.angle is None
            else np.radians(measure.angle % 360) / self.rows.angles[1]
        )

    def _is_sampled(self, measure: Measure) -> bool:
        """Return whether samples of a quantity are all that a measure takes; what else there is, a
        goal has.
        """
        if self.machine.motion is not None:
            return False
        if measure.kind == "at":
            sample = self._find_sample(measure)
            return self._true is None and bool(abs(sample - np.round(sample)) < SAME_SAMPLE)
        if measure.kind == "work" and self.machine.find_quantity(measure.name).unit == "W":
            return not measure.is_moving and self.machine.speed not in self.machine.moved
        return not measure.is_moving

    def data(self, points: Array) -> Array:
        """Return all values (m, v) in SI at points (m, n)."""
        data = np.repeat(self.machine.data[None], len(points), axis=0)
        data[:, list(self.machine.moved)] = np.asarray(points, dtype=float) * self.machine.scale
        return data

    def evaluated(self, points: Array, threads: int) -> Array:
        """Return outputs (m, k) at points (m, n), NaN without a cycle."""
        values = self._measure(self.data(points), threads)
        for row, k, goal, x in self._visit(points, values, self._goals):
            values[row, k] += _evaluate(goal, x)[0]
        return values

    def _visit(
        self, points: Array, values: Array, goals: Mapping[int, Goal]
    ) -> Iterator[tuple[int, int, Goal, Array]]:
        """Yield rows, outputs and their goals, and the moved values (n,) in SI, of values (m, k)
        that are there; goals of a row, which share its motion, come one after another.
        """
        designs = np.asarray(points, dtype=float) * self.machine.scale
        for row in range(len(points)) if goals else ():
            for k, goal in goals.items():
                if not np.isnan(values[row, k]):
                    yield row, k, goal, designs[row]

    def _measure(self, d: Array, threads: int) -> Array:
        """Return outputs (m, k) of rows of values d (m, v) in SI, but for those that goals have."""
        if self._true is None:
            return self.sample(d, threads)
        if self.machine.motion is not None:
            return np.zeros((len(d), len(self.outputs)))
        if len(d) >= COMPILED:
            self._true.compile()
        measures, values = self._true.evaluate(d, threads), np.zeros((len(d), len(self.outputs)))
        for term in self._terms:
            if term.output not in self._goals:
                values[:, term.output] += term.scale * _read_measure(measures[:, term.place], term)
        has_cycle = ~np.isnan(measures[:, :, 0]).any(axis=1)
        values[~has_cycle] = np.nan
        return values

    def gradients(
        self, points: Array, threads: int, count: int | None = None
    ) -> tuple[Array, Array]:
        """Return outputs (m, k) at points (m, n) and exact slopes (m, k, n) of them; extremes stay
        at their samples.

        Slopes are those of the first `count` outputs, all if it is None.
        """
        if self._true is not None:
            return self._differentiate(
                points, threads, len(self.outputs) if count is None else count
            )
        count, compiled = len(self.outputs) if count is None else count, len(points) >= COMPILED
        values, slopes = self.sample_slopes(self.data(points), threads, count, compiled)
        for row, k, goal, x in self._visit(points, values, self._goals):
            value, slope = _evaluate(goal, x, with_slope=k < count)
            values[row, k] += value
            if k < count:
                slopes[row, k] = slope
        slopes[np.isnan(values[:, :count])] = np.nan
        return values, slopes * self.machine.scale

    def _differentiate(self, points: Array, threads: int, count: int) -> tuple[Array, Array]:
        """Return true outputs (m, k) at points (m, n), and exact slopes (m, count, n) of the
        first.
        """
        values = self._measure(self.data(points), threads)
        slopes = np.full((len(points), count, len(self.machine.moved)), np.nan)
        sloped = dict(enumerate(self._true_goals[:count]))
        for row, k, goal, x in self._visit(points, values, self._goals | sloped):
            value, slope = _evaluate(goal, x, with_slope=k < count)
            values[row, k] += value if k in self._goals else 0.0
            if k < count:
                slopes[row, k] = slope
        return values, slopes * self.machine.scale

    def sample(self, d: Array, threads: int) -> Array:
        """Return outputs (m, k) of rows of values d (m, v) in SI, as far as samples decide them."""
        cycles = self.find_cycles()
        return (
            self.rows.evaluate(d, self._reduce, threads)
            if cycles is None
            else cycles.evaluate(d, threads)[0]
        )

    def sample_slopes(
        self, d: Array, threads: int, count: int, compiled: bool
    ) -> tuple[Array, Array]:
        """Return that and slopes (m, count, n) in SI of the first outputs, compiled if that
        pays.
        """
        pairs = self._pair(count)
        cycles = self.find_cycles(count) if pairs and compiled else None
        if cycles is not None:
            values, slopes = cycles.evaluate(d, threads)
            # The compiled loop gives a row up that has no slopes at an angle; here those of a side
            # may stand for it.
            failed = np.isnan(slopes).any(axis=(1, 2))
            if failed.any():
                values[failed], slopes[failed] = self._sample_blocks(
                    d[failed], threads, count, pairs
                )
            return values, slopes
        if pairs and compiled:
            self.rows.compile_slopes(1 + max(place for _, place in pairs))
        return self._sample_blocks(d, threads, count, pairs)

    def _sample_blocks(
        self, d: Array, threads: int, count: int, pairs: Sequence[tuple[int, int]]
    ) -> tuple[Array, Array]:
        """Return outputs and slopes as `sample_slopes`, by blocks of samples."""
        size = len(self.machine.moved)

        def reduce(block: SampleBlock) -> Array:
            slopes = np.zeros((count, size, len(block.rows)))
            if pairs:
                parts = self.rows.gradients(
                    block, [place for _, place in pairs], self._weigh(block, pairs)
                )
                for (k, _), part in zip(pairs, parts, strict=True):
                    slopes[k] += part
            return np.concatenate(
                [self._reduce(block), slopes.reshape(count * size, len(block.rows))]
            )

        rows = self.rows.evaluate(d, reduce, threads, size if pairs else 0)
        return rows[:, : len(self.outputs)], rows[:, len(self.outputs) :].reshape(
            len(d), count, size
        )

    def find_cycles(self, sloped: int = 0) -> Cycles | None:
        """Return the outputs compiled, with slopes of the first `sloped`; None if they are not
        evaluated in lanes.
        """
        if sloped not in self._cycles:
            terms = [term for term in self._terms if term.output not in self._goals]
            if not all(term.is_statistic for term in terms):
                self._cycles[sloped] = None
                return None
            averages = [(term.output, term.place) for term in self._terms if term.kind in AVERAGES]
            self._cycles[sloped] = build_cycles(
                self.rows, terms, averages, len(self.outputs), sloped
            )
        return self._cycles[sloped]

    def find_row_cycles(self) -> tuple[Cycles | None, Cycles | None]:
        """Return the outputs compiled for single rows, without and with slopes of the first; None
        where that takes more than a compiled call: closed loops, and what goals have.
        """
        if self._goals or self.machine.loops is not None:
            return None, None
        return self.find_cycles(), self.find_cycles(1)

    def _pair(self, count: int) -> list[tuple[int, int]]:
        """Return the pairs of an output, one of the first `count`, and the place of a quantity that
        it is made of.
        """
        sampled = [
            term for term in self._terms if term.output < count and term.output not in self._goals
        ]
        return list(dict.fromkeys((term.output, term.place) for term in sampled))

    def _weigh(self, block: SampleBlock, pairs: Sequence[tuple[int, int]]) -> Array:
        """Return the derivatives (pairs, n, rows) of outputs in the samples of their quantities."""
        weights = np.zeros((len(pairs), *block.samples.shape[1:]))
        for term in self._terms:
            if (term.output, term.place) in pairs:
                weights[pairs.index((term.output, term.place))] += term.differentiate(
                    block.samples[term.place]
                )
        return weights

    def _reduce(self, block: SampleBlock) -> Array:
        """Return outputs (k, rows), zero where a goal is to be added."""
        reduced = np.zeros((len(self.outputs), len(block.rows)))
        for term in self._terms:
            if term.output not in self._goals:
                reduced[term.output] += term.reduce(block.samples[term.place])
            if term.kind in AVERAGES:
                reduced[term.output, ~block.repeats[term.place]] = np.nan
        return reduced

    @cached_property
    def _goals(self) -> dict[int, Goal]:
        """Goals of the outputs that samples alone do not decide."""
        return {
            k: self._build_goal(output)
            for k, output in enumerate(self.outputs)
            if not all(map(self._is_sampled, output.terms))
        }

    def _build_goal(self, output: Output) -> Goal:
        return Goal(self.machine, output.terms, (), None if self._true else len(self.rows.angles))

    @cached_property
    def _true_goals(self) -> list[Goal]:
        """Goals of all outputs, which have the slopes of true measures."""
        return [
            self._goals[k] if k in self._goals else self._build_goal(o)
            for k, o in enumerate(self.outputs)
        ]

    def slopes(self, point: Array) -> tuple[Array, Array]:
        """Return outputs (k,) at a point (n,) and their exact slopes (k, n).

        Raises ComputationError without them.
        """
        values, slopes = self.gradients(np.asarray(point, dtype=float)[None], 1)
        if np.isnan(values).any():
            raise ComputationError(self.find_reason(point))
        return values[0], slopes[0]

    def find_reason(self, point: Array) -> str:
        """Return why a point (n,) has no outputs: what the walk of the machine alone says."""
        response = open_response(self.machine)
        try:
            at = response.at_data(self.data(np.asarray(point, dtype=float)[None])[0])
            response.check(response.values(at, self.rows.angles), self.rows.angles)
            x = np.asarray(point, dtype=float) * self.machine.scale
            for goal in self._goals.values():
                goal.evaluate(x)
                if self.machine.motion is not None:
                    goal.slope(x)
        except ComputationError as error:
            return error.message
        averages = [
            output.name
            for output in self.outputs
            if any(term.kind in AVERAGES for term in output.terms)
        ]
        return (
            f"{self.machine.name}: a turn does not end in the state in which it began: it has "
            f"no {averages[0]}"
        )

    def curves(self, keys: Sequence[str], points: Array) -> Mapping[str, Array]:
        """Return quantities by key over a turn, (m, n) each, at points (m, inputs), and the angles
        `phi_deg` (n,); of what moves freely over times `t_s` (n,).
        """
        quantities = [self.machine.find_quantity(key) for key in keys]
        if (motion := self.machine.motion) is not None:
            response = open_response(self.machine, [quantity.name for quantity in quantities])
            phi = np.append(self.rows.angles, self.machine.turn)
            moved = [response.values(response.at_data(d), phi) for d in self.data(points)]
            columns = zip(keys, np.transpose(moved, (1, 0, 2)), quantities, strict=True)
            by_key = {key: rows / quantity.factor for key, rows, quantity in columns}
            return by_key | {"t_s": phi / self.machine.turn * motion.span}
        rows = MachineRows(
            self.machine,
            [quantity.name for quantity in quantities],
            len(self.rows.angles),
            compared=False,
        )
        samples = rows.evaluate(
            self.data(points), lambda block: block.samples.reshape(-1, block.samples.shape[2])
        )
        failed = np.isnan(samples).any(axis=1)
        if failed.any():
            raise ComputationError(self.find_reason(points[np.flatnonzero(failed)[0]]))
        samples = samples.reshape(len(points), len(quantities), -1).transpose(1, 0, 2)
        samples = np.tile(samples, len(rows.angles) // samples.shape[2])
        curves = {
            key: row / quantity.factor
            for key, row, quantity in zip(keys, samples, quantities, strict=True)
        }
        return curves | {"phi_deg": np.degrees(rows.angles)}


def _evaluate(goal: Goal, x: Array, with_slope: bool = False) -> tuple[float, Array | float]:
    """Return a goal at a design (n,) and, if it is asked for, its slope (n,); NaN without a
    cycle.
    """
    try:
        return goal.evaluate(x), goal.slope(x) if with_slope else np.nan
    except ComputationError:
        return np.nan, np.nan


def _read_measure(measures: Array, term: CycleTerm) -> Array:
    """Return the measure (m,) of a term, or of the size of its quantity, of the measures (m, k) of
    the quantity.
    """
    if term.size and term.kind == "max":
        return np.maximum(measures[:, KINDS.index("max")], -measures[:, KINDS.index("min")])
    return np.asarray(measures[:, KINDS.index(term.kind)])


CHUNK = 10_000
"""Designs between two reports of progress."""


@dataclass(frozen=True)
class OutputBatch:
    """Outputs by name of many designs, (m, k), each in the unit that its name ends in; NaN without
    a cycle.

    `gradient` has the derivatives in the design [1/SI], None if they were not asked for: of each
    output, (m, k, p), or, where none was named, of the objective, (m, p).
    """

    names: tuple[str, ...]
    values: Array
    gradient: Array | None = None

    def __getitem__(self, name: str) -> Array:
        """Return an output (m,) by its name."""
        return np.asarray(self.values[:, self.names.index(name)])

    @property
    def objective(self) -> Array:
        """The objective (m,) of the machine's file, in the unit of its sum."""
        return self[OBJECTIVE]

    def to_frame(self) -> DataFrame:
        """Return a table of pandas, a row for each design.

        Raises InputError if pandas is missing.
        """
        return build_frame(dict(zip(self.names, self.values.T, strict=True)))

    def _repr_html_(self) -> str:
        ends = (np.nanmin(self.values, axis=0), np.nanmax(self.values, axis=0))
        title = f"{len(self.values)} designs"
        return format_table(title, ("", "least", "largest"), zip(self.names, *ends, strict=True))


def evaluate_many(
    stated: Machine | HasMachine,
    designs: Array,
    samples: int | None = None,
    progress: Listener | None = None,
    threads: int | None = None,
    *,
    gradients: bool = False,
    outputs: Sequence[str] = (),
) -> OutputBatch:
    """Return outputs of a machine at designs (m, p) of its moved values [SI], with their
    `gradients` if they are asked for.

    Outputs are those of `planter sweep`, over `samples` of a cycle or true; without names it is the
    objective of the file, over the samples of the file if it has some. `progress` receives the
    number of evaluated designs. Beyond the result only some chunks are in memory, whatever m is.
    Raises InputError for an output that the machine does not have, or a machine without moved
    values; CallError for designs of another shape.
    """
    machine = to_machine(stated)
    if not machine.moved:
        hint = 'give it [bounds], or choose some by machine.with_moved({"values.r_mm": (40, 60)})'
        raise InputError(f"{machine.source}: no values are to be varied; {hint}")
    if np.ndim(designs) != 2 or np.shape(designs)[1] != len(machine.moved):
        raise CallError(
            f"designs have the shape (m, {len(machine.moved)}), and were given as "
            f"{np.shape(designs)}"
        )
    if not outputs and machine.sampling != "refined":
        samples = samples or machine.sampling
    names = tuple(outputs) or ((OBJECTIVE,) if machine.objective else ())
    check_outputs(machine, names)
    sampled = SampledOutputs(machine, machine.moved_paths, names, samples)
    count = threads or os.cpu_count() or 1
    values = np.empty((len(designs), len(names)))
    slopes = np.empty((*values.shape, len(machine.moved))) if gradients else None
    phase = ProgressPhase("evaluate", "design", len(designs), progress)
    for start in range(0, len(designs), CHUNK):
        part = slice(start, start + CHUNK)
        points = np.array(designs[part], dtype=float) / machine.scale
        if slopes is None:
            values[part] = sampled.evaluated(points, count)
        else:
            values[part], chunk = sampled.gradients(points, count)
            slopes[part] = chunk / machine.scale
        phase.report(start + len(points))
    if slopes is not None and not outputs:
        slopes = slopes[:, 0]
    return OutputBatch(names, values, slopes)


class CycleObjective:
    """The objective of a machine's file over samples of a cycle, with exact derivatives; designs x
    are (p,) of its moved values in SI.

    Extremes stay at their samples, which are those of the file if `samples` is None. Functions are
    compiled at the first use and stored in the user's cache; without a compiler evaluation is
    slower. Threads may share an object: each has separate memory. Raises ComputationError for a
    design without a finite objective, CallError for one of another shape or not finite.
    """

    def __init__(self, stated: Machine | HasMachine, samples: int | None = None) -> None:
        self.stated, self.machine = stated, to_machine(stated)
        self.samples = samples or self.machine.objective_samples
        paths = self.machine.moved_paths
        self._outputs = SampledOutputs(self.machine, paths, [OBJECTIVE], self.samples)
        self._values, self._slopes = self._outputs.find_row_cycles()
        if self._slopes is None:
            self._outputs.rows.compile()
            self._outputs.rows.compile_slopes(1)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickling saves: a copy has memory and compiled functions of its own."""
        return CycleObjective, (self.stated, self.samples)

    @property
    def way(self) -> str:
        """Backend that evaluates a cycle: `lanes`, or the fastest available one of the others."""
        return self._outputs.rows.find_slopes(1).kernel.way

    @property
    def angles(self) -> Array:
        """The samples [rad] that differ: a half turn of them where both halves are the same."""
        return sample_angles(self.samples, self.machine.period, self.machine.turn)

    def value(self, x: Array) -> float:
        """Return the objective at a design, in the unit of its sum."""
        self._check(x)
        if self._values is not None:
            return float(self._run(self._values, x).outputs[0])
        return float(self._outputs.slopes(x / self.machine.scale)[0][0])

    def gradient(self, x: Array) -> tuple[float, Array]:
        """Return the objective at a design and its gradient (p,) [1/SI]."""
        self._check(x)
        if self._slopes is not None:
            memory = self._run(self._slopes, x)
            return float(memory.outputs[0]), memory.gradients[0].copy()
        values, slopes = self._outputs.slopes(x / self.machine.scale)
        return float(values[0]), slopes[0] / self.machine.scale

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (p, p) [1/SI2] at a design."""
        self._check(x)
        return find_hessian(self._goal.objective, x)

    @cached_property
    def _goal(self) -> Goal:
        return Goal(self.machine, self._outputs.outputs[0].terms, (), self.samples)

    def _run(self, cycles: Cycles, x: Array) -> Memory:
        memory = cycles.run_row(self.machine.build_data(x))
        if memory is None:
            raise ComputationError(f"{self.machine.name}: no finite objective at {list(x)}")
        return memory

    def _check(self, x: Array) -> None:
        if np.shape(x) != self.machine.design.shape:
            raise CallError(
                f"expected the shape {self.machine.design.shape}, and was given {np.shape(x)}"
            )
        if not np.isfinite(x).all():
            raise CallError(f"a design must be finite, and was given as {list(x)}")


def check_outputs(machine: Machine, names: Sequence[str]) -> None:
    """Raise InputError for an unknown output of a machine, with names that are close, and for no
    names.
    """
    if not names:
        example = next(iter(list_outputs(machine)))
        raise InputError(
            f"{machine.source}: outputs is empty: name at least one, such as {example}"
        )
    for name in names:
        find_output(machine, name, f"{machine.source}: output")
