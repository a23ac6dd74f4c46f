"""Modules of array code: the same steps for NumPy, JAX, mpmath and complex step."""

from __future__ import annotations

from collections.abc import Sequence

from ...mechanics.gearing.pitch_curve import PitchCurve
from ...model import SineSeries, System
from ..expression import PLAIN, Dialect, Printer
from ..folder import Target
from ..text import NOTICE, Emitted, describe_composed, fill_text, format_unpacking, in_closed_form

SOLVER = '''def solved(xp, matrix, right):
    """The unknowns of simultaneous equations, then the least pivot over the largest entry of its column.

    Elimination; the row with the largest entry of a column is brought up by selection. Zeros of the matrix stay zeros.
    """
    rows, least = [[*row, value] for row, value in zip(matrix, right)], 1.0
    n = len(rows)
    sizes = [xp.absolute(rows[0][k]) for k in range(n)]
    for k in range(n):
        for row in rows[1:]:
            sizes[k] = xp.maximum(sizes[k], xp.absolute(row[k]))

    def is_zero(entry):
        return isinstance(entry, int) and entry == 0

    def select(condition, first, second):
        return first if is_zero(first) and is_zero(second) else xp.where(condition, first, second)

    for k in range(n):
        below_k = [i for i in range(k + 1, n) if not is_zero(rows[i][k])]
        for i in below_k:
            larger = xp.absolute(rows[i][k]) > xp.absolute(rows[k][k])
            pairs = list(zip(rows[i], rows[k]))
            rows[k] = [select(larger, below, above) for below, above in pairs]
            rows[i] = [select(larger, above, below) for below, above in pairs]
        least = xp.minimum(least, xp.absolute(rows[k][k]) / sizes[k])
        for i in below_k:
            share = rows[i][k] / rows[k][k]
            rows[i] = [
                below if is_zero(above) else below - share * above for below, above in zip(rows[i], rows[k])
            ]
    found = [0] * n
    for k in reversed(range(n)):
        known = sum(rows[k][i] * found[i] for i in range(k + 1, n) if not is_zero(rows[k][i]))
        found[k] = (rows[k][n] - known) / rows[k][k]
    return *found, least'''
ARRAY = Dialect(
    {f: f"xp.{f}" for f in PLAIN}
    | {
        "acos": "xp.arccos",
        "asin": "xp.arcsin",
        "atan": "xp.arctan",
        "atan2": "xp.arctan2",
        "abs": "xp.absolute",
        "min": "xp.minimum",
        "max": "xp.maximum",
        "select": "xp.where",
        "and": "xp.logical_and",
        "or": "xp.logical_or",
        "not": "xp.logical_not",
        "pi": "xp.pi",
    },
    ratio="xp.divide({0}, {1})",
    length="len({0})",
    solver=SOLVER,
    first=("xp",),
    series="sine_series",
)
MEANT = """`xp` is a module of elementary functions under NumPy's names: numpy, jax.numpy, or a few lines around mpmath.
Packed inputs are indexed along their first axis, so an entry may itself be an array."""
WIDTH = 118


SERIES = '''def sine_series(xp, u, b):
    """Sum over k of b[k] sin(k u) / k, by Clenshaw's recurrence."""
    twice_cos, last, before = 2 * xp.cos(u), 0, 0
    for k in range(len(b) - 1, 0, -1):
        last, before = b[k] / k + twice_cos * last - before, last
    return last * xp.sin(u)'''


def model(system: System, functions: Sequence[Emitted]) -> str:
    """The text of a module with the functions of a model."""
    solver = [SOLVER] if any(f.solves for f in functions) else []
    texts = "\n\n\n".join((*solver, *_helpers(functions), *map(_function, functions)))
    meant = "\n".join(
        fill_text(f"{MEANT} {describe_composed(system.functions, ARRAY.first)}", WIDTH)
    )
    return f'''"""{system.title}: array code.

{NOTICE}
{meant}
"""


{texts}
'''


def _helpers(functions: Sequence[Emitted]) -> list[str]:
    return [SERIES] if any(map(_sums, functions)) else []


def _sums(function: Emitted) -> bool:
    return any(isinstance(step, SineSeries) for step in function.steps)


def _function(function: Emitted) -> str:
    parameters = "".join(f", {composed.name}" for composed in function.functions)
    return f'''def {function.name}(xp, {function.names()}{parameters}):
    """{function.output.name}: {len(function.output)} entries in the order of the CasADi function."""
{function.body(ARRAY)}
    return (
{function.packed(ARRAY)},
    )'''


def curve(curve: PitchCurve, functions: Sequence[Emitted]) -> str:
    """The text of a module with the functions of a pitch curve and its prologue."""
    texts = "\n\n\n".join(
        (_prologue(curve), *_helpers(functions), *map(_curve_function, functions))
    )
    return f'''"""{curve.title.capitalize()}: array code of a pitch curve and its conjugate.

{NOTICE}
`xp` is a module of elementary functions under NumPy's names.
"""


{texts}
'''


def _curve_function(function: Emitted) -> str:
    """A function that sums a series takes another way to do so, if one likes."""
    otherwise = ", sine_series=sine_series" if _sums(function) else ""
    return f'''def {function.name}(xp, {function.names()}{otherwise}):
    """{", ".join(q.name for q in function.output)}."""
{function.body(ARRAY)}
    return (
{function.packed(ARRAY)},
    )'''


def _prologue(curve: PitchCurve) -> str:
    if in_closed_form(curve):
        return f'''def prologue(xp, parameters, terms):
    """Centre distance in closed form; the rotation needs no series."""
{format_unpacking(curve.parameters, "parameters")}
    return [{Printer(ARRAY)(curve.centre_distance())}, *([0] * terms)]'''
    return f'''def radii(xp, parameters, terms):
    """Parameters of the midpoints of half a turn, and the radii there."""
{format_unpacking(curve.parameters, "parameters")}
    nodes = [xp.pi * (2 * j + 1) / (4 * terms) for j in range(2 * terms)]
    return nodes, [{Printer(ARRAY)(curve.radius())} for u in nodes]


def closure(a, radii):
    """Ratios at the midpoints, what their sum exceeds a mean of 1 by, and the slope of that in the centre distance."""
    ratios = [r / (a - r) for r in radii]
    slope = -sum(r / (a - r) ** 2 for r in radii)
    return ratios, sum(ratios) - len(radii), slope


def series(xp, ratios, nodes):
    """Cosine series of the ratio."""
    terms = len(nodes) // 2
    return [sum(f * xp.cos(k * u) for f, u in zip(ratios, nodes)) / terms for k in range(1, terms + 1)]


def prologue(xp, parameters, terms):
    """Centre distance by closure (the mean ratio is 1), then the cosine series of the ratio."""
    nodes, at_nodes = radii(xp, parameters, terms)
    a = sum(at_nodes) / terms
    for r in at_nodes:
        a = xp.maximum(a, r * (1 + 1e-6))
    for _ in range(50):
        ratios, excess, slope = closure(a, at_nodes)
        a = a - excess / slope
    return [a, *series(xp, ratios, nodes)]'''


TARGET = Target("array", "array/{name}.py", frozenset({"xp", "len", "solved"}), model, curve)
