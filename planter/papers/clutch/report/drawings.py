"""Drawings of a clutch with its symbols, and its moving scenes."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from planter.kernels import Array, Integers, formulas
from planter.numerics.arrays import TURN
from planter.papers.clutch.contact_dynamics import ANGLE, FREE, REULEAUX, TRAVEL
from planter.papers.clutch.contact_simulation import ContactRun
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.geometry import SIDES, VERTICES, CrankLinkage
from planter.papers.clutch.model import collect_values, load_model
from planter.papers.clutch.rotor import Rotor, body_outline, polygon_outline
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

_MM = 1e3
_TURN = np.linspace(0, 2 * np.pi, 181)
_TURNED = 360 / SIDES
"""Direction of X from x: that of the hexagon's next side."""


def draw_sheets(clutch: ClutchFile) -> list[Sheet]:
    """Return all drawings of a clutch."""
    values = collect_values(clutch)
    return [_polygon(values), _teeth(values), _sleeve(values), _linkage(values)]


def compute_direction(angle: float | Array) -> Array:
    """Return the unit vector of an angle [rad], (2,) or (2, n)."""
    return np.array([np.cos(angle), np.sin(angle)])


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
    major, minor = compute_direction(axis), compute_direction(axis + np.pi / 2)
    oval = centre + _MM * (
        compute_direction(_TURN).T @ [sizes["s_1"] * major, sizes["s_2"] * minor]
    )
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
    corner = (
        (flats / 2 - fillet) / np.cos(np.pi / SIDES) * compute_direction(np.pi / 2 + np.pi / SIDES)
    )
    circle = compute_direction(_TURN).T
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
        Length(("b2",), centre, root * compute_direction(0.6), 0.7),
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
    circle = _MM * gear * compute_direction(_TURN).T
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
        Length(("r_A",), axis, _MM * values["r_A"] * compute_direction(-1.0), 0.7),
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
    body = 1e3 * body_outline(Rotor(VERTICES, SIDES, run.inputs.width), 0.0, np.zeros(2)).T
    shaft = 1e3 * polygon_outline(SIDES, run.inputs.apothem, run.inputs.fillet).T
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
    rows = [run.load, run.speed, run.seen["link"][0], run.states[TRAVEL]]

    def nearest(places: Array) -> Integers:
        return np.rint(places).astype(np.int64)

    first = np.union1d(np.linspace(0, len(run.time) - 1, MOMENTS), [np.argmax(run.load)])
    places = refine_places(lambda at: [row[nearest(at)] for row in rows], first)
    return np.unique(nearest(places))


def _block(size: float) -> Array:
    half = size / 2
    return np.array([[-half, -half / 2], [half, -half / 2], [half, half / 2], [-half, half / 2]])
