"""Page, figures and files of a clutch's shape."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.clutch.geometry import SIDES, VERTICES, CrankLinkage, least_travel
from planter.clutch.model import MODELS, collect_values, load_model
from planter.clutch.report.drawings import build_rotor_scene
from planter.clutch.rotor import Rotor, body_outline, polygon_outline
from planter.files import units
from planter.kernels import formulas
from planter.report import files, style
from planter.report.folder import renews
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import inputs, provenance_section
from planter.report.labels import label
from planter.view.animation import Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from planter.clutch.file import ClutchFile
    from planter.clutch.results import ClutchGeometry, FastestSwitching, PolygonFit, Sizing
    from planter.kernels import Array
    from planter.records import Record

GHOSTS = 4
FRAMES = 60


@style.drawn
def draw_turning(rotor: Rotor) -> Figure:
    """The body at several rotations in the smallest polygon that lets it turn, and what a rotation needs beyond R."""
    figure = style.new_figure(3.6)
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.15])
    _sleeve(left, rotor)
    step = 2 * math.pi / rotor.vertices / (GHOSTS + 1)
    for i in range(GHOSTS, -1, -1):
        x, y = _body(rotor, math.pi / 2 + i * step)
        left.plot(x, y, color=style.FAINT if i else style.BLUE, linewidth=0.7 if i else 1.4)
    orbit = 1e3 * np.array([rotor.tightest(r)[1] for r in np.linspace(0, 2 * math.pi / rotor.vertices, 61)]).T
    left.plot(*orbit, color=style.VERMILION, linewidth=1.0, label="orbit of the centroid")
    left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    style.drawing_board(left)
    rotations = np.linspace(0, 2 * math.pi / rotor.vertices, 181)
    needed = 1e3 * (2 * np.array([rotor.tightest(r)[0] for r in rotations]) / rotor.width - 1)
    right.plot(np.degrees(rotations), needed, color=style.BLUE)
    right.set_xlabel("rotation of the polygon / deg")
    right.set_ylabel("extra clearance needed / (R/1000)")
    right.set_title("clearance error of the polygon (0 = perfect rotor)")
    return figure


def _sleeve(axes: Axes, rotor: Rotor) -> None:
    axes.plot(*(1e3 * polygon_outline(rotor.sides, rotor.smallest_apothem)), color=style.INK, linewidth=1.2)


def _body(rotor: Rotor, rotation: float) -> Array:
    closed = body_outline(rotor, rotation, rotor.tightest(rotation)[1])
    return 1e3 * np.hstack([closed, closed[:, :1]])


@style.drawn
def draw_vertex_path(rotor: Rotor, fillets: Mapping[str, float]) -> Figure:
    """Path of a vertex over a turn with the ellipse of one corner, and that corner with rounded ones [m] inside."""
    figure = style.new_figure(3.6)
    overview, corner = figure.subplots(1, 2)
    theta = np.linspace(*rotor.passage, 61)
    arc = rotor.path(theta)
    x, y = 1e3 * arc["x_C"], 1e3 * arc["y_C"]
    for axes in (overview, corner):
        axes.plot(*(1e3 * polygon_outline(rotor.sides, rotor.width / 2)), color=style.INK, linewidth=0.9)
        axes.plot(*(1e3 * rotor.track()), color=style.BLUE, linewidth=1.0)
        axes.plot(x, y, color=style.VERMILION, linewidth=1.8)
        axes.plot(*_ellipse(rotor), color=style.VERMILION, linewidth=0.7, linestyle=(0, (4, 2)))
    _axes_of(overview, rotor)
    style.drawing_board(overview)
    for index, (name, radius) in enumerate(fillets.items()):
        rounded = 1e3 * polygon_outline(rotor.sides, rotor.width / 2, radius, 40)
        shade = (style.GREEN, style.PURPLE, style.ORANGE)[index % 3]
        corner.plot(*rounded, color=shade, linewidth=1.0, label=f"{name}: {radius / rotor.width:.4f} R")
    reach = 0.1 * 1e3 * rotor.width
    middle = x[len(x) // 2], y[len(y) // 2]
    style.drawing_board(corner)
    corner.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach))
    corner.set_aspect("equal", adjustable="box")
    corner.legend(loc="upper left", frameon=False, fontsize=7)
    overview.set_title("path of a vertex; dashed: its ellipse at one corner")
    corner.set_title("the corner, with fillets inside")
    return figure


def _ellipse(rotor: Rotor) -> Array:
    ellipse, angle = rotor.ellipse, np.linspace(0, 2 * math.pi, 241)
    major = np.array([math.cos(ellipse["axis"]), math.sin(ellipse["axis"])])
    across = np.array([-major[1], major[0]])
    centre = np.array([ellipse["x_E"], ellipse["y_E"]])
    points = np.outer(major, ellipse["s_1"] * np.cos(angle)) + np.outer(across, ellipse["s_2"] * np.sin(angle))
    return 1e3 * (centre[:, None] + points)


def _axes_of(axes: Axes, rotor: Rotor) -> None:
    ellipse = rotor.ellipse
    for size, turn in ((ellipse["s_1"], 0.0), (ellipse["s_2"], math.pi / 2)):
        direction = size * np.array([math.cos(ellipse["axis"] + turn), math.sin(ellipse["axis"] + turn)])
        ends = 1e3 * np.array([[ellipse["x_E"]], [ellipse["y_E"]]]) + 1e3 * np.outer(direction, [-1, 1])
        axes.plot(*ends, color=style.SOFT, linewidth=0.5)
    axes.plot(1e3 * ellipse["x_E"], 1e3 * ellipse["y_E"], "+", color=style.INK, markersize=6)


@style.drawn
def draw_travels(angles_deg: Array, curves: Mapping[str, Array], marks: Sequence[float]) -> Figure:
    """Least travel [mm] over the axial angle, a curve for each model, with the file's levels marked."""
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    ends = []
    for index, (name, curve) in enumerate(curves.items()):
        shade = style.colour(name, index)
        axes.plot(angles_deg, curve, color=shade)
        axes.plot(marks, np.interp(marks, angles_deg, curve), "o", color=shade, markersize=4)
        ends.append((float(curve[-1]), name, shade))
    axes.set_ylim(bottom=0)
    axes.set_xlabel("axial angle / deg")
    axes.set_ylabel("least travel of the sleeve / mm")
    style.label_ends(axes, ends, 0.07)
    return figure


@style.drawn
def draw_linkages(labelled: Mapping[str, tuple[CrankLinkage, float, float]]) -> Figure:
    """Each linkage at both ends of its travel: label -> (linkage, travel [m], pitch radius of the crank gear [m])."""
    figure = style.new_figure(2.6 * len(labelled))
    for axes, (name, (linkage, travel, gear)) in zip(
        figure.subplots(len(labelled), 1, squeeze=False)[:, 0], labelled.items(), strict=True
    ):
        _linkage(axes, linkage, travel, gear)
        turned = math.degrees(linkage.rotation(travel))
        axes.set_title(f"{name}: crank turns {turned:.3g}° for a travel of {1e3 * travel:.3g} mm")
    return figure


def _linkage(axes: Axes, linkage: CrankLinkage, travel: float, gear: float) -> None:
    from matplotlib.patches import Circle, Rectangle

    reach = 1e3 * (linkage.distance + travel)
    axes.plot([0, 1.15 * reach], [0, 0], color=style.FAINT, linewidth=0.8, linestyle=(0, (6, 3)))
    axes.add_patch(Circle((0, 0), 1e3 * gear, fill=False, edgecolor=style.FAINT, linewidth=0.9))
    for name, shift, shade in (("engaged", 0.0, style.BLUE), ("disengaged", travel, style.VERMILION)):
        at = linkage.evaluate(np.array([shift]))
        x, y = 1e3 * at["pin_x"][0], 1e3 * at["pin_y"][0]
        pin = 1e3 * (linkage.distance + shift)
        axes.plot([0, x, pin], [0, y, 0], "o-", color=shade, markersize=3.5, linewidth=1.6, label=name)
        axes.add_patch(Rectangle((pin - 2.5, -1.5), 5, 3, fill=False, edgecolor=shade, linewidth=0.9))
    axes.annotate("A", (0, 0), (-9, -10), textcoords="offset points")
    axes.legend(loc="upper right", frameon=False)
    style.drawing_board(axes, "along the guide / mm", "across / mm")


@style.drawn
def animate_turning(rotor: Rotor, frames: int = FRAMES) -> bytes:
    """The body turning once in the smallest polygon that lets it, as a GIF; a vertex draws its path."""
    from matplotlib.animation import PillowWriter

    figure = style.new_figure(3.4, 3.4)
    axes = figure.subplots()
    _sleeve(axes, rotor)
    (body,) = axes.plot([], [], color=style.BLUE)
    (trail,) = axes.plot([], [], color=style.VERMILION, linewidth=1.0)
    axes.set_axis_off()
    axes.set_aspect("equal")
    limit = 1.05e3 * rotor.smallest_apothem / math.cos(math.pi / rotor.sides)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit))
    rho, tips = float(rotor.support(0.0)[0]), np.empty((2, 0))
    writer = PillowWriter(fps=20)
    with tempfile.TemporaryDirectory(prefix="planter-") as scratch:
        path = Path(scratch) / "turning.gif"
        with writer.saving(figure, str(path), dpi=90):
            for rotation in 2 * math.pi * np.arange(frames) / frames:
                centroid = rotor.tightest(float(rotation))[1]
                tip = 1e3 * (centroid + rho * np.array([math.cos(rotation), math.sin(rotation)]))
                tips = np.column_stack([tips, tip])
                body.set_data(*_body(rotor, float(rotation)))
                trail.set_data(*tips)
                writer.grab_frame()
        return path.read_bytes()


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
        "travel": draw_travels(ANGLES, curves, clutch.levels.axial_angles_deg),
        **({"linkage": draw_linkages(labelled)} if labelled else {}),
    }
    files.write_bytes(folder / "turning.gif", animate_turning(rotor))
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
    plots = {**_shape(rotor, {}), "linkage": draw_linkages({"sized": (linkage, travel, values["r_A"])})}
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
        {"linkage": draw_linkages(labelled)},
    )


@renews
def write_rotor(out: Path, rotor: Rotor, result: PolygonFit) -> None:
    """Write summary.json, figures, turning.gif and report.html. Raises InputError if it cannot."""
    folder = files.output_folder(out)
    sample = Rotor(rotor.vertices, rotor.sides, 0.03)
    plots = _shape(sample, {}) if result.ellipse else {"turning": draw_turning(sample)}
    files.write_bytes(folder / "turning.gif", animate_turning(sample))
    title = f"Reuleaux polygon of {rotor.vertices} vertices in a regular one of {rotor.sides} sides"
    _finish(folder, title, None, result, plots, sample)


def _shape(rotor: Rotor, fillets: Mapping[str, float]) -> dict[str, Figure]:
    limits = {"limit": rotor.ellipse["fillet"], **fillets}
    return {"turning": draw_turning(rotor), "vertex_path": draw_vertex_path(rotor, limits)}


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
