"""Function files for MATLAB and Octave: a file a module, which gives a structure of its
functions.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence

import sympy as sp

from ...mechanics.gearing.pitch_curve import PitchCurve
from ...model import COMMON, Call, Input, LinearSolve, SineSeries, Step, System
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
    in_closed_form,
    pack_parameters,
)

MATLAB = Dialect(
    {f: f for f in PLAIN}
    | {
        "abs": "abs",
        "min": "min",
        "max": "max",
        "select": "select",
        "and": "and",
        "or": "or",
        "not": "not",
        "pi": "pi",
    },
    ratio="{0} / {1}",
    length="numel({0})",
    power="^",
    differs="~=",
    true="true",
)
WORDS = frozenset(
    (
        "break",
        "case",
        "catch",
        "classdef",
        "continue",
        "else",
        "elseif",
        "end",
        "for",
        "function",
        "global",
        "if",
        "otherwise",
        "parfor",
        "persistent",
        "return",
        "spmd",
        "switch",
        "try",
        "while",
        "do",
        "endfor",
        "endfunction",
        "endif",
        "endswitch",
        "endwhile",
        "until",
        "unwind_protect",
    )
)
"""Words of MATLAB, then of Octave alone."""
HELPERS = {
    "select": """function value = select(condition, then, other)
    if condition
        value = then;
    else
        value = other;
    end
end""",
    "solved": """function values = solved(matrix, right)
    % The unknowns of simultaneous equations, then the least pivot over the largest entry of its column.
    rows = [matrix, right];
    n = size(matrix, 1);
    sizes = max(abs(matrix), [], 1);
    least = 1;
    for k = 1:n
        [~, largest] = max(abs(rows(k:n, k)));
        rows([k, k + largest - 1], :) = rows([k + largest - 1, k], :);
        least = min(least, abs(rows(k, k)) / sizes(k));
        below = k + 1:n;
        rows(below, :) = rows(below, :) - rows(below, k) / rows(k, k) * rows(k, :);
    end
    values = [rows(:, 1:n) \\ rows(:, n + 1); least];
end""",
    "sine_series": """function value = sine_series(u, b)
    % Sum over k of b_k sin(k u) / k; b_k is entry k + 1 of b.
    k = (1:numel(b) - 1)';
    value = sum(reshape(b(2:end), [], 1) .* sin(k * u) ./ k);
end""",
}
"""Functions that a file holds where its own call them."""
MEANT = """Call it once, as in `m = {name}()`; then `m.{first}({names})` and the others. SI units and radians; an
angle is a scalar, packed inputs are vectors, and every function gives a column."""
WIDTH = 112


def model(system: System, functions: Sequence[Emitted]) -> str:
    """The text of a file with the functions of a model."""
    inputs = (
        f"{describe_composed(system.functions)} Inputs:".lstrip(),
        "",
        *describe_vectors(system.inputs).split("\n"),
    )
    assumed = fill_text(f"Assumes: {'; '.join(system.assumptions)}.", WIDTH)
    head = (f"{system.title}.", "", NOTICE, f"Source: {system.source}.", *assumed, "")
    return _file(system.name, functions, (*head, *_meant(system.name, functions), *inputs))


def curve(curve: PitchCurve, functions: Sequence[Emitted]) -> str:
    """The text of a file with the functions of a pitch curve and its prologue."""
    name = f"curve_{curve.name}"
    head = (f"{curve.title.capitalize()}: pitch curve and conjugate.", "", NOTICE, "")
    inputs = describe_vectors([pack_parameters(curve), HOISTED]).split("\n")
    meant = (*_meant(name, functions), "`m.prologue(parameters, terms)` gives what is hoisted.", "")
    return _file(name, functions, (*head, *meant, *inputs), _prologue(curve))


def _meant(name: str, functions: Sequence[Emitted]) -> list[str]:
    first = functions[0]
    return fill_text(MEANT.format(name=name, first=first.name, names=_taken(first)), WIDTH)


def _file(name: str, functions: Sequence[Emitted], head: Iterable[str], *first_bodies: str) -> str:
    """A function that gives handles of all that follow it, those first that others call by name."""
    bodies = "\n\n".join((*first_bodies, *map(_function, functions)))
    helpers = [text for helper, text in HELPERS.items() if re.search(rf"\b{helper}\(", bodies)]
    names = [*(["prologue"] if first_bodies else []), *(f.name for f in functions)]
    lines = (*_comments(head), *(f"module.{name} = @{name};" for name in names))
    first = f"function module = {name}()\n{_indented(lines)}\nend"
    return "\n\n".join((first, *helpers, bodies)) + "\n"


def _function(function: Emitted) -> str:
    _refuse_names(function)
    remark = (
        f"{function.output.name}, {len(function.output)} entries:",
        *describe_vectors([function.output]).split("\n")[1:],
    )
    lines = [
        *_comments(remark),
        *(line for packed in function.inputs for line in _unpacked(packed, function.used)),
        *(line for step in function.steps for line in _step(step)),
        *_broken(f"values = [{'; '.join(map(WRITE, function.returned))}];"),
    ]
    return f"function values = {function.name}({_taken(function)})\n{_indented(lines)}\nend"


def _taken(function: Emitted) -> str:
    return ", ".join(argument.name for argument in (*function.inputs, *function.functions))


def _refuse_names(function: Emitted) -> None:
    for name in function.speaks:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name):
            allowed = "a name in MATLAB is a letter, then up to 62 letters, digits and underscores"
            raise ValueError(f"function {function.name}: {name}: {allowed}")


def _unpacked(packed: Input, used: frozenset[sp.Symbol]) -> list[str]:
    """Entries of a packed input that the steps use; those of an open one may be counted from its
    end.
    """
    if isinstance(packed, Quantity):
        return []
    entries = packed.known.items() if isinstance(packed, OpenVector) else enumerate(packed)
    return [f"{q.name} = {packed.name}({_place(i)});{_note(q)}" for i, q in entries if q in used]


def _place(index: int) -> str:
    """Return the index in a list that counts from one, or back from its end."""
    return str(index + 1) if index >= 0 else f"end - {-index - 1}"


def _note(quantity: sp.Symbol) -> str:
    return f" % [{quantity.unit}] {quantity.meaning}" if isinstance(quantity, Quantity) else ""


WRITE = Printer(MATLAB)


def _step(step: Step) -> Iterator[str]:
    if step.source != COMMON:
        yield from _comments([step.source])
    if isinstance(step, Call):
        arguments = ", ".join((WRITE(step.argument), *(v.name for v in step.vectors)))
        yield from _entries(f"{step.function.name}({arguments})", step.outputs)
    elif isinstance(step, LinearSolve):
        rows = "; ".join(", ".join(map(WRITE, row)) for row in step.matrix)
        yield from _entries(
            f"solved([{rows}], [{'; '.join(map(WRITE, step.right))}])", step.defines
        )
    elif isinstance(step, SineSeries):
        yield f"{step.symbol.name} = sine_series({step.argument.name}, {step.coefficients.name});"
    else:
        yield from _broken(f"{step.symbol.name} = {WRITE(step.expr)};")


def _entries(column: str, names: Iterable[Quantity | None]) -> Iterator[str]:
    """Quantities that are entries of a column."""
    yield from _broken(f"found = {column};")
    yield from (f"{q.name} = found({i});" for i, q in enumerate(names, 1) if q is not None)


def _broken(statement: str) -> list[str]:
    """A statement over as many lines as it needs."""
    lines = textwrap.wrap(
        statement, WIDTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
    return [*(f"{line} ..." for line in lines[:-1]), lines[-1]]


def _comments(lines: Iterable[str]) -> Iterator[str]:
    for line in lines:
        deeper = " " * (len(line) - len(line.lstrip()) + 4)
        broken = textwrap.wrap(line, WIDTH, subsequent_indent=deeper, break_on_hyphens=False)
        yield from (f"% {part}".rstrip() for part in broken or [""])


def _indented(lines: Iterable[str]) -> str:
    return textwrap.indent("\n".join(lines), "    ")


def _prologue(curve: PitchCurve) -> str:
    unpacked = "\n".join(
        f"    {q.name} = parameters({i});" for i, q in enumerate(curve.parameters, 1)
    )
    if in_closed_form(curve):
        return f"""function values = prologue(parameters, terms)
    % Centre distance in closed form; the rotation needs no series.
{unpacked}
    values = [{WRITE(curve.centre_distance())}; zeros(terms, 1)];
end"""
    return f"""function r = radius(parameters, u)
    % Radius at the parameter u.
{unpacked}
    r = {WRITE(curve.radius())};
end

function values = prologue(parameters, terms)
    % Centre distance by closure (the mean ratio is 1), then the cosine series of the ratio.
    nodes = pi * (2 * (0:2 * terms - 1)' + 1) / (4 * terms);
    radii = arrayfun(@(u) radius(parameters, u), nodes);
    a = max(sum(radii) / terms, max(radii) * (1 + 1e-6));
    for k = 1:50
        ratios = radii ./ (a - radii);
        a = a + (sum(ratios) - numel(radii)) / sum(radii ./ (a - radii).^2);
    end
    values = [a; cos((1:terms)' * nodes') * ratios / terms];
end"""


RESERVED = WORDS.union(HELPERS, MATLAB.functions.values(), ("found", "values"))
TARGET = Target("matlab", "matlab/{name}.m", RESERVED, model, curve, on_request=True)
