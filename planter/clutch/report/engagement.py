"""The files that the command of the clutch's engagement leaves in a folder: summary, CSV, figures and page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.clutch.engage import modal
from planter.clutch.engage.dynamics import TRAVEL
from planter.clutch.report import engagement_figures as figures
from planter.clutch.report import scene
from planter.clutch.results.engagement import ContactEngagement, ModalEngagement
from planter.kernels import formulas
from planter.report import files, style
from planter.report.folder import check, renews
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.view.block import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.clutch.engage.switching import Switching
    from planter.clutch.file import Clutch

Result = Mapping[str, Any]
CAPTIONS = {
    "load": "Contact load over the link angle while both clutches engage: the sum over all teeth or jaws. The dog "
    "clutch is struck; the Reuleaux clutch slides until its coupling holds, and then has a short lever for its torque.",
    "speed": "Speed of the output over the link angle, at engagement and at cut-off.",
    "section": "Body, shaft and sleeve as the shaft sees them, at the start and at the end of the engagement.",
    "ratio": "How the ratio of the largest loads moves with inputs that the paper does not disclose.",
    "modal": "Load on the tooth in one mode of the shaft, derived and as printed, until it is gone.",
}
MOVING = "Body and teeth as the shaft sees them while the clutch engages, many times slower than they are."
EVERY = 5
"""Every how many points of the grid a row of the CSV stands."""


@renews
def write(
    out: Path,
    clutch: Clutch,
    found: ModalEngagement | ContactEngagement,
    shape: str,
    runs: Mapping[str, Switching] | None,
) -> None:
    """Writes summary.json, figures and report.html, of motions also a CSV each. Raises InputError where it cannot."""
    folder, result = files.output_folder(out), found.table()
    drawn: dict[str, Figure] = {}
    if runs is None or isinstance(found, ModalEngagement):
        struck = modal.modal(clutch.si, shape)
        drawn["modal"] = figures.modal_load(struck, modal.printed(struck))
    else:
        check(folder, [f"{name}_{way}.csv" for name in runs for way in ("engagement", "cut_off")])
        _motions(folder, clutch, runs)
        drawn = {
            "load": figures.loads(runs),
            "speed": figures.speeds(runs),
            "section": figures.section(runs["reuleaux"].engagement),
            "ratio": figures.ratios(found.sensitivity, found.N_max_ratio),
        }
    told = files.provenance(clutch)
    files.write_summary(folder / "summary.json", {**result, "input": clutch.table(), "provenance": told})
    place = files.output_folder(folder / "figures")
    saved = {name: style.save(figure, place, name) for name, figure in drawn.items()}
    moving = [] if runs is None else [Motion(scene.engagement(runs["reuleaux"].engagement), MOVING)]
    parts = [
        *_sections(result, saved, moving),
        Section("Inputs", list(inputs(clutch, {}))),
        provenance_section(told),
    ]
    files.write_text(folder / "report.html", page(f"Engagement of the clutch {clutch.name}", parts, clutch.description))


def _motions(folder: Path, clutch: Clutch, runs: Mapping[str, Switching]) -> None:
    """One CSV for each clutch and way: time, link angle, sleeve, load, output speed."""
    comments = list(files.comments(clutch, "clutch"))
    for name, switching in runs.items():
        for way, run in (("engagement", switching.engagement), ("cut_off", switching.cut_off)):
            columns = {
                "time_s": run.time,
                "link_deg": figures.link_deg(run),
                "sleeve_mm": 1e3 * run.states[TRAVEL],
                "load_N": run.load,
                "output_rpm": run.speed * 30 / np.pi,
            }
            rows = {key: column[::EVERY] for key, column in columns.items()}
            files.write_cycle_csv(folder / f"{name}_{way}.csv", comments, rows)


def _sections(result: Result, saved: Mapping[str, str], moving: Sequence[Block]) -> Iterator[Section]:
    groups = {key: value for key, value in result.items() if isinstance(value, Mapping)}
    plain = {label(key): value for key, value in result.items() if not isinstance(value, Mapping | list)}
    tables = [
        Table(
            ("quantity", "value"), [(label(k), v) for k, v in group.items() if not isinstance(v, Mapping)], label(key)
        )
        for key, group in groups.items()
    ]
    yield Section("Results", [Keys(plain), *tables])
    for key in ("sensitivity", "phases"):
        rows = result.get(key)
        if rows:
            yield Section(label(key), [Table([label(k) for k in rows[0]], [tuple(row.values()) for row in rows], "")])
    if moving:
        yield Section("Motion", moving)
    yield Section("Figures", [FigureSvg(svg, CAPTIONS[name]) for name, svg in saved.items()])
    assumed = result.get("assumptions") or model_assumptions()
    yield Section("Model", [Text("First principles. It assumes:"), Items(assumed)])


def model_assumptions() -> list[str]:
    """What the one-mode engagement assumes."""
    found: list[str] = formulas.load("clutch_beam").sidecar["assumptions"]
    return found
