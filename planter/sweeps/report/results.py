"""Report folder of `planter sweep`: rows.csv, rows.parquet, summary.json, figures and report.html."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.progress import Listener
from planter.report import bundle, files
from planter.report.folder import renews
from planter.report.html import Block, FigureSvg, Folded, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import flat, label
from planter.sweeps.report.figures import MOST_KINDS, SweepData, draw_envelope, draw_map
from planter.sweeps.results import SweepFound
from planter.sweeps.rows import Rows, write_rows
from planter.sweeps.sweep import Sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.report.bundle import Drawn as Rendered

MOST_FIGURES = 12
"""Maximum number of outputs with figures."""
MOST_ROWS = 5_000_000
"""Number of rows up to which figures are drawn."""


@renews
def write_sweep(out: Path, sweep: Sweep, rows: Rows, result: SweepFound, progress: Listener | None = None) -> None:
    """Write the folder of a sweep. Raises InputError if it cannot be written."""
    folder = files.output_folder(out)
    plan, provenance = sweep.plan, _provenance(sweep)
    comments = [f"sweep: {plan.name}", f"machine: {', '.join(plan.machine)}",
                f"scheme: {plan.scheme}, seed {plan.seed}", f"hash of the numbers: {result.hash}"]  # fmt: skip
    write_rows(folder, rows, comments, progress)
    figures = bundle.drawn(dict(_figures(sweep, rows)), progress) if rows.points.rows <= MOST_ROWS else {}
    table = plan.model_dump(mode="json", by_alias=True, exclude_none=True)
    texts = {
        "summary.json": files.summary_text({**result.table(), "plan": table, "provenance": provenance}),
        "report.html": page(f"Sweep: {plan.name}", list(_sections(sweep, result, figures)), plan.description),
    }
    bundle.write(folder, texts, figures)


def _provenance(sweep: Sweep) -> dict[str, Any]:
    entries = [files.provenance(resolved.machine, sweep.plan.seed) for resolved in sweep.machines]
    return entries[0] | {key: [entry[key] for entry in entries] for key in ("machine", "machine_sha256", "changed")}


def _figures(sweep: Sweep, rows: Rows) -> Iterator[tuple[str, Figure]]:
    points, outputs = rows.load_all()
    data, values = (
        SweepData(rows.inputs, points, sweep.plan.scheme != "grid"),
        dict(zip(rows.outputs, outputs.T, strict=True)),
    )
    names = data.numbers
    for output in rows.outputs[:MOST_FIGURES]:
        if names:
            yield f"envelope-{output}", draw_envelope(data, output, values[output])
    maps = [tuple(map(sweep.find_column, (item.x, item.y, item.output))) for item in sweep.plan.map]
    if not maps and len(names) > 1:
        maps = [(names[0], names[1], output) for output in rows.outputs[:MOST_FIGURES]]
    for x, y, output in maps:
        figure = draw_map(data, x, y, output, values[output])
        if figure is not None:
            yield f"map-{output}-{_file_part(x)}-{_file_part(y)}", figure


def _file_part(path: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in path)


def _sections(sweep: Sweep, result: SweepFound, figures: Mapping[str, Rendered]) -> Iterator[Section]:
    plan = sweep.plan
    yield Section("Sweep", [
        Keys({"machine": ", ".join(plan.machine), "scheme": plan.scheme, "rows": result.rows, "seed": plan.seed,
              "hash of the numbers": result.hash}),
        Table(("input", "values"), [(label(name), flat(axis.table)) for name, axis in sweep.inputs.items()]),
    ])  # fmt: skip
    yield Section("Envelope", list(_envelope(sweep, result)))
    for title, start, note in _FIGURE_SECTIONS:
        blocks: list[Block] = [FigureSvg(item.svg, name) for name, item in figures.items() if name.startswith(start)]
        if blocks:
            yield Section(title, [Text(note, "note"), *blocks])
    for resolved in sweep.machines:
        yield Section(
            f"Machine {resolved.machine.name}", [Folded("numbers", list(inputs(resolved.machine, resolved.inputs)))]
        )
    yield provenance_section(_provenance(sweep))


_FIGURE_SECTIONS = (
    (
        "Along each input",
        "envelope-",
        "A value without a result is a gap. "
        f"Random values are averaged in slices of their range. Of several texts the first {MOST_KINDS} are drawn.",
    ),
    (
        "Over two inputs",
        "map-",
        "Mean over all other inputs; empty where no row has a result. "
        "Random values are averaged in slices of their ranges.",
    ),
)


def _envelope(sweep: Sweep, result: SweepFound) -> Iterator[Block]:
    resolved = sweep.machines[0]
    rows = [
        (label(name), extent.min, extent.mean, extent.max, extent.missing, resolved.describe_output(name, "output")[1])
        for name, extent in result.envelope.items()
    ]
    yield Table(("output", "min", "mean", "max", "missing", "meaning"), rows)
    ends = [
        (f"{end} {label(name)}", flat(point))
        for name, extent in result.envelope.items()
        for end, point in (("minimum", extent.min_at), ("maximum", extent.max_at))
        if point is not None
    ]
    yield Folded("inputs of the extremes", [Table(("extreme", "inputs"), ends)])
