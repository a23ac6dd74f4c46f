"""The presentation of `planter sweep`: ranges of the outputs, figures, and lists of inputs and
outputs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from planter.report import files
from planter.report.html import Folded, Items, Keys, Section, Table, Text
from planter.report.labels import count_things, format_cell, format_label
from planter.report.presentation import ResultPresentation, tabulate_inputs
from planter.rows.sweeps.figures import (
    MOST_KINDS,
    SweepData,
    draw_envelope,
    draw_map,
    list_numeric_inputs,
)
from planter.rows.sweeps.results import SweepFound, Varied
from planter.rows.sweeps.sweep import Rows, Sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_FIGURES = 12
"""Maximum number of outputs with figures."""
MOST_ROWS = 5_000_000
"""Number of rows up to which figures are drawn."""
ALONG_INPUTS = (
    f"Along each input: a value without a result is a gap. Of several texts the first {MOST_KINDS} "
    "are drawn."
)
OVER_TWO_INPUTS = (
    "Over two inputs: mean over all other inputs, empty where no row has a result; random rows one "
    "by one."
)


def present_sweep(sweep: Sweep, result: SweepFound, rows: Rows) -> ResultPresentation:
    """Return the presentation: plan, range of each output, figures of `rows`, and the machines."""
    plan, reused = (
        sweep.plan,
        f", {count_things(result.resumed, 'chunk')} reused" if result.resumed else "",
    )
    return ResultPresentation(
        title=f"Sweep: {plan.name}",
        conclusion=(
            f"{count_things(result.rows, 'row')} in {result.seconds:.3g} s, "
            f"{count_things(result.workers, 'worker') if result.workers else 'no workers'}{reused}."
        ),
        record=result,
        sections=list(_list_sections(sweep, result)),
        figures=lambda: dict(_draw(sweep, rows)),
        captions=dict.fromkeys(map(_name_envelope, rows.outputs), ALONG_INPUTS)
        | dict.fromkeys(_list_maps(sweep), OVER_TWO_INPUTS),
        details=partial(_list_machines, sweep),
        summary_parts={"plan": plan.model_dump(mode="json", by_alias=True, exclude_none=True)},
        provenance=_provenance(sweep),
    )


def _list_sections(sweep: Sweep, result: SweepFound) -> Iterator[Section]:
    plan, resolved = sweep.plan, sweep.machines[0]
    machines = ", ".join(plan.machine)
    keys = Keys(
        {"machine": machines, "scheme": plan.scheme, "seed": plan.seed, "hash": result.hash}
    )
    values = [(format_label(name), format_cell(axis.table)) for name, axis in sweep.inputs.items()]
    description = [Text(plan.description)] if plan.description else []
    yield Section("Plan", [*description, keys, Table(("input", "values"), values)])
    ranges = [
        (
            format_label(name),
            extent.min,
            extent.mean,
            extent.max,
            extent.missing,
            resolved.describe_output(name, "output")[1],
        )
        for name, extent in result.envelope.items()
    ]
    ends = [
        (f"{end} {format_label(name)}", format_cell(point))
        for name, extent in result.envelope.items()
        for end, point in (("minimum", extent.min_at), ("maximum", extent.max_at))
        if point is not None
    ]
    yield Section(
        "Envelope",
        [
            Table(
                ("output", "min", "mean", "max", "missing", "meaning"),
                ranges,
                page_columns=("meaning",),
            ),
            Folded("inputs of the extremes", [Table(("extreme", "inputs"), ends)]),
        ],
    )


def _list_machines(sweep: Sweep) -> Iterator[Section]:
    for resolved in sweep.machines:
        numbers = Folded("numbers", list(tabulate_inputs(resolved.machine, resolved.inputs)))
        yield Section(f"Machine {resolved.machine.name}", [numbers])


def _provenance(sweep: Sweep) -> dict[str, Any]:
    entries = [
        files.list_provenance(resolved.machine, sweep.plan.seed) for resolved in sweep.machines
    ]
    return entries[0] | {
        key: [entry[key] for entry in entries] for key in ("machine", "machine_sha256", "changed")
    }


def _draw(sweep: Sweep, rows: Rows) -> Iterator[tuple[str, Figure]]:
    if rows.points.rows > MOST_ROWS:
        return
    points, outputs = rows.load_all()
    resolved = sweep.machines[0]
    meanings = {name: resolved.describe_output(name, "output")[1] for name in rows.outputs} | dict(
        resolved.inputs
    )
    data = SweepData(rows.inputs, points, sweep.plan.scheme != "grid", meanings)
    values = dict(zip(rows.outputs, outputs.T, strict=True))
    if data.numbers:
        for output in rows.outputs[:MOST_FIGURES]:
            yield _name_envelope(output), draw_envelope(data, output, values[output])
    for name, (x, y, output) in _list_maps(sweep).items():
        if (figure := draw_map(data, x, y, output, values[output])) is not None:
            yield name, figure


def _name_envelope(output: str) -> str:
    return f"envelope-{output}"


def _list_maps(sweep: Sweep) -> dict[str, tuple[str, str, str]]:
    """Return x, y and output of the maps of a plan by figure name, by default of all outputs over
    two inputs.
    """
    maps = [tuple(map(sweep.find_column, (item.x, item.y, item.output))) for item in sweep.plan.map]
    numbers = list_numeric_inputs(sweep.inputs)
    if not maps and len(numbers) > 1:
        maps = [(*numbers[:2], output) for output in sweep.outputs[:MOST_FIGURES]]
    return {
        f"map-{output}-{_file_part(x)}-{_file_part(y)}": (x, y, output) for x, y, output in maps
    }


def _file_part(path: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in path)


def present_inputs(result: Varied) -> ResultPresentation:
    """Return the presentation of the inputs and outputs of a machine."""
    choices = {name: f"one of {', '.join(texts)}" for name, texts in result.choices.items()}
    return ResultPresentation(
        title=f"Inputs and outputs of {result.machine} for a sweep",
        record=result,
        sections=[
            _list_meanings("Inputs", choices | result.inputs),
            _list_meanings("Outputs", result.outputs),
        ],
    )


def _list_meanings(title: str, meanings: Mapping[str, str]) -> Section:
    return Section(
        title,
        [Text(f"{title}:"), Items([f"{name}: {meaning}" for name, meaning in meanings.items()])],
    )
