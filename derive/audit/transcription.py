"""Formulas as they were typed: in the order and with the signs of the print, which an expression
does not keep.
"""

from __future__ import annotations

import ast
import linecache
import re
from collections.abc import Iterator
from functools import cache
from html import escape
from types import CodeType, FrameType

import sympy as sp
from sympy import Basic

from .typesetting import (
    GREEK,
    MINUS,
    PLUS,
    RELATIONS,
    TIMES,
    add_brackets,
    typeset_symbol,
)

KEPT = (ast.BinOp, ast.UnaryOp, ast.Compare, ast.Tuple, ast.operator, ast.unaryop, ast.cmpop)
"""Nodes that are taken over as they stand."""


def transcribe_call(frame: FrameType, count: int) -> list[str]:
    """Return the arguments of the call that a frame is at, after the first, as they were typed:
    ``count`` of them, with each name as the symbol that it stands for.

    None of them where the source is not known, or is no formula.
    """
    call = _find_call(frame.f_code, frame.f_lasti)
    if call is None or len(call.args) <= count:
        return []
    writer = _Writer(frame)
    try:
        return [ast.unparse(writer.visit(_copy(part))) for part in call.args[1 : count + 1]]
    except Exception:  # a program may compute its formulas in any way
        return []


def _copy(node: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(node), mode="eval").body


def _find_call(code: CodeType, instruction: int) -> ast.Call | None:
    positions = list(code.co_positions())[instruction // 2]
    return _calls(code.co_filename).get(positions)


@cache
def _calls(filename: str) -> dict[tuple[int | None, ...], ast.Call]:
    """Return the calls in a file by their place, as code objects have it."""
    try:
        tree = ast.parse("".join(linecache.getlines(filename)))
    except SyntaxError:
        return {}
    nodes: Iterator[ast.AST] = ast.walk(tree)
    return {
        (node.lineno, node.end_lineno, node.col_offset, node.end_col_offset): node
        for node in nodes
        if isinstance(node, ast.Call)
    }


class _Writer(ast.NodeTransformer):
    """Writes what is computed in Python as what it is: symbols by name, numbers as they are
    printed.
    """

    def __init__(self, frame: FrameType) -> None:
        self.frame = frame

    def visit(self, node: ast.AST) -> ast.AST:
        """Return a node of a formula; what is none of mathematics by its value."""
        if isinstance(node, ast.Constant | ast.expr_context):
            return node
        if isinstance(node, KEPT):
            return self.generic_visit(node)
        if isinstance(node, ast.Call):
            function = self._evaluate(node.func)
            if function is sp.Rational and isinstance(node.args[0], ast.Constant):
                return ast.Name(str(node.args[0].value))
            if function is sp.sqrt or (
                isinstance(function, type) and issubclass(function, sp.Function | sp.Abs)
            ):
                name = ast.Name("sqrt" if function is sp.sqrt else function.__name__)
                arguments = (self.visit(part) for part in node.args)
                return ast.Call(name, [a for a in arguments if isinstance(a, ast.expr)], [])
        return ast.parse(str(self._evaluate(node)), mode="eval").body

    def _evaluate(self, node: ast.AST) -> object:
        """Return the value of a part of the program that states the paper."""
        text = ast.unparse(node)
        value: object = eval(text, self.frame.f_globals, self.frame.f_locals)
        return (
            value if isinstance(value, Basic | int | float | str) or callable(value) else str(value)
        )


SUM, PRODUCT, POWER, ATOM = range(4)
"""How strongly the parts of a formula are bound."""


def typeset_transcription(text: str) -> str:
    """Return a formula as it was typed, in MathML: order, signs and brackets are those of the
    print.
    """
    words = re.split(r" (=|<=|>=|<|>) (?![^(]*\))", text, maxsplit=1)
    sides = [_typeset(ast.parse(side, mode="eval").body)[0] for side in words[::2]]
    sign = escape(RELATIONS.get(words[1], words[1]), quote=False)
    content = f"<mo>{sign}</mo>".join(sides)
    note = f'<annotation encoding="text/plain">{escape(text, quote=False)}</annotation>'
    row = f"<semantics><mrow>{content}</mrow>{note}</semantics>"
    return f'<math display="block">{row}</math>'


def _typeset(node: ast.expr) -> tuple[str, int]:
    """Return a part of a formula in MathML, and how strongly it is bound."""
    if isinstance(node, ast.Name):
        letter = GREEK["pi"] if node.id == "pi" else None
        return (f"<mi>{letter}</mi>" if letter else typeset_symbol(node.id)), ATOM
    if isinstance(node, ast.Constant):
        return f"<mn>{node.value!s}</mn>", ATOM
    if isinstance(node, ast.UnaryOp):
        return f"{MINUS}{_bound(node.operand, PRODUCT)}", SUM
    if isinstance(node, ast.Call):
        return _typeset_call(node), ATOM
    if isinstance(node, ast.Compare):
        words = ast.unparse(node).split(ast.unparse(node.left), 1)[1].split()[0]
        sides = _typeset(node.left)[0], _typeset(node.comparators[0])[0]
        return f"<mo>{escape(words, quote=False)}</mo>".join(sides), SUM
    assert isinstance(node, ast.BinOp)
    if isinstance(node.op, ast.Add | ast.Sub):
        sign = PLUS if isinstance(node.op, ast.Add) else MINUS
        return f"{_bound(node.left, SUM)}{sign}{_bound(node.right, PRODUCT)}", SUM
    if isinstance(node.op, ast.Div):
        above, below = (_typeset(part)[0] for part in (node.left, node.right))
        return f"<mfrac><mrow>{above}</mrow><mrow>{below}</mrow></mfrac>", PRODUCT
    if isinstance(node.op, ast.Pow):
        base, power = _bound(node.left, ATOM), _typeset(node.right)[0]
        return f"<msup><mrow>{base}</mrow><mrow>{power}</mrow></msup>", POWER
    return f"{_bound(node.left, PRODUCT)}{TIMES}{_bound(node.right, POWER)}", PRODUCT


def _bound(node: ast.expr, strength: int) -> str:
    """Return a part in MathML, in brackets where it is bound less strongly."""
    text, own_strength = _typeset(node)
    return text if own_strength >= strength else add_brackets(text)


def _typeset_call(node: ast.Call) -> str:
    assert isinstance(node.func, ast.Name)
    if node.func.id == "Piecewise":
        pairs = (pair.elts for pair in node.args if isinstance(pair, ast.Tuple))
        rows = ("".join(f"<mtd>{_typeset(part)[0]}</mtd>" for part in pair) for pair in pairs)
        table = "".join(f"<mtr>{row}</mtr>" for row in rows)
        return f"<mrow><mo>{{</mo><mtable>{table}</mtable></mrow>"
    parts = "<mo>,</mo>".join(_typeset(part)[0] for part in node.args)
    if node.func.id == "sqrt":
        return f"<msqrt>{parts}</msqrt>"
    if node.func.id == "Abs":
        return f"<mrow><mo>|</mo>{parts}<mo>|</mo></mrow>"
    name = f"<mi>{escape(node.func.id)}</mi><mo>\N{FUNCTION APPLICATION}</mo>"
    return f"<mrow>{name}{add_brackets(parts)}</mrow>"
