"""What `planter sweep` writes: rows.csv, rows.parquet, summary.json, figures and report.html."""

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
from planter.sweeps import tidy
from planter.sweeps.report.figures import MOST_KINDS, Drawn, envelope, mapped, pairs
from planter.sweeps.results import SweepFound
from planter.sweeps.rows import Rows
from planter.sweeps.sweep import Sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.report.bundle import Drawn as Rendered

MOST_FIGURES = 12
"""Outputs that are drawn."""
MOST_ROWS = 5_000_000
"""Rows that figures are drawn of: of more the table alone is written."""


@renews
def write(out: Path, sweep: Sweep, rows: Rows, found: SweepFound, progress: Listener | None = None) -> None:
    """Writes the folder of a sweep. Raises InputError for one that it cannot write."""
    folder = files.output_folder(out)
    plan, provenance = sweep.plan, _provenance(sweep)
    comments = [f"sweep: {plan.name}", f"machine: {', '.join(plan.machine)}",
                f"scheme: {plan.scheme}, seed {plan.seed}", f"hash of the numbers: {found.hash}"]  # fmt: skip
    tidy.write(folder, rows, comments, progress)
    drawn = bundle.drawn(dict(_figures(sweep, rows)), progress) if rows.points.rows <= MOST_ROWS else {}
    table = plan.model_dump(mode="json", by_alias=True, exclude_none=True)
    texts = {
        "summary.json": files.summary_text({**found.table(), "plan": table, "provenance": provenance}),
        "report.html": page(f"Sweep: {plan.name}", list(_sections(sweep, found, drawn)), plan.description),
    }
    bundle.write(folder, texts, drawn)


def _provenance(sweep: Sweep) -> dict[str, Any]:
    told = [files.provenance(held.machine, sweep.plan.seed) for held in sweep.machines]
    return told[0] | {key: [one[key] for one in told] for key in ("machine", "machine_sha256", "changed")}


def _figures(sweep: Sweep, rows: Rows) -> Iterator[tuple[str, Figure]]:
    points, outputs = rows.whole()
    drawn, of = Drawn(rows.inputs, points, sweep.plan.scheme != "grid"), dict(zip(rows.outputs, outputs.T, strict=True))
    for name in rows.outputs[:MOST_FIGURES]:
        if drawn.numbers:
            yield f"envelope-{name}", envelope(drawn, name, of[name])
    asked = [(sweep.shown(one.x), sweep.shown(one.y), sweep.shown(one.output)) for one in sweep.plan.map]
    usual = [(*pair, name) for pair in pairs(drawn.numbers) for name in rows.outputs[:MOST_FIGURES]]
    for x, y, name in asked or usual:
        figure = mapped(drawn, x, y, name, of[name])
        if figure is not None:
            yield f"map-{name}-{_plain(x)}-{_plain(y)}", figure


def _plain(path: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in path)


def _sections(sweep: Sweep, found: SweepFound, drawn: Mapping[str, Rendered]) -> Iterator[Section]:
    plan = sweep.plan
    yield Section("Sweep", [
        Keys({"machine": ", ".join(plan.machine), "scheme": plan.scheme, "rows": found.rows, "seed": plan.seed,
              "hash of the numbers": found.hash}),
        Table(("input", "values"), [(label(name), flat(axis.given)) for name, axis in sweep.inputs.items()]),
    ])  # fmt: skip
    yield Section("Envelope", list(_envelope(sweep, found)))
    for title, start, note in _DRAWN:
        figures: list[Block] = [FigureSvg(one.svg, name) for name, one in drawn.items() if name.startswith(start)]
        if figures:
            yield Section(title, [Text(note, "note"), *figures])
    for held in sweep.machines:
        yield Section(f"Machine {held.machine.name}", [Folded("its numbers", list(inputs(held.machine, held.inputs)))])
    yield provenance_section(_provenance(sweep))


_DRAWN = (
    (
        "Along each input",
        "envelope-",
        "A value without a result is a gap. "
        f"Values at random are averaged in slices of their range. Of several texts the first {MOST_KINDS} are drawn.",
    ),
    (
        "Over two inputs",
        "map-",
        "Mean over all other inputs; empty where no row has a result. "
        "Values at random are averaged in slices of their ranges.",
    ),
)


def _envelope(sweep: Sweep, found: SweepFound) -> Iterator[Block]:
    rows = [
        (label(name), one.min, one.mean, one.max, one.missing, sweep.machines[0].describe_output(name, "output")[1])
        for name, one in found.envelope.items()
    ]
    yield Table(("output", "min", "mean", "max", "missing", "meaning"), rows)
    ends = [
        (f"{end} {label(name)}", flat(point))
        for name, one in found.envelope.items()
        for end, point in (("least", one.min_at), ("largest", one.max_at))
        if point is not None
    ]
    yield Folded("where the ends stand", [Table(("end", "inputs"), ends)])
