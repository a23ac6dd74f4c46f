"""Sentences that contain expressions, and presentation MathML of both, which browsers set without a
script.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any, ClassVar, TypeAlias
from unicodedata import lookup

import sympy as sp
from sympy import Basic, Expr
from sympy.core.function import AppliedUndef
from sympy.printing.precedence import PRECEDENCE, precedence
from sympy.printing.printer import Printer

from ..equations import Equation

Piece: TypeAlias = str | Basic


class Said(str):
    """A sentence: a string that knows which of its pieces are expressions.

    >>> from sympy import symbols
    >>> a, b = symbols("a b")
    >>> Said("sign of ", a - b), Said("sign of ", a - b).pieces
    ('sign of a - b', ('sign of ', a - b))
    """

    pieces: tuple[Piece, ...]

    def __new__(cls, *pieces: Piece) -> Said:
        opened = tuple(part for piece in pieces for part in split_sentence(piece))
        self = super().__new__(cls, "".join(map(str, opened)))
        self.pieces = opened
        return self

    def __reduce__(self) -> tuple[type[Said], tuple[Piece, ...]]:
        return type(self), self.pieces


def split_sentence(piece: Piece) -> tuple[Piece, ...]:
    """The pieces of a sentence; a plain string or an expression is one."""
    return piece.pieces if isinstance(piece, Said) else (piece,)


def join_parts(separator: str, sentences: Iterable[Piece]) -> Said:
    """Sentences or expressions one after the other."""
    pieces: list[Piece] = []
    for sentence in sentences:
        pieces += [separator] if pieces else []
        pieces.append(sentence)
    return Said(*pieces)


_SMALL = (
    "alpha",
    "beta",
    "gamma",
    "delta",
    "epsilon",
    "zeta",
    "theta",
    "mu",
    "nu",
    "xi",
    "pi",
    "rho",
    "phi",
    "psi",
    "omega",
)
GREEK = {name: lookup(f"GREEK SMALL LETTER {name.upper()}") for name in _SMALL} | {
    name: lookup(f"GREEK CAPITAL LETTER {name.upper()}") for name in ("Delta", "Omega")
}
DOTS = {"dot": "\u02d9", "ddot": "\u00a8"}
RELATIONS = {"<=": "\N{LESS-THAN OR EQUAL TO}", ">=": "\N{GREATER-THAN OR EQUAL TO}"}
COMPONENTS = tuple(kind + axis for kind in "av" for axis in "xyz")
"""Letters of accelerations and velocities with their axis."""
WIDE = 105
"""Signs of a sum after which it is broken."""
MINUS, PLUS, TIMES = ("<mo>\N{MINUS SIGN}</mo>", "<mo>+</mo>", "<mo>\N{INVISIBLE TIMES}</mo>")


class Presentation(Printer):
    """Sets an expression; raises TypeError for a node that it does not know."""

    printmethod = "_presentation"
    _default_settings: ClassVar[dict[str, Any]] = {"order": None}

    def in_brackets(self, expr: Basic, binding: int) -> str:
        """An expression, in brackets where it binds less than ``binding``."""
        text = self.doprint(expr)
        return add_brackets(text) if precedence(expr) < binding else text

    def terms(self, expr: Expr) -> list[tuple[bool, str]]:
        """The summands of an expression as they stand in its text: whether each is taken away, and
        what.
        """
        ordered = self._as_ordered_terms(expr) if isinstance(expr, sp.Add) else [expr]
        return [self._term(term) for term in ordered]

    def _term(self, term: Expr) -> tuple[bool, str]:
        minus = bool(term.as_coeff_Mul()[0].is_negative)
        return minus, self.in_brackets(-term if minus else term, PRECEDENCE["Mul"])

    def emptyPrinter(self, expr: Basic) -> str:
        """Raise TypeError for an expression for which the printer has no method."""
        raise TypeError(f"cannot set {type(expr).__name__} in {expr}")

    def _print_Symbol(self, expr: sp.Symbol) -> str:
        return typeset_symbol(expr.name)

    _print_Dummy = _print_Symbol

    def _print_Integer(self, expr: sp.Integer) -> str:
        return f"<mn>{expr}</mn>" if expr >= 0 else _row(MINUS, f"<mn>{-expr}</mn>")

    def _print_Rational(self, expr: sp.Rational) -> str:
        fraction = f"<mfrac><mn>{abs(expr.p)}</mn><mn>{expr.q}</mn></mfrac>"
        return fraction if expr > 0 else _row(MINUS, fraction)

    def _print_Float(self, expr: sp.Float) -> str:
        return f"<mn>{expr}</mn>"

    def _print_Pi(self, expr: Basic) -> str:
        return f"<mi>{GREEK['pi']}</mi>"

    def _print_Add(self, expr: sp.Add) -> str:
        return _row(*(_signed(i, minus, term) for i, (minus, term) in enumerate(self.terms(expr))))

    def _print_Mul(self, expr: sp.Mul) -> str:
        coefficient = expr.args[0] if expr.args[0].is_Number else sp.S.One
        if coefficient.is_negative and len(expr.args) > 1:
            rest = (
                sp.Mul(-coefficient, *expr.args[1:], evaluate=False)
                if coefficient != -1
                else self._without(expr)
            )
            return _row(MINUS, self.in_brackets(rest, PRECEDENCE["Mul"]))
        above, below = self._fraction(expr)
        if below:
            return f"<mfrac>{_row(self._product(above))}{_row(self._product(below))}</mfrac>"
        return _row(self._product(above))

    @staticmethod
    def _without(expr: sp.Mul) -> Expr:
        rest = expr.args[1:]
        return rest[0] if len(rest) == 1 else sp.Mul(*rest, evaluate=False)

    @staticmethod
    def _fraction(expr: sp.Mul) -> tuple[list[Expr], list[Expr]]:
        """Factors above and below the bar."""
        above: list[Expr] = []
        below: list[Expr] = []
        for factor in expr.as_ordered_factors():
            if isinstance(factor, sp.Rational) and factor.q != 1:
                above += [sp.Integer(factor.p)] if factor.p != 1 else []
                below.append(sp.Integer(factor.q))
            elif isinstance(factor, sp.Pow) and factor.exp.is_number and factor.exp.is_negative:
                below.append(sp.Pow(factor.base, -factor.exp))
            else:
                above.append(factor)
        return above, below

    def _product(self, factors: Sequence[Expr]) -> str:
        if len(factors) == 1:
            return self.doprint(factors[0])
        return (
            TIMES.join(self.in_brackets(factor, PRECEDENCE["Mul"]) for factor in factors)
            or "<mn>1</mn>"
        )

    def _print_Pow(self, expr: sp.Pow) -> str:
        base, power = expr.args
        if power.is_number and power.is_negative:
            return f"<mfrac><mn>1</mn>{_row(self.doprint(sp.Pow(base, -power)))}</mfrac>"
        if power == sp.S.Half:
            return f"<msqrt>{self.doprint(base)}</msqrt>"
        return f"<msup>{_row(self.in_brackets(base, PRECEDENCE['Atom']))}{_row(self.doprint(power))}</msup>"

    def _print_Function(self, expr: sp.Function) -> str:
        inner = "<mo>,</mo>".join(map(self.doprint, expr.args))
        name = expr.name if isinstance(expr, AppliedUndef) else type(expr).__name__
        return _row(
            f"<mi>{escape(name)}</mi><mo>\N{FUNCTION APPLICATION}</mo>", add_brackets(inner)
        )

    def _print_Abs(self, expr: sp.Abs) -> str:
        return _row("<mo>|</mo>", self.doprint(expr.args[0]), "<mo>|</mo>")

    def _print_Piecewise(self, expr: sp.Piecewise) -> str:
        rows = (
            f"<mtr>{_cell(self.doprint(v))}{_cell(self.doprint(c))}</mtr>" for v, c in expr.args
        )
        return _row("<mo>{</mo>", f"<mtable>{''.join(rows)}</mtable>")

    def _print_Relational(self, expr: sp.Rel) -> str:
        return _row(self.doprint(expr.lhs), _sign(expr.rel_op), self.doprint(expr.rhs))

    def _print_And(self, expr: sp.And) -> str:
        word = "<mtext>\N{NO-BREAK SPACE}and\N{NO-BREAK SPACE}</mtext>"
        return _row(word.join(map(self.doprint, sorted(expr.args, key=sp.default_sort_key))))

    def _print_BooleanTrue(self, expr: Basic) -> str:
        return "<mtext>otherwise</mtext>"


_SETTER = Presentation()


def typeset_expression(expr: Basic) -> str:
    """An expression without the element around it.

    >>> typeset_expression(sp.Symbol("x_A"))
    '<msub><mi>x</mi><mtext>A</mtext></msub>'
    """
    return _SETTER.doprint(expr)


def typeset_inline(expr: Basic) -> str:
    """An expression as an element for running text."""
    lines = _lines(_SETTER.terms(expr)) if isinstance(expr, Expr) else [typeset_expression(expr)]
    return _math(lines[0] if len(lines) == 1 else _stacked(lines), str(expr))


def typeset_equation(equation: Equation) -> str:
    """An equation as a separate element, solved for what it defines."""
    text = f"{equation.residual} {equation.relation} 0"
    left, right = split_sides(equation)
    return _math(
        _set(_SETTER.terms(left), equation.relation, _SETTER.terms(right)), text, display=True
    )


def split_sides(equation: Equation) -> tuple[Expr, Expr]:
    """Both sides as they are shown."""
    symbol = equation.defines
    if symbol is None or equation.residual.diff(symbol) != 1:
        return equation.residual, sp.S.Zero
    return symbol, symbol - equation.residual


def typeset_sentence(sentence: Piece) -> str:
    """A sentence with the expressions in it typeset."""
    return "".join(
        typeset_inline(part) if isinstance(part, Basic) else escape(part, quote=False)
        for part in split_sentence(sentence)
    )


def _math(content: str, text: str, display: bool = False) -> str:
    head = '<math display="block">' if display else "<math>"
    note = f'<annotation encoding="text/plain">{escape(text, quote=False)}</annotation>'
    return f"{head}<semantics><mrow>{content}</mrow>{note}</semantics></math>"


Terms = list[tuple[bool, str]]


def _set(left: Terms, relation: str, right: Terms) -> str:
    """An equation in one line, or in lines that begin with a sign."""
    head, tail = _lines(left), _lines(right)
    if len(head) == 1:
        lines = [_row(head[0], _sign(relation), tail[0]), *tail[1:]]
    else:
        lines = [*head[:-1], _row(head[-1], _sign(relation), *tail)]
    return lines[0] if len(lines) == 1 else _stacked(lines)


def _lines(terms: Terms) -> list[str]:
    """A sum as lines that are not much wider than a page."""
    lines, width = [""], 0
    for i, (minus, term) in enumerate(terms):
        size = len(re.sub(r"<[^>]*>", "", term)) + 2
        if width and width + size > WIDE:
            lines.append("")
            width = 0
        lines[-1] += _signed(i, minus, term)
        width += size
    return lines


def _signed(index: int, minus: bool, term: str) -> str:
    return (MINUS if minus else PLUS if index else "") + term


def _stacked(lines: list[str]) -> str:
    rows = "".join(f"<mtr>{_cell(_row(line))}</mtr>" for line in lines)
    return f'<mtable displaystyle="true">{rows}</mtable>'


def _cell(content: str) -> str:
    return f'<mtd style="text-align: left">{content}</mtd>'


def _sign(relation: str) -> str:
    return f"<mo>{escape(RELATIONS.get(relation, relation), quote=False)}</mo>"


def add_brackets(text: str) -> str:
    """Return MathML in round brackets."""
    return f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>"


def _row(*content: str) -> str:
    return f"<mrow>{''.join(content)}</mrow>"


def typeset_symbol(name: str) -> str:
    """A name as a letter with index and dots.

    >>> typeset_symbol("phi72_dot")
    '<msub><mover><mi>φ</mi><mo stretchy="false">\\u02d9</mo></mover><mtext>72</mtext></msub>'
    """
    stem, _, last = name.rpartition("_")
    dotted = stem and last in DOTS
    letter, index = _split(stem if dotted else name)
    markup = f"<mi>{escape(GREEK.get(letter, letter))}</mi>"
    if dotted:
        markup = f'<mover>{markup}<mo stretchy="false">{DOTS[last]}</mo></mover>'
    return f"<msub>{markup}<mtext>{escape(index)}</mtext></msub>" if index else markup


def _split(name: str) -> tuple[str, str]:
    """Letter and index: what stands after the first underscore, or digits at the end of the
    letter.
    """
    letter, _, index = name.partition("_")
    match = re.fullmatch(r"([A-Za-z]+)(\d+\w*)", letter)
    if letter in COMPONENTS:
        letter, index = letter[0], f"{letter[1]} {index}"
    elif match:
        letter, index = match[1], match[2] + (f" {index}" if index else "")
    return letter, index.replace("_", " ")
