"""The presentation of toothed gears: what the terminal prints and the folder contains."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.gears.geometry.pitch_curves import RACK
from planter.gears.parts import GearPart, build_part_files
from planter.gears.results import (
    Friction,
    FrictionCurves,
    GearCut,
    GearsFound,
    IncompleteCut,
    Intermittent,
    LooseTurn,
    Scaled,
    StageCut,
)
from planter.progress import Listener
from planter.report import files
from planter.report.animation import MotionBlock
from planter.report.folder import renews_files
from planter.report.html import Block, Cell, Items, KeyFigure, Keys, Section, Table, Text
from planter.report.labels import clean_zero, count_things, format_label
from planter.report.presentation import ResultPresentation
from planter.report.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTIONS = {
    "assembly": "All gears in their mounting positions, pitch curves dashed.",
    "mesh": "Teeth about the pitch point at four positions of a period, with their contacts.",
    "teeth": (
        "Contact ratio of every pair of teeth; margin against undercut of both flanks and "
        "top land of each tooth."
    ),
    "play": (
        "Lost motion of the mate to either side and of both, the gap of the outlines as polygons, "
        "and the error of transmission at every contact, without play."
    ),
    "dwell": "Locking arcs and the adjacent teeth, about the line of centres.",
    "loose": (
        "How many flanks touch over a turn, and how far the driven gear can turn from its law, the "
        "driving gear fixed: behind the law and ahead of it."
    ),
    "lands": (
        "Margin against undercut of both flanks and top land of each tooth, as the rack "
        "leaves them."
    ),
    "friction": (
        "What friction of the teeth adds over a turn to the forces in the joints, to the motor's "
        "torque M_L and to the power lost at both meshes of side 1: by the paper's convention, and "
        "against the sliding."
    ),
}
FRICTION_HEAD = ("friction", "without", "convention", "sliding", "nearest", "farthest", "at most")
OVERLAP_ROUNDING = 1e-9
"""Overlap of polygons [mm2] that is rounding."""
_GEAR_HEAD = ("gear", "teeth", "margin (tooth)", "top land / mm (tooth)", "area / mm2")


def present_gears(result: GearsFound) -> ResultPresentation:
    """Return the presentation of a set of gears, without figures and files."""
    sections = [
        Section(
            "Rack",
            [
                _list_keys(
                    result,
                    "pressure_angle_deg",
                    "addendum",
                    "clearance",
                    "backlash_mm",
                    "centre_error_mm",
                    "process",
                )
            ],
        )
    ]
    sections += [_describe_stage(stage, result.centre_error_mm) for stage in result.stages]
    if result.intermittent:
        sections += _describe_intermittent(result.intermittent)
    if result.scaled:
        blocks = list(_describe_scaling(result.scaled))
        sections.append(Section("Effect of the scaling", blocks, detail=True))
    if result.friction:
        blocks = _describe_friction(result.friction)
        sections.append(Section("Friction of the teeth over a turn", blocks, detail=True))
    if result.files:
        text = Text(f"{count_things(len(result.files), 'file')} written.")
        sections.append(Section("Files", [text], detail=True))
    prefixes = ("", *(f"stage{stage.stage}_" for stage in result.stages))
    return ResultPresentation(
        title=f"Gears of {result.machine}",
        record=result,
        conclusion=_conclude(result),
        failures=_list_failures(result),
        key_figures=list(_list_key_figures(result)),
        sections=sections,
        captions={
            f"{prefix}{name}": caption for prefix in prefixes for name, caption in CAPTIONS.items()
        },
        details=lambda: [
            Section("Geometry", [Text("The geometry assumes:"), Items(RACK.sidecar["assumptions"])])
        ],
    )


def _list_failures(result: GearsFound) -> list[str]:
    """Return what keeps the gears from running: undercut, teeth that overlap, contact that ends."""
    failures = []
    for stage in result.stages:
        names = " and ".join(gear.name for gear in stage.gears)
        if stage.contact_ratio.min < 1:
            ratio = f"{stage.contact_ratio.min:.3f}"
            failures.append(f"Fails: the contact ratio of {names} falls to {ratio}, below 1.")
        if stage.overlap_mm2 > OVERLAP_ROUNDING:
            overlap = f"{stage.overlap_mm2:.3g} mm2"
            failures.append(f"Fails: teeth of {names} overlap by up to {overlap}.")
    undercut = [gear for stage in result.stages for gear in stage.gears if gear.undercut]
    if undercut:
        names = ", ".join(f"{gear.name} on {len(gear.undercut)} flanks" for gear in undercut)
        failures.append(f"Fails: undercut: {names}.")
    return failures


def _conclude(result: GearsFound) -> str:
    """Return the least contact ratio, and that neither undercut nor overlap is there, if so."""
    gears = [gear for stage in result.stages for gear in stage.gears]
    if not gears:
        return f"{result.machine} has an intermittent pair of gears."
    ratio = min(stage.contact_ratio.min for stage in result.stages)
    parts = [f"The contact ratio is at least {ratio:.3f}"]
    if not any(gear.undercut for gear in gears):
        parts.append(f"none of {len(gears)} gears is undercut")
    if max(stage.overlap_mm2 for stage in result.stages) <= OVERLAP_ROUNDING:
        parts.append("no teeth overlap")
    turns = [
        f" The {first.name} turns {stage.z[1] / stage.z[0]:.6g} times in a turn of the "
        f"{second.name}."
        for stage in result.stages
        for first, second in [stage.gears]
        if stage.z[0] != stage.z[1]
    ]
    return f"{'; '.join(parts)}.{''.join(turns)}"


def _list_key_figures(result: GearsFound) -> Iterator[KeyFigure]:
    gears = [gear for stage in result.stages for gear in stage.gears]
    if gears:
        pairs = ", ".join("/".join(map(str, stage.z)) for stage in result.stages)
        yield KeyFigure(pairs, "", "teeth of the pairs")
        ratio = min(stage.contact_ratio.min for stage in result.stages)
        yield KeyFigure(f"{ratio:.3f}", "", "least contact ratio")
        margin = min(gears, key=lambda gear: gear.margin)
        yield KeyFigure(
            f"{margin.margin:.3f}".replace("-", "\N{MINUS SIGN}"),
            "",
            f"least margin against undercut, {margin.name}",
        )


def _list_keys(record: object, *keys: str) -> Keys:
    return Keys({format_label(key): getattr(record, key) for key in keys})


def _describe_stage(stage: StageCut, centre_error_mm: float) -> Section:
    lost_motions = {
        "lost motion, one side / deg": stage.lost_motion_deg,
        "lost motion, both sides / deg": stage.lost_motion_total_deg,
        "axes farther apart, contact ratio": stage.farther_contact_ratio,
        "axes farther apart, lost motion, one side / deg": stage.farther_lost_motion_deg,
        "axes farther apart, lost motion, both sides / deg": stage.farther_total_deg,
    }
    blocks: list[Block] = [
        _list_keys(stage, "module_mm", "scale", "centre_distance_mm"),
        Table(
            ("gear", "undercut flanks", *_GEAR_HEAD[1:], "root radius / mm", "keyway / deg"),
            [
                (
                    name,
                    len(gear.undercut),
                    *measures,
                    gear.root_radius_min_mm,
                    gear.keyway_phase_deg,
                )
                for gear, (name, *measures) in zip(
                    stage.gears, _list_gears(stage.gears), strict=True
                )
            ],
            page_columns=("area / mm2", "root radius / mm"),
        ),
        Table(
            ("mesh", "least", "largest"),
            _clean_rows(
                [
                    *_list_mesh(stage),
                    ("gap of flanks / mm", stage.gap_mm.min, stage.gap_mm.max),
                    ("gap of polygons / mm", stage.polygon_gap_mm.min, stage.polygon_gap_mm.max),
                    ("overlap of polygons / mm2", None, stage.overlap_mm2),
                    ("penetration of polygons / modules", None, stage.penetration_modules),
                    *(
                        (name, extent.min, extent.max)
                        for name, extent in lost_motions.items()
                        if extent is not None
                    ),
                ]
            ),
        ),
        Text(
            "Lost motion: turn of the second gear, the first gear fixed, from the central "
            "position to contact on one "
            "side, and from contact on one side to contact on the other.",
            "note",
        ),
    ]
    if centre_error_mm and stage.farther_contact_ratio is None:
        blocks.append(
            Text(f"With the axes {centre_error_mm:g} mm farther apart the teeth lose contact.")
        )
    undercut = [
        (gear.name, flank.tooth, flank.flank, flank.margin)
        for gear in stage.gears
        for flank in gear.undercut
    ]
    if undercut:
        blocks.append(Table(("gear", "tooth", "flank", "margin"), undercut, "Undercut flanks"))
    return Section(f"Pair {stage.stage}: {stage.gears[0].name} and {stage.gears[1].name}", blocks)


def _list_gears(gears: Iterable[GearCut | IncompleteCut]) -> list[tuple[Cell, ...]]:
    """Return rows under `_GEAR_HEAD`."""
    return [
        (
            gear.name,
            gear.teeth,
            f"{gear.margin:.4g} ({gear.margin_tooth})",
            f"{gear.top_land_mm:.4g} ({gear.top_land_tooth})",
            gear.area_mm2,
        )
        for gear in gears
    ]


MeshRow = tuple[str, float | None, float | None]
"""A measure of a mesh with its least and largest value."""


def _clean_rows(rows: Iterable[MeshRow]) -> list[MeshRow]:
    """Return rows in which zeros stand for rounding errors."""
    return [(name, clean_zero(lower), clean_zero(upper)) for name, lower, upper in rows]


def _list_mesh(pair: StageCut | Intermittent) -> list[MeshRow]:
    ratio, angle = pair.contact_ratio, pair.pressure_angle_deg
    return [
        ("contact ratio", ratio.min, ratio.max),
        ("contact ratio, mean", ratio.mean, ratio.mean),
        ("pressure angle / deg", angle.min, angle.max),
        ("error of transmission / rad", None, pair.transmission_error_rad),
        ("sliding per rotation rate / mm", None, pair.sliding_max_mm),
    ]


def _describe_intermittent(pair: Intermittent) -> Iterator[Section]:
    first, second = pair.gears
    yield Section(
        f"Pair: {first.name} and {second.name}",
        [
            _list_keys(pair, "z", "pitches", "module_mm", "centre_distance_mm", "toothed_arc_mm"),
            Table(_GEAR_HEAD, _list_gears(pair.gears)),
            Table(
                ("mesh", "least", "largest"),
                [
                    *_list_mesh(pair),
                    ("overlap of polygons over the teeth / mm2", None, pair.overlap_mm2),
                    ("overlap of polygons in the dwell / mm2", None, pair.dwell_overlap_mm2),
                ],
            ),
        ],
    )
    yield Section(
        "Dwell",
        [
            Text(
                f"While the {second.name} rests, over {pair.dwell_deg:.4g} deg of the "
                f"{first.name}, locking arcs "
                f"hold it: of {pair.locking_radius_mm:.5g} mm in radius, {pair.apart_mm:.3g} mm "
                f"apart. They remove "
                "teeth next to the dwell; the phase of the teeth minimises the angle without drive."
            ),
            Table(
                ("ends of the dwell", "after it", "before it"),
                [
                    ("pitch radius of the driving gear / mm", *pair.end_radii_mm),
                    ("horn in the arc / deg", *pair.horns_deg),
                    ("without drive / deg", *pair.undriven_deg),
                    ("best phase for this side only / deg", *pair.undriven_least_deg),
                    ("without braking flanks / deg", *pair.unheld_deg),
                ],
            ),
            _tabulate_loose_motion(
                pair.loose,
                "Rotation of the driven gear, the driving gear fixed; a dash if nothing limits it",
            ),
            *(
                []
                if pair.farther_loose is None
                else [
                    _tabulate_loose_motion(
                        pair.farther_loose, "The same with the axes farther apart"
                    )
                ]
            ),
        ],
    )


def _tabulate_loose_motion(turn: LooseTurn, caption: str) -> Table:
    parts = {
        "after the dwell": turn.after_dwell,
        "driven and braked": turn.driven,
        "before the dwell": turn.before_dwell,
        "in the dwell": turn.dwell,
    }
    rows = [(name, motion.behind_deg, motion.ahead_deg) for name, motion in parts.items()]
    return Table(("loose motion", "behind the law / deg", "ahead of it / deg"), rows, caption)


def _describe_friction(friction: Friction) -> list[Block]:
    turns = (
        friction.without,
        friction.convention,
        friction.sliding,
        friction.nearest,
        friction.farthest,
    )

    def row(label: str, values: Iterable[float], bound: float | None = None) -> tuple[Cell, ...]:
        return label, *values, bound

    rows = [
        *(
            row(f"{name} largest / N", (turn.largest_N[name] for turn in turns), bound)
            for name, bound in friction.at_most_N.items()
        ),
        *(
            row(f"{name} rms / N", (turn.rms_N[name] for turn in turns))
            for name in friction.at_most_N
        ),
        row("torque largest / Nm", (turn.torque_Nm.max for turn in turns)),
        row("motor, work / J", (turn.motor_work_J for turn in turns)),
        *(
            row(f"lost, {place} / J", (turn.lost_J[place] for turn in turns))
            for place in friction.without.lost_J
        ),
        *(
            row(f"efficiency, mesh {stage + 1}", (turn.efficiency[stage] for turn in turns))
            for stage in range(len(friction.pairs))
        ),
    ]
    text = (
        f"Angle of friction {friction.friction_angle_deg:.4g} deg, pressure angle "
        f"{friction.pressure_angle_deg:.4g} "
        "deg. By the paper's convention friction acts at the pitch point, outwards, and does no "
        "work; teeth that slide "
        "rub in their contacts along the flanks, against the sliding. The pairs that are in "
        "contact at once bear the "
        "same, or the one nearest to the pitch point or farthest from it bears all; no sharing "
        "makes a force larger "
        f"than the last column. The support force changes by {friction.support_changed_N:.2g} N "
        f"at most, so that the "
        f"objective, {friction.objective:.6g}, does not depend on friction."
    )
    return [Text(text), Table(FRICTION_HEAD, rows)]


def _describe_scaling(scaled: Scaled) -> Iterator[Block]:
    yield Text(
        f"Scaled to the module, the path of the tip moves by up to {scaled.tip_moved_max_mm:.4g} "
        f"mm."
    )
    if scaled.broken is not None:
        before, after = (
            ", ".join(names or ()) or "none" for names in (scaled.broken_before, scaled.broken)
        )
        yield Text(f"Requirements violated as designed: {before}; as scaled: {after}.")
    yield Keys(scaled.design)


@renews_files
def write_gears(
    out: Path,
    result: GearsFound,
    parts: Sequence[GearPart],
    provenance: Mapping[str, Any],
    figures: Mapping[str, Figure],
    scenes: Iterable[Scene],
    friction: FrictionCurves | None = None,
    progress: Listener | None = None,
) -> GearsFound:
    """Write drawings, solids, tables, figures, report.html and summary.json; return the result with
    their paths.

    Raises InputError if the folder cannot be written, or if solids need a package that is not
    installed.
    """
    contents = dict(build_part_files(parts))
    curves = {"friction.csv": friction.columns()} if friction else {}
    folder = files.output_folder(out)
    result = replace(result, files=[str(folder / name) for name in (*contents, *curves)])
    presentation = replace(
        present_gears(result),
        motions=lambda: [MotionBlock(scene) for scene in scenes],
        figures=lambda: figures,
        tables=lambda: curves,
        comments=[
            f"machine: {result.machine}",
            "angles stand close to each other on both sides of every jump",
        ],
        texts=lambda: contents,
        provenance=provenance,
    )
    presentation.write(out, progress)
    return result
