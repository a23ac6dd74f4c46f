"""Laws that a chain of equations must obey as a whole, and the equations that a broken law is due to.

A chain is executed over the cycle of a machine with two equal sides, as printed and with equations exchanged for their
derivations. All of it runs in floating point of 15 digits: the motion comes from outside, at any precision.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import Any, Literal

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy import Expr

from derive.chain import Chain, Solve
from derive.equations import Equation
from derive.model import Let, Twin

Array = NDArray[np.float64]
Values = dict[sp.Symbol, Array]
Repairs = frozenset[str]

TOLERANCE = 1e-7
"""Largest violation [N, J] of a law that counts as kept.

Forces of up to 1e3 in 15 digits leave 1e-12 of rounding, and a chain loses at most four digits more in its small
denominators; the rule of quadrature leaves less than 2e-8 (shown by the derivation, which must keep every law).
"""
SAME = 1e-10
"""An equation holds that gives its unknown to this share of its largest value."""
EXHAUSTIVE = 2
"""Up to this size every set of repairs is tried; beyond it those that contain what no other repairs make up for."""
DIGITS = 4


class LawError(ValueError):
    """The derivation itself breaks a law, so that nothing can be said of the print."""


@dataclass(frozen=True)
class Law:
    """``gaps`` vanish: at every angle (``largest``), on average, or in their integral over a turn.

    ``cycle`` names the motion in which it is tested.
    """

    name: str
    unit: str
    gaps: tuple[Expr, ...]
    over: Literal["largest", "mean", "turn"] = "largest"
    cycle: str = "reference"

    def violation(self, gaps: Sequence[Array], weights: Array) -> float:
        """By how much the law is broken, from the gaps at every angle."""
        if self.over == "largest":
            return float(np.max(np.abs(gaps)))
        total = abs(float(np.sum(gaps, axis=0) @ weights))
        return total / float(weights.sum()) if self.over == "mean" else total


@dataclass(frozen=True)
class Cycle:
    """A motion at some angles: what is known of each side, and the weights that integrate over a turn.

    ``between`` are more angles, interpolated, close enough to find the largest value of anything.
    """

    sides: tuple[Values, Values]
    weights: Array
    between: Cycle | None = None


@dataclass(frozen=True)
class Machine:
    """What a system states for the trial of a chain: its laws, its motions, and its derivation.

    ``claims`` are derived equations by what they claim to be; ``supplements`` the derivation's steps for unknowns of
    one side that a chain may lack but a derived equation may name.
    """

    laws: tuple[Law, ...]
    cycles: Mapping[str, Cycle]
    claims: Mapping[str, Equation]
    supplements: tuple[Let, ...]
    twin: Twin


@dataclass(frozen=True)
class Formula:
    """An expression made executable on arrays."""

    expr: Expr

    @cached_property
    def symbols(self) -> list[sp.Symbol]:
        return sorted(self.expr.free_symbols, key=str)

    @cached_property
    def _function(self) -> Callable[..., Any]:
        return sp.lambdify(self.symbols, self.expr, modules="numpy", cse=True)

    def __call__(self, values: Mapping[sp.Symbol, Array], count: int) -> Array:
        return np.broadcast_to(np.asarray(self._function(*(values[s] for s in self.symbols)), dtype=float), (count,))


@dataclass(frozen=True)
class Step:
    """``symbol = formula``."""

    symbol: sp.Symbol
    formula: Formula


@dataclass
class Trial:
    """A printed chain (one side, then what both sides share) on a machine."""

    side: Chain
    frame: Chain
    machine: Machine
    _steps: dict[tuple[str, Repairs], Step] = field(default_factory=dict)
    _runs: dict[tuple[Repairs, str], Values] = field(default_factory=dict)

    def violation(self, law: Law, repairs: Iterable[str] = ()) -> float:
        """By how much the chain breaks a law, after some repairs, at the angles that decide."""
        chosen = frozenset(repairs)
        if (chosen, law.cycle) not in self._runs:
            self._runs[chosen, law.cycle] = self.run(chosen, self.machine.cycles[law.cycle])
        return self._violation(law, self._runs[chosen, law.cycle], self.machine.cycles[law.cycle])

    def size(self, law: Law) -> float:
        """By how much the printed chain breaks a law, at all angles if the largest value is asked for."""
        cycle = self.machine.cycles[law.cycle]
        if law.over == "largest" and cycle.between:
            cycle = cycle.between
        return self._violation(law, self.run(frozenset(), cycle), cycle)

    def _violation(self, law: Law, found: Values, cycle: Cycle) -> float:
        return law.violation([gap(found, len(cycle.weights)) for gap in self._gaps[law.name]], cycle.weights)

    def broken(self, law: Law, repairs: Iterable[str] = ()) -> bool:
        return not self.violation(law, repairs) <= TOLERANCE

    def run(self, repairs: Repairs, cycle: Cycle) -> Values:
        """Every quantity of both sides and of what they share."""
        count = len(cycle.weights)
        one, two = (self._side(repairs, known, count) for known in cycle.sides)
        both = one | {self.machine.twin(s): v for s, v in two.items()}
        for solve in self.frame.order:
            self._take(self._step(self.frame, solve, repairs), both, count)
        return both

    def _side(self, repairs: Repairs, known: Values, count: int) -> Values:
        values = dict(known)
        steps = [self._step(self.side, solve, repairs) for solve in self.side.order]
        for step in (*steps, *self._supplements.values()):
            self._take(step, values, count)
        return values

    def _take(self, step: Step, values: Values, count: int) -> None:
        """Execute a step; unknowns of the derivation that it names are found first."""
        for symbol in step.formula.symbols:
            if symbol not in values and symbol in self._supplements:
                self._take(self._supplements[symbol], values, count)
        values[step.symbol] = step.formula(values, count)

    def _step(self, chain: Chain, solve: Solve, repairs: Repairs) -> Step:
        involved = {solve.equation, *(number for number, _ in solve.eliminate)}
        key = solve.equation, frozenset(involved & repairs)
        if key not in self._steps:
            for number in key[1]:
                chain = chain.replace(number, self._derived(number))
            let = replace(chain, order=[solve]).lets()[0]
            self._steps[key] = Step(let.symbol, Formula(let.expr))
        return self._steps[key]

    def _derived(self, number: str) -> Equation:
        return replace(self.machine.claims[str(self._printed(number).claims)], number=number)

    def _printed(self, number: str) -> Equation:
        return (self.side.equations if number in self.side.equations else self.frame.equations)[number]

    @cached_property
    def _supplements(self) -> dict[sp.Symbol, Step]:
        solved = {solve.unknown for solve in (*self.side.order, *self.frame.order)}
        steps = [Step(let.symbol, Formula(let.expr)) for let in self.machine.supplements]
        return {step.symbol: step for step in steps if step.symbol not in solved}

    @cached_property
    def _gaps(self) -> dict[str, list[Formula]]:
        return {law.name: [Formula(gap) for gap in law.gaps] for law in self.machine.laws}

    @property
    def numbers(self) -> list[str]:
        """The equations that the chain executes, in the order of the print."""
        executed = {solve.equation for solve in (*self.side.order, *self.frame.order)}
        return [number for number in {**self.side.equations, **self.frame.equations} if number in executed]

    @cached_property
    def suspects(self) -> list[str]:
        """The equations that do not hold of the derivation's own forces and moments, at some angle of the cycle."""
        derived = self.run(frozenset(self.numbers), self.machine.cycles["reference"])
        return [number for number in self.numbers if self._differs(number, derived)]

    def _differs(self, number: str, run: Values) -> bool:
        chain = self.side if any(s.equation == number for s in self.side.order) else self.frame
        solve = next(s for s in chain.order if s.equation == number)
        count = len(self.machine.cycles["reference"].weights)
        printed = self._step(chain, solve, frozenset()).formula(run, count)
        size = np.max(np.abs([printed, run[solve.unknown]]))
        return bool(np.max(np.abs(printed - run[solve.unknown])) > SAME * size)

    def causes(self, law: Law) -> list[tuple[str, ...]]:
        """The smallest sets of equations whose repair restores a law, in the order of the print."""
        if self.broken(law, self.numbers):
            raise LawError(f"{law.name}: broken by {self.violation(law, self.numbers)} {law.unit} with all repaired")
        for sets in self._tried(law):
            found = [chosen for chosen in sets if not self.broken(law, chosen)]
            if found:
                return found
        return [tuple(self.numbers)]

    def _tried(self, law: Law) -> Iterator[Iterable[tuple[str, ...]]]:
        """Sets of equations to repair, a size at a time."""
        suspects = self.suspects
        yield from (combinations(suspects, size) for size in range(1, EXHAUSTIVE + 1))
        needed = [n for n in suspects if self.broken(law, (m for m in suspects if m != n))]
        others = [n for n in suspects if n not in needed]
        for more in range(max(0, EXHAUSTIVE + 1 - len(needed)), len(others) + 1):
            yield (tuple(n for n in suspects if n in {*needed, *added}) for added in combinations(others, more))


def findings(paper: str, trial: Trial) -> list[dict[str, Any]]:
    """A record for every law: by how much the chain breaks it, and the smallest repair of what is printed."""
    return [_finding(paper, trial, law) for law in trial.machine.laws]


def _finding(paper: str, trial: Trial, law: Law) -> dict[str, Any]:
    broken = trial.broken(law)
    size = trial.size(law)
    causes = trial.causes(law) if broken else []
    return {
        "paper": paper,
        "law": law.name,
        "violation": float(f"{size:.{DIGITS - 1}e}") if broken else 0.0,
        "unit": law.unit,
        "caused_by": list(causes[0]) if causes else [],
        "or_by": [list(chosen) for chosen in causes[1:]],
    }


def as_lines(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """A section of the page, a table of the laws by paper."""
    if not records:
        return []
    lines = ["## Laws of each chain as a whole", "", "Each printed chain, executed over the reference cycle; a law is"]
    lines += ["laid to the smallest set of equations whose repair restores it.", ""]
    lines += ["| paper | law | broken by | unit | laid to |", "|---|---|---|---|---|"]
    for record in records:
        sets = [record["caused_by"], *record["or_by"]] if record["caused_by"] else []
        laid = " or ".join(", ".join(f"({number})" for number in chosen) for chosen in sets) or "kept"
        size = f"{record['violation']:.{DIGITS}g}"
        lines += [f"| {record['paper']} | {record['law']} | {size} | {record['unit']} | {laid} |"]
    return [*lines, ""]
