"""A paper on trial from its own text: its displayed equations, read and compared with a mechanism
or formulas.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import sympy as sp
from sympy import Expr

from ...discovery import load_user_modules
from ...equations import UNCLAIMED, Claimed, Definition, Equation, Relation, what
from ...evaluate import Point
from ...generated_folder import OwnError, blame_user_file
from ...mechanics.mechanism import Mechanism
from ...quantity import Quantity
from ..case import Case
from ..comparison import Comparison
from ..paper import Paper, Repair, Subject
from ..terms import holds, list_unknown
from ..user_mechanism.motions import ConfigurationSubject
from ..user_mechanism.subject import MechanismSubject
from ..user_mechanism.trial import SECONDS, build_subject, trial
from .corrections import find_repairs
from .documents import Row, TextDocument, list_rows, read_document
from .formula import (
    Bracket,
    Derivative,
    FormulaError,
    Matrix,
    Name,
    Node,
    Number,
    Product,
    RelationChain,
    Sum,
    Symbol,
    expand_matrix_macros,
    list_nodes,
    read_formula,
)
from .interpretation import Read, UnknownNameError, interpret_formula
from .names import NameTable, Stated, StatedNames, find_stated, read_name_table, to_scalar
from .values import OperandError, Scalar, Value

ANNOUNCEMENT = re.compile(
    r"(?i)\blineari[sz]|\bsmall(?:[ -]\w+)?[ "
    r"-](?:angle|displacement|deflection|oscillation|rotation|vibration|motion)"
    r"|\bfirst[ -]order\b|\bsmall[ -]angle|\\sin\s*\{?\\?\w+\}?\s*\\(?:approx|simeq)|\bnear "
    r"(?:the|its) equilibrium"
)
"""Words and formulas that say that motions are small."""
MOST_LISTED = 4
"""Equations of which the numbers stand in a remark."""


@dataclass
class ReadRow:
    """A row of a text: its tree and its sides, both None if it is refused, and why it is not
    judged.

    ``names`` are the meanings that hold in it.
    """

    row: Row
    names: StatedNames
    chain: RelationChain | None = None
    read: Read | None = None
    reason: str = ""
    defines: Symbol | None = None
    unknown: Symbol | None = None
    clash: str = ""

    @property
    def record(self) -> dict[str, Any]:
        """Return the place of the row, whether it was read, and why it is not judged if it is
        not.
        """
        status = "refused" if self.chain is None else "read"
        return {
            "file": self.row.file,
            "line": self.row.line,
            "status": status,
            "reason": self.reason,
        }


@dataclass(frozen=True)
class Place:
    """Place of an equation of the paper: its row, and which of the row's residuals it is."""

    row: ReadRow
    index: int


@dataclass
class PrintedText:
    """A text whose rows were read: what the audit asks about the place and the own LaTeX of an
    equation.
    """

    document: TextDocument
    names: StatedNames
    rows: list[ReadRow]
    places: dict[str, Place] = field(default_factory=dict)
    uses: dict[str, list[str]] = field(default_factory=dict)
    """The rows that hold and rest on a definition of the text that the mechanism does not test,
    by the name.
    """
    meant: dict[str, str] = field(default_factory=dict)
    """What names must mean that the text defines wrongly, by texts of a names file."""
    _repairs: dict[str, Repair | None] = field(default_factory=dict)
    _outcomes: dict[str, dict[str, list[bool] | None]] = field(default_factory=dict)

    def repair(
        self, number: str, points: list[Point], draw: Callable[[int], list[Point]]
    ) -> Repair | None:
        """Return the smallest change of an equation's own LaTeX after which it holds at points,
        None without one.

        ``draw`` returns a number of random admissible points.
        """
        if number not in self._repairs:
            place = self.places[number]
            row = place.row.row
            outcomes = self._outcomes.setdefault(row.number, {})
            self._repairs[number] = self.correct(
                row.latex, place.index, place.row.names, points, draw, outcomes
            )
        return self._repairs[number]

    def correct(
        self,
        latex: str,
        index: int,
        names: StatedNames,
        points: Sequence[Point],
        draw: Callable[[int], list[Point]],
        outcomes: dict[str, list[bool] | None] | None = None,
    ) -> Repair | None:
        """Return the smallest change of a row in which names have some meanings; see
        `find_repairs`.
        """
        macros, words = self.document.macros, self.list_vocabulary()
        return find_repairs(latex, index, names, points, macros, words, draw, outcomes)

    def explain_unjudged(self, number: str) -> str:
        """Return why an equation cannot be judged, empty if it can."""
        return self.places[number].row.reason

    def announces_small_motion(self, number: str) -> bool:
        """Return whether the text says before an equation that motions are small, or that it
        linearises.
        """
        line = self.places[number].row.row.line
        before = "\n".join(self.document.text.split("\n")[: self.document.lines.index(line) + 1])
        return ANNOUNCEMENT.search(before) is not None

    def compares_angles(self, number: str) -> bool:
        """Return whether both sides of an equation are angles: turns do not count."""
        place = self.places[number]
        if place.row.read is None:
            return False
        _, relation, left, right = place.row.read.residuals(place.row.names)[place.index]
        return relation == "=" and left.kind == right.kind == "angle"

    def find_clash(self, number: str) -> str:
        """Return which terms of a definition have different units, empty if none have."""
        return self.places[number].row.clash

    def describe_use(self, number: str) -> str:
        """Return which equations hold that rest on a definition, empty if none do."""
        symbol = self.places[number].row.defines
        numbers = self.uses.get(symbol.spell(), []) if symbol else []
        listed = ", ".join(f"({some})" for some in numbers[:MOST_LISTED])
        return f"a name of the text; what rests on it holds: {listed}" if numbers else ""

    def describe_footing(self, number: str) -> str:
        """Return what may be wrong instead of an equation: the definitions that it rests on and
        nothing tests; or what its own name must mean, if it defines one.

        Empty if there is neither.
        """
        chain = self.places[number].row.chain
        first = chain.sides[0] if chain is not None else None
        if isinstance(first, Name) and first.symbol.spell() in self.meant:
            meant = self.meant[first.symbol.spell()]
            return f"more of what rests on {first.symbol.spell()} holds if it is {meant}"
        rests = self.list_footing(self.places[number].row)
        untested = [
            f"{spelling} of ({row.row.number})"
            for spelling, row in rests.items()
            if self.uses.get(spelling) == []
        ]
        return f"it rests on what nothing tests: {', '.join(untested)}" if untested else ""

    def list_footing(self, row: ReadRow) -> dict[str, ReadRow]:
        """Return the rows that define names which a row rests on, also by other definitions, by
        name.
        """
        defining = {some.defines.spell(): some for some in self.rows if some.defines is not None}
        footing: dict[str, ReadRow] = {}
        waiting = [row]
        while waiting:
            spellings = {symbol.base.spell() for symbol in list_symbols(waiting.pop().chain)}
            new = [s for s in sorted(spellings & defining.keys()) if s not in footing]
            footing |= {spelling: defining[spelling] for spelling in new}
            waiting += [defining[spelling] for spelling in new]
        return {spelling: some for spelling, some in footing.items() if some is not row}

    def list_rows(self) -> list[dict[str, Any]]:
        """Return place, status and reason of every displayed row."""
        return [entry.record for entry in self.rows]

    def list_vocabulary(self) -> list[str]:
        """Return the names of the text that have a meaning, as they are printed."""
        spelled: dict[str, Symbol] = {}
        for row in self.rows:
            for symbol in list_symbols(row.chain):
                if self.names.is_known(symbol):
                    spelled.setdefault(symbol.spell(), symbol)
        return sorted(spelled)

    def describe(self, number: str) -> dict[str, Any]:
        """Return file, line and LaTeX of an equation, and its LaTeX corrected, empty if no change
        corrects it.
        """
        row = self.places[number].row.row
        repair = self._repairs.get(number)
        corrected = "" if repair is None else repair.latex
        return {
            "file": row.file,
            "line": row.line,
            "latex": row.latex,
            "corrected_latex": corrected,
        }


def list_symbols(chain: RelationChain | None) -> list[Symbol]:
    """List the names in a formula."""
    return (
        []
        if chain is None
        else [node.symbol for node in list_nodes(chain) if isinstance(node, Name)]
    )


def load_module(path: Path) -> ModuleType:
    """Run a user's Python file and return it as a module. Raises OwnError for what it raises."""
    if path.suffix != ".py" or not path.is_file():
        raise OwnError(f"{path}: --against needs a Python file that states a mechanism")
    with blame_user_file(path), load_user_modules(path) as (module,):
        return module


def read_trial(text: str | Path, against: str | Path, names: str | Path | None = None) -> Case:
    """Read a text and compare its equations with the mechanism or the formulas of a file.

    ``names`` is a file of meanings; names without an entry there mean the quantity whose name they
    spell. Raises OwnError, which names the file, for a text, names or a mechanism that cannot be
    used.
    """
    document = read_document(Path(text))
    table = NameTable() if names is None else read_name_table(Path(names))
    module = load_module(Path(against))
    stated = find_stated(module)
    return build_trial(document, stated, table, module)


def build_trial(
    document: TextDocument, stated: Stated, table: NameTable, module: ModuleType | None = None
) -> Case:
    """Build the case of a document, in which equations that do not hold claim what they come
    closest to.
    """
    case = read_case(document, stated, table, module)
    if meant := _test_definitions(case):
        table = replace(table, meanings={**table.meanings, **meant})
        case = read_case(document, stated, table, module)
        _test_definitions(case)
        assert isinstance(case.source, PrintedText)
        case.source.meant |= {spelling: text for spelling, text in meant.items() if "(" not in text}
    _list_uses(case)
    _claim_what_fails(case, case.paper)
    return case


def _list_uses(case: Case) -> None:
    """List for each definition that nothing tests the equations that hold and rest on it."""
    printed, equations = case.source, case.paper.equations
    assert isinstance(printed, PrintedText)
    for row in printed.rows:
        if row.defines and isinstance(equations[row.row.number].claims, Definition):
            printed.uses[row.defines.spell()] = []
    for row in printed.rows:
        spellings = printed.list_footing(row).keys() & printed.uses.keys()
        numbers = [number for number, place in printed.places.items() if place.row is row]
        # of vectors and matrices all entries must hold: one says nothing of the others
        if spellings and not row.reason and all(_is_sound(case, row, n) for n in numbers):
            for spelling in spellings:
                printed.uses[spelling].append(row.row.number)


def _is_sound(case: Case, row: ReadRow, number: str) -> bool:
    """Return whether an equation of a row states something of the mechanism, and it holds."""
    equation = case.paper.equations[number]
    is_empty = equation.residual == 0 and row.defines is None
    if is_empty or isinstance(equation.claims, Definition):
        return False
    return _vanishes(equation.residual, case.points)


def _test_definitions(case: Case) -> dict[str, str]:
    """Return what names must mean that the text defines wrongly, by the texts of a names file;
    definitions that the mechanism confirms are equations.

    Rows are judged with names as they are meant, and a wrong definition as an equation, which does
    not hold.
    """
    printed = case.source
    assert isinstance(printed, PrintedText)
    names, meant = printed.names, dict[str, str]()
    meanings = list_meanings(names) if any(row.defines for row in printed.rows) else {}
    for row in printed.rows:
        value = names.abbreviations.get(row.defines.spell()) if row.defines else None
        if not isinstance(value, Scalar):
            continue
        fitting = {t: some for t, some in meanings.items() if some.dimension == value.dimension}
        is_computed = not sp.sympify(value.value).is_Symbol
        if is_computed and any(_are_equal(value, some, case.points) for some in fitting.values()):
            equation = case.paper.equations[row.row.number]
            case.paper.equations[row.row.number] = replace(equation, claims=UNCLAIMED)
        elif text := _find_meant(case, printed, row, value, fitting):
            assert row.defines is not None
            meant[row.defines.spell()] = text
    return meant


AXES = {"x": 1, "y": 2, "z": 3}
ENERGIES = {"T": "kinetic()", "K": "kinetic()", "V": "potential()", "U": "potential()"}
"""Meanings that names of energies have where a text defines them without saying more."""
COMPLETED = " after "
"""What the words of a repair contain that adds a term: of such, any definition is one change from
any other.
"""


def list_meanings(names: StatedNames) -> dict[str, Scalar]:
    """Return what the name of a scalar may mean of a mechanism, by its text in a names file, none
    for formulas: positions, velocities and speeds of points, energies, and named quantities.
    """
    if not isinstance(names.stated, Mechanism):
        return {}
    texts = [
        f"component({kind}({place}), {axis})"
        for kind in ("position", "velocity")
        for place in names.places
        for axis in AXES.values()
    ]
    meanings: dict[str, Scalar] = {}
    for text in (*texts, *map(_describe_speed, names.places), "kinetic()", "potential()"):
        try:
            value = names.evaluate(text)
        except OwnError:
            continue
        if isinstance(value, Scalar) and value.value != 0:
            meanings[text] = value
    scalars = {name: to_scalar(quantity) for name, quantity in names.quantities.items()}
    return meanings | {name: some for name, some in scalars.items() if name not in names.places}


def _describe_speed(place: str) -> str:
    """Return the text of the speed of a point."""
    squares = (f"component(velocity({place}), {axis})**2" for axis in AXES.values())
    return f"sqrt({' + '.join(squares)})"


def _find_meant(
    case: Case, printed: PrintedText, row: ReadRow, value: Scalar, meanings: Mapping[str, Scalar]
) -> str:
    """Return which of some meanings a name must have that a row defines wrongly; empty if it may be
    right.

    A definition is wrong if more rows that speak of the name hold once it means a quantity of the
    mechanism, at least two more if that has a name of its own, since one row may be what is wrong;
    or if the name says which quantity, and one change of the definition makes it that, unless axis
    or origin are another.
    """
    assert row.defines is not None
    names, spelling = printed.names, row.defines.spell()
    named = [text for text in _list_named(names, row.defines) if text in meanings]
    resting = [
        other
        for other in printed.rows
        if other.read is not None
        and not other.reason
        and any(symbol.base.spell() == spelling for symbol in list_symbols(other.chain))
    ]

    def count_holding(some: StatedNames) -> int:
        return sum(_row_holds(other, some, printed.document, case.points) for other in resting)

    now = count_holding(names)
    failing = len(resting) - now
    candidates = [t for t in meanings if failing and (t not in names.quantities or failing > 1)]
    changed = {text: names.with_meanings({spelling: text}) for text in {*candidates, *named}}
    gains = {text: count_holding(changed[text]) - now for text in candidates}
    enough = {text: gain for text, gain in gains.items() if gain > (text in names.quantities)}
    best = max(enough.values(), default=0)
    if best > 0:
        chosen = [text for text, gain in enough.items() if gain == best]
        preferred = [text for text in chosen if text in named] or chosen
        return preferred[0] if len(preferred) == 1 else ""
    for text in named:
        if _differ_by_choice(names, value, meanings[text], case.points):
            continue
        # the row itself must not define what it is tried against
        other_names = replace(changed[text], abbreviations=dict(names.abbreviations))
        repair = printed.correct(row.row.latex, 0, other_names, case.points, case.draw)
        if repair is not None and COMPLETED not in repair.text:
            return text
    return ""


def _list_named(names: StatedNames, symbol: Symbol) -> Iterator[str]:
    """Yield meanings that the spelling of a name suggests."""
    stem, below = symbol.stem.removeprefix("\\"), symbol.subscript.strip("{} ").casefold()
    places = [place for place in names.places if below and place.casefold() == below]
    if stem == "v":
        yield from map(_describe_speed, places)
    if stem in AXES:
        yield from (f"component(position({place}), {AXES[stem]})" for place in places)
    if stem in ENERGIES and not below:
        yield ENERGIES[stem]


def _are_equal(first: Scalar, second: Scalar, points: Sequence[Point]) -> bool:
    return _vanishes(first.value - second.value, points)


def _vanishes(residual: Expr, points: Sequence[Point]) -> bool:
    """Whether a residual has values and is zero at points, or identically."""
    if list_unknown(residual, points):
        return False
    return residual == 0 or holds(residual, tuple(points))


def _differ_by_choice(
    names: StatedNames, value: Scalar, meaning: Scalar, points: Sequence[Point]
) -> bool:
    """Whether two quantities are one but for the direction of an axis, or for where it is counted
    from.
    """
    try:
        first, second = names.rate(value), names.rate(meaning)
    except (FormulaError, OperandError):
        return True
    if not (isinstance(first, Scalar) and isinstance(second, Scalar)):
        return True
    return any(_are_equal(first, sign, points) for sign in (second, -second))


def _row_holds(
    row: ReadRow, names: StatedNames, document: TextDocument, points: list[Point]
) -> bool:
    """Return whether all that a row states holds under some meanings."""
    entry = read_row(row.row, names, document)
    if entry.read is None or entry.reason:
        return False
    return all(
        relation == "=" and _vanishes(sp.sympify(left.value - right.value), points)
        for _, relation, left, right in entry.read.residuals(names)
    )


def read_case(
    document: TextDocument, stated: Stated, table: NameTable, module: ModuleType | None = None
) -> Case:
    """Read the case of a document: every row that can be read for certain becomes an equation of
    the paper.
    """
    document = replace(document, macros={**document.macros, **table.macros})
    until = table.until_s or SECONDS
    subject = build_subject(stated, until)
    names = StatedNames(stated, list_quantities(stated, subject), table, module)
    paper = Paper(re.sub(r"\W+", "_", Path(document.name).stem), document.name)
    printed = PrintedText(document, names, [])
    claims = subject.claims()
    by_sentence = {str(claim): claim for claim in claims}
    printed.rows.extend(_read_rows(document, names, table))
    for entry in printed.rows:
        entry_of_row = table.rows.get(entry.row.number, {})
        if entry_of_row.get("skip"):
            entry.reason = f"left out: {entry_of_row['skip']}"
        if entry.chain is not None:
            claim = _find_claim(entry_of_row, by_sentence, table, entry.row)
            _add_row(entry, claim, printed, paper, claims)
    if unknown := sorted(table.rows.keys() - {entry.row.number for entry in printed.rows}):
        numbers = ", ".join(entry.row.number for entry in printed.rows[:20]) or "none"
        raise OwnError(
            f"{table.file}: rows.{unknown[0]}: {document.name} has no such row; it has {numbers}"
        )
    return replace(trial(stated, paper, until), source=printed)


def _read_rows(document: TextDocument, names: StatedNames, table: NameTable) -> list[ReadRow]:
    """Read the rows of a text, those with unknown names again once a later row defines these.

    What a later definition gives other units is not what it speaks of, and stays unknown.
    """
    rows = list_rows(document)
    in_row = [names.with_meanings(table.rows.get(row.number, {}).get("names", {})) for row in rows]
    entries = [read_row(row, some, document) for row, some in zip(rows, in_row, strict=True)]
    count = 0
    while count < len(names.abbreviations):
        count = len(names.abbreviations)
        for index, entry in enumerate(entries):
            if entry.unknown is None or not in_row[index].is_known(entry.unknown):
                continue
            again = read_row(rows[index], in_row[index], document)
            if again.read is None or again.read.is_consistent(in_row[index]):
                entries[index] = again
    spoiled = {entry.defines.spell(): entry for entry in entries if entry.defines and entry.clash}
    for entry in entries:
        spellings = {symbol.base.spell() for symbol in list_symbols(entry.chain)}
        for spelling in sorted(spellings & spoiled.keys()) if entry.unknown else ():
            number = spoiled[spelling].row.number
            entry.reason = (
                f"nothing says what {spelling} is: ({number}), which defines it, mixes units"
            )
    return entries


def _find_claim(
    entry_of_row: Mapping[str, Any], by_sentence: Mapping[str, Claimed], table: NameTable, row: Row
) -> Claimed | None:
    sentence = entry_of_row.get("claims")
    if sentence is None:
        return None
    if sentence not in by_sentence:
        from difflib import get_close_matches

        close = get_close_matches(sentence, by_sentence, 3)
        hint = f"; near it: {'; '.join(close)}" if close else ""
        raise OwnError(
            f"{table.file}: rows.{row.number}.claims = {sentence!r}: nothing here states it{hint}"
        )
    return by_sentence[sentence]


def list_quantities(stated: Stated, subject: Subject) -> dict[str, Quantity]:
    """Return the quantities of a mechanism or of formulas by name."""
    quantities = dict(stated.given)
    if isinstance(subject, MechanismSubject | ConfigurationSubject):
        quantities |= {q.name: q for q in sorted(subject.quantities, key=str)}
    symbols = set().union(*(e.residual.free_symbols for e in subject.claims().values()))
    quantities |= {s.name: s for s in sorted(symbols, key=str) if isinstance(s, Quantity)}
    return {name: quantity for name, quantity in quantities.items() if not _INTERNAL.search(name)}


def read_row(row: Row, names: StatedNames, document: TextDocument) -> ReadRow:
    """Read a row; what cannot be read for certain has its reason."""
    entry = ReadRow(row, names, reason=row.refused)
    if row.refused:
        return entry
    try:
        entry.row = row = replace(row, latex=expand_matrix_macros(row.latex, document.macros))
        entry.chain = read_formula(row.latex, document.macros)
        abbreviation = _own_name(entry.chain, names)
        if abbreviation is not None:
            entry.read = interpret_formula(
                replace(entry.chain, sides=entry.chain.sides[1:], relations=()), names
            )
            _define(abbreviation, entry, names)
        else:
            entry.read = interpret_formula(entry.chain, names)
            if set(entry.chain.relations) == {"~"}:
                entry.reason = "an approximation: no value could contradict it"
    except (FormulaError, OperandError) as error:
        entry.reason = str(error)
        entry.unknown = error.symbol if isinstance(error, UnknownNameError) else None
    except (TypeError, ValueError, ZeroDivisionError, RecursionError) as error:
        entry.reason = f"it cannot be evaluated: {type(error).__name__}: {error}"
    return entry


def _own_name(chain: RelationChain, names: StatedNames) -> Symbol | None:
    """Return the name that a row defines for itself: one without a meaning, before names that have
    one.
    """
    first = chain.sides[0]
    if not isinstance(first, Name) or chain.relations != ("=",) or names.is_known(first.symbol):
        return None
    if names.table.find(first.symbol.spell()) == "" or first.symbol.dots:
        return None
    right = [node.symbol for node in list_nodes(chain.sides[1]) if isinstance(node, Name)]
    return first.symbol if right and all(map(names.is_known, right)) else None


def _define(symbol: Symbol, entry: ReadRow, names: StatedNames) -> None:
    assert entry.read is not None
    (value,) = entry.read.sides
    assert value is not None
    if isinstance(value, Scalar) and value.mixed:
        assert entry.chain is not None
        entry.clash = _find_clash(entry.chain.sides[1], entry.row.latex, names)
        if not entry.clash:
            raise FormulaError("it defines a name by what mixes units")
    else:
        names.abbreviations[symbol.spell()] = value
    entry.read, entry.defines = None, symbol


def _find_clash(side: Node, latex: str, names: StatedNames) -> str:
    """Return in words which terms that are added have different units, empty if none are known to.

    Pure numbers do not count: they may be what a quantity with a unit was put for.
    """
    for total in list_nodes(side):
        if not isinstance(total, Sum):
            continue
        terms = [
            (latex[term.start : term.end].strip(), interpret_formula(_alone(term), names).sides[0])
            for _, term in total.terms
        ]
        with_units = [
            (text, value)
            for text, value in terms
            if isinstance(value, Scalar) and value.kind == "unit" and not value.mixed
        ]
        for (text, value), (other, second) in pairwise(with_units):
            if value.dimension != second.dimension:
                return f"{text} and {other}, which it adds, have different units"
    return ""


def _alone(term: Node) -> RelationChain:
    """Return a term as a formula without relations."""
    return RelationChain(term.start, term.end, (term,), ())


def _add_row(
    entry: ReadRow,
    claim: Claimed | None,
    printed: PrintedText,
    paper: Paper,
    claims: Mapping[Claimed, Equation],
) -> None:
    """Add the equations of a row to the paper."""
    number = entry.row.number
    if entry.reason or entry.read is None:
        stated = not entry.reason and not entry.clash
        claimed = Definition("an abbreviation of the text") if stated else UNCLAIMED
        paper.equation(number, sp.S.Zero, claimed)
        printed.places[number] = Place(entry, 0)
        return
    residuals = entry.read.residuals(entry.names)
    for index, (side, relation, left, right) in enumerate(residuals):
        name = number if len(residuals) == 1 else f"{number}.{index + 1}"
        if left.value == right.value and len(residuals) > 1 and left.dimension is None:
            continue
        printed.places[name] = Place(entry, index)
        if left.value == right.value:
            circular = Definition("both sides are the same by the meaning of their names")
            paper.equation(name, sp.S.Zero, circular if _is_circular(entry, side) else UNCLAIMED)
        elif relation == "=" and _gives_value(left, right, entry.names.stated):
            paper.equation(name, sp.S.Zero, Definition("a value that the text gives"))
        else:
            _add_equation(paper, name, relation, left, right, claim, claims)


def _gives_value(left: Scalar, right: Scalar, stated: Stated) -> bool:
    """Return whether two sides are a quantity of the table and a number: the table has other
    values.
    """
    sides = {sp.sympify(side.value) for side in (left, right)}
    return len(sides & set(stated.given.values())) == 1 and any(side.is_number for side in sides)


def _is_circular(entry: ReadRow, side: int) -> bool:
    """Return whether two equal sides say no more than the names file: one is a name, and nothing is
    computed.
    """
    assert entry.chain is not None
    if any(map(entry.names.is_computed, list_symbols(entry.chain))):
        return False
    pair = entry.chain.sides[side : side + 2]
    derived = any(isinstance(node, Derivative) for node in list_nodes(entry.chain))
    return not derived and any(_is_name(node) for node in pair)


def _is_name(node: Node) -> bool:
    """Return whether a side is a name, also with what it depends on, a number or a matrix of
    such.
    """
    if isinstance(node, Matrix):
        return all(_is_name(cell) for row in node.rows for cell in row)
    if isinstance(node, Product):
        first, *arguments = (factor for _, factor in node.factors)
        return isinstance(first, Name) and all(
            isinstance(argument, Bracket) for argument in arguments
        )
    return isinstance(node, Name | Number)


def _add_equation(
    paper: Paper,
    number: str,
    relation: str,
    left: Scalar,
    right: Scalar,
    claim: Claimed | None,
    claims: Mapping[Claimed, Equation],
) -> None:
    left_side, right_side = sp.sympify(left.value), sp.sympify(right.value)
    if relation != "=":
        kinds: dict[str, Relation] = {"<": "<", "<=": "<=", ">": ">", ">=": ">="}
        paper.inequality(number, left_side, kinds[relation], right_side, claim or UNCLAIMED)
        return
    if isinstance(left_side, Quantity) and left_side not in right_side.free_symbols:
        stated_claim = claim or (what(left_side) if what(left_side) in claims else None)
        paper.defines(number, left_side, right_side, stated_claim or UNCLAIMED)
        return
    paper.equation(number, left_side - right_side, claim or UNCLAIMED)


_INTERNAL = re.compile(r"_(given|near\d|step\d|case\d)$|^(law|pivot|states)_")
"""Names of quantities that solving needs and no text speaks of."""
MOST_CLAIMS = 4
"""Claims that an equation is compared with term by term."""


def _claim_what_fails(case: Case, paper: Paper) -> None:
    """Give an equation that does not hold the claim that it comes closest to, so that missing terms
    can be named.
    """
    points = tuple(case.points)
    for number, equation in paper.equations.items():
        if equation.claims != UNCLAIMED or equation.relation != "=":
            continue
        if list_unknown(equation.residual, points):
            continue
        if holds(equation.residual, points):
            continue
        claim = _closest_claim(case, equation)
        if claim is not None:
            paper.equations[number] = replace(equation, claims=claim, defines=None)


def _closest_claim(case: Case, printed: Equation) -> Claimed | None:
    """Return the claim whose derivation shares most terms with an equation, None if none shares
    half of them.
    """
    points = tuple(case.points)
    ranked = sorted(_shared_symbols(case, printed), key=lambda pair: -pair[0])[:MOST_CLAIMS]
    best: tuple[int, Claimed] | None = None
    for _, claim in ranked:
        derived = case.claims[claim]
        left_side, right_side = case.subject.common(printed.residual, derived.residual)
        if list_unknown(left_side - right_side, points):
            continue
        for sign in (1, -1):
            comparison = Comparison(left_side, sign * right_side, points, scales=True)
            left = comparison.struck()
            terms = len(sp.Add.make_args(sp.expand(right_side)))
            shared = terms - len(left.derived)
            if 2 * shared >= terms and (best is None or left.size < best[0]):
                best = left.size, claim
    return None if best is None else best[1]


def _shared_symbols(case: Case, printed: Equation) -> Iterator[tuple[float, Claimed]]:
    symbols = printed.residual.free_symbols
    for claim, derived in case.claims.items():
        if derived.relation == "=" and derived.defines is None:
            common = symbols & derived.residual.free_symbols
            if common:
                yield len(common) / len(symbols | derived.residual.free_symbols), claim


def format_skeleton(case: Case) -> str:
    """Return a names file for a text: every name with its meaning, empty for what nothing says, and
    where it stands.
    """
    source = case.source
    assert isinstance(source, PrintedText)
    names = source.names
    stands: dict[str, list[str]] = {}
    meanings: dict[str, str | None] = {}
    for entry in source.rows:
        for symbol in list_symbols(entry.chain):
            spelling = symbol.spell()
            rows = stands.setdefault(spelling, [])
            if entry.row.number not in rows:
                rows.append(entry.row.number)
            if spelling not in meanings:
                meanings[spelling] = _meaning(symbol, names)
    texts = {spelling: text for spelling, text in meanings.items() if text}
    lines = [
        f"# Names of {source.document.name}, for {names.stated.name}. A name without a meaning is "
        f"not judged.",
        "# A meaning is a quantity, an expression of quantities, or of frames and points: "
        "rate(x), rate(v, FRAME),",
        "# spin(FRAME), velocity(POINT), axis(FRAME, 1), component(VECTOR, 1), kinetic(), "
        "potential(),",
        "# rotation(FROM, TO), matrix(2, a, b, c, d) of 2 rows, row by row.",
        f"# Quantities: {', '.join(sorted(names.quantities))}.",
        *(
            [f"# Frames: {', '.join(names.frames)}. Points: {', '.join(names.places)}."]
            if names.frames
            else []
        ),
        "# [rows] may say of a row what it claims to be, or that it is left out:",
        "# '12' = { claims = \"...\" }, '13' = { skip = \"the reason\" }. Names that mean "
        "something else in a row:",
        "# '14' = { names = { 'M' = \"matrix(2, m_1, 0, 0, m_2)\" } }.",
        "",
        "[names]",
    ]
    defined = [spelling for spelling in meanings if spelling in names.abbreviations]
    lines[-1:-1] = (
        [f"# The text itself defines {', '.join(defined)}, and with that their rates.", ""]
        if defined
        else []
    )
    for spelling in (*texts, *(spelling for spelling, text in meanings.items() if text == "")):
        places = ", ".join(f"({number})" for number in stands[spelling][:6])
        more = f" and {len(stands[spelling]) - 6} more" if len(stands[spelling]) > 6 else ""
        quoted = (
            f"'{spelling}'" if "'" not in spelling else '"' + spelling.replace("\\", "\\\\") + '"'
        )
        lines.append(f'{quoted} = "{meanings[spelling]}"  # in {places}{more}')
    return "\n".join([*lines, ""])


def _meaning(symbol: Symbol, names: StatedNames) -> str | None:
    """Return what the names file says of a name: nothing where the text defines it, or what it is
    the rate of.
    """
    text = names.table.find(symbol.spell())
    if symbol.base.spell() in names.abbreviations and not text and names.guess(symbol) is None:
        return None
    if text is not None:
        return text
    if not names.is_known(symbol):
        return ""
    value: Value = names.look_up(symbol)
    return str(value.value) if isinstance(value, Scalar) else ""
