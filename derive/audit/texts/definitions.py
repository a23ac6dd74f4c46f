"""Definitions of a text, tested wherever the mechanism has the same quantity: points, their speeds,
energies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from ...evaluate import Point
from ...generated_folder import OwnError
from ...mechanics.mechanism import Mechanism
from ..judge import holds
from .corrections import find_repairs
from .documents import TextDocument
from .formula import FormulaError, Symbol
from .names import StatedNames
from .values import OperandError, Scalar

AXES = {"x": 1, "y": 2, "z": 3}
ENERGIES = {"T": "kinetic()", "K": "kinetic()", "V": "potential()", "U": "potential()"}
"""Meanings that names of energies have where a text defines them without saying more."""
COMPLETED = " after "
"""What the words of a repair contain that adds a term: of such, any definition is one change from
any other.
"""


@dataclass(frozen=True)
class TextDefinition:
    """A name that a row of a text defines, with the row's number and LaTeX."""

    symbol: Symbol
    number: str
    latex: str

    @property
    def spelling(self) -> str:
        """The name as it is spelled in a names file."""
        return self.symbol.spell()


CountHolding = Callable[[TextDefinition, StatedNames], int]
"""Gives the number of rows that speak of a name and hold under some meanings."""


def list_meanings(names: StatedNames) -> dict[str, Scalar]:
    """Return what the name of a scalar may mean of a mechanism, by its text in a names file, none
    for formulas.
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
    return meanings


def _describe_speed(place: str) -> str:
    """Return the text of the speed of a point."""
    squares = (f"component(velocity({place}), {axis})**2" for axis in AXES.values())
    return f"sqrt({' + '.join(squares)})"


def is_meaning(names: StatedNames, definition: TextDefinition, points: Sequence[Point]) -> bool:
    """Return whether the mechanism has a quantity that is what a text defines a name as."""
    value = names.abbreviations.get(definition.spelling)
    if not isinstance(value, Scalar):
        return False
    return any(_are_equal(value, meaning, points) for meaning in list_meanings(names).values())


def find_meant(
    names: StatedNames,
    definition: TextDefinition,
    document: TextDocument,
    points: Sequence[Point],
    draw: Callable[[int], list[Point]],
    vocabulary: Sequence[str],
    count_holding: CountHolding,
) -> str:
    """Return what a name must mean that a text defines wrongly, as the text of a names file; empty
    if it may be right.

    A definition is wrong if more rows that speak of the name hold once it means a quantity of the
    mechanism; or if the name says which quantity, and one change of the definition makes it that,
    unless axis or origin are another.
    """
    value = names.abbreviations.get(definition.spelling)
    if not isinstance(value, Scalar):
        return ""
    meanings = {
        text: meaning
        for text, meaning in list_meanings(names).items()
        if meaning.dimension == value.dimension
    }
    if any(_are_equal(value, meaning, points) for meaning in meanings.values()):
        return ""
    named = [text for text in _list_named(names, definition.symbol) if text in meanings]
    before = count_holding(definition, names)
    counts = {
        text: count_holding(definition, _with_meaning(names, definition, text)) for text in meanings
    }
    best = max(counts.values(), default=0)
    if best > before:
        chosen = [text for text, count in counts.items() if count == best]
        preferred = [text for text in chosen if text in named] or chosen
        return preferred[0] if len(preferred) == 1 else ""
    for text in named:
        if not _differ_by_choice(names, value, meanings[text], points) and _is_one_change_from(
            names, definition, text, document, points, draw, vocabulary
        ):
            return text
    return ""


def _with_meaning(names: StatedNames, definition: TextDefinition, text: str) -> StatedNames:
    return names.with_meanings({definition.spelling: text})


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
    residual = first.value - second.value
    if any(symbol not in point for symbol in residual.free_symbols for point in points):
        return False
    return residual == 0 or holds(residual, tuple(points))


def _differ_by_choice(
    names: StatedNames, value: Scalar, meaning: Scalar, points: Sequence[Point]
) -> bool:
    """Whether two quantities are one but for the direction of an axis, or for where it is counted
    from.
    """
    try:
        rates = [names.rate(some) for some in (value, meaning)]
    except (FormulaError, OperandError):
        return True
    first, second = rates
    if not (isinstance(first, Scalar) and isinstance(second, Scalar)):
        return True
    return any(_are_equal(first, sign, points) for sign in (second, -second))


def _is_one_change_from(
    names: StatedNames,
    definition: TextDefinition,
    text: str,
    document: TextDocument,
    points: Sequence[Point],
    draw: Callable[[int], list[Point]],
    vocabulary: Sequence[str],
) -> bool:
    meant = replace(_with_meaning(names, definition, text), abbreviations=dict(names.abbreviations))
    repair = find_repairs(definition.latex, 0, meant, points, document.macros, vocabulary, draw)
    return repair is not None and COMPLETED not in repair.text
