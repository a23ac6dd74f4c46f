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
COMPONENTS = tuple(kind + axis for kind in "av" for axis in "xyz")
"""Letters of accelerations and velocities with their axis."""
WIDE = 105
"""Signs of a sum after which it is broken."""

Set = tuple[str, int]
"""MathML of an expression, and how tightly it holds together."""


def equation(text: str, solve: bool = False, defines: str = "") -> str | None:
    """An equation or inequality as a MathML element; None where it is not one of expressions that can be set.

    One with zero on the right may be solved for what it `defines`, or for the only name that is a term of its own. A
    long sum is broken before its signs.

    >>> equation("F_Ey = 0")
    '<math display="block"><mrow><msub><mi>F</mi><mtext>Ey</mtext></msub><mo>=</mo><mn>0</mn></mrow></math>'
    """
    found = re.fullmatch(r"(.*) (<=|>=|=|<|>) (.*)", text)
    if found is None:
        return None
    try:
        left, right = (_terms(_parsed(side)) for side in (found[1], found[3]))
        if solve and found[2] == "=" and found[3] == "0":
            left, right = _solved(left, right, defines)
        return _math(_set(left, found[2], right), "block")
    except (SyntaxError, ValueError):
        return None


def term(text: str) -> str | None:
    """A term as a MathML element for running text; None where it cannot be set.

    >>> term("x_A")
    '<math><msub><mi>x</mi><mtext>A</mtext></msub></math>'
    """
    try:
        lines = _lines_of(_terms(_parsed(text)))
    except (SyntaxError, ValueError):
        return None
    return _math(lines[0] if len(lines) == 1 else _stacked(lines), "inline")


def _math(content: str, display: str) -> str:
    return f'<math display="block">{content}</math>' if display == "block" else f"<math>{content}</math>"


def _stacked(lines: list[str]) -> str:
    rows = "".join(f"<mtr>{_cell(_row(line))}</mtr>" for line in lines)
    return f'<mtable displaystyle="true">{rows}</mtable>'


Terms = list[tuple[bool, ast.expr]]
"""A sum: for each of its terms whether it is taken away, and the term without that sign."""


def _parsed(text: str) -> ast.expr:
    return ast.parse(text.strip(), mode="eval").body


def _terms(node: ast.expr, minus: bool = False) -> Terms:
    """The terms of a sum, out of which a leading sign is taken."""
    match node:
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _terms(left, minus) + _terms(right, minus)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            return _terms(left, minus) + _terms(right, not minus)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return _terms(operand, not minus)
        case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as op, right=right):
            (negative, first), *more = _terms(left)
            if not more:
                return [(minus != negative, ast.BinOp(first, op, right))]
    return [(minus, node)]


def _solved(left: Terms, right: Terms, defines: str) -> tuple[Terms, Terms]:
    """Both sides with one name alone on the left, where there is such a one."""
    alone = [i for i, (_, node) in enumerate(left) if isinstance(node, ast.Name)]
    named = [i for i in alone if ast.unparse(left[i][1]) == defines]
    chosen = named or alone
    if len(chosen) != 1 or len(left) < 2:
        return left, right
    minus, node = left[chosen[0]]
    rest = [(negative == minus, term) for i, (negative, term) in enumerate(left) if i != chosen[0]]
    first = next((i for i, (negative, _) in enumerate(rest) if not negative), 0)
    return [(False, node)], [rest[first], *rest[:first], *rest[first + 1 :]]


def _set(left: Terms, relation: str, right: Terms) -> str:
    """An equation in one line, or in lines that begin with a sign."""
    head, tail = _lines_of(left), _lines_of(right)
    if len(head) == 1 and len(tail) == 1:
        return _row(head[0], _sign(relation), tail[0])
    if len(head) == 1:
        first, *rest = tail
        lines = [_row(head[0], _sign(relation), first), *rest]
    else:
        lines = [*head[:-1], _row(head[-1], _sign(relation), *tail)]
    return _stacked(lines)


def _lines_of(terms: Terms) -> list[str]:
    """A sum as lines that are not much wider than a page."""
    lines = [""]
    width = 0
    for i, (minus, node) in enumerate(terms):
        shown = _held(node, _PRODUCT) if minus else _node(node)[0]
        size = len(re.sub(r"<[^>]*>", "", shown)) + 2
        if width and width + size > WIDE:
            lines.append("")
            width = 0
        lines[-1] += ("<mo>\N{MINUS SIGN}</mo>" if minus else "<mo>+</mo>" if i else "") + shown
        width += size
    return lines


def expression(text: str) -> str:
    """An expression as MathML. Raises SyntaxError or ValueError for what cannot be set."""
    return _node(_parsed(text))[0]


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
            return _row(_node(left)[0], "<mtext>\N{NO-BREAK SPACE}and\N{NO-BREAK SPACE}</mtext>", _node(right)[0]), _SUM
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
        rows.append(f"<mtr>{_cell(_node(value)[0])}{_cell(when)}</mtr>")
    return _row("<mo>{</mo>", f"<mtable>{''.join(rows)}</mtable>")


def _cell(content: str) -> str:
    return f'<mtd style="text-align: left">{content}</mtd>'


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
    '<msub><mover><mi>φ</mi><mo stretchy="false">\\u02d9</mo></mover><mtext>72</mtext></msub>'
    """
    stem, _, last = name.rpartition("_")
    dotted = stem and last in DOTS
    letter, index = _split(stem if dotted else name)
    shown = f"<mi>{escape(GREEK.get(letter, letter))}</mi>"
    if dotted:
        shown = f'<mover>{shown}<mo stretchy="false">{DOTS[last]}</mo></mover>'
    return f"<msub>{shown}<mtext>{escape(index)}</mtext></msub>" if index else shown


def _split(name: str) -> tuple[str, str]:
    """Letter and index: what stands after the first underscore, or digits at the end of the letter."""
    letter, _, index = name.partition("_")
    found = re.fullmatch(r"([A-Za-z]+)(\d+\w*)", letter)
    if letter in COMPONENTS:
        letter, index = letter[0], f"{letter[1]} {index}"
    elif found:
        letter, index = found[1], found[2] + (f" {index}" if index else "")
    return letter, index.replace("_", " ")
