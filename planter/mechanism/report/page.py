"""What pages of mechanisms of one's own share: model, inputs, provenance, and how a folder is written."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from planter.kernels import Array
from planter.mechanism.file import MechanismFile
from planter.mechanism.report.figures import Course, curves
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.html import Block, FigureSvg, Items, Section, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.view.block import Motion as Moving
from planter.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEN = "Bodies by the points where forces act on them and by their centroids, which is all that the statement says."


def write(
    out: Path, title: str, machine: MechanismFile, table: Mapping[str, Any], told: Iterable[Section],
    columns: Mapping[str, Array], course: Course, progress: Listener | None, moving: Scene,
    more: Mapping[str, str] = MappingProxyType({}),
) -> None:  # fmt: skip
    """Writes summary.json, values.csv, figures and report.html, whole or not at all, and `more` texts by their names.

    `told` are the sections that come first. Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    drawn = bundle.drawn(dict(curves(columns, course)), progress)
    provenance = files.provenance(machine)
    every = {course.label.replace(" / ", "_"): course.values, **columns}
    motion = Section("Motion", [Moving(moving, SEEN)])
    figures = Section("Figures", [FigureSvg(figure.svg, "") for figure in drawn.values()])
    texts = {
        "summary.json": files.summary_text({**table, "input": machine.table(), "provenance": provenance}),
        "values.csv": files.cycle_csv("values.csv", files.comments(machine, "mechanism"), every),
        "report.html": page(title, [*told, motion, figures, *_end(machine, provenance)], machine.description),
        **more,
    }
    bundle.write(out, texts, drawn)


def write_tables(out: Path, title: str, machine: MechanismFile, table: Mapping[str, Any], told: Iterable[Section],
                 figures: Mapping[str, Figure] = MappingProxyType({}), texts: Mapping[str, str] = MappingProxyType({}),
                 progress: Listener | None = None) -> None:  # fmt: skip
    """Write summary.json and report.html, with figures by their names and more `texts`.

    Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    drawn = bundle.drawn(dict(figures), progress)
    provenance = files.provenance(machine)
    shown = [Section("Figures", [FigureSvg(figure.svg, "") for figure in drawn.values()])] if drawn else []
    every = {
        "summary.json": files.summary_text({**table, "input": machine.table(), "provenance": provenance}),
        "report.html": page(title, [*told, *shown, *_end(machine, provenance)], machine.description),
        **texts,
    }
    bundle.write(out, every, drawn)


def _end(machine: MechanismFile, provenance: Mapping[str, Any]) -> Iterator[Section]:
    yield Section("Model", list(_model(machine)))
    meanings = {entry["shown"]: entry["meaning"] for entry in machine.entries}
    yield Section("Inputs", list(inputs(machine, meanings, ("turn",))))
    yield provenance_section(provenance)


def _model(machine: MechanismFile) -> Iterator[Block]:
    sidecar = machine.model.sidecar
    yield Text(f"{sidecar['title']}, from {sidecar['source']}. It assumes:")
    yield Items(sidecar["assumptions"])
