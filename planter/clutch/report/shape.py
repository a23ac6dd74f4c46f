"""The files that the commands of the clutch's shape leave in a folder: summary, CSV, figures, GIF and page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.clutch.geometry import SIDES, VERTICES
from planter.clutch.geometry import travel as least_travel
from planter.clutch.linkage import Linkage
from planter.clutch.model import MODELS, given, model
from planter.clutch.report import shape_figures as figures
from planter.clutch.report.scene import scene
from planter.clutch.rotor import Rotor
from planter.files import units
from planter.kernels import formulas
from planter.report import files, style
from planter.report.folder import renews
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.view.block import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.clutch.file import Clutch
    from planter.clutch.results.rotor import Fit
    from planter.clutch.results.shape import FastestSwitching, Geometry, Sizing
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
def write_geometry(out: Path, clutch: Clutch, result: Geometry) -> None:
    """Writes summary.json, poses.csv, figures, turning.gif and report.html. Raises InputError where it cannot."""
    folder, values = files.output_folder(out), given(clutch)
    rotor = Rotor(VERTICES, SIDES, result.R_mm * 1e-3)
    _poses(folder, clutch, rotor, values["a"])
    curves: dict[str, Array] = {
        m: 1e3 * np.array([least_travel(values, math.radians(x), m) for x in ANGLES]) for m in MODELS
    }
    own = {
        f"axial angle {at.axial_angle_deg:g}°, printed travel": (
            Linkage(values["l_AB"], row.rod_mm * 1e-3, values["l_AC"]), at.printed_mm * 1e-3, values["r_A"]
        )
        for at, row in zip(result.travel, result.linkage, strict=True)
        if row.crank_rotation_deg is not None
    }  # fmt: skip
    drawn = {
        **_shape(rotor, {"printed": result.printed.fillet_limit_over_R * rotor.width}),
        "travel": figures.travels(ANGLES, curves, clutch.levels.axial_angles_deg),
        **({"linkage": figures.linkages(own)} if own else {}),
    }
    files.write_bytes(folder / "turning.gif", figures.animation(rotor))
    _finish(folder, f"Geometry of the clutch {clutch.name}", clutch, result, drawn, rotor)


@renews
def write_design(out: Path, clutch: Clutch, result: Sizing) -> None:
    """Writes summary.json, way.csv, figures and report.html. Raises InputError where it cannot."""
    folder, values = files.output_folder(out), given(clutch)
    found = result.linkage
    linkage = Linkage(found.crank_mm * 1e-3, found.rod_mm * 1e-3, found.distance_mm * 1e-3)
    travel = result.sizes.travel_mm * 1e-3
    _way(folder, clutch, linkage, travel, values["r_A"])
    rotor = Rotor(VERTICES, SIDES, result.sizes.width_mm * 1e-3)
    drawn = {**_shape(rotor, {}), "linkage": figures.linkages({"sized": (linkage, travel, values["r_A"])})}
    _finish(folder, f"Sizes of the clutch {clutch.name}", clutch, result, drawn, rotor)


@renews
def write_optimisation(out: Path, clutch: Clutch, result: FastestSwitching) -> None:
    """Writes summary.json, way.csv, figures and report.html. Raises InputError where it cannot."""
    folder, values = files.output_folder(out), given(clutch)
    drawn: dict[str, tuple[Linkage, float, float]] = {}
    for name, found in (("file", result.start_design), ("optimum", result.design)):
        linkage = Linkage(found.crank_mm * 1e-3, found.rod_mm * 1e-3, found.distance_mm * 1e-3)
        travel = least_travel(values, math.radians(found.axial_angle_deg))
        span = values["r_A"] + values["r_D"]
        gear = model().at("drive", k=found.ratio, span=span, gamma=values["gamma"], theta_Amax=0.0)["r_A"]
        drawn[name] = linkage, travel, gear
    _way(folder, clutch, *drawn["optimum"])
    _finish(
        folder, f"Fastest switching of the clutch {clutch.name}", clutch, result, {"linkage": figures.linkages(drawn)}
    )


@renews
def write_rotor(out: Path, rotor: Rotor, result: Fit) -> None:
    """Writes summary.json, figures, turning.gif and report.html. Raises InputError where it cannot."""
    folder = files.output_folder(out)
    shown = Rotor(rotor.vertices, rotor.sides, 0.03)
    drawn = _shape(shown, {}) if result.ellipse else {"turning": figures.turning(shown)}
    files.write_bytes(folder / "turning.gif", figures.animation(shown))
    title = f"Reuleaux polygon of {rotor.vertices} vertices in a regular one of {rotor.sides} sides"
    _finish(folder, title, None, result, drawn, shown)


def _shape(rotor: Rotor, fillets: Mapping[str, float]) -> dict[str, Figure]:
    limits = {"limit": rotor.ellipse["fillet"], **fillets}
    return {"turning": figures.turning(rotor), "vertex_path": figures.vertex_path(rotor, limits)}


def _poses(folder: Path, clutch: Clutch, rotor: Rotor, side: float) -> None:
    """Places of A, B, C and the centroid while C passes a corner, and the overlap with the third pair of sides."""
    theta = np.linspace(*rotor.passage, POSES)
    at = rotor.path(theta)
    columns = {f"{name}_mm": 1e3 * values for name, values in at.items()}
    columns["overlap_mm"] = 1e3 * model()("path", theta=theta, a=side)["e_3"]
    table = {"theta_deg": np.degrees(theta), **columns}
    files.write_cycle_csv(folder / "poses.csv", files.comments(clutch, "clutch"), table)


def _way(folder: Path, clutch: Clutch, linkage: Linkage, travel: float, gear: float) -> None:
    """Crank, rod and forces over the way of the sleeve."""
    shift = np.linspace(0, travel, WAY)
    force = given(clutch)["F1"]
    pose, push = linkage.along(shift), model()("push", shift=shift, crank=linkage.packed, F1=force, r_A=gear)
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
    folder: Path, title: str, clutch: Clutch | None, result: Record, drawn: Mapping[str, Figure],
    rotor: Rotor | None = None,
) -> None:  # fmt: skip
    """Summary, figures and page; on it the `rotor` as it turns, if one is meant."""
    table = result.table()
    of = model() if clutch is not None else formulas.load("clutch_rotor")
    assumptions = [*of.sidecar["assumptions"], *table.get("assumes", ())]
    summary = table | {"assumptions": assumptions}
    if clutch is not None:
        summary |= {"input": clutch.table(), "provenance": files.provenance(clutch, table.get("seed"))}
    files.write_summary(folder / "summary.json", summary)
    place = files.output_folder(folder / "figures")
    saved = {name: style.save(figure, place, name) for name, figure in drawn.items()}
    moving = [] if rotor is None else [Motion(scene(rotor, title), MOVING)]
    parts = list(_sections(clutch, table, saved, moving, assumptions, summary))
    files.write_text(folder / "report.html", page(title, parts, clutch.description if clutch else ""))


def _sections(
    clutch: Clutch | None, result: Result, saved: Mapping[str, str], moving: Sequence[Block],
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
    entries = [entry for vector in model().sidecar["vectors"].values() for entry in vector]
    return {entry["shown"]: entry["meaning"] for entry in entries if entry.get("shown") and units.unit(entry["shown"])}
