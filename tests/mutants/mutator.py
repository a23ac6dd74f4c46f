"""Single faults in the text of a module: an operator, a comparison, a condition, a constant, a
statement.

A fault is named by where it stands and what it changes, without line numbers, so that a seeded
sample hardly changes with the code around it. Left alone are docstrings, annotations, decorators,
what is raised, words (of meanings and sources), and `strict`, by which loops over several sequences
state what cannot happen.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from hashlib import sha256

OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
NAMES = {
    "min": "max",
    "max": "min",
    "Min": "Max",
    "Max": "Min",
    "sin": "cos",
    "cos": "sin",
    "any": "all",
    "all": "any",
    "Zero": "One",
    "One": "Zero",
    "X": "Y",
    "Y": "Z",
    "Z": "X",
}
"""Names for which another may be taken."""
TEXT = re.compile(r"(?<![^\s(])(?:[-+*/<>]|[<>=!]=)(?![^\s])|(?<![\w.])[01](?!\w)")
IN_TEXT = {
    "+": "-",
    "-": "+",
    "*": "/",
    "/": "*",
    "<": "<=",
    "<=": "<",
    ">": ">=",
    ">=": ">",
    "==": "!=",
    "!=": "==",
    "0": "1",
    "1": "0",
}
"""What is exchanged, sign by sign, in text that is itself a programme."""
NOT_CODE = ("annotation", "returns", "decorator_list", "bases")


@dataclass(frozen=True)
class Mutant:
    """One fault of a module: in which function and line, what stood there and what stands there
    now.
    """

    place: str
    kind: str
    change: str
    line: str
    again: int
    index: int

    @property
    def name(self) -> str:
        """What tells it from all others of its module."""
        again = f" ({self.again + 1})" if self.again else ""
        return f"{self.place}: {self.kind}: {self.change} in {self.line}{again}"

    def rank(self, seed: int) -> str:
        """Its place in a seeded order."""
        return sha256(f"{seed} {self.name}".encode()).hexdigest()


Changes = Iterator[tuple[str, ast.AST]]
"""Kinds of faults and what then stands in a node's place."""


def mutants(source: str, writes: bool = False) -> list[Mutant]:
    """Every mutant of a module; of one that writes programmes also those of what it writes."""
    seen: Counter[tuple[str, str, str, str]] = Counter()
    mutants, lines = [], source.splitlines()
    for index, fault in enumerate(_faults(ast.parse(source), writes)):
        key = (
            fault.place,
            fault.kind,
            f"{_format_node(fault.node)} -> {_format_node(fault.other)}",
            lines[fault.line - 1].strip(),
        )
        mutants.append(Mutant(*key, seen[key], index))
        seen[key] += 1
    return mutants


def mutated(source: str, mutant: Mutant, writes: bool = False) -> str:
    """The text of a module with a fault in it."""
    tree = ast.parse(source)
    fault = list(_faults(tree, writes))[mutant.index]
    return ast.unparse(ast.fix_missing_locations(_Exchange(fault).visit(tree)))


@dataclass(frozen=True)
class _Fault:
    place: str
    kind: str
    line: int
    node: ast.AST
    other: ast.AST


class _Exchange(ast.NodeTransformer):
    """Puts what a fault makes of a node in the node's place."""

    def __init__(self, fault: _Fault) -> None:
        self.fault = fault

    def visit(self, node: ast.AST) -> ast.AST:
        return self.fault.other if node is self.fault.node else super().generic_visit(node)


def _format_node(node: ast.AST) -> str:
    return (
        ast.unparse(node).splitlines()[0]
        if not isinstance(node, ast.Constant)
        else repr(node.value)
    )


def _faults(tree: ast.Module, writes: bool) -> Iterator[_Fault]:
    for place, line, node in _walk(tree, "", 1, writes):
        for kind, other in _changes(node, writes):
            yield _Fault(place, kind, line, node, other)


def _walk(node: ast.AST, place: str, line: int, writes: bool) -> Iterator[tuple[str, int, ast.AST]]:
    """Every node that may be changed, with the names of the classes and functions around it and its
    line.
    """
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if name in NOT_CODE or not isinstance(child, ast.AST) or _is_left_alone(child, writes):
                continue
            named = isinstance(child, ast.FunctionDef | ast.ClassDef)
            inside = f"{place}.{child.name}".lstrip(".") if named else place
            own_line = getattr(child, "lineno", line)
            yield inside, own_line, child
            yield from _walk(child, inside, own_line, writes)


def _is_left_alone(node: ast.AST, writes: bool) -> bool:
    match node:
        case ast.keyword(arg="strict") | ast.Raise() | ast.Import() | ast.ImportFrom():
            return True
        case ast.Expr(value=ast.Constant()):
            return True
    return isinstance(node, ast.JoinedStr) and not writes


def _changes(node: ast.AST, writes: bool) -> Changes:
    match node:
        case ast.BinOp(op=op) | ast.AugAssign(op=op) if type(op) in OPERATORS:
            yield "operator", _with(node, op=OPERATORS[type(op)]())
        case ast.Compare(ops=[op]):
            yield from (
                ("comparison", _with(node, ops=[other()])) for other in COMPARISONS[type(op)]
            )
        case ast.BoolOp(op=op):
            yield "logic", _with(node, op=ast.Or() if isinstance(op, ast.And) else ast.And())
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield "sign", operand
        case ast.Constant(value=value):
            yield from (
                ("constant", _with(node, value=other)) for other in _constants(value, writes)
            )
        case ast.Name(id=name, ctx=ast.Load()) if name in NAMES:
            yield "name", _with(node, id=NAMES[name])
        case ast.Attribute(attr=name, ctx=ast.Load()) if name in NAMES:
            yield "name", _with(node, attr=NAMES[name])
        case ast.Call(args=[first, second, *rest]) if not isinstance(first, ast.Starred):
            if not isinstance(second, ast.Starred):
                yield "arguments", _with(node, args=[second, first, *rest])
        case ast.comprehension(ifs=[_, *_]):
            yield "condition", _with(node, ifs=[])
        case ast.If(test=test) | ast.IfExp(test=test):
            yield "condition", _with(node, test=ast.UnaryOp(ast.Not(), test))
    yield from _left_out(node)


def _constants(value: object, writes: bool) -> Iterator[object]:
    match value:
        case bool():
            yield not value
        case int():
            yield from (value + 1, value - 1)
        case float():
            yield 2 * value if value else 1.0
        case str() if writes:
            for sign in TEXT.finditer(value):
                yield value[: sign.start()] + IN_TEXT[sign[0]] + value[sign.end() :]


def _left_out(node: ast.AST) -> Changes:
    """Statements that do nothing any more."""
    match node:
        case ast.Return(value=ast.expr() as value) if not isinstance(value, ast.Constant):
            yield "statement", _with(node, value=ast.Constant(None))
        case (
            ast.Expr()
            | ast.AugAssign()
            | ast.Continue()
            | ast.If(body=[ast.Raise() | ast.Return()], orelse=[])
        ):
            yield "statement", ast.Pass()


def _with(node: ast.AST, **fields: object) -> ast.AST:
    """A node like another but for some of its parts."""
    other = copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    return other
