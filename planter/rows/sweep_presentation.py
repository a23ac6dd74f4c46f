"""The presentation of `planter sweep`: ranges of the outputs, figures, and lists of inputs and
outputs.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.kernels import Array, Flags, Integers
from planter.progress import Listener
from planter.report import files, folder, style
from planter.report.html import Folded, Items, Keys, Section, Table, Text
from planter.report.labels import count_things, format_cell, format_label, label_axis
from planter.report.presentation import ResultPresentation, tabulate_inputs
from planter.rows.adapter import ResolvedMachine
from planter.rows.job import open_store, run_job
from planter.rows.points import Axis, Plan
from planter.rows.results import SweepFound, Varied
from planter.rows.sweep import Rows, Sweep, write_rows
from planter.task import AUTO, Means

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PANELS = 3
"""Panels side by side."""
MOST_KINDS = 4
"""Maximum number of texts in a figure."""
MARKED, DRAWN_AS_LINES = 61, 2000
"""Number of values up to which each has a marker, and from which a curve is rasterised."""


@dataclass(frozen=True)
class SweepData:
    """Rows of a sweep: inputs by path, points (m, n); `at_random` if the points are not a grid.

    `meanings` are those of inputs by path and of outputs by name, for the axes.
    """

    inputs: Mapping[str, Axis]
    points: Array
    at_random: bool
    meanings: Mapping[str, str] = field(default_factory=dict)

    def label(self, name: str) -> str:
        """Return the label of an axis: the meaning of an input or an output, or its name, with the
        unit.
        """
        return label_axis(name, self.meanings)

    @property
    def numbers(self) -> list[str]:
        """Names of the numeric inputs with more than one value."""
        return list_numeric_inputs(self.inputs)

    @cached_property
    def kinds(self) -> list[tuple[str, Flags]]:
        """Masks (m,) of the rows of each text of the first input with texts; a mask of all rows
        without one.
        """
        name = next((name for name, axis in self.inputs.items() if axis.texts is not None), None)
        if name is None:
            return [("", np.ones(len(self.points), dtype=bool))]
        column = self.column(name)
        return [(text, column == i) for i, text in enumerate(self.inputs[name].texts or ())]

    def column(self, name: str) -> Array:
        """Return the values (m,) of an input."""
        column: Array = self.points[:, list(self.inputs).index(name)]
        return column


def list_numeric_inputs(inputs: Mapping[str, Axis]) -> list[str]:
    """Return the names of the numeric inputs with more than one value."""
    return [name for name, axis in inputs.items() if axis.texts is None and np.ptp(axis.ends) > 0]


@style.with_style
def draw_envelope(rows: SweepData, output: str, values: Array) -> Figure:
    """Draw an output along each input for each text: computed rows, or mean and extremes over the
    other inputs.
    """
    names, kinds = rows.numbers, rows.kinds[:MOST_KINDS]
    lines, columns = -(-len(names) // PANELS), min(len(names), PANELS)
    figure = style.new_figure(0.3 + 1.9 * lines * len(kinds), min(style.WIDTH, 0.8 + 2.6 * columns))
    panels = figure.subplots(lines * len(kinds), columns, sharey="row", squeeze=False)
    for i, (kind, mask) in enumerate(kinds):
        shared = panels[i * lines : (i + 1) * lines]
        for axes, name in zip(shared.ravel(), names, strict=False):
            has_result = mask & (~np.isnan(values) | (not rows.at_random))
            _draw_curve(axes, rows, name, has_result, values, style.curve_colour(kind, i))
            axes.set_xlabel(rows.label(name))
        for axes in shared[:, 0]:
            axes.set_ylabel(rows.label(output))
        for axes in shared.ravel()[len(names) :]:
            axes.set_visible(False)
        shared[0, 0].set_title(kind)
    style.add_legend(figure, panels[0, 0], 2)
    return figure


def _draw_curve(
    axes: Axes, rows: SweepData, name: str, mask: Flags, values: Array, shade: str
) -> None:
    """Draw the rows of a mask (m,) along an input; a value without a result is a gap."""
    column = rows.column(name)[mask]
    if rows.at_random:
        axes.plot(
            column, values[mask], ".", color=shade, markersize=2, label="rows", rasterized=True
        )
        return
    at, places = np.unique(column, return_inverse=True)
    mean, low, high = _reduce(places.ravel(), values[mask], len(at))
    as_picture = len(at) > DRAWN_AS_LINES
    has_others = len(at) < len(column)
    if has_others:
        axes.fill_between(
            at,
            low,
            high,
            color=shade,
            alpha=0.2,
            linewidth=0,
            label="minimum to maximum",
            rasterized=as_picture,
        )
    word = "mean over the other inputs" if has_others else "computed rows"
    marker = "." if len(at) <= MARKED else ""
    axes.plot(at, mean, color=shade, marker=marker, label=word, rasterized=as_picture)


def draw_map(rows: SweepData, x: str, y: str, output: str, values: Array) -> Figure | None:
    """Draw an output over two inputs, a panel for each text: means of a grid, or random points;
    None if no row has a result.
    """
    return None if np.isnan(values).all() else _draw_panels(rows, x, y, output, values)


@style.with_style
def _draw_panels(rows: SweepData, x: str, y: str, output: str, values: Array) -> Figure:
    kinds = rows.kinds[:MOST_KINDS]
    figure = style.new_figure(2.8, min(style.WIDTH, 0.5 + 3.6 * len(kinds)))
    panels = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axes, (kind, mask) in zip(panels, kinds, strict=True):
        across, up, cell_values = rows.column(x)[mask], rows.column(y)[mask], values[mask]
        if rows.at_random:
            mesh = axes.scatter(across, up, 4, cell_values, cmap="cividis", rasterized=True)
        else:
            places, cells = np.unique(np.column_stack([up, across]), axis=0, return_inverse=True)
            heights, widths = np.unique(places[:, 0]), np.unique(places[:, 1])
            means = _reduce(cells.ravel(), cell_values, len(places))[0]
            grid = means.reshape(len(heights), len(widths))
            mesh = axes.pcolormesh(
                widths, heights, grid, cmap="cividis", shading="nearest", rasterized=True
            )
        axes.set_xlabel(rows.label(x))
        axes.set_title(kind)
        axes.grid(visible=False)
        figure.colorbar(mesh, ax=axes, label=rows.label(output), pad=0.02)
    panels[0].set_ylabel(rows.label(y))
    return figure


def _reduce(places: Integers, values: Array, count: int) -> tuple[Array, Array, Array]:
    """Return mean, minimum and maximum (k,) of values (m,) at places (m,) from 0 on, NaN without
    one.
    """
    valid = ~np.isnan(values)
    places, values = places[valid], values[valid]
    counts = np.bincount(places, minlength=count)
    mean = np.full(count, np.nan)
    total = np.bincount(places, values, count)
    np.divide(total, counts, out=mean, where=counts > 0)
    low, high = np.full(count, np.nan), np.full(count, np.nan)
    np.fmin.at(low, places, values)
    np.fmax.at(high, places, values)
    return mean, low, high


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
    return Section(title, [Items([f"{name}: {meaning}" for name, meaning in meanings.items()])])


STORE_NAME = "sweep.sqlite"
"""The file of finished chunks in the folder of a sweep."""


def compute_sweep(
    plan: Plan, out: Path | None = None, means: Means = AUTO, progress: Listener | None = None
) -> ResultPresentation:
    """Compute the rows of a plan and return their presentation, which is written to the folder
    `out`, if any.

    Finished chunks of the same plan in that folder are reused.

    Raises InputError if the plan does not fit its machines, ComputationError if rows cannot be
    computed, and Interrupted on Ctrl-C, after which the same call resumes.
    """
    started, request = time.perf_counter(), Sweep(plan)
    recipe, points = request.recipe, plan.sample_points
    with folder.renew_files(out):
        path = None if out is None else folder.output_folder(out) / STORE_NAME
        with open_store(path, recipe.question, points.rows, len(request.outputs)) as store:
            outcome = run_job(recipe, store, means, progress)
            rows = Rows(request.inputs, points, request.outputs, store)
            result = SweepFound(
                name=plan.name,
                machine=plan.machine,
                scheme=plan.scheme,
                seed=plan.seed,
                rows=points.rows,
                columns=rows.columns,
                hash=store.digest(),
                resumed=outcome.resumed,
                seconds=time.perf_counter() - started,
                workers=outcome.workers,
                envelope=rows.envelope(),
            )
            presentation = present_sweep(request, result, rows)
            if out is not None:
                scheme = f"scheme: {plan.scheme}, seed {plan.seed}"
                names = [f"sweep: {plan.name}", f"machine: {', '.join(plan.machine)}"]
                write_rows(
                    out, rows, [*names, scheme, f"hash of the numbers: {result.hash}"], progress
                )
                presentation.write(out, progress)
    return presentation


def list_inputs(source: str) -> Varied:
    """List the inputs and outputs of a machine. Raises InputError if there is no such machine."""
    resolved = ResolvedMachine(source)
    choices = {name: list(texts) for name, texts in resolved.adapter.choices.items()}
    return Varied(resolved.machine.name, choices, dict(resolved.inputs), dict(resolved.outputs))
