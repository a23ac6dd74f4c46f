"""Laws that a chain of equations must obey as a whole, and the equations that a broken law is due
to.

A chain is executed over the cycle of a machine, which may have equal sides, as printed and with
equations exchanged for their derivations, many such repairs at once. All of it runs in floating
point of 15 digits: the motion comes from outside, at any precision.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain as joined
from itertools import combinations, islice
from math import comb
from typing import Any

import numpy as np
import sympy as sp
from sympy import Expr

from ..chain import Chain, Solve, Together
from ..equations import Equation, find_claim
from ..model import Let, LinearSolve, Step
from .judge import UNJUDGED, explain_unjudged
from .paper import Array, Cycle, Dynamics, Law, Values


@dataclass(frozen=True)
class Formula:
    """An expression made executable on arrays; no number, or none that is finite, where it has
    none.
    """

    expr: Expr

    @cached_property
    def symbols(self) -> list[sp.Symbol]:
        """Return the symbols that must be known before the steps."""
        return sorted(self.expr.free_symbols, key=str)

    @cached_property
    def _function(self) -> Callable[..., Any]:
        return sp.lambdify(self.symbols, self.expr, modules="numpy", cse=True)

    def __call__(self, values: Mapping[sp.Symbol, Array]) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(self._function(*(values[s] for s in self.symbols)), dtype=float)


@dataclass(frozen=True)
class Programme:
    """Steps that give some unknowns, one after another or together."""

    steps: tuple[Step, ...]
    unknowns: tuple[sp.Symbol, ...]

    @cached_property
    def symbols(self) -> list[sp.Symbol]:
        """Return the symbols that must be known before the steps."""
        defined = {symbol for step in self.steps for symbol in step.defines}
        return sorted(set().union(*(step.needs for step in self.steps)) - defined, key=str)

    @cached_property
    def _parts(self) -> list[tuple[Step, list[Formula]]]:
        return [
            (s, [Formula(e) for e in (s.entries if isinstance(s, LinearSolve) else _expr(s))])
            for s in self.steps
        ]

    def __call__(self, values: Mapping[sp.Symbol, Array]) -> Values:
        """The unknowns; no number where the equations determine none."""
        available = dict(values)
        for step, formulas in self._parts:
            results = [formula(available) for formula in formulas]
            available |= zip(
                step.defines,
                _solved(results) if isinstance(step, LinearSolve) else results,
                strict=False,
            )
        return {symbol: available[symbol] for symbol in self.unknowns}


def _expr(step: Step) -> list[Expr]:
    assert isinstance(step, Let)
    return [step.expr]


def _solved(entries: Sequence[Array]) -> list[Array]:
    """Unknowns of simultaneous equations from the rows of their matrix and their right-hand
    sides.
    """
    count = int(np.sqrt(len(entries)))
    stacked = np.stack(np.broadcast_arrays(*entries), axis=-1)
    matrix = stacked[..., : count * count].reshape(*stacked.shape[:-1], count, count)
    try:
        solution = np.linalg.solve(matrix, stacked[..., count * count :, None])[..., 0]
    except np.linalg.LinAlgError:
        solution = np.full((*stacked.shape[:-1], count), np.nan)
    return list(np.moveaxis(solution, -1, 0))


Repairs = frozenset[str]

TOLERANCE = 1e-7
"""Largest violation [N, J] of a law that counts as kept, as a share of the law's scale.

Forces of up to 1e3 in 15 digits leave 1e-12 of rounding, and a chain loses at most four digits more
in its small denominators; the rule of quadrature leaves less than 2e-8 (shown by the derivation,
which must keep every law).
"""
SAME = 1e-10
"""An equation holds that gives its unknown to this share of its largest value."""
MOST_SETS = 100_000
"""Up to this many sets of repairs all are tried, a size at a time; of more, those that contain what
no others make up for, which need not be the smallest.
"""
AT_ONCE = 512
"""Sets of repairs that are executed together."""
FEW = 8
"""Sets of repairs that are executed together where every angle of the cycle is asked for."""
DIGITS = 4


class LawError(ValueError):
    """The derivation itself breaks a law, so that nothing can be said of the print."""


@dataclass(frozen=True)
class Causes:
    """The sets of equations whose repair restores a law, and whether there is certainly no smaller
    one.
    """

    sets: list[tuple[str, ...]]
    exhaustive: bool = True


@dataclass(frozen=True)
class Share:
    """Effect of an equation on a law: what its repair alone removes, what it alone leaves, its
    Shapley value.
    """

    equation: str
    alone: float
    without: float
    shapley: float


@dataclass
class ChainLaws:
    """A printed chain (one side, then what all sides share) held to the laws of a machine."""

    side: Chain
    frame: Chain
    dynamics: Dynamics
    _programmes: dict[tuple[Solve | Together, Repairs], Programme] = field(default_factory=dict)

    def violations(self, law: Law, repairs: Sequence[Iterable[str]]) -> Array:
        """Return the violation of a law after each set of repairs, at the deciding angles."""
        return self._violations(law, repairs, self.dynamics.cycles[law.cycle])

    def size(self, law: Law) -> float:
        """Return the violation of a law by the printed chain, at all angles if the law takes the
        largest value.
        """
        return self._sizes(law, [frozenset()])[0]

    def broken(self, law: Law, repairs: Iterable[str] = ()) -> bool:
        """Return whether the chain breaks a law after the repairs of some equations."""
        return not self.violations(law, [repairs])[0] <= TOLERANCE * law.scale

    def _violations(self, law: Law, repairs: Sequence[Iterable[str]], cycle: Cycle) -> Array:
        sets = [frozenset(chosen) for chosen in repairs]
        values = self.run(sets, cycle)
        shape = len(sets), len(cycle.weights)
        return law.violations(
            [np.broadcast_to(gap(values), shape) for gap in self._gaps[law.name]], cycle.weights
        )

    def run(self, sets: Sequence[Repairs], cycle: Cycle) -> Values:
        """Every quantity of all sides and of what they share: by set of repairs, where it depends
        on it, and angle.
        """
        count, sides = len(cycle.weights), cycle.sides
        values = {s: np.concatenate([side[s] for side in sides]) for s in sides[0]}
        self._execute(self.side, sets, values)
        for symbol in self._supplements:
            self._supply(symbol, values)
        samples = count * len(sides)
        values = {
            s: np.broadcast_to(v, (*v.shape[:-1], samples) if v.ndim else samples)
            for s, v in values.items()
        }
        all_values = {s: v[..., :count] for s, v in values.items()}
        for k, twin in enumerate(self.dynamics.twins[: len(sides) - 1], 1):
            all_values |= {twin(s): v[..., k * count : (k + 1) * count] for s, v in values.items()}
        self._execute(self.frame, sets, all_values)
        return all_values

    def _execute(self, chain: Chain, sets: Sequence[Repairs], values: Values) -> None:
        for solve in chain.order:
            chosen = [solve.involved & repairs for repairs in sets]
            variants = sorted(set(chosen), key=sorted)
            results = [
                self._evaluated(self.programme(chain, solve, variant), values)
                for variant in variants
            ]
            masks = [np.array([c == variant for c in chosen])[:, None] for variant in variants]
            for unknown in solve.unknowns:
                forms = [result[unknown] for result in results]
                values[unknown] = forms[0] if len(forms) == 1 else np.select(masks, forms)

    def _evaluated(self, programme: Programme, values: Values) -> Values:
        """Its unknowns; those of the derivation that it names are found first."""
        for symbol in programme.symbols:
            if symbol not in values and symbol in self._supplements:
                self._supply(symbol, values)
        return programme(values)

    def _supply(self, symbol: sp.Symbol, values: Values) -> None:
        formula = self._supplements[symbol]
        for symbol_needed in formula.symbols:
            if symbol_needed not in values and symbol_needed in self._supplements:
                self._supply(symbol_needed, values)
        values[symbol] = formula(values)

    def programme(self, chain: Chain, solve: Solve | Together, repairs: Repairs) -> Programme:
        """Build the program that computes the unknowns of a step of a chain."""
        key = solve, solve.involved & repairs
        if key not in self._programmes:
            for number in key[1]:
                chain = chain.replace(number, self._derived(number))
            self._programmes[key] = Programme(replace(chain, order=[solve]).steps(), solve.unknowns)
        return self._programmes[key]

    def _derived(self, number: str) -> Equation:
        return replace(
            find_claim(self.dynamics.claims, self._printed(number).claims), number=number
        )

    def _printed(self, number: str) -> Equation:
        return (self.side.equations if number in self.side.equations else self.frame.equations)[
            number
        ]

    @property
    def _steps(self) -> list[tuple[Chain, Solve | Together]]:
        return [(chain, solve) for chain in (self.side, self.frame) for solve in chain.order]

    @cached_property
    def _supplements(self) -> dict[sp.Symbol, Formula]:
        solved = {unknown for _, solve in self._steps for unknown in solve.unknowns}
        return {
            let.symbol: Formula(let.expr)
            for let in self.dynamics.supplements
            if let.symbol not in solved
        }

    @cached_property
    def _gaps(self) -> dict[str, list[Formula]]:
        return {law.name: [Formula(gap) for gap in law.gaps] for law in self.dynamics.laws}

    @property
    def numbers(self) -> list[str]:
        """The equations that the chain executes, in the order of the print."""
        executed = {number for _, solve in self._steps for number in solve.equations}
        return [
            number
            for number in {**self.side.equations, **self.frame.equations}
            if number in executed
        ]

    @cached_property
    def suspects(self) -> list[str]:
        """The equations that do not hold of the derivation's own forces and moments, at some angle
        of the cycle.
        """
        derived = self.run([frozenset(self.numbers)], self.dynamics.cycles["reference"])
        wrong = {
            n
            for chain, solve in self._steps
            if self._differs(chain, solve, derived)
            for n in solve.equations
        }
        return [number for number in self.numbers if number in wrong]

    def _differs(self, chain: Chain, solve: Solve | Together, run: Values) -> bool:
        printed = self.programme(chain, solve, frozenset())(run)
        return any(
            _differ_beyond_rounding(value, run[unknown]) for unknown, value in printed.items()
        )

    def concerned(self, law: Law) -> list[str]:
        """The suspects that a law can depend on at all, through any printed or derived step."""
        needs: dict[sp.Symbol, set[sp.Symbol]] = {
            s: set(f.symbols) for s, f in self._supplements.items()
        }
        for chain, solve in self._steps:
            forms = [
                self.programme(chain, solve, frozenset(some))
                for some in _subsets(sorted(solve.involved))
            ]
            needs |= {
                unknown: {s for form in forms for s in form.symbols} for unknown in solve.unknowns
            }
        needs |= {twin(s): {s} for twin in self.dynamics.twins for s in [*needs]}
        reached = {s for gap in self._gaps[law.name] for s in gap.symbols}
        while new := set().union(*(needs.get(s, set()) for s in reached)) - reached:
            reached |= new
        numbers = set().union(
            *(solve.involved for _, solve in self._steps if reached.intersection(solve.unknowns))
        )
        return [number for number in self.suspects if number in numbers]

    def causes(self, law: Law) -> Causes:
        """The smallest sets of equations whose repair restores a law, in the order of the print."""
        if self.broken(law, self.numbers):
            size = self.violations(law, [self.numbers])[0]
            raise LawError(f"{law.name}: broken by {size} {law.unit} with all repaired")
        concerned, count = self._with_kept(law), 0
        for size in range(1, len(concerned) + 1):
            count += comb(len(concerned), size)
            if count > MOST_SETS:
                return Causes(self._eliminated(law, concerned), exhaustive=False)
            if restoring := self._restoring(law, combinations(concerned, size)):
                return Causes(restoring)
        return Causes([tuple(self.numbers)])

    def _with_kept(self, law: Law) -> list[str]:
        """The suspects that a law, or a law that the print keeps and a repair of them may break,
        can depend on.
        """
        concerned = set(self.concerned(law))
        shared = [s for s in map(self.concerned, self.satisfied_laws) if concerned & set(s)]
        return [n for n in self.suspects if n in concerned.union(*shared)]

    @cached_property
    def satisfied_laws(self) -> list[Law]:
        """The laws that the print keeps."""
        return [law for law in self.dynamics.laws if not self.broken(law)]

    def _eliminated(self, law: Law, concerned: list[str]) -> list[tuple[str, ...]]:
        """Return the smallest sets that contain every equation whose repair nothing else makes up
        for.
        """
        needed = {n for n in concerned if self.broken(law, (m for m in concerned if m != n))}
        rest = [n for n in concerned if n not in needed]
        for more in range(len(rest) + 1):
            sets = (
                tuple(n for n in concerned if n in needed.union(added))
                for added in combinations(rest, more)
            )
            if restoring := self._restoring(law, sets):
                return restoring
        return [tuple(concerned)]

    def _restoring(self, law: Law, sets: Iterator[tuple[str, ...]]) -> list[tuple[str, ...]]:
        """Select the sets whose repair restores a law and breaks none that the print satisfies."""
        restoring: list[tuple[str, ...]] = []
        while batch := list(islice(sets, AT_ONCE)):
            restores = self.violations(law, batch) <= TOLERANCE * law.scale
            restoring += [
                s
                for s, restored in zip(batch, restores, strict=True)
                if restored and not self._breaks(s)
            ]
        return restoring

    def _breaks(self, repairs: tuple[str, ...]) -> bool:
        return any(self.broken(law, repairs) for law in self.satisfied_laws)

    def shares(self, law: Law, causes: Sequence[str]) -> list[Share]:
        """Return the effect on a broken law of each equation that causes it, largest first.

        The size of the violation is asked for after the repair of every set of them; the shares of
        Shapley, the mean of what an equation's repair takes away over all orders of repair, add up
        to the whole violation.
        """
        sets = [frozenset(subset) for subset in _subsets(list(causes))]
        sizes = dict(zip(sets, self._sizes(law, sets), strict=True))
        all_causes, count = frozenset(causes), len(causes)

        def mean_gain(number: str) -> float:
            gains = (
                (sizes[s] - sizes[s | {number}]) / (count * comb(count - 1, len(s)))
                for s in sets
                if number not in s
            )
            return float(sum(gains))

        shares = [
            Share(
                n, sizes[frozenset()] - sizes[frozenset({n})], sizes[all_causes - {n}], mean_gain(n)
            )
            for n in causes
        ]
        return sorted(shares, key=lambda share: -share.shapley)

    def _sizes(self, law: Law, sets: Sequence[Repairs]) -> list[float]:
        """Violations after sets of repairs, at all angles if the largest value is asked for."""
        cycle = self.dynamics.cycles[law.cycle]
        if law.over == "largest" and cycle.between:
            cycle = cycle.between
        batches = (sets[i : i + FEW] for i in range(0, len(sets), FEW))
        return [float(size) for batch in batches for size in self._violations(law, batch, cycle)]


def _differ_beyond_rounding(printed: Array, derived: Array) -> bool:
    """Whether values differ by more than rounding; what is no number does."""
    size = max(np.max(np.abs(printed)), np.max(np.abs(derived)))
    return not np.max(np.abs(printed - derived)) <= SAME * size


def _subsets(numbers: list[str]) -> Iterator[tuple[str, ...]]:
    return joined.from_iterable(combinations(numbers, size) for size in range(len(numbers) + 1))


def judge_laws(paper: str, chains: ChainLaws) -> list[dict[str, Any]]:
    """A record for every law: by how much the chain breaks it, and the smallest repair of what is
    printed.
    """
    return [_attempted(paper, chains, law) for law in chains.dynamics.laws]


def record_untried_law(paper: str, law: str, unit: str, error: Exception) -> dict[str, Any]:
    """The record of a law that cannot be tried, with the reason in `owed`; its violation is
    unknown, null.
    """
    empty: dict[str, Any] = {"caused_by": [], "or_by": [], "shares": []}
    record = {"paper": paper, "law": law, "violation": None, "unit": unit, "search": UNJUDGED}
    return {**record, **empty, "owed": explain_unjudged(error).finding}


def _attempted(paper: str, chains: ChainLaws, law: Law) -> dict[str, Any]:
    try:
        return _finding(paper, chains, law)
    except LawError:
        raise
    except Exception as error:  # a law that cannot be tried says nothing of the others
        return record_untried_law(paper, law.name, law.unit, error)


def measure_violation(chains: ChainLaws, law: Law) -> float:
    """Return by how much the chain breaks a law, in four digits; zero where that is rounding."""
    return float(f"{chains.size(law):.{DIGITS - 1}e}") if chains.broken(law) else 0.0


def attempted_violation(chains: ChainLaws, law: Law) -> float | None:
    """Return by how much the chain breaks a law, None where it cannot be executed."""
    try:
        return measure_violation(chains, law)
    except Exception:  # a law that cannot be tried says nothing of the others
        return None


def _finding(paper: str, chains: ChainLaws, law: Law) -> dict[str, Any]:
    causes = chains.causes(law) if chains.broken(law) else Causes([])
    return {
        "paper": paper,
        "law": law.name,
        "violation": measure_violation(chains, law),
        "unit": law.unit,
        "caused_by": list(causes.sets[0]) if causes.sets else [],
        "or_by": [list(chosen) for chosen in causes.sets[1:]],
        "search": "exhaustive" if causes.exhaustive else "elimination",
        "shares": [_rounded(share, law) for share in chains.shares(law, causes.sets[0])]
        if causes.sets
        else [],
    }


def _rounded(share: Share, law: Law) -> dict[str, Any]:
    sizes = {name: getattr(share, name) for name in ("alone", "without", "shapley")}
    rounded = {
        name: float(f"{v:.{DIGITS - 1}e}") if abs(v) > TOLERANCE * law.scale else 0.0
        for name, v in sizes.items()
    }
    return {"equation": share.equation, **rounded}
