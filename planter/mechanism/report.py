"""The files that `planter turn` leaves in a folder: summary, CSV, figures and page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from planter.files import units
from planter.mechanism.file import MechanismFile
from planter.mechanism.turn import Turn
from planter.progress import Listener
from planter.report import bundle, files, style
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs
from planter.report.labels import name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_CURVES = 6
"""Curves in one figure."""


def write(out: Path, found: Turn, machine: MechanismFile, progress: Listener | None = None) -> None:
    """Writes summary.json, turn.csv, figures and report.html, whole or not at all.

    Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    drawn = bundle.drawn(dict(_figures(found)), progress)
    provenance = files.provenance(machine)
    heads = [f"mechanism: {found.machine}", f"machine_sha256: {provenance['machine_sha256']}"]
    columns = {f"{found.angle}_deg": found.angles_deg, **found.columns}
    texts = {
        "summary.json": files.summary_text({**found.table(), "input": machine.table(), "provenance": provenance}),
        "turn.csv": files.cycle_csv("turn.csv", heads, columns),
        "report.html": page(f"A turn of {found.machine}", list(_sections(found, machine, drawn)), machine.description),
    }
    bundle.write(out, texts, drawn)


def _figures(found: Turn) -> Iterator[tuple[str, Figure]]:
    """Quantities of one unit together, a few in a figure."""
    by_unit: dict[str, list[str]] = {}
    for key in found.columns:
        by_unit.setdefault(units.unit(key), []).append(key)
    for unit, keys in by_unit.items():
        for first in range(0, len(keys), MOST_CURVES):
            some = keys[first : first + MOST_CURVES]
            word = "".join(c if c.isalnum() else "_" for c in unit or "number")
            yield f"{word}_{first // MOST_CURVES + 1}", _curves(found, unit, some)


@style.drawn
def _curves(found: Turn, unit: str, keys: Sequence[str]) -> Figure:
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    style.over_a_turn(axes)
    axes.set_xlabel(f"{found.angle} / deg")
    axes.set_ylabel(unit or "1")
    ends = []
    for index, key in enumerate(keys):
        shade, values = style.colour(key, index), found.columns[key]
        axes.plot([*found.angles_deg, 360.0], [*values, values[0]], color=shade, linewidth=1.2)
        ends.append((float(values[0]), name(key), shade))
    axes.autoscale_view()
    style.label_ends(axes, ends, 0.07)
    return figure


def _sections(found: Turn, machine: MechanismFile, drawn: Mapping[str, bundle.Drawn]) -> Iterator[Section]:
    yield Section("Turn", [_quantities(found)])
    if found.work:
        yield Section("Work of a turn", [Keys({f"{name(key)} / J": value for key, value in found.work.items()})])
    laws = [(law.law, law.violation, law.unit) for law in found.laws]
    yield Section("Laws", [Table(("law", "largest violation", "unit"), laws)])
    yield Section("Figures", [FigureSvg(figure.svg, f"Quantities in {key}") for key, figure in drawn.items()])
    yield Section("Model", list(_model(machine)))
    meanings = {entry["shown"]: entry["meaning"] for entry in machine.entries}
    yield Section("Inputs", list(inputs(machine, meanings, ("turn",))))
    yield Section("Provenance", [Keys({key: str(value) for key, value in files.provenance(machine).items()})])


def _quantities(found: Turn) -> Block:
    rows = [
        (key, found.meanings[key], q.unit, q.min, q.min_deg, q.max, q.max_deg, q.mean, q.rms)
        for key, q in found.quantities.items()
    ]
    return Table(("quantity", "meaning", "unit", "min", "at / deg", "max", "at / deg", "mean", "rms"), rows)


def _model(machine: MechanismFile) -> Iterator[Block]:
    sidecar = machine.model.sidecar
    yield Text(f"{sidecar['title']}, from {sidecar['source']}. It assumes:")
    yield Items(sidecar["assumptions"])
