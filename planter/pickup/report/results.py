"""The files that `planter pickup` leaves in a folder: summary, CSV, figures and page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.files import units
from planter.kernels.formulas import load
from planter.pickup import analysis
from planter.pickup.law import MODEL
from planter.pickup.report import figures
from planter.pickup.report.scene import build_pickup_scene
from planter.pickup.tables import GROUPS
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.html import Block, Cell, FigureSvg, Folded, Items, Keys, Section, Table, Text, page
from planter.report.inputs import provenance_section
from planter.report.labels import label
from planter.view.block import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.pickup.analysis import PickupOutcome
    from planter.pickup.file import Pickup
    from planter.pickup.results import Demand, PickupFound, PickupState

STEPS = 720
"""Rows of cycle.csv, path.csv and pitch.csv."""
MOVING = "The pick-up over a turn of its carrier. Thick arcs on the gears lock the arm in the dwell."
CAPTIONS = {
    "path": "Path of the tip with pick and push, and the pick in the frame of a tray's cell. The tray lies where the "
    "pick has the wanted depth; the level line follows from the inclination of the tray box.",
    "pitch_curves": "Pitch curves of the non-circular pair. In the dwell the locking arcs take the place of teeth, "
    "as large as holds the intermediate gear both ways.",
    "contact_ratio": "Contact ratio of the non-circular pair along the teeth (the paper's Fig. 9). The paper's "
    "formulas are lost; these are of the circular gears with the curvature radii at the contact.",
    "tip_motion": "Displacement and speed of the tip (the paper's Fig. 13).",
    "law": "Angle of the arm, slope of it over the carrier's angle, and total ratio; grey: dwell.",
}


def write_pickup_report(out: Path, outcome: PickupOutcome, progress: Listener | None = None) -> None:
    """Writes summary.json, CSV files, figures and report.html, whole or not at all.

    Raises InputError for a folder that it cannot write.
    """
    files.output_folder(out)
    plots = bundle.drawn(_figures(outcome), progress)
    svgs = {name: figure.svg for name, figure in plots.items()}
    title = f"Seedling pick-up {outcome.machine.name}"
    texts = {
        "summary.json": files.summary_text(_summary(outcome)),
        **dict(_tables(outcome)),
        "report.html": page(title, list(_sections(outcome, svgs)), outcome.machine.description),
    }
    bundle.write(out, texts, plots)


def _tables(outcome: PickupOutcome) -> Iterator[tuple[str, str]]:
    """CSV files by their names."""
    comments = list(files.comments(outcome.machine, "pick-up", [f"driven by its {outcome.result.driven_by}"]))
    turn, teeth = analysis.sample_cycle(outcome.train, STEPS), analysis.sample_pitch(outcome.train, STEPS)
    path = {"x_mm": turn["tip_x_mm"], "y_mm": turn["tip_y_mm"]}
    for name, columns in (("cycle.csv", turn), ("pitch.csv", teeth), ("path.csv", path)):
        yield name, files.cycle_csv(name, comments, columns)
    if outcome.redesigned is not None:
        x, y = outcome.redesigned.points.T * 1000
        yield "value_points.csv", files.cycle_csv("value_points.csv", comments, {"x_mm": x, "y_mm": y})


def _summary(outcome: PickupOutcome) -> dict[str, Any]:
    return {
        **outcome.result.table(),
        "assumptions": load(MODEL).sidecar["assumptions"],
        "input": outcome.machine.table(),
        "provenance": files.provenance(outcome.machine),
    }


def _figures(outcome: PickupOutcome) -> dict[str, Figure]:
    moved, train = outcome.redesigned, outcome.train
    before = None if moved is None else moved.points_before
    return {
        "path": figures.draw_path(outcome.machine, train, before),
        "pitch_curves": figures.draw_pitch_curves(train),
        "contact_ratio": figures.draw_contact_ratio(train),
        "tip_motion": figures.draw_motion(train),
        "law": figures.draw_law(train, None if moved is None else moved.start),
    }


def _sections(outcome: PickupOutcome, svgs: Mapping[str, str]) -> Iterator[Section]:
    result = outcome.result
    if result.warnings:
        yield Section("Warnings", [Items([warning.message for warning in result.warnings], "warning")])
    yield Section("Mechanism", list(_mechanism(result)))
    yield Section("Requirements", list(_requirements(result)))
    before = None if outcome.redesigned is None else outcome.redesigned.points_before
    yield Section("Motion", [Motion(build_pickup_scene(outcome.machine, outcome.train, before), MOVING)])
    yield Section("Figures", [FigureSvg(svg, CAPTIONS[name]) for name, svg in svgs.items()])
    if result.at:
        yield Section("At single angles", [_at(result.at)])
    sidecar = load(MODEL).sidecar
    yield Section("Model", [Text(f"{sidecar['title']}. It assumes:"), Items(sidecar["assumptions"])])
    yield Section("Inputs", list(_inputs(outcome.machine)))
    yield provenance_section(files.provenance(outcome.machine))


def _mechanism(result: PickupFound) -> Iterator[Block]:
    table = result.table()
    yield Keys({label(key): value for key, value in table.items() if not isinstance(value, dict | list)})
    for key in GROUPS:
        if table[key]:
            values = {label(name): value for name, value in table[key].items() if not isinstance(value, list)}
            yield Table((label(key), "value"), list(values.items()))
    yield Text(
        "The paper's (14) lacks the factor 1/2: with the printed 44.6 mm the helix angle is the one above, inside the "
        "printed range. The printed contact ratio of the helical pair is 1.9358.",
        "note",
    )


def _requirements(result: PickupFound) -> Iterator[Block]:
    yield _demands(result.requirements, "")
    if result.optimised:
        yield _demands(result.optimised.requirements_before, "before the value points were moved")


def _demands(rows: Sequence[Demand], caption: str) -> Block:
    cells = [(r.name, r.value, r.wanted, r.unit, r.margin, r.holds) for r in rows]
    return Table(("requirement", "value", "wanted", "unit", "margin", "holds"), cells, caption)


def _at(states: Sequence[PickupState]) -> Block:
    rows = [row.table() for row in states]
    head = ("quantity", *(f"{row['t_deg']:.6g} deg" for row in rows))
    keys = [key for key in rows[0] if key not in ("t_deg", "tip_mm")]
    return Table(head, [(label(key), *(row[key] for row in rows)) for key in keys])


def _inputs(machine: Pickup) -> Iterator[Block]:
    by_section: dict[str, list[tuple[Cell, ...]]] = {}
    origins = machine.number_origins()
    for path, value in machine.numbers().items():
        section, _, key = path.partition(".")
        by_section.setdefault(section, []).append((key, value, units.unit(path), origins[path]))
    yield Text("What is not marked as the paper's was chosen by whoever wrote the file.", "note")
    for section, rows in by_section.items():
        yield Folded(section.replace("_", " "), [Table(("key", "value", "unit", "origin"), rows)])
