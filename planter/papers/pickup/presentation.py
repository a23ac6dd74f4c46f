"""The presentation of `planter design pickup`: what the terminal prints and the folder contains."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from planter.kernels.formulas import load
from planter.papers.pickup import analysis
from planter.papers.pickup.law import MODEL
from planter.papers.pickup.scene import build_pickup_scene, draw_figures
from planter.report import files
from planter.report.animation import MotionBlock
from planter.report.html import Section, Text
from planter.report.labels import tabulate_angles
from planter.report.presentation import (
    ModelAssumptions,
    ResultPresentation,
    describe_violations,
    list_record_sections,
)

if TYPE_CHECKING:
    from planter.kernels import Array
    from planter.papers.pickup.analysis import PickupOutcome
    from planter.papers.pickup.results import PickupFound

NAMES = {"group.requirements_before": "Requirements before the redesign"}
MOVING = "The pick-up over a cycle. Thick arcs on the gears lock the arm in the dwell."
STEPS = 720
"""Rows of cycle.csv, path.csv and pitch.csv."""
CAPTIONS = {
    "path": "Path of the tip, with the pick-up where the tip is farthest. The tray lies where the pick has the "
    "required depth.",
    "pitch_curves": "Pitch curves of the non-circular pair. In the dwell the locking arcs replace the teeth; they are "
    "as large as locks the intermediate gear in both directions.",
    "contact_ratio": "Contact ratio of the non-circular pair along the teeth (yu2023, Fig. 9). The published formulas "
    "are missing; these are of the circular gears with the curvature radii at the contact.",
    "tip_motion": "Displacement and speed of the tip (yu2023, Fig. 13).",
    "law": "Angle of the arm, its slope over the carrier's angle, and total ratio; grey: dwell.",
}


def present_pickup(outcome: PickupOutcome) -> ResultPresentation:
    """Return the presentation: mechanism, requirements, redesign of the path, and states at single
    angles.
    """
    result, machine, train = outcome.result, outcome.machine, outcome.train
    moved = outcome.redesigned
    start, points_before = (None, None) if moved is None else (moved.start, moved.points_before)
    driven_by = f"driven by its {result.driven_by}"
    return ResultPresentation(
        title=f"Seedling pick-up {machine.name}, {driven_by}",
        conclusion=describe_violations(
            [row.name for row in result.requirements if not row.holds],
            len(result.requirements),
            "requirement",
        ),
        record=result,
        sections=_list_sections(result),
        document=machine,
        model=ModelAssumptions.from_sidecar(load(MODEL).sidecar),
        motions=lambda: [MotionBlock(build_pickup_scene(machine, train, points_before), MOVING)],
        figures=lambda: draw_figures(machine, train, start, points_before),
        captions=CAPTIONS,
        tables=partial(_tabulate_cycle, outcome),
        comments=files.list_comments(machine, "pick-up", [driven_by]),
    )


def _list_sections(result: PickupFound) -> list[Section]:
    note = (
        "Equation (14) of yu2023 lacks the factor 1/2: with the published 44.6 mm the helix angle "
        "is the one above, inside the published range. The published contact ratio of the helical "
        "pair is 1.9358."
    )
    omitted = ("machine", "driven_by", "at")
    sections = list(list_record_sections(result, NAMES, omitted))
    if result.at:
        states = tabulate_angles([state.table() for state in result.at], "t_deg")
        sections.append(Section("At single angles", [states]))
    return [*sections, Section("Note", [Text(note, "note")])]


def _tabulate_cycle(outcome: PickupOutcome) -> Mapping[str, Mapping[str, Array]]:
    cycle = analysis.sample_cycle(outcome.train, STEPS)
    tables = {
        "cycle.csv": cycle,
        "pitch.csv": analysis.sample_pitch(outcome.train, STEPS),
        "path.csv": {k: cycle[f"tip_{k}"] for k in ("x_mm", "y_mm")},
    }
    if outcome.redesigned is not None:
        x, y = outcome.redesigned.points.T * 1000
        tables["value_points.csv"] = {"x_mm": x, "y_mm": y}
    return tables
