"""The Reuleaux polygon as it turns in the smallest regular polygon that lets it, and during an engagement."""

from __future__ import annotations

import math

import numpy as np

from planter.clutch.engagement.dynamics import ANGLE, FREE, REULEAUX, TRAVEL
from planter.clutch.engagement.motion import ContactRun
from planter.clutch.geometry import SIDES, VERTICES
from planter.clutch.report.shape_figures import polygon_outline
from planter.clutch.rotor import Rotor, body_outline
from planter.kernels import Array, formulas
from planter.numerics.arrays import TURN, Integers
from planter.view.scene import Body, Curve, Event, Label, Outline, Point, Scene, refine_places

STEPS = 8
"""Rotations, between two at which a vertex points at a side, from which those that are drawn are refined."""
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
            Point("a vertex", centroid[0] + rho * np.cos(rotations), centroid[1] + rho * np.sin(rotations), True),
            Point("the centroid", centroid[0], centroid[1], True),
        ),
        curves=(Curve("extra clearance needed", "mm", 1e3 * (2 * apothem - rotor.width)),),
        events=[Event(f"vertex {k + 1} where the first began", 360 * k / rotor.vertices)
                for k in range(1, rotor.vertices)],
        shares=rotations / TURN,
    )  # fmt: skip


def _fitted(rotor: Rotor) -> tuple[Array, Array, Array]:
    """Rotations (n,) of a turn [rad], apothems (n,) of the smallest sleeves [m], and centroids (2, n) in these [mm].

    Corners of the apothem's curve lie where a vertex points at a side: these are among the rotations.
    From one to the next body and sleeve have turned into themselves, the sleeve by some of its sides.
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
    """Return the scene of an engagement in the frame of the shaft; the sleeve from the side below."""
    chosen = _chosen(run)
    states, pushed, time = run.states[:, chosen], run.seen["pushed"][0, chosen], 1e3 * run.time[chosen]
    model = formulas.load(REULEAUX)
    places = [[*state[:FREE], state[ANGLE], push] for state, push in zip(states.T, pushed, strict=True)]
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
            Body("sleeve from the side", (Outline(_block(wide / 3), "body", shade=2),), (1e3 * states[TRAVEL], low)),
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
    """Return the indices (n,) of a run's instants for the scene: those that the curves need, and the largest load."""
    rows = [run.load, run.speed, run.seen["link"][0], run.states[TRAVEL]]

    def nearest(places: Array) -> Integers:
        return np.rint(places).astype(np.int64)

    first = np.union1d(np.linspace(0, len(run.time) - 1, MOMENTS), [np.argmax(run.load)])
    places = refine_places(lambda at: [row[nearest(at)] for row in rows], first)
    return np.unique(nearest(places))


def _block(size: float) -> Array:
    half = size / 2
    return np.array([[-half, -half / 2], [half, -half / 2], [half, half / 2], [-half, half / 2]])
