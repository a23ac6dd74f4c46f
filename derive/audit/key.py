"""Keys of findings: what a finding depends on, hashed, so that what has not changed need not be
judged again.

The same on every machine and under every hash seed: expressions in their canonical order, values
rounded.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from hashlib import sha256
from importlib.util import resolve_name
from pathlib import Path

import mpmath
import sympy as sp

from ..equations import ClaimError, Equation
from ..evaluate import Point
from ..quantity import Quantity
from .case import AS_READ, Case, Choice

ROOT = Path(__file__).parents[2]
CYCLE_DIGITS = 6
"""Digits of a value along the cycle, of the largest there: some systems interpolate in floating
point.
"""


@cache
def engine_key(*modules: str) -> str:
    """Hash of the code of modules and of all that they import from this package, and of SymPy's
    version.
    """
    return _hashed([sp.__version__, *(_content(path) for path in sorted(list_sources(modules)))])


def _content(path: Path) -> str:
    """Return the code of a Python file, or the text of any other file."""
    text = path.read_text(encoding="utf-8")
    return code_without_docstrings(text) if path.suffix == ".py" else text


def code_without_docstrings(source: str) -> str:
    """Return the syntax tree of a source as text, without comments, layout and docstrings.

    Every string that is a statement counts as a docstring. Raises SyntaxError for what is not
    Python.
    """
    return _dumped(ast.parse(source))


def _dumped(node: object) -> str:
    """A node with its fields; empty ones are left out, since Python versions differ in which of
    them exist.

    `ast.dump` differs between versions for the same code.
    """
    if isinstance(node, list):
        return f"[{', '.join(_dumped(part) for part in node if not _is_docstring(part))}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = (
        f"{name}={_dumped(part)}"
        for name, part in ast.iter_fields(node)
        if part is not None and part != []
    )
    return f"{type(node).__name__}({', '.join(fields)})"


def _is_docstring(node: object) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def list_sources(modules: Iterable[str]) -> set[Path]:
    """Files of modules and of all that they import from this package or from their own."""
    waiting, paths = set(modules), set[Path]()
    packages = {name.partition(".")[0] for name in (__name__, *waiting)}
    while waiting:
        module = waiting.pop()
        path = _file(module)
        if path is None or path in paths:
            continue
        paths.add(path)
        package = module if path.name == "__init__.py" else module.rpartition(".")[0]
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            waiting |= {
                name for name in _imported(node, package) if name.partition(".")[0] in packages
            }
    return paths


def _imported(node: ast.AST, package: str) -> set[str]:
    """Return the modules that a node of a syntax tree may import, and names in them that may be
    modules.
    """
    if isinstance(node, ast.Import):
        return {name.name for name in node.names}
    if isinstance(node, ast.ImportFrom):
        base = resolve_name("." * node.level + (node.module or ""), package)
        return {base, *(f"{base}.{name.name}" for name in node.names)}
    return set()


def _file(module: str) -> Path | None:
    """Return the file of a module, which is loaded or in this project, or None."""
    loaded = getattr(sys.modules.get(module), "__file__", None)
    if loaded is not None:
        return Path(loaded)
    place = ROOT.joinpath(*module.split("."))
    return next(
        (path for path in (place.with_suffix(".py"), place / "__init__.py") if path.is_file()), None
    )


def equations_key(case: Case) -> str:
    """Return the key of the findings on all equations of a paper: judging code, both sides of each,
    vocabulary, every value used.

    Raises ClaimError where an equation claims what its subject does not derive.
    """
    parts = [engine_key(f"{__package__}.record"), case.paper.name]
    tables = case.subject.folds(), case.definitions
    parts += (f"{_name(s)} {sp.srepr(e)}" for table in tables for s, e in table.items())
    parts += sorted(case.paper.rough)
    symbols: set[sp.Symbol] = set()
    for number in case.paper.equations:
        try:
            sides = _list_sides(case, number)
            parts += _describe_equation(case, number, sides)
            symbols.update(*(side.residual.free_symbols for side in sides))
        except ClaimError:
            raise
        except Exception as error:  # what is wrong with one equation, its record says
            parts.append(f"{number} {error}")
    called = case.subject.actions()
    for symbol in _sorted({*symbols, *case.words}):
        name = _name(symbol)
        parts += (f"{name} {_at(symbol, point)}" for point in case.points)
        if symbol in symbols:
            parts.append(f"{name} {_cycle_values(symbol, case.cycle)} {called.get(symbol)}")
    return _hashed(parts)


def _list_sides(case: Case, number: str) -> list[Equation]:
    """List an equation as printed, its pairs under every reading, and its lifted derivation."""
    sides: list[Equation | None] = [case.paper.equations[number]]
    for choice in case.choices(number) or [AS_READ]:
        for pair in case.footings(number, choice):
            sides += pair
    return [side for side in (*sides, case.lifted(number)) if side]


def _describe_equation(case: Case, number: str, sides: Sequence[Equation]) -> Iterator[str]:
    """Yield all that the finding on an equation depends on, but values."""
    printed = case.paper.equations[number]
    yield from map(equation_text, sides)
    yield from map(_choice, case.choices(number))
    yield case.read_as(number)
    yield str(sides[1].defines in case.directions)
    yield from (f"{s} {why}" for s, why in case.assumed(number).items())
    if printed.defines:
        yield str(case.subject.constraint_residuals(printed.claims, printed.defines))


def laws_key(case: Case, chosen: Mapping[str, Choice]) -> str:
    """Key of the findings on chains as a whole: the code of trial and subject, the subject's files,
    the equations.

    ``chosen`` says how equations are read that can be read in several ways.
    """
    parts = [engine_key(f"{__package__}.laws", type(case.subject).__module__)]
    parts += map(_content, case.subject.files())
    parts += [f"{number} {_choice(choice)}" for number, choice in chosen.items()]
    for chain in case.chains or ():
        parts += [equation_text(e) for e in chain.equations.values()]
        parts += map(str, chain.order)
        parts += [
            f"{symbol} {sp.srepr(meant)}" for symbol, meant in sorted(chain.bind.items(), key=str)
        ]
    return _hashed(parts)


def equation_text(equation_: Equation) -> str:
    """An equation as text that says all of it, in canonical order."""
    names = [_name(s) for s in _sorted(equation_.residual.free_symbols)]
    fields = [
        equation_.number,
        equation_.legibility,
        str(equation_.claims),
        str(equation_.defines),
        equation_.relation,
        equation_.typed,
    ]
    fields += [str(equation_.stated), sp.srepr(equation_.where), *equation_.rebuilt]
    fields += [f"{w.where} {w.values} {w.between}" for w in equation_.witnesses]
    return "\n".join([*fields, *names, sp.srepr(equation_.residual)])


def _choice(choice: Choice) -> str:
    maps = (
        f"{symbol} {sp.srepr(e)}"
        for substitutions in (choice.printed, choice.derived)
        for symbol, e in substitutions.items()
    )
    because = (answer.because for answer in choice.answers)
    return "\n".join([choice.meaning, *because, *maps, sp.srepr(choice.text)])


def _name(symbol: sp.Symbol) -> str:
    return f"{symbol} [{symbol.unit}]" if isinstance(symbol, Quantity) else str(symbol)


def _at(symbol: sp.Symbol, point: Point) -> str:
    return point.digits(symbol) if symbol in point else "-"


def _cycle_values(symbol: sp.Symbol, cycle: list[Point]) -> str:
    """Values along the cycle as whole numbers of a unit in the last digit of the largest."""
    if not all(symbol in point for point in cycle):
        return "-"
    values = [point(symbol) for point in cycle]
    largest = max(map(abs, values), default=mpmath.mpf(0))
    unit = largest / 10**CYCLE_DIGITS or mpmath.mpf(1)
    return f"{mpmath.nstr(largest, CYCLE_DIGITS)} {[int(mpmath.nint(v / unit)) for v in values]}"


def _sorted(symbols: Iterable[sp.Symbol]) -> list[sp.Symbol]:
    return sorted(symbols, key=_name)


def _hashed(parts: Iterable[str]) -> str:
    return sha256("\0".join(parts).encode()).hexdigest()
