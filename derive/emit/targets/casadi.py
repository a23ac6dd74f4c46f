"""Modules that build CasADi functions."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence

from ...mechanics.gearing.pitch_curve import PitchCurve
from ...model import System
from ...quantity import OpenVector, Quantity
from ..expression import PLAIN, Dialect, Printer
from ..folder import Target
from ..text import (
    HOISTED,
    NOTICE,
    Emitted,
    describe_composed,
    describe_vectors,
    fill_text,
    format_unpacking,
    in_closed_form,
    pack_parameters,
)

SOLVER = '''def solved(matrix: list[list[SX]], right: list[SX]) -> tuple[SX, ...]:
    """The unknowns of simultaneous equations, then the least pivot over the largest entry of its column.

    Elimination; the row with the largest entry of a column is brought up by selection.
    """
    rows, least = [[SX(entry) for entry in (*row, value)] for row, value in zip(matrix, right)], SX(1)
    n = len(rows)
    sizes = [mmax(fabs(vertcat(*(row[k] for row in rows)))) for k in range(n)]
    for k in range(n):
        for i in (i for i in range(k + 1, n) if not rows[i][k].is_zero()):
            larger = fabs(rows[i][k]) > fabs(rows[k][k])
            pairs = list(zip(rows[i], rows[k]))
            rows[k] = [if_else(larger, below, above) for below, above in pairs]
            rows[i] = [if_else(larger, above, below) for below, above in pairs]
        least = fmin(least, fabs(rows[k][k]) / sizes[k])
        for i in (i for i in range(k + 1, n) if not rows[i][k].is_zero()):
            share = rows[i][k] / rows[k][k]
            rows[i] = [below - share * above for below, above in zip(rows[i], rows[k])]
    found = [SX(0)] * n
    for k in reversed(range(n)):
        known = sum(rows[k][i] * found[i] for i in range(k + 1, n))
        found[k] = (rows[k][n] - known) / rows[k][k]
    return *found, least'''
"""Elimination, for modules with simultaneous equations."""
CASADI = Dialect(
    {f: f for f in PLAIN}
    | {
        "abs": "fabs",
        "min": "fmin",
        "max": "fmax",
        "select": "if_else",
        "and": "logic_and",
        "or": "logic_or",
        "not": "logic_not",
        "pi": "pi",
    },
    ratio="{0} / {1}",
    length="{0}.numel()",
    solver=SOLVER,
)
ALWAYS = ("Function", "SX", "vertcat")
"""What every module imports, whatever its expressions hold."""
SOLVING = ("mmax",)
"""What elimination needs besides."""
CLOSED = ("jacobian",)
CLOSURE = ("DM", "MX", "fmax", "jacobian", "mmax", "rootfinder", "sum1")
"""What the module of a pitch curve imports besides: with a centre distance in closed form, and by
closure.
"""
WIDTH = 112


def model(system: System, functions: Sequence[Emitted]) -> str:
    """The text of a module with one builder per function."""
    solver = [SOLVER] if any(f.solves for f in functions) else []
    builders = "\n\n\n".join((*solver, *map(_builder, functions)))
    docstring = "\n".join(
        (
            f"{system.title}: CasADi functions.",
            "",
            NOTICE,
            f"Source: {system.source}.",
            *textwrap.wrap(f"Assumes: {'; '.join(system.assumptions)}.", WIDTH),
            *textwrap.wrap(
                f"Operations: {', '.join(f'{f.name} {f.operations}' for f in functions)}.", WIDTH
            ),
            "",
            *fill_text(f"{describe_composed(system.functions)} Inputs:".lstrip(), WIDTH),
            "",
            describe_vectors(system.inputs),
        )
    )
    return f'"""{_escape_docstring(docstring)}\n"""\n\n{_imports(builders)}\n\n\n{builders}\n'


def _escape_docstring(text: str) -> str:
    """Return a text for a docstring."""
    return text.replace("\\", r"\\").replace('"""', "'''")


def _imports(text: str, besides: Sequence[str] = ()) -> str:
    """An import of the CasADi names that a text uses."""
    used = {
        name for name in (*CASADI.functions.values(), *SOLVING) if re.search(rf"\b{name}\b", text)
    }
    names = sorted(
        used.union(ALWAYS, besides), key=lambda n: (n.upper() != n, not n[0].isupper(), n)
    )
    return "from casadi import (\n" + "".join(f"    {n},\n" for n in names) + ")"


def _builder(function: Emitted) -> str:
    signature = ", ".join(f"{composed.name}: Function" for composed in function.functions)
    output = function.output.name
    return f'''def {function.name}({signature}) -> Function:
    """{function.output.name}, {len(function.output)} entries:

{textwrap.indent(_escape_docstring(describe_vectors([function.output])), "    ")}
    """
{_declared(function, _length)}
{function.body(CASADI)}
    {output} = vertcat(
{function.packed(CASADI)}
    )
    inputs = [{function.names()}]
    return Function("{function.name}", inputs, [{output}], [{function.quoted()}], ["{output}"])'''


def _declared(function: Emitted, length: Callable[[OpenVector], str]) -> str:
    """Symbols for what a function takes; ``length`` writes that of an open vector."""
    sizes = [
        "" if isinstance(v, Quantity) else f", {length(v) if isinstance(v, OpenVector) else len(v)}"
        for v in function.inputs
    ]
    pairs = zip(function.inputs, sizes, strict=True)
    return "\n".join(f'    {v.name} = SX.sym("{v.name}"{size})' for v, size in pairs)


def _length(vector: OpenVector) -> str:
    if vector.sized_by is None:
        raise ValueError(
            f"vector {vector.name}: nothing says how long it is; name what it is sized by"
        )
    function, argument = vector.sized_by
    return f'{function}.size1_in("{argument}")'


def curve(curve: PitchCurve, functions: Sequence[Emitted]) -> str:
    """The text of a module with a builder per function of a pitch curve, the prologue and its
    tangent.
    """
    closed = in_closed_form(curve)
    prologue = _closed(curve) if closed else _closure(curve)
    builders = "\n\n\n".join((prologue, *map(_curve_builder, functions)))
    return f'''"""{curve.title.capitalize()}: CasADi functions of a pitch curve and its conjugate.

{NOTICE}
{describe_vectors([pack_parameters(curve), HOISTED])}
"""

{_imports(builders, CLOSED if closed else CLOSURE)}


{builders}
'''


def _curve_builder(function: Emitted) -> str:
    terms = "terms: int" if HOISTED in function.inputs else ""
    single = ", ".join(f'"{q.name}"' for q in function.output)
    return f'''def {function.name}({terms}) -> Function:
    """{function.operations} operations. {_describe_given(function)}"""
{_declared(function, lambda _: "1 + terms")}
{function.body(CASADI)}
    outputs = [
{function.packed(CASADI)}
    ]
    return Function("{function.name}", [{function.names()}], outputs, [{function.quoted()}], [{single}])'''


def _describe_given(function: Emitted) -> str:
    """The outputs, each with unit and meaning, for a docstring; conditions speak in the sidecar."""
    if function.results:
        return "Each output must be positive; the sidecar names them."
    lines = "\n    ".join(f"    {q.name} [{q.unit}] {q.meaning}" for q in function.output)
    return f"Outputs:\n\n    {lines}\n    "


def _closed(curve: PitchCurve) -> str:
    return f'''def prologue(terms: int) -> Function:
    """Centre distance in closed form; the rotation needs no series."""
    parameters = SX.sym("parameters", {len(pack_parameters(curve))})
{format_unpacking(curve.parameters, "parameters")}
    hoisted = vertcat({Printer(CASADI)(curve.centre_distance())}, SX.zeros(terms))
    return Function("prologue", [parameters], [hoisted], ["parameters"], ["hoisted"])


def tangent(terms: int) -> Function:
    """Jacobian of the prologue in the parameters."""
    parameters, hoisted = SX.sym("parameters", {len(pack_parameters(curve))}), SX.sym("hoisted", 1 + terms)
    along = jacobian(prologue(terms)(parameters), parameters)
    return Function("tangent", [parameters, hoisted], [along], ["parameters", "hoisted"], ["along"])'''


def _closure(curve: PitchCurve) -> str:
    return f'''def nodes(terms: int) -> tuple[DM, SX, SX]:
    """Quadrature by midpoints of half a turn, which is spectrally accurate for an even curve.

    The cosines of the series there, the parameters and the radii.
    """
    u = DM([pi * (j + 0.5) / (2 * terms) for j in range(2 * terms)])
    cosines = cos(DM(range(1, terms + 1)) @ u.T) / terms
    parameters = SX.sym("parameters", {len(pack_parameters(curve))})
{format_unpacking(curve.parameters, "parameters")}
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

    given = MX.sym("parameters", {len(pack_parameters(curve))})
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

    given, hoisted = MX.sym("parameters", {len(pack_parameters(curve))}), MX.sym("hoisted", 1 + terms)
    along_distance, along_ratios = at_nodes(hoisted[0], given)
    along = vertcat(along_distance, cosines @ along_ratios)
    return Function("tangent", [given, hoisted], [along], ["parameters", "hoisted"], ["along"])'''


TARGET = Target(
    "casadi",
    "{name}.py",
    frozenset({*CASADI.functions.values(), *ALWAYS, "solved", *CLOSED, *CLOSURE}),
    model,
    curve,
)
