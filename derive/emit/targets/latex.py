"""The derivation as a document: what is given, then every step as a numbered equation under its
meaning and source.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

import sympy as sp
from sympy import Basic, Expr
from sympy.core.alphabets import greeks

from ...functions import Polynomial, Turns
from ...mechanics.gearing.pitch_curve import PitchCurve
from ...mechanics.motion_steps import NOTES
from ...model import COMMON, Call, Input, LinearSolve, SineSeries, Step, System, join_entries
from ...quantity import OpenVector, Quantity
from ..folder import Target
from ..text import HOISTED, NOTICE, Emitted, describe_composed, in_closed_form, pack_parameters

DOCUMENT = r"""\documentclass[a4paper]{article}
\usepackage[margin=22mm]{geometry}
\usepackage{amsmath,longtable}
\setlength{\parindent}{0pt}
\emergencystretch=3em
\allowdisplaybreaks
\title{%s}
\author{}
\date{}
\begin{document}
\maketitle
%s
\end{document}
"""
CAPITALS = (
    "Gamma",
    "Delta",
    "Theta",
    "Lambda",
    "Xi",
    "Pi",
    "Sigma",
    "Upsilon",
    "Phi",
    "Psi",
    "Omega",
)
GREEK = frozenset((*greeks, *CAPITALS)) - {"omicron"}
ACCENTS = {"dot": r"\dot", "ddot": r"\ddot"}
SPECIAL = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
}
ROOM = 78
"""Signs of an equation that go on a line."""


def model(system: System, functions: Sequence[Emitted]) -> str:
    """A document on a model."""
    assumed = (
        f"Source: {system.source}. Assumes: {'; '.join(system.assumptions)}. "
        f"{describe_composed(system.functions)}"
    )
    return _document(system.title, assumed, system.inputs, _sections(functions))


def curve(curve: PitchCurve, functions: Sequence[Emitted]) -> str:
    """A document on a pitch curve and its conjugate."""
    sections = (*_prologue(curve), *_sections(functions))
    return _document(
        f"{curve.title.capitalize()}",
        "Pitch curve and conjugate.",
        (pack_parameters(curve),),
        sections,
    )


def _document(title: str, about: str, inputs: Sequence[Input], sections: Iterable[str]) -> str:
    table = _table([quantity for packed in inputs for quantity in join_entries(packed)])
    open_ones = [
        f"{_code(v.name)}: {_plain(v.meaning)}." for v in inputs if isinstance(v, OpenVector)
    ]
    lines = (_plain(f"{about} {NOTICE}"), r"\section*{Given}", *table, *open_ones, *sections)
    return DOCUMENT % (_plain(title), "\n".join(lines))


def _table(quantities: Iterable[Quantity]) -> list[str]:
    rows = [
        f"${symbol(q)}$ & {_code(q.name)} & {_unit(q.unit)} & {_plain(q.meaning)} & "
        f"{_plain(q.source)}"
        r" \\"
        for q in dict.fromkeys(quantities)
    ]
    columns = r"\begin{longtable}{lllp{0.4\textwidth}p{0.2\textwidth}}"
    return [
        columns,
        r"symbol & name & unit & meaning & source \\ \hline \endhead",
        *rows,
        r"\end{longtable}",
    ]


def _sections(functions: Iterable[Emitted]) -> Iterator[str]:
    """A section a function; a step that stands as it is further up is not repeated."""
    above: dict[sp.Symbol, Step] = {}
    for function in functions:
        new = [step for step in function.steps if above.get(step.defines[0]) != step]
        above |= {step.defines[0]: step for step in new}
        yield rf"\section*{{{_plain(function.name)}}}"
        gives = ", ".join(f"${_math(e)}$" for e in function.returned)
        repeated = " What stands above is not repeated." if len(new) < len(function.steps) else ""
        yield f"Gives {_code(function.output.name)}: {gives}.{repeated}\n"
        for is_short, some in groupby(new, key=_is_abbreviation):
            if is_short:
                yield _aligned(some)
            else:
                yield from map(_format_step, some)


def _is_abbreviation(step: Step) -> bool:
    """Whether a step continues others and has no meaning of its own."""
    quantity = step.defines[0]
    has_meaning = isinstance(quantity, Quantity) and quantity.meaning not in NOTES.values()
    return step.source == COMMON and not has_meaning


def _aligned(steps: Iterable[Step]) -> str:
    """Abbreviations, which have no meaning."""
    lines = " \\\\\n".join(map(_equations, steps))
    return f"\\begin{{align}}\n{lines}\n\\end{{align}}"


def _format_step(step: Step) -> str:
    """A step under what it defines and where it comes from."""
    symbols_shown = step.symbols if isinstance(step, LinearSolve) else step.defines
    named = "; ".join(
        f"{_plain(q.meaning)} [{_unit(q.unit)}], {_code(q.name)}" for q in symbols_shown
    )
    source = "" if step.source == COMMON else f" ({_plain(step.source)})"
    equations = f"\\begin{{align}}\n{_equations(step)}\n\\end{{align}}"
    return f"{named[:1].upper()}{named[1:]}{source}:\n{equations}"


def _equations(step: Step) -> str:
    if isinstance(step, LinearSolve):
        rows = (sp.Add(*map(sp.Mul, row, step.symbols)) for row in step.matrix)
        return " \\\\\n".join(
            _broken(_math(row), right) for row, right in zip(rows, step.right, strict=True)
        )
    if isinstance(step, Call):
        outputs = ", ".join(symbol(q) if q is not None else r"\cdot" for q in step.outputs)
        arguments = ", ".join((_math(step.argument), *(_word(v.name) for v in step.vectors)))
        return rf"\left({outputs}\right) &= {_word(step.function.name)}\left({arguments}\right)"
    if isinstance(step, SineSeries):
        return rf"{symbol(step.symbol)} &= \sum_k b_k \, \sin(k \, {symbol(step.argument)}) / k"
    return _broken(symbol(step.symbol), step.expr)


def _broken(left: str, right: Expr) -> str:
    """An equation, broken between the terms of its right-hand side where it is too long for a
    line.
    """
    lines, length = [f"{left} &= "], _length(left)
    for term in right.as_ordered_terms() if isinstance(right, sp.Add) else [right]:
        text = _math(term)
        signed = text if lines == [f"{left} &= "] or text.startswith("-") else f"+ {text}"
        if length + _length(text) > ROOM and length > _length(left):
            lines.append(r"& \quad ")
            length = 0
        lines[-1] += f"{signed} "
        length += _length(text)
    return " \\nonumber \\\\\n".join(line.rstrip() for line in lines)


def _length(text: str) -> int:
    """About how many signs of it are seen side by side."""
    return len(
        re.sub(
            r"[{}_^\s]|\\,",
            "",
            re.sub(r"\\(left|right|mathrm|frac)\b", "", re.sub(r"\\[a-z]{2,}", "x", text)),
        )
    )


def _math(expr: Expr) -> str:
    written = expr.replace(Turns, sp.floor).replace(
        lambda e: isinstance(e, Polynomial), lambda e: e.doit()
    )
    names = {s: symbol(s) for s in sorted(written.free_symbols, key=str)}
    text: str = sp.latex(written, symbol_names=names, mul_symbol=r"\,")
    return text


def symbol(quantity: Basic) -> str:
    """The symbol of a name: `phi52_dot` is a dotted phi with the index 52."""
    first, *parts = str(quantity).strip("_").split("_")
    head = first.rstrip("0123456789") or first
    accent = ACCENTS[parts.pop()] if parts and parts[-1] in ACCENTS else ""
    base = rf"\{head}" if head in GREEK else head if len(head) == 1 else rf"\mathit{{{head}}}"
    index = ", ".join(filter(None, (first.removeprefix(head), *parts)))
    index = index if index.isdecimal() or not index else rf"\mathrm{{{index}}}"
    star = "^{*}" if str(quantity).endswith("_") else ""
    return (rf"{accent}{{{base}}}" if accent else base) + (f"_{{{index}}}" if index else "") + star


def _word(name: str) -> str:
    return rf"\mathrm{{{_plain(name)}}}"


def _unit(unit: str) -> str:
    return re.sub(r"([a-z])(\d)", r"\1$^\2$", _plain(unit))


def _plain(text: str) -> str:
    return "".join(SPECIAL.get(sign, sign) for sign in text)


def _code(name: str) -> str:
    return rf"\texttt{{{_plain(name)}}}"


def _prologue(curve: PitchCurve) -> list[str]:
    """Centre distance and rotation: in closed form, or what closes them."""
    distance, radius = symbol(HOISTED.known[0]), _math(curve.radius())
    lines = [r"\section*{prologue}", rf"\begin{{align}} r &= {radius} \\"]
    if in_closed_form(curve):
        return [*lines, rf"{distance} &= {_math(curve.centre_distance())} \end{{align}}"]
    return [
        *lines,
        rf"1 &= \frac{{1}}{{\pi}} \int_0^\pi \frac{{r}}{{{distance} - r}} \, \mathrm{{d}}u \\",
        rf"b_k &= \frac{{2}}{{\pi}} \int_0^\pi \frac{{r}}{{{distance} - r}} \, \cos(k \, u) \, "
        rf"\mathrm{{d}}u",
        r"\end{align}",
    ]


TARGET = Target("latex", "latex/{name}.tex", frozenset(), model, curve, on_request=True)
