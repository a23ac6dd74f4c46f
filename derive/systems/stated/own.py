"""A mechanism of one's own as what papers are tried against: what it claims, and laws that a print must keep."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import combinations

import sympy as sp
from sympy import Expr

from ...audit.laws import Dynamics
from ...audit.subject import Subject
from ...chain import Chain
from ...equations import Claimed, Equation, by_claim, defined, derived, loop, what
from ...mechanics.lawful import lawful
from ...mechanics.mechanism import Mechanism
from ...model import Let, Step, System, needed, sorted_steps
from ...quantity import Quantity
from . import laws
from .given import Values

MOST_TOGETHER = 2
"""Equations that are solved together for the rates of a loop."""


class Own(Subject):
    """A mechanism as derived; ``printed`` are equations of a paper in the order in which they give something."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.system = mechanism, mechanism.system()
        self.printed = Chain({}, [])

    @property
    @abstractmethod
    def quantities(self) -> frozenset[Quantity]:
        """Everything that has a value in its motion."""

    @property
    @abstractmethod
    def moving(self) -> list[tuple[Quantity, Quantity]]:
        """What may be moved alone, each with its rate."""

    @abstractmethod
    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        """Values along its own motion, and along others that laws compare it with."""

    @property
    def named(self) -> list[Let]:
        """What has a name of its own, each after what it is told in."""
        return [s for s in sorted_steps((*self.mechanism.named, *self.mechanism.reports)) if isinstance(s, Let)]

    @cached_property
    def _before(self) -> tuple[Step, ...]:
        """What the gaps of loops are told in."""
        gaps = self.mechanism.loops.gaps.values()
        return needed(self.named, frozenset().union(*(gap.free_symbols for gap in gaps)))

    def claims(self) -> Mapping[Claimed, Equation]:
        """Balances, what named quantities are, the gaps of loops, rates and accelerations that these determine."""
        named = {let.symbol: let for let in self.named}
        gaps = self.mechanism.loops.gaps.items()
        return by_claim((
            *self.mechanism.equations(),
            *(defined(what(symbol), symbol, let.expr) for symbol, let in named.items()),
            *(derived(loop(name.removeprefix("gap_")), gap) for name, gap in gaps),
            *(defined(what(symbol), symbol, expr) for symbol, expr in self._rates.items() if symbol not in named),
        ))  # fmt: skip

    @cached_property
    def _rates(self) -> dict[Quantity, Expr]:
        """Rates and accelerations of the coordinates that loops determine, each in terms of those before it."""
        loops, motion = self.mechanism.loops, self.mechanism.motion
        rates, accelerations = [c.rate for c in loops.coordinates], [c.acceleration for c in loops.coordinates]
        told = self.mechanism.told_in([*rates, *accelerations])
        once = [sp.sympify(motion.rate(gap)).xreplace(told) for gap in loops.gaps.values()]
        twice = [sp.sympify(motion.rate(rate)).xreplace(told) for rate in once]
        return _solve_in_turn(once, rates) | _solve_in_turn(twice, accelerations)

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        """What only one of them names is told by what it is: in coordinates, their rates and accelerations, data."""
        both = printed.free_symbols & derived.free_symbols
        plain: dict[Quantity, Expr] = {}
        for let in self.named:
            if let.symbol not in both:
                plain[let.symbol] = let.expr.xreplace(plain)
        return printed.xreplace(plain), derived.xreplace(plain)

    def actions(self) -> Mapping[sp.Symbol, str]:
        return {unknown: unknown.meaning for unknown in self.mechanism.assembly.unknowns}

    def model(self) -> System:
        return self.system

    def dynamics(self) -> Dynamics | None:
        """Laws that the printed equations must keep as a whole; None where they give nothing that a law feels."""
        if not self.printed.order:
            return None
        return laws.dynamics(self.mechanism, lawful(self.mechanism, self.moving), self.printed, self.motions())


def _solve_in_turn(residuals: Sequence[Expr], unknowns: Sequence[Quantity]) -> dict[Quantity, Expr]:
    """Unknowns of linear equations: those of the fewest equations first, which stay symbols in what follows.

    What needs more than MOST_TOGETHER equations at once is left out: its formula would be too long to compare with.
    """
    found: dict[Quantity, Expr] = {}
    left = list(residuals)
    while solved := next(_solve_together(left, [q for q in unknowns if q not in found]), None):
        together, values = solved
        found |= values
        left = [residual for residual in left if residual not in together]
    return found


def _solve_together(
    residuals: Sequence[Expr], unknowns: Sequence[Quantity]
) -> Iterator[tuple[tuple[Expr, ...], dict[Quantity, Expr]]]:
    """Equations that determine as many unknowns as they are many, the fewest first, with these."""
    for size in range(1, MOST_TOGETHER + 1):
        for some in combinations(residuals, size):
            known = set().union(*(residual.free_symbols for residual in some))
            together = [unknown for unknown in unknowns if unknown in known]
            if len(together) == size:
                matrix, right = sp.linear_eq_to_matrix(some, together)
                if sp.expand(matrix.det()) != 0:
                    yield some, dict(zip(together, matrix.LUsolve(right), strict=True))
