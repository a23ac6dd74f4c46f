"""Chains of equations: an order in which each gives an unknown, or a block of them
simultaneously.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import sympy as sp
from sympy import Expr

from .elimination import find_closure, match_rows, order_elimination
from .equations import Claimed, Equation, find_claim
from .functions import switch
from .model import Let, LinearSolve, Step
from .quantity import Quantity

MOST_CASES = 4
"""Unknowns of a set whose signs may decide; each doubles the number of times that the set is
solved.
"""

STATES = "states_"
"""Beginning of the names of how many states of friction are possible."""


class BlockError(ValueError):
    """A set of equations is not linear in its unknowns, or has too many cases."""


def match_equations(
    equations: Sequence[Equation], unknowns: Sequence[Quantity]
) -> dict[Quantity, Equation]:
    """Match as many unknowns as possible to an equation each that contains them (augmenting
    paths).
    """
    pairs = match_rows([e.residual.free_symbols for e in equations], unknowns)
    return {unknown: equations[row] for unknown, row in pairs.items()}


def closed_set(
    equations: Sequence[Equation], unknowns: Sequence[Quantity]
) -> tuple[list[Equation], list[Quantity]]:
    """A smallest closed set of the equations, in their order; both lists are empty where there is
    none.
    """
    pairs = match_equations(equations, unknowns)
    needs = {u: [v for v in unknowns if v in e.residual.free_symbols] for u, e in pairs.items()}
    closures = [closure for u in pairs if (closure := find_closure(u, needs)) is not None]
    if not closures:
        return [], []
    smallest = min(closures, key=len)
    numbers = {pairs[u].number for u in smallest}
    return [e for e in equations if e.number in numbers], [u for u in unknowns if u in smallest]


def solve_set(equations: Sequence[Equation], unknowns: Sequence[Quantity]) -> tuple[Step, ...]:
    """The steps that give the unknowns of a closed set.

    The set must be linear in them but for sizes ``Abs(N)`` of unknowns, as friction has them, and
    for cases by the sign of an unknown, as the flanks of teeth are: it is solved for each choice of
    the signs, and that solution stands whose signs are those chosen. Raises BlockError for any
    other set.
    """
    deciding = sorted(
        {u for e in equations for u in _deciding_unknowns(e.residual) if u in unknowns}, key=str
    )
    if len(deciding) > MOST_CASES:
        names = ", ".join(map(str, deciding))
        raise BlockError(f"the signs of {names} decide; at most {MOST_CASES} are supported")
    source = "derived: " + "; ".join(e.source.removeprefix("derived: ") for e in equations)
    if not deciding:
        return solve_linear_set([e.residual for e in equations], unknowns, source)
    return _by_cases(equations, unknowns, deciding, source)


def _deciding_unknowns(residual: Expr) -> Iterator[Expr]:
    """Yield what stands in ``Abs`` or is compared with zero."""
    yield from (size.args[0] for size in residual.atoms(sp.Abs))
    yield from (test.lhs for test in residual.atoms(sp.Ge) if test.rhs == 0)


def solve_linear_set(
    residuals: Sequence[Expr], unknowns: Sequence[Quantity], source: str
) -> tuple[Step, ...]:
    """Return steps that make residuals vanish which are linear in the unknowns; raises BlockError
    where one is not.
    """
    nothing = dict.fromkeys(unknowns, sp.S.Zero)
    rows, right = [], []
    for residual in residuals:
        row = tuple(residual.diff(u) for u in unknowns)
        if any(entry.has(*unknowns) for entry in row):
            named = ", ".join(sorted(map(str, unknowns)))
            raise BlockError(f"{source}: not linear in {named}")
        rows.append(row)
        right.append(-residual.xreplace(nothing))
    if len(unknowns) == 1:
        (unknown,), ((entry,),), (value,) = unknowns, rows, right
        return (Let(unknown, value / entry, source),)
    row_order, column_order = order_elimination(
        [{j for j, entry in enumerate(row) if entry != 0} for row in rows]
    )
    return (
        LinearSolve(
            tuple(unknowns[j] for j in column_order),
            pivot(unknowns[0]),
            tuple(tuple(rows[i][j] for j in column_order) for i in row_order),
            tuple(right[i] for i in row_order),
            source,
        ),
    )


def pivot(first: Quantity) -> Quantity:
    """The pivot of simultaneous equations, by the first of their unknowns."""
    meaning = (
        f"least pivot over its column where {first} is found with others: zero where "
        f"nothing determines them"
    )
    return Quantity(f"pivot_{first}", "1", meaning, "derived: elimination")


def _by_cases(
    equations: Sequence[Equation],
    unknowns: Sequence[Quantity],
    deciding: Sequence[Expr],
    source: str,
) -> tuple[Step, ...]:
    """One solution for each choice of signs, and the one that is true to its own."""
    defined = [e.defines if e.defines in unknowns else None for e in equations]
    steps: list[Step] = []
    cases: list[tuple[dict[Quantity, Quantity], Expr]] = []
    for number, signs in enumerate(product((1, -1), repeat=len(deciding)), 1):
        named = {
            u: Quantity(f"{u}_case{number}", u.unit, f"{u.meaning}, case {number}", source)
            for u in unknowns
        }
        signed: dict[sp.Basic, sp.Basic] = {}
        for unknown, sign in zip(deciding, signs, strict=True):
            signed |= {sp.Abs(unknown): sign * unknown, sp.Ge(unknown, 0): sp.sympify(sign > 0)}
        core, definitions = _eliminate_definitions(
            [e.residual.xreplace(signed) for e in equations], defined
        )
        choice = ", ".join(
            f"{sp.Abs(u)} = {sign * u}" for u, sign in zip(deciding, signs, strict=True)
        )
        label, open_unknowns = (
            f"{source}; {choice}",
            [named[u] for u in unknowns if u not in definitions],
        )
        steps += solve_linear_set(
            [residual.xreplace(named) for residual in core], open_unknowns, label
        )
        steps += [Let(named[u], value.xreplace(named), label) for u, value in definitions.items()]
        cases.append((named, sp.Min(*(s * named[u] for u, s in zip(deciding, signs, strict=True)))))
    for unknown in unknowns:
        chosen: Expr = cases[-1][0][unknown]
        for named, true in reversed(cases[:-1]):
            chosen = switch(true, named[unknown], chosen)
        steps.append(Let(unknown, chosen, f"{source}; the case that is true to its signs"))
    trues = [true for _, true in cases]
    strictly = sp.Add(*(switch(-true, sp.S.Zero, sp.S.One) for true in trues))
    any_ = switch(sp.Max(*trues), sp.S.One, sp.S.Zero)
    steps.append(
        Let(
            friction_states(unknowns[0]),
            sp.Max(strictly, any_),
            f"{source}; cases that are true to their signs",
        )
    )
    return tuple(steps)


def _eliminate_definitions(
    residuals: Sequence[Expr], defined: Sequence[Quantity | None]
) -> tuple[list[Expr], dict[Quantity, Expr]]:
    """Return residuals without what some of them define, and those definitions in an order of
    evaluation.
    """
    pending = {
        u: u - residual for u, residual in zip(defined, residuals, strict=True) if u is not None
    }
    core = [residual for u, residual in zip(defined, residuals, strict=True) if u is None]
    ordered_definitions: dict[Quantity, Expr] = {}
    while ready := [u for u, value in pending.items() if not value.free_symbols & pending.keys()]:
        ordered_definitions |= {u: pending.pop(u) for u in ready}
    for unknown, value in reversed(ordered_definitions.items()):
        core = [residual.xreplace({unknown: value}) for residual in core]
    return [*core, *(unknown - value for unknown, value in pending.items())], ordered_definitions


def friction_states(first: Quantity) -> Quantity:
    """Return the count of friction states that the balances allow, named after the first unknown
    solved with it.
    """
    return Quantity(
        f"{STATES}{first}",
        "1",
        f"states of friction in which {first} can be",
        "derived: elimination",
    )


class ChainError(ValueError):
    """A chain does not determine its unknowns."""


@dataclass(frozen=True)
class Solve:
    """Solve one equation for one unknown; others may first be used to eliminate what they define in
    terms of it.
    """

    equation: str
    unknown: Quantity
    eliminate: tuple[tuple[str, Quantity], ...] = ()

    @property
    def equations(self) -> tuple[str, ...]:
        """The equation that is solved."""
        return (self.equation,)

    @property
    def unknowns(self) -> tuple[Quantity, ...]:
        return (self.unknown,)

    @property
    def involved(self) -> frozenset[str]:
        """Every equation that is used."""
        return frozenset({self.equation, *(number for number, _ in self.eliminate)})


@dataclass(frozen=True)
class Together:
    """Solve simultaneous equations for as many unknowns."""

    equations: tuple[str, ...]
    unknowns: tuple[Quantity, ...]

    @property
    def involved(self) -> frozenset[str]:
        return frozenset(self.equations)


@dataclass(frozen=True)
class Chain:
    """Equations, their order of solution, and how printed symbols bind to named quantities."""

    equations: Mapping[str, Equation]
    order: Sequence[Solve | Together]
    bind: Mapping[sp.Symbol, Expr] = field(default_factory=dict)

    @classmethod
    def of_claims(
        cls,
        equations: Mapping[Claimed, Equation],
        order: Iterable[tuple[Claimed, Quantity]],
        bind: Mapping[sp.Symbol, Expr] | None = None,
    ) -> Chain:
        """A chain whose order says what each equation claims to be; raises ClaimError for what none
        of them does.
        """
        solutions = [(find_claim(equations, claim), unknown) for claim, unknown in order]
        return cls(
            {e.number: e for e, _ in solutions},
            [Solve(e.number, u) for e, u in solutions],
            bind or {},
        )

    def replace(self, number: str, equation: Equation) -> Chain:
        """Return a copy of the chain with one equation exchanged."""
        if number not in self.equations:
            raise ChainError(f"the chain has no equation {number}")
        return replace(self, equations={**self.equations, number: equation})

    @property
    def spent(self) -> frozenset[str]:
        """Numbers of the equations that give an unknown, or help to."""
        return frozenset(number for solve in self.order for number in solve.involved)

    @property
    def singles(self) -> tuple[Solve, ...]:
        """The order of a chain that solves one equation at a time; raises ChainError for any
        other.
        """
        together = [s for s in self.order if isinstance(s, Together)]
        if together:
            raise ChainError(
                f"equations {', '.join(together[0].equations)} have to be solved together"
            )
        return tuple(s for s in self.order if isinstance(s, Solve))

    def lets(self) -> tuple[Let, ...]:
        """The steps of a chain that solves one equation at a time; each is linear in its one
        unknown.
        """
        return tuple(self._let(solve) for solve in self.singles)

    def steps(self) -> tuple[Step, ...]:
        """The executable steps; each is linear in its one unknown, or in its unknowns together."""
        return tuple(step for solve in self.order for step in self._steps(solve))

    def _steps(self, solve: Solve | Together) -> tuple[Step, ...]:
        if isinstance(solve, Solve):
            return (self._let(solve),)
        return solve_set(
            [self._bound(self.equations[number]) for number in solve.equations], solve.unknowns
        )

    def _bound(self, equation: Equation) -> Equation:
        return replace(equation, residual=close_cases(equation.residual.xreplace(dict(self.bind))))

    def _let(self, solve: Solve) -> Let:
        equation = self.equations[solve.equation]
        residual = equation.residual
        for number, symbol in solve.eliminate:
            residual = residual.xreplace({symbol: solve_linear(self.equations[number], symbol)})
        expr = solve_linear(replace(equation, residual=residual), solve.unknown)
        return Let(solve.unknown, close_cases(expr.xreplace(dict(self.bind))), equation.source)


def solve_linear(equation: Equation, unknown: sp.Symbol) -> Expr:
    """The one root of an equation that is linear in ``unknown``."""
    slope = equation.residual.diff(unknown)
    if slope == 0 or slope.has(unknown):
        raise ChainError(f"equation {equation.number} is not linear in {unknown}")
    return -equation.residual.xreplace({unknown: sp.S.Zero}) / slope


def close_cases(expr: Expr) -> Expr:
    """Let the last of a list of cases hold where no other does (the papers leave out
    borderlines).
    """

    def closed(cases: sp.Piecewise) -> Expr:
        *head, (last, _) = cases.args
        return sp.Piecewise(*head, (last, True))

    return expr.replace(lambda e: isinstance(e, sp.Piecewise), closed)


def ordered(
    equations: Sequence[Equation], unknowns: Sequence[Quantity], targets: Sequence[Quantity]
) -> Chain:
    """A chain whose order is found by matching.

    Again and again the first equation with a single open unknown gives it. Where there is none, the
    first balance whose open unknowns are all defined in terms of a single one gives that one. Where
    there is none either, the smallest closed set of equations is solved together. Raises ChainError
    that names what is left undetermined.
    """
    still_open = set(unknowns)
    left = list(equations)
    order: list[Solve | Together] = []
    while still_open & set(targets):
        solve = _next(left, unknowns, still_open)
        if solve is None:
            raise ChainError(describe_undetermined(left, [u for u in unknowns if u in still_open]))
        left = [e for e in left if e.number not in solve.equations]
        still_open -= set(solve.unknowns)
        order.append(solve)
    return Chain({e.number: e for e in equations}, order)


def select_solvable(equations: Sequence[Equation], unknowns: Sequence[Quantity]) -> Chain:
    """The order in which equations give as many of the unknowns as they can; the rest is taken as
    given.

    So is what they give only by an equation that is not linear in it.
    """
    still_open, left = set(unknowns), list(equations)
    order: list[Solve | Together] = []
    while solve := _next(left, unknowns, still_open):
        still_open -= set(solve.unknowns)
        try:
            Chain({e.number: e for e in equations}, [solve]).steps()
        except (ChainError, BlockError):
            continue
        left = [e for e in left if e.number not in solve.equations]
        order.append(solve)
    return Chain({e.number: e for e in equations}, order)


def _next(
    equations: Sequence[Equation], unknowns: Sequence[Quantity], still_open: set[Quantity]
) -> Solve | Together | None:
    solve = _single(equations, still_open) or _common(equations, still_open)
    if solve is not None:
        return solve
    block, block_unknowns = closed_set(equations, [u for u in unknowns if u in still_open])
    if not block_unknowns:
        return None
    return Together(tuple(e.number for e in block), tuple(block_unknowns))


def describe_undetermined(equations: Sequence[Equation], unknowns: Sequence[Quantity]) -> str:
    """Describe the unknowns that too few equations contain, with those equations."""
    occurrences = {
        u: [e.number for e in equations if u in e.residual.free_symbols] for u in unknowns
    }
    lines = "; ".join(
        f"{u} stands in {', '.join(numbers) or 'none'}" for u, numbers in occurrences.items()
    )
    left = f"{len(equations)} equation{' is' if len(equations) == 1 else 's are'} left"
    names = ", ".join(map(str, unknowns))
    return f"{left} for {len(unknowns)} unknowns ({names}), and no set of them is closed: {lines}"


def _single(equations: Sequence[Equation], still_open: set[Quantity]) -> Solve | None:
    for equation in equations:
        open_unknowns = equation.residual.free_symbols & still_open
        if len(open_unknowns) != 1 or _has_sizes(open_unknowns, equation):
            continue
        if equation.defines is None or equation.defines in open_unknowns:
            return Solve(equation.number, open_unknowns.pop())
    return None


def _common(equations: Sequence[Equation], still_open: set[Quantity]) -> Solve | None:
    """A balance in several unknowns that all depend on one: those others are eliminated through
    their definitions.
    """
    definitions = {e.defines: e for e in equations if e.defines in still_open}
    for equation in equations:
        open_unknowns = equation.residual.free_symbols & still_open
        defined = sorted(open_unknowns & definitions.keys(), key=str)
        roots = (open_unknowns - definitions.keys()).union(
            *(_open_in(definitions[s], still_open) for s in defined)
        )
        if equation.defines is not None or len(roots) != 1:
            continue
        if not _has_sizes(open_unknowns | roots, equation, *(definitions[s] for s in defined)):
            return Solve(
                equation.number, roots.pop(), tuple((definitions[s].number, s) for s in defined)
            )
    return None


def _has_sizes(unknowns: set[Quantity], *equations: Equation) -> bool:
    """Whether sizes of unknowns stand in equations, so that they are linear in them only case by
    case.
    """
    return any(e.residual.has(*(sp.Abs(u) for u in unknowns)) for e in equations)


def _open_in(definition: Equation, still_open: set[Quantity]) -> set[Quantity]:
    return (definition.residual.free_symbols & still_open) - {definition.defines}
