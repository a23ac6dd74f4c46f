"""A paper as data: its equations as they stand in print."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import sympy as sp
from sympy import Expr

from ..equations import Claimed, Equation, Legibility, Relation, Unclaimed, Witness
from ..quantity import Quantity


@dataclass(frozen=True)
class Reading:
    """One of the things that a print may be meant to say.

    ``printed`` and ``derived`` replace symbols of the print and of its derivation; ``text`` is another way to read the
    characters, as a residual; ``because`` names the place in the paper that admits it.
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
    """What a paper leaves open of some of its equations, and every admissible answer: one holds for all of them."""

    numbers: tuple[str, ...]
    readings: tuple[Reading, ...]


@dataclass(frozen=True)
class Reference:
    """A place where a paper says from which of its equations it has some quantities."""

    symbols: tuple[Quantity, ...]
    numbers: tuple[str, ...]


@dataclass
class Paper:
    """Transcriptions of one paper, by equation number; a short name stands for a number where print gives none.

    ``reading`` says what printed symbols stand for in the named quantities, ``readings`` in single equations;
    ``questions`` are what the paper leaves open. Papers are shown in the order of their ``place``, those that have none
    after them, by name.
    """

    name: str
    reference: str
    equations: dict[str, Equation] = field(default_factory=dict)
    place: int | None = None
    reading: dict[sp.Symbol, Expr] = field(default_factory=dict)
    readings: dict[str, dict[sp.Symbol, Expr]] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    references: list[Reference] = field(default_factory=list)

    @property
    def rank(self) -> tuple[bool, int, str]:
        """What papers are sorted by."""
        return self.place is None, self.place or 0, self.name

    def equation(
        self, number: str, residual: Expr, claims: Claimed = Unclaimed.HOLDS, legibility: Legibility = "printed"
    ) -> None:
        """An equation printed as ``residual = 0``, and the balance or relation that the paper says it is.

        Without a claim it is held against values alone: whether it holds of the subject in motion.
        """
        self._add(Equation(number, residual, f"{self.name} ({number})", claims, legibility))

    def defines(
        self, number: str, symbol: Quantity, expr: Expr, claims: Claimed = Unclaimed.HOLDS,
        legibility: Legibility = "printed",
    ) -> None:  # fmt: skip
        """A formula printed as ``symbol = expr``; what it claims as of `equation`."""
        self._add(Equation(number, symbol - expr, f"{self.name} ({number})", claims, legibility, defines=symbol))

    def inequality(
        self,
        number: str,
        left: Expr,
        relation: Relation,
        right: Expr,
        claims: Claimed,
        legibility: Legibility = "printed",
    ) -> None:
        """A condition printed as ``left < right`` or the like."""
        source = f"{self.name} ({number})"
        self._add(Equation(number, left - right, source, claims, legibility, relation=relation))

    def symbol(self, name: str, unit: str, meaning: str) -> Quantity:
        """A symbol that only the paper uses."""
        return Quantity(name, unit, meaning, self.name)

    def reads(self, meaning: Mapping[sp.Symbol, Expr], *numbers: str) -> None:
        """What printed symbols stand for: in the equations of these numbers, or wherever they stand without any."""
        for number in numbers:
            self._known(number)
            self.readings.setdefault(number, {}).update(meaning)
        if not numbers:
            self.reading.update(meaning)

    def admits(self, numbers: Sequence[str], *readings: Reading) -> None:
        """Every reading that the paper admits of some equations, the literal one first: one of them holds for all.

        A verdict is given under each. A symbol that may mean another thing elsewhere has a question of its own there.
        """
        for number in numbers:
            self._known(number)
        self.questions.append(Question(tuple(numbers), readings))

    def rebuilds(self, number: str, *pieces: str) -> None:
        """Pieces of a transcription that cannot be read and were completed."""
        self.equations[number] = replace(self._known(number), rebuilt=pieces)

    def shows(
        self, number: str, where: str, between: Mapping[Quantity, tuple[Expr, Expr]] | None = None, **values: str
    ) -> None:
        """Values that the paper prints of an equation's symbols: digits by the symbol's name.

        ``between`` holds the least and the largest value that others allow of a symbol without printed values.
        """
        known = self._known(number)
        bounds = tuple((symbol, sp.sympify(low), sp.sympify(high)) for symbol, (low, high) in (between or {}).items())
        asked = known.residual.free_symbols.union(*(low.free_symbols | high.free_symbols for _, low, high in bounds))
        named = {str(s): s for s in asked if isinstance(s, Quantity)}
        witness = Witness(where, tuple((named[name], digits) for name, digits in values.items()), bounds)
        self.equations[number] = replace(known, witnesses=(*known.witnesses, witness))

    def refers(self, symbols: Sequence[Quantity], *numbers: str) -> None:
        """The paper says that it has these quantities from these equations."""
        for number in numbers:
            self._known(number)
        self.references.append(Reference(tuple(symbols), numbers))

    def _known(self, number: str) -> Equation:
        if number not in self.equations:
            raise ValueError(f"{self.name} has no equation {number} to read")
        return self.equations[number]

    def _add(self, equation: Equation) -> None:
        if equation.number in self.equations:
            raise ValueError(f"{self.name} has two equations {equation.number}")
        self.equations[equation.number] = equation
