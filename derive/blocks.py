"""Simultaneous linear equations: the smallest closed sets of them, and the steps that solve one.

A closed set is a strongly connected part of the matched equations and unknowns (Dulmage and Mendelsohn, "Coverings of
bipartite graphs", Canad. J. Math. 10 (1958) 517-534): no smaller set of its equations determines any of its unknowns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import sympy as sp
from sympy import Expr

from .branches import switch
from .equations import Equation
from .model import Let, LinearSolve, Step
from .quantity import Quantity

MOST_CASES = 4
"""Unknowns of a set that may stand as sizes |N|; each doubles the number of times that the set is solved."""

STATES = "states_"
"""Beginning of the names of how many states of friction are possible."""


class BlockError(ValueError):
    """A set of equations is not linear in its unknowns, or has too many cases."""


def matched(equations: Sequence[Equation], unknowns: Sequence[Quantity]) -> dict[Quantity, Equation]:
    """As many unknowns as can be had, each with an equation of its own that holds it (augmenting paths)."""
    holds = {e.number: frozenset(e.residual.free_symbols) for e in equations}
    found: dict[Quantity, Equation] = {}

    def placed(equation: Equation, tried: set[Quantity]) -> bool:
        for unknown in (u for u in unknowns if u in holds[equation.number] and u not in tried):
            tried.add(unknown)
            if unknown not in found or placed(found[unknown], tried):
                found[unknown] = equation
                return True
        return False

    for equation in equations:
        placed(equation, set())
    return found


def closed_set(equations: Sequence[Equation], unknowns: Sequence[Quantity]) -> tuple[list[Equation], list[Quantity]]:
    """A smallest closed set of the equations, in their order; both lists are empty where there is none."""
    pairs = matched(equations, unknowns)
    needs = {u: [v for v in unknowns if v in e.residual.free_symbols] for u, e in pairs.items()}
    closures = [found for u in pairs if (found := _closure(u, needs)) is not None]
    if not closures:
        return [], []
    smallest = min(closures, key=len)
    numbers = {pairs[u].number for u in smallest}
    return [e for e in equations if e.number in numbers], [u for u in unknowns if u in smallest]


def _closure(first: Quantity, needs: Mapping[Quantity, Sequence[Quantity]]) -> set[Quantity] | None:
    """Every unknown that must be known with the first; None where one of them has no equation."""
    found, pending = {first}, [first]
    while pending:
        wanted = needs.get(pending.pop())
        if wanted is None:
            return None
        pending += [u for u in wanted if u not in found]
        found.update(wanted)
    return found if found <= needs.keys() else None


def solved(equations: Sequence[Equation], unknowns: Sequence[Quantity]) -> tuple[Step, ...]:
    """The steps that give the unknowns of a closed set.

    The set must be linear in them but for sizes ``Abs(N)`` of unknowns, as friction has them: it is solved for each
    choice of their signs, and that solution stands whose signs are those chosen. Raises BlockError for any other set.
    """
    sizes = sorted({a for e in equations for a in e.residual.atoms(sp.Abs) if a.args[0] in unknowns}, key=str)
    if len(sizes) > MOST_CASES:
        raise BlockError(f"{', '.join(map(str, sizes))} are sizes of unknowns; at most {MOST_CASES} can be told apart")
    source = "derived: " + "; ".join(e.source.removeprefix("derived: ") for e in equations)
    if not sizes:
        return linear([e.residual for e in equations], unknowns, source)
    return _by_cases(equations, unknowns, sizes, source)


def linear(residuals: Sequence[Expr], unknowns: Sequence[Quantity], source: str) -> tuple[Step, ...]:
    """Steps that make residuals vanish which are linear in the unknowns; raises BlockError where one is not."""
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
    return (LinearSolve(tuple(unknowns), pivot(unknowns[0]), tuple(rows), tuple(right), source),)


def _signs(signed: Mapping[Expr, Expr]) -> str:
    return ", ".join(f"{size} = {value}" for size, value in signed.items())


def pivot(first: Quantity) -> Quantity:
    """The pivot of simultaneous equations, by the first of their unknowns."""
    meaning = f"least pivot over its column where {first} is found with others: zero where nothing determines them"
    return Quantity(f"pivot_{first}", "1", meaning, "derived: elimination")


def _by_cases(
    equations: Sequence[Equation], unknowns: Sequence[Quantity], sizes: Sequence[Expr], source: str
) -> tuple[Step, ...]:
    """One solution for each choice of signs, and the one that is true to its own."""
    steps: list[Step] = []
    cases: list[tuple[dict[Quantity, Quantity], Expr]] = []
    for number, signs in enumerate(product((1, -1), repeat=len(sizes)), 1):
        named = {u: Quantity(f"{u}_case{number}", u.unit, f"{u.meaning}, case {number}", source) for u in unknowns}
        signed = {size: sign * size.args[0] for size, sign in zip(sizes, signs, strict=True)}
        residuals = [e.residual.xreplace(signed).xreplace(named) for e in equations]
        steps += linear(residuals, list(named.values()), f"{source}; {_signs(signed)}")
        cases.append((named, sp.Min(*(s * named[a.args[0]] for a, s in zip(sizes, signs, strict=True)))))
    for unknown in unknowns:
        chosen: Expr = cases[-1][0][unknown]
        for named, true in reversed(cases[:-1]):
            chosen = switch(true, named[unknown], chosen)
        steps.append(Let(unknown, chosen, f"{source}; the case that is true to its signs"))
    trues = [true for _, true in cases]
    strictly = sp.Add(*(switch(-true, sp.S.Zero, sp.S.One) for true in trues))
    any_ = switch(sp.Max(*trues), sp.S.One, sp.S.Zero)
    steps.append(Let(states(unknowns[0]), sp.Max(strictly, any_), f"{source}; cases that are true to their signs"))
    return tuple(steps)


def states(first: Quantity) -> Quantity:
    """How many states of friction the balances allow, by the first of the unknowns that are found with it."""
    return Quantity(f"{STATES}{first}", "1", f"states of friction in which {first} can be", "derived: elimination")
