"""Drawings of a clutch with its symbols: polygon in the hexagon, teeth on the shaft, sleeve, crank and rod."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from planter.clutch.file import ClutchFile
from planter.clutch.geometry import SIDES, VERTICES, CrankLinkage
from planter.clutch.model import collect_values, load_model
from planter.clutch.report.shape_figures import polygon_outline
from planter.clutch.rotor import Rotor, body_outline
from planter.kernels import Array
from planter.view.scene import Body, Outline
from planter.view.sheet import Angle, Length, Mark, Sheet, Spot, heading, still

_MM = 1e3
_TURN = np.linspace(0, 2 * np.pi, 181)
_TURNED = 360 / SIDES
"""Direction of X from x: that of the hexagon's next side."""


def draw_sheets(clutch: ClutchFile) -> list[Sheet]:
    """Return all drawings of a clutch."""
    values = collect_values(clutch)
    return [_polygon(values), _teeth(values), _sleeve(values), _linkage(values)]


def _direction(angle: float | Array) -> Array:
    """The unit vector of an angle [rad], (2,) or (2, n)."""
    return np.array([np.cos(angle), np.sin(angle)])


def _polygon(values: Mapping[str, float]) -> Sheet:
    """The polygon with A and B on their sides, C near the middle of its way past a corner."""
    sizes = load_model().at("polygon", a=values["a"])
    rotor = Rotor(VERTICES, SIDES, sizes["R"])
    theta = sum(rotor.passage) / 2
    at = {name: float(value[0]) * _MM for name, value in rotor.path(np.array([theta])).items()}
    a, b, c, middle = (np.array([at[f"x_{name}"], at[f"y_{name}"]]) for name in "ABCM")
    beta = np.degrees(load_model().at("path", theta=theta, a=values["a"])["beta"])
    body = body_outline(rotor, np.radians(heading(middle, c)), middle / _MM).T * _MM
    hexagon = polygon_outline(SIDES, rotor.width / 2).T[:-1] * _MM
    axis, centre = rotor.ellipse["axis"], np.array([sizes["x_E"], sizes["y_E"]]) * _MM
    major, minor = _direction(axis), _direction(axis + np.pi / 2)
    oval = centre + _MM * (_direction(_TURN).T @ [sizes["s_1"] * major, sizes["s_2"] * minor])
    bodies = (Body("hexagon", (Outline(hexagon, "frame"), Outline(oval, "mark"))),
              Body("body", (Outline(body, "body", shade=0),)))  # fmt: skip
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
    return Sheet("polygon", "polygon in the hexagonal hole", still("polygon", bodies), marks)


def _teeth(values: Mapping[str, float]) -> Sheet:
    """Teeth of the body about the output shaft, an axis of a tooth to the right; faces as the least tip has them."""
    teeth = load_model().at("teeth", flats=values["flats"], r=values["r"])
    tip, root, flats, fillet = (_MM * values[name] for name in ("b1", "b2", "flats", "r"))
    section = polygon_outline(SIDES, flats / 2, fillet).T
    corner = (flats / 2 - fillet) / np.cos(np.pi / SIDES) * _direction(np.pi / 2 + np.pi / SIDES)
    circle = _direction(_TURN).T
    bodies = (Body("shaft", (Outline(section, "body", closed=False, shade=1),)),
              Body("tips and roots", (Outline(tip * circle, "mark"), Outline(root * circle, "mark"))))  # fmt: skip
    centre, face = np.zeros(2), np.degrees(teeth["xi"]) / 2
    marks: list[Mark] = [
        Length(("flats",), np.array([0.0, -flats / 2]), np.array([0.0, flats / 2]), 0.3),
        Length(("flat_to_flat_mm",), np.array([0.0, -flats / 2]), np.array([0.0, flats / 2]), 0.75),
        Length(("r",), corner, corner * (1 + fillet / float(np.hypot(*corner)))),
        Length(("b1",), centre, np.array([tip, 0.0]), 0.6),
        Length(("b2",), centre, root * _direction(0.6), 0.7),
        Angle(("xi",), np.array([_MM * teeth["b1"], 0.0]), -float(face), 2 * float(face), 0.2 * flats),
    ]
    return Sheet("teeth", "teeth on the output shaft", still("teeth", bodies), marks)


def _sleeve(values: Mapping[str, float]) -> Sheet:
    """Return the drawing of the tapered body above the axis, and of the sleeve's travel."""
    length, right, way = (_MM * values[name] for name in ("d", "R2", "c"))
    start, travel = np.array([length, right]), np.array([way, 0.0])
    left = right + length * float(np.tan(values["phi"]))
    body = np.array([[0.0, 0.0], [length, 0.0], [length, right], [0.0, left]])
    bodies = (Body("body", (Outline(body, "body", shade=0),)),
              Body("cut off", (Outline(body + travel, "before"),)))  # fmt: skip
    marks: list[Mark] = [
        Length(("d",), np.zeros(2), np.array([length, 0.0])),
        Length(("R1",), np.zeros(2), np.array([0.0, left])),
        Length(("R2",), np.array([length, 0.0]), start),
        Length(("c",), start, start + travel),
        Angle(("phi",), start, 180, -float(np.degrees(values["phi"])), 0.6 * length),
    ]
    return Sheet("sleeve", "tapered body in the sleeve, engaged and by the travel away", still("sleeve", bodies),
                 marks)  # fmt: skip


def _linkage(values: Mapping[str, float]) -> Sheet:
    """Crank and rod engaged, and palely when the sleeve has made its travel; the guide lies to the right of A."""
    linkage = CrankLinkage(values["l_AB"], values["l_BC"], values["l_AC"])
    travel, axis = np.array([_MM * values["c"], 0.0]), np.zeros(2)
    both = linkage.evaluate(np.array([0.0, values["c"]]))
    pins = _MM * np.column_stack([both["pin_x"], both["pin_y"]])
    sleeve = np.array([_MM * values["l_AC"], 0.0])
    gear = _MM * values["r_A"] * _direction(_TURN).T
    bodies = (
        Body("crank gear", (Outline(gear, "gear", shade=2),)),
        Body("crank and rod", (Outline(np.array([axis, pins[0], sleeve]), "frame", closed=False),)),
        Body("cut off", (Outline(np.array([axis, pins[1], sleeve + travel]), "before", closed=False),)),
    )
    turned = [float(np.degrees(angle)) for angle in both["crank_angle"]]
    marks: list[Mark] = [
        Length(("l_AB",), axis, pins[0], 0.8),
        Length(("l_BC",), pins[0], sleeve),
        Length(("l_AC",), axis, sleeve, 0.6),
        Length(("r_A",), axis, _MM * values["r_A"] * _direction(-1.0), 0.7),
        Length(("c",), sleeve, sleeve + travel),
        Spot(("pin_x", "pin_y"), pins[0]),
        Angle(("crank_angle",), axis, 0, turned[0], 0.45 * _MM * values["l_AB"]),
        Angle(("theta_Amax",), axis, turned[0], turned[1] - turned[0], 1.15 * _MM * values["l_AB"]),
        Angle(("rod_angle",), sleeve, 180, -float(np.degrees(both["rod_angle"][0])), 0.7 * _MM * values["l_AB"]),
    ]
    return Sheet("linkage", "crank and rod at both ends of the travel", still("linkage", bodies), marks)
