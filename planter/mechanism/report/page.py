"""What pages of machines that the engine takes share: model, inputs, provenance, and how a folder is written."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from planter.engine.machine import Machine
from planter.files.document import Document
from planter.kernels import Array
from planter.mechanism.file import MechanismFile
from planter.mechanism.report.figures import Course, curves
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.html import FigureSvg, Items, Section, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.view.block import Motion as Moving
from planter.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEN = "Bodies by the points where forces act on them and by their centroids, which is all that the statement says."


class FileDescription(NamedTuple):
    """What a page says of a file: meanings of its values by path, title and source of its model, what this assumes."""

    document: Document
    meanings: Mapping[str, str]
    title: str
    source: str
    assumptions: Sequence[str]


def describe_owner(machine: Machine) -> FileDescription:
    """Return what a page says of the file of a machine that an angle drives."""
    model = machine.documentation
    return FileDescription(machine.document, machine.meanings, model.title, model.reference, machine.assumptions)


def describe_free(file: MechanismFile) -> FileDescription:
    """Return what a page says of the file of a mechanism that moves by itself."""
    sidecar, meanings = file.model.sidecar, {entry["shown"]: entry["meaning"] for entry in file.entries}
    return FileDescription(file, meanings, sidecar["title"], sidecar["source"], sidecar["assumptions"])


def write(
    out: Path, title: str, file: FileDescription, table: Mapping[str, Any], told: Iterable[Section],
    columns: Mapping[str, Array], course: Course, progress: Listener | None, moving: Scene | None,
    more: Mapping[str, str] = MappingProxyType({}),
) -> None:  # fmt: skip
    """Writes summary.json, values.csv, figures and report.html, whole or not at all, and `more` texts by their names.

    `told` are the sections that come first. Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    drawn = bundle.drawn(dict(curves(columns, course)), progress)
    document, provenance = file.document, files.provenance(file.document)
    every = {course.label.replace(" / ", "_"): course.values, **columns}
    motion = [] if moving is None else [Section("Motion", [Moving(moving, SEEN)])]
    figures = Section("Figures", [FigureSvg(figure.svg, "") for figure in drawn.values()])
    texts = {
        "summary.json": files.summary_text({**table, "input": document.table(), "provenance": provenance}),
        "values.csv": files.cycle_csv("values.csv", files.comments(document, "mechanism"), every),
        "report.html": page(title, [*told, *motion, figures, *_end(file, provenance)], document.description),
        **more,
    }
    bundle.write(out, texts, drawn)


def write_tables(out: Path, title: str, machine: Machine, table: Mapping[str, Any], told: Iterable[Section],
                 figures: Mapping[str, Figure] = MappingProxyType({}), texts: Mapping[str, str] = MappingProxyType({}),
                 progress: Listener | None = None) -> None:  # fmt: skip
    """Write summary.json and report.html, with figures by their names and more `texts`.

    Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    drawn = bundle.drawn(dict(figures), progress)
    document, provenance = machine.document, files.provenance(machine.document)
    shown = [Section("Figures", [FigureSvg(figure.svg, "") for figure in drawn.values()])] if drawn else []
    every = {
        "summary.json": files.summary_text({**table, "input": document.table(), "provenance": provenance}),
        "report.html": page(title, [*told, *shown, *_end(describe_owner(machine), provenance)], document.description),
        **texts,
    }
    bundle.write(out, every, drawn)


def _end(file: FileDescription, provenance: Mapping[str, Any]) -> Iterator[Section]:
    assumptions = Text(f"{file.title}, from {file.source}. It assumes:"), Items(file.assumptions)
    yield Section("Model", list(assumptions))
    yield Section("Inputs", list(inputs(file.document, file.meanings, ("turn",))))
    yield provenance_section(provenance)
