"""Commands for machines that are neither a planting device nor a mechanism's file, by what the engine knows of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from planter.engine.goal import resolve_measure
from planter.engine.machine import Machine, load_machine
from planter.engine.measures import AVERAGES, parse_sum
from planter.engine.response import Response
from planter.engine.sensitivity import compute_sensitivity, move_all
from planter.engine.summary import summarise
from planter.errors import ComputationError, InputError
from planter.kernels import Array
from planter.measured import calibration
from planter.measured import tables as fitted
from planter.measured.calibration import Check
from planter.measured.reading import Columns
from planter.mechanism import tables
from planter.mechanism.options import RPM
from planter.mechanism.periodicity import FLOOR, SHARE, Periodicity
from planter.mechanism.results import AngleValues, Turn
from planter.mechanism.simulation import check_angles, check_samples
from planter.mechanism.turn import describe_quantity
from planter.numerics.angles import TURN
from planter.parallel.task import Means
from planter.terminal.console import Console

MODEL = "exact"


def load(source: str, changes: Mapping[str, float], speed_rpm: float | None) -> Machine:
    """Return the machine of a source, its drive's speed [r/min] set if it is given."""
    machine = load_machine(source, changes)
    if speed_rpm is None:
        return machine
    data = machine.data.copy()
    data[machine.speed] = speed_rpm * RPM
    return machine.with_data(data)


def simulate(machine: Machine, samples: int | None = None, at_deg: Sequence[float] = ()) -> Turn:
    """Return the cycle of a machine in `samples` equal steps, its own without, and its results at angles [deg].

    Raises InputError for a number of samples out of range or an angle that is not finite, ComputationError where
    something is not finite.
    """
    check_samples(samples)
    check_angles(at_deg)
    count = samples or machine.samples
    phi = machine.turn * np.arange(count) / count
    response = Response(machine, [quantity.name for quantity in machine.results])
    point = response.at(machine.design)
    values = response.values(point, phi)
    ends = response.values(point, np.array([machine.turn]))[:, 0]
    changes = _changes(machine, values, ends)
    repeats = Periodicity({}, changes, None if changes else 1)
    at = response.values(point, np.radians(at_deg)) if at_deg else np.empty((len(values), 0))
    results = list(enumerate(machine.results))
    return Turn(
        machine=machine.name,
        samples=count,
        quantities={
            one.key: describe_quantity(one.key, values[i] / one.factor, phi, ends[i] / one.factor, repeats, one.axes)
            for i, one in results
        },
        work={},
        laws=[],
        warnings=[],
        repeats_after_turns=repeats.turns,
        not_repeating=changes,
        at=[
            AngleValues(float(angle), {one.key: float(at[i, k] / one.factor) for i, one in results})
            for k, angle in enumerate(at_deg)
        ]
        or None,
        designer=summarise(machine, changes),
    )


def _changes(machine: Machine, values: Array, ends: Array) -> dict[str, float | None]:
    """Return by how much quantities (m, n) differ after a cycle, whole turns of angles apart, if it is not rounding."""
    changes: dict[str, float | None] = {}
    for quantity, row, end in zip(machine.results, values, ends, strict=True):
        change = end - row[0]
        change -= TURN * round(change / TURN) if quantity.unit == "rad" else 0.0
        largest = 1.0 if quantity.unit == "rad" else float(np.abs(row).max())
        if abs(change) > max(SHARE * largest, FLOOR):
            changes[quantity.key] = abs(float(change / quantity.factor))
    return changes


def run_simulate(
    console: Console, machine: Machine, samples: int | None, at_deg: Sequence[float], out: Path | None
) -> None:
    """Simulate and print."""
    _refuse_out(machine, out)
    cycle = simulate(machine, samples, at_deg)
    console.result(cycle, lambda: tables.turn(console, cycle))


def run_sensitivity(
    console: Console, machine: Machine, least: str | None, samples: int | None, all_values: bool, out: Path | None
) -> None:
    """Compute the sensitivity of a sum and print it."""
    _refuse_out(machine, out)
    check_samples(samples)
    if least is None:
        raise InputError(f"{machine.source}: it has no objective of its kind: give one by --least, as range NAME")
    if not (machine.moved or all_values):
        raise InputError(f"{machine.source}: it has no bounds; ask for all values by --all")
    measures = [resolve_measure(machine, measure) for measure in parse_sum(least)]
    averaged = {machine.find_quantity(one.name).key for one in measures if one.kind in AVERAGES}
    if changed := averaged & simulate(machine, samples).not_repeating.keys():
        raise ComputationError(f"{machine.name}: {min(changed)} does not end a cycle as it began it: it has no mean")
    found = compute_sensitivity(move_all(machine) if all_values else machine, measures, samples)
    console.result(found, lambda: tables.show_sensitivity(console, found))


def run_calibrate(
    console: Console, build: Callable[[], Machine], data: Path, columns: Columns,
    bounds: Mapping[str, tuple[float, float]], quantity: str | None, check: Check | None, seed: int,
    means: Means, out: Path | None,
) -> None:  # fmt: skip
    """Fit values to a measured curve and print them; pickles can be made of `build`."""
    machine = build()
    _refuse_out(machine, out)
    if quantity is None:
        known = ", ".join(one.key for one in machine.results)
        raise InputError(f"--quantity must name what was measured: it must be one of {known}")
    found = calibration.calibrate(
        {MODEL: build}, data, columns, bounds, quantity, None, check, seed, console.progress, means
    )  # fmt: skip
    for warning in found.result.warnings:
        console.say(f"planter: warning: {warning}")
    console.result(found.result, lambda: fitted.measured(console, found.result))


def _refuse_out(machine: Machine, out: Path | None) -> None:
    if out is not None:
        raise InputError(
            f"--out does not apply to {machine.name}: its own command writes its files; --json prints this result"
        )
