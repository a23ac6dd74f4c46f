"""Bodies of a clutch in contact and their motion: how the output shaft's end sees the body, and how they slide."""

from __future__ import annotations

from sympy import Expr, S

from ....formulas import Formulas
from ....mechanics.frames import Frame, Motion, Point, Vec, Z, displacement
from ....model import Let, let
from ....quantity import Quantity, Vector
from . import quantities as q

WORLD = Frame("frame")
INPUT = Frame("input", WORLD, Z, q.angle)
"""The body turns with the input, whose slides carry it."""
SHAFT = Frame("output shaft", WORLD, Z, q.output)
O = Point("O")  # noqa: E741
BODY = Point("centre of the body", O, Vec(WORLD, (q.x, q.y, S.Zero)))
END = Point("end of the output shaft", O, Vec(WORLD, (q.shaft_x, q.shaft_y, S.Zero)))
SEEN = displacement(END, BODY, SHAFT)

MOTION = Motion(dict(zip(q.PLACES, q.RATES, strict=True)))
SEEN_RATE = MOTION.relative_derivative(displacement(END, BODY, WORLD), SHAFT).resolved(SHAFT)
"""Of `SEEN`, as the turning shaft sees it."""
TURNING = (MOTION.spin(INPUT).resolved(WORLD) - MOTION.spin(SHAFT).resolved(WORLD))[2]
"""Rate at which the body turns against the shaft."""
OVER_INPUT = MOTION.relative_derivative(displacement(O, BODY, WORLD), INPUT)
"""Velocity of the body over what turns with the input."""
ON_SLIDES = MOTION.relative_derivative(displacement(O, BODY, INPUT), INPUT)
"""The same as the turning input sees it."""


def vec(frame: Frame, x: Expr, y: Expr) -> Vec:
    return Vec(frame, (x, y, S.Zero))


def heading(polar: Expr = S.Zero) -> tuple[Let, ...]:
    """Centre of the body and direction of a radius of it, as the shaft sees them."""
    return (
        let(q.c_x, SEEN[0]),
        let(q.c_y, SEEN[1]),
        let(q.heading, q.angle - q.output + polar),
    )


def opening(slopes: tuple[Expr, Expr, Expr]) -> Expr:
    """Rate of a distance from its slopes in what the shaft sees of the body: centre (2,) and direction."""
    x, y, turn = slopes
    return x * SEEN_RATE[0] + y * SEEN_RATE[1] + turn * TURNING


def slip(normal: tuple[Expr, Expr], point: tuple[Expr, Expr]) -> Expr:
    """Velocity of the body over the shaft along the surface at a point, all as the shaft sees it."""
    turning = Vec(SHAFT, (S.Zero, S.Zero, TURNING))
    over = SEEN_RATE + turning.cross(vec(SHAFT, *point) - vec(SHAFT, q.c_x, q.c_y))
    along = Vec(SHAFT, (S.Zero, S.Zero, S.One)).cross(vec(SHAFT, *normal))
    return along.dot(over)


def contact(
    f: Formulas,
    name: str,
    inputs: tuple[Vector | Quantity, ...],
    before: tuple[Let, ...],
    gap: Expr,
    rate: Expr,
    slips: tuple[Expr, ...],
) -> None:
    """A contact as a function of places, rates, the law and its own ``inputs``: what it does to each coordinate."""
    told = f"{name}_contact"
    steps = (*before, *q.CONTACT.steps(gap, rate, slips, q.HERTZ))
    given = q.CONTACT.outputs(told).quantities
    f.function(name, (*inputs, q.PLACES, q.RATES, q.LAW), *steps, gives=given, told=told)
