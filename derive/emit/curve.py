"""Modules of a pitch curve, for CasADi and for arrays.

Prologue (closure, series), contact, curvature, conditions, convexity where there is a closed form, relative parameters.
"""

from __future__ import annotations

import sympy as sp

from ..gearing import meshing
from ..gearing.meshing import BySeries, Condition, PitchCurve
from ..model import Let, SineSeries, Step
from ..quantity import OpenVector, Quantity, Vector
from .expression import ARRAY, CASADI, Printer
from .schedule import share
from .targets.casadi import NOTICE, imports
from .text import Emitted, described

HOISTED = OpenVector("hoisted", "centre distance, then the cosine series of the ratio, if there is one", {0: meshing.a})


def parameters_of(curve: PitchCurve) -> Vector:
    return Vector("parameters", (*curve.parameters, meshing.m))


def all_conditions(curve: PitchCurve) -> list[Condition]:
    return [*curve.conditions(), Condition("m", meshing.m - sp.Rational(1, 2), "greater than 1/2")]


def contact(curve: PitchCurve) -> Emitted:
    """Contact of the deformed curve at the polar angle t."""
    turned = curve.turned()
    rotation: Step = Let(meshing.turned_u, turned, "rotation in closed form") if isinstance(turned, sp.Expr) else (
        SineSeries(meshing.turned_u, meshing.u, HOISTED, "rotation"))  # fmt: skip
    steps = share((*meshing.parameter_steps(), rotation, *meshing.contact_steps(curve)), prefix="c")
    return Emitted("contact", (meshing.t, parameters_of(curve), HOISTED), steps, meshing.CONTACT)


def curvature(curve: PitchCurve) -> Emitted:
    """Curvatures of the deformed curve and its conjugate at the parameter u, on both segments."""
    steps = share(meshing.curvature_steps(curve), prefix="c")
    return Emitted("curvature", (meshing.u, parameters_of(curve), HOISTED), steps, meshing.CURVATURE)


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
    return Emitted("relative", (meshing.swing, shapes_of(curve)), share(tuple(lets), "c"), Vector("relative", found))


def shapes_of(curve: PitchCurve) -> Vector:
    return Vector("shape", tuple(shape.quantity for shape in curve.shapes))


def functions_of(curve: PitchCurve) -> list[Emitted]:
    """All but the prologue."""
    return [contact(curve), curvature(curve), conditions(curve), *convexity(curve), relative(curve)]


def casadi_module(curve: PitchCurve) -> str:
    always = ["Function", "SX", "jacobian", "vertcat"]
    if _by_closure(curve) or _by_series(curve):
        prologue = _casadi_closure(curve)
        always += ["DM", "MX", "fmax", "mmax", "rootfinder", "sum1"]
    else:
        prologue = _casadi_closed(curve)
    functions = "\n\n\n".join((prologue, *map(_casadi_function, functions_of(curve))))
    return f'''"""{curve.title.capitalize()}: CasADi functions of a pitch curve and its conjugate.

{NOTICE}
{described([parameters_of(curve), HOISTED])}
"""

{imports(functions, always)}


{functions}
'''


def array_module(curve: PitchCurve) -> str:
    functions = "\n\n\n".join((_array_prologue(curve), *map(_array_function, functions_of(curve))))
    return f'''"""{curve.title.capitalize()}: array code of a pitch curve and its conjugate.

{NOTICE}
`xp` is a module of elementary functions under NumPy's names.
"""


{functions}
'''


def _by_closure(curve: PitchCurve) -> bool:
    return not isinstance(curve.centre_distance(), sp.Expr)


def _by_series(curve: PitchCurve) -> bool:
    return isinstance(curve.turned(), BySeries)


def _casadi_function(function: Emitted) -> str:
    declared = "\n".join(f"    {v.name} = SX.sym({_size(v)})" for v in function.inputs)
    names = ", ".join(f'"{v.name}"' for v in function.inputs)
    terms = "terms: int" if HOISTED in function.inputs else ""
    single = ", ".join(f'"{q.name}"' for q in function.output)
    return f'''def {function.name}({terms}) -> Function:
    """{function.operations} operations. {_given(function)}"""
{declared}
{function.body(CASADI)}
    outputs = [
{function.packed(CASADI)}
    ]
    return Function("{function.name}", [{function.names()}], outputs, [{names}], [{single}])'''


def _given(function: Emitted) -> str:
    """The outputs, each with unit and meaning, for a docstring; conditions speak in the sidecar."""
    if function.results:
        return "Each output must be positive; the sidecar names them."
    lines = "\n    ".join(f"    {q.name} [{q.unit}] {q.meaning}" for q in function.output)
    return f"Outputs:\n\n    {lines}\n    "


def _size(vector: Vector | OpenVector | Quantity) -> str:
    if isinstance(vector, OpenVector):
        return f'"{vector.name}", 1 + terms'
    return f'"{vector.name}"' if isinstance(vector, Quantity) else f'"{vector.name}", {len(vector)}'


def _array_function(function: Emitted) -> str:
    return f'''def {function.name}(xp, {function.names()}):
    """{", ".join(q.name for q in function.output)}."""
{function.body(ARRAY)}
    return (
{function.packed(ARRAY)},
    )'''


def _unpacked(curve: PitchCurve) -> str:
    return "\n".join(f"    {q.name} = parameters[{i}]" for i, q in enumerate(curve.parameters))


def _casadi_closed(curve: PitchCurve) -> str:
    return f'''def prologue(terms: int) -> Function:
    """Centre distance in closed form; the rotation needs no series."""
    parameters = SX.sym("parameters", {len(parameters_of(curve))})
{_unpacked(curve)}
    hoisted = vertcat({Printer(CASADI)(curve.centre_distance())}, SX.zeros(terms))
    return Function("prologue", [parameters], [hoisted], ["parameters"], ["hoisted"])


def tangent(terms: int) -> Function:
    """Jacobian of the prologue in the parameters."""
    parameters, hoisted = SX.sym("parameters", {len(parameters_of(curve))}), SX.sym("hoisted", 1 + terms)
    along = jacobian(prologue(terms)(parameters), parameters)
    return Function("tangent", [parameters, hoisted], [along], ["parameters", "hoisted"], ["along"])'''


def _casadi_closure(curve: PitchCurve) -> str:
    return f'''def nodes(terms: int) -> tuple[DM, SX, SX]:
    """Quadrature by midpoints of half a turn, which is spectrally accurate for an even curve.

    The cosines of the series there, the parameters and the radii.
    """
    u = DM([pi * (j + 0.5) / (2 * terms) for j in range(2 * terms)])
    cosines = cos(DM(range(1, terms + 1)) @ u.T) / terms
    parameters = SX.sym("parameters", {len(parameters_of(curve))})
{_unpacked(curve)}
    radii = {Printer(CASADI)(curve.radius())}
    return cosines, parameters, radii


def prologue(terms: int) -> Function:
    """Centre distance by closure (the mean ratio is 1), then the cosine series of the ratio."""
    cosines, parameters, radii = nodes(terms)
    a = SX.sym("a")
    ratios = radii / (a - radii)
    start = Function("start", [parameters], [fmax(sum1(radii) / terms, mmax(radii) * (1 + 1e-6))])
    closure = Function("closure", [a, parameters], [sum1(ratios) / (2 * terms) - 1])
    at_nodes = Function("ratios", [a, parameters], [ratios])

    given = MX.sym("parameters", {len(parameters_of(curve))})
    root = rootfinder("root", "fast_newton", closure, {{"abstol": 1e-14, "abstolStep": 1e-14, "max_iter": 100}})
    distance = root(start(given), given)
    hoisted = vertcat(distance, cosines @ at_nodes(distance, given))
    return Function("prologue", [given], [hoisted], ["parameters"], ["hoisted"])


def tangent(terms: int) -> Function:
    """Jacobian of the prologue in the parameters; that of the centre distance by the implicit function theorem."""
    cosines, parameters, radii = nodes(terms)
    a = SX.sym("a")
    ratios = radii / (a - radii)
    along_a, along_parameters = jacobian(ratios, a), jacobian(ratios, parameters)
    moved = -sum1(along_parameters) / sum1(along_a)
    at_nodes = Function("slopes", [a, parameters], [moved, along_parameters + along_a @ moved])

    given, hoisted = MX.sym("parameters", {len(parameters_of(curve))}), MX.sym("hoisted", 1 + terms)
    along_distance, along_ratios = at_nodes(hoisted[0], given)
    along = vertcat(along_distance, cosines @ along_ratios)
    return Function("tangent", [given, hoisted], [along], ["parameters", "hoisted"], ["along"])'''


def _array_prologue(curve: PitchCurve) -> str:
    if not _by_series(curve) and not _by_closure(curve):
        return f'''def prologue(xp, parameters, terms):
    """Centre distance in closed form; the rotation needs no series."""
{_unpacked(curve)}
    return [{Printer(ARRAY)(curve.centre_distance())}, *([0] * terms)]'''
    return f'''def prologue(xp, parameters, terms):
    """Centre distance by closure (the mean ratio is 1), then the cosine series of the ratio."""
{_unpacked(curve)}
    nodes = [xp.pi * (2 * j + 1) / (4 * terms) for j in range(2 * terms)]
    radii = [{Printer(ARRAY)(curve.radius())} for u in nodes]
    a = sum(radii) / terms
    for r in radii:
        a = xp.maximum(a, r * (1 + 1e-6))
    for _ in range(50):
        ratios = [r / (a - r) for r in radii]
        slope = -sum(r / (a - r) ** 2 for r in radii)
        a = a - (sum(ratios) - 2 * terms) / slope
    series = [sum(f * xp.cos(k * u) for f, u in zip(ratios, nodes)) / terms for k in range(1, terms + 1)]
    return [a, *series]'''
