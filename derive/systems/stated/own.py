"""A mechanism of one's own as what papers are tried against: what it claims, and laws that a print must keep."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property

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
        """Balances, what named quantities are, the gaps of loops."""
        named = {let.symbol: let for let in self.named}
        gaps = self.mechanism.loops.gaps.items()
        return by_claim((
            *self.mechanism.equations(),
            *(defined(what(symbol), symbol, let.expr) for symbol, let in named.items()),
            *(derived(loop(name.removeprefix("gap_")), gap) for name, gap in gaps),
        ))  # fmt: skip

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
