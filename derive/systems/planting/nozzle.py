"""What requirements ask of the nozzle in the soil: where its axis passes a level, how near a half is to the plant."""

from __future__ import annotations

import sympy as sp
from sympy import S, pi, sqrt

from ...formulas import Formulas
from ...mechanics.frames import Frame, Vec, X, Y, unit
from ...model import System, let
from ...quantity import Quantity
from . import quantities as q
from .derivation import PLANET, WORLD

ASSUMPTIONS = (
    "a half of the nozzle is the line from its hinge to its tip; it swings out of the plane of the tip's path",
    "the plant is a vertical line from the ground to the top of the seedling",
)
TINY = sp.Float("1e-30")
"""Keeps a quotient finite where the half hangs straight down."""


def _found(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: nozzle")


tilt = _found("tilt", "rad", "angle of the nozzle's axis from the vertical")
soil = _found("soil", "m", "level of the soil")
cut = _found("cut", "m", "where over ground the nozzle's axis passes that level")
plant = _found("plant", "m", "where over ground the plant stands")
top = _found("top", "m", "height of the top of the plant")
hair = _found("hair", "m", "length that keeps the slope of no distance finite")
length = _found("length", "m", "length of a half, from hinge to tip")
root_x, root_y = (_found(f"root_{a}", "m", f"hinge on the nozzle's axis, {a}") for a in "xy")
along_x, along_y, aside = (_found(f"along_{a}", "1", f"direction of the open half, {a}") for a in "xyz")
nearest = _found("nearest", "m", "place on the line of the half, from the hinge, that is nearest to the plant")
lowest = _found("lowest", "m", "place on it from which on it is lower than the plant's top")
place = _found("place", "m", "the nearest place that counts")
clearance = _found("clearance", "m", "horizontal distance of the half from the plant")


def axis(f: Formulas) -> None:
    """The nozzle's axis through its tip: its tilt, and where it passes a level."""
    way = sp.Dummy("way")
    x, y, _ = unit(PLANET, X).resolved(WORLD).components
    (there,) = sp.solve(q.y_tip + way * y - soil, way)
    steps = (let(tilt, q.alpha - pi / 2), let(cut, q.x_tip + there * x))
    f.function("axis", (q.x_tip, q.y_tip, q.alpha, soil), *steps, told="passing")


def half(f: Formulas) -> None:
    """Of a half, what is lower than the plant's top counts."""
    closed = unit(PLANET, X).resolved(WORLD)
    opened = unit(Frame("half", PLANET, Y, q.theta1), X).resolved(WORLD)
    s = sp.Dummy("s")
    gap = Vec(WORLD, (root_x - plant + s * along_x, S.Zero, s * aside))
    square = gap.dot(gap)
    (near,) = sp.solve(square.diff(s), s)
    above, below = sp.fraction(sp.together(near))
    (passed,) = sp.solve(root_y + s * along_y - top, s)
    steps = (
        let(length, q.L_tip - q.x_A),
        let(root_x, q.x_tip - length * closed[0]),
        let(root_y, q.y_tip - length * closed[1]),
        *(let(symbol, part) for symbol, part in zip((along_x, along_y, aside), opened.components, strict=True)),
        let(nearest, above / (below + TINY)),
        let(lowest, sp.Min(sp.Max(passed, S.Zero), length)),
        let(place, sp.Min(sp.Max(nearest, lowest), length)),
        let(clearance, sqrt(square.subs(s, place) + hair**2)),
    )
    inputs = (q.x_tip, q.y_tip, q.alpha, q.theta1, plant, top, hair, q.MACHINE)
    f.function("half", inputs, *steps, gives=(clearance,), told="apart")


def exact() -> System:
    """The nozzle in the soil."""
    title, source = "Nozzle of the planting device in the soil", "derived (geometry)"
    f = Formulas("planting_nozzle", title=title, source=source, assumptions=ASSUMPTIONS)
    axis(f)
    half(f)
    return f.system()


SYSTEMS = (exact,)
