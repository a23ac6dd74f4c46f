"""Moving scenes, drawings with symbols and figures of a clutch."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planter.kernels import Array, Integers, formulas
from planter.numerics.arrays import TURN, unit_vector
from planter.papers.clutch.model import SIDES, VERTICES, CrankLinkage, collect_values, load_model
from planter.papers.clutch.rotor import Rotor, body_outline, polygon_outline
from planter.report import style
from planter.report.animation import draw_stills
from planter.report.scene import Body, Curve, Event, Label, Outline, Point, Scene, refine_places
from planter.report.sheet import (
    Angle,
    Length,
    Mark,
    Sheet,
    Spot,
    build_still_scene,
    direction_angle,
)
from planter.report.style import Panel, Points, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.papers.clutch.contact import ContactRun, SwitchingRun
    from planter.papers.clutch.field import FieldEvaluation
    from planter.papers.clutch.file import ClutchFile
    from planter.papers.clutch.modal_engagement import Si
    from planter.papers.clutch.results import ContactLoadSensitivity

DrawnLinkage = tuple[CrankLinkage, float, float]
"""A linkage, its travel [m], and the pitch radius of its crank gear [m]."""
_MM = 1e3
_TURN = np.linspace(0, 2 * np.pi, 181)
_TURNED = 360 / SIDES
"""Direction of X from x: that of the hexagon's next side."""


def draw_sheets(clutch: ClutchFile) -> list[Sheet]:
    """Return all drawings of a clutch."""
    values = collect_values(clutch)
    return [_polygon(values), _teeth(values), _sleeve(values), _linkage(values)]


def _polygon(values: Mapping[str, float]) -> Sheet:
    """The polygon with A and B on their sides, C near the middle of its way past a corner."""
    sizes = load_model().at("polygon", a=values["a"])
    rotor = Rotor(VERTICES, SIDES, sizes["R"])
    theta = sum(rotor.passage) / 2
    at = {name: float(value[0]) * _MM for name, value in rotor.path(np.array([theta])).items()}
    a, b, c, middle = (np.array([at[f"x_{name}"], at[f"y_{name}"]]) for name in "ABCM")
    beta = np.degrees(load_model().at("path", theta=theta, a=values["a"])["beta"])
    body = body_outline(rotor, np.radians(direction_angle(middle, c)), middle / _MM).T * _MM
    hexagon = polygon_outline(SIDES, rotor.width / 2).T[:-1] * _MM
    axis, centre = rotor.ellipse["axis"], np.array([sizes["x_E"], sizes["y_E"]]) * _MM
    major, minor = unit_vector(axis), unit_vector(axis + np.pi / 2)
    oval = centre + _MM * (unit_vector(_TURN).T @ [sizes["s_1"] * major, sizes["s_2"] * minor])
    bodies = (
        Body("hexagon", (Outline(hexagon, "frame"), Outline(oval, "mark"))),
        Body("body", (Outline(body, "body", shade=0),)),
    )
    size = rotor.width * _MM
    marks: list[Mark] = [
        Length(("R",), a, c, 0.35),
        Length(("a",), hexagon[0], hexagon[1], 0.2),
        Length(("b", "circumradius"), middle, c, 0.3),
        Spot(("x_A", "y_A"), a),
        Spot(("X_B", "Y_B"), b),
        Spot(("x_B", "y_B"), b),
        Spot(("x_C", "y_C"), c),
        Spot(("X_C", "Y_C"), c),
        Spot(("x_M", "y_M"), middle),
        Spot(("x_E", "y_E"), centre),
        Spot(("x_F", "y_F"), np.array([sizes["x_F"], sizes["y_F"]]) * _MM),
        Length(("s_1",), centre, centre + _MM * sizes["s_1"] * major, 0.85),
        Length(("s_2",), centre, centre + _MM * sizes["s_2"] * minor, 0.6),
        Angle(("axis",), centre, 0, float(np.degrees(axis)), 0.35 * size),
        Angle(("theta_deg",), a, 0, -float(np.degrees(theta)), 0.3 * size),
        Angle(("beta",), b, _TURNED, -float(beta), 0.3 * size),
        Angle.between(("arc",), c, a, b, 0.6 * size),
    ]
    return Sheet(
        "polygon", "polygon in the hexagonal hole", build_still_scene("polygon", bodies), marks
    )


def _teeth(values: Mapping[str, float]) -> Sheet:
    """Teeth of the body about the output shaft, an axis of a tooth to the right; faces as the least
    tip has them.
    """
    teeth = load_model().at("teeth", flats=values["flats"], r=values["r"])
    tip, root, flats, fillet = (_MM * values[name] for name in ("b1", "b2", "flats", "r"))
    section = polygon_outline(SIDES, flats / 2, fillet).T
    corner = (flats / 2 - fillet) / np.cos(np.pi / SIDES) * unit_vector(np.pi / 2 + np.pi / SIDES)
    circle = unit_vector(_TURN).T
    bodies = (
        Body("shaft", (Outline(section, "body", closed=False, shade=1),)),
        Body("tips and roots", (Outline(tip * circle, "mark"), Outline(root * circle, "mark"))),
    )
    centre, face = np.zeros(2), np.degrees(teeth["xi"]) / 2
    marks: list[Mark] = [
        Length(("flats",), np.array([0.0, -flats / 2]), np.array([0.0, flats / 2]), 0.3),
        Length(("flat_to_flat_mm",), np.array([0.0, -flats / 2]), np.array([0.0, flats / 2]), 0.75),
        Length(("r",), corner, corner * (1 + fillet / float(np.hypot(*corner)))),
        Length(("b1",), centre, np.array([tip, 0.0]), 0.6),
        Length(("b2",), centre, root * unit_vector(0.6), 0.7),
        Angle(
            ("xi",), np.array([_MM * teeth["b1"], 0.0]), -float(face), 2 * float(face), 0.2 * flats
        ),
    ]
    return Sheet("teeth", "teeth on the output shaft", build_still_scene("teeth", bodies), marks)


def _sleeve(values: Mapping[str, float]) -> Sheet:
    """Return the drawing of the tapered body above the axis, and of the sleeve's travel."""
    length, right, way = (_MM * values[name] for name in ("d", "R2", "c"))
    start, travel = np.array([length, right]), np.array([way, 0.0])
    left = right + length * float(np.tan(values["phi"]))
    body = np.array([[0.0, 0.0], [length, 0.0], [length, right], [0.0, left]])
    bodies = (
        Body("body", (Outline(body, "body", shade=0),)),
        Body("cut off", (Outline(body + travel, "before"),)),
    )
    marks: list[Mark] = [
        Length(("d",), np.zeros(2), np.array([length, 0.0])),
        Length(("R1",), np.zeros(2), np.array([0.0, left])),
        Length(("R2",), np.array([length, 0.0]), start),
        Length(("c",), start, start + travel),
        Angle(("phi",), start, 180, -float(np.degrees(values["phi"])), 0.6 * length),
    ]
    scene = build_still_scene("sleeve", bodies)
    return Sheet(
        "sleeve", "tapered body in the sleeve, engaged and by the travel away", scene, marks
    )


def draw_linkage(linkage: CrankLinkage, travel: float, gear: float) -> tuple[Body, ...]:
    """Return crank gear, of a pitch radius, crank and rod, engaged and at the end of a travel [m]."""
    axis = np.zeros(2)
    both = linkage.evaluate(np.array([0.0, travel]))
    first, last = _MM * np.column_stack([both["pin_x"], both["pin_y"]])
    sleeves = [_MM * np.array([linkage.distance + way, 0.0]) for way in (0.0, travel)]
    circle = _MM * gear * unit_vector(_TURN).T
    bars = (
        Outline(np.array([axis, first, sleeves[0]]), "frame", closed=False),
        Outline(np.array([axis, last, sleeves[1]]), "before", closed=False),
    )
    return (
        Body("crank gear", (Outline(circle, "gear", shade=2),)),
        Body("crank and rod", bars[:1]),
        Body("cut off", bars[1:]),
    )


def _linkage(values: Mapping[str, float]) -> Sheet:
    """Crank and rod engaged, and palely when the sleeve has made its travel; the guide lies to the
    right of A.
    """
    linkage = CrankLinkage(values["l_AB"], values["l_BC"], values["l_AC"])
    bodies = draw_linkage(linkage, values["c"], values["r_A"])
    axis, pin, sleeve = bodies[1].outlines[0].points
    both = linkage.evaluate(np.array([0.0, values["c"]]))
    turned = [float(np.degrees(angle)) for angle in both["crank_angle"]]
    rod, size = float(np.degrees(both["rod_angle"][0])), _MM * values["l_AB"]
    marks: list[Mark] = [
        Length(("l_AB",), axis, pin, 0.8),
        Length(("l_BC",), pin, sleeve),
        Length(("l_AC",), axis, sleeve, 0.6),
        Length(("r_A",), axis, _MM * values["r_A"] * unit_vector(-1.0), 0.7),
        Length(("c",), sleeve, bodies[2].outlines[0].points[2]),
        Spot(("pin_x", "pin_y"), pin),
        Angle(("crank_angle",), axis, 0, turned[0], 0.45 * size),
        Angle(("theta_Amax",), axis, turned[0], turned[1] - turned[0], 1.15 * size),
        Angle(("rod_angle",), sleeve, 180, -rod, 0.7 * size),
    ]
    title = "crank and rod at both ends of the travel"
    return Sheet("linkage", title, build_still_scene("linkage", bodies), marks)


STEPS = 8
"""Rotations, between two at which a vertex points at a side, from which those that are drawn are
refined.
"""
MOMENTS = 240
"""Instants of an engagement."""
SLOWED = 20
"""How many times slower an engagement is shown."""
SECONDS = 6.0
"""How long a turn is shown: the shape is the same at any speed."""


def build_rotor_scene(rotor: Rotor, name: str) -> Scene:
    """Return the scene of a revolution of the body; every vertex takes the path of the first."""
    rotations, apothem, centroid = _fitted(rotor)
    rho = 1e3 * float(rotor.support(0.0)[0])
    body = Outline(1e3 * body_outline(rotor, 0.0, np.zeros(2)).T, "body", shade=0)
    sleeve = Outline(1e3 * polygon_outline(rotor.sides, rotor.smallest_apothem).T, "frame")
    return Scene(
        title=f"{name}: {rotor.vertices} arcs in {rotor.sides} sides",
        place="rotation of the body",
        unit="deg",
        places=np.degrees(rotations),
        seconds=SECONDS,
        bodies=(Body("sleeve", (sleeve,)), Body("body", (body,), centroid, np.degrees(rotations))),
        points=(
            Point(
                "a vertex",
                centroid[0] + rho * np.cos(rotations),
                centroid[1] + rho * np.sin(rotations),
                True,
            ),
            Point("the centroid", centroid[0], centroid[1], True),
        ),
        curves=(Curve("extra clearance needed", "mm", 1e3 * (2 * apothem - rotor.width)),),
        events=[
            Event(f"vertex {k + 1} where the first began", 360 * k / rotor.vertices)
            for k in range(1, rotor.vertices)
        ],
        shares=rotations / TURN,
    )


def _fitted(rotor: Rotor) -> tuple[Array, Array, Array]:
    """Rotations (n,) of a turn [rad], apothems (n,) of the smallest sleeves [m], and centroids (2,
    n) in these [mm].

    Corners of the apothem's curve lie where a vertex points at a side: these are among the
    rotations. From one to the next body and sleeve have turned into themselves, the sleeve by some
    of its sides.
    """
    poses: dict[float, tuple[float, Array]] = {}

    def rows(rotations: Array) -> list[Array]:
        for rotation in rotations.tolist():
            if rotation not in poses:
                poses[rotation] = rotor.tightest(rotation)
        fits = [poses[rotation] for rotation in rotations.tolist()]
        return [np.array([fit[0] for fit in fits]), *1e3 * np.array([fit[1] for fit in fits]).T]

    arches, common = math.lcm(rotor.vertices, rotor.sides), math.gcd(rotor.vertices, rotor.sides)
    first = refine_places(rows, TURN / arches * np.arange(STEPS + 1) / STEPS)[:-1]
    apothem, x, y = rows(first)
    sides = pow(rotor.vertices // common, -1, rotor.sides // common)
    turned = np.exp(1j * TURN / rotor.sides * sides * np.arange(arches))
    centroid = (turned[:, None] * (x + 1j * y)).ravel()
    rotations = (TURN / arches * np.arange(arches)[:, None] + first).ravel()
    return rotations, np.tile(apothem, arches), np.array([centroid.real, centroid.imag])


def build_engagement_scene(run: ContactRun) -> Scene:
    """Return the scene of an engagement in the frame of the shaft; the sleeve from the side
    below.
    """
    from planter.papers.clutch.contact import ANGLE, FREE, REULEAUX, TRAVEL

    chosen = _chosen(run)
    states, pushed, time = (
        run.states[:, chosen],
        run.seen["pushed"][0, chosen],
        1e3 * run.time[chosen],
    )
    model = formulas.load(REULEAUX)
    places = [
        [*state[:FREE], state[ANGLE], push] for state, push in zip(states.T, pushed, strict=True)
    ]
    views = [model.at("seen", places=view) for view in places]
    x, y = (1e3 * np.array([view[name] for view in views]) for name in ("c_x", "c_y"))
    body = 1e3 * body_outline(Rotor(VERTICES, SIDES, run.inputs["width"]), 0.0, np.zeros(2)).T
    shaft = 1e3 * polygon_outline(SIDES, run.inputs["apothem"], run.inputs["fillet"]).T
    low, wide = float(body[:, 1].min()) * 1.6, float(np.ptp(body[:, 0]))
    heading = np.degrees(np.unwrap([view["heading"] for view in views]))
    return Scene(
        title="Engagement of the Reuleaux clutch",
        place="time",
        unit="ms",
        places=time,
        seconds=SLOWED * float(run.time[-1] - run.time[0]),
        bodies=(
            Body("shaft", (Outline(shaft, "body", closed=False, shade=1),)),
            Body("body with its teeth", (Outline(body, "body", shade=0),), (x, y), heading),
            Body(
                "sleeve from the side",
                (Outline(_block(wide / 3), "body", shade=2),),
                (1e3 * states[TRAVEL], low),
            ),
            Body("end of the sleeve's way", (Outline(_block(wide / 3), "before"),), (0.0, low)),
        ),
        curves=(
            Curve("contact load", "N", run.load[chosen]),
            Curve("speed of the output", "r/min", run.speed[chosen] * 30 / np.pi),
            Curve("link angle", "deg", np.degrees(run.seen["link"][0, chosen])),
            Curve("way of the sleeve", "mm", 1e3 * states[TRAVEL]),
        ),
        events=(Event("largest load", float(1e3 * run.time[int(np.argmax(run.load))])),),
        labels=(Label("sleeve from the side", 0.0, low - 0.22 * wide),),
        shares=(run.time[chosen] - run.time[0]) / (run.time[-1] - run.time[0]),
    )


def _chosen(run: ContactRun) -> Integers:
    """Return the indices (n,) of a run's instants for the scene: those that the curves need, and
    the largest load.
    """
    from planter.papers.clutch.contact import TRAVEL

    rows = [run.load, run.speed, run.seen["link"][0], run.states[TRAVEL]]

    def nearest(places: Array) -> Integers:
        return np.rint(places).astype(np.int64)

    first = np.union1d(np.linspace(0, len(run.time) - 1, MOMENTS), [np.argmax(run.load)])
    places = refine_places(lambda at: [row[nearest(at)] for row in rows], first)
    return np.unique(nearest(places))


def _block(size: float) -> Array:
    half = size / 2
    return np.array([[-half, -half / 2], [half, -half / 2], [half, half / 2], [-half, half / 2]])


BINS = 900
LINK = "link angle / deg"


def thin_curve(x: Array, y: Array) -> Points:
    """Return the smallest and largest value of each of many parts of a curve (n,), in order."""
    if len(x) <= 2 * BINS:
        return x, y
    chosen = {0, len(x) - 1}
    for part in np.array_split(np.arange(len(x)), BINS):
        chosen |= {int(part[np.argmin(y[part])]), int(part[np.argmax(y[part])])}
    index = sorted(chosen)
    return x[index], y[index]


def _plot(run: ContactRun, values: Array) -> Points:
    """Values over the link angle while the link moves."""
    from planter.papers.clutch.contact import switching_time

    moving = (run.time >= 0) & (run.time <= switching_time(run.inputs))
    return thin_curve(run.link_deg[moving], values[moving])


def draw_contact(
    runs: Mapping[str, SwitchingRun],
    rows: Sequence[ContactLoadSensitivity],
    loads: Mapping[str, float],
) -> dict[str, Figure]:
    """Return figures of loads and speeds of both clutches, of the section, and of the loads [N]
    while inputs vary.
    """
    engaged = {name: run.engagement for name, run in runs.items()}
    cut_off = {name: run.cut_off for name, run in runs.items()}
    load = {name: _plot(run, run.load) for name, run in engaged.items()}
    speeds = [
        {name: _plot(run, run.speed * 30 / np.pi) for name, run in way.items()}
        for way in (engaged, cut_off)
    ]
    titles = ("engagement", "cut-off")
    scene = build_engagement_scene(engaged["reuleaux"])
    return {
        "load": draw_panels([Panel("contact load / N", load)], LINK, 3.0),
        "speed": draw_panels(
            [
                Panel("output speed / (r/min)", curves, title)
                for curves, title in zip(speeds, titles, strict=True)
            ],
            LINK,
        ),
        "section": draw_stills({"cut off": (scene, 0), "engaged": (scene, scene.moments - 1)}),
        "sensitivity": draw_sensitivity(rows, loads),
    }


def draw_sensitivity(rows: Sequence[ContactLoadSensitivity], loads: Mapping[str, float]) -> Figure:
    """Draw the largest loads [N] of both clutches while one input runs over a factor of 10."""
    panels = []
    for clutch, load in loads.items():
        curves: dict[str, Points] = {}
        for name in dict.fromkeys(row.input for row in rows):
            varied = [(r.factor, getattr(r, f"{clutch}_N_max_N")) for r in rows if r.input == name]
            factors, largest = np.array(sorted([(1.0, load), *varied])).T
            curves[name] = factors, largest
        panels.append(Panel("largest load / N", curves, clutch, is_log=True))
    return draw_panels(panels, "factor on the input")


def draw_modal_load(si: Si, shape: str) -> dict[str, Figure]:
    """Draw the load on the tooth in one mode, derived and as printed, until contact is lost."""
    from planter.papers.clutch import modal_engagement as modal

    engagement = modal.build_engagement(si, shape)
    struck = [engagement[name] for name in formulas.load(modal.MODEL).entries("struck")]
    curves = {}
    for name, model in (("exact", modal.MODEL), ("printed", modal.PRINTED)):
        at = modal.find_extremes(engagement, model)
        time = np.linspace(0, at["t_loss"], 241)
        rates = {"B1": at["B1"], "B2": at["B2"], "struck": struck}
        curves[name] = 1e6 * time, formulas.load(modal.MODEL)("motion", t=time, **rates)["N"]
    panel = Panel("load on the tooth / N", curves, level=0)
    return {"modal": draw_panels([panel], "time since contact / μs")}


def draw_rotor(rotor: Rotor, fillets: Mapping[str, float]) -> dict[str, Figure]:
    """Draw the body in the smallest polygon that lets it turn, and the path of a vertex with
    rounded corners [m] inside, if there are any.
    """
    turning = draw_stills({"": (build_rotor_scene(rotor, "rotor"), 0)})
    if not fillets:
        return {"turning": turning}
    rounded = [polygon_outline(rotor.sides, rotor.width / 2, r, 40) for r in fillets.values()]
    outlines = [
        Outline(_MM * polygon_outline(rotor.sides, rotor.width / 2).T, "frame"),
        Outline(_MM * rotor.track().T, "body", closed=False, shade=0),
        *(
            Outline(_MM * part.T, "gear", closed=False, shade=i)
            for i, part in enumerate(rounded, 2)
        ),
    ]
    radii = ", ".join(f"{name}: {r / rotor.width:.4f} R" for name, r in fillets.items())
    scene = build_still_scene("path", [Body("path", outlines)])
    return {"turning": turning, "vertex_path": draw_stills({f"fillets {radii}": (scene, 0)})}


def draw_travels(angles_deg: Array, curves: Mapping[str, Array], marks: Array) -> Figure:
    """Draw the least travel [mm] over the axial angle, with the file's levels marked."""
    points = {name: (marks, np.interp(marks, angles_deg, curve)) for name, curve in curves.items()}
    series = {name: (angles_deg, curve) for name, curve in curves.items()}
    return draw_panels(
        [Panel("least travel of the sleeve / mm", series, "", points)], "axial angle / deg"
    )


def draw_linkages(linkages: Mapping[str, DrawnLinkage]) -> Figure:
    """Draw linkages by their labels at both ends of their travel.

    Titles have the rotation of the crank and the travel.
    """
    stills = {}
    for name, (linkage, travel, gear) in linkages.items():
        turned = math.degrees(linkage.rotation(travel))
        title = f"{name}: {turned:.3g}°, {_MM * travel:.3g} mm"
        stills[title] = build_still_scene(name, draw_linkage(linkage, travel, gear)), 0
    return draw_stills(stills, 2.6)


def draw_field_test(evaluation: FieldEvaluation) -> dict[str, Figure]:
    """Return the figures of a field test: effects, and the compared clutches if there are any."""
    figures = {"effects": draw_effects(evaluation)}
    if evaluation.samples:
        figures["comparison"] = draw_comparison(evaluation)
    return figures


def _escape(text: str) -> str:
    """Return a user's text with dollars escaped, which would set it as mathematics."""
    return text.replace("$", r"\$")


@style.with_style
def draw_effects(evaluation: FieldEvaluation) -> Figure:
    """Draw means at the levels of each factor over the runs, a row for each response."""
    trial, count = evaluation.trial, len(evaluation.trial.factors)
    figure = style.new_figure(0.4 + 1.9 * len(trial.responses))
    grid = figure.subplots(len(trial.responses), count, sharey="row", squeeze=False)
    for row, (response, values) in zip(grid, trial.responses.items(), strict=True):
        means = evaluation.result.range[response]
        for axes, (name, factor) in zip(row, trial.factors.items(), strict=True):
            places = np.arange(len(factor.levels))
            axes.plot(factor.codes, values, "o", color=style.FAINT, markersize=3)
            axes.plot(places, means[name].k, "o-", color=style.BLUE, markersize=4.5)
            axes.axhline(float(values.mean()), color=style.SOFT, linewidth=0.6, linestyle="--")
            axes.set_xticks(places, [_escape(str(level)) for level in factor.levels])
            axes.set_xlim(-0.4, len(places) - 0.6)
            axes.set_xlabel(_escape(trial.labels.get(name, name)))
        row[0].set_ylabel(_escape(trial.labels.get(response, response)))
    return figure


@style.with_style
def draw_comparison(evaluation: FieldEvaluation) -> Figure:
    """Draw mean and standard deviation of each clutch over speed, a panel for each measure."""
    samples = evaluation.samples
    measures = list(dict.fromkeys(sample.measure for sample in samples))
    figure = style.new_figure(2.6)
    for axes, measure in zip(
        figure.subplots(1, len(measures), squeeze=False)[0], measures, strict=True
    ):
        clutches = list(dict.fromkeys(sample.clutch for sample in samples))
        for index, clutch in enumerate(clutches):
            chosen = [s for s in samples if (s.clutch, s.measure) == (clutch, measure)]
            axes.errorbar(
                [s.speed_m_s for s in chosen],
                [s.mean for s in chosen],
                [s.sd for s in chosen],
                fmt="o",
                capsize=3,
                color=style.curve_colour(clutch, index),
                label=_escape(clutch),
            )
        axes.set_title(_escape(evaluation.trial.labels.get(measure, measure)))
        axes.set_xlabel("working speed / (m/s)")
        axes.margins(x=0.4)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return figure
