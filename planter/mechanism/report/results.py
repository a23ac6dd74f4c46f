"""What `planter turn` and `planter move` write."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from planter.engine.machine import Machine
from planter.engine.sensitivity import SensitivityFound
from planter.engine.shown import describe_directions, sensitivity_sentences, sensitivity_tables, summary_tables
from planter.files import units
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import Model
from planter.mechanism.motion import Motion
from planter.mechanism.optimisation import Found
from planter.mechanism.report import optimum_file, page
from planter.mechanism.report.figures import Course
from planter.mechanism.report.scene import scene
from planter.mechanism.results import Held, Optimum
from planter.mechanism.tables import CHANGED_START, unit_with_axes
from planter.mechanism.turn import Turn, turn
from planter.progress import Listener
from planter.report.html import Block, Items, Keys, Section, Table, Text
from planter.report.labels import label
from planter.report.proof import describe_proof

ONE_SIDED = "Extremes are true ones, not those of samples; where a quantity jumps, those of either side."


def write_turn(out: Path, found: Turn, progress: Listener | None = None) -> None:
    """Write a turn: every quantity, works, laws. Raises InputError for a folder that it cannot write."""
    told = [*_turn(found), *_limits(found.result.holds or ())]
    _write_cycle(out, f"A turn of {found.machine.name}", found, found.result.table(), told, progress)


def _write_cycle(
    out: Path, title: str, cycle: Turn, table: Mapping[str, Any], told: Iterable[Section], progress: Listener | None,
    more: Mapping[str, str] = MappingProxyType({}),
) -> None:  # fmt: skip
    course = Course.from_cycle(cycle)
    seen = scene(title, course, cycle.seconds, cycle.columns, cycle.places) if cycle.places else None
    page.write(out, title, page.describe_owner(cycle.machine), table, told, cycle.columns, course, progress, seen, more)


def write_motion(out: Path, found: Motion, machine: MechanismFile, progress: Listener | None = None) -> None:
    """A free motion: every quantity, energy, the state of rest. Raises InputError as `write_turn`."""
    course = Course(found.times, "time / s", turn=False)
    title = f"Motion of {machine.name}"
    seen = scene(title, course, found.result.until_s, found.columns, found.places)
    file = page.describe_free(machine)
    page.write(out, title, file, found.result.table(), _motion(found), found.columns, course, progress, seen)


def write_optimum(out: Path, found: Found, progress: Listener | None = None) -> None:
    """An optimum: what moved, the turn it makes, and a file of it. Raises InputError as `write_turn`."""
    best = turn(Model(found.machine))
    told = [*_optimum(found.result), *_limits(found.result.holds), *_turn(best)]
    more = {"optimum.toml": optimum_file.text(found)}
    _write_cycle(out, f"Optimum of {found.machine.name}", best, found.result.table(), told, progress, more)


def write_sensitivity(out: Path, found: SensitivityFound, machine: Machine) -> None:
    """A sensitivity: gradient and combinations. Raises InputError as `write_turn`."""
    title = f"Sensitivity of {machine.name}"
    page.write_tables(out, title, machine, found.table(), sensitivity_sections(found))


def sensitivity_sections(found: SensitivityFound) -> Iterator[Section]:
    """Yield the gradient, and which combinations matter."""
    tables = [Table(one.head, one.rows, one.title) for one in sensitivity_tables(found)]
    sentences = [Text(sentence) for sentence in sensitivity_sentences(found)]
    yield Section("Gradient", [Text(f"Of {found.least}."), *tables[:1]])
    yield Section("What matters", [*sentences, *tables[1:]])


def _optimum(found: Optimum) -> Iterator[Section]:
    change = f"{found.start_objective:.6g} to {found.objective:.6g}"
    rows = [(label(key), found.start_design[key], value) for key, value in found.design.items()]
    blocks: list[Block] = [Text(f"Least {found.least}: {change}."), Table(("quantity", "before", "optimum"), rows)]
    yield Section("Optimum", blocks)
    proof = found.certificate
    yield Section("Certificate", [Keys({
        "residual of the optimality conditions": proof.kkt_residual,
        "starts that agree": f"{proof.agreeing_starts} of {proof.starts}",
        "bounds that bind": ", ".join(proof.active_bounds) or "none",
        **{f"price of {one.limit_on} per {one.unit or 'unit'}": one.multiplier for one in proof.active_limits},
        "samples of the turn": found.samples,
    })])  # fmt: skip
    effective, count = found.effective_parameters, len(found.design)
    yield Section("What matters", [Text(line) for line in describe_directions(effective, count, found.insensitive)])
    if found.front:
        points = [(point.range, point.variance, *point.design.values()) for point in found.front]
        head = ("range", "variance", *map(label, found.design))
        yield Section("Front of range and variance", [Table(head, points)])
    if found.proof is not None:
        yield Section("Proof", list(describe_proof(found.proof.table())))


def _limits(holds: Sequence[Held]) -> Iterator[Section]:
    if holds:
        rows = [(one.limit_on, one.value, one.active, one.met) for one in holds]
        yield Section("Limits", [Table(("limit", "value", "binds", "satisfied"), rows)])


def _turn(found: Turn) -> Iterator[Section]:
    if told := found.result.warnings:
        yield Section("Warnings", [Items([f"{w.message} ({w.name})" for w in told], "warning")])
    meanings = {quantity.key: quantity.meaning for quantity in found.machine.results}
    rows = [
        (key, meanings[key], unit_with_axes(q), q.min, q.min_deg, q.max, q.max_deg, q.mean, q.rms)
        for key, q in found.result.quantities.items()
    ]
    head = ("quantity", "meaning", "unit", "min", "at / deg", "max", "at / deg", "mean", "rms")
    yield Section("Turn", [Table(head, rows)])
    if found.result.work:
        yield Section("Work of a turn", [_keys(found.result.work)])
    if found.result.designer is not None:
        blocks = [Table(one.head, one.rows, one.title) for one in summary_tables(found.result.designer)]
        yield Section("Designer's summary", [*blocks, Text(ONE_SIDED, "note")])
    if at := found.result.at:
        angles = [f"{one.angle_deg:.6g} deg" for one in at]
        cells: list[list[str | float]] = [
            [key, units.unit(key), *(one.quantities[key] for one in at)] for key in found.result.quantities
        ]
        yield Section("At single angles", [Table(("quantity", "unit", *angles), cells)])
    if found.result.laws:
        laws = [(law.law, law.violation, law.unit) for law in found.result.laws]
        yield Section("Laws", [Table(("law", "largest violation", "unit"), laws)])


def _motion(found: Motion) -> Iterator[Section]:
    result = found.result
    rows = [(key, found.meanings[key], unit_with_axes(q), q.min, q.max, q.last) for key, q in result.quantities.items()]
    yield Section("Motion", [Table(("quantity", "meaning", "unit", "min", "max", "last"), rows)])
    if result.changed_start:
        changed = [(one.quantity, one.unit, one.stated, one.used) for one in result.changed_start]
        yield Section("Start", [Text(f"{CHANGED_START}.", "warning"),
                                Table(("quantity", "unit", "stated", "used"), changed)])  # fmt: skip
    yield Section("Energy", [_keys(result.energy.table())])
    if result.equilibrium is not None and result.eigenvalues_per_s is not None:
        values = Table(("real / 1/s", "imaginary / 1/s"), result.eigenvalues_per_s)
        yield Section("State of rest", [_keys(result.equilibrium), values])


def _keys(values: Mapping[str, float | None]) -> Keys:
    return Keys({label(key): value for key, value in values.items()})
