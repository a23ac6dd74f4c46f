"""Evidence of verdicts: all that a program without derive needs to repeat them.

`check_verdicts.py` beside this module says what it trusts of it, and what it repeats.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..equations import Equation
from ..evaluate import Point
from ..quantity import Quantity
from .case import MOST_POINTS, Case
from .comparison import FLIPPED, solve_for
from .edits import Edit
from .faults import ACTIONS
from .reading_search import Hearing, Outcome
from .terms import common_factor, evaluate_at, holds

FORMAT = "planter verdicts 1"
WITNESS_DIGITS = 30
RANGE_DIGITS = 12
SAMPLES = 12
"""Admissible points whose values span the ranges of random points."""
ROUNDS = 12
"""Times that definitions are put into one another."""
SEED = 7
TRIES = 400
"""Random points that are tried to refute a condition."""
WIDER = 1.5
"""Standard deviation of the exponent of two by which a value leaves its range."""
USUAL = mpf("0.2"), mpf(2)
"""Range of a quantity without values."""
MARGIN = mpf("1e-12")
"""Share of the largest term that is left where a print fails: far above the last of the digits of
a witness.
"""

Entry = dict[str, Any]


def write_evidence(case: Case, number: str, outcome: Outcome) -> Entry:
    """Return the evidence of the verdict on an equation, under every reading."""
    printed = case.paper.equations[number]
    hearings = outcome.alternatives or (outcome.kindest,)
    return {
        "paper": case.paper.name,
        "equation": number,
        "verdict": outcome.kindest.judgement.verdict,
        "legibility": printed.legibility,
        "transcription": printed.typed,
        "defines": str(printed.defines or ""),
        "direction": printed.defines in case.directions,
        "values": [
            {
                "where": witness.where,
                "values": {str(symbol): digits for symbol, digits in witness.values},
                "between": {str(s): [str(low), str(high)] for s, low, high in witness.between},
            }
            for witness in printed.witnesses
        ],
        "taken": hearings.index(outcome.kindest),
        "readings": [HearingEvidence(case, number, hearing).write() for hearing in hearings],
    }


def write_unjudged(case: Case, number: str) -> Entry:
    """Return the evidence of an equation that cannot be judged: none."""
    printed = case.paper.equations[number]
    return {
        "paper": case.paper.name,
        "equation": number,
        "verdict": "not judged",
        "legibility": printed.legibility,
        "transcription": printed.typed,
        "readings": [],
    }


@dataclass(frozen=True)
class HearingEvidence:
    """Evidence of the verdict on an equation under one reading."""

    case: Case
    number: str
    hearing: Hearing

    def write(self) -> Entry:
        """Return what the checker repeats."""
        judgement, choice = self.hearing.judgement, self.hearing.choice
        derived, printed = self.hearing.derived, self.hearing.printed
        entry: Entry = {
            "reading": choice.meaning,
            "verdict": judgement.verdict,
            "meanings": {str(s): str(meant) for s, meant in self.meanings.items()},
            "text": "" if choice.text is None else str(choice.text),
            "through": list(map(str, self._find_definitions(self.unread, printed.residual) or ())),
            "read": str(printed.residual),
            "derived": "",
            "relations": [printed.relation, printed.relation, printed.relation],
            "flips": False,
        }
        lists = ("steps", "missing", "unexplained", "points", "definitions", "meaning_of_missing")
        entry |= {name: [] for name in lists} | {"loose": {}, "ranges": {}, "where": ""}
        if derived is None:
            return entry
        left = sp.Add(*judgement.missing, *(-term for term in judgement.unexplained))
        multiple = self._find_multiple(self._complete(self.sides[0], left))
        pairs = [(self._complete(side, left), multiple * derived.residual) for side in self.sides]
        fails = judgement.verdict in ("misprint", "incomplete", "contradicted")
        keeps_sense = derived.relation == "=" or self.undivided * multiple > 0
        after = derived.relation if keeps_sense else FLIPPED[derived.relation]
        definitions = [[] if judgement.domain else self._find_definitions(*pair) for pair in pairs]
        holding = [place for place, names in enumerate(definitions) if names is not None]
        ways = [judgement.ways[place] for place in holding if judgement.ways]
        names = [
            name for some in dict.fromkeys(map(tuple, filter(None, definitions))) for name in some
        ]
        entry |= {
            "derived": str(derived.residual),
            "relations": [printed.relation, after, derived.relation],
            "flips": after != printed.relation,
            "where": "" if derived.where == sp.true else str(derived.where),
            "initial": str(self.start),
            "solved": self.is_solved,
            "undivided": str(self.undivided),
            "multiple": str(multiple),
            "steps": [_write_way(self.start, way) for way in ways],
            "missing": list(map(str, judgement.missing)),
            "unexplained": list(map(str, judgement.unexplained)),
            "loose": {name: str(expr) for name, expr in judgement.loose.items()},
            "definitions": list(map(str, names)),
            "meaning_of_missing": self._list_missing_actions(),
        }
        if judgement.domain:
            entry["points"] = [self._write_point(point) for point in self.case.cycle]
        entry["ranges"] = self._write_ranges(pairs[0][0] - pairs[0][1], names)
        if fails or judgement.domain:
            entry["witness"] = self._find_witness()
        return entry

    @cached_property
    def table(self) -> Mapping[sp.Symbol, Expr]:
        return self.case.definitions

    @cached_property
    def meanings(self) -> dict[sp.Symbol, Expr]:
        """Meanings of printed symbols under this reading."""
        symbols = self.case.paper.equations[self.number].residual.free_symbols
        if self.hearing.choice.text is not None:
            symbols = self.hearing.choice.text.free_symbols
        meanings = self.case.find_meanings(self.number, self.hearing.choice)
        return {s: meant for s, meant in meanings.items() if s in symbols}

    @cached_property
    def unread(self) -> Expr:
        """The residual as it is read, before it is put into the quantities of the derivation."""
        text = self.hearing.choice.text
        printed = self.case.paper.equations[self.number].residual if text is None else text
        return printed.xreplace(self.meanings)

    @property
    def start(self) -> Expr:
        """The residual that the corrections change, or a side of it."""
        judgement = self.hearing.judgement
        return self.hearing.printed.residual if judgement.start is None else judgement.start

    @property
    def is_solved(self) -> bool:
        """Whether corrections change what the equation says that a symbol is."""
        printed = self.hearing.printed
        return (
            self.hearing.judgement.start is not None
            and printed.defines is not None
            and self.start == solve_for(printed.residual, printed.defines)
            and self.start != printed.residual
        )

    @property
    def sides(self) -> list[Expr]:
        """Results of each way to correct the start; the start itself without any."""
        ways = self.hearing.judgement.ways or ((),)
        return [way[-1].result if way else self.start for way in ways]

    def _complete(self, side: Expr, left: Expr) -> Expr:
        """Return the residual of a side with the terms that it lacks."""
        symbol = self.hearing.printed.defines
        return symbol - side - left if self.is_solved else side + left

    @property
    def undivided(self) -> Expr:
        """The factor between the residual that was corrected and the one that was read."""
        printed = self.hearing.printed
        if self.is_solved:
            return 1 / printed.residual.diff(printed.defines)
        if self.start in (printed.residual, -printed.residual):
            return sp.S.One if self.start == printed.residual else sp.S.NegativeOne
        return common_factor(self.start) / common_factor(printed.residual)

    def _find_multiple(self, completed: Expr) -> Expr:
        """Return the number by which the completed print is larger than the derivation."""
        derived = self.hearing.derived
        assert derived is not None
        symbol = self.hearing.printed.defines
        if symbol is not None and derived.defines == symbol:
            slopes = completed.diff(symbol), derived.residual.diff(symbol)
            if all(slope.is_number and slope != 0 for slope in slopes):
                return slopes[0] / slopes[1]
        for point in self.case.points_where(derived.where):
            above, below = (evaluate_at(side, point) for side in (completed, derived.residual))
            if above is not None and below:
                return sp.Rational(str(mpmath.nstr(above / below, 20))).limit_denominator(1000)
        return sp.S.One

    def _find_definitions(self, first: Expr, second: Expr) -> list[sp.Symbol] | None:
        """Return the definitions that make two residuals equal, in the order in which they are put
        in; None if none do.

        Put in first are quantities that one residual alone has, the longest there, those of the
        first before those of the second; what a definition brings in may be what the other has.
        """
        names: list[sp.Symbol] = []
        defined = self.table.keys() - {self.hearing.printed.defines}
        rounds: dict[sp.Symbol, int] = {}
        for place in range(ROUNDS):
            if self._is_identity(first - second):
                return names
            sides = [side.free_symbols & defined for side in (first, second)]
            rounds = {s: rounds.get(s, place) for s in sides[0] | sides[1]}
            in_one_side = sides[0] ^ sides[1] or sides[0]
            if not in_one_side:
                return None
            next_ = min((rounds[s], s not in sides[0]) for s in in_one_side)
            chosen = [s for s in in_one_side if (rounds[s], s not in sides[0]) == next_]
            for name in sorted(chosen, key=str):
                names.append(name)
                replaced = {name: self.table[name]}
                first, second = first.xreplace(replaced), second.xreplace(replaced)
        return None

    def _is_identity(self, expr: Expr) -> bool:
        """Whether an expression vanishes at random points of its symbols, each by itself."""
        if not expr.free_symbols:
            return bool(abs(sp.N(expr, 30)) < MARGIN) or self._turns(expr, Point({}))
        decided = 0
        for values in self._draw(expr.free_symbols):
            point = Point(values)
            value = evaluate_at(expr, point)
            if value is None:
                continue
            largest = max(abs(point(term)) for term in sp.Add.make_args(expr))
            if abs(value) > MARGIN * max(1, largest) and not self._turns(expr, point):
                return False
            decided += 1
        return decided > 0

    def _turns(self, expr: Expr, point: Point) -> bool:
        symbol = self.hearing.printed.defines
        if symbol not in self.case.directions:
            return False
        turns = point(expr) / (2 * mpmath.pi)
        return bool(abs(turns - mpmath.nint(turns)) < MARGIN)

    def _draw(
        self, symbols: Iterable[sp.Symbol], widening: float = 0.0
    ) -> Iterator[dict[sp.Symbol, mpf]]:
        """Yield values of symbols within their ranges, or by a factor outside."""
        rng = random.Random(SEED)
        names = sorted(symbols, key=str)
        ends = [self._ranges.get(s, USUAL) for s in names]
        for _ in range(TRIES if widening else SAMPLES):
            yield {
                s: (low + (high - low) * mpf(rng.random())) * mpf(2) ** rng.gauss(0, widening)
                for s, (low, high) in zip(names, ends, strict=True)
            }

    @cached_property
    def _ranges(self) -> dict[sp.Symbol, tuple[mpf, mpf]]:
        derived = self.hearing.derived
        where = sp.true if derived is None else derived.where
        points = (
            [p for p in self.case.draw(MOST_POINTS) if p.holds(where)][:SAMPLES]
            if where != sp.true
            else self.case.draw(SAMPLES)
        )
        columns = [point.values() for point in points]
        ranges = {s: [column[s] for column in columns] for s in (columns or [{}])[0]}
        ends = {s: (min(values), max(values)) for s, values in ranges.items()}
        return {s: (low, high) for s, (low, high) in ends.items() if high - low > MARGIN}

    def _write_ranges(self, difference: Expr, names: Iterable[sp.Symbol]) -> dict[str, list[str]]:
        """Return the ranges of random points, of what is not rational in quantities, sines and
        cosines.
        """
        assert self.hearing.derived is not None
        where = self.hearing.derived.where
        parts = [difference, *(self.table[name] for name in names)]
        if where == sp.true and not any(map(_is_opaque, parts)):
            return {}
        symbols = where.free_symbols.union(*(part.free_symbols for part in parts))
        return {
            str(s): [mpmath.nstr(end, RANGE_DIGITS) for end in ends]
            for s, ends in self._ranges.items()
            if s in symbols
        }

    def _list_missing_actions(self) -> list[str]:
        """List the actions of missing terms that the print does not name, and that are defined in
        other quantities.
        """
        judgement = self.hearing.judgement
        terms = (*judgement.missing, *judgement.unexplained)
        acting = {
            s
            for term in terms
            for s in term.free_symbols
            if isinstance(s, Quantity) and s.unit in ACTIONS
        }
        acting -= self.hearing.printed.residual.free_symbols
        return sorted(str(s) for s in acting & self.case.subject.reactions().keys())

    def _write_point(self, point: Point) -> dict[str, str]:
        assert self.hearing.derived is not None
        judgement = self.hearing.judgement
        parts = self.hearing.printed.residual, self.hearing.derived.residual
        symbols = set().union(*(e.free_symbols for e in (*parts, *judgement.loose.values())))
        return {str(s): mpmath.nstr(point(s), WITNESS_DIGITS) for s in sorted(symbols, key=str)}

    def _find_witness(self) -> Entry:
        """Return a point at which the derivation holds and the print does not."""
        derived, printed = self.hearing.derived, self.hearing.printed
        assert derived is not None
        if loose := self.hearing.judgement.loose:
            some = next(p for p in self.case.points if all(map(p, loose.values())))
            return {"values": self._write_point(some), "unknown": ""}
        for point in self._list_candidates():
            if printed.relation != "=":
                if _is_true(printed, point) != _is_true(derived, point):
                    return {"values": self._write_point(point), "unknown": ""}
                continue
            for unknown in self._list_unknowns(derived):
                slope = derived.residual.diff(unknown)
                if not evaluate_at(slope, point):
                    continue
                solved = point(unknown) - point(derived.residual) / point(slope)
                moved = Point(point.values() | {unknown: solved})
                if not holds(printed.residual, (moved,)) and not self._turns(
                    printed.residual, moved
                ):
                    return {"values": self._write_point(point), "unknown": str(unknown)}
        raise ValueError(
            f"({self.number}): no point where the print fails and the derivation holds"
        )

    def _list_candidates(self) -> Iterator[Point]:
        derived = self.hearing.derived
        assert derived is not None
        yield from self.case.points_where(derived.where)
        yield from self.case.draw(MOST_POINTS)
        symbols = self.hearing.printed.residual.free_symbols | derived.residual.free_symbols
        for values in self._draw(symbols, WIDER):
            yield Point(values)

    def _list_unknowns(self, derived: Equation) -> list[sp.Symbol]:
        if derived.defines is not None:
            return [derived.defines]
        symbols = sorted(derived.residual.free_symbols, key=str)
        return [
            s
            for s in symbols
            if (slope := derived.residual.diff(s)) != 0 and s not in slope.free_symbols
        ]


def _is_true(equation: Equation, point: Point) -> bool:
    value = evaluate_at(equation.residual, point)
    signs = {"<": (-1,), "<=": (-1, 0), ">": (1,), ">=": (1, 0)}
    return value is not None and int(mpmath.sign(value)) in signs[equation.relation]


def _is_opaque(expr: Expr) -> bool:
    """Return whether an expression is not rational in quantities, sines and cosines."""
    functions = expr.atoms(sp.Function) - expr.atoms(sp.sin, sp.cos, sp.tan)
    return bool(functions) or any(not power.exp.is_Integer for power in expr.atoms(sp.Pow))


def _write_step(side: Expr, edit: Edit) -> Entry:
    """Return an edit of a side: the frame in which it changes one part, or symbols throughout."""
    frame, old, new = edit.frame(side)
    swaps = {} if frame is not None else {str(a): str(b) for a, b in edit.swaps}
    return {
        "words": str(edit.text),
        "swaps": swaps,
        "frame": str(frame if frame is not None else sp.S.Zero),
        "old": str(old),
        "new": str(new),
        "after": str(edit.result),
    }


def _write_way(side: Expr, edits: Iterable[Edit]) -> list[Entry]:
    steps = []
    for edit in edits:
        steps.append(_write_step(side, edit))
        side = edit.result
    return steps


def format_evidence(records: Sequence[Entry], cases: Iterable[Case]) -> str:
    """Return the file of verdicts: the evidence of all, and the definitions that it names."""
    tables: dict[str, dict[str, str]] = {}
    for case in cases:
        records_of_paper = [record for record in records if record["paper"] == case.paper.name]
        names = {
            name
            for record in records_of_paper
            for reading in record["readings"]
            for part in ("through", "definitions", "meaning_of_missing")
            for name in reading[part]
        }
        tables[case.paper.name] = {
            str(s): str(expr) for s, expr in case.definitions.items() if str(s) in names
        }
    content = {"format": FORMAT, "definitions": tables, "records": list(records)}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"
