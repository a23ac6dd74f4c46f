"""Files of the clutch's shape: summary, CSV, figures, GIF and page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.clutch.geometry import SIDES, VERTICES, CrankLinkage, least_travel
from planter.clutch.model import MODELS, collect_values, load_model
from planter.clutch.report import shape_figures as figures
from planter.clutch.report.scene import build_rotor_scene
from planter.clutch.rotor import Rotor
from planter.files import units
from planter.kernels import formulas
from planter.report import files, style
from planter.report.folder import renews
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.view.animation import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.clutch.file import ClutchFile
    from planter.clutch.results.shape import ClutchGeometry, FastestSwitching, PolygonFit, Sizing
    from planter.kernels import Array
    from planter.records import Record

Result = Mapping[str, Any]
CAPTIONS = {
    "turning": "The body at five rotations in the smallest regular polygon that lets it turn, with the orbit of its "
    "centroid; and the distance of the sides that each rotation needs beyond the body's width.",
    "vertex_path": "Path of a vertex: straight along the sides, an ellipse arc at each corner. Fillets that the path "
    "clears stay inside it; tooth tips take the same path round the shaft.",
    "travel": "Least travel of the sleeve over the axial angle; dots are the levels of the file. The printed formula "
    "counts the radial gap twice.",
    "linkage": "Crank and rod at both ends of the travel; the circle is the pitch circle of the crank gear.",
}
MOVING = "The body over a turn in the smallest regular polygon that lets it, with the path of a vertex."
ANGLES = np.linspace(8, 25, 69)
"""Axial angles of the travel figure [deg]."""
POSES = 97
WAY = 101


@renews
def write_geometry(out: Path, clutch: ClutchFile, result: ClutchGeometry) -> None:
    """Write summary.json, poses.csv, figures, turning.gif and report.html. Raises InputError if it cannot."""
    folder, values = files.output_folder(out), collect_values(clutch)
    rotor = Rotor(VERTICES, SIDES, result.R_mm * 1e-3)
    _poses(folder, clutch, rotor, values["a"])
    curves: dict[str, Array] = {
        m: 1e3 * np.array([least_travel(values, math.radians(x), m) for x in ANGLES]) for m in MODELS
    }
    labelled = {
        f"axial angle {at.axial_angle_deg:g}°, printed travel": (
            CrankLinkage(values["l_AB"], row.rod_mm * 1e-3, values["l_AC"]), at.printed_mm * 1e-3, values["r_A"]
        )
        for at, row in zip(result.travel, result.linkage, strict=True)
        if row.crank_rotation_deg is not None
    }  # fmt: skip
    plots = {
        **_shape(rotor, {"printed": result.printed.fillet_limit_over_R * rotor.width}),
        "travel": figures.draw_travels(ANGLES, curves, clutch.levels.axial_angles_deg),
        **({"linkage": figures.draw_linkages(labelled)} if labelled else {}),
    }
    files.write_bytes(folder / "turning.gif", figures.animate_turning(rotor))
    _finish(folder, f"Geometry of the clutch {clutch.name}", clutch, result, plots, rotor)


@renews
def write_design(out: Path, clutch: ClutchFile, result: Sizing) -> None:
    """Write summary.json, way.csv, figures and report.html. Raises InputError if it cannot."""
    folder, values = files.output_folder(out), collect_values(clutch)
    rods = result.linkage
    linkage = CrankLinkage(rods.crank_mm * 1e-3, rods.rod_mm * 1e-3, rods.distance_mm * 1e-3)
    travel = result.sizes.travel_mm * 1e-3
    _way(folder, clutch, linkage, travel, values["r_A"])
    rotor = Rotor(VERTICES, SIDES, result.sizes.width_mm * 1e-3)
    plots = {**_shape(rotor, {}), "linkage": figures.draw_linkages({"sized": (linkage, travel, values["r_A"])})}
    _finish(folder, f"Sizes of the clutch {clutch.name}", clutch, result, plots, rotor)


@renews
def write_optimisation(out: Path, clutch: ClutchFile, result: FastestSwitching) -> None:
    """Write summary.json, way.csv, figures and report.html. Raises InputError if it cannot."""
    folder, values = files.output_folder(out), collect_values(clutch)
    labelled: dict[str, tuple[CrankLinkage, float, float]] = {}
    for name, choice in (("file", result.start_design), ("optimum", result.design)):
        linkage = CrankLinkage(choice.crank_mm * 1e-3, choice.rod_mm * 1e-3, choice.distance_mm * 1e-3)
        travel = least_travel(values, math.radians(choice.axial_angle_deg))
        span = values["r_A"] + values["r_D"]
        gear = load_model().at("drive", k=choice.ratio, span=span, gamma=values["gamma"], theta_Amax=0.0)["r_A"]
        labelled[name] = linkage, travel, gear
    _way(folder, clutch, *labelled["optimum"])
    _finish(
        folder,
        f"Fastest switching of the clutch {clutch.name}",
        clutch,
        result,
        {"linkage": figures.draw_linkages(labelled)},
    )


@renews
def write_rotor(out: Path, rotor: Rotor, result: PolygonFit) -> None:
    """Write summary.json, figures, turning.gif and report.html. Raises InputError if it cannot."""
    folder = files.output_folder(out)
    sample = Rotor(rotor.vertices, rotor.sides, 0.03)
    plots = _shape(sample, {}) if result.ellipse else {"turning": figures.draw_turning(sample)}
    files.write_bytes(folder / "turning.gif", figures.animate_turning(sample))
    title = f"Reuleaux polygon of {rotor.vertices} vertices in a regular one of {rotor.sides} sides"
    _finish(folder, title, None, result, plots, sample)


def _shape(rotor: Rotor, fillets: Mapping[str, float]) -> dict[str, Figure]:
    limits = {"limit": rotor.ellipse["fillet"], **fillets}
    return {"turning": figures.draw_turning(rotor), "vertex_path": figures.draw_vertex_path(rotor, limits)}


def _poses(folder: Path, clutch: ClutchFile, rotor: Rotor, side: float) -> None:
    """Places of A, B, C and the centroid while C passes a corner, and the overlap with the third pair of sides."""
    theta = np.linspace(*rotor.passage, POSES)
    at = rotor.path(theta)
    columns = {f"{name}_mm": 1e3 * values for name, values in at.items()}
    columns["overlap_mm"] = 1e3 * load_model()("path", theta=theta, a=side)["e_3"]
    table = {"theta_deg": np.degrees(theta), **columns}
    files.write_cycle_csv(folder / "poses.csv", files.comments(clutch, "clutch"), table)


def _way(folder: Path, clutch: ClutchFile, linkage: CrankLinkage, travel: float, gear: float) -> None:
    """Crank, rod and forces over the way of the sleeve."""
    shift = np.linspace(0, travel, WAY)
    force = collect_values(clutch)["F1"]
    pose, push = linkage.evaluate(shift), load_model()("push", shift=shift, crank=linkage.packed, F1=force, r_A=gear)
    columns: dict[str, Array] = {
        "shift_mm": 1e3 * shift,
        "crank_angle_deg": np.degrees(pose["crank_angle"]),
        "rod_angle_deg": np.degrees(pose["rod_angle"]),
        "lever_mm": 1e3 * pose["lever"],
        "tooth_force_N": push["tooth_force"],
        "side_force_N": push["side_force"],
    }
    files.write_cycle_csv(folder / "way.csv", files.comments(clutch, "clutch"), columns)


def _finish(
    folder: Path, title: str, clutch: ClutchFile | None, result: Record, plots: Mapping[str, Figure],
    rotor: Rotor | None = None,
) -> None:  # fmt: skip
    """Summary, figures and page; on it the `rotor` as it turns, if one is meant."""
    table = result.table()
    equations = load_model() if clutch is not None else formulas.load("clutch_rotor")
    assumptions = [*equations.sidecar["assumptions"], *table.get("assumes", ())]
    summary = table | {"assumptions": assumptions}
    if clutch is not None:
        summary |= {"input": clutch.table(), "provenance": files.provenance(clutch, table.get("seed"))}
    files.write_summary(folder / "summary.json", summary)
    place = files.output_folder(folder / "figures")
    saved = {name: style.save(figure, place, name) for name, figure in plots.items()}
    moving = [] if rotor is None else [Motion(build_rotor_scene(rotor, title), MOVING)]
    parts = list(_sections(clutch, table, saved, moving, assumptions, summary))
    files.write_text(folder / "report.html", page(title, parts, clutch.description if clutch else ""))


def _sections(
    clutch: ClutchFile | None, result: Result, saved: Mapping[str, str], moving: Sequence[Block],
    assumptions: Sequence[str], summary: Result,
) -> Iterator[Section]:  # fmt: skip
    yield Section("Results", list(_results(result)))
    for key in ("conditions", "travel", "linkage", "harmonics"):
        rows = result.get(key) or result.get("rotor", {}).get(key)
        if isinstance(rows, list):
            yield Section(label(key), [_rows(rows)])
    if "printed" in result:
        printed = result["printed"]
        note = Text("The same quantities by the equations as the paper prints them.")
        yield Section("As printed", [note, *_results(printed), _rows(printed["conditions"])])
    if moving:
        yield Section("Motion", moving)
    yield Section("Figures", [FigureSvg(svg, CAPTIONS.get(name, name)) for name, svg in saved.items()])
    yield Section("Model", [Text("First principles. It assumes:"), Items(assumptions)])
    if clutch is not None:
        yield Section("Inputs", list(inputs(clutch, _meanings())))
        yield provenance_section(summary["provenance"])


def _results(result: Result) -> Iterator[Block]:
    """Single values, then groups of them, then lists of words."""
    single = {label(k): v for k, v in result.items() if not isinstance(v, Mapping | list)}
    if single:
        yield Keys(single)
    for key, value in result.items():
        if key in ("printed", "assumes"):
            continue
        if isinstance(value, Mapping):
            rows = [(label(k), _text(v)) for k, v in value.items() if not _table(v)]
            yield Table(("quantity", "value"), rows, label(key))
            for name, entries in ((k, v) for k, v in value.items() if _table(v) and k != "harmonics"):
                yield _rows(entries, label(name))
        elif isinstance(value, list) and not _table(value):
            yield Keys({label(key): _text(value)})


def _table(value: object) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def _text(value: Any) -> Any:
    if isinstance(value, list):
        return "; ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in value) or None
    return value


def _rows(rows: Iterable[Result], caption: str = "") -> Table:
    listed = list(rows)
    return Table([label(key) for key in listed[0]], [tuple(_text(v) for v in row.values()) for row in listed], caption)


def _meanings() -> dict[str, str]:
    entries = [entry for vector in load_model().sidecar["vectors"].values() for entry in vector]
    return {entry["shown"]: entry["meaning"] for entry in entries if entry.get("shown") and units.unit(entry["shown"])}
