"""Faults in words: what was edited and what is left out, by its largest term; and which differences
are none.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import mpmath
import sympy as sp
from sympy import Expr

from ..equations import Equation
from ..evaluate import TOLERANCE, Point
from ..quantity import NONE, DimensionError, Quantity, dimension, of_unit
from .comparison import solve_for
from .edits import Edit
from .judge import FAULTS, Judgement
from .terms import evaluate_at, expand_sum, find_largest_size

ACTIONS = ("N", "N m")
"""Units of what one body does to another."""
NEGLECTED = 0.01
"""Share of the largest term over the cycle below which terms that are left out are neglected."""
ROUGH = 0.1
"""Share by which a number may be off that is printed as an approximate one."""
Grade = Literal["", "at fault", "neglected", "approximate"]


def grade_fault(judgement: Judgement, share: float | None, off: float | None) -> Grade:
    """Return what a difference of print and derivation amounts to, "" if there is none.

    ``share`` is what missing terms are together, of the largest term over the cycle; ``off`` by how
    much an approximate number differs.
    """
    if judgement.verdict not in FAULTS:
        return ""
    if off is not None and off < ROUGH:
        return "approximate"
    is_small = share is not None and share < NEGLECTED
    only_lacks = judgement.verdict == "incomplete" and not judgement.edits
    return "neglected" if only_lacks and is_small else "at fault"


def find_relative_error(
    printed: Equation, derived: Equation | None, points: Sequence[Point]
) -> float | None:
    """Return by which share what an equation gives differs from the derivation; None if the two are
    not proportional.
    """
    symbol = printed.defines
    if symbol is None or derived is None or derived.defines != symbol:
        return None
    sides = [solve_for(side.residual, symbol) for side in (printed, derived)]
    ratios = []
    for point in points:
        first, second = (evaluate_at(side, point) for side in sides)
        if first is None or not second:
            return None
        ratios.append(first / second)
    if any(abs(ratio - ratios[0]) > TOLERANCE * abs(ratio) for ratio in ratios):
        return None
    return float(abs(ratios[0] - 1))


def is_fragile(judgement: Judgement) -> bool:
    """Whether a correction puts one symbol for another whose name differs in a single character, a
    dot among them.

    So little a machine that reads a print may have taken for something else.
    """
    swaps = (edit.swaps[0] for edit in judgement.edits if len(edit.swaps) == 1)
    return any(isinstance(new, Quantity) and _one_apart(str(old), str(new)) for old, new in swaps)


def _one_apart(first: str, second: str) -> bool:
    """Whether two names are one character apart, put in, left out or exchanged."""
    short, long = sorted((first, second), key=len)
    if len(short) == len(long):
        return sum(a != b for a, b in zip(first, second, strict=True)) == 1
    return len(long) - len(short) == 1 and any(
        long[:i] + long[i + 1 :] == short for i in range(len(long))
    )


def list_reasons(
    judgement: Judgement,
    printed: Equation,
    actions: Mapping[sp.Symbol, str],
    reactions: Mapping[sp.Symbol, Expr] | None = None,
    cycle: Sequence[Point] = (),
) -> tuple[str, ...]:
    """List faults, in words that are equal for equal faults of two equations: edits, and terms left
    out.

    ``actions`` says what forces and moments are called, ``reactions`` what they are in other
    quantities. The largest missing term over the ``cycle`` names the omission.
    """
    if judgement.verdict not in FAULTS:
        return ()
    edits = _join_signs(judgement.edits)
    edits += [f"{name} does not vanish" for name in judgement.loose]
    unlike = (
        [f"{', '.join(map(str, judgement.unexplained))} is not derived"]
        if judgement.unexplained
        else []
    )
    missing = sorted(
        judgement.missing, key=lambda term: -(find_largest_size(term, cycle) or mpmath.mpf(0))
    )
    lacking = (
        _left_out(missing, printed.residual, actions, reactions or {}, cycle) if not unlike else []
    )
    corrected = [str(text) for text in next(iter(judgement.corrections), ())]
    return tuple(
        dict.fromkeys(
            [*edits, *unlike, *lacking] or corrected or [f"({printed.number}) does not hold"]
        )
    )


SIGN = "sign of "


def _join_signs(edits: Iterable[Edit]) -> list[str]:
    """Return edits in words; the same sign of like terms, which differ by the names in them, once."""
    by_shape: dict[str, list[str]] = {}
    for edit in edits:
        shape = words = _same_wherever(edit)
        for symbol in edit.result.free_symbols:
            if isinstance(symbol, Quantity):
                shape = re.sub(rf"\b{symbol}\b", symbol.unit, shape)
        by_shape.setdefault(shape if words.startswith(SIGN) else words, []).append(words)
    return [
        " and of ".join([some[0], *(words.removeprefix(SIGN) for words in some[1:])])
        for some in by_shape.values()
    ]


def _same_wherever(edit: Edit) -> str:
    """An edit without the place where it is made."""
    if len(edit.swaps) != 1:
        return str(edit.text)
    ((old, new),) = edit.swaps
    return f"{new} for {old}"


def _left_out(
    missing: Sequence[Expr],
    printed: Expr,
    actions: Mapping[sp.Symbol, str],
    reactions: Mapping[sp.Symbol, Expr],
    cycle: Sequence[Point],
) -> list[str]:
    """Actions that missing terms speak of, those that the print does not name before others; else
    what the first term is.

    Of actions of which a part is printed, what the rest consists of is named.
    """
    acting = {
        s for t in missing for s in t.free_symbols if isinstance(s, Quantity) and s.unit in ACTIONS
    }
    acting = acting - printed.free_symbols or acting
    if acting & reactions.keys() and any(isinstance(term, sp.Add) for term in missing):
        return [f"lacks {_describe_rest(missing, acting, actions, reactions, cycle)}"]
    meanings = (actions.get(s, str(s)).partition("; ")[0] for s in sorted(acting, key=str))
    named = [meaning.rpartition(", ")[0] or meaning for meaning in meanings]
    reasons_ = [f"lacks {name}" for name in dict.fromkeys(named)]
    return reasons_ or [f"lacks {describe_term(term)}" for term in missing[:1]]


KINDS = dict.fromkeys(("inertia", "Coriolis", "centrifugal", "gyroscopic"), "inertia")
KINDS["weight"] = "weight"
"""What several terms are together, by what each is."""


def _describe_rest(
    missing: Sequence[Expr],
    acting: Iterable[sp.Symbol],
    actions: Mapping[sp.Symbol, str],
    reactions: Mapping[sp.Symbol, Expr],
    cycle: Sequence[Point],
) -> str:
    """Return what actions without their printed parts consist of, and on which bodies they act."""
    rest = expand_sum(sp.Add(*missing).xreplace(dict(reactions)))
    sized = [term for term in rest if not cycle or find_largest_size(term, cycle)]
    kinds = sorted({KINDS.get(_classify(term)[0], str(term)) for term in sized})
    bodies = sorted(
        {actions.get(s, str(s)).partition(" on ")[2].partition(" at ")[0] for s in acting}
    )
    unit = "moment" if any(s.unit == "N m" for s in acting if isinstance(s, Quantity)) else "force"
    return f"{unit}s of {' and '.join(kinds)} of {' and '.join(bodies)}"


def describe_term(term: Expr) -> str:
    r"""Return a term of a balance in words, by its rates and the body that its mass is of; the term
    itself if it is none.

    >>> from derive import quantities
    >>> q = quantities("m | kg | mass of the rod\nw | rad/s | rate\nx | m | distance")
    >>> describe_term(q.m * q.w**2 * q.x)
    'centrifugal force of the rod'
    """
    kind, bodies = _classify(term)
    try:
        unit = {of_unit("N"): "force", of_unit("N m"): "moment"}.get(dimension(term) or NONE)
    except DimensionError:
        unit = None
    if not kind or not bodies or unit is None:
        return str(term)
    names = {"inertia": f"inertia {unit}", "weight": f"{unit} of weight"}
    return f"{names.get(kind, f'{kind} {unit}')} of {' and '.join(bodies)}"


RATE, ACCELERATIONS = of_unit("rad/s"), (of_unit("m/s2"), of_unit("rad/s2"))


def _classify(term: Expr) -> tuple[str, list[str]]:
    """Return what kind of term of a balance one is, "" if of none, and bodies whose mass it has."""
    symbols = [s for s in sorted(term.free_symbols, key=str) if isinstance(s, Quantity)]
    holders = [s for s in symbols if s.unit in ("kg", "kg m2")]
    bodies = list(dict.fromkeys(s.meaning.partition(" of ")[2].partition(",")[0] for s in holders))
    bodies = [name.removeprefix("inertia of ") for name in bodies]
    powers = {
        base: power
        for base, power in term.as_powers_dict().items()
        if base.free_symbols and _dimension(base) == RATE
    }
    if any(s.name == "g" for s in symbols):
        return "weight", bodies
    if sum(powers.values()) == 2 and len(powers) == 1:
        return ("gyroscopic" if holders and holders[0].unit == "kg m2" else "centrifugal"), bodies
    if len(powers) == 2:
        return ("gyroscopic" if holders and holders[0].unit == "kg m2" else "Coriolis"), bodies
    if holders and any(_dimension(s) in ACCELERATIONS for s in symbols):
        return "inertia", bodies
    return "", bodies


def _dimension(expr: Expr) -> object:
    try:
        return dimension(expr) or NONE
    except DimensionError:
        return None
