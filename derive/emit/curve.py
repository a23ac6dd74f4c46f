"""The functions of a pitch curve, whatever the target.

Contact, curvature, arc length, conditions, convexity where there is a closed form, relative parameters; the prologue
(closure, series) is a loop or a root, which each target writes in its own way.
"""

from __future__ import annotations

import sympy as sp

from ..gearing import pitch_curve
from ..gearing.pitch_curve import Condition, PitchCurve
from ..model import Let, SineSeries, Step
from ..quantity import OpenVector, Quantity, Vector
from .schedule import share
from .text import Emitted

LOCALS = frozenset({"cosines", "nodes", "radii", "terms"})
"""Names of the prologues' own."""
HOISTED = OpenVector(
    "hoisted", "centre distance, then the cosine series of the ratio, if there is one", {0: pitch_curve.a}
)


def parameters_of(curve: PitchCurve) -> Vector:
    return Vector("parameters", (*curve.parameters, pitch_curve.m))


def all_conditions(curve: PitchCurve) -> list[Condition]:
    return [*curve.conditions(), Condition("m", pitch_curve.m - sp.Rational(1, 2), "greater than 1/2")]


def contact(curve: PitchCurve) -> Emitted:
    """Contact of the deformed curve at the polar angle t."""
    turned = curve.turned()
    rotation: Step = SineSeries(pitch_curve.ahead, pitch_curve.u, HOISTED, "rotation")
    if isinstance(turned, sp.Expr):
        rotation = Let(pitch_curve.ahead, turned - pitch_curve.u, "rotation in closed form")
    steps = share((*pitch_curve.parameter_steps(), rotation, *pitch_curve.contact_steps(curve)), prefix="c")
    return Emitted("contact", (pitch_curve.t, parameters_of(curve), HOISTED), steps, pitch_curve.CONTACT)


def curvature(curve: PitchCurve) -> Emitted:
    """Curvatures of the deformed curve and its conjugate at the parameter u, on both segments."""
    steps = share(pitch_curve.curvature_steps(curve), prefix="c")
    return Emitted("curvature", (pitch_curve.u, parameters_of(curve), HOISTED), steps, pitch_curve.CURVATURE)


def polar(curve: PitchCurve) -> Emitted:
    """Polar angles at which the deformed curve has the parameter u, one on each segment."""
    return Emitted(
        "polar", (pitch_curve.u, parameters_of(curve)), share(pitch_curve.polar_steps(), prefix="c"), pitch_curve.POLAR
    )


def speed(curve: PitchCurve) -> Emitted:
    """Arc lengths of the deformed curve per parameter u, on both segments."""
    return Emitted(
        "speed", (pitch_curve.u, parameters_of(curve)), share(pitch_curve.speed_steps(curve), "c"), pitch_curve.SPEED
    )


def conditions(curve: PitchCurve) -> Emitted:
    """Expressions that must be positive."""
    positive = tuple(c.positive for c in all_conditions(curve))
    names = Vector(
        "positive",
        tuple(Quantity(f"g{i}", "1", "must be positive", "pitch curve") for i in range(len(positive))),
    )
    return Emitted("conditions", (parameters_of(curve),), (), names, positive)


def convexity(curve: PitchCurve) -> list[Emitted]:
    """The closed form that is positive if and only if the deformed curve is convex, if the family has one."""
    closed = curve.convexity()
    if closed is None:
        return []
    convex = Quantity("convex", "1", "positive if and only if the deformed curve is convex", "pitch curve")
    steps = share((Let(convex, closed, "convexity in closed form"),), prefix="c")
    return [Emitted("convexity", (parameters_of(curve),), steps, Vector("convexity", (convex,)))]


def relative(curve: PitchCurve) -> Emitted:
    """Parameters of a curve of unit size and a given swing, without the deformation coefficient."""
    found = tuple(Quantity(f"{q.name}_", q.unit, q.meaning, q.source) for q in curve.parameters)
    lets = (Let(q, value, "unit size") for q, value in zip(found, curve.relative(), strict=True))
    return Emitted(
        "relative", (pitch_curve.swing, shapes_of(curve)), share(tuple(lets), "c"), Vector("relative", found)
    )


def shapes_of(curve: PitchCurve) -> Vector:
    return Vector("shape", tuple(shape.quantity for shape in curve.shapes))


def functions_of(curve: PitchCurve) -> list[Emitted]:
    """All but the prologue. Raises ValueError where a parameter has a name that the prologue needs."""
    if taken := sorted(q.name for q in curve.parameters if q.name in LOCALS):
        raise ValueError(f"family {curve.name}: its prologue needs the name {taken[0]}; call the parameter otherwise")
    along = [contact(curve), curvature(curve), polar(curve), speed(curve)]
    return [*along, conditions(curve), *convexity(curve), relative(curve)]


def in_closed_form(curve: PitchCurve) -> bool:
    """Whether centre distance and rotation are known, so that the prologue needs neither closure nor series."""
    return all(isinstance(known, sp.Expr) for known in (curve.centre_distance(), curve.turned()))
