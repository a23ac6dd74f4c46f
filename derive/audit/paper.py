"""Papers as data, their equations as printed; and the subject that they are compared with, and its
laws of motion.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy import Expr

from ..equations import UNCLAIMED, Claimed, Equation, Legibility, Relation, Witness
from ..evaluate import Point
from ..model import Let, System, Twin
from ..quantity import Quantity
from .comparison import solve_for
from .terms import Equilibrium
from .transcription import transcribe_call

Array = NDArray[np.float64]
Values = dict[sp.Symbol, Array]


@dataclass(frozen=True)
class Law:
    """``gaps`` vanish: at every angle (``largest``), on average, or in their integral over a turn.

    ``cycle`` names the motion in which it is tested. What is asked of the violation is asked of its
    share of ``scale``.
    """

    name: str
    unit: str
    gaps: tuple[Expr, ...]
    over: Literal["largest", "mean", "turn"] = "largest"
    cycle: str = "reference"
    scale: float = 1.0

    def violations(self, gaps: Sequence[Array], weights: Array) -> Array:
        """Return by how much the law is broken, from the gaps at every angle (last axis)."""
        if self.over == "largest":
            return np.max([np.max(np.abs(gap), axis=-1) for gap in gaps], axis=0)
        total = np.abs(sum(gap @ weights for gap in gaps))
        return total / weights.sum() if self.over == "mean" else total


@dataclass(frozen=True)
class Cycle:
    """A motion at some angles: what is known of each equal side, and the weights that integrate
    over a turn.

    ``between`` are more angles, interpolated, close enough to find the largest value of anything.
    """

    sides: tuple[Values, ...]
    weights: Array
    between: Cycle | None = None


@dataclass(frozen=True)
class Dynamics:
    """Laws, motions and derivation of a system, for the audit of a chain.

    ``claims`` are derived equations by what they claim to be; ``supplements`` the derivation's
    steps for unknowns of one side that a chain may lack but a derived equation may name; ``twins``
    name a quantity on the second side, and on those after it.
    """

    laws: tuple[Law, ...]
    cycles: Mapping[str, Cycle]
    claims: Mapping[Claimed, Equation]
    supplements: tuple[Let, ...]
    twins: tuple[Twin, ...] = ()


class Subject(Protocol):
    """A system that papers are tried against.

    Asked for are the derived equations and values of their quantities; the rest has a default for
    who inherits.
    """

    def claims(self) -> Mapping[Claimed, Equation]:
        """Derived equations by what they claim to be."""
        ...

    def admissible(self, rng: random.Random) -> Mapping[Any, Any]:
        """Random values of all quantities, consistent with each other; by the seed, both cases of
        every branch.
        """
        ...

    def reference(self, points: int) -> Sequence[Mapping[Any, Any]]:
        """Values of all quantities along the machine's own cycle, to estimate how large a term
        becomes.
        """
        ...

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Any, Any]] | None:
        """Values of all quantities, consistent with each other, near those of ``reference``: data
        changed a little.

        None where the subject finds none; every quantity of the reference is then moved a little by
        itself.
        """
        return None

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        """Two sums, a printed and a derived one, in the same quantities."""
        return printed, derived

    def footings(self, printed: Expr, derived: Expr) -> Sequence[tuple[Expr, Expr]]:
        """Both sums in more and more of the same quantities: from the balance's own to those of
        ``common``.
        """
        return [self.common(printed, derived)]

    def equilibria(self) -> Sequence[Equilibrium]:
        """Return equilibria with points near them, about which equations may be linearised; none by
        default.
        """
        return []

    def folds(self) -> Mapping[sp.Symbol, Expr]:
        """Quantities that a balance holds as differences: each with what is taken from it."""
        return {}

    def definitions(self) -> Mapping[sp.Symbol, Expr]:
        """Return quantities by what they are in other quantities: those of the claims that define
        one, by default.
        """
        formulas = {
            e.defines: solve_for(e.residual, e.defines)
            for e in self.claims().values()
            if e.defines is not None
        }
        explicit = {s: e for s, e in formulas.items() if s not in e.free_symbols}
        return {**explicit, **self.reactions()}

    def reactions(self) -> Mapping[sp.Symbol, Expr]:
        """Return actions by what they are in other quantities, where a paper need not name them."""
        return {}

    def actions(self) -> Mapping[sp.Symbol, str]:
        """Return names of the forces and moments between bodies, by their symbols."""
        return {}

    def constraint_residuals(self, claim: Claimed, formula: Expr) -> Mapping[str, Expr]:
        """Return the residuals that must vanish at the supports, by the ``formula`` for the subject
        of a claim.
        """
        return {}

    def zero(self) -> Mapping[sp.Symbol, str]:
        """Quantities that an assumption makes vanish, each with the reason."""
        return {}

    def lift(self, claim: Claimed, printed: Expr) -> Expr | None:
        """The derived residual of a claim while the quantities of ``zero`` are not, in those of the
        printed one.

        None for a claim that no assumption bears on.
        """
        return None

    def dynamics(self) -> Dynamics | None:
        """Laws that a chain of equations must obey as a whole, and the motion to test it in; None
        without any.
        """
        return None

    def model(self) -> System | None:
        """Return the model that computes the numbers of a paper, or None if nothing derived here
        does.
        """
        return None

    def files(self) -> Iterable[Path]:
        """Files that the dynamics depend on in addition to the modules that the subject's own one
        imports.
        """
        return ()


@dataclass(frozen=True)
class Repair:
    """A change of a printed row that makes it hold: its LaTeX after it, the change in words, and
    other changes that would do as well.
    """

    latex: str
    text: str
    alternatives: tuple[str, ...] = ()


class Source(Protocol):
    """The text that a paper's equations were read from, which can be changed and read again."""

    def repair(
        self, number: str, points: list[Point], draw: Callable[[int], list[Point]]
    ) -> Repair | None:
        """Return the smallest change of an equation's own LaTeX after which it holds at points,
        None without one.

        ``draw`` returns a number of random admissible points.
        """
        ...

    def describe(self, number: str) -> dict[str, Any]:
        """Return file, line and LaTeX of an equation, and its LaTeX corrected, empty if no change
        corrects it.
        """
        ...

    def explain_unjudged(self, number: str) -> str:
        """Return why an equation cannot be judged, empty if it can."""
        ...

    def announces_small_motion(self, number: str) -> bool:
        """Return whether the text says before an equation that motions are small, or that it
        linearises.
        """
        ...

    def find_clash(self, number: str) -> str:
        """Return which terms of a definition have different units, empty if none have."""
        ...

    def describe_use(self, number: str) -> str:
        """Return which equations hold that rest on a definition, empty if none do."""
        ...

    def describe_footing(self, number: str) -> str:
        """Return what may be wrong instead of an equation that does not hold, empty without."""
        ...

    def compares_angles(self, number: str) -> bool:
        """Return whether both sides of an equation are angles: turns do not count."""
        ...

    def list_rows(self) -> list[dict[str, Any]]:
        """Return place, status and reason of every displayed row."""
        ...


@dataclass(frozen=True)
class Reading:
    """One admissible meaning of a printed equation.

    ``printed`` and ``derived`` replace symbols of the print and of its derivation; ``text`` is
    another transcription of the characters, as a residual; ``because`` names the place in the paper
    that admits it.
    """

    meaning: str
    printed: Mapping[sp.Symbol, Expr] = field(default_factory=dict)
    derived: Mapping[sp.Symbol, Expr] = field(default_factory=dict)
    text: Expr | None = None
    because: str = ""

    @property
    def rereads(self) -> bool:
        """Whether the print itself says something else under this reading."""
        return bool(self.printed) or self.text is not None


@dataclass(frozen=True)
class Question:
    """A question that a paper leaves open, its equations, and every admissible answer: one holds
    for all of them.
    """

    numbers: tuple[str, ...]
    readings: tuple[Reading, ...]


@dataclass(frozen=True)
class Reference:
    """A place where a paper says from which of its equations it has some quantities."""

    symbols: tuple[Quantity, ...]
    numbers: tuple[str, ...]


@dataclass
class Paper:
    r"""The transcription of a paper: its equations by number; a short name stands for a number
    where print gives none.

    ``reading`` says what printed symbols stand for in all equations, ``readings`` in single ones,
    ``questions`` what the paper leaves open, ``rough`` are
    equations that it calls approximate. Quantities are in SI; digits that a paper prints may
    be in other units. Papers are listed in the order of their ``place``, those without one last.
    `derive.trial` compares them with a mechanism or formulas.

    >>> from derive import Paper, quantities, what
    >>> q = quantities("r | m | radius\nd | m | diameter")
    >>> paper = Paper("invented2026", "An invented paper")
    >>> paper.defines("1", q.d, 2 * q.r, what(q.d))
    >>> paper.equation("2", q.d - 2 * q.r)
    >>> paper.shows("1", "table 1", d="40.0", r="20.0")
    >>> [(number, equation.residual) for number, equation in paper.equations.items()]
    [('1', d - 2*r), ('2', d - 2*r)]
    """

    name: str
    reference: str
    equations: dict[str, Equation] = field(default_factory=dict)
    place: int | None = None
    reading: dict[sp.Symbol, Expr] = field(default_factory=dict)
    readings: dict[str, dict[sp.Symbol, Expr]] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    rough: set[str] = field(default_factory=set)
    references: list[Reference] = field(default_factory=list)

    @property
    def rank(self) -> tuple[bool, int, str]:
        """The key by which papers are sorted: place, then name; without unit."""
        return self.place is None, self.place or 0, self.name

    def equation(
        self,
        number: str,
        residual: Expr,
        claims: Claimed = UNCLAIMED,
        legibility: Legibility = "printed",
    ) -> None:
        """Add an equation printed as ``residual = 0``, in any one unit, with what the paper claims
        it to be.

        The claim is a balance (`Mechanism.balance`), a closed loop (`derive.loop`), what a quantity
        is (`derive.what`) or a sentence of the machine's vocabulary; without one the equation is
        only compared with values in motion. ``legibility`` is "printed", "partly legible" or
        "lost". Raises ValueError if the number exists. Example: `Paper`.
        """
        typed = [*transcribe_call(sys._getframe(1), 1), "= 0"]
        self._add(Equation(number, residual, f"{self.name} ({number})", claims, legibility), typed)

    def defines(
        self,
        number: str,
        symbol: Quantity,
        expr: Expr,
        claims: Claimed = UNCLAIMED,
        legibility: Legibility = "printed",
    ) -> None:
        """Add a formula printed as ``symbol = expr``, in the unit of the symbol; else as
        `equation`.
        """
        typed = transcribe_call(sys._getframe(1), 2)
        source = f"{self.name} ({number})"
        equation = Equation(number, symbol - expr, source, claims, legibility, defines=symbol)
        self._add(equation, [*typed[:1], "=", *typed[1:]])

    def inequality(
        self,
        number: str,
        left: Expr,
        relation: Relation,
        right: Expr,
        claims: Claimed,
        legibility: Legibility = "printed",
    ) -> None:
        """Add a condition printed as ``left < right`` or with another ``relation``, in one unit;
        else as `equation`.
        """
        source = f"{self.name} ({number})"
        typed = transcribe_call(sys._getframe(1), 3)
        equation = Equation(number, left - right, source, claims, legibility, relation=relation)
        self._add(equation, [*typed[:1], relation, *typed[2:]])

    def symbol(self, name: str, unit: str, meaning: str) -> Quantity:
        """Return a quantity that only the paper uses, in ``unit`` of SI.

        Raises ValueError for a name that code needs.

        >>> from derive import Paper
        >>> Paper("invented2026", "An invented paper").symbol("F_E", "N", "support force").source
        'invented2026'
        """
        return Quantity(name, unit, meaning, self.name)

    def reads(self, meaning: Mapping[sp.Symbol, Expr], *numbers: str) -> None:
        r"""State what printed symbols stand for, each in the unit of its symbol.

        It applies to the numbered equations, or to all if no number is passed. Raises ValueError
        for a number that the paper does not have.

        >>> from derive import Paper, quantities
        >>> q = quantities("r | m | radius\nd | m | diameter")
        >>> paper = Paper("invented2026", "An invented paper")
        >>> paper.reads({q.d: 2 * q.r})
        >>> paper.reading
        {d: 2*r}
        """
        for number in numbers:
            self._equation(number)
            self.readings.setdefault(number, {}).update(meaning)
        if not numbers:
            self.reading.update(meaning)

    def admits(self, numbers: Sequence[str], *readings: Reading) -> None:
        """State every reading that the paper admits of some equations, the literal one first.

        One reading holds for all of the equations. Each is tried, and a verdict given for each. A
        symbol that may mean something else elsewhere has another call there. Readings have no unit.
        Raises ValueError for a number that the paper does not have.
        """
        for number in numbers:
            self._equation(number)
        self.questions.append(Question(tuple(numbers), readings))

    def approximates(self, *numbers: str) -> None:
        """State that the paper itself calls what these equations give approximate ("about"), in
        words, without unit.

        Raises ValueError for a number that the paper does not have.
        """
        for number in numbers:
            self._equation(number)
            self.rough.add(number)

    def rebuilds(self, number: str, *pieces: str) -> None:
        """State which pieces of a transcription were illegible and completed, in words, without
        unit.

        Raises ValueError for a number that the paper does not have.
        """
        self.equations[number] = replace(self._equation(number), rebuilt=pieces)

    def shows(
        self,
        number: str,
        where: str,
        between: Mapping[Quantity, tuple[Expr, Expr]] | None = None,
        **values: str,
    ) -> None:
        """Add values that the paper prints for an equation: digits by the symbol's name.

        They are in the units of the print, which the equation must allow. ``where`` is their place
        in the paper. ``between`` holds, for symbols without printed values, the smallest and the
        largest value that other symbols allow [the unit of the symbol]. Raises ValueError for a
        number that the paper does not have, KeyError for a symbol that its equation does not have.
        Example: `Paper`.
        """
        equation = self._equation(number)
        bounds = tuple(
            (symbol, sp.sympify(low), sp.sympify(high))
            for symbol, (low, high) in (between or {}).items()
        )
        symbols_shown = equation.residual.free_symbols.union(
            *(low.free_symbols | high.free_symbols for _, low, high in bounds)
        )
        named = {str(s): s for s in symbols_shown if isinstance(s, Quantity)}
        witness = Witness(
            where, tuple((named[name], digits) for name, digits in values.items()), bounds
        )
        self.equations[number] = replace(equation, witnesses=(*equation.witnesses, witness))

    def refers(self, symbols: Sequence[Quantity], *numbers: str) -> None:
        """State that the paper takes ``symbols``, each in its unit, from these equations.

        Raises ValueError for a number that the paper does not have.
        """
        for number in numbers:
            self._equation(number)
        self.references.append(Reference(tuple(symbols), numbers))

    def _equation(self, number: str) -> Equation:
        if number not in self.equations:
            raise ValueError(f"{self.name} has no equation {number} to read")
        return self.equations[number]

    def _add(self, equation: Equation, typed: Sequence[str]) -> None:
        if equation.number in self.equations:
            raise ValueError(f"{self.name} has two equations {equation.number}")
        is_known = len(typed) > 1 and typed[0] != "="
        words = " ".join(typed) if is_known else f"{equation.residual} {equation.relation} 0"
        self.equations[equation.number] = replace(equation, typed=words)
