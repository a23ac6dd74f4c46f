"""Equations of the audit, which are Python expressions, as presentation MathML: what browsers set without a script."""

from __future__ import annotations

import ast
import re
from html import escape
from unicodedata import lookup

SMALL = (
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "theta", "mu", "nu", "xi", "pi", "rho", "phi", "psi", "omega",
)  # fmt: skip
CAPITAL = ("Delta", "Omega")
GREEK = {name: lookup(f"GREEK SMALL LETTER {name.upper()}") for name in SMALL} | {
    name: lookup(f"GREEK CAPITAL LETTER {name.upper()}") for name in CAPITAL
}
DOTS = {"dot": "\u02d9", "ddot": "\u00a8"}
RELATIONS = {"<=": "\N{LESS-THAN OR EQUAL TO}", ">=": "\N{GREATER-THAN OR EQUAL TO}", "=": "=", "<": "<", ">": ">"}
COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
_SUM, _SIGN, _PRODUCT, _POWER, _ATOM = range(5)

Set = tuple[str, int]
"""MathML of an expression, and how tightly it holds together."""


def equation(text: str) -> str | None:
    """An equation or inequality as a MathML element; None where it is not one of expressions that can be set.

    >>> equation("F_Ey = 0")
    '<math display="block"><mrow><msub><mi>F</mi><mtext>Ey</mtext></msub><mo>=</mo><mn>0</mn></mrow></math>'
    """
    found = re.fullmatch(r"(.*) (<=|>=|=|<|>) (.*)", text)
    if found is None:
        return None
    try:
        left, right = expression(found[1]), expression(found[3])
    except (SyntaxError, ValueError):
        return None
    return f'<math display="block"><mrow>{left}{_sign(found[2])}{right}</mrow></math>'


def expression(text: str) -> str:
    """An expression as MathML. Raises SyntaxError or ValueError for what cannot be set."""
    return _node(ast.parse(text.strip(), mode="eval").body)[0]


def _node(node: ast.expr) -> Set:
    match node:
        case ast.Name(id=name):
            return symbol(name), _ATOM
        case ast.Constant(value=value):
            return f"<mn>{escape(str(value))}</mn>", _ATOM
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return _row("<mo>\N{MINUS SIGN}</mo>", _held(operand, _PRODUCT)), _SIGN
        case ast.BinOp(left=left, op=op, right=right):
            return _binary(left, op, right)
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _call(name, arguments)
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            if type(op) in COMPARED:
                return _row(_node(left)[0], _sign(COMPARED[type(op)]), _node(right)[0]), _SUM
    raise ValueError(f"cannot set {ast.dump(node)}")


def _binary(left: ast.expr, op: ast.operator, right: ast.expr) -> Set:
    match op:
        case ast.Add():
            return _row(_node(left)[0], "<mo>+</mo>", _node(right)[0]), _SUM
        case ast.Sub():
            return _row(_node(left)[0], "<mo>\N{MINUS SIGN}</mo>", _held(right, _PRODUCT)), _SUM
        case ast.Mult():
            return _row(_held(left, _SIGN), "<mo>\N{INVISIBLE TIMES}</mo>", _held(right, _PRODUCT)), _PRODUCT
        case ast.Div():
            return f"<mfrac>{_row(_node(left)[0])}{_row(_node(right)[0])}</mfrac>", _POWER
        case ast.Pow():
            return f"<msup>{_row(_held(left, _ATOM))}{_row(_node(right)[0])}</msup>", _POWER
        case ast.BitAnd():
            return _row(_node(left)[0], "<mtext> and </mtext>", _node(right)[0]), _SUM
    raise ValueError(f"cannot set {op}")


def _call(name: str, arguments: list[ast.expr]) -> Set:
    if name == "Piecewise":
        return _cases(arguments), _ATOM
    inner = [_node(argument)[0] for argument in arguments]
    if name == "sqrt":
        return f"<msqrt>{''.join(inner)}</msqrt>", _ATOM
    if name == "Abs":
        return _row("<mo>|</mo>", *inner, "<mo>|</mo>"), _ATOM
    listed = "<mo>,</mo>".join(inner)
    return _row(f"<mi>{escape(name)}</mi><mo>\N{FUNCTION APPLICATION}</mo>", _bracketed(listed)), _ATOM


def _cases(arguments: list[ast.expr]) -> str:
    rows = []
    for argument in arguments:
        if not (isinstance(argument, ast.Tuple) and len(argument.elts) == 2):
            raise ValueError("a case is a value and a condition")
        value, condition = argument.elts
        otherwise = isinstance(condition, ast.Constant)
        when = "<mtext>otherwise</mtext>" if otherwise else _node(condition)[0]
        rows.append(f"<mtr><mtd>{_node(value)[0]}</mtd><mtd>{when}</mtd></mtr>")
    return _row("<mo>{</mo>", f"<mtable>{''.join(rows)}</mtable>")


def _held(node: ast.expr, least: int) -> str:
    text, level = _node(node)
    return text if level >= least else _bracketed(text)


def _sign(relation: str) -> str:
    return f"<mo>{escape(RELATIONS[relation])}</mo>"


def _bracketed(text: str) -> str:
    return f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>"


def _row(*parts: str) -> str:
    return f"<mrow>{''.join(parts)}</mrow>"


def symbol(name: str) -> str:
    """A name as a letter with index and dots.

    >>> symbol("phi72_dot")
    '<mover><msub><mi>φ</mi><mtext>72</mtext></msub><mo>\\u02d9</mo></mover>'
    """
    stem, _, last = name.rpartition("_")
    if stem and last in DOTS:
        return f"<mover>{symbol(stem)}<mo>{DOTS[last]}</mo></mover>"
    letter, index = _split(name)
    shown = f"<mi>{escape(GREEK.get(letter, letter))}</mi>"
    return f"<msub>{shown}<mtext>{escape(index)}</mtext></msub>" if index else shown


def _split(name: str) -> tuple[str, str]:
    """Letter and index: what stands after the first underscore, or digits at the end of the letter."""
    letter, _, index = name.partition("_")
    found = re.fullmatch(r"([A-Za-z]+)(\d+\w*)", letter)
    if found:
        letter, index = found[1], found[2] + (f" {index}" if index else "")
    return letter, index.replace("_", " ")
