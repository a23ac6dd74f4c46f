"""A turn and a motion of a mechanism as tables on the screen."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

from planter import safe_text
from planter.engine.drive import DriveResult
from planter.engine.sensitivity import SensitivityFound
from planter.engine.tables import (
    describe_directions,
    drive_tables,
    driven_quantities,
    round_mean,
    sensitivity_sentences,
    sensitivity_tables,
    summary_tables,
)
from planter.files import units
from planter.mechanism.results import Course, Held, MachineValidation, Motion, Optimum, Quantity, Turn, Warned
from planter.optimise.proof.results import GlobalBound
from planter.report.labels import name
from planter.terminal.console import Console

HEAD = ("quantity", "min", "at", "max", "at", "mean", "rms", "unit")
WIDTH = 80
"""Columns of a terminal that sentences fit in."""
CHANGED_START = "The constraints do not allow the stated start; the nearest that they allow is used"


def turn(console: Console, found: Turn) -> None:
    """Quantities, works and laws."""
    rows = [
        (
            name(key),
            q.min,
            f"{q.min_deg:g}",
            q.max,
            f"{q.max_deg:g}",
            round_mean(q.mean, q.rms),
            q.rms,
            unit_with_axes(q),
        )
        for key, q in found.quantities.items()
    ]
    console.table(f"{found.machine}: a turn in {found.samples} samples", HEAD, rows)
    if found.work:
        _values(console, "Work of a turn", found.work)
    if found.at:
        head = ("quantity", *(f"at {one.angle_deg:g} deg" for one in found.at), "unit")
        rows_at = ((name(key), *(one.quantities[key] for one in found.at), units.unit(key)) for key in found.quantities)
        console.table("At single angles", head, rows_at)
    if found.designer is not None:
        for table in summary_tables(found.designer):
            console.table(table.title, table.head, table.rows)
    _limits(console, found.holds or ())
    _warnings(console, found.warnings)
    laws = [(law.law, law.violation, law.unit) for law in found.laws]
    if laws:
        console.table("Laws, and the largest violation", ("law", "violation", "unit"), laws)


def show_validation(console: Console, source: str, found: MachineValidation) -> None:
    """Print that a file is valid, whether its limits are satisfied, and warnings."""
    design = f"; design values {', '.join(found.design)}" if found.design else ""
    print(textwrap.fill(safe_text.sanitise_line(f"{source}: valid{design}"), WIDTH))
    _limits(console, found.holds or ())
    _warnings(console, found.warnings)


def show_sensitivity(console: Console, found: SensitivityFound) -> None:
    """Print the gradient, and which combinations matter."""
    for table in sensitivity_tables(found):
        console.table(table.title, table.head, table.rows)
    for sentence in sensitivity_sentences(found):
        print(textwrap.fill(sentence, WIDTH))


def show_drive(console: Console, found: DriveResult) -> None:
    """Print motor, speed and forces."""
    for table in (*drive_tables(found), driven_quantities(found)):
        console.table(table.title, table.head, table.rows)


def unit_with_axes(quantity: Quantity | Course) -> str:
    """A unit, and by whose axes a component is told if they are not the world's."""
    return quantity.unit if quantity.axes is None else f"{quantity.unit}, axes of {quantity.axes}"


def motion(console: Console, found: Motion) -> None:
    """Quantities, energy, constraints, and the state of rest if it was asked for."""
    rows = [(name(key), q.min, q.max, q.last, unit_with_axes(q)) for key, q in found.quantities.items()]
    console.table(
        f"{found.machine}: motion until {found.until_s:g} s", ("quantity", "min", "max", "last", "unit"), rows
    )
    if found.changed_start:
        changed = [(name(one.quantity), one.stated, one.used, one.unit) for one in found.changed_start]
        console.table(CHANGED_START, ("quantity", "stated", "used", "unit"), changed)
    _values(console, "Energy of weights, springs and motion", found.energy.table())
    if found.redundant_constraints:
        names = ", ".join(found.dependent_constraints)
        console.say(f"{found.redundant_constraints} too many of the constraints {names}, which follow from one another")
    if found.undetermined_actions:
        names = ", ".join(found.undetermined_actions)
        console.say(f"Held twice, so that the balances do not determine them: {names}")
    if found.equilibrium is not None and found.eigenvalues_per_s is not None:
        _values(console, "State of rest", found.equilibrium)
        console.table("Eigenvalues there", ("real / 1/s", "imaginary / 1/s"), found.eigenvalues_per_s)


def optimum(console: Console, found: Optimum) -> None:
    """What moved, the limits, how sure it is."""
    change = f"{found.start_objective:.6g} to {found.objective:.6g}"
    rows = [(name(k), found.start_design[k], v, units.unit(k)) for k, v in found.design.items()]
    console.table(f"{found.machine}: least {found.least}, {change}", ("quantity", "before", "optimum", "unit"), rows)
    _limits(console, found.holds)
    proof = found.certificate
    console.table("Certificate", ("", "value"), [
        ("residual of the optimality conditions", f"{proof.kkt_residual:.2g}"),
        ("starts that agree", f"{proof.agreeing_starts} of {proof.starts}"),
        ("bounds that bind", ", ".join(proof.active_bounds) or "none"),
        *((f"price of {one.limit_on} per {one.unit or 'unit'}", one.multiplier) for one in proof.active_limits),
        ("samples of the turn", found.samples),
    ])  # fmt: skip
    for sentence in describe_directions(found.effective_parameters, len(found.design), found.insensitive):
        console.say(sentence)
    if found.front:
        console.table("Front of range and variance", ("range", "variance", *map(name, found.design)), [
            (point.range, point.variance, *point.design.values()) for point in found.front
        ])  # fmt: skip
    if found.proof is not None:
        console.say(describe_bound(found.proof))


def describe_bound(proof: GlobalBound) -> str:
    """Return a bound beside the best design that is known, with the gap between them, and what is proved."""
    if proof.lower_bound is None or proof.gap is None:
        return f"{proof.statement} ({proof.boxes} boxes, {proof.seconds:.0f} s)"
    share = f", gap {100 * proof.gap / abs(proof.objective):.3g} %" if proof.objective else ""
    claim = proof.statement[0].upper() + proof.statement[1:]
    return (
        f"No design within the bounds is better than {proof.lower_bound:.9g} over {proof.samples} samples; "
        f"found {proof.objective:.9g}{share} ({proof.boxes} boxes, {proof.seconds:.0f} s). {claim}."
    )


def _limits(console: Console, holds: Sequence[Held]) -> None:
    """Limits with what they are on, and whether they bind or are violated."""
    if holds:
        state = {True: "binds", False: ""}
        rows = [(one.limit_on, one.value, one.limit, state[one.active] if one.met else "violated") for one in holds]
        console.table("Limits", ("limit", "value", "limit", ""), rows)


def _warnings(console: Console, warnings: Sequence[Warned]) -> None:
    if warnings:
        rows = ((one.name, one.angle_deg, one.message) for one in warnings)
        console.table("Warnings", ("name", "at / deg", "what"), rows)


def _values(console: Console, title: str, values: Mapping[str, float | None]) -> None:
    rows = [(name(key), value, units.unit(key)) for key, value in values.items()]
    console.table(title, ("quantity", "value", "unit"), rows)
