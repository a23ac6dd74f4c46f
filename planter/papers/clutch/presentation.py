"""The presentations of the clutch's results: what the terminal prints and the folder contains."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.files import csv_rows, units
from planter.kernels import formulas
from planter.papers.clutch import scene
from planter.papers.clutch.field import FieldEvaluation
from planter.papers.clutch.model import (
    MODELS,
    SIDES,
    VERTICES,
    CrankLinkage,
    collect_values,
    drive_link,
    least_travel,
    load_model,
)
from planter.papers.clutch.results import ContactEngagement, FieldTest
from planter.papers.clutch.rotor import Rotor
from planter.report import files
from planter.report.animation import MotionBlock
from planter.report.html import Items, Section, Table, Text
from planter.report.labels import format_name, load_names
from planter.report.presentation import (
    ModelAssumptions,
    ResultPresentation,
    describe_violations,
    list_record_sections,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.files.record import Record
    from planter.kernels import Array
    from planter.papers.clutch.contact import ContactRun, SwitchingRun
    from planter.papers.clutch.file import ClutchFile
    from planter.papers.clutch.results import (
        ClutchGeometry,
        ClutchLoads,
        FastestSwitching,
        InequalityResult,
        ModalEngagement,
        PolygonFit,
        Sizing,
    )

NAMES = load_names(__package__)
WORDS = NAMES.with_symbols()
CAPTIONS = {
    "turning": "The body in the smallest regular polygon that lets it turn, with the paths of a vertex and of its "
    "centroid.",
    "vertex_path": "Path of a vertex: straight along the sides, an ellipse arc at each corner. Fillets that the path "
    "clears stay inside it; tooth tips take the same path round the shaft.",
    "travel": "Least travel of the sleeve over the axial angle; dots are the levels of the file. The printed formula "
    "counts the radial gap twice.",
    "linkage": (
        "Crank and rod at both ends of the travel, with the pitch circle of the crank gear. Titles: "
        "axial angle or design, rotation of the crank, travel."
    ),
    "load": "Contact load over the link angle while both clutches engage: the sum over all teeth or jaws. The dog "
    "clutch is struck; the Reuleaux clutch slides until its coupling holds, and then has a short "
    "lever for its torque.",
    "speed": "Speed of the output over the link angle, at engagement and at cut-off.",
    "section": (
        "Body, shaft and sleeve as the shaft sees them, at the start and at the end of the "
        "engagement."
    ),
    "sensitivity": (
        "How the largest loads of both clutches move with inputs that the paper does not disclose."
    ),
    "modal": "Load on the tooth in one mode of the shaft, derived and as printed, until it is gone.",
    "effects": "Mean at each level (blue), single runs (grey), mean of all runs (dashed).",
    "comparison": "Mean and standard deviation of each clutch.",
}
ROTATING = (
    "The body over a turn in the smallest regular polygon that lets it, with the path of a vertex."
)
ENGAGING = "Body and teeth as the shaft sees them while the clutch engages, in slow motion."
ANGLES = np.linspace(8, 25, 69)
"""Axial angles of the travel figure [deg]."""
POSES, SHIFTS = 97, 101
"""Rows of poses.csv and of way.csv."""
EVERY = 5
"""Step of the rows of an engagement's table in points of the grid."""
SENTENCES = ("printed", "assumes", "assumptions", "clutch")
"""Keys of a result that the page says elsewhere."""


def present_geometry(clutch: ClutchFile, result: ClutchGeometry) -> ResultPresentation:
    """Return the presentation of a clutch's geometry."""
    values, rotor = collect_values(clutch), Rotor(VERTICES, SIDES, result.R_mm * 1e-3)
    linkages: dict[str, scene.DrawnLinkage] = {}
    for at, row in zip(result.travel, result.linkage, strict=True):
        if row.crank_rotation_deg is not None:
            linkage = CrankLinkage(values["l_AB"], row.rod_mm * 1e-3, values["l_AC"])
            linkages[f"{at.axial_angle_deg:g}°"] = linkage, at.printed_mm * 1e-3, values["r_A"]

    def draw() -> dict[str, Figure]:
        curves: dict[str, Array] = {
            m: 1e3 * np.array([least_travel(values, math.radians(x), m) for x in ANGLES])
            for m in MODELS
        }
        levels = np.array(clutch.levels.axial_angles_deg)
        figures = scene.draw_rotor(rotor, {"limit": rotor.ellipse["fillet"]})
        figures["travel"] = scene.draw_travels(ANGLES, curves, levels)
        return figures | ({"linkage": scene.draw_linkages(linkages)} if linkages else {})

    return _present(
        f"Geometry of the clutch {clutch.name}",
        result,
        clutch,
        draw,
        rotor,
        conclusion=_conclude(result.conditions),
        tables=lambda: {"poses.csv": _tabulate_poses(rotor, values["a"])},
    )


def present_design(clutch: ClutchFile, result: Sizing) -> ResultPresentation:
    """Return the presentation of a sized clutch."""
    values, linkage = collect_values(clutch), CrankLinkage.from_lengths(result.linkage)
    way = linkage, result.sizes.travel_mm * 1e-3, values["r_A"]
    rotor = Rotor(VERTICES, SIDES, result.sizes.width_mm * 1e-3)

    def draw() -> dict[str, Figure]:
        figures = scene.draw_rotor(rotor, {"limit": rotor.ellipse["fillet"]})
        return {**figures, "linkage": scene.draw_linkages({"sized": way})}

    return _present(
        f"Sizes of the clutch {clutch.name}",
        result,
        clutch,
        draw,
        rotor,
        conclusion=f"{_conclude(result.conditions)} Next is: {result.tightest}.",
        tables=lambda: {"way.csv": _tabulate_way(values["F1"], *way)},
    )


def present_optimisation(clutch: ClutchFile, result: FastestSwitching) -> ResultPresentation:
    """Return the presentation of the fastest switching of a clutch."""
    values, linkages = collect_values(clutch), dict[str, scene.DrawnLinkage]()
    for name, choice in (("file", result.start_design), ("optimum", result.design)):
        travel = least_travel(values, math.radians(choice.axial_angle_deg))
        gear = drive_link(values | {"k": choice.ratio}, 0.0)["r_A"]
        linkages[name] = CrankLinkage.from_lengths(choice), travel, gear
    certificate = result.certificate
    return _present(
        f"Fastest switching of the clutch {clutch.name}",
        result,
        clutch,
        lambda: {"linkage": scene.draw_linkages(linkages)},
        conclusion=f"The travel time falls from {result.start_travel_time_s:.4g} s to "
        f"{result.travel_time_s:.4g} s; "
        f"{certificate.agreeing_starts} of {certificate.starts} starts agree.",
        tables=lambda: {"way.csv": _tabulate_way(values["F1"], *linkages["optimum"])},
        provenance=files.list_provenance(clutch, result.seed),
    )


def present_rotor(rotor: Rotor, result: PolygonFit) -> ResultPresentation:
    """Return the presentation of a Reuleaux polygon in a regular polygon."""
    sample = Rotor(rotor.vertices, rotor.sides, 0.03)
    fillets = {"limit": sample.ellipse["fillet"]} if result.ellipse else {}
    title = f"Reuleaux polygon of {rotor.vertices} vertices in a regular one of {rotor.sides} sides"
    conclusion = f"The body {'is a rotor' if result.exact else 'needs clearance to turn'}."
    draw = partial(scene.draw_rotor, sample, fillets)
    return _present(title, result, None, draw, sample, conclusion=conclusion)


def present_engagement(
    clutch: ClutchFile,
    result: ModalEngagement | ContactEngagement,
    shape: str,
    runs: Mapping[str, SwitchingRun] | None,
) -> ResultPresentation:
    """Return the presentation of an engagement in one mode of the shaft or, if there are `runs`, by
    contact.
    """
    assumptions = result.table().get("assumptions")
    assumptions = assumptions or formulas.load("clutch_beam").sidecar["assumptions"]

    def draw() -> dict[str, Figure]:
        if runs is None or not isinstance(result, ContactEngagement):
            return scene.draw_modal_load(clutch.si, shape)
        loads = {"reuleaux": result.reuleaux.N_max_N, "dog": result.dog.N_max_N}
        return scene.draw_contact(runs, result.sensitivity, loads)

    def animate() -> Iterator[MotionBlock]:
        if runs is not None:
            yield MotionBlock(scene.build_engagement_scene(runs["reuleaux"].engagement), ENGAGING)

    return ResultPresentation(
        title=f"Engagement of the clutch {clutch.name}",
        conclusion=_conclude_engagement(result),
        record=result,
        sections=list(_list_sections(result)),
        document=clutch,
        meanings=NAMES.meanings(clutch.numbers()),
        motions=animate,
        figures=draw,
        captions=CAPTIONS,
        details=lambda: [
            Section("Model", [Text("First principles. It assumes:"), Items(assumptions)])
        ],
        tables=lambda: {
            f"{name}_{way}.csv": _tabulate_run(getattr(run, way))
            for name, run in (runs or {}).items()
            for way in ("engagement", "cut_off")
        },
        comments=files.list_comments(clutch, "clutch"),
    )


def _present(
    title: str,
    result: Record,
    clutch: ClutchFile | None,
    draw: Callable[[], Mapping[str, Figure]],
    rotor: Rotor | None = None,
    **options: Any,
) -> ResultPresentation:
    """Return the presentation of a shape, with the rotating `rotor` if there is one."""
    sidecar = (load_model() if clutch is not None else formulas.load("clutch_rotor")).sidecar
    entries = [entry for vector in load_model().sidecar["vectors"].values() for entry in vector]
    meanings = {
        e["shown"]: e["meaning"]
        for e in entries
        if e.get("shown") and units.display_unit(e["shown"])
    }
    if clutch is not None:
        meanings |= NAMES.meanings(clutch.numbers())
        options["comments"] = files.list_comments(clutch, "clutch")
    if rotor is not None:
        build = partial(scene.build_rotor_scene, rotor, title)
        options["motions"] = lambda: [MotionBlock(build(), ROTATING)]
    assumptions = [*sidecar["assumptions"], *result.table().get("assumes", ())]
    return ResultPresentation(
        title=title,
        record=result,
        sections=list(_list_sections(result)),
        document=clutch,
        model=ModelAssumptions("First principles", assumptions, meanings),
        figures=draw,
        captions=CAPTIONS,
        **options,
    )


def _conclude_engagement(result: ModalEngagement | ContactEngagement) -> str:
    if not isinstance(result, ContactEngagement):
        return f"The largest load at engagement is {result.N_max_N:.4g} N."
    reuleaux, dog = result.reuleaux, result.dog
    parts = [
        _describe_loads(f"The clutch {result.clutch}", reuleaux),
        _describe_loads("The dog clutch", dog),
    ]
    if reuleaux.outcome == "jam":
        parts[0] += (
            f": its teeth overlap the shaft by {result.teeth.coaxial_overlap_mm:.3g} mm with the "
            f"body central"
        )
    if result.N_max_ratio is not None:
        parts.append(f"The largest load is {result.N_max_ratio:.3g} times that of the dog clutch")
    elif "no engagement" not in (reuleaux.outcome, dog.outcome):
        parts.append("A load that stays and one that passes are not compared")
    return ". ".join(parts) + "."


def _describe_loads(name: str, loads: ClutchLoads) -> str:
    if loads.outcome == "no engagement":
        return f"{name} does not engage: its output does not follow the input"
    if loads.outcome == "impact":
        return f"{name} is struck with {loads.N_max_N:.4g} N, of which {loads.N_end_N:.4g} N stay"
    verb = "jams" if loads.outcome == "jam" else "is loaded"
    return f"{name} {verb} with up to {loads.N_max_N:.4g} N, of which {loads.N_end_N:.4g} N stay"


def _conclude(conditions: Sequence[InequalityResult]) -> str:
    violated = [row.condition for row in conditions if not row.holds]
    return describe_violations(violated, len(conditions), "inequality", "; ")


def _list_sections(result: Record) -> Iterator[Section]:
    yield from list_record_sections(result, WORDS, SENTENCES)
    printed: Record | None = getattr(result, "printed", None)
    if printed is not None:
        for section in list_record_sections(printed, WORDS):
            yield Section(f"{section.title}, as printed", section.blocks)


def _tabulate_poses(rotor: Rotor, side: float) -> dict[str, Array]:
    """Return positions of A, B, C and the centroid while C passes a corner, and the overlap with
    the third sides.
    """
    theta = np.linspace(*rotor.passage, POSES)
    places = {f"{name}_mm": 1e3 * values for name, values in rotor.path(theta).items()}
    overlap = 1e3 * load_model()("path", theta=theta, a=side)["e_3"]
    return {"theta_deg": np.degrees(theta), **places, "overlap_mm": overlap}


def _tabulate_way(
    force: float, linkage: CrankLinkage, travel: float, gear: float
) -> dict[str, Array]:
    """Return crank, rod and forces over the travel of the sleeve."""
    shift = np.linspace(0, travel, SHIFTS)
    pose, push = (
        linkage.evaluate(shift),
        load_model()("push", shift=shift, crank=linkage.packed, F1=force, r_A=gear),
    )
    return {
        "shift_mm": 1e3 * shift,
        "crank_angle_deg": np.degrees(pose["crank_angle"]),
        "rod_angle_deg": np.degrees(pose["rod_angle"]),
        "lever_mm": 1e3 * pose["lever"],
        "tooth_force_N": push["tooth_force"],
        "side_force_N": push["side_force"],
    }


def _tabulate_run(run: ContactRun) -> dict[str, Array]:
    """Return time, link angle, sleeve, load and output speed of a motion."""
    from planter.papers.clutch.contact import TRAVEL

    columns = {
        "time_s": run.time,
        "link_deg": run.link_deg,
        "sleeve_mm": 1e3 * run.states[TRAVEL],
        "load_N": run.load,
        "output_rpm": run.speed * 30 / np.pi,
    }
    return {key: column[::EVERY] for key, column in columns.items()}


SHOWN = 5
"""Combinations among the results; prediction.csv has all."""
VARIANCE_HEAD = ("response", "source", "ss", "df", "ms", "F", "p")


def present_field_test(evaluation: FieldEvaluation) -> ResultPresentation:
    """Return the presentation: ranges, analysis of variance, prediction, comparison of clutches."""
    trial, result = evaluation.trial, evaluation.result
    tables = _build_tables(result)
    values = [(name, column.tolist()) for name, column in trial.responses.items()]
    values += [(name, factor.codes.tolist()) for name, factor in trial.factors.items()]
    return ResultPresentation(
        title=f"Field test {result.source}",
        conclusion=_conclude_field_test(result),
        record=result,
        sections=list(_list_field_sections(result, tables)),
        figures=lambda: scene.draw_field_test(evaluation),
        captions=CAPTIONS,
        texts=lambda: {
            f"{name}.csv": csv_rows.format_csv(
                [f"data: {result.source}"], table.head, [_fill_cells(row) for row in table.rows]
            )
            for name, table in tables.items()
        },
        provenance={
            **files.list_versions(),
            "data_sha256": hashlib.sha256(repr(values).encode("utf-8")).hexdigest(),
        },
    )


def _fill_cells(row: object) -> list[object]:
    return ["" if cell is None else cell for cell in row]  # type: ignore[attr-defined]


def _conclude_field_test(result: FieldTest) -> str:
    parts = []
    for response, sources in result.anova.items():
        chances = {name: getattr(row, "p", None) for name, row in sources.items()}
        strong = [name for name, p in chances.items() if p is not None and p < 0.05]
        parts.append(f"{', '.join(strong) or 'none'} on {response}")
    return f"Effects with p < 0.05 in {result.runs} runs: {'; '.join(parts)}."


def _build_tables(result: FieldTest) -> dict[str, Table]:
    """Return the tables by the names of their files."""
    ranges, variances = [], []
    for response, factors in result.range.items():
        for name, means in factors.items():
            ranges += [(response, name, i, k, means.R) for i, k in enumerate(means.k, 1)]
    for response, sources in result.anova.items():
        for name, row in sources.items():
            cells = (getattr(row, key, None) for key in VARIANCE_HEAD[2:])
            variances.append((response, name, *cells))
    factors = next(iter(result.range.values()))
    predicted = [(*row.levels, *row.means.values()) for row in result.prediction]
    tables = {
        "range": Table(("response", "factor", "level", "k", "R"), ranges),
        "anova": Table(VARIANCE_HEAD, variances),
        "prediction": Table((*factors, *result.goals), predicted),
    }
    if result.comparison:
        pairs = [pair.table() for pair in result.comparison]
        rows = [tuple(pair.values()) for pair in pairs]
        tables["comparison"] = Table(tuple(pairs[0]), rows)
    return tables


def _list_field_sections(result: FieldTest, tables: Mapping[str, Table]) -> Iterator[Section]:
    yield Section("Range analysis", [tables["range"]])
    yield Section("Analysis of variance", [tables["anova"]])
    goals = result.goals | {"both": "least mean rank"}
    factors = next(iter(result.range.values()))
    best = [(name, goals[name], *levels) for name, levels in result.best.items()]
    prediction = Table(tables["prediction"].head, tables["prediction"].rows[:SHOWN])
    note = "The prediction adds main effects: interactions are neither predicted nor tested."
    yield Section(
        "Prediction",
        [
            Table(("response", "goal", *factors), best, "Best levels"),
            prediction,
            Text(note, "note"),
        ],
    )
    if "comparison" in tables:
        note = "p: Welch's test of each difference"
        rows = [
            (pair.speed_m_s, format_name(pair.measure), pair.reduction_percent, pair.p_value)
            for pair in result.comparison
        ]
        table = Table(("speed / m/s", "measure", "reduction / %", "p"), rows)
        yield Section("Comparison of clutches", [table, Text(note, "note")])
